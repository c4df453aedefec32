//! `keepout-proofs`: proves, tests and explores what the trusted core promises, here and now.

mod explore;
mod faults;
mod prove;
mod soak;
mod write;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Proofs of Keepout's trusted core.
#[derive(Debug, Parser)]
#[command(
    name = "keepout-proofs",
    version,
    after_help = "Exit codes: 0 all holds · 1 something does not · 2 it could not be tried"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Prove all theorems with SMT solvers.
    Prove(prove::Prove),
    /// Explore the guard beside a model of the controller, in every world to the last state.
    Explore(explore::Explore),
    /// Compare predicates, queries and arcs with their definitions on random cases, for as long as one likes.
    Soak(soak::Soak),
    /// Seed the faults of the catalogue into copies of the tree; each must be noticed.
    Faults(faults::Faults),
    /// Run every engine and write the assurance table, `proofs/README.md`.
    Table(write::Table),
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Prove(prove) => prove.run(),
        Command::Explore(explore) => explore.run(),
        Command::Soak(soak) => soak.run(),
        Command::Faults(faults) => faults.run(),
        Command::Table(table) => table.run(),
    }
}

/// The exit code of what may have come to no end.
fn code(outcome: std::io::Result<bool>) -> ExitCode {
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

//! `keepout-proofs`: proves what the trusted core promises, here and now.

mod prove;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Proofs of Keepout's trusted core.
#[derive(Debug, Parser)]
#[command(name = "keepout-proofs", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Prove all theorems with SMT solvers.
    Prove(prove::Prove),
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Prove(prove) => prove.run(),
    }
}

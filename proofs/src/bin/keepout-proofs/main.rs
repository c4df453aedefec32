//! `keepout-proofs`: proves, tests and explores the properties of the trusted core.

mod explore;
mod faults;
mod model_check;
mod mutants;
mod prove;
mod soak;
mod trace;
mod write;

use std::ffi::OsStr;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use keepout_campaigns::{ShardOptions, ShardRecord};

/// Proofs of Keepout's trusted core.
#[derive(Debug, Parser)]
#[command(
    name = "keepout-proofs",
    version,
    after_help = "Exit codes: 0 everything holds · 1 something does not hold · 2 the check could not run"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Prove all theorems with SMT solvers.
    Prove(prove::Prove),
    /// Explore all states of the guard with a model of the controller, in every world.
    Explore(explore::Explore),
    /// Compare predicates, queries and arcs with their definitions on random cases.
    Soak(soak::Soak),
    /// Put faults into a copy of the trusted core, one at a time; each must be noticed.
    Faults(faults::SeededFaults),
    /// Give the harnesses to the bounded model checker CBMC: all inputs within stated bounds.
    ModelCheck(model_check::ModelCheck),
    /// Keep the outcomes of cargo-mutants, and write the page of mutants.
    Mutants(mutants::KeepMutants),
    /// Run all engines except the solvers, and write the assurance table, `proofs/README.md`.
    Table(write::Table),
    /// Write the pages of the safety trace, and list its gaps.
    Trace(trace::TracePages),
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Prove(prove) => prove.run(),
        Command::Explore(explore) => explore.run(),
        Command::Soak(soak) => soak.run(),
        Command::Faults(faults) => faults.run(),
        Command::ModelCheck(check) => check.run(),
        Command::Mutants(mutants) => mutants.run(),
        Command::Table(table) => table.run(),
        Command::Trace(trace) => trace.run(),
    }
}

/// The exit code of a check, or of its error.
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

/// Begins the results of a shard. `local` are arguments that belong to this machine.
fn begin(options: &ShardOptions, local: &[&OsStr]) -> std::io::Result<ShardRecord> {
    options.begin("keepout-proofs", String::new(), local).map_err(std::io::Error::other)
}

/// Writes the results of a shard. Returns whether every item holds.
fn finish(record: ShardRecord) -> std::io::Result<bool> {
    record.finish().map_err(std::io::Error::other)
}

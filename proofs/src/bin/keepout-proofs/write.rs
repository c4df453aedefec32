//! `table`: the assurance table.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Where the table's figures come from, and where it goes.
#[derive(Debug, clap::Args)]
pub struct Table {
    /// The results that `prove --results FILE` wrote; default: those that are kept in the repository.
    #[arg(long, value_name = "FILE")]
    theorems: Option<PathBuf>,
    /// The page to write; default: proofs/README.md.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Table {
    /// Runs all but the solvers, and writes the page. Says by the exit code whether everything holds.
    pub fn run(&self) -> ExitCode {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let page = self.output.clone().unwrap_or_else(|| here.join("README.md"));
        let theorems = self.theorems.clone().unwrap_or_else(|| here.join("results/theorems.tsv"));
        super::code(keepout_proofs::table::write(&page, &theorems))
    }
}

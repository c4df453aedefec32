//! `table`: writes the assurance table.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The input and the output of the table.
#[derive(Debug, clap::Args)]
pub struct Table {
    /// The results file of `prove --results FILE`; default: the one in the repository.
    #[arg(long, value_name = "FILE")]
    theorems: Option<PathBuf>,
    /// The page to write; default: proofs/README.md.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Table {
    /// Runs all engines except the solvers, and writes the page. The exit code is 0 if everything holds.
    pub fn run(&self) -> ExitCode {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let page = self.output.clone().unwrap_or_else(|| here.join("README.md"));
        let theorems = self.theorems.clone().unwrap_or_else(|| here.join("results/theorems.tsv"));
        super::code(keepout_proofs::table::write(&page, &theorems))
    }
}

//! `mutants`: faults in a copy of the trusted core.

use std::path::PathBuf;
use std::process::ExitCode;

use keepout_proofs::mutants;

/// Which faults to put in, and where the copy lies.
#[derive(Debug, clap::Args)]
pub struct Mutants {
    /// The folder of the copy, and of what is built of it; default: a folder for temporary files.
    folder: Option<PathBuf>,
    /// Only the one of this number.
    #[arg(long, value_name = "N")]
    only: Option<usize>,
    /// From this number on.
    #[arg(long, value_name = "N")]
    from: Option<usize>,
    /// Only those in the kernel.
    #[arg(long)]
    kernel: bool,
    /// Only those that were not noticed yet.
    #[arg(long)]
    left: bool,
}

impl Mutants {
    /// Runs them, prints a line for each, and keeps the results. Says by the exit code whether all in the list are settled.
    pub fn run(&self) -> ExitCode {
        super::code(self.try_run().and_then(|()| {
            let (list, results) = (mutants::list()?, mutants::results());
            let open: Vec<_> = list.iter().filter(|mutant| !mutant.is_settled(&results)).collect();
            open.iter().for_each(|mutant| println!("not noticed, or not run: {}", mutant.what));
            Ok(open.is_empty())
        }))
    }

    fn try_run(&self) -> std::io::Result<()> {
        let folder = self.folder.clone().unwrap_or_else(|| std::env::temp_dir().join("keepout-mutants"));
        let (list, known) = (mutants::list()?, mutants::results());
        mutants::run(&folder, |number| {
            let mutant = &list[number];
            self.only.is_none_or(|only| only == number)
                && self.from.is_none_or(|from| number >= from)
                && (!self.left || !mutant.is_settled(&known))
                && (!self.kernel || mutant.file.starts_with("kernel"))
        })
    }
}

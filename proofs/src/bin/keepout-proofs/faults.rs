//! `faults`: the seeded faults of the catalogue, each of which must be noticed.

use std::path::PathBuf;
use std::process::ExitCode;

use keepout_proofs::faults::run::Workshop;
use keepout_proofs::faults::{self, FaultEngine, results};

/// Which faults to seed, and where the copies lie.
#[derive(Debug, clap::Args)]
pub struct SeededFaults {
    /// The folder of the copies and their builds; default: a folder for temporary files.
    folder: Option<PathBuf>,
    /// Only the fault of this number, from 1 on.
    #[arg(long, value_name = "N")]
    only: Option<usize>,
    /// From this number on.
    #[arg(long, value_name = "N")]
    from: Option<usize>,
    /// Only faults that change this file, or a file in this folder.
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Only faults in the kernel.
    #[arg(long)]
    kernel: bool,
    /// Only faults that go into one copy: parts of the guard, under the worlds and the hostile simulation.
    #[arg(long)]
    switched: bool,
    /// Only faults that are not settled yet.
    #[arg(long)]
    left: bool,
    /// Minutes of hostile simulation for one fault.
    #[arg(long, default_value_t = 4.0)]
    minutes: f64,
}

impl SeededFaults {
    /// Runs them and prints a line for each. The exit code says whether all faults of the catalogue are settled.
    pub fn run(&self) -> ExitCode {
        super::code(self.try_run())
    }

    fn try_run(&self) -> std::io::Result<bool> {
        let folder = self.folder.clone().unwrap_or_else(|| std::env::temp_dir().join("keepout-faults"));
        let (catalogue, known) = (faults::catalogue()?, results::read());
        let workshop = Workshop { folder: &folder, minutes: self.minutes };
        workshop.run(&catalogue, |number, engine| {
            let fault = &catalogue[number - 1];
            let settled = results::row(&known, fault, engine).is_some_and(|row| row.fate.is_settled());
            engine != FaultEngine::Fuzz
                && self.only.is_none_or(|only| only == number)
                && self.from.is_none_or(|from| number >= from)
                && (!self.left || !settled)
                && self
                    .file
                    .as_ref()
                    .is_none_or(|place| fault.edits().any(|edit| edit.file.starts_with(place)))
                && (!self.kernel || fault.is_in_kernel())
                && (!self.switched || fault.is_switched() && engine.runs_switched())
        })?;
        let rows = results::read();
        let open: Vec<_> = catalogue.iter().filter(|fault| !results::is_settled(&rows, fault)).collect();
        open.iter().for_each(|fault| println!("not noticed, or not run: {}", fault.name));
        Ok(open.is_empty())
    }
}

//! The commands of the studies.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use keepout_drives::profile::ProfileError;
use keepout_planner::plan::PlanError;
use keepout_planner::plan_file::{self, PlanFileError};
use thiserror::Error;

use crate::franco_horikawa::command::{CalibrateArguments, ExperimentArguments, experiment, find_delays};
use crate::franco_horikawa::scenario::StudyError;
use crate::koren_lo::command::{CompareArguments, compare, table_3, write_page};

/// The papers that Keepout rests on, reproduced and compared with it.
#[derive(Debug, Parser)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Compare controllers over paths and disturbances: a table, and pictures of what they leave.
    Compare(CompareArguments),
    /// Print the grades of Koren & Lo's Table 3 beside ours.
    Table3,
    /// Write the page that reproduces Koren & Lo, with its pictures.
    KorenLo {
        /// The folder that `koren-lo.md` and its pictures go to.
        #[arg(short, long, default_value = "docs/research")]
        output: PathBuf,
    },
    /// Franco & Horikawa's experiment with the paper's own controller, and with Keepout in its place.
    FrancoHorikawa(ExperimentArguments),
    /// Find the free figures of that study's delay model on half of the paper's Table 2.
    Calibrate(CalibrateArguments),
}

/// Why a command failed.
#[derive(Debug, Error)]
pub enum CommandError {
    /// A profile of feed drives, or scenarios, are refused.
    #[error(transparent)]
    Drives(#[from] ProfileError),
    /// A study can not be run.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A plan file can not be read.
    #[error(transparent)]
    PlanFile(#[from] PlanFileError),
    /// A plan file does not hold what it claims.
    #[error("not certified: {0}")]
    NotCertified(#[from] PlanError),
    /// An argument is out of range.
    #[error("{0}")]
    Argument(String),
    /// A file can not be written.
    #[error("can not write {}: {source}. Nothing was changed.", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// [`CommandError`] saying why it failed.
    pub fn execute(self) -> Result<ExitCode, CommandError> {
        match self.command {
            Command::Compare(arguments) => compare(&arguments),
            Command::Table3 => table_3(),
            Command::KorenLo { output } => write_page(&output),
            Command::FrancoHorikawa(arguments) => experiment(&arguments),
            Command::Calibrate(arguments) => find_delays(&arguments),
        }
    }
}

/// A progress bar, quiet where the output is no terminal.
pub(crate) fn bar() -> ProgressBar {
    let bar = ProgressBar::new(1);
    if let Ok(style) = ProgressStyle::with_template("{msg:32} {bar:30} {pos}/{len} {elapsed}") {
        bar.set_style(style);
    }
    bar
}

pub(crate) fn make_folder(folder: &Path) -> Result<(), CommandError> {
    std::fs::create_dir_all(folder)
        .map_err(|source| CommandError::Write { path: folder.to_path_buf(), source })
}

/// Writes a file whole or not at all.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), CommandError> {
    plan_file::write_whole(path, bytes)
        .map_err(|source| CommandError::Write { path: path.to_path_buf(), source })
}

//! The commands of the studies.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use keepout_drives::profile::DriveProfileError;
use keepout_planner::file::{FileError, OUTPUT};
use keepout_planner::plan::PlanError;
use keepout_planner::plan_file::PlanFileError;
use thiserror::Error;

use crate::franco_horikawa::command::{CalibrateArguments, ExperimentArguments, experiment, find_delays};
use crate::franco_horikawa::scenario::StudyError;
use crate::koren_lo::command::{CompareArguments, compare, table_3, write_page};

/// Reproduce the papers behind Keepout, and compare them with it.
#[derive(Debug, Parser)]
pub struct StudyArguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Compare controllers over paths and disturbances: a table, and pictures of the contour errors.
    Compare(CompareArguments),
    /// Print the grades of Koren & Lo's Table 3, and ours.
    Table3,
    /// Write the page that reproduces Koren & Lo, with its pictures.
    KorenLo {
        /// Folder for `koren-lo.md` and its pictures.
        #[arg(short, long, default_value = "docs/research")]
        output: PathBuf,
    },
    /// Tune every controller alike, and write the page that compares them.
    Tuned {
        /// Folder for `tuned-controllers.md`.
        #[arg(short, long, default_value = "docs/research")]
        output: PathBuf,
    },
    /// Repeat Franco & Horikawa's experiment with the paper's controller and with Keepout.
    FrancoHorikawa(ExperimentArguments),
    /// Fit the unknown delays of the paper's controller to half of the paper's Table 2.
    Calibrate(CalibrateArguments),
}

/// Reasons for which a command fails.
#[derive(Debug, Error)]
pub enum CommandError {
    /// A profile of feed drives or a scenario is invalid.
    #[error(transparent)]
    Drives(#[from] DriveProfileError),
    /// A study can not run.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A plan file can not be read.
    #[error(transparent)]
    PlanFile(#[from] PlanFileError),
    /// The certification of a plan failed.
    #[error("not certified: {0}")]
    NotCertified(#[from] PlanError),
    /// An argument is out of range.
    #[error("{0}")]
    Argument(String),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
}

impl StudyArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// [`CommandError`] with the reason of the failure.
    pub fn execute(self) -> Result<ExitCode, CommandError> {
        match self.command {
            Command::Compare(arguments) => compare(&arguments),
            Command::Table3 => table_3(),
            Command::KorenLo { output } => write_page(&output),
            Command::Tuned { output } => tuned(&output),
            Command::FrancoHorikawa(arguments) => experiment(&arguments),
            Command::Calibrate(arguments) => find_delays(&arguments),
        }
    }
}

/// Writes the page of the tuned controllers.
fn tuned(folder: &Path) -> Result<ExitCode, CommandError> {
    let bar = bar();
    let text = crate::tuned::page::page(&|done, all| {
        bar.set_length(all);
        bar.set_position(done);
    })?;
    bar.finish_and_clear();
    let path = folder.join("tuned-controllers.md");
    write(&path, text.as_bytes())?;
    println!("written      {}", path.display());
    Ok(ExitCode::SUCCESS)
}

/// A progress bar. It shows nothing if the output is not a terminal.
pub(crate) fn bar() -> ProgressBar {
    let bar = ProgressBar::new(1);
    if let Ok(style) = ProgressStyle::with_template("{msg:32} {bar:30} {pos}/{len} {elapsed}") {
        bar.set_style(style);
    }
    bar
}

pub(crate) fn make_folder(folder: &Path) -> Result<(), CommandError> {
    Ok(std::fs::create_dir_all(folder).map_err(OUTPUT.write_error(folder))?)
}

/// Writes a file atomically: completely or not at all.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), CommandError> {
    Ok(OUTPUT.write(path, bytes)?)
}

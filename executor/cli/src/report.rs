//! The command `report`: makes the page of a run from its log.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use keepout_executor::session::page_of_log;

use super::plan::write;
use super::replay::Played;
use super::{CertifyTime, CliError};

#[derive(Debug, Args)]
pub struct ReportArguments {
    /// The log of a run.
    log: PathBuf,
    /// The plan of the run. Without it, the program searches the log's folder for a *.plan file with the
    /// log's hash.
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    #[command(flatten)]
    time: CertifyTime,
    /// Output file of the page.
    #[arg(short, long, value_name = "FILE.html")]
    output: PathBuf,
}

pub fn report(arguments: &ReportArguments) -> Result<ExitCode, CliError> {
    let played =
        Played::of(&arguments.log, arguments.plan.as_deref(), Some(&arguments.output), arguments.time)?;
    let file = arguments.log.file_name().unwrap_or_default().to_string_lossy();
    let Played { header, replay, lines, torn, checksum } = &played;
    let page = page_of_log(
        header,
        replay,
        &format!("{file}, {lines} lines, {torn} bytes of an incomplete line"),
        *checksum,
    );
    write(&arguments.output, page.as_bytes())?;
    println!("{:<36} {}", "report", arguments.output.display());
    Ok(ExitCode::SUCCESS)
}

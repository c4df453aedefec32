//! The command `report`: makes the page of a run from its log.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use keepout_executor::session::page_of_log;
use keepout_executor::supervisor::PreparedPlan;

use super::job::JobFolder;
use super::plan::{check_ending, write};
use super::replay::{Played, find_plan_in, open};
use super::{CertifyTime, CliError};

#[derive(Debug, Args)]
pub struct ReportArguments {
    /// The log of a run, or the folder of a job: its last log.
    log: PathBuf,
    /// The plan of the run. Without it, the program searches the log's folder for a *.plan file with the
    /// log's hash.
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    #[command(flatten)]
    time: CertifyTime,
    /// Output file of the page. A job has its own place.
    #[arg(short, long, value_name = "FILE.html")]
    output: Option<PathBuf>,
}

pub fn report(arguments: &ReportArguments) -> Result<ExitCode, CliError> {
    if let Some(job) = JobFolder::at(&arguments.log)? {
        return of_job(&job, arguments.time);
    }
    let output = arguments
        .output
        .as_ref()
        .ok_or_else(|| CliError::Argument("give the output file with -o, or the folder of a job".into()))?;
    make(&arguments.log, arguments.plan.as_deref(), output, &[], arguments.time)
}

/// Makes the page of a job's last run in its folder.
pub fn of_job(job: &JobFolder, time: CertifyTime) -> Result<ExitCode, CliError> {
    let log = job.last_log()?;
    let plan = find_plan_in(&log, &job.folder)?;
    make(&log, Some(&plan), &job.path("report.html"), &job.file.title.rows(), time)
}

/// Makes the page of a run that has just ended.
pub fn of_log(
    log: &Path,
    work: PreparedPlan,
    output: &Path,
    title: &[(String, String)],
) -> Result<(), CliError> {
    write_page(log, &Played::with(log, &mut open(log)?, work)?, output, title)
}

fn make(
    log: &Path,
    plan: Option<&Path>,
    output: &Path,
    title: &[(String, String)],
    time: CertifyTime,
) -> Result<ExitCode, CliError> {
    let played = Played::of(log, plan, Some(output), time)?;
    if played.header.dry_run {
        let reason = format!(
            "{} is the log of a dry run, which cut no part: there is nothing to report",
            log.display()
        );
        return Err(CliError::Argument(reason));
    }
    check_ending(output, "html")?;
    write_page(log, &played, output, title)?;
    Ok(ExitCode::SUCCESS)
}

fn write_page(
    log: &Path,
    played: &Played,
    output: &Path,
    title: &[(String, String)],
) -> Result<(), CliError> {
    let file = log.file_name().unwrap_or_default().to_string_lossy();
    let Played { header, replay, lines, torn, checksum } = played;
    let file = format!("{file}, {lines} lines, {torn} bytes of an incomplete line");
    let page = page_of_log(header, replay, title, &file, *checksum);
    write(output, page.as_bytes())?;
    println!("{:<36} {}", "report", output.display());
    Ok(())
}

//! The commands `franco-horikawa` and `calibrate`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use indicatif::ProgressBar;
use keepout_planner::report::table::markdown;

use super::calibration::calibrate;
use super::check_picture;
use super::page::{FOLDER, page};
use super::picture::{chart, passes, paths};
use super::results::Results;
use super::scenario::{Scenarios, StudyError};
use super::tables::paper_table;
use crate::command::{CommandError, bar, make_folder, write};

/// Arguments of `franco-horikawa`.
#[derive(Debug, Args)]
pub struct ExperimentArguments {
    /// Attempts per row.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    attempts: u64,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the page franco-horikawa.md. Its pictures and results go to the subfolder franco-horikawa.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// Attempts per row for each model of the coarse search. The fine search uses eight times as many, the
    /// final rating forty times as many.
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    attempts: u64,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn shown(bar: &ProgressBar, done: u64, all: u64) {
    bar.set_length(all);
    bar.set_position(done);
}

/// Runs the experiment.
///
/// # Errors
/// [`CommandError`] if an attempt can not run, or a file can not be written.
pub fn experiment(arguments: &ExperimentArguments) -> Result<ExitCode, CommandError> {
    let scenarios = Scenarios::built_in()?;
    let bar = bar();
    let results = Results::of(&scenarios, (arguments.attempts, arguments.seed), &|what, done, all| {
        bar.set_message(what.to_string());
        shown(&bar, done, all);
    })?;
    bar.finish_and_clear();
    println!("{}\n{}", markdown(&paper_table(&results.paper)), markdown(&results.ours_by_speed()));
    if let Some(folder) = &arguments.output {
        save(folder, &scenarios, &results)?;
    }
    let ours = results.ours_together();
    let gouges = ours.attempts - ours.successes;
    println!("{} attempts with Keepout, {gouges} gouges", ours.attempts);
    Ok(if gouges == 0 { ExitCode::SUCCESS } else { ExitCode::from(8) })
}

/// Writes the page, pictures and results. Each file is written completely or not at all.
fn save(folder: &Path, scenarios: &Scenarios, results: &Results) -> Result<(), CommandError> {
    let beside = folder.join(FOLDER);
    make_folder(&beside)?;
    let put = |name: &str, text: &str| write(&beside.join(name), text.as_bytes());
    for (name, svg) in paths(scenarios, results.seed)? {
        put(&name, &svg)?;
    }
    for (name, svg) in passes(scenarios, results.seed)? {
        put(&name, &svg)?;
    }
    put("checks.svg", &check_picture::svg())?;
    put("success.svg", &chart(results))?;
    put("results.json", &serde_json::to_string_pretty(results).map_err(StudyError::from)?)?;
    let path = folder.join(format!("{FOLDER}.md"));
    write(&path, page(scenarios, results).as_bytes())?;
    println!("written      {}", path.display());
    Ok(())
}

/// Fits the free values of the delay model, and prints the best models.
///
/// # Errors
/// [`CommandError`] if an attempt can not run.
pub fn find_delays(arguments: &CalibrateArguments) -> Result<ExitCode, CommandError> {
    let scenarios = Scenarios::built_in()?;
    let bar = bar();
    bar.set_message("delay model");
    let fits =
        calibrate(&scenarios, (arguments.attempts, arguments.seed), &|done, all| shown(&bar, done, all))?;
    bar.finish_and_clear();
    println!("{:>7}  unit mm  ahead  computation s  inertia s  segments", "misfit");
    for fit in &fits {
        let delays = &fit.delays;
        println!(
            "{:>7.1}  {:>7}  {:>5}  {:>13}  {:>9}  {:?}",
            fit.misfit, delays.unit_mm, delays.ahead, delays.compute_s, delays.inertia_s, delays.classified
        );
    }
    Ok(ExitCode::SUCCESS)
}

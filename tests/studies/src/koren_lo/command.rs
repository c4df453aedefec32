//! The commands `compare`, `table3` and `koren-lo`. They compare controllers of feed drives.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use keepout_drives::controllers::kind::Kind;
use keepout_drives::profile::DriveProfile;
use keepout_drives::reference::Ramp;
use keepout_planner::file::FileKind;
use keepout_planner::plan_file;

use super::comparison::{Comparison, ModelError};
use super::finishing::{self, ContourPath};
use super::scenario::{DriveScenario, FrictionKind, PathShape};
use super::{grades, page, picture};
use crate::command::{CommandError, bar, make_folder, write};

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Drives: a built-in profile (koren-lo-table-1, koren-lo-table-2, nsk-modules, simulated, ...) or a TOML
    /// file. Default: the machine of each scenario.
    #[arg(long, value_name = "PROFILE")]
    machine: Option<String>,
    /// Scenario: the name of a built-in one, or a TOML file with scenarios. May be repeated. Default: all
    /// built-in scenarios.
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Vec<String>,
    /// Follow the finishing toolpath of this plan instead. Each loop is a row.
    #[arg(long, value_name = "PLAN", conflicts_with = "scenario")]
    plan: Option<PathBuf>,
    /// Feed for the passes of the plan without their own feed, mm/min.
    #[arg(long, value_name = "MM_MIN", default_value_t = 900.0, requires = "plan")]
    feed: f64,
    /// Time to reach the feed at the start, and to stop at the end, s (raised cosine).
    #[arg(long, value_name = "S", default_value_t = 0.0, requires = "plan")]
    ramp_s: f64,
    /// Controller to run. May be repeated. Default: all controllers.
    #[arg(long, value_name = "NAME", value_parser = kind)]
    controller: Vec<Kind>,
    /// Error of the controllers' models, in per cent: gains +, − and time constants −, + on X, Y.
    #[arg(long, default_value_t = 0.0, value_name = "PERCENT")]
    model_error: f64,
    /// Folder for the table (Markdown, CSV) and the pictures.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

fn kind(text: &str) -> Result<Kind, String> {
    Kind::named(text).ok_or_else(|| {
        let names: Vec<_> = Kind::ALL.iter().map(|kind| kind.names().0).collect();
        format!("unknown controller. Choose one of: {}", names.join(", "))
    })
}

static SCENARIO: FileKind = FileKind::new("scenario");

/// The requested scenarios.
fn scenarios(names: &[String]) -> Result<Vec<DriveScenario>, CommandError> {
    let built_in = DriveScenario::built_in()?;
    if names.is_empty() {
        return Ok(built_in);
    }
    let mut found = Vec::new();
    for name in names {
        if let Some(scenario) = built_in.iter().find(|scenario| scenario.name == *name) {
            found.push(scenario.clone());
            continue;
        }
        let text = SCENARIO.read_text(Path::new(name)).map_err(|error| {
            let known: Vec<_> = built_in.iter().map(|scenario| scenario.name.as_str()).collect();
            CommandError::Argument(format!(
                "{name} is neither a scenario ({}) nor a file: {error}",
                known.join(", ")
            ))
        })?;
        found.extend(DriveScenario::parse(name, &text)?);
    }
    Ok(found)
}

/// The loops of a plan as scenarios, with sticking friction and the cutting force.
fn loops_of(plan: &Path, arguments: &CompareArguments) -> Result<Vec<DriveScenario>, CommandError> {
    if !(0.0..=60.0).contains(&arguments.ramp_s) {
        return Err(CommandError::Argument(format!(
            "--ramp-s {} must be between 0 and 60 s",
            arguments.ramp_s
        )));
    }
    let loops = finishing::loops(&plan_file::load(plan)?.certify()?.plan);
    let ramp = if arguments.ramp_s > 0.0 { Ramp::RaisedCosine(arguments.ramp_s) } else { Ramp::None };
    let scenario = |each: ContourPath| DriveScenario {
        name: each.name,
        title: "finishing toolpath".into(),
        figure: None,
        machine: "simulated".into(),
        path: PathShape::Given(each.pieces),
        feed_m_min: each.feed_mm_min.map_or(arguments.feed, f64::from) / 1000.0,
        ramp,
        friction: FrictionKind::Stick,
        cutting: true,
        limit_bits: None,
    };
    Ok(loops.into_iter().map(scenario).collect())
}

/// Compares controllers.
///
/// # Errors
/// [`CommandError`] if an argument is invalid, or a file can not be written.
pub fn compare(arguments: &CompareArguments) -> Result<ExitCode, CommandError> {
    if !(0.0..=50.0).contains(&arguments.model_error) {
        let reason = format!("--model-error {} must be between 0 and 50 per cent", arguments.model_error);
        return Err(CommandError::Argument(reason));
    }
    let scenarios = match &arguments.plan {
        Some(plan) => loops_of(plan, arguments)?,
        None => scenarios(&arguments.scenario)?,
    };
    let machine = arguments.machine.as_deref().map(DriveProfile::load).transpose()?;
    let kinds =
        if arguments.controller.is_empty() { Kind::ALL.to_vec() } else { arguments.controller.clone() };
    let error = ModelError::crossed(arguments.model_error / 100.0);
    let bar = bar();
    let found = Comparison::run(&scenarios, machine.as_ref(), &kinds, error, &mut show(&bar))?;
    bar.finish_and_clear();
    let table = format!("{}\n{}", found.legend(), found.markdown());
    print!("{table}");
    let Some(folder) = &arguments.output else { return Ok(ExitCode::SUCCESS) };
    make_folder(folder)?;
    write(&folder.join("compare.md"), table.as_bytes())?;
    write(&folder.join("compare.csv"), found.csv().as_bytes())?;
    for row in &found.rows {
        write(&folder.join(format!("{}.svg", file_name(&row.scenario.name))), picture::svg(row).as_bytes())?;
    }
    println!("written      {}", folder.display());
    Ok(ExitCode::SUCCESS)
}

/// The name of a scenario as a file name: other characters than letters, digits, `-` and `_` become `-`.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '-' }).collect()
}

/// Prints the grades of Table 3 and ours.
///
/// # Errors
/// [`CommandError`] if a built-in profile is invalid.
pub fn table_3() -> Result<ExitCode, CommandError> {
    print!("{}", grades::markdown(&grades::cells()?));
    Ok(ExitCode::SUCCESS)
}

fn show(bar: &indicatif::ProgressBar) -> impl FnMut(usize, usize) {
    |done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    }
}

/// Writes the page and its pictures.
///
/// # Errors
/// [`CommandError`] if a file can not be written.
pub fn write_page(folder: &Path) -> Result<ExitCode, CommandError> {
    let bar = bar();
    let page = page::page(&mut show(&bar))?;
    bar.finish_and_clear();
    let pictures = folder.join("koren-lo");
    make_folder(&pictures)?;
    for (name, svg) in &page.pictures {
        write(&pictures.join(name), svg.as_bytes())?;
    }
    let path = folder.join("koren-lo.md");
    write(&path, page.text.as_bytes())?;
    println!("written      {}", path.display());
    Ok(ExitCode::SUCCESS)
}

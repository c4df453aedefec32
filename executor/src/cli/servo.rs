//! `servo`: feed drives and their controllers, compared, and the contour-error term of a machine.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use keepout_executor::servo::budget::{Budget, Question, budget};
use keepout_executor::servo::comparison::{Comparison, ModelError, figure};
use keepout_executor::servo::controllers::kind::Kind;
use keepout_executor::servo::finishing::{self, ContourPath};
use keepout_executor::servo::profile::DriveProfile;
use keepout_executor::servo::reference::Ramp;
use keepout_executor::servo::scenario::{FrictionKind, Scenario, Shape};
use keepout_executor::servo::{grades, page, picture};
use keepout_planner::machine::MachineProfile;
use keepout_planner::text_file;

use super::plan::{given, load, refuse_same, write};
use super::{CertifyTime, CliError};

/// What is asked of the drives.
#[derive(Debug, Subcommand)]
pub enum ServoCommand {
    /// Compare controllers over paths and disturbances: a table, and pictures of what they leave.
    Compare(CompareArguments),
    /// Print the grades of Koren & Lo's Table 3 beside ours.
    Table3,
    /// Print the contour-error term of the margin for drives at a feed: the worst over what may be wrong with their model.
    Budget(BudgetArguments),
    /// Write the page that reproduces the paper, with its pictures.
    Page {
        /// The folder that `koren-lo.md` and its pictures go to.
        #[arg(short, long, default_value = "docs")]
        output: PathBuf,
    },
}

#[derive(Debug, Args)]
pub struct CompareArguments {
    /// The drives: a built-in profile (koren-lo-table-1, koren-lo-table-2, nsk-modules, simulated, ...) or a TOML file. Without it, each
    /// scenario's own.
    #[arg(long, value_name = "PROFILE")]
    machine: Option<String>,
    /// Scenarios to take: names of built-in ones, or a TOML file of them. All without it.
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Vec<String>,
    /// Follow the finishing path of this plan instead, each loop a row.
    #[arg(long, value_name = "PLAN", conflicts_with = "scenario")]
    plan: Option<PathBuf>,
    #[command(flatten)]
    time: CertifyTime,
    /// The feed along it where a pass has none of its own, mm/min.
    #[arg(long, value_name = "MM_MIN", default_value_t = 900.0, requires = "plan")]
    feed: f64,
    /// Reach that feed, and leave it at the end, within so many seconds (raised cosine).
    #[arg(long, value_name = "S", default_value_t = 0.0, requires = "plan")]
    ramp_s: f64,
    /// Controllers to take. All without it.
    #[arg(long, value_name = "NAME", value_parser = kind)]
    controller: Vec<Kind>,
    /// How far the controllers' models are off, in per cent: gains +, − and time constants −, + on X, Y.
    #[arg(long, default_value_t = 0.0, value_name = "PERCENT")]
    model_error: f64,
    /// Where the table (Markdown, CSV) and the pictures go.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct BudgetArguments {
    /// The drives: a built-in profile or a TOML file.
    profile: String,
    /// Feed along the contour, mm/min.
    #[arg(long, value_name = "MM_MIN")]
    feed: f64,
    /// Fastest speed by hand, mm/min. Only for profiles with an interpolator; its top speed without it.
    #[arg(long, value_name = "MM_MIN")]
    by_hand: Option<f64>,
    /// The controller.
    #[arg(long, default_value = "contouring", value_name = "NAME", value_parser = kind)]
    controller: Kind,
    /// A machine profile of `plan` to write anew with this term; the simulated machine's without it.
    #[arg(long, value_name = "FILE", requires = "output")]
    machine_profile: Option<PathBuf>,
    /// Where the machine profile goes.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

fn kind(text: &str) -> Result<Kind, String> {
    Kind::named(text).ok_or_else(|| {
        let names: Vec<_> = Kind::ALL.iter().map(|kind| kind.names().0).collect();
        format!("there is no such controller; there are: {}", names.join(", "))
    })
}

pub fn servo(command: &ServoCommand) -> Result<ExitCode, CliError> {
    match command {
        ServoCommand::Compare(arguments) => compare(arguments),
        ServoCommand::Table3 => {
            print!("{}", grades::markdown(&grades::cells()?));
            Ok(ExitCode::SUCCESS)
        }
        ServoCommand::Budget(arguments) => work_out(arguments),
        ServoCommand::Page { output } => write_page(output),
    }
}

/// A bar that is quiet where the output is no terminal.
fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed}");
    let bar = ProgressBar::new(0);
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

fn show(bar: &ProgressBar) -> impl FnMut(usize, usize) {
    |done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    }
}

/// The scenarios asked for.
fn scenarios(names: &[String]) -> Result<Vec<Scenario>, CliError> {
    let built_in = Scenario::built_in()?;
    if names.is_empty() {
        return Ok(built_in);
    }
    let mut found = Vec::new();
    for name in names {
        if let Some(scenario) = built_in.iter().find(|scenario| scenario.name == *name) {
            found.push(scenario.clone());
            continue;
        }
        let text = text_file::read(Path::new(name)).map_err(|error| {
            let known: Vec<_> = built_in.iter().map(|scenario| scenario.name.as_str()).collect();
            CliError::Argument(format!(
                "{name} is neither a scenario ({}) nor a file: {error}",
                known.join(", ")
            ))
        })?;
        found.extend(Scenario::parse(name, &text)?);
    }
    Ok(found)
}

/// The loops of a plan as scenarios, with friction that sticks and the force of the cut.
fn loops_of(plan: &Path, arguments: &CompareArguments) -> Result<Vec<Scenario>, CliError> {
    if !(0.0..=60.0).contains(&arguments.ramp_s) {
        return Err(CliError::Argument(format!("--ramp-s {} must be between 0 and 60 s", arguments.ramp_s)));
    }
    let loops = finishing::loops(&load(plan, arguments.time)?.plan);
    let ramp = if arguments.ramp_s > 0.0 { Ramp::RaisedCosine(arguments.ramp_s) } else { Ramp::None };
    let scenario = |each: ContourPath| Scenario {
        name: each.name,
        title: "finishing path".into(),
        figure: None,
        machine: "simulated".into(),
        path: Shape::Given(each.pieces),
        feed_m_min: each.feed_mm_min.map_or(arguments.feed, f64::from) / 1000.0,
        ramp,
        friction: FrictionKind::Stick,
        cutting: true,
        limit_bits: None,
    };
    Ok(loops.into_iter().map(scenario).collect())
}

fn compare(arguments: &CompareArguments) -> Result<ExitCode, CliError> {
    if !(0.0..=50.0).contains(&arguments.model_error) {
        let reason = format!("--model-error {} must be between 0 and 50 per cent", arguments.model_error);
        return Err(CliError::Argument(reason));
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

/// A scenario's name without what a file's name can not have.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '-' }).collect()
}

pub(super) fn make_folder(folder: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(folder).map_err(|source| CliError::Write { path: folder.to_path_buf(), source })
}

fn work_out(arguments: &BudgetArguments) -> Result<ExitCode, CliError> {
    refuse_same(&[Path::new(&arguments.profile)], &given(&[arguments.output.as_ref()]))?;
    let profile = DriveProfile::load(&arguments.profile)?;
    let speed = |name: &str, mm_min: f64| {
        let checked = (1.0..=600_000.0).contains(&mm_min).then_some(mm_min / 60.0);
        checked
            .ok_or_else(|| CliError::Argument(format!("{name} {mm_min} must be between 1 and 600000 mm/min")))
    };
    let top = profile.interpolator.map(|interpolator| interpolator.max_rate_mm_s);
    let by_hand_mm_s = match (arguments.by_hand, top) {
        (Some(_), None) => {
            let reason =
                "--by-hand needs a profile with an [interpolator]: at constant feed there is no way to steer";
            return Err(CliError::Argument(reason.into()));
        }
        (Some(mm_min), Some(_)) => Some(speed("--by-hand", mm_min)?),
        (None, top) => top,
    };
    let question =
        Question { kind: arguments.controller, feed_mm_s: speed("--feed", arguments.feed)?, by_hand_mm_s };
    suits(&profile, &question, arguments)?;
    let bar = bar();
    let found = budget(&profile, &question, &mut show(&bar));
    bar.finish_and_clear();
    let Some(found) = found else {
        let reason = format!("{} with {}: no budget, it diverges", profile.name, question.kind.names().1);
        return Err(CliError::Argument(reason));
    };
    print!("{}", summary(&found));
    if let Some(output) = &arguments.output {
        let machine = machine_of(arguments)?;
        let machine = MachineProfile {
            contour_error_mm: found.term_mm,
            contour_error_source: Some(found.source),
            ..machine
        };
        if arguments.machine_profile.is_none() {
            eprintln!(
                "note: the other figures are of the {}: give those of your machine with --machine-profile",
                machine.name
            );
        }
        if by_hand_mm_s.is_none() {
            eprintln!(
                "note: the drives' profile has no [interpolator]: the term is of paths at constant feed, and not of corners, stops and \
                 steering by hand"
            );
        }
        write(output, machine.checked()?.to_toml().as_bytes())?;
        println!("written      {}", output.display());
    }
    Ok(ExitCode::SUCCESS)
}

fn machine_of(arguments: &BudgetArguments) -> Result<MachineProfile, CliError> {
    Ok(match &arguments.machine_profile {
        Some(path) => MachineProfile::load(path)?,
        None => MachineProfile::simulated(),
    })
}

/// The slowest that the simulated interpolator goes, mm/s.
const SLOWEST_MM_S: f64 = 0.2;
/// Samples of a path at most.
const MOST_SAMPLES: f64 = 1e5;

/// Whether the question can be answered, and for the machine that it is asked for.
fn suits(profile: &DriveProfile, question: &Question, arguments: &BudgetArguments) -> Result<(), CliError> {
    let refused = |reason: String| Err(CliError::Argument(reason));
    if let Some(interpolator) = &profile.interpolator {
        let speeds = [("--feed", Some(question.feed_mm_s)), ("--by-hand", question.by_hand_mm_s)];
        for (name, speed) in speeds.into_iter().filter_map(|(name, speed)| Some((name, speed?))) {
            if !(SLOWEST_MM_S..=interpolator.max_rate_mm_s).contains(&speed) {
                let (low, high) = (SLOWEST_MM_S * 60.0, interpolator.max_rate_mm_s * 60.0);
                return refused(format!(
                    "{name} {:.0} is beyond the drives: {low} to {high} mm/min",
                    speed * 60.0
                ));
            }
        }
        let machine = machine_of(arguments)?;
        if arguments.output.is_some()
            && (machine.acceleration_mm_s2 > interpolator.acceleration_mm_s2
                || machine.max_rate_mm_s > interpolator.max_rate_mm_s)
        {
            return refused(format!(
                "the machine profile has {} mm/s² and {} mm/s, the drives' [interpolator] {} and {}: the term would not hold. Make \
                 them alike",
                machine.acceleration_mm_s2,
                machine.max_rate_mm_s,
                interpolator.acceleration_mm_s2,
                interpolator.max_rate_mm_s
            ));
        }
    }
    let samples = question.samples(profile);
    if samples > MOST_SAMPLES {
        return refused(format!(
            "--feed {}: a path of the budget would take {samples:.0} samples of the profile's period_s, {MOST_SAMPLES} are the most",
            arguments.feed
        ));
    }
    Ok(())
}

fn summary(found: &Budget) -> String {
    let mut lines =
        vec![format!("{:<36} {:>9} {:>9}   signs of the worst", "contour error, µm, max", "exact", "worst")];
    for finding in &found.findings {
        let sign = |sign: f64| {
            if sign > 0.0 {
                '+'
            } else if sign < 0.0 {
                '-'
            } else {
                '0'
            }
        };
        let [kx, tx, ky, ty] = finding.signs.map(sign);
        lines.push(format!(
            "{:<36} {:>9} {:>9}   K {kx}{ky} tau {tx}{ty}",
            finding.path,
            figure(finding.exact.max),
            figure(finding.worst.max)
        ));
    }
    lines.push(format!("contour error {:.4} mm: {}", found.term_mm, found.source));
    lines.join("\n") + "\n"
}

fn write_page(folder: &Path) -> Result<ExitCode, CliError> {
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

//! The command `drives`: the contour-error term of a machine's feed drives, and what leads to it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use keepout_drives::budget::{BudgetRequest, ContourErrorBudget, budget};
use keepout_drives::metrics::figure;
use keepout_drives::profile::DriveProfile;
use keepout_planner::machine::{ContourErrorSource, MachineProfile};

use super::CliError;
use super::drive_tools::{
    BallbarArguments, ExportArguments, IdentifyArguments, TuneArguments, ballbar, export_gains,
    identify_drives, tune_drives,
};
use super::plan::{given, refuse_same, write};

/// Subcommands of `drives`.
#[derive(Debug, Subcommand)]
pub enum DrivesCommand {
    /// Print the contour-error term of the margin for drives at a feed: the worst case over the errors of
    /// their model.
    Budget(BudgetArguments),
    /// Find gain, time constant, friction and delay of drives from a recorded motion.
    Identify(IdentifyArguments),
    /// Propose gains for drives: the least contour error that keeps the margins.
    Tune(TuneArguments),
    /// Print the gains of a drive profile in the form of another controller.
    Export(ExportArguments),
    /// Take a measured circular test as the contour-error term.
    Ballbar(BallbarArguments),
}

#[derive(Debug, Args)]
pub struct BudgetArguments {
    /// The drives: a built-in profile or a TOML file.
    profile: String,
    /// Feed along the contour, mm/min.
    #[arg(long, value_name = "MM_MIN")]
    feed: f64,
    /// Fastest jog, mm/min. Only for profiles with an interpolator. Without it, the interpolator's top speed
    /// is used.
    #[arg(long, value_name = "MM_MIN")]
    by_hand: Option<f64>,
    /// Machine profile that the output copies, with this term. Without it, the output copies the simulated
    /// machine's.
    #[arg(long, value_name = "FILE", requires = "output")]
    machine_profile: Option<PathBuf>,
    /// Output file of the machine profile, TOML.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn drives(command: &DrivesCommand) -> Result<ExitCode, CliError> {
    match command {
        DrivesCommand::Budget(arguments) => work_out(arguments),
        DrivesCommand::Identify(arguments) => identify_drives(arguments),
        DrivesCommand::Tune(arguments) => tune_drives(arguments),
        DrivesCommand::Export(arguments) => export_gains(arguments),
        DrivesCommand::Ballbar(arguments) => ballbar(arguments),
    }
}

/// A progress bar. It is hidden if the error output is not a terminal.
pub fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed}");
    let bar = ProgressBar::new(0);
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

pub fn show(bar: &ProgressBar) -> impl FnMut(usize, usize) {
    |done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    }
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
                "--by-hand needs a profile with an [interpolator]: without one, jogging has no speed";
            return Err(CliError::Argument(reason.into()));
        }
        (Some(mm_min), Some(_)) => Some(speed("--by-hand", mm_min)?),
        (None, top) => top,
    };
    let question = BudgetRequest { feed_mm_s: speed("--feed", arguments.feed)?, by_hand_mm_s };
    suits(&profile, &question, arguments)?;
    let bar = bar();
    let found = budget(&profile, &question, &mut show(&bar));
    bar.finish_and_clear();
    let found = found.map_err(|error| CliError::Argument(error.to_string()))?;
    print!("{}", summary(&found));
    if let Some(output) = &arguments.output {
        let machine = machine_of(arguments)?;
        let machine = MachineProfile {
            contour_error_mm: found.term_mm,
            contour_error_source: ContourErrorSource::Modelled(found.source),
            ..machine
        };
        if arguments.machine_profile.is_none() {
            eprintln!(
                "note: the other figures are of the {}: give the figures of your machine with \
                 --machine-profile",
                machine.name
            );
        }
        if by_hand_mm_s.is_none() {
            eprintln!(
                "note: the drives' profile has no [interpolator]: the term covers paths at constant feed, \
                 but not corners, stops and jogging"
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

/// Least speed of the simulated interpolator, mm/s.
const SLOWEST_MM_S: f64 = 0.2;
/// Most samples of a path.
const MOST_SAMPLES: f64 = 1e5;

/// Checks that the budget can be computed, and that it holds for the machine profile.
fn suits(
    profile: &DriveProfile,
    question: &BudgetRequest,
    arguments: &BudgetArguments,
) -> Result<(), CliError> {
    let refused = |reason: String| Err(CliError::Argument(reason));
    if let Some(interpolator) = &profile.interpolator {
        let speeds = [("--feed", Some(question.feed_mm_s)), ("--by-hand", question.by_hand_mm_s)];
        for (name, speed) in speeds.into_iter().filter_map(|(name, speed)| Some((name, speed?))) {
            if !(SLOWEST_MM_S..=interpolator.max_rate_mm_s).contains(&speed) {
                let (low, high) = (SLOWEST_MM_S * 60.0, interpolator.max_rate_mm_s * 60.0);
                return refused(format!(
                    "{name} {:.0} is beyond the drives: give {low} to {high} mm/min",
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
                "the machine profile has {} mm/s² and {} mm/s, the drives' [interpolator] has {} and {}: the \
                 term would not hold. Give both the same limits",
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
            "--feed {}: a path of the budget needs {samples:.0} samples of the profile's period_s, but \
             at most {MOST_SAMPLES} are possible",
            arguments.feed
        ));
    }
    Ok(())
}

fn summary(found: &ContourErrorBudget) -> String {
    let mut lines = vec![format!(
        "{:<36} {:>9} {:>9}   signs of the worst, and samples late",
        "contour error, µm, at most", "exact", "worst"
    )];
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
            "{:<36} {:>9} {:>9}   K {kx}{ky} tau {tx}{ty}, {} late",
            finding.path,
            figure(finding.exact.max),
            figure(finding.worst.max),
            finding.delay
        ));
    }
    lines.push(format!("contour error {:.4} mm: {}", found.term_mm, found.source));
    lines.join("\n") + "\n"
}

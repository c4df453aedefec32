//! `doctor`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use keepout_executor::dialect::{DialectConfig, DialectName, Fit, Inspected};
use keepout_executor::session::RealClock;
use keepout_executor::session::serial::Serial;
use keepout_executor::supervisor::Mode;
use keepout_kernel::Vector;
use keepout_planner::machine::MachineProfile;
use keepout_planner::margin::Budget;
use keepout_sim::conformance::check_dialect;

use super::CliError;
use super::conformance::{AtPort, ConformanceArguments, compare_files, conformance};
use crate::examine::{Examination, examine, remedy};

/// It sends nothing but queries and questions: the machine does not move, and nothing is stored. With --conformance it moves
/// the tool in a small box, after a question. The exit code is 0 when
/// nothing was found that a session could not begin with, 6 when the port or the controller does not answer, or is not set up as
/// a session needs it.
#[derive(Debug, Args)]
pub struct DoctorArguments {
    /// The serial port, such as /dev/ttyUSB0.
    #[arg(long, value_name = "DEVICE", required_unless_present = "compare")]
    port: Option<String>,
    /// What the controller speaks: grbl, grblhal, zaber, venus, or a file that describes it. Settings are asked of the first two
    /// only.
    #[arg(long, value_name = "DIALECT", default_value = "grbl")]
    dialect: String,
    /// Baud rate of the port.
    #[arg(long, default_value_t = 115_200)]
    baud: u32,
    /// The machine's figures, a TOML file. Without it the simulated machine's are used.
    #[arg(long, value_name = "FILE")]
    machine_profile: Option<PathBuf>,
    /// Queries whose answers are timed.
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    queries: u16,
    #[command(flatten)]
    conformance: ConformanceArguments,
}

pub fn doctor(arguments: &DoctorArguments) -> Result<ExitCode, CliError> {
    if let Some(files) = &arguments.conformance.compare {
        return compare_files(files);
    }
    let machine = match &arguments.machine_profile {
        Some(path) => MachineProfile::load(path)?,
        None => MachineProfile::simulated(),
    };
    let language =
        DialectName::named(&arguments.dialect).map_err(|error| CliError::Argument(error.to_string()))?;
    if arguments.conformance.conformance {
        check_dialect(&language)?;
    }
    let setting = DialectConfig::of(&machine, Vector { dx: 0, dy: 0 });
    let mut dialect = language.dialect(setting);
    let mut port = Serial::open(arguments.port.as_deref().unwrap_or_default(), arguments.baud)?;
    let mut clock = RealClock::default();
    let needed = (machine.steps_per_mm, machine.arc_tolerance_mm);
    let queries = usize::from(arguments.queries);
    let found = examine(&mut port, &mut clock, dialect.as_mut(), queries, needed)?;
    let (fit, machine) = print_examination(machine, &found, arguments.baud)?;
    match (&arguments.machine_profile, fit) {
        (Some(profile), true) if arguments.conformance.conformance => {
            let baud = arguments.baud;
            let at = AtPort { port: &mut port, baud, clock: &mut clock, language, machine, profile };
            conformance(at, &arguments.conformance)
        }
        (_, true) => Ok(ExitCode::SUCCESS),
        (_, false) => Ok(ExitCode::from(6)),
    }
}

/// What was found; whether a session can begin, and the machine with the controller's own figures.
fn print_examination(
    machine: MachineProfile,
    found: &Examination,
    baud: u32,
) -> Result<(bool, MachineProfile), CliError> {
    let mut fit = print_state(found);
    match &found.inspector {
        Some(inspected) => fit &= print_findings(inspected),
        None => print("settings", "this dialect reads them when a session begins; nothing was asked here"),
    }
    print_timing(found);
    let machine = as_found(machine, found);
    print_margin(&machine)?;
    print_feel(&machine, found, baud);
    println!(
        "\n{}",
        match (fit, &found.inspector) {
            (true, Some(_)) => "A session can begin.",
            (true, None) => "The controller answers; what it is set to is checked when a session begins.",
            (false, _) => "No session can begin; see above what to do.",
        }
    );
    Ok((fit, machine))
}

fn print(name: &str, value: &str) {
    println!("{name:<44} {value}");
}

/// The controller's state; whether a session can begin in it.
fn print_state(found: &Examination) -> bool {
    let mode = found.report.mode;
    let note = remedy(mode).map_or(String::new(), |remedy| format!(": {remedy}"));
    print("state", &format!("{mode:?}{note}"));
    matches!(mode, Mode::Idle | Mode::Alarm | Mode::Held)
}

/// What was found; whether all of it is fit.
fn print_findings(inspected: &Inspected) -> bool {
    let mut fit = true;
    for finding in &inspected.findings {
        let note = match finding.fit {
            Fit::Good => String::new(),
            Fit::Minor(note) => format!("   ({note})"),
            Fit::Wrong(remedy) => {
                fit = false;
                format!("   NOT FIT: {remedy}")
            }
        };
        print(&finding.name, &format!("{}{note}", finding.value));
    }
    fit
}

fn print_timing(found: &Examination) {
    let ms = |percent| found.round_trip(percent).as_secs_f64() * 1e3;
    let all = found.round_trips.len();
    let (least, median, most) = (ms(0), ms(50), ms(95));
    print(
        "answer to a query",
        &format!("{least:.1} ms at least, {median:.1} ms median, {most:.1} ms for 95 % of {all}"),
    );
    print("reports", &format!("{:.0} a second, asked for one after the other", found.reports_per_s));
    if found.unanswered > 0 {
        print("queries without an answer", &format!("{}: check cable and baud rate", found.unanswered));
    }
}

/// The machine with the controller's own figures, where it tells them.
fn as_found(machine: MachineProfile, found: &Examination) -> MachineProfile {
    let Some(inspected) = &found.inspector else { return machine };
    let less = |known: f64, told: f64| if told.is_finite() && told > 0.0 { known.min(told) } else { known };
    MachineProfile {
        steps_per_mm: inspected.steps_per_mm.unwrap_or(machine.steps_per_mm),
        report_digit_mm: inspected.report_digit_mm.unwrap_or(machine.report_digit_mm),
        max_rate_mm_s: less(machine.max_rate_mm_s, inspected.limits.speed_mm_s),
        acceleration_mm_s2: less(machine.acceleration_mm_s2, inspected.limits.acceleration_mm_s2),
        ..machine
    }
}

fn print_margin(machine: &MachineProfile) -> Result<(), CliError> {
    let budget = Budget::of(machine, None, false).map_err(|error| CliError::Argument(error.to_string()))?;
    println!("\nmargin of a plan, with {} and the steps and digits found here", machine.name);
    println!("{budget}\n");
    Ok(())
}

/// What latency and baud rate mean at the stick, and in the contour.
fn print_feel(machine: &MachineProfile, found: &Examination, baud: u32) {
    let latency = found.round_trip(95).as_secs_f64();
    for speed in [10.0, 50.0, machine.max_rate_mm_s] {
        let speed = machine.max_rate_mm_s.min(speed);
        let braking = speed * speed / (2.0 * machine.acceleration_mm_s2);
        let value = format!(
            "{:.2} mm: {:.2} mm until it hears of it, {braking:.2} mm braking",
            speed * latency + braking,
            speed * latency
        );
        print(&format!("from the stick let go to rest, at {speed:.0} mm/s"), &value);
    }
    // A motion of a contour goes out when the one before was acknowledged.
    let line_s = LINE_BYTES * 10.0 / f64::from(baud.max(1));
    let rate = 1.0 / (found.round_trip(50).as_secs_f64() + line_s);
    print("motions of a contour", &format!("up to {rate:.0} a second ({LINE_BYTES:.0} bytes each)"));
    let shortest = 15.0 / rate;
    print("at 900 mm/min it keeps its feed on motions of", &format!("{shortest:.2} mm and more, on average"));
    println!("\nNone of this bears on safety: what is sent is certified from wherever the tool may be.");
}

/// A motion of a contour is about so long.
const LINE_BYTES: f64 = 45.0;

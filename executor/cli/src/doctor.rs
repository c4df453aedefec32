//! The command `doctor`: examines a controller.

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
use super::store::StoredMachine;
use crate::examine::{Examination, examine, remedy};

/// Arguments of `doctor`.
#[derive(Debug, Args)]
pub struct DoctorArguments {
    /// The serial port, such as /dev/ttyUSB0.
    #[arg(long, value_name = "DEVICE", required_unless_present_any = ["compare", "machine"])]
    port: Option<String>,
    /// Dialect of the controller: grbl, grblhal, zaber, venus, or a file that describes another dialect.
    /// `doctor` reads the settings of grbl and grblhal only.
    #[arg(long, value_name = "DIALECT")]
    dialect: Option<String>,
    /// Baud rate of the port. Default: 115200.
    #[arg(long)]
    baud: Option<u32>,
    /// The stored name of a machine; see `keepout machine`. It gives the port, the dialect, the baud rate and the
    /// machine profile.
    #[arg(long, value_name = "NAME", conflicts_with = "machine_profile")]
    machine: Option<String>,
    /// Machine profile, a TOML file. Without it, the figures of the simulated machine are used.
    #[arg(long, value_name = "FILE")]
    machine_profile: Option<PathBuf>,
    /// Number of timed queries.
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    queries: u16,
    #[command(flatten)]
    conformance: ConformanceArguments,
}

pub fn doctor(arguments: &DoctorArguments) -> Result<ExitCode, CliError> {
    if let Some(files) = &arguments.conformance.compare {
        return compare_files(files);
    }
    let stored = arguments.machine.as_deref().map(StoredMachine::named).transpose()?;
    let stored = stored.unwrap_or_else(StoredMachine::simulated);
    let machine = match &arguments.machine_profile {
        Some(path) => MachineProfile::load(path)?,
        None => stored.profile,
    };
    let port = arguments.port.as_ref().unwrap_or(&stored.port);
    let baud = arguments.baud.unwrap_or(stored.baud);
    let dialect_name = DialectName::named(arguments.dialect.as_ref().unwrap_or(&stored.dialect))
        .map_err(|error| CliError::Argument(error.to_string()))?;
    if arguments.conformance.conformance {
        check_dialect(&dialect_name)?;
    }
    let config = DialectConfig::of(&machine, Vector { dx: 0, dy: 0 });
    let mut dialect = dialect_name.dialect(config);
    let mut port = Serial::open(port, baud)?;
    let mut clock = RealClock::default();
    let needed = (machine.steps_per_mm, machine.arc_tolerance_mm);
    let queries = usize::from(arguments.queries);
    let found = examine(&mut port, &mut clock, dialect.as_mut(), queries, needed)?;
    let (fit, machine) = print_examination(machine, &found, baud)?;
    match (&arguments.machine_profile, fit) {
        (Some(profile), true) if arguments.conformance.conformance => {
            let at = AtPort { port: &mut port, baud, clock: &mut clock, dialect_name, machine, profile };
            conformance(at, &arguments.conformance)
        }
        (_, true) => Ok(ExitCode::SUCCESS),
        (_, false) => Ok(ExitCode::from(6)),
    }
}

/// Prints the findings. Returns whether a session can begin, and the machine profile with the controller's
/// own figures.
fn print_examination(
    machine: MachineProfile,
    found: &Examination,
    baud: u32,
) -> Result<(bool, MachineProfile), CliError> {
    let mut fit = print_state(found);
    match &found.inspector {
        Some(inspected) => fit &= print_findings(inspected),
        None => print("settings", "not read here: this dialect reads them when a session begins"),
    }
    print_timing(found);
    let machine = as_found(machine, found);
    print_margin(&machine)?;
    print_feel(&machine, found, baud);
    println!(
        "\n{}",
        match (fit, &found.inspector) {
            (true, _) if found.report.mode == Mode::Alarm => {
                "The machine is locked: only a session with --home, tool raised, can begin."
            }
            (true, Some(_)) => "A session can begin.",
            (true, None) => "The controller answers. A session checks its settings when it begins.",
            (false, _) => "No session can begin. The lines above state the remedy.",
        }
    );
    Ok((fit, machine))
}

fn print(name: &str, value: &str) {
    println!("{name:<44} {value}");
}

/// Prints the controller's state. Returns whether a session can begin in it.
fn print_state(found: &Examination) -> bool {
    let mode = found.report.mode;
    let note = remedy(mode).map_or(String::new(), |remedy| format!(": {remedy}"));
    print("state", &format!("{mode:?}{note}"));
    matches!(mode, Mode::Idle | Mode::Alarm | Mode::Held)
}

/// Prints the findings. Returns whether all settings are fit for a session.
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
    print("reports", &format!("{:.0} a second, with one query at a time", found.reports_per_s));
    if found.unanswered > 0 {
        print("queries without an answer", &format!("{}: check cable and baud rate", found.unanswered));
    }
}

/// The machine profile with the controller's own figures, where the controller states them.
fn as_found(machine: MachineProfile, found: &Examination) -> MachineProfile {
    let Some(inspected) = &found.inspector else { return machine };
    let less = |known: f64, stated: f64| {
        if stated.is_finite() && stated > 0.0 { known.min(stated) } else { known }
    };
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

/// Prints the effect of latency and baud rate on jogging and on the contour.
fn print_feel(machine: &MachineProfile, found: &Examination, baud: u32) {
    let latency = found.round_trip(95).as_secs_f64();
    for speed in [10.0, 50.0, machine.max_rate_mm_s] {
        let speed = machine.max_rate_mm_s.min(speed);
        let braking = speed * speed / (2.0 * machine.acceleration_mm_s2);
        let value = format!(
            "{:.2} mm: {:.2} mm until the stop arrives, {braking:.2} mm braking",
            speed * latency + braking,
            speed * latency
        );
        print(&format!("travel after the stick's release, at {speed:.0} mm/s"), &value);
    }
    // The program sends a motion of a contour after the controller acknowledged the motion before.
    let line_s = LINE_BYTES * 10.0 / f64::from(baud.max(1));
    let rate = 1.0 / (found.round_trip(50).as_secs_f64() + line_s);
    print("motions of a contour", &format!("up to {rate:.0} a second ({LINE_BYTES:.0} bytes each)"));
    let shortest = 15.0 / rate;
    print("at 900 mm/min it keeps its feed on motions of", &format!("{shortest:.2} mm and more, on average"));
    println!(
        "\nThese figures do not affect safety: each command is certified from every position where the tool \
         may be."
    );
}

/// Approximate length of a motion of a contour, bytes.
const LINE_BYTES: f64 = 45.0;

//! The command `simulate`: a simulated machine behind a pty.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use clap::Args;
use keepout_executor::dialect::DialectName;
use keepout_executor::session::place_on_table;
use keepout_kernel::Height;
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;
use keepout_sim::monitor::CollisionMonitor;
use keepout_sim::standalone::{Records, Signals, Standalone, state};
use keepout_sim::{SimMachine, SimSettings};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};

use super::plan::{given, load, refuse_same};
use super::run::drives;
use super::values::length;
use super::{CertifyTime, CliError, pair};
use crate::input::TerminalError;

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// Dialect of the controller: grbl, grblhal, zaber, venus, or a file that describes another dialect.
    #[arg(long, value_name = "DIALECT", default_value = "grbl")]
    dialect: String,
    /// Machine profile, a TOML file. Without it, the figures of the built-in simulated machine are used.
    #[arg(long, value_name = "FILE")]
    machine_profile: Option<PathBuf>,
    /// The built-in machine with a third axis.
    #[arg(long, conflicts_with = "machine_profile")]
    three_axes: bool,
    /// Baud rate of the line.
    #[arg(long, default_value_t = 115_200)]
    baud: u32,
    /// Added delay each way, ms.
    #[arg(long, value_name = "MS", default_value_t = 1)]
    latency_ms: u64,
    /// Seed of the tool's positioning error, which varies within the machine's repeatability.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Start position of the tool, machine coordinates, mm.
    #[arg(long, value_name = "X,Y", value_parser = pair, default_value = "-1,-1", allow_hyphen_values = true)]
    start_mm: Mm2,
    /// Start homed. Without this option the machine is locked until it homes. It homes in place, as if the
    /// tool were raised and lowered again.
    #[arg(long)]
    homed: bool,
    /// Symbolic link to the device. The program renews it with each new device.
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// File that keeps the tool's position. If it exists, it gives the start position in place of --start-mm.
    #[arg(long, value_name = "FILE")]
    state: Option<PathBuf>,
    /// Append every received byte to this file.
    #[arg(long, value_name = "FILE")]
    received: Option<PathBuf>,
    /// Append the true tool positions to this file: lines "MICROSECONDS rest|jog|run X Y", machine
    /// coordinates, mm.
    #[arg(long, value_name = "FILE")]
    positions: Option<PathBuf>,
    /// Feed drives: a profile of `drives budget`, or `none`. With `none` the tool follows every command
    /// exactly.
    #[arg(long, default_value = "simulated", value_name = "PROFILE")]
    drives: String,
    /// Watch the part of this plan. The exit code is 8 if the tool was in the part.
    #[arg(long, value_name = "PLAN")]
    monitor: Option<PathBuf>,
    #[command(flatten)]
    time: CertifyTime,
    /// Machine coordinates of the drawing's origin, for --monitor, mm.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    origin_mm: Option<Mm2>,
    /// Machine coordinate of the top of the part, for --monitor of a plan with depths, mm.
    #[arg(long, value_name = "Z", value_parser = length, allow_hyphen_values = true)]
    top_mm: Option<f64>,
}

pub fn simulate(arguments: &SimulateArguments) -> Result<ExitCode, CliError> {
    let described = Some(PathBuf::from(&arguments.dialect)).filter(|path| path.is_file());
    let driven = Some(PathBuf::from(&arguments.drives)).filter(|path| path.is_file());
    let profile = arguments.machine_profile.as_ref();
    let inputs = given(&[profile, arguments.monitor.as_ref(), described.as_ref(), driven.as_ref()]);
    let outputs = [&arguments.link, &arguments.received, &arguments.positions, &arguments.state];
    refuse_same(&inputs, &given(&outputs.map(Option::as_ref)))?;
    let dialect_name =
        DialectName::named(&arguments.dialect).map_err(|error| CliError::Argument(error.to_string()))?;
    let machine = match &arguments.machine_profile {
        Some(path) => MachineProfile::load(path)?,
        None if arguments.three_axes => MachineProfile::simulated_three_axes(),
        None => MachineProfile::simulated(),
    };
    let mut monitor = monitor(arguments, &machine)?;
    let known = arguments.state.as_deref().map(state).transpose()?.flatten();
    let settings = SimSettings {
        homed: arguments.homed,
        ..SimSettings::of(
            machine.clone(),
            known.unwrap_or(arguments.start_mm.at_height(if machine.z.is_some() { -1.0 } else { 0.0 })),
        )
    };
    let line = (arguments.baud, Duration::from_millis(arguments.latency_ms));
    let servo = drives(&arguments.drives)?;
    let simulated = SimMachine::wandering(settings, &dialect_name, line, arguments.seed, servo.as_ref());
    let records = Records {
        link: arguments.link.clone(),
        received: arguments.received.clone(),
        positions: arguments.positions.clone(),
        state: arguments.state.clone(),
    };
    let mut watch = |sample: &_| {
        if let Some(monitor) = &mut monitor {
            monitor.watch(sample);
        }
    };
    let signals = signals()?;
    Standalone::new(simulated, records, &mut watch)?.run(&signals, |name| {
        println!("device {name}");
        let _ = std::io::stdout().flush();
    })?;
    Ok(monitor.map_or(ExitCode::SUCCESS, |monitor| verdict(&monitor)))
}

fn monitor(
    arguments: &SimulateArguments,
    machine: &MachineProfile,
) -> Result<Option<CollisionMonitor>, CliError> {
    let Some(path) = &arguments.monitor else { return Ok(None) };
    let plan = load(path, arguments.time)?;
    let place = place_on_table(&plan, machine, arguments.origin_mm)?.with_top(&plan, arguments.top_mm)?;
    let zero = place.z.map_or(Height::ZERO, |z| z.zero);
    Ok(Some(CollisionMonitor::new(plan.levels, plan.plan.tool_radius, (place.offset, zero))))
}

fn verdict(monitor: &CollisionMonitor) -> ExitCode {
    let deepest = monitor.deepest().map_or(0.0, |gouge| gouge.depth_mm);
    println!("{:<36} {deepest:.5} mm", "deepest gouge");
    if let Some(closest) = monitor.closest_mm() {
        println!("{:<36} {closest:.5} mm", "closest approach of tool and part");
    }
    if deepest > 0.0 { ExitCode::from(8) } else { ExitCode::SUCCESS }
}

fn signals() -> Result<Arc<Signals>, CliError> {
    let signals = Arc::new(Signals::default());
    let raised = Arc::clone(&signals);
    let wrong = |error| CliError::Terminal(TerminalError::SetUp(error));
    let mut waiting =
        signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP, SIGUSR1]).map_err(wrong)?;
    let wait = move || {
        for signal in waiting.forever() {
            let flag = if signal == SIGUSR1 { &raised.cut } else { &raised.end };
            flag.store(true, Ordering::Relaxed);
        }
    };
    std::thread::Builder::new().name("signals".into()).spawn(wait).map_err(wrong)?;
    Ok(signals)
}

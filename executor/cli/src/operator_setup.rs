//! Who steers a run, and who watches: the arguments' operator with what belongs around it.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use keepout_executor::operator::{Operator, Panel};
use keepout_sim::operator::{OperatorError, Recorder, named};

use super::screen::Screen;
use super::{CliError, RunArguments};
use crate::input::device::{Mapping, Wanted};
use crate::input::terminal::restore;
use crate::input::{Attended, Endable, Gamepad, Keyboard, Stick, StickSettings, TerminalError};

/// What the keys do where the keyboard steers.
const STEERING_KEYS: &str = "SPACE STOP · arrows steer · q quit · 1-4 speed · s step · a auto · p r f";
/// What the keys do where something else steers.
const WATCHING_KEYS: &str = "SPACE STOP · p pause · q quit · r resume · f recover";

/// The operator, the view if there is one, and what the operator's devices have to say.
pub struct OperatorSetup {
    pub operator: Box<dyn Operator + Send>,
    pub screen: Option<Screen>,
    pub panel: Panel,
    /// Whether a person is there who can recover from a fault.
    pub recovers: bool,
}

/// Sets up the operator that the arguments ask for. `real_time`: whether the run waits for people.
pub fn hands(arguments: &RunArguments, jog_s: f64, real_time: bool) -> Result<OperatorSetup, CliError> {
    let panel = Panel::default();
    let name = arguments.operator.as_str();
    let by_hand = ["keyboard", "gamepad", "handwheel"].contains(&name.split(':').next().unwrap_or(name));
    if by_hand && !real_time {
        let reason = format!("nobody can steer in virtual time: take --machine sim for --operator {name}");
        return Err(CliError::Argument(reason));
    }
    // Devices that are missing are told of before the terminal is changed.
    let other = if name == "keyboard" { None } else { Some(other(arguments, jog_s, &panel)?) };
    let keyboard = name == "keyboard" || arguments.view && real_time && std::io::stdin().is_terminal();
    let screen = if arguments.view && std::io::stdout().is_terminal() {
        let keys = match (name, keyboard) {
            ("keyboard", _) => STEERING_KEYS,
            (_, true) => WATCHING_KEYS,
            _ => "",
        };
        Some(Screen::open(panel.clone(), keys)?)
    } else {
        None
    };
    let operator = match (other, keyboard) {
        (None, _) => Box::new(Keyboard::open(panel.clone())?),
        (Some(other), true) => {
            // The device's line is of more use than the speed of keys that do not steer.
            let keys = Keyboard::open(Panel::default())?;
            Box::new(Attended::new(other, keys)) as Box<dyn Operator + Send>
        }
        (Some(other), false) => other,
    };
    let operator = if real_time { ended_by_signals(operator)? } else { operator };
    let operator = match &arguments.record_trace {
        Some(path) => Box::new(Recorder::create(operator, path, panel.clone()).map_err(OperatorError::from)?),
        None => operator,
    };
    Ok(OperatorSetup { operator, screen, panel, recovers: by_hand })
}

/// An operator other than the keyboard.
fn other(arguments: &RunArguments, jog_s: f64, panel: &Panel) -> Result<Box<dyn Operator + Send>, CliError> {
    let (kind, device) = match arguments.operator.split_once(':') {
        Some((kind, device)) => (kind, Some(device)),
        None => (arguments.operator.as_str(), None),
    };
    let wanted = match (kind, device) {
        ("gamepad", None) => Wanted::Stick,
        ("handwheel", None) => Wanted::Wheel,
        ("gamepad" | "handwheel", Some(device)) => Wanted::At(device.into()),
        _ => return Ok(named(&arguments.operator, jog_s, arguments.seed)?),
    };
    let stick = Stick::new(StickSettings {
        dead_zone: arguments.dead_zone,
        expo: arguments.expo,
        ..StickSettings::default()
    })?;
    Ok(Box::new(Gamepad::open(wanted, Mapping::default(), stick, panel.clone())?))
}

/// The first signal to end lets the session stop the machine and put the terminal back; the second puts the terminal back
/// and ends at once.
#[cfg(unix)]
fn ended_by_signals(operator: Box<dyn Operator + Send>) -> Result<Box<dyn Operator + Send>, CliError> {
    use std::sync::atomic::Ordering;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let end = Arc::new(AtomicBool::new(false));
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP]).map_err(TerminalError::AlignmentFile)?;
    let raised = Arc::clone(&end);
    let wait = move || {
        for signal in signals.forever() {
            if raised.swap(true, Ordering::Relaxed) {
                restore();
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        }
    };
    std::thread::Builder::new().name("signals".into()).spawn(wait).map_err(TerminalError::AlignmentFile)?;
    Ok(Box::new(Endable::new(operator, end)))
}

#[cfg(not(unix))]
fn ended_by_signals(operator: Box<dyn Operator + Send>) -> Result<Box<dyn Operator + Send>, CliError> {
    Ok(Box::new(Endable::new(operator, Arc::new(AtomicBool::new(false)))))
}

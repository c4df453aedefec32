//! The operator set-up of a run: the operator of the arguments, the attendant at the keyboard, and the view.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use keepout_executor::operator::{Operator, Panel};
use keepout_executor::supervisor::{Stick, StickSettings};
use keepout_sim::operator::{OperatorError, Recorder, named};

use super::before::OperatorName;
use super::screen::Screen;
use super::{CliError, RunArguments};
use crate::input::device::{Mapping, Wanted};
use crate::input::terminal::restore;
use crate::input::{Attended, Endable, Gamepad, Keyboard, TerminalError};

/// Line that explains the keys when the keyboard jogs.
pub const JOGGING_KEYS: &str =
    "SPACE STOP · arrows jog · 1-4 speed · a arm · p pause · r resume · q quit · ? help";
/// Line that explains the keys when another device jogs.
pub const WATCHING_KEYS: &str = "SPACE STOP · p pause · r resume · f recover · q quit · ? help";
/// Line that explains the keys after a fault.
pub const FAULT_KEYS: &str = "f recover · q quit · ? help";
/// The keys, line by line, for `?`.
pub const HELP: [&str; 16] = [
    "SPACE          stop the jog, or pause the contour. Any key ends the stop.",
    "arrows         jog; HOME, PAGE UP, END and PAGE DOWN jog diagonally",
    "+ -            up, down, in a plan with depths",
    "u              raise the tool to the safe height, from anywhere",
    "c, N, enter    cross to contour N: up, across, down to just above the stock",
    "m              the spindle runs, or stands; twice where the controller switches it",
    "1 2 3 4        speed 5, 20, 50 or 100 %; in step mode the size of a step",
    "s              step mode on or off: each press moves one step",
    "a              arm the cycle: touching the wall starts the contour, at once if the tool touches it now",
    "p              pause the contour (feed hold)",
    "r              resume the contour (cycle start)",
    "f              recover after a fault",
    "q              end the session: the machine comes to rest first",
    "? or h         show or hide this help",
    "The tool slides along the wall and cannot enter the part.",
    "Keepout does not know the spindle, a clamp that is not drawn, or the tool's height in two axes.",
];

/// The operator, the view if there is one, and the notices of the operator's devices.
pub struct OperatorSetup {
    pub operator: Box<dyn Operator + Send>,
    pub screen: Option<Screen>,
    pub panel: Panel,
    /// Whether a person operates the run, who can recover from a fault.
    pub recovers: bool,
}

/// Sets up the operator of the arguments. `real_time`: whether the run takes place in real time.
pub fn set_up(
    arguments: &RunArguments,
    OperatorName { name, by_hand }: &OperatorName,
    jog_s: f64,
    real_time: bool,
) -> Result<OperatorSetup, CliError> {
    let panel = Panel::default();
    let (name, by_hand) = (name.as_str(), *by_hand);
    if by_hand && !real_time {
        let reason = format!("a person cannot jog in virtual time: use --machine sim for --operator {name}");
        return Err(CliError::Argument(reason));
    }
    // A missing device gives its error before the terminal changes.
    let other = if name == "keyboard" { None } else { Some(other(arguments, name, jog_s, &panel)?) };
    let keyboard = name == "keyboard" || arguments.view && real_time && std::io::stdin().is_terminal();
    let screen = if arguments.view && std::io::stdout().is_terminal() {
        let keys = match (name, keyboard) {
            ("keyboard", _) => JOGGING_KEYS,
            (_, true) => WATCHING_KEYS,
            _ => "",
        };
        Some(Screen::open(panel.clone(), keys, arguments)?)
    } else {
        None
    };
    let operator = match (other, keyboard) {
        (None, _) => Box::new(Keyboard::open(panel.clone())?),
        (Some(other), true) => {
            // The status line shows the device, and not the speed of keys that do not jog.
            let keys = Keyboard::watching(panel.clone())?;
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
fn other(
    arguments: &RunArguments,
    name: &str,
    jog_s: f64,
    panel: &Panel,
) -> Result<Box<dyn Operator + Send>, CliError> {
    let (kind, device) = match name.split_once(':') {
        Some((kind, device)) => (kind, Some(device)),
        None => (name, None),
    };
    let wanted = match (kind, device) {
        ("gamepad", None) => Wanted::Stick,
        ("handwheel", None) => Wanted::Wheel,
        ("gamepad" | "handwheel", Some(device)) => Wanted::At(device.into()),
        _ => return Ok(named(name, jog_s, arguments.seed)?),
    };
    let stick = Stick::new(StickSettings {
        dead_zone: arguments.dead_zone,
        expo: arguments.expo,
        ..StickSettings::default()
    })?;
    Ok(Box::new(Gamepad::open(wanted, Mapping::default(), stick, panel.clone())?))
}

/// Ends the session at SIGINT, SIGTERM or SIGHUP.
///
/// At the first signal the session stops the machine and restores the terminal. At the second signal the
/// program restores the terminal and ends at once.
#[cfg(unix)]
fn ended_by_signals(operator: Box<dyn Operator + Send>) -> Result<Box<dyn Operator + Send>, CliError> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let end = Arc::new(AtomicBool::new(false));
    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP]).map_err(TerminalError::SetUp)?;
    let raised = Arc::clone(&end);
    let wait = move || {
        for signal in signals.forever() {
            if raised.swap(true, Ordering::Relaxed) {
                restore();
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        }
    };
    std::thread::Builder::new().name("signals".into()).spawn(wait).map_err(TerminalError::SetUp)?;
    Ok(Box::new(Endable::new(operator, end)))
}

/// Ends the session at Ctrl-C. At the second the program ends at once. Windows ends it when its window closes.
#[cfg(not(unix))]
fn ended_by_signals(operator: Box<dyn Operator + Send>) -> Result<Box<dyn Operator + Send>, CliError> {
    let end = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&end);
    let stop = move || {
        if raised.swap(true, Ordering::Relaxed) {
            restore();
            std::process::exit(1);
        }
    };
    ctrlc::set_handler(stop).map_err(|error| TerminalError::SetUp(std::io::Error::other(error)))?;
    Ok(Box::new(Endable::new(operator, end)))
}

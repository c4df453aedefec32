//! Why a session stops.

use keepout_kernel::Point;
use thiserror::Error;

use super::event::Mode;
use super::guard::Refusal;

/// Why a session stopped.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    /// The controller does not answer.
    #[error("no answer from the controller for {seconds:.1} s. Check cable, power, port and baud rate.")]
    Silent {
        /// How long.
        seconds: f64,
    },
    /// It answered something that is not its language.
    #[error("the controller sent {line:?}, which is not GRBL 1.1. Check the baud rate and the cable.")]
    Garbled {
        /// The line.
        line: String,
    },
    /// It refused a line.
    #[error("the controller refused a line with error {code}{}. The machine has stopped at its last certified target.", error_text(*.code))]
    Refused {
        /// Its error number.
        code: u16,
    },
    /// It raised an alarm.
    #[error("the controller raised alarm {code}{}. Find the cause, then home the machine again.", alarm_text(*.code))]
    Alarm {
        /// Its alarm number.
        code: u16,
    },
    /// It was reset under way.
    #[error("the controller was reset. Its position may be lost: home it and start again.")]
    WasReset,
    /// It is locked and homing was not asked for.
    #[error(
        "the machine is not homed: where the tool is, is not known. Start with --home, with the tool raised."
    )]
    NotHomed,
    /// Its settings are not those that safety needs.
    #[error("controller setting ${number} is {value}, it must be {needed}")]
    Setting {
        /// The setting's number.
        number: u16,
        /// Its value.
        value: f64,
        /// What is needed.
        needed: &'static str,
    },
    /// The tool stands where it must not.
    #[error("the tool stands at {}: {refusal}. Raise it, move it clear by hand, and start again.", keepout_planner::units::place(*at))]
    StandsInside {
        /// Where it stands.
        at: Point,
        /// What the guard says.
        refusal: Refusal,
    },
    /// A line was neither accepted nor refused.
    #[error("a line was lost on the way to the controller. Check cable and baud rate.")]
    LineLost,
    /// Its work offset changed under way.
    #[error("the controller's work offset changed while the session ran: somebody set it there")]
    OffsetChanged,
    /// The guard found something that can not be.
    #[error("stopped: {0}")]
    Guard(#[from] Refusal),
    /// It entered a state that it was not sent to.
    #[error("the controller went into {mode:?} by itself: somebody pressed a button there, or a door opened")]
    Unexpected {
        /// The state.
        mode: Mode,
    },
    /// The port failed.
    #[error("the port was lost: {0}")]
    PortLost(String),
}

fn error_text(code: u16) -> &'static str {
    match code {
        1..=3 => " (a damaged line)",
        8 => " (not idle)",
        9 => " (locked by an alarm)",
        11 | 14 => " (a line too long)",
        15 => " (beyond the machine's travel)",
        20..=25 | 33..=35 => " (not valid G-code)",
        _ => "",
    }
}

fn alarm_text(code: u16) -> &'static str {
    match code {
        1 => " (limit switch)",
        2 => " (beyond the machine's travel)",
        3 => " (reset while moving: position lost)",
        6..=9 => " (homing failed)",
        _ => "",
    }
}

//! Why a session stops.

use keepout_guard::Refusal;
use keepout_kernel::Point;
use thiserror::Error;

use super::event::{EncodeError, Mode, Text, Unfit};

/// Why a session stopped.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Fault {
    /// The controller does not answer.
    #[error("no answer from the controller for {seconds:.1} s. Check cable, power, port and baud rate.")]
    Silent {
        /// How long.
        seconds: f64,
    },
    /// It answered something that is not its language.
    #[error(
        "the controller sent {line:?}, which is not its language. Check the dialect, the baud rate and the cable."
    )]
    Garbled {
        /// The line.
        line: Text,
    },
    /// It refused a line.
    #[error("the controller refused a line with error {code}{}{meaning}. The machine stops at its last certified target.", if meaning.is_empty() { "" } else { ": " })]
    Refused {
        /// Its error number.
        code: u16,
        /// What that means.
        meaning: &'static str,
    },
    /// It raised an alarm.
    #[error("the controller raised alarm {code}{}{meaning}. Find the cause, then home the machine again.", if meaning.is_empty() { "" } else { ": " })]
    Alarm {
        /// Its alarm number.
        code: u16,
        /// What that means.
        meaning: &'static str,
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
    #[error("controller setting {}{} must be {}", .0.name, if .0.value.is_nan() { String::new() } else { format!(" is {}, it", .0.value) }, .0.needed)]
    Unfit(Unfit),
    /// The tool stands in the part.
    #[error("the tool stands at {at}: {refusal}. Raise it, move it clear of the part, and start again.")]
    InsidePart {
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
    PortLost(Text),
    /// A command cannot be written in the controller's language.
    #[error("stopped before a motion was sent: {0}")]
    NotSent(EncodeError),
}

impl Fault {
    /// Whether the controller may have lost where the tool is: it must be homed again.
    #[must_use]
    pub fn loses_position(&self) -> bool {
        !matches!(
            self,
            Self::Silent { .. }
                | Self::Garbled { .. }
                | Self::Refused { .. }
                | Self::LineLost
                | Self::PortLost(_)
                | Self::NotSent(_)
        )
    }
}

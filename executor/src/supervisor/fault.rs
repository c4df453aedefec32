//! The faults that stop a session.

use keepout_guard::Refusal;
use keepout_kernel::Point;
use thiserror::Error;

use super::event::{EncodeError, Mode, Text, Unfit};

/// The reason why a session stopped.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Fault {
    /// The controller does not answer.
    #[error("no answer from the controller for {seconds:.1} s. Check cable, power, port and baud rate.")]
    Silent {
        /// Duration of the silence, s.
        seconds: f64,
    },
    /// The controller sent a line that is not in its language.
    #[error(
        "the controller sent {line:?}, which is not its language. \
         Check the dialect, the baud rate and the cable."
    )]
    Garbled {
        /// The line.
        line: Text,
    },
    /// The controller rejected a line.
    #[error(
        "the controller rejected a line with error {code}{}{meaning}. \
         The machine stops at its last certified target.",
        if meaning.is_empty() { "" } else { ": " }
    )]
    Refused {
        /// The controller's error number.
        code: u16,
        /// Meaning of the number. Empty when it is unknown.
        meaning: &'static str,
    },
    /// The controller raised an alarm.
    #[error(
        "the controller raised {}{}{meaning}. Find the cause, then home the machine again.",
        if *code == 0 { "an alarm".into() } else { format!("alarm {code}") },
        if meaning.is_empty() { "" } else { ": " }
    )]
    Alarm {
        /// The controller's alarm number. 0 when the controller did not report it.
        code: u16,
        /// Meaning of the number. Empty when it is unknown.
        meaning: &'static str,
    },
    /// The controller was reset during the session.
    #[error("the controller was reset. Its position may be lost: home it and start again.")]
    WasReset,
    /// The controller is locked, and the session does not home it.
    #[error(
        "the machine is not homed, so the position of the tool is unknown. \
         Raise the tool, and start with --home."
    )]
    NotHomed,
    /// A setting does not have the value that safety requires.
    #[error(
        "controller setting {}{} must be {}. Set it at the controller, then home the machine again.",
        .0.name,
        if .0.value.is_nan() { String::new() } else { format!(" is {}, it", .0.value) },
        .0.needed
    )]
    Unfit(Unfit),
    /// The tool stands in the part.
    #[error("the tool stands at {at}: {refusal}. Raise it, move it clear of the part, and start again.")]
    InsidePart {
        /// Position of the tool.
        at: Point,
        /// Refusal of the guard.
        refusal: Refusal,
    },
    /// The controller neither accepted nor rejected a line.
    #[error("a line was lost on the way to the controller. Check cable and baud rate.")]
    LineLost,
    /// The work offset of the controller changed during the session.
    #[error("the controller's work offset changed: someone set it there. Home the machine again.")]
    OffsetChanged,
    /// The guard refused a reply of the controller.
    #[error("stopped: {0}. Find the cause, then home the machine again.")]
    Guard(#[from] Refusal),
    /// The controller entered a state without a command.
    #[error("the controller went to \"{mode}\" by itself: by a button, or a door. Home the machine again.")]
    Unexpected {
        /// The new state.
        mode: Mode,
    },
    /// The port failed.
    #[error("the port was lost: {0}. Check the cable and its plugs.")]
    PortLost(Text),
    /// A command cannot be written in the controller's language.
    #[error("stopped before a motion was sent: {0}")]
    NotSent(EncodeError),
}

impl Fault {
    /// Whether the controller may have lost the position of the tool. The machine must then be homed again.
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

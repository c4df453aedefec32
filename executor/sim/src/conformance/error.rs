//! The errors of a recording.

use std::time::Duration;

use keepout_executor::session::port::PortError;
use keepout_executor::supervisor::Mode;
use keepout_planner::Mm2;
use thiserror::Error;

use super::recording::EVENTS_MAX;

/// Longest time for one step of a scenario.
pub(super) const LIMIT: Duration = Duration::from_secs(60);

/// Why a recording fails.
#[derive(Debug, Error)]
pub enum RecordError {
    /// The port failed.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The dialect has no scenarios.
    #[error("the dialect {name} has no conformance scenarios. Only grbl and grblhal have them.")]
    Dialect {
        /// Its name.
        name: String,
    },
    /// The controller does not answer.
    #[error("the controller does not answer. Check cable, power, port, baud rate and dialect.")]
    Silent,
    /// The controller did not answer a line.
    #[error("the controller does not answer the line {line:?}. Is it the dialect's controller?")]
    Unanswered {
        /// The line.
        line: String,
    },
    /// The controller is not at rest.
    #[error("the controller is not idle: its state is {mode:?}. Home it with --home, or bring it to rest.")]
    NotIdle {
        /// Its state.
        mode: Mode,
    },
    /// Reports carry no machine position.
    #[error("the controller's reports carry no machine position. Set $10=3.")]
    NoPosition,
    /// The unit of reports is unknown.
    #[error("the controller does not state $13. The unit of its reports is unknown, so nothing may move.")]
    Units,
    /// Reports are in inches.
    #[error("the controller reports inches. Set $13=0.")]
    Inches,
    /// The travel is smaller than the box.
    #[error("the box is larger than the machine's travel. Take a smaller box with --box-mm.")]
    SmallTravel,
    /// The box leaves the travel.
    #[error(
        "the box about the tool at ({:.3}, {:.3}) mm leaves the machine's travel. Move the tool to \
         ({:.3}, {:.3}) mm, or take a smaller box with --box-mm.",
        at.x, at.y, inside.x, inside.y
    )]
    BeyondTravel {
        /// The tool's position.
        at: Mm2,
        /// The nearest position where the box fits.
        inside: Mm2,
    },
    /// A scenario has a target outside the box.
    #[error("the scenario \"{scenario}\" leaves the box. No line of it was sent.")]
    OutsideBox {
        /// Its name.
        scenario: String,
    },
    /// The controller did not come to rest.
    #[error(
        "the controller did not come to rest within {} s in \"{scenario}\". Press the emergency stop if it \
         still moves.",
        LIMIT.as_secs()
    )]
    NoRest {
        /// The scenario.
        scenario: String,
    },
    /// The controller raised an alarm.
    #[error("the controller raised an alarm in \"{scenario}\". Home the machine before the next session.")]
    Alarm {
        /// The scenario.
        scenario: String,
    },
    /// The recording is full.
    #[error("more than {EVENTS_MAX} events. Record fewer scenarios.")]
    TooLong,
}

//! Input and output of the supervisor: events, replies, commands.

use arrayvec::ArrayString;
use keepout_guard::{Certified, CertifiedCancel};
use keepout_kernel::{LatticeError, Place};
use keepout_planner::job::{ContourJob, JobError};
use thiserror::Error;

use super::input::{OperatorCommand, OperatorInput};
use super::jog::Limits;

/// A line of text of bounded length. The rest of a longer line is cut off.
pub type Text = ArrayString<80>;

/// The beginning of `text` that fits.
#[must_use]
pub fn text(text: &str) -> Text {
    let mut short = Text::new();
    text.chars().take_while(|&letter| short.try_push(letter).is_ok()).for_each(drop);
    short
}

/// The controller's state, in the terms of the supervisor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// At rest, ready for commands.
    Idle,
    /// In motion: a jog or a contour.
    Moving,
    /// Decelerating for a hold.
    Slowing,
    /// At rest in a hold.
    Held,
    /// Homing.
    Homing,
    /// Locked by an alarm. It needs homing or unlocking.
    Alarm,
    /// Another state: door, check, sleep.
    Other,
}

impl std::fmt::Display for Mode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Idle => "idle",
            Self::Moving => "moving",
            Self::Slowing => "slowing down",
            Self::Held => "hold",
            Self::Homing => "homing",
            Self::Alarm => "alarm",
            Self::Other => "door, check or sleep",
        })
    }
}

/// A status report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// The controller's state.
    pub mode: Mode,
    /// The tool's tip in drawing coordinates. `None` when the report does not state it, or the coordinates
    /// are not known yet.
    pub position: Option<Place>,
    /// Number of motions in the controller's queue. `None` when the report does not state it.
    pub queued: Option<usize>,
    /// Whether the controller has received input that it has not acted on. `None` when the report does not
    /// state it.
    pub waiting: Option<bool>,
}

/// A controller setting with an unsuitable value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unfit {
    /// The controller's name for the setting.
    pub name: &'static str,
    /// The value of the setting.
    pub value: f64,
    /// The required value.
    pub needed: &'static str,
}

/// A decoded message from the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reply {
    /// The controller accepted the oldest motion.
    Accepted,
    /// The controller rejected the oldest line.
    Refused {
        /// The controller's number of the error or alarm.
        code: u16,
        /// Meaning of the number. Empty when it is unknown.
        meaning: &'static str,
        /// Whether the controller can accept a jog again at rest.
        transient: bool,
    },
    /// The controller raised an alarm.
    Alarm {
        /// The controller's number of the error or alarm.
        code: u16,
        /// Meaning of the number. Empty when it is unknown.
        meaning: &'static str,
    },
    /// A status report.
    Report(Report),
    /// The controller is set up. It states these limits.
    Prepared(Limits),
    /// The controller cannot be used with this setting.
    Unfit(Unfit),
    /// The reference position was found.
    Homed,
    /// The modes that motions rely on are set.
    Armed,
    /// The spindle was switched.
    SpindleSwitched,
    /// The controller was reset or switched on.
    Restarted,
    /// The controller does not know the position of its axes.
    NotHomed,
    /// Someone changed the coordinates of the controller.
    Displaced,
    /// A message for the operator. It requires no action.
    Message(Text),
    /// A line that is not in the controller's language.
    Garbled(Text),
}

/// Reason why a command cannot be written in the controller's language. No part of the command is then sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// The language has no words for the spindle.
    #[error("this controller does not switch the spindle: take spindle_rpm out of the machine profile")]
    NoSpindle,
    /// The language has no arcs.
    #[error("this controller has no arcs, but the contour has one: the plan and the dialect do not fit")]
    NoArcs,
    /// No report has carried the work offset, or the position of the axes' zero.
    #[error(
        "the controller has not reported its work offset: \
         connect again, and run `keepout doctor` if this returns"
    )]
    WorkOffsetUnknown,
    /// A target leaves the lattice in machine coordinates.
    #[error(
        "a target lies beyond ±5.37 m in machine coordinates ({0}): check the work offset and the alignment"
    )]
    OffLattice(#[from] LatticeError),
    /// A line is longer than the length that certainly fits the controller's receive buffer.
    #[error("a line of {bytes} bytes is longer than the controller takes")]
    LineTooLong {
        /// Length of the line.
        bytes: usize,
    },
}

/// An event for the supervisor.
#[derive(Debug)]
pub enum Event {
    /// A message from the controller.
    Reply(Reply),
    /// The jog input of this moment.
    Input(OperatorInput),
    /// An operator command.
    Command(OperatorCommand),
    /// Time has passed.
    Tick,
    /// The contouring job that the supervisor requested.
    Job(Box<Result<ContourJob, JobError>>),
    /// The port failed.
    PortLost(Text),
    /// The dialect could not write a command of the last step. It wrote no later command of that step either.
    NotSent(EncodeError),
    /// The port is back.
    PortFound,
}

/// A command to the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Request a status report.
    Query,
    /// Stop jogging, and drop the queued jogs.
    Cancel(CertifiedCancel),
    /// Stop homing. The guard does not certify the motions of homing.
    EndHoming,
    /// Drop the queued motions. It is sent only to a controller that someone else has put on hold.
    Abort,
    /// Read the controller's settings, and set the settings that the session relies on.
    Prepare,
    /// Find the reference position.
    Home,
    /// Set the modes that motions rely on.
    Arm,
    /// Switch the spindle. It is sent only while the machine rests.
    Spindle {
        /// Whether it is to run.
        runs: bool,
    },
    /// A certified motion.
    Move(Certified),
}

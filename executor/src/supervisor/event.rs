//! What goes in and out of the supervisor: events, replies, commands.

use arrayvec::ArrayString;
use keepout_guard::{Certified, CertifiedCancel};
use keepout_kernel::{LatticeError, Point};
use keepout_planner::job::{ContourJob, JobError};
use thiserror::Error;

use super::input::{OperatorCommand, OperatorInput};
use super::jog::Limits;

/// A line of text of bounded length: what does not fit is cut off.
pub type Text = ArrayString<80>;

/// The beginning of `text`, as far as it fits.
#[must_use]
pub fn text(text: &str) -> Text {
    let mut short = Text::new();
    text.chars().take_while(|&letter| short.try_push(letter).is_ok()).for_each(drop);
    short
}

/// The controller's state, as far as the supervisor needs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Stands still, waits for commands.
    Idle,
    /// Moves: jogging, or running a contour.
    Moving,
    /// Slowing down for a hold.
    Slowing,
    /// Stands still, held.
    Held,
    /// Homing.
    Homing,
    /// Locked by an alarm: homing or unlocking needed.
    Alarm,
    /// Something else: door, check, sleep.
    Other,
}

/// A status report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// The controller's state.
    pub mode: Mode,
    /// The tool centre, drawing coordinates; `None` when it is not reported, or the coordinates are not known yet.
    pub position: Option<Point>,
    /// Motions in the controller's queue; `None` when the report does not say.
    pub queued: Option<usize>,
    /// Whether the controller has received something that it has not acted on; `None` when the report does not say.
    pub waiting: Option<bool>,
}

/// What a controller needs to be, and is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unfit {
    /// Its name for the setting.
    pub name: &'static str,
    /// The setting's value.
    pub value: f64,
    /// What is needed.
    pub needed: &'static str,
}

/// A decoded message from the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reply {
    /// The oldest motion is accepted.
    Accepted,
    /// The oldest line is refused.
    Refused {
        /// The controller's number for it.
        code: u16,
        /// What that number means; empty when it is not known.
        meaning: &'static str,
        /// It can be tried again at rest.
        transient: bool,
    },
    /// An alarm.
    Alarm {
        /// The controller's number for it.
        code: u16,
        /// What that number means; empty when it is not known.
        meaning: &'static str,
    },
    /// A status report.
    Report(Report),
    /// The controller is set up; what it says it can do.
    Prepared(Limits),
    /// The controller can not be used as it is.
    Unfit(Unfit),
    /// The reference position was found.
    Homed,
    /// The modes that motions rely on are set.
    Armed,
    /// It was reset, or switched on.
    Restarted,
    /// It does not know where its axes are.
    NotHomed,
    /// Its coordinates were changed by somebody.
    Displaced,
    /// A message worth keeping, nothing to act on.
    Message(Text),
    /// Not of this controller's language.
    Garbled(Text),
}

/// Why a command cannot be written in the controller's language. Nothing of the command is sent then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EncodeError {
    /// The language has no arcs.
    #[error("this controller has no arcs, but the contour has one: the plan and the dialect do not fit")]
    NoArcs,
    /// No report has carried the work offset, or the position of the axes' zero.
    #[error(
        "the controller has not reported its work offset: connect again, and run `keepout doctor` if this returns"
    )]
    WorkOffsetUnknown,
    /// A target leaves the lattice in machine coordinates.
    #[error(
        "a target lies beyond ±5.37 m in machine coordinates ({0}): check the work offset and the alignment"
    )]
    OffLattice(#[from] LatticeError),
    /// A line is longer than the controller's receive buffer holds for certain.
    #[error("a line of {bytes} bytes is longer than the controller takes")]
    LineTooLong {
        /// Its length.
        bytes: usize,
    },
}

/// What happens to the supervisor.
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
    /// The contouring job that the supervisor wanted.
    Job(Box<Result<ContourJob, JobError>>),
    /// The port failed.
    PortLost(Text),
    /// A command of the last step could not be written in the controller's language; nor was any after it.
    NotSent(EncodeError),
    /// The port is back.
    PortFound,
}

/// What the supervisor wants done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Asks for a status report.
    Query,
    /// Stop jogging, and forget jogs that are queued.
    Cancel(CertifiedCancel),
    /// Stop homing: the machine seeks its switches, and no motion of that is certified.
    EndHoming,
    /// Drop the queued motions. It is sent only to a controller that somebody else has put on hold.
    Abort,
    /// Read the controller's settings, and set those that the session relies on.
    Prepare,
    /// Find the reference position.
    Home,
    /// Set the modes that motions rely on.
    Arm,
    /// A certified motion.
    Move(Certified),
}

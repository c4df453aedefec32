//! What goes in and out of the supervisor: events, replies, commands.

use keepout_kernel::Point;

use super::guard::Certified;

/// What the operator wants, as read from a joystick, script or model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wish {
    /// Direction and share of full speed; the length counts up to 1.
    pub direction: (f64, f64),
    /// How far the handwheels were turned since the last wish, mm.
    pub turned_mm: (f64, f64),
    /// Touching the part starts the contour.
    pub automatic: bool,
    /// What is asked for besides.
    pub ask: Option<Ask>,
}

/// What an operator asks for besides steering. It counts when it is first said, and again after a wish without it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Stop where it is; a contour can go on later.
    Pause,
    /// Go on with what was paused.
    Resume,
    /// Begin anew with the controller after a fault, and know where the contour was.
    Recover,
    /// Stop and end the session.
    Quit,
}

impl Wish {
    /// Nothing but the end of the session.
    pub const QUIT: Self =
        Self { direction: (0.0, 0.0), turned_mm: (0.0, 0.0), automatic: false, ask: Some(Ask::Quit) };
}

/// The controller's state, as far as the supervisor needs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Stands still, waits for commands.
    Idle,
    /// Moves: jogging, or running a contour.
    Moving,
    /// Held by a feed hold.
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
    /// The tool centre, drawing coordinates; `None` when the report gives no machine position.
    pub position: Option<Point>,
    /// The work offset, when this report carries it, in machine coordinates.
    pub work_offset: Option<Point>,
    /// Free blocks in the planner, when reported.
    pub free_blocks: Option<usize>,
}

/// A decoded line from the controller.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply {
    /// The oldest line is accepted.
    Ok,
    /// The oldest line is refused.
    Error(u16),
    /// An alarm.
    Alarm(u16),
    /// A status report.
    Report(Report),
    /// A setting, number and value.
    Setting(u16, f64),
    /// The greeting after power-up or reset.
    Greeting(String),
    /// A message worth keeping, nothing to act on.
    Message(String),
    /// Not a line of this controller's language.
    Garbled(String),
}

/// What happens to the supervisor.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A line from the controller.
    Reply(Reply),
    /// The operator's wish of this moment.
    Operator(Wish),
    /// Time has passed.
    Tick,
    /// The port failed.
    PortLost(String),
}

/// What the supervisor wants sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Ask for a status report.
    Query,
    /// Stop a jog.
    Cancel,
    /// Stop a contour, keeping the position.
    Hold,
    /// Reset the controller.
    Reset,
    /// End whatever line the controller may have half of.
    Wake,
    /// Read the controller's settings.
    ReadSettings,
    /// Have planner blocks reported.
    ReportBlocks,
    /// Set how far chords may leave an arc.
    SetArcTolerance {
        /// The tolerance, mm.
        mm: f64,
    },
    /// Set the modes that motions rely on; two lines.
    SetModes,
    /// Find the reference position.
    Home,
    /// A certified motion.
    Move(Certified),
}

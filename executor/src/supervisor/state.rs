//! What the supervisor is doing.

use keepout_kernel::Point;
use keepout_planner::job::{ContourJob, Progress};

use super::event::Text;
use super::fault::Fault;
use super::manual::Steering;

/// What the supervisor is doing; each state carries only its own data.
#[derive(Debug)]
pub(super) enum State {
    /// Waiting for a first report; what came instead is kept for the message.
    Connecting {
        garbled: Option<Text>,
    },
    /// Waiting for the controller to be read and set up.
    Preparing,
    Homing,
    /// Waiting for the modes that motions rely on.
    Arming,
    /// Waiting for a report at rest, with the coordinates known; and for another that agrees, where one may be damaged.
    Locating {
        seen: Option<Point>,
    },
    Manual(Steering),
    /// As by hand, along the wall.
    Sliding(Steering),
    /// The tool stands nearer than the manual threshold: only ways out.
    Escaping(Steering),
    Touching(Touch),
    Contouring(Run),
    /// A contour is stopped, and can go on.
    Holding(Run),
    /// Coming to rest for the end, or for giving up a contour.
    Stopping {
        aborted: bool,
        /// So many reports are still to come that were asked for before.
        stale: usize,
    },
    Done,
    Faulted {
        fault: Fault,
        warned: bool,
    },
}

/// A contour before its first motion.
#[derive(Debug)]
pub(super) enum Touch {
    /// The job was asked for; in place, when the tool stands on a contour that was interrupted.
    Asked { in_place: bool },
    /// It is being certified.
    Certifying(Run),
}

/// A contour under way.
#[derive(Debug)]
pub(super) struct Run {
    /// What it cuts.
    pub(super) job: ContourJob,
    /// For each motion that is sent, which of the job's motions it is of.
    pub(super) sources: Vec<usize>,
    /// What is done when all of it is: worked out before it begins.
    pub(super) done: Progress,
}

impl Run {
    /// What is done when the tool was last seen at `at`, on the sent motion of this number.
    pub(super) fn progress(&self, sent: usize, at: Point) -> Progress {
        let source = self.sources.get(sent).copied();
        match source.and_then(|source| self.job.motion(source)) {
            Some((leg, curve)) => Progress::after(&self.job, leg, curve, at),
            None => self.done.clone(),
        }
    }
}

/// The state's name, for the operator and the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Connecting, reading settings, homing: where the tool is, is not known.
    Starting,
    /// Steered by the operator.
    Manual,
    /// Steered by the operator, along the wall.
    Sliding,
    /// Standing too near: only ways out are allowed.
    Escaping,
    /// Standing at the wall while the contour is worked out and certified.
    Touching,
    /// Contouring by itself.
    Contouring,
    /// A contour is stopped and can go on.
    Holding,
    /// Coming to rest before the end.
    Stopping,
    /// Ended as wanted.
    Done,
    /// Stopped by a fault.
    Faulted,
}

impl Phase {
    /// Whether the operator's hand moves the tool.
    #[must_use]
    pub fn is_steered(self) -> bool {
        matches!(self, Self::Manual | Self::Sliding | Self::Escaping)
    }
}

impl State {
    pub(super) fn phase(&self) -> Phase {
        match self {
            Self::Connecting { .. }
            | Self::Preparing
            | Self::Homing
            | Self::Arming
            | Self::Locating { .. } => Phase::Starting,
            Self::Manual(_) => Phase::Manual,
            Self::Sliding(_) => Phase::Sliding,
            Self::Escaping(_) => Phase::Escaping,
            Self::Touching(_) => Phase::Touching,
            Self::Contouring(_) => Phase::Contouring,
            Self::Holding(_) => Phase::Holding,
            Self::Stopping { .. } => Phase::Stopping,
            Self::Done => Phase::Done,
            Self::Faulted { .. } => Phase::Faulted,
        }
    }
}

//! What the supervisor is doing.

use keepout_kernel::{Curve, Point};
use keepout_planner::job::{ContourJob, Progress};
use serde::{Deserialize, Serialize};

use super::event::Text;
use super::fault::Fault;
use super::jog::JogPlanner;

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
    Manual(JogPlanner),
    /// As by hand, along the wall.
    Sliding(JogPlanner),
    /// The tool stands nearer than the manual threshold: only ways out.
    Escaping(JogPlanner),
    Touching(Touch),
    Contouring(Run),
    /// No more of a contour is sent, and it can go on.
    Holding(Run),
    /// Coming to rest for the end, or for giving up a contour.
    Stopping {
        aborted: bool,
        /// The last report showed rest, with nothing left to do.
        rested: bool,
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
    Certifying(Box<Run>),
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
    /// Where the tool was by the last two reports, the later one behind.
    seen: [Option<Seen>; 2],
}

/// A place of the tool on a contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// The motion that was sent.
    motion: usize,
    /// The square of its distance from where that motion begins, lattice units.
    gone_2: u64,
    at: Point,
}

impl Run {
    pub(super) fn new(job: ContourJob, sources: Vec<usize>, done: Progress) -> Self {
        Self { job, sources, done, seen: [None; 2] }
    }

    /// Takes a place where the tool was reported, on the sent motion of this number.
    pub(super) fn see(&mut self, at: Point, motion: usize, curve: &Curve) {
        let gone = at.minus(curve.from());
        let square = |d: i32| u64::from(d.unsigned_abs()).pow(2);
        self.seen = [self.seen[1], Some(Seen { motion, gone_2: square(gone.dx) + square(gone.dy), at })];
    }

    /// The place that the tool has reached for certain. A report that lost a digit may name one that is still to come, and be
    /// believed: what no second one bears out does not count, here as in [`keepout_guard::Guard::reported`].
    fn reached(&self) -> Option<Seen> {
        let [Some(before), Some(last)] = self.seen else { return None };
        let way = |seen: &Seen| (seen.motion, seen.gone_2);
        Some(if way(&last) < way(&before) { last } else { before })
    }

    /// Which of the job's motions the tool has come to for certain.
    pub(super) fn source(&self) -> usize {
        self.reached().and_then(|seen| self.sources.get(seen.motion).copied()).unwrap_or(0)
    }

    /// What is done for certain; `None` when that is what was done before.
    pub(super) fn progress(&self) -> Option<Progress> {
        let seen = self.reached()?;
        let source = self.sources.get(seen.motion).copied();
        Some(match source.and_then(|source| self.job.motion(source)) {
            Some((leg, curve)) => Progress::after(&self.job, leg, curve, seen.at),
            None => self.done.clone(),
        })
    }
}

/// The state's name, for the operator and the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
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
    /// No more of a contour is sent, and it can go on. The tool may still run to the end of the queued motions.
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

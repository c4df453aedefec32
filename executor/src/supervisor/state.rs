//! The states of the supervisor.
//!
//! Implements SR-23.

use keepout_kernel::{Curve, Place, Point};
use keepout_planner::job::{ContourJob, Progress};
use serde::{Deserialize, Serialize};

use super::event::Text;
use super::fault::Fault;
use super::jog::JogPlanner;

/// A state of the supervisor. Each state carries only its own data.
#[derive(Debug)]
pub(super) enum State {
    /// Waiting for the first report. `garbled` is the last unreadable line, for the message.
    Connecting {
        garbled: Option<Text>,
    },
    /// Waiting until the dialect has read and set up the controller.
    Preparing,
    Homing,
    /// Waiting until the controller has set the modes that motions rely on.
    Arming,
    /// Waiting for a report at rest with a position. Without a checksum, a second report must agree.
    Locating {
        seen: Option<Place>,
    },
    Manual(JogPlanner),
    /// Jogging along the wall.
    Sliding(JogPlanner),
    /// The tool is inside the jogging clearance: only retract moves.
    Retracting(JogPlanner),
    Touching(Touch),
    Contouring(Run),
    /// Feed hold: the supervisor sends no more motions of the contour, and it can go on.
    Holding(Run),
    /// Coming to rest at the end of the session, or after a contour was given up.
    Stopping {
        aborted: bool,
        /// The last report showed the machine at rest, with an empty queue.
        rested: bool,
        /// Number of reports still to come whose queries left before the stop.
        stale: usize,
    },
    Done,
    Faulted {
        fault: Fault,
        warned: bool,
    },
}

impl State {
    /// The jog planner, in the states in which the operator steers the tool.
    pub(super) fn steering(&mut self) -> Option<&mut JogPlanner> {
        match self {
            Self::Manual(planner) | Self::Sliding(planner) | Self::Retracting(planner) => Some(planner),
            _ => None,
        }
    }
}

/// A contour before its first motion.
#[derive(Debug)]
pub(super) enum Touch {
    /// The supervisor requests the job. `in_place`: the tool stands on an interrupted contour.
    Asked { in_place: bool },
    /// The guard certifies the contour.
    Certifying(Box<Run>),
}

/// A contour under way.
#[derive(Debug)]
pub(super) struct Run {
    /// The contouring job.
    pub(super) job: ContourJob,
    /// For each motion as sent, the index of its motion in the job.
    pub(super) sources: Vec<usize>,
    /// Progress after the whole job, computed before the job begins.
    pub(super) done: Progress,
    /// Places of the tool in the last two reports, the later one last.
    seen: [Option<Seen>; 2],
}

/// A place of the tool on a contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// Index of the motion as sent.
    motion: usize,
    /// Square of the distance from the start of that motion, lattice units.
    gone_2: u64,
    at: Point,
}

impl Run {
    pub(super) fn new(job: ContourJob, sources: Vec<usize>, done: Progress) -> Self {
        Self { job, sources, done, seen: [None; 2] }
    }

    /// Takes a reported place of the tool, on the motion with this index.
    pub(super) fn see(&mut self, at: Point, motion: usize, curve: &Curve) {
        let gone = at.minus(curve.from());
        let square = |d: i32| u64::from(d.unsigned_abs()).pow(2);
        self.seen = [self.seen[1], Some(Seen { motion, gone_2: square(gone.dx) + square(gone.dy), at })];
    }

    /// The place that the tool has certainly reached: the less advanced of the last two reported places.
    ///
    /// A report that lost a digit can name a place still ahead, and the guard can accept it. So one report
    /// alone does not count, as in [`keepout_guard::Guard::reported`].
    fn reached(&self) -> Option<Seen> {
        let [Some(before), Some(last)] = self.seen else { return None };
        let way = |seen: &Seen| (seen.motion, seen.gone_2);
        Some(if way(&last) < way(&before) { last } else { before })
    }

    /// Index of the motion in the job that the tool has certainly reached.
    pub(super) fn source(&self) -> usize {
        self.reached().and_then(|seen| self.sources.get(seen.motion).copied()).unwrap_or(0)
    }

    /// The certain progress. `None` before two reports from this contour: the earlier progress then holds.
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
    /// Connecting, reading settings, homing. The position of the tool is unknown.
    Starting,
    /// The operator jogs.
    Manual,
    /// The operator jogs along the wall.
    Sliding,
    /// The tool is inside the jogging clearance: only retract moves are possible. Older logs have the alias.
    #[serde(alias = "escaping")]
    Retracting,
    /// The tool stands at the wall, while Keepout computes and certifies the contour.
    Touching,
    /// The supervisor runs a contour.
    Contouring,
    /// Feed hold: the supervisor sends no more motions of the contour, and it can go on. The tool may still
    /// run to the end of the queued motions.
    Holding,
    /// Coming to rest before the end.
    Stopping,
    /// Ended without a fault.
    Done,
    /// Stopped by a fault.
    Faulted,
}

impl Phase {
    /// The phase in words, after "while".
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::Manual => "jogging",
            Self::Sliding => "jogging along the wall",
            Self::Retracting => "retracting from the part",
            Self::Touching => "planning the contour",
            Self::Contouring => "cutting a contour",
            Self::Holding => "holding in a contour",
            Self::Stopping => "stopping",
            Self::Done => "ending",
            Self::Faulted => "stopped by a fault",
        }
    }

    /// Whether the operator moves the tool in this phase.
    #[must_use]
    pub fn is_steered(self) -> bool {
        matches!(self, Self::Manual | Self::Sliding | Self::Retracting)
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
            Self::Retracting(_) => Phase::Retracting,
            Self::Touching(_) => Phase::Touching,
            Self::Contouring(_) => Phase::Contouring,
            Self::Holding(_) => Phase::Holding,
            Self::Stopping { .. } => Phase::Stopping,
            Self::Done => Phase::Done,
            Self::Faulted { .. } => Phase::Faulted,
        }
    }
}

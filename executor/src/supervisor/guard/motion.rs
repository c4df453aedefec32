//! What the guard hands out, and why it refuses.

use keepout_kernel::offset::Gouge;
use keepout_kernel::{Blocked, Curve, Point};
use thiserror::Error;

/// A motion that the guard has certified. Only the guard makes one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certified {
    pub(super) motion: Motion,
}

/// A motion of the tool centre, in drawing coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Straight from wherever the tool is; can be cancelled.
    Jog {
        /// The target.
        to: Point,
        /// Feed, mm/min.
        feed_mm_min: u32,
    },
    /// The next motion of a contour.
    Contour {
        /// The line or arc, beginning where the one before ended.
        curve: Curve,
        /// Feed, mm/min.
        feed_mm_min: u32,
    },
}

impl Certified {
    /// A motion that nobody certified, for tests of what becomes of it.
    #[cfg(test)]
    pub(crate) fn for_test(motion: Motion) -> Self {
        Self { motion }
    }

    /// The motion.
    #[must_use]
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Where it ends.
    #[must_use]
    pub fn target(&self) -> Point {
        match &self.motion {
            Motion::Jog { to, .. } => *to,
            Motion::Contour { curve, .. } => curve.to(),
        }
    }
}

/// A cancel that the guard has certified. Only the guard makes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CertifiedCancel {
    certified: (),
}

impl CertifiedCancel {
    pub(super) const fn new() -> Self {
        Self { certified: () }
    }
}

/// Why the guard refuses.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Refusal {
    /// The part is in the way.
    #[error("{0}")]
    Blocked(Blocked),
    /// A motion of a contour comes too near the part.
    #[error("{0}")]
    Gouge(Gouge),
    /// The target is beyond the machine's travel.
    #[error("{} is beyond the machine's travel", keepout_planner::units::place(*.0))]
    BeyondStroke(Point),
    /// Where the tool is, is not known.
    #[error("where the tool is, is not known")]
    PositionUnknown,
    /// The tool stands nearer to the part than this needs.
    #[error("the tool stands nearer to the part than that needs")]
    StandsInside,
    /// The tool is clear of the part: there is nothing to escape from.
    #[error("the tool is clear of the part")]
    StandsClear,
    /// The tool is moving, or may be about to.
    #[error("motions are still under way")]
    InMotion,
    /// More targets in flight than are tracked.
    #[error("too many motions are under way")]
    Full,
    /// Jogs can not be cancelled here.
    #[error("this controller can not cancel a jog")]
    NoCancel,
    /// A cancel was sent, and nothing shows yet that it has been executed.
    #[error("a cancel is already on its way")]
    Cancelled,
    /// A cancel may lead the tool off its path, and how far is not known.
    #[error("how far the tool goes on after a cancel is not known")]
    StoppingUnknown,
    /// The motion is no longer than a step or two of the controller.
    #[error("the motion is shorter than the controller resolves")]
    TooShort,
    /// The axes of this controller run apart, and the motion is not along one of them.
    #[error("this controller's axes run apart: a motion from {} must be along one of them", keepout_planner::units::place(*.0))]
    Slanted(Point),
    /// An arc so short that a controller can take it for a full circle.
    #[error("an arc at {} is too short for the controller to tell from a full circle", keepout_planner::units::place(*.0))]
    ArcTooShort(Point),
    /// An arc that turns by more than a quarter: the radius alone would not tell its centre well.
    #[error("an arc at {} turns by more than a quarter: send it in pieces", keepout_planner::units::place(*.0))]
    ArcTooLong(Point),
    /// An acknowledgement that belongs to no line.
    #[error("the controller acknowledged a line that was not sent")]
    UnexpectedAcknowledgement,
    /// The reported position lies outside everything that was certified.
    #[error("the tool is reported at {}, where nothing was sent to", keepout_planner::units::place(*.0))]
    OffCertified(Point),
    /// The controller rests short of the end of a contour's motion.
    #[error("the tool rests at {}, before the end of a motion of the contour: the controller dropped it", keepout_planner::units::place(*.0))]
    Dropped(Point),
}

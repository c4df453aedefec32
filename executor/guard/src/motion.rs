//! What the guard hands out, and why it refuses.

use core::fmt;

use keepout_kernel::offset::Gouge;
use keepout_kernel::{Blocked, Curve, Point};

/// A motion that the guard has certified. Only the guard makes one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certified {
    pub(crate) motion: Motion,
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
    pub(crate) const fn new() -> Self {
        Self { certified: () }
    }
}

/// Why the guard refuses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// The part is in the way.
    Blocked(Blocked),
    /// A motion of a contour comes too near the part.
    Gouge(Gouge),
    /// The target is beyond the machine's travel.
    SoftLimit(Point),
    /// Where the tool is, is not known.
    PositionUnknown,
    /// The tool stands nearer to the part than this needs.
    InsideJoggingClearance,
    /// The tool is clear of the part: there is nothing to retract from.
    ClearOfPart,
    /// The tool is moving, or may be about to.
    InMotion,
    /// More targets in flight than are tracked.
    Full,
    /// Jogs can not be cancelled here.
    NoCancel,
    /// A cancel was sent, and nothing shows yet that it has been executed.
    Cancelled,
    /// A cancel may lead the tool off its path, and how far is not known.
    StoppingUnknown,
    /// The motion is no longer than a step or two of the controller.
    TooShort,
    /// The axes of this controller run apart, and the motion is not along one of them.
    Slanted(Point),
    /// An arc so short that a controller can take it for a full circle.
    ArcTooShort(Point),
    /// An arc that turns by more than a quarter: the radius alone would not tell its centre well.
    ArcTooLong(Point),
    /// An acknowledgement that belongs to no line.
    UnexpectedAcknowledgement,
    /// The reported position lies outside everything that was certified.
    OffCertified(Point),
    /// The controller rests short of the end of a contour's motion.
    Dropped(Point),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blocked(by) => by.fmt(f),
            Self::Gouge(by) => by.fmt(f),
            Self::SoftLimit(at) => write!(f, "{at} is beyond the machine's travel"),
            Self::PositionUnknown => f.write_str("where the tool is, is not known"),
            Self::InsideJoggingClearance => f.write_str("the tool stands nearer to the part than that needs"),
            Self::ClearOfPart => f.write_str("the tool is clear of the part"),
            Self::InMotion => f.write_str("motions are still under way"),
            Self::Full => f.write_str("too many motions are under way"),
            Self::NoCancel => f.write_str("this controller can not cancel a jog"),
            Self::Cancelled => f.write_str("a cancel is already on its way"),
            Self::StoppingUnknown => f.write_str("how far the tool goes on after a cancel is not known"),
            Self::TooShort => f.write_str("the motion is shorter than the controller resolves"),
            Self::Slanted(at) => {
                write!(f, "this controller's axes run apart: a motion from {at} must be along one of them")
            }
            Self::ArcTooShort(at) => {
                write!(f, "an arc at {at} is too short for the controller to tell from a full circle")
            }
            Self::ArcTooLong(at) => {
                write!(f, "an arc at {at} turns by more than a quarter: send it in pieces")
            }
            Self::UnexpectedAcknowledgement => {
                f.write_str("the controller acknowledged a line that was not sent")
            }
            Self::OffCertified(at) => write!(f, "the tool is reported at {at}, where nothing was sent to"),
            Self::Dropped(at) => write!(
                f,
                "the tool rests at {at}, before the end of a motion of the contour: the controller dropped it"
            ),
        }
    }
}

impl core::error::Error for Refusal {}

//! Certified motions and cancels, and the reasons for a refusal.
//!
//! Implements SR-24.

use core::fmt;

use keepout_kernel::offset::Gouge;
use keepout_kernel::{Blocked, Curve, Height, Place, Point};

/// A certified motion. Only the guard makes one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certified {
    pub(crate) motion: Motion,
}

/// A motion of the tool's tip, in drawing coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// A jog from the current position. It can be cancelled.
    Jog {
        /// The target.
        to: Place,
        /// The feed, mm/min.
        feed_mm_min: u32,
    },
    /// The next motion of a contour.
    Contour {
        /// The line or arc. It begins where the one before it ended.
        curve: Curve,
        /// The heights at its start and at its end. The height changes evenly along the curve.
        heights: [Height; 2],
        /// The feed, mm/min.
        feed_mm_min: u32,
    },
}

/// A feed override that only slows: 25 to 100 per cent of the feed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeedOverride(u8);

impl Default for FeedOverride {
    fn default() -> Self {
        Self::FULL
    }
}

impl FeedOverride {
    /// Least override, per cent. The longest motion of a contour lasts four times as long then, and so does a feed
    /// hold.
    pub const LEAST: u8 = 25;
    /// The planned feed.
    pub const FULL: Self = Self(100);

    /// The override of these per cent, or the nearest one.
    #[must_use]
    pub fn of_percent(percent: u8) -> Self {
        Self(percent.clamp(Self::LEAST, 100))
    }

    /// The override, per cent.
    #[must_use]
    pub const fn percent(self) -> u8 {
        self.0
    }

    /// The feed under this override, mm/min: never faster, and never zero unless the feed is.
    #[must_use]
    pub fn of(self, feed_mm_min: u32) -> u32 {
        let slowed = u64::from(feed_mm_min) * u64::from(self.0) / 100;
        u32::try_from(slowed).unwrap_or(feed_mm_min).max(1).min(feed_mm_min)
    }
}

impl Certified {
    /// The same motion under a feed override. The certificate of a contour's motion does not depend on its feed, since
    /// it is never cancelled. A jog stays as it is, because the reach of its cancel follows from its feed.
    #[must_use]
    pub fn slowed(self, feed: FeedOverride) -> Self {
        let motion = match self.motion {
            Motion::Contour { curve, heights, feed_mm_min } => {
                Motion::Contour { curve, heights, feed_mm_min: feed.of(feed_mm_min) }
            }
            jog @ Motion::Jog { .. } => jog,
        };
        Self { motion }
    }

    /// The motion.
    #[must_use]
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// The end point.
    #[must_use]
    pub fn target(&self) -> Place {
        match &self.motion {
            Motion::Jog { to, .. } => *to,
            Motion::Contour { curve, heights, .. } => curve.to().at_height(heights[1]),
        }
    }
}

/// A certified cancel. Only the guard makes one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CertifiedCancel {
    certified: (),
}

impl CertifiedCancel {
    pub(crate) const fn new() -> Self {
        Self { certified: () }
    }
}

/// Why the guard refuses a motion, a cancel or a reply of the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// The part is in the way.
    Blocked(Blocked),
    /// A motion of a contour comes too near the part.
    Gouge(Gouge),
    /// The target is beyond the machine's travel.
    SoftLimit(Point),
    /// The target is above or below the machine's travel.
    HeightLimit(Height),
    /// The motion lowers the tool inside the jogging clearance.
    LowersNearPart(Height),
    /// The motion does not raise the tool.
    NoRise(Height),
    /// The position of the tool is unknown, or there is no contour to run.
    PositionUnknown,
    /// The tool is inside the jogging clearance, and this motion or cancel needs it outside.
    InsideJoggingClearance,
    /// The tool is outside the jogging clearance: a retract move is not needed.
    ClearOfPart,
    /// The tool moves or may still start to move, or a contour is running.
    InMotion,
    /// The set of motions in flight is full, or the controller may not have read the last line yet.
    Full,
    /// The controller cannot cancel jogs.
    NoCancel,
    /// A cancel is in flight: the controller has not yet confirmed its execution.
    Cancelled,
    /// A cancel may lead the tool off its path, and the stopping distance is unknown.
    StoppingUnknown,
    /// The motion is shorter than a step or two of the controller.
    TooShort,
    /// The controller does not interpolate its axes, and the motion is an arc or not along one axis.
    Slanted(Point),
    /// The arc is so short that a controller can take it for a full circle.
    ArcTooShort(Point),
    /// The arc turns by more than a quarter circle. Its radius alone would not fix its centre accurately.
    ArcTooLong(Point),
    /// The controller acknowledged a line although no line is unacknowledged.
    UnexpectedAcknowledgement,
    /// The position feedback lies outside every certified motion, or a contour does not begin at the tool.
    OffCertified(Point),
    /// The controller stopped short of the end of a contour motion.
    Dropped(Point),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blocked(by) => by.fmt(f),
            Self::Gouge(by) => by.fmt(f),
            Self::SoftLimit(at) => write!(f, "{at} is beyond the machine's travel"),
            Self::HeightLimit(height) => write!(f, "height {height} is beyond the machine's travel"),
            Self::LowersNearPart(height) => {
                write!(f, "the tool is inside the jogging clearance and must not be lowered to {height}")
            }
            Self::NoRise(height) => write!(f, "height {height} does not raise the tool"),
            Self::PositionUnknown => f.write_str("the position of the tool is unknown"),
            Self::InsideJoggingClearance => f.write_str("the tool is inside the jogging clearance"),
            Self::ClearOfPart => f.write_str("the tool is clear of the part: a retract move is not needed"),
            Self::InMotion => f.write_str("motions are still in progress"),
            Self::Full => f.write_str("too many motions are in progress"),
            Self::NoCancel => f.write_str("this controller cannot cancel a jog"),
            Self::Cancelled => f.write_str("a cancel is already on its way"),
            Self::StoppingUnknown => f.write_str("the stopping distance after a cancel is unknown"),
            Self::TooShort => f.write_str("the motion is shorter than the controller resolves"),
            Self::Slanted(at) => {
                write!(
                    f,
                    "this controller does not interpolate its axes: \
                     the motion from {at} must be along one axis"
                )
            }
            Self::ArcTooShort(at) => {
                write!(f, "the arc at {at} is too short: the controller can take it for a full circle")
            }
            Self::ArcTooLong(at) => {
                write!(f, "the arc at {at} turns by more than a quarter circle: split it")
            }
            Self::UnexpectedAcknowledgement => {
                f.write_str("the controller acknowledged a line that was not sent")
            }
            Self::OffCertified(at) => write!(f, "position feedback {at} lies outside every certified motion"),
            Self::Dropped(at) => write!(
                f,
                "the tool stopped at {at}, short of the end of a contour motion: \
                 the controller dropped that motion"
            ),
        }
    }
}

impl core::error::Error for Refusal {}

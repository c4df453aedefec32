//! TRUSTED. The rules of one session: travel, clearances, and how the controller moves.
//!
//! Implements SR-13, SR-15.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Height, Length};

use crate::OnCancel;

/// How a controller drives to a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Interpolated axes: the tool drives straight to the target. The feed is its greatest speed.
    Linear,
    /// Non-interpolated axes: the tool can be anywhere in the box between start and target. The feed is the
    /// greatest speed of each axis.
    Independent,
}

/// Rules that the guard applies to every motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Permitted window of the tool centre: the machine's travel.
    pub travel: Window,
    /// Jogging clearance: the guard certifies jogs at this distance from the part.
    pub jogging_clearance: Length,
    /// Finishing clearance: the guard certifies contours at this distance, in the motions that are sent.
    pub finishing_clearance: Length,
    /// Greatest distance of a reported position from the commanded position.
    pub resolution: Length,
    /// Least length of a jog along one of the axes: at least two steps. The controller might not queue a
    /// shorter jog, and the count of its queue would then be wrong.
    pub shortest: Length,
    /// How the controller drives to the target of a jog, cancelled or not.
    pub interpolation: Interpolation,
    /// Behaviour of the tool when a jog is cancelled.
    pub on_cancel: OnCancel,
    /// How the controller drives the motions of a contour. The guard never cancels them, so they can be
    /// linear although `interpolation` is independent.
    pub contours: Interpolation,
    /// Whether a checksum protects the line in both directions.
    pub checked: bool,
    /// The third axis.
    pub heights: HeightRules,
}

/// Rules for the height of the tool's tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeightRules {
    /// Lowest permitted height.
    pub lowest: Height,
    /// Greatest permitted height.
    pub highest: Height,
    /// Height margin: how far the tip can be below its commanded height. The guard certifies a tip lower by
    /// this much.
    pub margin: Length,
    /// Greatest distance of a reported height from the commanded height.
    pub resolution: Length,
    /// Least change of height that the controller queues for certain: at least two steps.
    pub shortest: Length,
}

impl HeightRules {
    /// A machine with two axes: the tool stands at height zero.
    pub const TWO_AXES: Self = Self {
        lowest: Height::ZERO,
        highest: Height::ZERO,
        margin: Length::ZERO,
        resolution: Length::ZERO,
        shortest: Length::ZERO,
    };

    /// Whether the height is permitted.
    #[must_use]
    pub fn permit(&self, height: Height) -> bool {
        self.lowest <= height && height <= self.highest
    }

    /// The lowest place of a tip that is commanded to this height: the guard certifies for this tip.
    #[must_use]
    pub fn certified_for(&self, height: Height) -> Height {
        height.lowered(self.margin)
    }

    /// Whether two heights differ by at most `count` resolutions.
    pub(crate) fn agree(&self, one: Height, other: Height, count: i64) -> bool {
        let apart = (i64::from(one.units()) - i64::from(other.units())).abs();
        apart <= i64::from(self.resolution.units()) * count
    }
}

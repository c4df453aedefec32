//! TRUSTED. The rules of one session: travel, clearances, and how the controller moves.

use keepout_kernel::Length;
use keepout_kernel::exact::segment::Window;

use crate::{Interpolation, OnCancel};

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
}

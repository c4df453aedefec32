//! The abilities of a controller.

use keepout_guard::{Interpolation, OnCancel};

/// The abilities of a dialect's controller that matter to the supervisor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abilities {
    /// How the controller drives to the target of a jog, cancelled or not.
    pub interpolation: Interpolation,
    /// How the controller drives the motions of a contour, which are never cancelled.
    pub contours: Interpolation,
    /// Whether the controller drives arcs.
    pub arcs: bool,
    /// Whether the controller takes motions while it moves, and joins them.
    pub queues: bool,
    /// The behaviour on a cancel that the dialect states. A measurement of the controller can weaken it.
    pub on_cancel: OnCancel,
    /// Whether a checksum protects the line in both directions.
    pub checked: bool,
    /// Whether the session switches the spindle: the dialect can, and the machine profile says so.
    pub spindle: bool,
}

impl Abilities {
    /// Whether a jog can be cancelled.
    #[must_use]
    pub fn cancels(&self) -> bool {
        self.on_cancel != OnCancel::NotOffered
    }
}

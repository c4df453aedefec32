//! What a controller can do.

use keepout_guard::{Interpolation, OnCancel};

/// What a dialect's controller can do, as far as the supervisor needs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abilities {
    /// How it drives to a jog's target, cancelled under way or not.
    pub interpolation: Interpolation,
    /// How it drives the motions of a contour, which are never cancelled.
    pub contours: Interpolation,
    /// It drives arcs.
    pub arcs: bool,
    /// It takes motions while it moves, and joins them.
    pub queues: bool,
    /// What a cancel does to a jog under way, as long as nothing more is known of the controller.
    pub on_cancel: OnCancel,
    /// A checksum protects the line both ways.
    pub checked: bool,
}

impl Abilities {
    /// Whether jogs can be stopped under way.
    #[must_use]
    pub fn cancels(&self) -> bool {
        self.on_cancel != OnCancel::NotOffered
    }
}

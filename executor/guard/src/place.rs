//! TRUSTED. A free point with the height of the tip there.
//!
//! Implements SR-07, SR-13.

use keepout_kernel::{FreePoint, Height, Length, Place, Point};

/// A certified point, and the height of the tool's tip there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FreePlace {
    pub(crate) free: FreePoint,
    pub(crate) height: Height,
}

impl FreePlace {
    /// The certified point.
    #[must_use]
    pub fn free(self) -> FreePoint {
        self.free
    }

    /// The point of the plane.
    #[must_use]
    pub fn point(self) -> Point {
        self.free.point()
    }

    /// The threshold at which the point is clear.
    #[must_use]
    pub fn threshold(self) -> Length {
        self.free.threshold()
    }

    /// The height of the tip.
    #[must_use]
    pub fn height(self) -> Height {
        self.height
    }

    /// The place.
    #[must_use]
    pub fn place(self) -> Place {
        self.point().at_height(self.height)
    }
}

//! The clearance index: it finds the edges that a query must test, and stores known answers for a fixed
//! threshold.
//!
//! Implements SR-01, SR-03.
//!
//! [`build`](mod@build) proposes bounding boxes over blocks of consecutive edges. [`check`] accepts them
//! after exact comparisons and returns a [`CheckedIndex`]. All safety queries use a [`CheckedIndex`].
//! [`Cells`] is an accelerator for one threshold: squares of the plane that are certified free, blocked, or
//! near to a few named edges only. [`nearest`](mod@nearest) proposes, in `f64`.

pub mod build;
pub mod cells;
pub mod check;
pub mod nearest;
pub mod query;
pub mod subdivide;

pub use cells::{CellFault, Cells};
pub use check::{CheckedIndex, IndexFault};
pub use nearest::Nearest;

use crate::exact::convex::Convex;
use crate::exact::lattice::{Length, Point};
use crate::exact::predicate::Proximity;
use crate::exact::segment::{Segment, Triangle, Window};

/// One edge of the profile: a chord and its chord-error bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The chord.
    pub chord: Segment,
    /// Bound on the distance between the true curve and the chord.
    pub chord_error: Length,
}

impl Edge {
    /// The bounding box of the chord, grown by the chord error.
    #[must_use]
    #[inline]
    pub fn bounds(&self) -> Window {
        self.chord.bounds().grown(self.chord_error)
    }

    /// Whether the chord comes within `threshold` plus chord error of `point`.
    #[must_use]
    #[inline]
    pub fn near_point(&self, point: Point, threshold: Length) -> Proximity {
        self.at(threshold, |r| self.chord.near_point(point, r))
    }

    /// Whether the chord comes within `threshold` plus chord error of the straight motion.
    #[must_use]
    #[inline]
    pub fn near_motion(&self, motion: Segment, threshold: Length) -> Proximity {
        self.at(threshold, |r| motion.near_segment(self.chord, r))
    }

    /// Whether the chord comes within `threshold` plus chord error of the filled triangle.
    #[must_use]
    #[inline]
    pub fn near_triangle(&self, triangle: Triangle, threshold: Length) -> Proximity {
        self.at(threshold, |r| triangle.near_segment(self.chord, r))
    }

    /// Whether the chord comes within `threshold` plus chord error of the filled polygon.
    #[must_use]
    #[inline]
    pub fn near_convex(&self, polygon: Convex<'_>, threshold: Length) -> Proximity {
        self.at(threshold, |r| polygon.near_segment(self.chord, r))
    }

    /// Whether the chord comes within `threshold` plus chord error of the box, clipped at the limits of the
    /// lattice.
    #[must_use]
    #[inline]
    pub fn near_box(&self, window: Window, threshold: Length) -> Proximity {
        self.at(threshold, |r| window.near_segment(self.chord, r))
    }

    /// Whether every point of the box, clipped at the limits of the lattice, is within `threshold` plus chord
    /// error of the chord.
    #[must_use]
    pub fn reaches_all(&self, window: Window, threshold: Length) -> bool {
        threshold.plus(self.chord_error).is_ok_and(|r| window.within_reach_of(self.chord, r))
    }

    /// The answer of `ask` for the threshold plus the chord error. A sum beyond the lattice counts as near.
    #[inline(always)]
    fn at(&self, threshold: Length, ask: impl Fn(Length) -> Proximity) -> Proximity {
        threshold.plus(self.chord_error).map_or(Proximity::Near, ask)
    }
}

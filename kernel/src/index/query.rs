//! TRUSTED: the threshold queries over a checked index. Each answer is exact over all edges.
//!
//! Implements SR-03, SR-14.
//!
//! The box of an edge includes its chord error. If the chord comes within a threshold T plus its chord error
//! of a shape, the edge's box meets the box of the shape grown by T. [`CheckedIndex::search`] omits no such
//! edge.
//!
//! Two more rules skip a box. Both grow the box by T first. The grown box holds every point within T of the
//! edges in it. A query along a motion skips the box if it lies wholly on one side of the motion's line. A
//! query around a polygon skips the box if it lies wholly beyond one side of the polygon.

#![deny(clippy::arithmetic_side_effects, clippy::as_conversions, clippy::float_arithmetic)]

use core::ops::ControlFlow;

use super::Edge;
use super::check::{CheckedIndex, Node, Search};
use crate::exact::convex::Convex;
use crate::exact::lattice::{Length, Point};
use crate::exact::predicate::{Orientation, Proximity, ray_crosses};
use crate::exact::region::Location;
use crate::exact::segment::{Segment, Triangle, Window};
use crate::exact::width::Product;

impl CheckedIndex {
    /// An edge within `threshold` of `point`, or `None`.
    #[must_use]
    pub fn near_point(&self, point: Point, threshold: Length) -> Option<&Edge> {
        self.first(Window::of(point).grown(threshold), |edge| edge.near_point(point, threshold))
    }

    /// An edge within `threshold` of the straight motion, or `None`.
    #[must_use]
    pub fn near_motion(&self, motion: Segment, threshold: Length) -> Option<&Edge> {
        let mut near = None;
        let _ = self.along(motion, threshold, |index, edge| match edge.near_motion(motion, threshold) {
            Proximity::Clear => ControlFlow::Continue(()),
            Proximity::Near => {
                near = self.edges().get(index);
                ControlFlow::Break(())
            }
        });
        near
    }

    /// An edge within `threshold` of the filled triangle, or `None`.
    #[must_use]
    pub fn near_triangle(&self, triangle: Triangle, threshold: Length) -> Option<&Edge> {
        self.first(triangle.bounds().grown(threshold), |edge| edge.near_triangle(triangle, threshold))
    }

    /// An edge within `threshold` of the filled convex polygon, or `None`.
    #[must_use]
    pub fn near_convex(&self, polygon: Convex<'_>, threshold: Length) -> Option<&Edge> {
        let mut search = Around { polygon, window: polygon.bounds().grown(threshold), threshold, near: None };
        let _ = self.search(&mut search);
        search.near.and_then(|near| self.edges().get(near))
    }

    /// An edge within `threshold` of the box, clipped at the limits of the lattice, or `None`.
    #[must_use]
    pub fn near_box(&self, window: Window, threshold: Length) -> Option<&Edge> {
        self.first(window.grown(threshold), |edge| edge.near_box(window, threshold))
    }

    /// An edge that the motion approaches, or `None`. The motion comes within `threshold` of the edge, and
    /// the distance to its chord falls somewhere on the motion.
    #[must_use]
    pub fn approached(&self, motion: Segment, threshold: Length) -> Option<&Edge> {
        self.first(motion.bounds().grown(threshold), |edge| {
            if motion.retracts_from(edge.chord) {
                Proximity::Clear
            } else {
                edge.near_motion(motion, threshold)
            }
        })
    }

    /// The location of `point`. It is on the boundary if a chord contains it. Otherwise it is inside if the
    /// ray from it toward +x crosses an odd number of chords.
    #[must_use]
    pub fn locate(&self, point: Point) -> Location {
        let (x, y, ..) = Window::of(point).corners();
        let mut on_chord = false;
        let mut odd = false;
        let _ = self.visit(Window::from_corners(x, y, i32::MAX, y), |_, edge| {
            let chord = edge.chord;
            on_chord |= !chord.near_point(point, Length::ZERO).is_clear();
            odd ^= ray_crosses::<Product>(point.into(), chord.from.into(), chord.to.into());
            ControlFlow::Continue(())
        });
        match (on_chord, odd) {
            (true, _) => Location::Boundary,
            (false, true) => Location::Inside,
            (false, false) => Location::Outside,
        }
    }

    /// Visits every edge that can come within `threshold` of the motion, until `visit` breaks. It may visit
    /// other edges too.
    #[inline]
    pub fn along(
        &self,
        motion: Segment,
        threshold: Length,
        visit: impl FnMut(usize, &Edge) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let window = motion.bounds().grown(threshold);
        self.search(&mut Along { motion, window, threshold, visit })
    }

    #[inline]
    pub(crate) fn first(&self, window: Window, ask: impl Fn(&Edge) -> Proximity) -> Option<&Edge> {
        let mut near = None;
        let _ = self.visit(window, |index, edge| match ask(edge) {
            Proximity::Clear => ControlFlow::Continue(()),
            Proximity::Near => {
                near = self.edges().get(index);
                ControlFlow::Break(())
            }
        });
        near
    }
}

struct Along<F> {
    motion: Segment,
    window: Window,
    threshold: Length,
    visit: F,
}

impl<F: FnMut(usize, &Edge) -> ControlFlow<()>> Search for Along<F> {
    #[inline(always)]
    fn enter(&mut self, node: &Node) -> u8 {
        let mut lanes = node.meeting(self.window);
        let mut rest = lanes;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            rest &= rest.wrapping_sub(1);
            let Some(window) = node.window(lane).map(|window| window.grown(self.threshold)) else { continue };
            if window.side_of(self.motion) != Orientation::On {
                lanes &= !(1_u8 << (lane & 7));
            }
        }
        lanes
    }

    #[inline(always)]
    fn edge(&mut self, index: usize, edge: &Edge) -> ControlFlow<()> {
        (self.visit)(index, edge)
    }
}

struct Around<'a> {
    polygon: Convex<'a>,
    window: Window,
    threshold: Length,
    near: Option<usize>,
}

impl Search for Around<'_> {
    #[inline(always)]
    fn enter(&mut self, node: &Node) -> u8 {
        let mut lanes = node.meeting(self.window);
        let mut rest = lanes;
        while rest != 0 {
            let lane = rest.trailing_zeros();
            rest &= rest.wrapping_sub(1);
            let Some(window) = node.window(lane).map(|window| window.grown(self.threshold)) else { continue };
            if self.polygon.sides().any(|side| window.side_of(side) == Orientation::Right) {
                lanes &= !(1_u8 << (lane & 7));
            }
        }
        lanes
    }

    #[inline(always)]
    fn edge(&mut self, index: usize, edge: &Edge) -> ControlFlow<()> {
        if edge.near_convex(self.polygon, self.threshold).is_clear() {
            return ControlFlow::Continue(());
        }
        self.near = Some(index);
        ControlFlow::Break(())
    }
}

//! Segments and triangles of the lattice, and their distance tests against a threshold.
//!
//! Implements SR-01, SR-03.

use super::lattice::{COORD_MAX, Length, Point};
use super::predicate::{self, Site};
pub use super::predicate::{Orientation, Proximity};
use super::width::Product;

impl From<Point> for Site<Product> {
    fn from(point: Point) -> Self {
        Self { x: point.x.units(), y: point.y.units() }
    }
}

impl From<Segment> for [Site<Product>; 2] {
    fn from(segment: Segment) -> Self {
        [segment.from.into(), segment.to.into()]
    }
}

/// The side of the directed line `a → b` on which `c` lies.
#[must_use]
#[inline]
pub fn orientation(a: Point, b: Point, c: Point) -> Orientation {
    predicate::orientation::<Product>(a.into(), b.into(), c.into())
}

/// Whether `|p − q| ≤ r`.
#[must_use]
pub fn points_within(p: Point, q: Point, r: Length) -> Proximity {
    predicate::point_point::<Product>(p.into(), q.into(), r.units())
}

/// A straight line between two lattice points. Its length may be zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// The start point.
    pub from: Point,
    /// The end point.
    pub to: Point,
}

impl Segment {
    /// Whether some point of the segment is within `r` of `point`.
    #[must_use]
    #[inline]
    pub fn near_point(self, point: Point, r: Length) -> Proximity {
        predicate::point_segment::<Product>(point.into(), self.from.into(), self.to.into(), r.units())
    }

    /// Whether the two segments come within `r` of each other.
    #[must_use]
    #[inline]
    pub fn near_segment(self, other: Self, r: Length) -> Proximity {
        predicate::segment_segment::<Product>(self.into(), other.into(), r.units())
    }

    /// Whether the segments share at least one point.
    #[must_use]
    #[inline]
    pub fn touches(self, other: Self) -> bool {
        // Shortcut for most pairs: both ends of `other` lie strictly on one side.
        let side = orientation(self.from, self.to, other.from);
        if side != Orientation::On && side == orientation(self.from, self.to, other.to) {
            return false;
        }
        !self.near_segment(other, Length::ZERO).is_clear()
    }

    /// Whether the distance to `wall` never falls on the motion along this segment.
    #[must_use]
    #[inline]
    pub fn retracts_from(self, wall: Self) -> bool {
        predicate::retract::<Product>(self.from.into(), self.to.into(), wall.from.into(), wall.to.into())
    }

    /// The bounding box of the segment.
    #[must_use]
    #[inline]
    pub fn bounds(self) -> Window {
        Window::of(self.from).including(self.to)
    }
}

/// A filled triangle: the area that the tool can sweep when a machine takes a new target in mid-motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// The three corners, in any order; the triangle may be degenerate.
    pub corners: [Point; 3],
}

impl Triangle {
    /// Whether the filled triangle and the segment come within `r` of each other.
    #[must_use]
    #[inline]
    pub fn near_segment(self, segment: Segment, r: Length) -> Proximity {
        let corners = self.corners.map(Site::from);
        predicate::triangle_segment::<Product>(corners, segment.into(), r.units())
    }

    /// The bounding box of the triangle.
    #[must_use]
    #[inline]
    pub fn bounds(self) -> Window {
        let [a, b, c] = self.corners;
        Window::of(a).including(b).including(c)
    }
}

/// A closed axis-aligned box in lattice units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    min_x: i32,
    min_y: i32,
    max_x: i32,
    max_y: i32,
}

impl Window {
    /// The box with these corners, in lattice units; empty when a minimum exceeds its maximum.
    #[must_use]
    #[inline]
    pub const fn from_corners(min_x: i32, min_y: i32, max_x: i32, max_y: i32) -> Self {
        Self { min_x, min_y, max_x, max_y }
    }

    /// The box that holds one point.
    #[must_use]
    #[inline]
    pub fn of(point: Point) -> Self {
        let (x, y) = (point.x.units(), point.y.units());
        Self { min_x: x, min_y: y, max_x: x, max_y: y }
    }

    /// The smallest box that holds this box and `point`.
    #[must_use]
    #[inline]
    pub fn including(self, point: Point) -> Self {
        self.union(Self::of(point))
    }

    /// The smallest box that holds both boxes.
    #[must_use]
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self {
            min_x: self.min_x.min(other.min_x),
            min_y: self.min_y.min(other.min_y),
            max_x: self.max_x.max(other.max_x),
            max_y: self.max_y.max(other.max_y),
        }
    }

    /// The intersection of two boxes. It is empty when they share no point.
    #[must_use]
    pub fn common(self, other: Self) -> Self {
        Self {
            min_x: self.min_x.max(other.min_x),
            min_y: self.min_y.max(other.min_y),
            max_x: self.max_x.min(other.max_x),
            max_y: self.max_y.min(other.max_y),
        }
    }

    /// The box grown by `r` on every side. A point outside the grown box is farther than `r` from every point
    /// of the box.
    #[must_use]
    #[inline]
    pub fn grown(self, r: Length) -> Self {
        // |c| ≤ 2^29 and r ≤ 2^29. Repeated growth saturates at the limits of `i32`, beyond the lattice.
        Self {
            min_x: self.min_x.saturating_sub(r.units()),
            min_y: self.min_y.saturating_sub(r.units()),
            max_x: self.max_x.saturating_add(r.units()),
            max_y: self.max_y.saturating_add(r.units()),
        }
    }

    /// The side of the line of `motion` on which the whole box lies, or [`Orientation::On`] when the box is
    /// not strictly on one side. A box to the right of a side of a counter-clockwise convex polygon lies
    /// outside the polygon.
    #[must_use]
    #[inline(always)]
    pub fn side_of(self, motion: Segment) -> Orientation {
        let (low, high) = (Site { x: self.min_x, y: self.min_y }, Site { x: self.max_x, y: self.max_y });
        predicate::box_side::<Product>(low, high, motion.from.into(), motion.to.into())
    }

    /// Whether the box, clipped at the limits of the lattice, comes within `r` of the segment.
    #[must_use]
    #[inline]
    pub fn near_segment(self, segment: Segment, r: Length) -> Proximity {
        let [low, _, high, _] = self.lattice_corners();
        predicate::box_segment::<Product>(low, high, segment.from.into(), segment.to.into(), r.units())
    }

    /// Whether every point of the box, clipped at the limits of the lattice, lies within `r` of the segment.
    /// Testing the corners is enough, because the points within `r` of a segment form a convex set.
    #[must_use]
    pub fn within_reach_of(self, segment: Segment, r: Length) -> bool {
        let (from, to) = (segment.from.into(), segment.to.into());
        let near = |corner| !predicate::point_segment::<Product>(corner, from, to, r.units()).is_clear();
        self.lattice_corners().into_iter().all(near)
    }

    /// The corners of the box clipped at the limits of the lattice, counter-clockwise from the lowest.
    /// Clipping keeps the integer widths of the predicates.
    fn lattice_corners(self) -> [Site<Product>; 4] {
        let cut = |c: i32| c.clamp(-COORD_MAX, COORD_MAX);
        let (x0, y0, x1, y1) = (cut(self.min_x), cut(self.min_y), cut(self.max_x), cut(self.max_y));
        [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Site { x, y })
    }

    /// Whether the closed boxes share a point.
    #[must_use]
    #[inline]
    pub fn meets(self, other: Self) -> bool {
        self.min_x <= other.max_x
            && other.min_x <= self.max_x
            && self.min_y <= other.max_y
            && other.min_y <= self.max_y
    }

    /// Whether the box holds no point: a minimum exceeds its maximum.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.min_x > self.max_x || self.min_y > self.max_y
    }

    /// Whether this box contains every point of the other box.
    #[must_use]
    #[inline]
    pub fn contains(self, other: Self) -> bool {
        self.min_x <= other.min_x
            && self.min_y <= other.min_y
            && self.max_x >= other.max_x
            && self.max_y >= other.max_y
    }

    /// Whether the closed box holds `point`.
    #[must_use]
    #[inline]
    pub fn holds(self, point: Point) -> bool {
        self.meets(Self::of(point))
    }

    /// The corners `(min x, min y, max x, max y)` in lattice units.
    #[must_use]
    pub fn corners(self) -> (i32, i32, i32, i32) {
        (self.min_x, self.min_y, self.max_x, self.max_y)
    }
}

/// Whether the projection of `point − origin` on the direction of `along` exceeds `units`. Requires
/// `units ≥ 0`.
#[must_use]
pub fn ahead(origin: Point, point: Point, along: Segment, units: i8) -> bool {
    predicate::ahead::<Product>(origin.into(), point.into(), along.from.into(), along.to.into(), units)
}

/// `|p − q|²` in square lattice units; at most 2^61.
#[must_use]
pub fn distance_2(p: Point, q: Point) -> i64 {
    use super::width::Lattice;
    let d = p.minus(q);
    Product::sum(Product::product(d.dx, d.dx), Product::product(d.dy, d.dy))
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    #[test]
    fn touching_segments_have_distance_zero() {
        let points: Vec<Point> = (0..16).map(|k| at(k % 4, k / 4)).collect();
        for (&a, &b) in points.iter().flat_map(|a| points.iter().map(move |b| (a, b))) {
            for (&c, &d) in points.iter().flat_map(|c| points.iter().map(move |d| (c, d))) {
                let (one, other) = (Segment { from: a, to: b }, Segment { from: c, to: d });
                let touches = !one.near_segment(other, Length::ZERO).is_clear();
                assert_eq!(one.touches(other), touches, "{one:?} {other:?}");
            }
        }
    }

    #[test]
    fn containment_and_emptiness_count_every_side() {
        let window = Window::from_corners(0, 0, 10, 20);
        assert!(window.contains(window) && !window.is_empty());
        for (x0, y0, x1, y1) in [(-1, 0, 10, 20), (0, -1, 10, 20), (0, 0, 11, 20), (0, 0, 10, 21)] {
            assert!(!window.contains(Window::from_corners(x0, y0, x1, y1)));
        }
        assert!(!Window::from_corners(3, 3, 3, 3).is_empty(), "a point");
        assert!(Window::from_corners(4, 3, 3, 3).is_empty() && Window::from_corners(3, 4, 3, 3).is_empty());
        assert!(!Window::from_corners(-9, -9, 3, 3).is_empty());
    }

    #[test]
    fn ahead_compares_the_projection_with_the_given_units() {
        let along = Segment { from: at(7, 7), to: at(3007, 4007) };
        let by = |k: i64| at(3 * k, 4 * k);
        assert!(ahead(Point::ORIGIN, by(1), along, 4));
        assert!(!ahead(Point::ORIGIN, by(1), along, 5) && !ahead(Point::ORIGIN, by(-9), along, 5));
        assert!(!ahead(Point::ORIGIN, at(-4000, 3000), along, 0), "beside");
    }
}

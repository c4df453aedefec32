//! Segments and triangles of the lattice, with the threshold questions that safety asks.

use super::lattice::{Length, Point};
use super::predicate::{self, Orientation, Site};
use super::width::Product;

pub use super::predicate::Proximity;

impl From<Point> for Site<Product> {
    fn from(point: Point) -> Self {
        Self { x: point.x.units(), y: point.y.units() }
    }
}

/// The side of the directed line `a → b` on which `c` lies.
#[must_use]
pub fn orientation(a: Point, b: Point, c: Point) -> Orientation {
    predicate::orientation::<Product>(a.into(), b.into(), c.into())
}

/// Whether `|p − q| ≤ r`.
#[must_use]
pub fn points_within(p: Point, q: Point, r: Length) -> Proximity {
    predicate::point_point::<Product>(p.into(), q.into(), r.units())
}

/// A straight piece between two lattice points; may have zero length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Where it begins.
    pub from: Point,
    /// Where it ends.
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
        predicate::segment_segment::<Product>(
            self.from.into(),
            self.to.into(),
            other.from.into(),
            other.to.into(),
            r.units(),
        )
    }

    /// Whether the segments share at least one point.
    #[must_use]
    pub fn touches(self, other: Self) -> bool {
        !self.near_segment(other, Length::ZERO).is_clear()
    }

    /// The box `[min x, min y, max x, max y]` of the segment.
    #[must_use]
    #[inline]
    pub fn bounds(self) -> Window {
        Window::of(self.from).including(self.to)
    }
}

/// A filled triangle: what is swept when a machine is re-targeted in the middle of a motion.
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
        predicate::triangle_segment::<Product>(corners, segment.from.into(), segment.to.into(), r.units())
    }

    /// The box of the triangle.
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
    /// The box that holds one point.
    #[must_use]
    #[inline]
    pub fn of(point: Point) -> Self {
        let (x, y) = (point.x.units(), point.y.units());
        Self { min_x: x, min_y: y, max_x: x, max_y: y }
    }

    /// The least box that holds this one and `point`.
    #[must_use]
    #[inline]
    pub fn including(self, point: Point) -> Self {
        self.union(Self::of(point))
    }

    /// The least box that holds both.
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

    /// The box grown by `r` on every side. Nothing farther than `r` from a point outside the grown box can be in it.
    #[must_use]
    #[inline]
    pub fn grown(self, r: Length) -> Self {
        // |c| ≤ 2^29 and r ≤ 2^29: repeated growth saturates, which only enlarges the box.
        Self {
            min_x: self.min_x.saturating_sub(r.units()),
            min_y: self.min_y.saturating_sub(r.units()),
            max_x: self.max_x.saturating_add(r.units()),
            max_y: self.max_y.saturating_add(r.units()),
        }
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

    /// Whether the closed box holds `point`.
    #[must_use]
    pub fn holds(self, point: Point) -> bool {
        self.meets(Self::of(point))
    }

    /// The corners `(min x, min y, max x, max y)` in lattice units.
    #[must_use]
    pub fn corners(self) -> (i32, i32, i32, i32) {
        (self.min_x, self.min_y, self.max_x, self.max_y)
    }
}

/// `|p − q|²` in square lattice units; at most 2^61.
#[must_use]
pub fn distance_2(p: Point, q: Point) -> i64 {
    use super::width::Lattice;
    let d = p.minus(q);
    Product::sum(Product::product(d.dx, d.dx), Product::product(d.dy, d.dy))
}

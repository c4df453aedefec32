//! Convex polygons of the lattice, and their distance tests against a threshold.
//!
//! Implements SR-01.

use super::lattice::{Length, Point};
use super::predicate::{self, Orientation, Proximity, Site};
use super::segment::{Segment, Window, orientation};
use super::width::Product;

/// A filled convex polygon over borrowed corners, counter-clockwise. Two corners form a segment, one forms a
/// point.
///
/// **Invariant:** every corner lies to the left of each directed side or on its line. So does the whole
/// polygon.
#[derive(Clone, Copy, Debug)]
pub struct Convex<'a> {
    corners: &'a [Point],
}

impl<'a> Convex<'a> {
    /// Accepts the corners of a convex polygon after an exact test of each corner against each side. Returns
    /// `None` when a test fails or there are no corners.
    #[must_use]
    #[inline]
    pub fn check(corners: &'a [Point]) -> Option<Self> {
        let polygon = Self { corners };
        let left = |side: Segment| {
            corners.iter().all(|&corner| orientation(side.from, side.to, corner) != Orientation::Right)
        };
        (!corners.is_empty() && polygon.sides().all(left)).then_some(polygon)
    }

    /// The corners.
    #[must_use]
    pub fn corners(&self) -> &'a [Point] {
        self.corners
    }

    /// The sides, counter-clockwise. A segment has two sides: there and back.
    #[inline]
    pub fn sides(&self) -> impl Iterator<Item = Segment> + 'a {
        predicate::sides(self.corners.iter().copied()).map(|[from, to]| Segment { from, to })
    }

    /// The bounding box of the polygon. It is empty without corners.
    #[must_use]
    pub fn bounds(&self) -> Window {
        let boxes = self.corners.iter().copied().map(Window::of);
        boxes.reduce(Window::union).unwrap_or(Window::from_corners(1, 1, 0, 0))
    }

    /// Whether the polygon holds the point, its border included.
    #[must_use]
    #[inline]
    pub fn holds(&self, point: Point) -> bool {
        predicate::convex_holds::<Product>(self.sites(), point.into())
    }

    /// Whether some point of the polygon is within `r` of the segment.
    #[must_use]
    #[inline]
    pub fn near_segment(&self, segment: Segment, r: Length) -> Proximity {
        predicate::convex_segment::<Product>(self.sites(), segment.into(), r.units())
    }

    #[inline(always)]
    fn sites(&self) -> impl ExactSizeIterator<Item = Site<Product>> + Clone + 'a {
        self.corners.iter().copied().map(Site::from)
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::exact::segment::Triangle;

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    /// Quadrangles on a small lattice. The oracle covers each with triangles, from every corner.
    #[test]
    fn polygon_distance_agrees_with_its_triangles() {
        let points: Vec<Point> = (0..16).map(|k| at(k % 4, k / 4)).collect();
        let segments =
            [(0, 0, 0, 0), (-2, 1, 5, 1), (6, -1, 5, 7), (-3, 0, -2, 4), (1, 1, 2, 1), (5, 5, 8, 8)];
        let mut convex = 0;
        for corners in points.iter().flat_map(|&a| points.iter().map(move |&b| (a, b))).flat_map(|(a, b)| {
            points.iter().flat_map(move |&c| [[a, b, c, at(0, 3)], [a, b, c, at(3, 1)], [a, b, c, at(1, 1)]])
        }) {
            for count in 1..=4 {
                let corners = &corners[..count];
                let Some(polygon) = Convex::check(corners) else { continue };
                convex += 1;
                for (x0, y0, x1, y1) in segments {
                    let segment = Segment { from: at(x0, y0), to: at(x1, y1) };
                    for r in 0..5 {
                        let r = Length::small(r);
                        let near = corners.iter().any(|&a| {
                            polygon.sides().any(|side| {
                                let triangle = Triangle { corners: [a, side.from, side.to] };
                                !triangle.near_segment(segment, r).is_clear()
                            })
                        });
                        assert_eq!(!polygon.near_segment(segment, r).is_clear(), near, "{corners:?}");
                    }
                }
            }
        }
        assert!(convex > 1000, "{convex}");
    }

    #[test]
    fn corners_that_turn_right_or_go_round_twice_are_refused() {
        assert!(Convex::check(&[]).is_none());
        assert!(Convex::check(&[at(0, 0), at(0, 9), at(9, 0)]).is_none());
        assert!(Convex::check(&[at(0, 0), at(9, 0), at(2, 2), at(0, 9)]).is_none());
        // All turns are to the left, but the corners go round twice.
        let twice = [at(0, 0), at(9, 0), at(0, 9), at(1, 1), at(8, 1), at(1, 8)];
        assert!(Convex::check(&twice).is_none());
        assert!(Convex::check(&[at(0, 0), at(9, 0), at(9, 9), at(0, 9)]).is_some());
    }
}

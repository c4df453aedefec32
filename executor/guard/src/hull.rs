//! TRUSTED. The exact convex hull of a few points.
//!
//! Implements SR-07.

use keepout_kernel::exact::segment::{Orientation, Window, distance_2, orientation};
use keepout_kernel::{Convex, Point, Segment};

/// Greatest number of points of a hull.
const POINTS_MAX: usize = 14;
/// Greatest number of corners during construction: both chains can hold every point at once.
const CORNERS_MAX: usize = 2 * POINTS_MAX + 1;

/// A convex hull: its corners, counter-clockwise. Points on a line have two corners, a single point has one.
#[derive(Clone, Copy, Debug)]
pub struct Hull {
    corners: [Point; CORNERS_MAX],
    count: usize,
}

impl Hull {
    /// The hull of the points. Returns `None` without points, with too many points, or when a final check
    /// finds a point outside. The last case would be an error of this function.
    #[must_use]
    pub fn of(points: impl Iterator<Item = Point> + Clone) -> Option<Self> {
        let first = points.clone().next()?;
        let mut sorted = [first; POINTS_MAX];
        let mut count = 0;
        for point in points.clone() {
            *sorted.get_mut(count)? = point;
            count += 1;
        }
        let key = |point: &Point| (point.x.units(), point.y.units());
        sorted[..count].sort_unstable_by_key(key);
        let mut hull = Self { corners: [first; CORNERS_MAX], count: 0 };
        hull.chain(sorted[..count].iter().copied(), 0)?;
        let lower = hull.count;
        hull.chain(sorted[..count].iter().rev().copied(), lower)?;
        let hull = if hull.count == 0 { Self { count: 1, corners: [sorted[0]; CORNERS_MAX] } } else { hull };
        points.into_iter().all(|point| hull.holds(point)).then_some(hull)
    }

    /// The hull of this hull and one more point.
    #[must_use]
    pub fn with(&self, point: Point) -> Option<Self> {
        Self::of(self.corners[..self.count].iter().copied().chain(core::iter::once(point)))
    }

    /// Adds a chain that turns left all the way. It omits the last point, where the next chain begins.
    fn chain(&mut self, points: impl Iterator<Item = Point>, begins: usize) -> Option<()> {
        for point in points {
            while self.count >= begins + 2 {
                let (a, b) = (self.corners[self.count - 2], self.corners[self.count - 1]);
                if orientation(a, b, point) == Orientation::Left {
                    break;
                }
                self.count -= 1;
            }
            let repeats = self.count > begins && self.corners[self.count - 1] == point;
            if !repeats {
                *self.corners.get_mut(self.count)? = point;
                self.count += 1;
            }
        }
        self.count = self.count.saturating_sub(1);
        Some(())
    }

    /// The corners.
    #[must_use]
    pub fn corners(&self) -> &[Point] {
        &self.corners[..self.count]
    }

    /// The hull as a polygon. `None` when the corners do not turn left all round. The kernel checks this
    /// again: `None` would be an error of this file.
    #[must_use]
    pub fn polygon(&self) -> Option<Convex<'_>> {
        Convex::check(&self.corners[..self.count])
    }

    /// The sides, as pairs of corners. Two corners have one side. A single corner has one side of length
    /// zero.
    pub fn sides(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let count = if self.count == 2 { 1 } else { self.count };
        (0..count).map(|k| (self.corners[k], self.corners[(k + 1) % self.count]))
    }

    /// Whether the hull holds the point. The border belongs to the hull.
    #[must_use]
    pub fn holds(&self, point: Point) -> bool {
        match self.count {
            0 => false,
            1 => self.corners[0] == point,
            2 => {
                let (a, b) = (self.corners[0], self.corners[1]);
                orientation(a, b, point) == Orientation::On && Window::of(a).including(b).holds(point)
            }
            _ => self.sides().all(|(a, b)| orientation(a, b, point) != Orientation::Right),
        }
    }

    /// The point of the hull nearest to `point`, rounded to the lattice.
    #[must_use]
    pub fn nearest(&self, point: Point) -> Option<Point> {
        if self.holds(point) {
            return Some(point);
        }
        let feet = self.sides().filter_map(|(a, b)| project(point, Segment { from: a, to: b }));
        feet.min_by_key(|&foot| distance_2(foot, point))
    }
}

/// The lattice point nearest to the foot of the perpendicular from `p` on the segment, or the nearer end if
/// the foot is outside.
fn project(p: Point, segment: Segment) -> Option<Point> {
    let (d, w) = (segment.to.minus(segment.from), p.minus(segment.from));
    let product = |a: i32, b: i32| i128::from(a) * i128::from(b);
    let length_2 = product(d.dx, d.dx) + product(d.dy, d.dy);
    if length_2 == 0 {
        return Some(segment.from);
    }
    let along = (product(w.dx, d.dx) + product(w.dy, d.dy)).clamp(0, length_2);
    let part = |span: i32| {
        let twice = 2 * i128::from(span) * along + length_2;
        i64::try_from(twice.div_euclid(2 * length_2)).ok()
    };
    let (x, y) = (i64::from(segment.from.x.units()), i64::from(segment.from.y.units()));
    Point::from_units(x + part(d.dx)?, y + part(d.dy)?).ok()
}

#[cfg(test)]
mod tests {
    use keepout_kernel::{Length, Triangle};

    use super::*;

    /// The grids are small, so points often coincide or lie on one line. The oracle tests all triangles.
    #[test]
    fn hull_agrees_with_all_triangles_of_its_points() {
        let mut random = fastrand::Rng::with_seed(9);
        for _ in 0..4000 {
            let size = [random.i64(1..9), 1000][random.usize(0..2)];
            let place = |random: &mut fastrand::Rng| {
                Point::from_units(random.i64(0..size), random.i64(0..size)).unwrap()
            };
            let count = if random.bool() { POINTS_MAX } else { random.usize(1..=POINTS_MAX) };
            let points: Vec<Point> = (0..count).map(|_| place(&mut random)).collect();
            let hull = Hull::of(points.iter().copied()).unwrap();
            let polygon = hull.polygon().unwrap();
            let again =
                Hull::of(points.iter().copied().skip(1)).map_or(hull, |rest| rest.with(points[0]).unwrap());
            assert_eq!(again.polygon().unwrap().corners(), polygon.corners(), "{points:?}");
            let probe = place(&mut random);
            let here = Segment { from: probe, to: probe };
            let inside = points.iter().any(|&a| {
                points.iter().any(|&b| {
                    points.iter().any(|&c| {
                        !Triangle { corners: [a, b, c] }.near_segment(here, Length::ZERO).is_clear()
                    })
                })
            });
            assert_eq!(hull.holds(probe), inside, "{points:?} {probe:?}");
            assert_eq!(polygon.holds(probe), inside, "{points:?} {probe:?}");
            assert!(polygon.corners().iter().all(|corner| points.contains(corner)));
            let near = hull.nearest(probe).unwrap();
            assert_eq!(near == probe, inside || near == probe, "{points:?} {probe:?}");
        }
        assert!(Hull::of(core::iter::empty()).is_none());
    }
}

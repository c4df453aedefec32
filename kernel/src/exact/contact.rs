//! The search for two segments that meet, among many.

use alloc::vec::Vec;

use super::lattice::{COORD_MAX, Length, Point};
use super::segment::{Segment, Window, distance_2};

/// Segments in a block, and blocks under one bound.
const BLOCK: usize = 8;

/// The first pair `i < j` for which `meet` answers yes, in the order of a divide-and-conquer walk.
///
/// The function bounds blocks of consecutive segments, and blocks of those blocks. It skips two blocks that
/// their bounds separate, because they hold no pair that meets. The time is near-linear when consecutive
/// segments lie near each other, even for long thin shapes.
pub fn first_contact(edges: &[Segment], meet: impl Fn(usize, usize) -> bool) -> Option<(usize, usize)> {
    let mut levels: Vec<Vec<Bound>> = Vec::new();
    let mut below: Vec<Bound> = edges.iter().map(|&edge| Bound::of(edge)).collect();
    while below.len() > 1 {
        let above = below.chunks(BLOCK).filter_map(Bound::around).collect();
        levels.push(below);
        below = above;
    }
    let search = Search { levels, meet };
    search.within(search.levels.len(), 0)
}

/// The bound of a block: a box, and a segment with every point of the block within a radius of it.
#[derive(Clone, Copy)]
struct Bound {
    window: Window,
    axis: Segment,
    radius: Length,
}

impl Bound {
    fn of(segment: Segment) -> Self {
        Self { window: segment.bounds(), axis: segment, radius: Length::ZERO }
    }

    /// The bound of a block of bounds. The axis joins two ends of axes that are far apart. The points within
    /// `radius` of the axis form a convex set, so this set holds an axis when it holds both its ends.
    fn around(block: &[Self]) -> Option<Self> {
        let ends = || block.iter().flat_map(|bound| [bound.axis.from, bound.axis.to]);
        let window = block.iter().map(|bound| bound.window).reduce(Window::union)?;
        let far_from = |start: Point| ends().max_by_key(|&end| distance_2(start, end));
        let from = far_from(ends().next()?)?;
        let axis = Segment { from, to: far_from(from)? };
        let radius = block.iter().fold(Length::ZERO, |radius, bound| {
            let away = reach(axis, bound.axis.from).max(reach(axis, bound.axis.to));
            radius.max(away.saturating_plus(bound.radius))
        });
        Some(Self { window, axis, radius })
    }

    /// Whether no segment of one block can meet a segment of the other.
    fn apart(&self, other: &Self) -> bool {
        // A sum beyond the lattice, or a radius limited there, proves nothing.
        let reach = self.radius.plus(other.radius).ok().filter(|reach| reach.units() < COORD_MAX);
        !self.window.meets(other.window)
            || reach.is_some_and(|reach| self.axis.near_segment(other.axis, reach).is_clear())
    }
}

/// The distance from the segment to the point, rounded up and limited to the largest length.
fn reach(segment: Segment, point: Point) -> Length {
    let is_clear = |r: i64| Length::from_units(r).is_ok_and(|r| segment.near_point(point, r).is_clear());
    // Most distances are short, so the search doubles a length until it reaches the point.
    let (mut low, mut high) = (-1_i64, 0_i64);
    while high < i64::from(COORD_MAX) && is_clear(high) {
        low = high;
        high = high.saturating_mul(2).max(1).min(i64::from(COORD_MAX));
    }
    while high.saturating_sub(low) > 1 {
        let middle = i64::midpoint(low, high);
        if is_clear(middle) { low = middle } else { high = middle }
    }
    Length::from_units(high).unwrap_or(Length::ZERO)
}

struct Search<F> {
    /// Bounds of single segments, of blocks, of blocks of blocks. The single bound over everything is not
    /// stored.
    levels: Vec<Vec<Bound>>,
    meet: F,
}

impl<F: Fn(usize, usize) -> bool> Search<F> {
    /// The bounds under item `index` of the level above `level`, with their numbers.
    fn under(&self, level: usize, index: usize) -> impl Iterator<Item = (usize, &Bound)> + '_ {
        let first = index.saturating_mul(BLOCK);
        let bounds = self.levels.get(level).and_then(|bounds| bounds.get(first..)).unwrap_or(&[]);
        (first..).zip(bounds).take(BLOCK)
    }

    /// A pair of segments that meet, both under item `index`, `height` levels above the segments.
    fn within(&self, height: usize, index: usize) -> Option<(usize, usize)> {
        let level = height.checked_sub(1)?;
        let found = self.under(level, index).find_map(|(i, _)| self.within(level, i));
        found.or_else(|| {
            self.under(level, index).find_map(|(i, one)| {
                let later = self.under(level, index).filter(|&(j, other)| j > i && !one.apart(other));
                later.map(|(j, _)| self.between(level, i, j)).find_map(|pair| pair)
            })
        })
    }

    /// A pair of segments that meet, one under each of two different items that their bounds do not separate.
    fn between(&self, height: usize, i: usize, j: usize) -> Option<(usize, usize)> {
        let Some(level) = height.checked_sub(1) else {
            return (self.meet)(i, j).then_some((i, j));
        };
        let across = self.levels.get(height).and_then(|bounds| bounds.get(j))?;
        self.under(level, i).filter(|(_, one)| !one.apart(across)).find_map(|(a, one)| {
            let meeting = self.under(level, j).filter(|(_, other)| !one.apart(other));
            meeting.map(|(b, _)| self.between(level, a, b)).find_map(|pair| pair)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The oracle tests all pairs.
    #[test]
    fn no_meeting_pair_is_missed() {
        for seed in 0..300_u64 {
            let mut random = fastrand::Rng::with_seed(seed);
            let count = random.usize(0..200);
            let mut at = || Point::from_units(random.i64(-300..300), random.i64(-300..300)).unwrap();
            let edges: Vec<Segment> = (0..count)
                .map(|_| {
                    let from = at();
                    let (x, y) = (i64::from(from.x.units()), i64::from(from.y.units()));
                    Segment { from, to: Point::from_units(x + (y % 7), y + (x % 5)).unwrap() }
                })
                .collect();
            let meet = |i: usize, j: usize| edges[i].touches(edges[j]);
            let brute = (0..count).any(|i| (i + 1..count).any(|j| meet(i, j)));
            let found = first_contact(&edges, meet);
            assert_eq!(found.is_some(), brute, "seed {seed}");
            assert!(found.is_none_or(|(i, j)| i < j && meet(i, j)));
        }
    }

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    #[test]
    fn reach_is_the_distance_rounded_up() {
        let segment = Segment { from: at(0, 0), to: at(100, 0) };
        for (x, y, away) in [(50, 7, 7), (50, 0, 0), (103, 4, 5), (-1, 1, 2), (50, -1_000_000, 1_000_000)] {
            assert_eq!(reach(segment, at(x, y)).units(), away, "{x} {y}");
        }
        let corner = i64::from(COORD_MAX);
        let far = Segment { from: at(-corner, -corner), to: at(-corner, -corner) };
        assert_eq!(reach(far, at(corner, corner)).units(), COORD_MAX, "limited");
    }

    #[test]
    fn blocks_are_separated_only_by_radii_on_the_lattice_or_by_boxes() {
        let window = Window::from_corners(-COORD_MAX, -COORD_MAX, COORD_MAX, COORD_MAX);
        let bound = |x, y, radius| {
            let axis = Segment { from: at(x, y), to: at(x, y) };
            Bound { window, axis, radius: Length::from_units(radius).unwrap() }
        };
        assert!(
            bound(0, 0, 10).apart(&bound(30, 0, 19)),
            "the axes are farther apart than the sum of the radii"
        );
        assert!(!bound(0, 0, 10).apart(&bound(30, 0, 20)), "the sum of the radii is reached");
        let corner = i64::from(COORD_MAX);
        let cut = bound(-corner, -corner, corner);
        assert!(!cut.apart(&bound(corner, corner, 0)), "a radius at the limit proves nothing");
        assert!(!cut.apart(&bound(corner, corner, 5)), "a sum beyond the lattice proves nothing");
        let beside = Bound { window: Window::from_corners(5, 5, 6, 6), ..cut };
        assert!(
            beside.apart(&Bound { window: Window::from_corners(7, 5, 8, 6), ..cut }),
            "boxes still separate"
        );
    }
}

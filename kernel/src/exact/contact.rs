//! The search for two segments that meet, among many.
//!
//! Implements SR-04.

use alloc::vec::Vec;
use core::cell::OnceCell;

use super::lattice::{COORD_MAX, Length, Point};
use super::segment::{Segment, Window, distance_2};
use super::width::{Lattice, Product};

/// Segments in a block, and blocks under one bound.
const BLOCK: usize = 8;

/// The first pair `i < j` of segments of different owners for which `meet` answers yes, in the order of a
/// divide-and-conquer walk.
///
/// The function bounds blocks of consecutive segments, and blocks of those blocks. It skips two blocks that
/// their bounds separate, because they hold no pair that meets, and blocks of one owner. The time is near-linear
/// when consecutive segments lie near each other, even for long thin shapes.
pub fn first_contact(
    edges: &[Segment],
    owner: impl Fn(usize) -> usize,
    meet: impl Fn(usize, usize) -> bool,
) -> Option<(usize, usize)> {
    let mut search = Search { edges, owner, levels: Vec::new(), meet };
    let (mut level, mut count) = (0_usize, edges.len());
    while count > 1 {
        let block = |index| search.under(level, index).map(|item| item.bounds).reduce(Bounds::union);
        let blocks = (0..count.div_ceil(BLOCK)).map_while(block);
        let blocks: Vec<Block> = blocks.map(|bounds| Block { bounds, strip: OnceCell::new() }).collect();
        count = blocks.len();
        search.levels.push(blocks);
        level = level.saturating_add(1);
    }
    search.within(level, 0)
}

/// The box of a segment or a block, and the owner of its segments if they have the same.
#[derive(Clone, Copy)]
struct Bounds {
    window: Window,
    owner: Option<usize>,
}

impl Bounds {
    fn union(self, other: Self) -> Self {
        let owner = if self.owner == other.owner { self.owner } else { None };
        Self { window: self.window.union(other.window), owner }
    }

    /// The longer side of the box.
    fn extent(self) -> i32 {
        let (x0, y0, x1, y1) = self.window.corners();
        x1.saturating_sub(x0).max(y1.saturating_sub(y0))
    }

    /// Whether the boxes or the owners show that no segment of one block can meet a segment of another owner in
    /// the other block.
    fn apart(self, other: Self) -> bool {
        (self.owner.is_some() && self.owner == other.owner) || !self.window.meets(other.window)
    }
}

/// The points within a radius of an axis. It holds every point of its segments.
#[derive(Clone, Copy)]
struct Strip {
    axis: Segment,
    radius: Length,
}

impl Strip {
    /// A strip that holds segments. The axis joins two ends that are far apart. The points within `radius` of the
    /// axis form a convex set, so this set holds a segment when it holds both its ends.
    fn around(segments: &[Segment]) -> Option<Self> {
        let ends = || segments.iter().flat_map(|segment| [segment.from, segment.to]);
        let far_from = |start: Point| ends().max_by_key(|&end| distance_2(start, end));
        let from = far_from(ends().next()?)?;
        let axis = Segment { from, to: far_from(from)? };
        let radius = ends().map(|end| reach(axis, end)).max()?;
        Some(Self { axis, radius })
    }

    fn apart(self, other: Self) -> bool {
        // A sum beyond the lattice, or a radius limited there, proves nothing.
        let reach = self.radius.plus(other.radius).ok().filter(|reach| reach.units() < COORD_MAX);
        reach.is_some_and(|reach| self.axis.near_segment(other.axis, reach).is_clear())
    }
}

struct Block {
    bounds: Bounds,
    /// The strip of a block of segments. The search computes it when it first needs it.
    strip: OnceCell<Option<Strip>>,
}

/// A length within which the segment reaches the point, limited to the largest length: at most twice the distance,
/// and a few units. The distance to the segment's line is mostly enough.
fn reach(segment: Segment, point: Point) -> Length {
    let is_clear = |r: i64| Length::from_units(r).is_ok_and(|r| segment.near_point(point, r).is_clear());
    let limit = i64::from(COORD_MAX);
    let (mut reach, mut step) = (line_distance(segment, point).min(limit), 1_i64);
    while reach < limit && is_clear(reach) {
        reach = reach.saturating_add(step).min(limit);
        step = step.saturating_mul(2);
    }
    Length::from_units(reach).unwrap_or(Length::ZERO)
}

/// The distance from the segment's line to the point, rounded up: the segment's length is rounded down to whole
/// units, so a segment of a few units gives up to half as much again. Zero for a segment of length zero.
fn line_distance(segment: Segment, point: Point) -> i64 {
    let (along, away) = (segment.to.minus(segment.from), point.minus(segment.from));
    let cross = Product::gap(Product::product(along.dx, away.dy), Product::product(along.dy, away.dx));
    let length = distance_2(segment.from, segment.to).isqrt();
    cross.saturating_abs().checked_div(length).map_or(0, |distance| distance.saturating_add(1))
}

/// A segment, at level 0, or a block.
#[derive(Clone, Copy)]
struct Item {
    level: usize,
    index: usize,
    bounds: Bounds,
}

struct Search<'a, O, F> {
    edges: &'a [Segment],
    owner: O,
    /// Blocks of segments, blocks of blocks, up to the one over everything.
    levels: Vec<Vec<Block>>,
    meet: F,
}

impl<O: Fn(usize) -> usize, F: Fn(usize, usize) -> bool> Search<'_, O, F> {
    fn block(&self, above: usize, index: usize) -> Option<&Block> {
        self.levels.get(above)?.get(index)
    }

    fn bounds(&self, level: usize, index: usize) -> Option<Bounds> {
        match level.checked_sub(1) {
            None => {
                let window = self.edges.get(index)?.bounds();
                Some(Bounds { window, owner: Some((self.owner)(index)) })
            }
            Some(above) => Some(self.block(above, index)?.bounds),
        }
    }

    /// The strip of a segment, or of a block of segments. Blocks of blocks have boxes only.
    fn strip(&self, item: Item) -> Option<Strip> {
        match item.level {
            0 => self.edges.get(item.index).map(|&axis| Strip { axis, radius: Length::ZERO }),
            1 => *self.block(0, item.index)?.strip.get_or_init(|| {
                let segments = self.edges.chunks(BLOCK).nth(item.index)?;
                Strip::around(segments)
            }),
            _ => None,
        }
    }

    /// The items under item `index` of the level above `level`.
    fn under(&self, level: usize, index: usize) -> impl Iterator<Item = Item> + '_ {
        let first = index.saturating_mul(BLOCK);
        let items = first..first.saturating_add(BLOCK);
        items.map_while(move |index| Some(Item { level, index, bounds: self.bounds(level, index)? }))
    }

    /// A pair of segments that meet, both under item `index`, `height` levels above the segments.
    fn within(&self, height: usize, index: usize) -> Option<(usize, usize)> {
        let level = height.checked_sub(1)?;
        let mut mixed = self.under(level, index).filter(|item| item.bounds.owner.is_none());
        let found = mixed.find_map(|item| self.within(level, item.index));
        found.or_else(|| {
            self.under(level, index).find_map(|one| {
                let mut later = self.under(level, index).filter(|other| other.index > one.index);
                later.find_map(|other| self.between(one, other))
            })
        })
    }

    /// A pair of segments that meet, one under each of two items. It looks under the larger of the two, unless
    /// their bounds separate them.
    fn between(&self, one: Item, other: Item) -> Option<(usize, usize)> {
        let strips_apart = || Some(self.strip(one)?.apart(self.strip(other)?));
        if one.bounds.apart(other.bounds) || strips_apart().unwrap_or(false) {
            return None;
        }
        match (one.level.checked_sub(1), other.level.checked_sub(1)) {
            (Some(below), next) if next.is_none() || one.bounds.extent() > other.bounds.extent() => {
                self.under(below, one.index).find_map(|part| self.between(part, other))
            }
            (_, Some(below)) => self.under(below, other.index).find_map(|part| self.between(one, part)),
            (_, None) => (self.meet)(one.index, other.index).then_some((one.index, other.index)),
        }
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
            let found = first_contact(&edges, |i| i, meet);
            assert_eq!(found.is_some(), brute, "seed {seed}");
            assert!(found.is_none_or(|(i, j)| i < j && meet(i, j)));
            // Runs of edges have one owner, as those of a ring.
            let run = random.usize(1..12);
            let apart = |i: usize, j: usize| i / run != j / run && meet(i, j);
            let brute = (0..count).any(|i| (i + 1..count).any(|j| apart(i, j)));
            let found = first_contact(&edges, |i| i / run, meet);
            assert_eq!(found.is_some(), brute, "seed {seed}");
            assert!(found.is_none_or(|(i, j)| i < j && apart(i, j)));
        }
    }

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    #[test]
    fn segment_reaches_the_point_within_its_reach() {
        let segment = Segment { from: at(0, 0), to: at(100, 0) };
        for (x, y, most) in [(50, 7, 8), (50, 0, 1), (103, 4, 10), (-1, 1, 4), (50, -1_000_000, 1_000_001)] {
            let found = reach(segment, at(x, y));
            assert!(!segment.near_point(at(x, y), found).is_clear() && found.units() <= most, "{x} {y}");
        }
        let mut random = fastrand::Rng::with_seed(1);
        for round in 0..20_000 {
            let spread = 1 << (1 + round % 29);
            let mut place = || at(random.i64(-spread..=spread), random.i64(-spread..=spread));
            let (segment, point) = (Segment { from: place(), to: place() }, place());
            let found = reach(segment, point);
            let half = Length::from_units(i64::from(found.units()) / 2 - 2);
            let is_far = half.is_ok_and(|half| !segment.near_point(point, half).is_clear());
            assert!(found.units() == COORD_MAX || !segment.near_point(point, found).is_clear());
            assert!(!is_far, "{segment:?} {point}: {found:?} is more than twice the distance");
        }
        let corner = i64::from(COORD_MAX);
        let far = Segment { from: at(-corner, -corner), to: at(-corner, -corner) };
        assert_eq!(reach(far, at(corner, corner)).units(), COORD_MAX, "limited");
    }

    #[test]
    fn strips_are_separated_only_by_radii_on_the_lattice() {
        let strip = |x, y, radius| {
            let axis = Segment { from: at(x, y), to: at(x, y) };
            Strip { axis, radius: Length::from_units(radius).unwrap() }
        };
        let apart = |one: Strip, other: Strip| one.apart(other);
        assert!(apart(strip(0, 0, 10), strip(30, 0, 19)), "farther apart than the sum of the radii");
        assert!(!apart(strip(0, 0, 10), strip(30, 0, 20)), "the sum of the radii is reached");
        let corner = i64::from(COORD_MAX);
        let cut = strip(-corner, -corner, corner);
        assert!(!apart(cut, strip(corner, corner, 0)), "a radius at the limit proves nothing");
        assert!(!apart(cut, strip(corner, corner, 5)), "a sum beyond the lattice proves nothing");
    }

    #[test]
    fn bounds_are_separated_by_their_boxes_and_by_one_owner() {
        let bounds = |x, owner| Bounds { window: Window::from_corners(x, 5, x + 1, 6), owner };
        assert!(bounds(5, None).apart(bounds(7, None)) && !bounds(5, None).apart(bounds(6, None)));
        assert!(bounds(5, Some(1)).apart(bounds(5, Some(1))), "of one owner");
        assert!(!bounds(5, Some(1)).apart(bounds(5, Some(2))));
        let (one, other) = (bounds(5, Some(1)), bounds(9, Some(2)));
        assert_eq!(one.union(other).owner, None);
        assert_eq!(one.union(bounds(9, Some(1))).owner, Some(1));
    }
}

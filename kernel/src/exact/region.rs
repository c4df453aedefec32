//! A region: disjoint simple rings, nested to any depth, filled by the even–odd rule.
//!
//! Implements SR-04.

use alloc::vec::Vec;
use core::fmt;

use super::contact::first_contact;
use super::lattice::Point;
use super::ring::{Contact, Ring};
use super::segment::{Segment, Window};

/// Disjoint simple rings. A point is inside when an odd number of rings encloses it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    rings: Vec<Ring>,
}

/// Why rings do not form a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegionError {
    /// There is no ring.
    Empty,
    /// Two rings touch or cross.
    RingsTouch {
        /// Index of the first ring.
        first: usize,
        /// Index of the second ring.
        second: usize,
        /// The point of contact, to the lattice unit.
        at: Point,
    },
}

impl fmt::Display for RegionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "a region needs at least one ring"),
            Self::RingsTouch { first, second, at } => {
                write!(f, "rings {first} and {second} cross or touch at {at}")
            }
        }
    }
}

impl core::error::Error for RegionError {}

/// Where a point lies with respect to a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// An odd number of rings encloses it.
    Inside,
    /// An even number of rings encloses it.
    Outside,
    /// On a ring.
    Boundary,
}

impl Region {
    /// The region without rings: no point is inside.
    pub(crate) const fn empty() -> Self {
        Self { rings: Vec::new() }
    }

    /// The region of some of these rings, which do not touch.
    pub(crate) fn of_some(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept = self.rings.iter().enumerate().filter(|&(index, _)| keep(index));
        Self { rings: kept.map(|(_, ring)| ring.clone()).collect() }
    }

    /// Checks that no two rings touch.
    ///
    /// # Errors
    /// [`RegionError`] with the place of the first contact.
    pub fn new(rings: Vec<Ring>) -> Result<Self, RegionError> {
        if rings.is_empty() {
            return Err(RegionError::Empty);
        }
        let mut edges: Vec<Segment> = Vec::new();
        let mut owners: Vec<usize> = Vec::new();
        for (owner, ring) in rings.iter().enumerate() {
            edges.extend(ring.segments());
            owners.resize(edges.len(), owner);
        }
        let owner = |edge: usize| owners.get(edge).copied().unwrap_or(usize::MAX);
        // Each ring is simple already, so only edges of different rings need the test.
        let meet = |i: usize, j: usize| match (edges.get(i), edges.get(j)) {
            (Some(one), Some(&other)) => one.touches(other),
            _ => false,
        };
        match first_contact(&edges, owner, meet) {
            Some(pair) => {
                let Contact { first, second, at } = Contact::of(&edges, pair);
                Err(RegionError::RingsTouch { first: owner(first), second: owner(second), at })
            }
            None => Ok(Self { rings }),
        }
    }

    /// The rings.
    #[must_use]
    pub fn rings(&self) -> &[Ring] {
        &self.rings
    }

    /// The location of `point` relative to the region.
    #[must_use]
    pub fn locate(&self, point: Point) -> Location {
        let zero = super::lattice::Length::ZERO;
        if self.segments().any(|edge| !edge.near_point(point, zero).is_clear()) {
            return Location::Boundary;
        }
        let odd = self.rings.iter().fold(false, |odd, ring| odd ^ ring.crossing_parity_is_odd(point));
        if odd { Location::Inside } else { Location::Outside }
    }

    /// The number of other rings around each ring: 0 for an outer ring, 1 for a hole, 2 for an island in the
    /// hole.
    #[must_use]
    pub fn depths(&self) -> Vec<usize> {
        let mut depths: Vec<usize> = self.rings.iter().map(|_| 0).collect();
        self.visit_nesting(|inner, _| {
            if let Some(depth) = depths.get_mut(inner) {
                *depth = depth.saturating_add(1);
            }
        });
        depths
    }

    /// The innermost of the other rings around each ring, by index. `None` for an outer ring.
    ///
    /// The rings around a ring lie in each other, so the innermost is the one with the most rings around it.
    #[must_use]
    pub fn parents(&self) -> Vec<Option<usize>> {
        let depths = self.depths();
        let depth = |ring: usize| depths.get(ring).copied().unwrap_or(0);
        let mut parents: Vec<Option<usize>> = self.rings.iter().map(|_| None).collect();
        self.visit_nesting(|inner, outer| {
            if let Some(parent) = parents.get_mut(inner)
                && parent.is_none_or(|known| depth(known) < depth(outer))
            {
                *parent = Some(outer);
            }
        });
        parents
    }

    /// Calls `visit` with each pair of a ring and another ring around it, by index.
    fn visit_nesting(&self, mut visit: impl FnMut(usize, usize)) {
        let bounds = |ring: &Ring| ring.segments().map(Segment::bounds).reduce(Window::union);
        // A ring without vertices does not exist; it would lie in no ring and hold none.
        let boxed = self.rings.iter().enumerate().filter_map(|(i, ring)| Some((i, ring, bounds(ring)?)));
        let mut by_left: Vec<(usize, &Ring, Window)> = boxed.collect();
        by_left.sort_by_key(|(.., bounds)| bounds.corners().0);
        let firsts =
            self.rings.iter().enumerate().filter_map(|(i, ring)| Some((i, *ring.vertices().first()?)));
        let mut points: Vec<(usize, Point)> = firsts.collect();
        points.sort_by_key(|(_, point)| point.x);
        // Sweeps along x. `open` has the rings whose boxes hold the x of the point.
        let mut unopened = by_left.into_iter().peekable();
        let mut open: Vec<(usize, &Ring, Window)> = Vec::new();
        for (i, point) in points {
            let x = point.x.units();
            while let Some(ring) = unopened.next_if(|(.., bounds)| bounds.corners().0 <= x) {
                open.push(ring);
            }
            open.retain(|(.., bounds)| bounds.corners().2 >= x);
            for &(j, ring, bounds) in &open {
                if j != i && bounds.holds(point) && ring.crossing_parity_is_odd(point) {
                    visit(i, j);
                }
            }
        }
    }

    /// All edges, ring by ring.
    pub fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        self.rings.iter().flat_map(Ring::segments)
    }

    /// The smallest box that holds the region.
    #[must_use]
    pub fn bounds(&self) -> Window {
        let mut windows = self.segments().map(Segment::bounds);
        let first = windows.next().unwrap_or(Window::of(Point::ORIGIN));
        windows.fold(first, Window::union)
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;

    fn square(low: i64, high: i64) -> Ring {
        let at = |x, y| Point::from_units(x, y).unwrap();
        Ring::new(vec![at(low, low), at(high, low), at(high, high), at(low, high)]).unwrap()
    }

    #[test]
    fn nesting_fills_by_even_odd() {
        let region = Region::new(vec![square(0, 90), square(10, 80), square(20, 70)]).unwrap();
        let place = |c| region.locate(Point::from_units(c, c).unwrap());
        assert_eq!(place(5), Location::Inside);
        assert_eq!(place(15), Location::Outside);
        assert_eq!(place(30), Location::Inside);
        assert_eq!(place(20), Location::Boundary);
        assert_eq!(place(-5), Location::Outside);
        assert_eq!(region.depths(), [0, 1, 2]);
        assert_eq!(region.parents(), [None, Some(0), Some(1)]);
    }

    /// The oracle asks every ring about the first vertex of every other.
    #[test]
    fn depths_are_the_numbers_of_rings_around_each() {
        let mut random = fastrand::Rng::with_seed(5);
        for _ in 0..300 {
            let mut rings = Vec::new();
            for _ in 0..random.usize(1..40) {
                let low = (random.i64(-60..60), random.i64(-60..60));
                let high = (low.0 + random.i64(1..60), low.1 + random.i64(1..60));
                let corners = [(low.0, low.1), (high.0, low.1), (high.0, high.1), (low.0, high.1)];
                let corners = corners.map(|(x, y)| Point::from_units(x, y).unwrap());
                rings.push(Ring::new(corners.to_vec()).unwrap());
                if Region::new(rings.clone()).is_err() {
                    rings.pop();
                }
            }
            let region = Region::new(rings).unwrap();
            let rings = region.rings();
            let depth = |ring: &Ring| {
                let others = rings.iter().filter(|other| *other != ring);
                others.filter(|other| other.crossing_parity_is_odd(ring.vertices()[0])).count()
            };
            assert_eq!(region.depths(), rings.iter().map(depth).collect::<Vec<_>>());
            let parents = rings.iter().map(|ring| {
                let around = rings.iter().enumerate().filter(|(_, other)| *other != ring);
                let around = around.filter(|(_, other)| other.crossing_parity_is_odd(ring.vertices()[0]));
                around.max_by_key(|(_, other)| depth(other)).map(|(index, _)| index)
            });
            assert_eq!(region.parents(), parents.collect::<Vec<_>>());
        }
    }

    #[test]
    fn touching_rings_are_refused_with_the_place() {
        let error = Region::new(vec![square(0, 10), square(10, 20)]).unwrap_err();
        assert_eq!(
            error,
            RegionError::RingsTouch { first: 0, second: 1, at: Point::from_units(10, 10).unwrap() }
        );
        assert_eq!(Region::new(vec![]), Err(RegionError::Empty));
    }
}

//! A region: disjoint simple rings, nested to any depth, filled by the even–odd rule.

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
            (Some(one), Some(&other)) => owner(i) != owner(j) && one.touches(other),
            _ => false,
        };
        match first_contact(&edges, meet) {
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
        let bounds = |ring: &Ring| ring.segments().map(Segment::bounds).reduce(Window::union);
        let boxes: Vec<Option<Window>> = self.rings.iter().map(bounds).collect();
        let around = |i: usize, ring: &Ring| {
            let Some(&point) = ring.vertices().first() else { return 0 };
            let others = self.rings.iter().zip(&boxes).enumerate().filter(|&(j, _)| j != i);
            let near = others.filter(|(_, (_, bounds))| bounds.is_some_and(|bounds| bounds.holds(point)));
            near.filter(|(_, (other, _))| other.crossing_parity_is_odd(point)).count()
        };
        self.rings.iter().enumerate().map(|(i, ring)| around(i, ring)).collect()
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

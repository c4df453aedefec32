//! Circular arcs on the lattice, and the check that a chain of chords follows an arc.
//!
//! Implements SR-02.

use alloc::vec::Vec;
use core::fmt;

use super::lattice::{Length, Point};
use super::predicate::{Orientation, on_ring, sagitta};
use super::segment::{Segment, distance_2, orientation, points_within};
use super::width::Product;

/// Smallest radius of an arc, in lattice units (0.64 µm). The chord-error bound of [`ArcChords::check`] is
/// not proved below it.
pub const RADIUS_MIN: i64 = 64;

/// Rounding of an arc's ends. With ρ = ⌊|from − centre|⌋ the curve stays between ρ − 1 and ρ + 2 from the
/// centre.
const ENDS: (i8, i8) = (1, 2);
/// Rounding of the corners of its chords: they lie between ρ − 2 and ρ + 3 from the centre.
const CORNERS: (i8, i8) = (2, 3);
/// The greatest difference between a radius in one of the two rings and a radius in the other.
const RING_WIDTH: i64 = 4;

/// The direction of travel along an arc.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Turn {
    /// Counter-clockwise (G3).
    CounterClockwise,
    /// Clockwise (G2).
    Clockwise,
}

impl Turn {
    /// The other direction.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::CounterClockwise => Self::Clockwise,
            Self::Clockwise => Self::CounterClockwise,
        }
    }

    fn agrees_with(self, orientation: Orientation) -> bool {
        matches!(
            (self, orientation),
            (Self::CounterClockwise, Orientation::Left) | (Self::Clockwise, Orientation::Right)
        )
    }
}

/// A circular arc with distinct ends, about a lattice centre.
///
/// It stands for *any* curve from `from` to `to` that turns about `centre` and stays between ρ − 1 and ρ + 2
/// lattice units from it, with ρ = ⌊|from − centre|⌋. So its ends need not lie exactly on one circle about
/// the centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Arc {
    from: Point,
    to: Point,
    centre: Point,
    turn: Turn,
    radius: Length,
}

/// Why an arc, or a chain of chords for it, is invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArcError {
    /// The ends are the same point. A full circle needs two arcs.
    EndsCoincide {
        /// The common point.
        at: Point,
    },
    /// The radius is below 0.64 µm or above 5.37 m.
    Radius {
        /// The square of the radius, in square lattice units.
        radius_2: i64,
    },
    /// A point is off the arc's circle by more than the permitted rounding: 1 unit inward or 2 outward for an
    /// end, 2 inward or 3 outward for a chord's corner, counted from ρ.
    OffCircle {
        /// The point.
        at: Point,
    },
    /// The chain does not begin and end at the ends of the arc.
    Ends,
    /// A chord is longer than the radius or does not advance in the arc's direction.
    Chord {
        /// The start of the chord.
        at: Point,
    },
}

impl fmt::Display for ArcError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::EndsCoincide { at } => write!(f, "the arc begins and ends at {at}: split it into two arcs"),
            Self::Radius { radius_2 } => {
                write!(f, "the arc radius is out of range: its square is {radius_2} lattice units")
            }
            Self::OffCircle { at } => write!(f, "{at} is not on the arc's circle"),
            Self::Ends => write!(f, "the chords do not begin and end at the ends of the arc"),
            Self::Chord { at } => {
                write!(f, "the chord from {at} is too long or runs against the arc's direction")
            }
        }
    }
}

impl core::error::Error for ArcError {}

impl Arc {
    /// Checks that both ends lie on one circle about `centre`.
    ///
    /// # Errors
    /// [`ArcError`] when the ends coincide, the radius is out of range, or `to` is off the circle by more
    /// than rounding.
    pub fn new(from: Point, to: Point, centre: Point, turn: Turn) -> Result<Self, ArcError> {
        if from == to {
            return Err(ArcError::EndsCoincide { at: from });
        }
        let radius_2 = distance_2(from, centre);
        let radius = match Length::from_units(radius_2.isqrt()) {
            Ok(radius) if i64::from(radius.units()) >= RADIUS_MIN => radius,
            _ => return Err(ArcError::Radius { radius_2 }),
        };
        let arc = Self { from, to, centre, turn, radius };
        if arc.has_on_circle(to, ENDS) { Ok(arc) } else { Err(ArcError::OffCircle { at: to }) }
    }

    /// The start point.
    #[must_use]
    pub fn from(&self) -> Point {
        self.from
    }

    /// The end point.
    #[must_use]
    pub fn to(&self) -> Point {
        self.to
    }

    /// The centre.
    #[must_use]
    pub fn centre(&self) -> Point {
        self.centre
    }

    /// The direction of travel.
    #[must_use]
    pub fn turn(&self) -> Turn {
        self.turn
    }

    /// ρ, the distance from the centre to the start, rounded down, in lattice units.
    #[must_use]
    pub fn radius(&self) -> Length {
        self.radius
    }

    /// The same arc in the opposite direction.
    ///
    /// # Errors
    /// [`ArcError::OffCircle`] when rounding makes the reversed arc miss its other end.
    pub fn reversed(&self) -> Result<Self, ArcError> {
        Self::new(self.to, self.from, self.centre, self.turn.reversed())
    }

    /// Whether `to` is ahead of `from` in the arc's direction, by less than half a turn about the centre.
    pub(super) fn is_ahead(&self, from: Point, to: Point) -> bool {
        self.turn.agrees_with(orientation(self.centre, from, to))
    }

    /// Whether the point can be a corner of the arc's chords.
    pub(super) fn has_corner(&self, point: Point) -> bool {
        self.has_on_circle(point, CORNERS)
    }

    /// A point of the ring half-way between two points that are less than half a turn apart. Only a proposal.
    pub(super) fn middle(&self, from: Point, to: Point) -> Option<Point> {
        let (a, b) = (from.minus(self.centre), to.minus(self.centre));
        let sum = |p: i32, q: i32| i64::from(p).saturating_add(i64::from(q));
        let (x, y) = (sum(a.dx, b.dx), sum(a.dy, b.dy));
        let length = x.saturating_mul(x).saturating_add(y.saturating_mul(y)).isqrt();
        let rho = i64::from(self.radius.units());
        let scaled = |c: i64| {
            let doubled = c.saturating_mul(rho).saturating_mul(2).checked_div(length)?;
            Some(doubled.saturating_add(1).div_euclid(2))
        };
        let moved = |c: i32, d: i64| i64::from(c).saturating_add(d);
        Point::from_units(moved(self.centre.x.units(), scaled(x)?), moved(self.centre.y.units(), scaled(y)?))
            .ok()
    }

    fn has_on_circle(&self, point: Point, (inward, outward): (i8, i8)) -> bool {
        on_ring::<Product>(point.into(), self.centre.into(), self.radius.units(), inward, outward)
    }
}

/// A straight segment or a circular arc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// A straight segment.
    Line(Segment),
    /// A circular arc.
    Arc(Arc),
}

impl Curve {
    /// The start point.
    #[must_use]
    pub fn from(&self) -> Point {
        match self {
            Self::Line(segment) => segment.from,
            Self::Arc(arc) => arc.from(),
        }
    }

    /// The end point.
    #[must_use]
    pub fn to(&self) -> Point {
        match self {
            Self::Line(segment) => segment.to,
            Self::Arc(arc) => arc.to(),
        }
    }
}

/// A chain of chords that passed the check against an [`Arc`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArcChords {
    points: Vec<Point>,
    chord_error: Length,
}

impl ArcChords {
    /// Accepts `points` as chords of `arc` after exact checks.
    ///
    /// Each corner lies between ρ − 2 and ρ + 3 from the centre. Each chord advances about the centre in the
    /// arc's direction and is no longer than ρ. The chain begins and ends where the arc does. So it passes
    /// every polar angle of the arc.
    ///
    /// With chords of length at most `L ≤ ρ` and ρ ≥ 64 the sagitta is at most `L² / 7ρ`. At the same polar
    /// angle the radius of the chord lies in [ρ − 2 − L²/7ρ, ρ + 3] and the radius of the curve in [ρ − 1,
    /// ρ + 2]. So the chord-error bound is the sagitta plus 4 units.
    ///
    /// # Errors
    /// [`ArcError`] naming the point that fails the check.
    pub fn check(arc: &Arc, points: Vec<Point>) -> Result<Self, ArcError> {
        if points.len() < 2 || points.first() != Some(&arc.from) || points.last() != Some(&arc.to) {
            return Err(ArcError::Ends);
        }
        let mut longest_2 = 0;
        for pair in points.windows(2) {
            let &[a, b] = pair else { continue };
            if !arc.has_on_circle(b, CORNERS) {
                return Err(ArcError::OffCircle { at: b });
            }
            let advances = arc.turn.agrees_with(orientation(arc.centre, a, b));
            if !advances || points_within(a, b, arc.radius).is_clear() {
                return Err(ArcError::Chord { at: a });
            }
            longest_2 = longest_2.max(distance_2(a, b));
        }
        let sagitta = sagitta::<Product>(longest_2, arc.radius.units());
        let chord_error = Length::from_units(sagitta.saturating_add(RING_WIDTH))
            .map_err(|_| ArcError::Radius { radius_2: distance_2(arc.from, arc.centre) })?;
        Ok(Self { points, chord_error })
    }

    /// The corners of the chain, first and last included.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The chord-error bound: no point of the arc is farther from the chain.
    #[must_use]
    pub fn chord_error(&self) -> Length {
        self.chord_error
    }

    /// The chords in order.
    pub fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        self.points.windows(2).filter_map(|pair| match *pair {
            [from, to] => Some(Segment { from, to }),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    fn quarter() -> Arc {
        Arc::new(at(1000, 0), at(0, 1000), Point::ORIGIN, Turn::CounterClockwise).unwrap()
    }

    #[test]
    fn valid_chain_is_accepted_with_its_chord_error() {
        let chords = ArcChords::check(&quarter(), vec![at(1000, 0), at(707, 707), at(0, 1000)]).unwrap();
        // True sagitta of a 45° chord of radius 1000: 1000·(1 − cos 22.5°) = 76.1.
        assert!(
            chords.chord_error().units() >= 77 && chords.chord_error().units() <= 90,
            "{:?}",
            chords.chord_error()
        );
    }

    #[test]
    fn wrong_chains_are_rejected() {
        let arc = quarter();
        let rejects = |points| ArcChords::check(&arc, points).unwrap_err();
        assert_eq!(rejects(vec![at(1000, 0), at(0, 1000)]), ArcError::Chord { at: at(1000, 0) });
        assert_eq!(rejects(vec![at(1000, 0), at(707, 707)]), ArcError::Ends);
        assert_eq!(
            rejects(vec![at(1000, 0), at(704, 704), at(0, 1000)]),
            ArcError::OffCircle { at: at(704, 704) }
        );
        let backwards = vec![at(1000, 0), at(707, -707), at(707, 707), at(0, 1000)];
        assert_eq!(rejects(backwards), ArcError::Chord { at: at(1000, 0) });
        assert_eq!(rejects(vec![]), ArcError::Ends);
    }

    #[test]
    fn impossible_arcs_are_rejected() {
        let new = |from, to, centre| Arc::new(from, to, centre, Turn::Clockwise);
        assert_eq!(new(at(9, 9), at(9, 9), at(0, 0)), Err(ArcError::EndsCoincide { at: at(9, 9) }));
        assert_eq!(new(at(1000, 0), at(0, 1003), at(0, 0)), Err(ArcError::OffCircle { at: at(0, 1003) }));
        assert!(new(at(1000, 0), at(0, 1002), at(0, 0)).is_ok());
        assert_eq!(new(at(30, 0), at(0, 30), at(0, 0)), Err(ArcError::Radius { radius_2: 900 }));
    }

    #[test]
    fn chains_that_begin_or_end_elsewhere_are_rejected() {
        let arc = quarter();
        let rejects = |points| ArcChords::check(&arc, points).unwrap_err();
        assert_eq!(rejects(vec![at(966, 259), at(707, 707), at(0, 1000)]), ArcError::Ends, "first");
        assert_eq!(rejects(vec![at(1000, 0), at(707, 707), at(259, 966)]), ArcError::Ends, "last");
    }
}

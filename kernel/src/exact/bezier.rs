//! Rational Bézier curves, and the check that a curve follows a chain of lines and arcs. Implements SR-02.

use alloc::vec::Vec;
use core::fmt;

use super::arc::{Arc, Curve};
use super::lattice::{Length, Point};
use super::segment::{Segment, points_within};

/// Highest degree of a curve.
pub const DEGREE_MAX: usize = 15;
/// The permitted range of weights. The upper bound is 2^16 times the lower one. So a weight rounded to an
/// integer moves no point of the curve by more than 2^-24 of its size.
pub const WEIGHTS: (u64, u64) = (1 << 24, 1 << 40);

/// Most control points of a piece.
const PLACES: usize = DEGREE_MAX + 1;
/// Most halvings of the parameter. After 30 halvings of a curve as long as the lattice no piece is longer
/// than a unit or two.
const DEPTH_MAX: usize = 32;
/// Halvings allowed per curve of the chain, and once more for the whole check.
const PIECES_EACH: usize = 2048;
/// Extra binary places of a coordinate times a weight.
const PLACES_MORE: u32 = 40;

/// Control points of one piece, relative to the first control point of the whole curve: x·w, y·w and w.
///
/// With |x| ≤ 2^30, w ≤ 2^40 and 40 extra places each number is below 2^111. So the sum of two fits `i128`.
type Row = [[i128; 3]; PLACES];

/// A rational Bézier curve with control points on the lattice.
///
/// The curve is Σ Bᵢ(t)·wᵢ·pᵢ / Σ Bᵢ(t)·wᵢ for t in [0, 1], with the Bernstein polynomials Bᵢ. It lies in the
/// convex hull of its control points (Farin, Curves and Surfaces for CAGD, §13.7).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bezier {
    control: Vec<Point>,
    weights: Vec<u64>,
}

/// Why control points and weights do not form a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BezierError {
    /// There are fewer than two control points, more than [`DEGREE_MAX`] allows, or a different number of
    /// weights.
    Count {
        /// The number of control points.
        points: usize,
        /// The number of weights.
        weights: usize,
    },
    /// A weight is out of range.
    Weight {
        /// The weight.
        weight: u64,
    },
}

impl fmt::Display for BezierError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { points, weights } => {
                write!(
                    f,
                    "a curve of degree 1 to {DEGREE_MAX} needs one weight per control point; \
                     this one has {points} control points and {weights} weights"
                )
            }
            Self::Weight { weight } => {
                write!(f, "the weight {weight} is outside the range {} to {}", WEIGHTS.0, WEIGHTS.1)
            }
        }
    }
}

impl core::error::Error for BezierError {}

/// A place where the check did not find that the curve follows the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stray {
    /// The place.
    pub at: Point,
}

impl Bezier {
    /// A curve from its control points and weights, after a check of their counts and ranges.
    ///
    /// # Errors
    /// [`BezierError`] when a count or a weight is out of range.
    pub fn new(control: Vec<Point>, weights: Vec<u64>) -> Result<Self, BezierError> {
        let points = control.len();
        if !(2..=PLACES).contains(&points) || weights.len() != points {
            return Err(BezierError::Count { points, weights: weights.len() });
        }
        match weights.iter().find(|weight| !(WEIGHTS.0..=WEIGHTS.1).contains(*weight)) {
            Some(&weight) => Err(BezierError::Weight { weight }),
            None => Ok(Self { control, weights }),
        }
    }

    /// The control points.
    #[must_use]
    pub fn control(&self) -> &[Point] {
        &self.control
    }

    /// The weights.
    #[must_use]
    pub fn weights(&self) -> &[u64] {
        &self.weights
    }

    /// Checks that the curve follows the chain within `chord_error`. Each curve of the chain begins where the
    /// one before it ends.
    ///
    /// **Claim.** The parameter range of the curve splits into consecutive intervals, one for each curve of
    /// the chain in order. On its interval every point is beside that curve. "Beside" means within
    /// `chord_error` of a line. For an arc of less than half a turn it means within `chord_error` of the
    /// circle of radius ρ about its centre and between the rays to its ends, or within `chord_error` of an
    /// end. Where one interval ends and the next begins, the point is within `chord_error` of the joint. So
    /// every point of the curve is within `chord_error` of the chain. The curve is continuous, so every point
    /// of the chain is within twice that of the curve.
    ///
    /// The check halves the curve until the convex hull of each piece's control points lies beside the
    /// current curve of the chain. It may also lie beside the next curve, if the piece begins near the joint.
    /// The check rounds the control points to the lattice. Rounding and halving together add less than a
    /// unit, and `chord_error` is reduced by it.
    ///
    /// # Errors
    /// [`Stray`] with a place where the curve leaves the chain, or where the limit of halvings ended the
    /// check.
    pub fn follows(&self, chain: &[Curve], chord_error: Length) -> Result<(), Stray> {
        let origin = self.control.first().copied().unwrap_or(Point::ORIGIN);
        let refused = Err(Stray { at: origin });
        let Ok(chord_error) = Length::from_units(i64::from(chord_error.units()).saturating_sub(1)) else {
            return refused;
        };
        let joins =
            |pair: &[Curve]| pair.iter().skip(1).zip(pair).all(|(next, curve)| curve.to() == next.from());
        let ends = (chain.first().map(Curve::from), chain.last().map(Curve::to));
        let own = (self.control.first().copied(), self.control.last().copied());
        if ends != own || !chain.windows(2).all(joins) || !chain.iter().all(is_short_of_half_a_turn) {
            return refused;
        }
        let mut row: Row = [[0; 3]; PLACES];
        for ((place, point), &weight) in row.iter_mut().zip(&self.control).zip(&self.weights) {
            let d = point.minus(origin);
            let weight = i128::from(weight) << PLACES_MORE;
            *place =
                [i128::from(d.dx).saturating_mul(weight), i128::from(d.dy).saturating_mul(weight), weight];
        }
        let left = chain.len().saturating_mul(PIECES_EACH).saturating_add(PIECES_EACH);
        let mut search = Search { origin, chain, chord_error, count: self.control.len(), left, reached: 0 };
        search.piece(&row, 0)?;
        search.finish()
    }
}

struct Search<'a> {
    origin: Point,
    chain: &'a [Curve],
    chord_error: Length,
    /// Control points of each piece.
    count: usize,
    /// Countdown of halvings: the check gives up at zero.
    left: usize,
    /// The curve of the chain that was beside the last piece.
    reached: usize,
}

impl Search<'_> {
    fn piece(&mut self, row: &Row, depth: usize) -> Result<(), Stray> {
        let mut points = [self.origin; PLACES];
        for (point, place) in points.iter_mut().zip(row).take(self.count) {
            *point = self.rounded(*place).ok_or(Stray { at: self.origin })?;
        }
        let hull = points.get(..self.count).unwrap_or(&points);
        if self.goes_on(hull) {
            return Ok(());
        }
        self.left = self.left.saturating_sub(1);
        if depth >= DEPTH_MAX || self.left == 0 {
            return Err(Stray { at: hull.first().copied().unwrap_or(self.origin) });
        }
        let (first, second) = halved(row, self.count);
        self.piece(&first, depth.saturating_add(1))?;
        self.piece(&second, depth.saturating_add(1))
    }

    /// Whether the piece is beside the current curve of the chain, or begins near the joint and is beside the
    /// next.
    fn goes_on(&mut self, hull: &[Point]) -> bool {
        let (Some(current), Some(&first)) = (self.chain.get(self.reached), hull.first()) else {
            return false;
        };
        if is_beside(hull, current, self.chord_error) {
            return true;
        }
        let next = self.reached.saturating_add(1);
        let near_joint = !points_within(first, current.to(), self.chord_error).is_clear();
        let goes_on =
            near_joint && self.chain.get(next).is_some_and(|curve| is_beside(hull, curve, self.chord_error));
        if goes_on {
            self.reached = next;
        }
        goes_on
    }

    /// The walk may end before the last curves of the chain only when all their joints are near the end. They
    /// turn less than half a turn, so they are short then.
    fn finish(&self) -> Result<(), Stray> {
        let Some(end) = self.chain.last().map(Curve::to) else { return Err(Stray { at: self.origin }) };
        let left = self.chain.iter().skip(self.reached).map(Curve::to);
        let mut far = left.filter(|&joint| points_within(joint, end, self.chord_error).is_clear());
        far.next().map_or(Ok(()), |at| Err(Stray { at }))
    }

    /// The control point, rounded to the nearest lattice point.
    fn rounded(&self, [x, y, w]: [i128; 3]) -> Option<Point> {
        let nearest = |c: i128| {
            let doubled = c.saturating_mul(2).saturating_add(w);
            i64::try_from(doubled.checked_div_euclid(w.saturating_mul(2))?).ok()
        };
        let moved = |c: i32, d: i64| i64::from(c).saturating_add(d);
        Point::from_units(
            moved(self.origin.x.units(), nearest(x)?),
            moved(self.origin.y.units(), nearest(y)?),
        )
        .ok()
    }
}

/// The two halves of the curve, by de Casteljau's algorithm at 1/2.
///
/// Each mean is rounded down by less than 1. The least weight with its extra places is 2^64. All rounds of
/// all halvings together lose less than 2^10. So every quotient loses less than (2^30 + 1)·2^10 / 2^64, far
/// below a unit.
fn halved(row: &Row, count: usize) -> (Row, Row) {
    let (mut first, mut second) = ([[0; 3]; PLACES], [[0; 3]; PLACES]);
    let mut means = *row;
    for round in 0..count {
        let last = count.saturating_sub(1).saturating_sub(round);
        if let (Some(place), Some(mean)) = (first.get_mut(round), means.first()) {
            *place = *mean;
        }
        if let (Some(place), Some(mean)) = (second.get_mut(last), means.get(last)) {
            *place = *mean;
        }
        for i in 0..last {
            if let (Some(&a), Some(&b)) = (means.get(i), means.get(i.saturating_add(1)))
                && let Some(mean) = means.get_mut(i)
            {
                *mean = core::array::from_fn(|k| {
                    let side = |v: [i128; 3]| v.get(k).copied().unwrap_or(0);
                    side(a).saturating_add(side(b)) >> 1
                });
            }
        }
    }
    (first, second)
}

fn is_short_of_half_a_turn(curve: &Curve) -> bool {
    match curve {
        Curve::Line(_) => true,
        Curve::Arc(arc) => arc.is_ahead(arc.from(), arc.to()),
    }
}

/// Whether the whole convex hull of the points is beside the curve.
fn is_beside(hull: &[Point], curve: &Curve, chord_error: Length) -> bool {
    let near_end = |end: Point| hull.iter().all(|&p| !points_within(p, end, chord_error).is_clear());
    match curve {
        Curve::Line(segment) => hull.iter().all(|&p| !segment.near_point(p, chord_error).is_clear()),
        Curve::Arc(arc) => is_along(hull, arc, chord_error) || near_end(arc.from()) || near_end(arc.to()),
    }
}

/// Whether the hull lies between the rays to the arc's ends, and within the chord error of its circle.
fn is_along(hull: &[Point], arc: &Arc, chord_error: Length) -> bool {
    let (from, to, centre) = (arc.from(), arc.to(), arc.centre());
    if !arc.is_ahead(from, to) {
        return false;
    }
    // Rays less than half a turn apart bound a convex wedge.
    let in_wedge = |p: Point| !arc.is_ahead(p, from) && !arc.is_ahead(to, p);
    let Ok(outer) = arc.radius().plus(chord_error) else { return false };
    let in_disc = |p: Point| !points_within(p, centre, outer).is_clear();
    if !hull.iter().all(|&p| in_wedge(p) && in_disc(p)) {
        return false;
    }
    let inner = i64::from(arc.radius().units()).saturating_sub(i64::from(chord_error.units()));
    let Ok(inner) = Length::from_units(inner) else { return true };
    // The outline of the hull is among the segments between its points. It does not go round the tip of the
    // wedge.
    hull.iter().enumerate().all(|(i, &from)| {
        let others = hull.iter().skip(i);
        others.into_iter().all(|&to| Segment { from, to }.near_point(centre, inner).is_clear())
    })
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::super::arc::Turn;
    use super::*;

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    fn chord_error(units: i64) -> Length {
        Length::from_units(units).unwrap()
    }

    /// A quarter circle of 1 mm radius, exact: weights 1, 1, 2 (Farin §12.7).
    fn quarter() -> Bezier {
        let w = WEIGHTS.0;
        Bezier::new(vec![at(100_000, 0), at(100_000, 100_000), at(0, 100_000)], vec![w, w, w << 1]).unwrap()
    }

    #[test]
    fn quarter_circle_follows_its_arc_and_not_its_chord() {
        let arc = Arc::new(at(100_000, 0), at(0, 100_000), Point::ORIGIN, Turn::CounterClockwise).unwrap();
        assert_eq!(quarter().follows(&[Curve::Arc(arc)], chord_error(4)), Ok(()));
        let chord = Curve::Line(Segment { from: at(100_000, 0), to: at(0, 100_000) });
        // The sagitta is 100 000·(1 − cos 45°) = 29 289.3.
        assert_eq!(quarter().follows(&[chord], chord_error(29_292)), Ok(()));
        assert!(quarter().follows(&[chord], chord_error(29_289)).is_err());
    }

    #[test]
    fn arcs_off_by_more_than_the_chord_error_are_refused() {
        // Arcs about centres moved along the bisector bend less or more. In the middle they are off by 0.29
        // of that move.
        for (moved, wrong) in [(-60, true), (60, true), (-15, false), (15, false)] {
            let arc =
                Arc::new(at(100_000, 0), at(0, 100_000), at(moved, moved), Turn::CounterClockwise).unwrap();
            assert_eq!(quarter().follows(&[Curve::Arc(arc)], chord_error(14)).is_err(), wrong, "{moved}");
        }
        // The other three quarters of the circle are not beside the curve. The check also refuses half a turn
        // or more.
        let rest = Arc::new(at(100_000, 0), at(0, 100_000), Point::ORIGIN, Turn::Clockwise).unwrap();
        assert!(quarter().follows(&[Curve::Arc(rest)], chord_error(8)).is_err());
        // One half as an arc, the other as a chord: the stray place is in the second half.
        let half =
            Arc::new(at(100_000, 0), at(70_711, 70_711), Point::ORIGIN, Turn::CounterClockwise).unwrap();
        let chord = Curve::Line(Segment { from: at(70_711, 70_711), to: at(0, 100_000) });
        let stray = quarter().follows(&[Curve::Arc(half), chord], chord_error(8)).unwrap_err();
        assert!((stray.at.x.units() - 70_711).abs() < 2_000, "{stray:?}");
        assert_eq!(
            quarter().follows(&[chord, Curve::Arc(half)], chord_error(8)),
            Err(Stray { at: at(100_000, 0) })
        );
        assert!(quarter().follows(&[Curve::Arc(half)], chord_error(8)).is_err(), "it ends early");
    }

    /// A point within the chord error of some curve of the chain is not enough. The check refuses a chain
    /// that leaves the curve through a neck and comes back, by lines or by two arcs.
    #[test]
    fn chains_that_leave_the_curve_and_come_back_are_refused() {
        let w = WEIGHTS.1;
        let line = Bezier::new(vec![at(0, 0), at(100_000, 0)], vec![w; 2]).unwrap();
        let path = |points: &[(i64, i64)]| -> Vec<Curve> {
            let ends = points.iter().zip(points.iter().skip(1));
            ends.map(|(&(a, b), &(c, d))| Curve::Line(Segment { from: at(a, b), to: at(c, d) })).collect()
        };
        assert_eq!(
            line.follows(&path(&[(0, 0), (50_000, 0), (50_004, 0), (100_000, 0)]), chord_error(8)),
            Ok(())
        );
        let pocket = [
            (0, 0),
            (50_000, 0),
            (50_000, -900),
            (60_000, -900),
            (60_000, -1_000),
            (50_004, -1_000),
            (50_004, 0),
            (100_000, 0),
        ];
        assert!(line.follows(&path(&pocket), chord_error(8)).is_err());
        let spur = [(0, 0), (50_000, 0), (50_002, -9_000), (50_004, 0), (100_000, 0)];
        assert!(line.follows(&path(&spur), chord_error(8)).is_err());
        let arc = |from, to, centre| Curve::Arc(Arc::new(from, to, centre, Turn::CounterClockwise).unwrap());
        let round = [
            path(&[(0, 0), (50_000, 0)])[0],
            arc(at(50_000, 0), at(50_001, -2_000), at(50_000, -1_000)),
            arc(at(50_001, -2_000), at(50_000, 0), at(50_001, -1_000)),
            path(&[(50_000, 0), (100_000, 0)])[0],
        ];
        assert!(line.follows(&round, chord_error(8)).is_err());
        // One arc of nearly a full turn, with its ends beside each other.
        let all_round =
            Arc::new(at(50_000, 0), at(50_002, 0), at(50_001, -1_000), Turn::CounterClockwise).unwrap();
        let [before, after] = [path(&[(0, 0), (50_000, 0)])[0], path(&[(50_002, 0), (100_000, 0)])[0]];
        assert!(line.follows(&[before, Curve::Arc(all_round), after], chord_error(8)).is_err());
        // Beside every line of a Z in turn, but never near the joint of its first two lines.
        let rising = Bezier::new(vec![at(0, 0), at(100_000, 30)], vec![w; 2]).unwrap();
        let zigzag = path(&[(0, 0), (60_000, 0), (40_000, 30), (100_000, 30)]);
        assert!(rising.follows(&zigzag, chord_error(17)).is_err());
        // A gap of a few units.
        assert!(line.follows(&[before, after], chord_error(8)).is_err());
        // Backwards, traversed twice, and from another start.
        assert!(line.follows(&path(&[(100_000, 0), (0, 0)]), chord_error(8)).is_err());
        assert!(line.follows(&path(&[(0, 0), (100_000, 0), (0, 0), (100_000, 0)]), chord_error(8)).is_err());
        assert!(line.follows(&path(&[(0, 1), (100_000, 0)]), chord_error(8)).is_err());
    }

    #[test]
    fn loop_of_the_curve_is_detected() {
        // Both ends are on the line, the middle is far from it.
        let w = WEIGHTS.1;
        let curve =
            Bezier::new(vec![at(0, 0), at(9_000, 8_000), at(-8_000, 8_000), at(1_000, 0)], vec![w; 4]);
        let line = Curve::Line(Segment { from: at(0, 0), to: at(1_000, 0) });
        assert!(curve.unwrap().follows(&[line], chord_error(100)).is_err());
    }

    #[test]
    fn invalid_curves_and_empty_chains_are_refused() {
        assert!(Bezier::new(vec![at(0, 0)], vec![WEIGHTS.0]).is_err());
        assert!(Bezier::new(vec![at(0, 0); 17], vec![WEIGHTS.0; 17]).is_err());
        assert!(Bezier::new(vec![at(0, 0); 3], vec![WEIGHTS.0; 2]).is_err());
        assert!(Bezier::new(vec![at(0, 0); 2], vec![1, WEIGHTS.0]).is_err());
        assert!(Bezier::new(vec![at(0, 0); 2], vec![WEIGHTS.0, WEIGHTS.1 + 1]).is_err());
        let edge =
            Bezier::new(vec![at(-(1 << 29), -(1 << 29)), at(1 << 29, 1 << 29)], vec![WEIGHTS.1; 2]).unwrap();
        assert!(edge.follows(&[], chord_error(100)).is_err());
        assert!(edge.follows(&[], Length::ZERO).is_err());
    }
}

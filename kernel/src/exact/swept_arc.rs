//! The test whether a disc that runs along an arc stays clear of a chord.
//!
//! Implements SR-02.
//!
//! As in [`super::arc`], an arc stands for any curve that turns about its centre c and stays between ρ − 1
//! and ρ + 2 from it. A chord is clear of the curve by more than t when one of four rules holds. Each rule is
//! sound. Together they decide all cases but the last few units.
//!
//! 1. *Inside.* Both ends of the chord are within ρ − 2 − t of c, so all of it is. The curve is t + 1 farther
//!    out.
//! 2. *Outside.* The chord is farther than ρ + 2 + t from c, and the curve is no farther than ρ + 2.
//! 3. *Chord of the arc.* Take a piece of the curve between points a and b of the ring, with |ab| = L ≤ ρ. It
//!    leaves the segment ab by at most s = L²/7ρ + 5 ([`ArcChords::check`](super::arc::ArcChords::check)).
//!    The chord is farther than t + s from ab.
//! 4. *Corner.* An end v of the chord is within 3 of c, and ρ ≥ t + 13. Seen from c, neither a nor b lies
//!    more than 4 ahead along the chord's direction. A curve point P of the piece is αa + βb with α + β ≤
//!    1.25 for pieces of at most 60°. So P is at most 5 ahead of c and 8 ahead of v, and |P − v| ≥ ρ − 4. Its
//!    distance from the chord's line ahead of v is at least √((t + 9)² − 64) > t, and its distance from v
//!    itself is at least t + 9.

use super::arc::{Arc, Turn};
use super::lattice::{Length, Point};
use super::predicate::{Proximity, sagitta};
use super::segment::{Segment, Window, ahead, distance_2, points_within};
use super::width::Product;

/// Most pieces of an arc: eighths of a turn.
const PIECES: usize = 8;
/// Halvings of a piece. The longest piece is an eighth of a turn at the largest radius, 4.2 m. After 24
/// halvings it is 26 units long.
const HALVINGS: u32 = 24;

/// An arc in pieces of at most an eighth of a turn, ready for distance tests.
#[derive(Clone, Copy, Debug)]
pub struct SweptArc {
    arc: Arc,
    corners: [Point; PIECES + 1],
    count: usize,
}

impl SweptArc {
    /// Cuts the arc into pieces. Returns `None` when rounding prevents it, as for very small radii.
    #[must_use]
    pub fn of(arc: &Arc) -> Option<Self> {
        let mut swept = Self { arc: *arc, corners: [arc.from(); PIECES + 1], count: 0 };
        let mut at = arc.from();
        // Whole quarter turns, while the end lies beyond the next one.
        for _ in 0..4 {
            let next = quarter(arc, at)?;
            if swept.reaches_before(at, next) {
                swept.push_halves(at, arc.to())?;
                return Some(swept);
            }
            swept.push_halves(at, next)?;
            at = next;
        }
        None
    }

    /// Whether the arc ends on the quarter turn from `at` to `next`: its end lies ahead of `at`, and `next`
    /// lies ahead of its end or on it.
    fn reaches_before(&self, at: Point, next: Point) -> bool {
        let to = self.arc.to();
        self.arc.is_ahead(at, to) && (to == next || self.arc.is_ahead(to, next))
    }

    fn push_halves(&mut self, from: Point, to: Point) -> Option<()> {
        if from == to {
            return Some(());
        }
        let middle = self
            .arc
            .middle(from, to)
            .filter(|&middle| self.follows(from, middle) && self.follows(middle, to));
        for corner in middle.into_iter().chain([to]) {
            let from = self.corners.get(self.count).copied()?;
            if !self.follows(from, corner) {
                return None;
            }
            self.count = self.count.saturating_add(1);
            *self.corners.get_mut(self.count)? = corner;
        }
        Some(())
    }

    /// Whether rule 3 applies to the piece between the two points.
    fn follows(&self, from: Point, to: Point) -> bool {
        let short = !points_within(from, to, self.arc.radius()).is_clear();
        short && self.arc.is_ahead(from, to) && (to == self.arc.to() || self.arc.has_corner(to))
    }

    fn pieces(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let corners = self.corners.get(..=self.count).unwrap_or(&[]);
        corners.iter().copied().zip(corners.iter().copied().skip(1))
    }

    /// A box that holds the curve: each piece is within its chord error of its chord.
    #[must_use]
    pub fn bounds(&self) -> Window {
        let start = Window::of(self.arc.from());
        self.pieces().fold(start, |bounds, (a, b)| {
            let chord_error = self.chord_error(a, b).unwrap_or(self.arc.radius());
            bounds.union(Segment { from: a, to: b }.bounds().grown(chord_error))
        })
    }

    /// [`Proximity::Clear`] when the four rules prove that the curve is farther than `t` from the chord.
    #[must_use]
    pub fn near_chord(&self, chord: Segment, t: Length) -> Proximity {
        let (centre, radius, t_units) = (self.arc.centre(), self.arc.radius(), i64::from(t.units()));
        let rho = i64::from(radius.units());
        let inside = |r: Length| {
            !points_within(chord.from, centre, r).is_clear() && !points_within(chord.to, centre, r).is_clear()
        };
        let outside = |r: Length| chord.near_point(centre, r).is_clear();
        if Length::from_units(rho.saturating_sub(2).saturating_sub(t_units)).is_ok_and(inside)
            || Length::from_units(rho.saturating_add(2).saturating_add(t_units)).is_ok_and(outside)
        {
            return Proximity::Clear;
        }
        let clear = self.pieces().all(|(a, b)| self.piece_clear(a, b, chord, t, HALVINGS));
        if clear { Proximity::Clear } else { Proximity::Near }
    }

    fn piece_clear(&self, a: Point, b: Point, chord: Segment, t: Length, halvings: u32) -> bool {
        let reach = self.chord_error(a, b).and_then(|chord_error| t.plus(chord_error).ok());
        if reach.is_some_and(|reach| Segment { from: a, to: b }.near_segment(chord, reach).is_clear())
            || self.behind_corner(a, b, chord, t)
            || self.behind_corner(a, b, Segment { from: chord.to, to: chord.from }, t)
        {
            return true;
        }
        let Some(halvings) = halvings.checked_sub(1) else { return false };
        let middle =
            self.arc.middle(a, b).filter(|&middle| self.follows(a, middle) && self.follows(middle, b));
        middle.is_some_and(|middle| {
            self.piece_clear(a, middle, chord, t, halvings) && self.piece_clear(middle, b, chord, t, halvings)
        })
    }

    /// The bound s of rule 3.
    fn chord_error(&self, a: Point, b: Point) -> Option<Length> {
        let sagitta = sagitta::<Product>(distance_2(a, b), self.arc.radius().units());
        Length::from_units(sagitta.saturating_add(5)).ok()
    }

    /// Rule 4 for the end `chord.from`.
    fn behind_corner(&self, a: Point, b: Point, chord: Segment, t: Length) -> bool {
        let centre = self.arc.centre();
        let behind = |point| !ahead(centre, point, chord, 4);
        let room = i64::from(self.arc.radius().units()) >= i64::from(t.units()).saturating_add(13);
        room && !points_within(chord.from, centre, Length::small(3)).is_clear() && behind(a) && behind(b)
    }
}

/// The point of the ring a quarter turn after `at`. It is exact, because the coordinates only change places
/// and signs.
fn quarter(arc: &Arc, at: Point) -> Option<Point> {
    let d = at.minus(arc.centre());
    let turned = match arc.turn() {
        Turn::CounterClockwise => (d.dy.checked_neg()?, d.dx),
        Turn::Clockwise => (d.dy, d.dx.checked_neg()?),
    };
    let coordinate = |c: i32, d: i32| i64::from(c).saturating_add(i64::from(d));
    let centre = arc.centre();
    Point::from_units(coordinate(centre.x.units(), turned.0), coordinate(centre.y.units(), turned.1)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    #[test]
    fn arcs_of_all_turns_are_cut_and_cover_their_sweep() {
        for (to, turn, least) in [
            (at(0, 1000), Turn::CounterClockwise, 2),
            (at(0, 1000), Turn::Clockwise, 6),
            (at(-1000, 0), Turn::CounterClockwise, 4),
            (at(998, 60), Turn::CounterClockwise, 1),
            (at(998, 60), Turn::Clockwise, 7),
            (at(998, -60), Turn::CounterClockwise, 7),
        ] {
            let arc = Arc::new(at(1000, 0), to, Point::ORIGIN, turn).unwrap();
            let swept = SweptArc::of(&arc).unwrap();
            assert!(swept.count >= least, "{to:?} {turn:?} {}", swept.count);
            assert_eq!(swept.corners[swept.count], to);
        }
    }

    #[test]
    fn each_rule_decides_where_it_should() {
        let arc = Arc::new(at(3000, 0), at(0, 3000), Point::ORIGIN, Turn::CounterClockwise).unwrap();
        let swept = SweptArc::of(&arc).unwrap();
        let near = |from, to, t| swept.near_chord(Segment { from, to }, Length::from_units(t).unwrap());
        // Inside and outside.
        assert!(near(at(100, 100), at(-100, 50), 2800).is_clear());
        assert!(!near(at(100, 100), at(-100, 50), 2900).is_clear());
        assert!(near(at(6000, 5000), at(5000, 6000), 4000).is_clear());
        // Behind the corner: the chord leaves the centre away from the arc.
        assert!(near(at(0, 0), at(-9000, -1), 2980).is_clear());
        assert!(near(at(0, 0), at(-9000, 0), 2987).is_clear());
        assert!(!near(at(0, 0), at(-9000, 0), 2999).is_clear());
        assert!(!near(at(0, 0), at(-9000, 900), 2980).is_clear(), "the end of the arc is ahead");
        // The far side of the circle does not matter: only the quarter is swept.
        assert!(near(at(-3000, -10), at(-3000, 10), 2000).is_clear());
        assert!(!near(at(3000, 10), at(3100, 900), 20).is_clear());
    }

    #[test]
    fn pieces_follow_the_ring_forward_and_short() {
        let arc = Arc::new(at(3000, 0), at(0, 3000), Point::ORIGIN, Turn::CounterClockwise).unwrap();
        let swept = SweptArc::of(&arc).unwrap();
        let east = at(3000, 0);
        assert!(swept.follows(east, at(2121, 2121)));
        assert!(!swept.follows(at(2121, 2121), east), "backward");
        assert!(!swept.follows(east, at(2110, 2110)), "off the ring");
        assert!(!swept.follows(east, at(0, 3000)), "longer than the radius");
        // The end of the arc passes without the ring test of corners.
        assert!(swept.follows(at(2121, 2121), arc.to()));
    }

    #[test]
    fn each_rule_decides_alone_by_a_unit() {
        let arc = Arc::new(at(3000, 0), at(0, 3000), Point::ORIGIN, Turn::CounterClockwise).unwrap();
        let swept = SweptArc::of(&arc).unwrap();
        let near = |from, to, t| swept.near_chord(Segment { from, to }, Length::from_units(t).unwrap());
        // Inside: a chord that touches the circle of radius 1000 from within.
        assert!(near(at(600, 800), at(800, 600), 1998).is_clear());
        // Outside: the chord is 4000 from the centre.
        assert!(near(at(4000, -9), at(4000, 5000), 997).is_clear());
        assert!(!near(at(4000, -9), at(4000, 5000), 1000).is_clear());
        // Behind a corner two units off the centre, with either end first.
        assert!(near(at(-2, 0), at(-5000, -5000), 2987).is_clear());
        assert!(near(at(-5000, -5000), at(-2, 0), 2987).is_clear());
        assert!(!near(at(-4, 0), at(-5000, -5000), 2996).is_clear(), "too far from the centre for rule 4");
    }
}

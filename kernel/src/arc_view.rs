//! Circular arcs in `f64`, for proposals and for display. Nothing here is trusted.

use core::f64::consts::TAU;

use libm::{atan2, cos, fmod, sin, sqrt};

use crate::exact::arc::{Arc, Turn};
use crate::vec2::Vec2;

/// Bound on the rounding error of an angle, radians.
const ANGLE_ROUNDING: f64 = 1e-9;

/// A circular arc in `f64`: what an exact [`Arc`] looks like. Use it for proposals and for display only.
///
/// Angles are in radians. Lengths are in lattice units, or in the unit of the numbers that made the arc. The
/// functions of `libm` give the same numbers on every platform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcView {
    /// The centre.
    pub centre: Vec2,
    /// The radius.
    pub radius: f64,
    /// The polar angle of the start about the centre.
    pub start: f64,
    /// The angle from the start to the end: positive is counter-clockwise.
    pub sweep: f64,
}

impl ArcView {
    /// The view of an exact arc, in lattice units. The radius is measured at its start.
    #[must_use]
    pub fn of(arc: &Arc) -> Self {
        Self::between(Vec2::from(arc.from()), Vec2::from(arc.to()), Vec2::from(arc.centre()), arc.turn())
    }

    /// The arc about `centre` from one point to the direction of another. Equal directions make a full
    /// circle.
    #[must_use]
    pub fn between(from: Vec2, to: Vec2, centre: Vec2, turn: Turn) -> Self {
        let arc = Self::starting_at(from, centre, 0.0);
        let (start, end) = (arc.start, polar_angle(centre, to));
        let sweep = match turn {
            Turn::CounterClockwise => one_turn(end - start),
            Turn::Clockwise => -one_turn(start - end),
        };
        Self { sweep, ..arc }
    }

    /// The arc about `centre` that starts at `from` and turns by `sweep`.
    #[must_use]
    pub fn starting_at(from: Vec2, centre: Vec2, sweep: f64) -> Self {
        let radius = from.distance(centre);
        Self { centre, radius, start: polar_angle(centre, from), sweep }
    }

    /// The arc from one point through a second to a third. `None` if they lie on a straight line.
    #[must_use]
    pub fn through(from: Vec2, by: Vec2, to: Vec2) -> Option<Self> {
        let (u, v) = (by - from, to - from);
        let (twice_area, uu, vv) = (u.cross(v), u.dot(u), v.dot(v));
        if twice_area.abs() < 1e-12 * vv {
            return None;
        }
        let scale = 2.0 * twice_area;
        let centre = from + (u.left() * vv - v.left() * uu) / scale;
        // The arc turns counter-clockwise if the second point lies to the right of the chord.
        let turn = if twice_area > 0.0 { Turn::CounterClockwise } else { Turn::Clockwise };
        Some(Self::between(from, to, centre, turn))
    }

    /// The same arc with all its lengths multiplied by `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { centre: self.centre * factor, radius: self.radius * factor, ..*self }
    }

    /// The same arc, mirrored at the x axis.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let centre = Vec2 { y: -self.centre.y, ..self.centre };
        Self { centre, radius: self.radius, start: -self.start, sweep: -self.sweep }
    }

    /// The same arc in a unit that is `factor` times as large.
    #[must_use]
    pub fn in_unit(&self, factor: f64) -> Self {
        Self { centre: self.centre / factor, radius: self.radius / factor, ..*self }
    }

    /// The direction of travel.
    #[must_use]
    pub fn turn(&self) -> Turn {
        if self.sweep > 0.0 { Turn::CounterClockwise } else { Turn::Clockwise }
    }

    /// 1 for a counter-clockwise arc, −1 for a clockwise one.
    #[must_use]
    pub fn sign(&self) -> f64 {
        if self.sweep > 0.0 { 1.0 } else { -1.0 }
    }

    /// The signed curvature: positive for a counter-clockwise arc.
    #[must_use]
    pub fn curvature(&self) -> f64 {
        self.sign() / self.radius
    }

    /// The length.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.radius * self.sweep.abs()
    }

    /// Whether the arc is a full circle, up to rounding.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.sweep.abs() >= TAU - ANGLE_ROUNDING
    }

    /// The polar angle at a share of the arc, 0 to 1.
    #[must_use]
    pub fn angle(&self, share: f64) -> f64 {
        self.start + self.sweep * share
    }

    /// The point at a share of the arc, 0 to 1.
    #[must_use]
    pub fn at(&self, share: f64) -> Vec2 {
        self.at_angle(self.angle(share))
    }

    /// The unit vector of travel at a share of the arc, 0 to 1.
    #[must_use]
    pub fn direction(&self, share: f64) -> Vec2 {
        self.direction_at_angle(self.angle(share))
    }

    /// The point of the circle at a polar angle.
    #[must_use]
    pub fn at_angle(&self, angle: f64) -> Vec2 {
        Vec2::new(self.centre.x + self.radius * cos(angle), self.centre.y + self.radius * sin(angle))
    }

    /// The unit vector of travel at a polar angle.
    #[must_use]
    pub fn direction_at_angle(&self, angle: f64) -> Vec2 {
        let sign = self.sign();
        Vec2::new(-sin(angle) * sign, cos(angle) * sign)
    }

    /// The direction of travel beside a point, as long as the point's distance from the centre. It needs no
    /// trigonometry.
    #[must_use]
    pub fn direction_beside(&self, point: Vec2) -> Vec2 {
        (point - self.centre).left() * self.sign()
    }

    /// The angle from the start forward to the direction of a point, in [0, 2π).
    #[must_use]
    pub fn angle_to(&self, point: Vec2) -> f64 {
        let angle = polar_angle(self.centre, point);
        let turned = if self.sweep > 0.0 { angle - self.start } else { self.start - angle };
        let turned = fmod(turned, TAU);
        if turned < 0.0 { turned + TAU } else { turned }
    }

    /// The share of the arc at the direction of a point. `None` if the arc does not pass that direction.
    #[must_use]
    pub fn share_beside(&self, point: Vec2) -> Option<f64> {
        let turned = self.angle_to(point);
        (turned <= self.sweep.abs()).then(|| turned / self.sweep.abs())
    }

    /// The same arc in the opposite direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { start: self.start + self.sweep, sweep: -self.sweep, ..*self }
    }

    /// The section between two shares of the arc.
    #[must_use]
    pub fn part(&self, from: f64, to: f64) -> Self {
        Self { start: self.angle(from), sweep: self.sweep * (to - from), ..*self }
    }

    /// The arc at distance `d` to the right, with the same centre. Its radius is negative if there is none.
    #[must_use]
    pub fn offset_right(&self, d: f64) -> Self {
        Self { radius: if self.sweep > 0.0 { self.radius + d } else { self.radius - d }, ..*self }
    }

    /// Twice the signed area between the arc and its chord: positive for a counter-clockwise arc.
    #[must_use]
    pub fn double_segment_area(&self) -> f64 {
        self.radius * self.radius * (self.sweep - sin(self.sweep))
    }

    /// The distance between the arc and its chords, if it has `count` equal ones.
    #[must_use]
    pub fn sagitta(&self, count: f64) -> f64 {
        self.radius * (1.0 - cos(self.sweep.abs() / count / 2.0))
    }

    /// The length of a chord with this sagitta, to first order.
    #[must_use]
    pub fn chord_length(&self, sagitta: f64) -> f64 {
        sqrt(8.0 * sagitta * self.radius)
    }
}

/// The point on the perpendicular bisector of two points that is nearest to `centre`.
///
/// Ends and centres on the lattice fit each other only to a unit. About this point they fit exactly.
#[must_use]
pub fn onto_bisector(centre: Vec2, from: Vec2, to: Vec2) -> Vec2 {
    let chord = to - from;
    let off = (centre - from.midpoint(to)).dot(chord) / chord.dot(chord);
    centre - chord * off
}

/// The polar angle of a point about the centre, in [−π, π].
fn polar_angle(centre: Vec2, point: Vec2) -> f64 {
    atan2(point.y - centre.y, point.x - centre.x)
}

/// The angle in (0, 2π] that differs from this difference of two polar angles by full turns.
fn one_turn(turned: f64) -> f64 {
    if turned <= 0.0 { turned + TAU } else { turned }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::exact::lattice::Point;

    fn near(a: Vec2, b: Vec2) -> bool {
        a.distance(b) < 1e-9
    }

    #[test]
    fn view_of_an_exact_arc_passes_its_ends() {
        let at = |x, y| Point::from_units(x, y).unwrap();
        for (turn, sweep) in [(Turn::CounterClockwise, FRAC_PI_2), (Turn::Clockwise, -3.0 * FRAC_PI_2)] {
            let exact = Arc::new(at(1007, 9), at(7, 1009), at(7, 9), turn).unwrap();
            let arc = ArcView::of(&exact);
            assert!((arc.sweep - sweep).abs() < 1e-12 && arc.turn() == turn && !arc.is_full());
            assert!(near(arc.at(0.0), Vec2::new(1007.0, 9.0)) && near(arc.at(1.0), Vec2::new(7.0, 1009.0)));
            assert!(near(arc.direction(0.0), Vec2::new(0.0, arc.sign())));
            let beside = arc.direction_beside(arc.at(0.3));
            assert!(near(Vec2::new(beside.x / 1000.0, beside.y / 1000.0), arc.direction(0.3)));
            let back = arc.reversed();
            assert!(near(back.at(0.3), arc.at(0.7)) && back.turn() == turn.reversed());
            assert!(near(arc.part(0.2, 0.6).at(0.5), arc.at(0.4)));
        }
    }

    #[test]
    fn shares_are_found_again_on_the_arc_only() {
        for sweep in [-6.0, -1.0, 0.5, 4.0] {
            let arc = ArcView { centre: Vec2::new(3.0, -2.0), radius: 5.0, start: 2.5, sweep };
            for share in [0.1, 0.5, 0.9] {
                assert!((arc.share_beside(arc.at(share)).unwrap() - share).abs() < 1e-9);
            }
            assert_eq!(arc.share_beside(arc.at(1.02)), None);
        }
    }

    /// The expected arcs are known: (0, 5), (5, 0), (−5, 0) and the like lie on a circle about the origin.
    #[test]
    fn arcs_are_found_from_points() {
        let arc = ArcView::through(Vec2::new(0.0, 5.0), Vec2::new(5.0, 0.0), Vec2::new(-5.0, 0.0)).unwrap();
        assert!(near(arc.centre, Vec2::new(0.0, 0.0)) && (arc.sweep + 3.0 * FRAC_PI_2).abs() < 1e-12);
        assert_eq!(ArcView::through(Vec2::new(0.0, 0.0), Vec2::new(1.0, 1.0), Vec2::new(3.0, 3.0)), None);
        assert_eq!(
            onto_bisector(Vec2::new(1.0, 7.0), Vec2::new(0.0, 0.0), Vec2::new(4.0, 0.0)),
            Vec2::new(2.0, 7.0)
        );
        let full =
            ArcView::between(Vec2::new(5.0, 0.0), Vec2::new(5.0, 0.0), Vec2::new(0.0, 0.0), Turn::Clockwise);
        assert!(full.is_full() && (full.length() - 5.0 * TAU).abs() < 1e-12);
    }
}

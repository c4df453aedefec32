//! An offset shape as a track with a parameter, and the part of it that an edge covers. Proposals only.
//!
//! The parameter grows along the track. It is the length on a straight track, and the share of the sweep on a
//! general arc. On a bend of less than half a circle it is 1 − cos θ, which needs no trigonometry.

use core::f64::consts::{PI, TAU};

use libm::{acos, atan2, cos, sin, sqrt};

use super::plane::PlaneCurve;
use crate::arc_view::ArcView;
use crate::vec2::Vec2;

/// Largest radius of a bend (lattice units, 0.1 m). Above it the track uses angles, because 1 − cos θ is too
/// inaccurate for their small values.
const FLAT: f64 = 1e7;

/// An offset shape, ready for subtraction of its covered parts.
#[derive(Clone, Copy, Debug)]
pub enum Track {
    Straight {
        from: Vec2,
        along: Vec2,
        length: f64,
    },
    /// The arc, and the unit vector from its centre to its start.
    Bend(ArcView, Vec2),
    General(PlaneCurve),
}

/// A straight edge, with its unit direction and its length.
#[derive(Clone, Copy, Debug)]
pub struct StraightWall {
    pub from: Vec2,
    pub to: Vec2,
    pub along: Vec2,
    pub length: f64,
}

impl StraightWall {
    pub fn of(shape: &PlaneCurve) -> Option<Self> {
        match *shape {
            PlaneCurve::Line { from, to } => {
                let d = to - from;
                let length = sqrt(d.dot(d));
                (length > 0.0).then(|| Self { from, to, along: d / length, length })
            }
            PlaneCurve::Arc(_) => None,
        }
    }
}

impl StraightWall {
    fn distance(&self, p: Vec2) -> f64 {
        let w = p - self.from;
        let foot = w.dot(self.along).clamp(0.0, self.length);
        w.distance(self.along * foot)
    }
}

impl Track {
    pub fn of(shape: &PlaneCurve) -> Self {
        match *shape {
            PlaneCurve::Line { from, to } => {
                let d = to - from;
                let length = sqrt(d.dot(d)).max(f64::MIN_POSITIVE);
                Self::Straight { from, along: d / length, length }
            }
            PlaneCurve::Arc(arc) if arc.sweep.abs() < 0.99 * PI && arc.radius < FLAT => {
                Self::Bend(arc, Vec2::new(cos(arc.start), sin(arc.start)))
            }
            PlaneCurve::Arc(_) => Self::General(*shape),
        }
    }

    /// The parameter at the end of the track. It is 0 at the start.
    pub fn end(&self) -> f64 {
        match *self {
            Self::Straight { length, .. } => length,
            Self::Bend(arc, _) => 1.0 - cos(arc.sweep.abs()),
            Self::General(_) => 1.0,
        }
    }

    /// The point at a parameter.
    pub fn at(&self, p: f64) -> Vec2 {
        match *self {
            Self::Straight { from, along, .. } => from + along * p,
            Self::Bend(arc, start) => {
                let (turn, (c, s)) = (arc.sign(), (1.0 - p, sqrt((p * (2.0 - p)).max(0.0))));
                arc.centre + (start * c + start.left() * s * turn) * arc.radius
            }
            Self::General(shape) => shape.at(p),
        }
    }

    /// The share of the whole track, 0 to 1, at a parameter.
    pub fn share(&self, p: f64) -> f64 {
        match *self {
            Self::Straight { length, .. } => p / length,
            Self::Bend(arc, _) => acos((1.0 - p).clamp(-1.0, 1.0)) / arc.sweep.abs(),
            Self::General(_) => p,
        }
    }

    fn parameter(&self, share: f64) -> f64 {
        match *self {
            Self::Straight { length, .. } => share * length,
            Self::Bend(arc, _) => 1.0 - cos(share * arc.sweep.abs()),
            Self::General(_) => share,
        }
    }

    /// The approximate length between two parameters.
    pub fn length_between(&self, p: f64, q: f64) -> f64 {
        match *self {
            Self::Straight { .. } => q - p,
            Self::Bend(..) => self.at(q).distance(self.at(p)),
            Self::General(shape) => (q - p) * shape.length(),
        }
    }

    /// A box of the track between two parameters: `(min x, min y, max x, max y)`.
    pub fn bounds(&self, p: f64, q: f64) -> (f64, f64, f64, f64) {
        let (a, b) = (self.at(p), self.at(q));
        let bulge = match *self {
            Self::Straight { .. } => 0.0,
            // The sagitta of less than half a circle is at most half its chord.
            Self::Bend(..) => b.distance(a) / 2.0,
            Self::General(shape) => match shape {
                PlaneCurve::Arc(arc) => 2.0 * arc.radius,
                PlaneCurve::Line { .. } => 0.0,
            },
        };
        (a.x.min(b.x) - bulge, a.y.min(b.y) - bulge, a.x.max(b.x) + bulge, a.y.max(b.y) + bulge)
    }

    /// Calls `covered` with the intervals of parameters whose points are within `r` of the straight edge.
    #[inline]
    pub fn covered_by_wall(&self, wall: &StraightWall, r: f64, mut covered: impl FnMut(f64, f64)) {
        match *self {
            Self::Straight { from, along, .. } => {
                if let Some((low, high)) = straight_in_capsule(from, along, wall, r) {
                    covered(low, high);
                }
            }
            Self::Bend(arc, start) if (arc.radius - r).abs() < 1.0 => {
                let Some((entry, exit)) = circle_in_capsule(arc.centre, arc.radius, wall, r) else {
                    // The circle lies wholly inside or wholly outside the capsule.
                    if wall.distance(self.at(self.end() / 2.0)) < r {
                        covered(-2.0, 2.0);
                    }
                    return;
                };
                let parameter = |u: Vec2| bend_parameter(start, arc.sign(), u);
                let (low, high) = (parameter(entry), parameter(exit));
                let (low, high) = if arc.sweep > 0.0 { (low, high) } else { (high, low) };
                if low <= high {
                    covered(low, high);
                    return;
                }
                // The interval wraps round the back. Or the contact is so short that rounding swapped its
                // ends, and it covers nothing.
                let end = self.end();
                for (a, b) in [(low, 2.0), (-2.0, high)] {
                    let middle = self.at(f64::midpoint(a.clamp(0.0, end), b.clamp(0.0, end)));
                    if wall.distance(middle) < r {
                        covered(a, b);
                    }
                }
            }
            // A circle beside an arc of the profile can cross a capsule four times.
            Self::Bend(..) | Self::General(_) => {
                let edge = PlaneCurve::Line { from: wall.from, to: wall.to };
                self.covered_by(&edge, r, covered);
            }
        }
    }

    /// As [`Track::covered_by_wall`] for any edge. Cuts the track where it meets the curve at distance `r`
    /// around the edge, and tests the middle of each piece.
    pub fn covered_by(&self, edge: &PlaneCurve, r: f64, mut covered: impl FnMut(f64, f64)) {
        let shape = self.shape();
        let circle = |centre| PlaneCurve::Arc(ArcView { centre, radius: r, start: 0.0, sweep: TAU });
        let around = [
            edge.offset_right(r),
            edge.reversed().offset_right(r),
            Some(circle(edge.at(0.0))),
            Some(circle(edge.at(1.0))),
        ];
        let mut cuts = [1.0; 10];
        cuts[0] = 0.0;
        let mut count = 1;
        for other in around.into_iter().flatten() {
            for cut in shape.meetings(&other, 1.0).into_iter().flatten() {
                cuts[count] = cut;
                count += 1;
            }
        }
        cuts[..=count].sort_by(f64::total_cmp);
        for pair in cuts[..=count].windows(2) {
            if edge.distance(shape.at(f64::midpoint(pair[0], pair[1]))) < r {
                covered(self.parameter(pair[0]), self.parameter(pair[1]));
            }
        }
    }

    fn shape(&self) -> PlaneCurve {
        match *self {
            Self::Straight { from, along, length } => PlaneCurve::Line { from, to: from + along * length },
            Self::Bend(arc, start) => PlaneCurve::Arc(ArcView { start: atan2(start.y, start.x), ..arc }),
            Self::General(shape) => shape,
        }
    }
}

/// 1 − cos θ of a direction from a bend's centre. It is negative for directions before the start.
fn bend_parameter(start: Vec2, turn: f64, u: Vec2) -> f64 {
    let forward = start.cross(u) * turn >= 0.0;
    let p = 1.0 - start.dot(u);
    if forward { p } else { -p }
}

/// The interval of parameters at which a line is in the capsule of radius `r` around the wall. The capsule is
/// convex.
#[inline]
fn straight_in_capsule(from: Vec2, along: Vec2, wall: &StraightWall, r: f64) -> Option<(f64, f64)> {
    let mut low = f64::INFINITY;
    let mut high = f64::NEG_INFINITY;
    let mut add = |a: f64, b: f64| {
        low = low.min(a);
        high = high.max(b);
    };
    for end in [wall.from, wall.to] {
        let w = end - from;
        let (near, off) = (w.dot(along), along.cross(w));
        let half_2 = r * r - off * off;
        if half_2 > 0.0 {
            let half = sqrt(half_2);
            add(near - half, near + half);
        }
    }
    // Beside the wall: |off| < r and the foot is within the wall. Both are linear in the parameter.
    let w = from - wall.from;
    let (off, off_rate) = (wall.along.cross(w), wall.along.cross(along));
    let (foot, foot_rate) = (wall.along.dot(w), wall.along.dot(along));
    let (a, b) = linear_within(off, off_rate, -r, r);
    let (c, d) = linear_within(foot, foot_rate, 0.0, wall.length);
    let (a, b) = (a.max(c), b.min(d));
    if a < b {
        add(a, b);
    }
    (low < high).then_some((low, high))
}

/// The interval of parameters at which `value + rate · p` is between `low` and `high`.
#[inline]
fn linear_within(value: f64, rate: f64, low: f64, high: f64) -> (f64, f64) {
    if rate.abs() < 1e-15 {
        let inside = low < value && value < high;
        return if inside { (f64::NEG_INFINITY, f64::INFINITY) } else { (f64::INFINITY, f64::NEG_INFINITY) };
    }
    let (p, q) = ((low - value) / rate, (high - value) / rate);
    (p.min(q), p.max(q))
}

/// The directions in which a circle enters and leaves the capsule of radius `r` around the wall,
/// counter-clockwise.
///
/// The circle runs around a corner, and its radius is within 1 unit of `r`. Two sums of disjoint convex sets
/// with one disc have boundaries that cross at most twice. Returns `None` when the circle is wholly outside
/// or inside, or its contact is too short to decide.
#[inline]
fn circle_in_capsule(centre: Vec2, radius: f64, wall: &StraightWall, r: f64) -> Option<(Vec2, Vec2)> {
    let w = centre - wall.from;
    let (foot, off) = (wall.along.dot(w), wall.along.cross(w));
    let beyond = (-foot).max(foot - wall.length).max(0.0);
    if beyond * beyond + off * off >= (radius + r) * (radius + r) {
        return None;
    }
    let (mut entry, mut exit) = (None, None);
    // In the wall's frame x runs along it and y to its left. The centre is at (foot, off). A direction u
    // meets the boundary at P = centre + radius · u. It enters when the counter-clockwise tangent points
    // against the outward normal there.
    let mut consider = |u: Vec2, normal: Vec2| {
        let tangent = u.left();
        *(if tangent.dot(normal) < 0.0 { &mut entry } else { &mut exit }) = Some(u);
    };
    for (x, ahead) in [(0.0, -1.0), (wall.length, 1.0)] {
        let to = Vec2::new(x - foot, -off);
        let distance_2 = to.dot(to);
        if distance_2 < 1e-6 {
            continue;
        }
        // |radius · u − to| = r.
        let k = (radius * radius + distance_2 - r * r) / (2.0 * radius);
        let rest = distance_2 - k * k;
        if rest <= 0.0 {
            continue;
        }
        let q = sqrt(rest);
        for sign in [-1.0, 1.0] {
            let u = (to * k + to.left() * q * sign) / distance_2;
            let from_end = u * radius - to;
            if from_end.x * ahead >= 0.0 {
                consider(u, from_end);
            }
        }
    }
    for side in [-r, r] {
        let y = (side - off) / radius;
        if y.abs() < 1.0 {
            let x = sqrt(1.0 - y * y);
            for u in [Vec2::new(x, y), Vec2::new(-x, y)] {
                if (0.0..=wall.length).contains(&(foot + radius * u.x)) {
                    consider(u, Vec2::new(0.0, side));
                }
            }
        }
    }
    let turned = |u: Vec2| wall.along * u.x + wall.along.left() * u.y;
    Some((turned(entry?), turned(exit?)))
}

//! Plane geometry in `f64` for the search: vectors, curves, intersections. Proposals only.

use libm::{atan2, sqrt};

use crate::arc_view::{ArcView, onto_bisector};
use crate::curve::{Curve, hypot, xy};

/// A point or vector, in lattice units.
pub type Xy = (f64, f64);

pub fn minus(a: Xy, b: Xy) -> Xy {
    (a.0 - b.0, a.1 - b.1)
}

pub fn plus(a: Xy, b: Xy, factor: f64) -> Xy {
    (a.0 + b.0 * factor, a.1 + b.1 * factor)
}

pub fn dot(a: Xy, b: Xy) -> f64 {
    a.0 * b.0 + a.1 * b.1
}

pub fn cross(a: Xy, b: Xy) -> f64 {
    a.0 * b.1 - a.1 * b.0
}

pub fn norm(a: Xy) -> f64 {
    hypot(a.0, a.1)
}

pub fn unit(a: Xy) -> Xy {
    let length = norm(a);
    if length > 0.0 { (a.0 / length, a.1 / length) } else { (0.0, 0.0) }
}

/// The vector turned by −90°: to the right of its direction.
pub fn right_of(a: Xy) -> Xy {
    (a.1, -a.0)
}

/// The vector turned by 90°: to the left of its direction.
pub fn left_of(a: Xy) -> Xy {
    (-a.1, a.0)
}

/// A directed line or arc.
#[derive(Clone, Copy, Debug)]
pub enum PlaneCurve {
    Line { from: Xy, to: Xy },
    Arc(ArcView),
}

/// Two shapes meet in a cusp when the cosine of their turn is below the negative of this: within 0.26° of
/// reversal.
const CUSP: f64 = 0.999_99;

impl PlaneCurve {
    pub fn of(curve: &Curve) -> Self {
        match curve {
            Curve::Line(segment) => Self::Line { from: xy(segment.from), to: xy(segment.to) },
            // Offsets must join much better than to a unit.
            Curve::Arc(arc) => {
                let (from, to) = (xy(arc.from()), xy(arc.to()));
                let centre = onto_bisector(xy(arc.centre()), from, to);
                Self::Arc(ArcView::between(from, to, centre, arc.turn()))
            }
        }
    }

    pub fn reversed(self) -> Self {
        match self {
            Self::Line { from, to } => Self::Line { from: to, to: from },
            Self::Arc(arc) => Self::Arc(arc.reversed()),
        }
    }

    pub fn length(&self) -> f64 {
        match *self {
            Self::Line { from, to } => norm(minus(to, from)),
            Self::Arc(arc) => arc.length(),
        }
    }

    /// The point at `t` in [0, 1].
    pub fn at(&self, t: f64) -> Xy {
        match *self {
            Self::Line { from, to } => plus(from, minus(to, from), t),
            Self::Arc(arc) => arc.at(t),
        }
    }

    /// The unit direction of travel at `t`.
    pub fn direction(&self, t: f64) -> Xy {
        match *self {
            Self::Line { from, to } => unit(minus(to, from)),
            Self::Arc(arc) => arc.direction(t),
        }
    }

    /// The shape at distance `d` to the right, if it exists.
    pub fn offset_right(&self, d: f64) -> Option<Self> {
        match *self {
            Self::Line { from, to } => {
                let normal = right_of(unit(minus(to, from)));
                Some(Self::Line { from: plus(from, normal, d), to: plus(to, normal, d) })
            }
            Self::Arc(arc) => {
                let beside = arc.offset_right(d);
                (beside.radius > 1.0).then_some(Self::Arc(beside))
            }
        }
    }

    /// Whether `next`, which runs back along this shape, lies on its left. Then the material is between the
    /// two.
    fn is_left_of_return(&self, next: &Self) -> bool {
        let away = 0.25 * self.length().min(next.length());
        let before = self.at(1.0 - away / self.length());
        let after = next.at(away / next.length());
        cross(self.direction(1.0), minus(after, before)) > 0.0
    }

    /// The arc of radius `d` around the corner from this shape to the next, if the corner is convex on the
    /// right.
    pub fn corner_right(&self, next: &Self, d: f64) -> Option<Self> {
        let (incoming, outgoing) = (self.direction(1.0), next.direction(0.0));
        let (sine, cosine) = (cross(incoming, outgoing), dot(incoming, outgoing));
        // At a cusp the directions cannot distinguish a spike of material from a notch of zero width. Points
        // a little away on both shapes can.
        let cusp = cosine < -CUSP;
        let convex = if cusp { self.is_left_of_return(next) } else { sine > 0.0 };
        if !convex {
            return None;
        }
        let turned = if cusp { core::f64::consts::PI } else { atan2(sine, cosine) };
        let normal = right_of(incoming);
        let start = atan2(normal.1, normal.0);
        let arc = ArcView { centre: self.at(1.0), radius: d, start, sweep: turned };
        (turned * d > 1.0).then_some(Self::Arc(arc))
    }

    pub fn part(&self, t0: f64, t1: f64) -> Self {
        match *self {
            Self::Line { .. } => Self::Line { from: self.at(t0), to: self.at(t1) },
            Self::Arc(arc) => Self::Arc(arc.part(t0, t1)),
        }
    }

    /// The distance from `p`.
    pub fn distance(&self, p: Xy) -> f64 {
        match *self {
            Self::Line { from, to } => {
                let d = minus(to, from);
                let length_2 = dot(d, d);
                let t =
                    if length_2 > 0.0 { (dot(minus(p, from), d) / length_2).clamp(0.0, 1.0) } else { 0.0 };
                norm(minus(p, plus(from, d, t)))
            }
            Self::Arc(arc) => match arc.share_beside(p) {
                Some(_) => (norm(minus(p, arc.centre)) - arc.radius).abs(),
                None => norm(minus(p, arc.at(0.0))).min(norm(minus(p, arc.at(1.0)))),
            },
        }
    }

    /// The parameters on this shape of its intersections with the full line or circle of `other`. Keeps an
    /// intersection that is on this shape and near `other`.
    pub fn meetings(&self, other: &Self, tolerance: f64) -> [Option<f64>; 2] {
        let points = match (self.carrier(), other.carrier()) {
            (Carrier::Line(p, d), Carrier::Line(q, e)) => {
                let m = cross(d, e);
                if m.abs() > 1e-12 {
                    [Some(plus(p, d, cross(minus(q, p), e) / m)), None]
                } else {
                    [None, None]
                }
            }
            (Carrier::Line(p, d), Carrier::Circle(c, r)) | (Carrier::Circle(c, r), Carrier::Line(p, d)) => {
                line_circle(p, d, c, r)
            }
            (Carrier::Circle(c, r), Carrier::Circle(o, s)) => circle_circle(c, r, o, s),
        };
        points.map(|point| {
            let point = point.filter(|&point| other.distance(point) <= tolerance)?;
            self.parameter(point)
        })
    }

    fn parameter(&self, p: Xy) -> Option<f64> {
        match *self {
            Self::Line { from, to } => {
                let d = minus(to, from);
                let t = dot(minus(p, from), d) / dot(d, d);
                (0.0..=1.0).contains(&t).then_some(t)
            }
            Self::Arc(arc) => arc.share_beside(p),
        }
    }

    fn carrier(&self) -> Carrier {
        match *self {
            Self::Line { from, to } => Carrier::Line(from, unit(minus(to, from))),
            Self::Arc(arc) => Carrier::Circle(arc.centre, arc.radius),
        }
    }

    /// The contribution to twice the signed area about `origin`.
    pub fn double_area(&self, origin: Xy) -> f64 {
        let (a, b) = (minus(self.at(0.0), origin), minus(self.at(1.0), origin));
        let chord = cross(a, b);
        match *self {
            Self::Line { .. } => chord,
            Self::Arc(arc) => chord + arc.double_segment_area(),
        }
    }
}

enum Carrier {
    Line(Xy, Xy),
    Circle(Xy, f64),
}

fn line_circle(p: Xy, d: Xy, centre: Xy, radius: f64) -> [Option<Xy>; 2] {
    let w = minus(p, centre);
    let along = -dot(w, d);
    let off = cross(d, w);
    let half_2 = radius * radius - off * off;
    if half_2 < 0.0 {
        // A near miss of a tangent still divides the curve there.
        let miss = off.abs() - radius;
        return [(miss < 1.0).then(|| plus(p, d, along)), None];
    }
    let half = sqrt(half_2);
    [Some(plus(p, d, along - half)), Some(plus(p, d, along + half))]
}

fn circle_circle(c: Xy, r: f64, o: Xy, s: f64) -> [Option<Xy>; 2] {
    let w = minus(o, c);
    let d = norm(w);
    if d < 1e-9 {
        return [None, None];
    }
    let along = (d * d + r * r - s * s) / (2.0 * d);
    let half_2 = r * r - along * along;
    let axis = (w.0 / d, w.1 / d);
    if half_2 < 0.0 {
        let miss = (d - r - s).max((r - s).abs() - d);
        return [(miss < 1.0).then(|| plus(c, axis, r.min(along))), None];
    }
    let half = sqrt(half_2);
    let foot = plus(c, axis, along);
    [Some(plus(foot, right_of(axis), half)), Some(plus(foot, right_of(axis), -half))]
}

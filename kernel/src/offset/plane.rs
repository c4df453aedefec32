//! Plane geometry in `f64` for the search: vectors, curves, intersections. Proposals only.

use libm::{atan2, sqrt};

use crate::arc_view::{ArcView, onto_bisector};
use crate::curve::Curve;
use crate::vec2::Vec2;

/// A directed line or arc.
#[derive(Clone, Copy, Debug)]
pub enum PlaneCurve {
    Line { from: Vec2, to: Vec2 },
    Arc(ArcView),
}

/// Two shapes meet in a cusp when the cosine of their turn is below the negative of this: within 0.26° of
/// reversal.
const CUSP: f64 = 0.999_99;

impl PlaneCurve {
    pub fn of(curve: &Curve) -> Self {
        match curve {
            Curve::Line(segment) => Self::Line { from: Vec2::from(segment.from), to: Vec2::from(segment.to) },
            // Offsets must join much better than to a unit.
            Curve::Arc(arc) => {
                let (from, to) = (Vec2::from(arc.from()), Vec2::from(arc.to()));
                let centre = onto_bisector(Vec2::from(arc.centre()), from, to);
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
            Self::Line { from, to } => to.distance(from),
            Self::Arc(arc) => arc.length(),
        }
    }

    /// The point at `t` in [0, 1].
    pub fn at(&self, t: f64) -> Vec2 {
        match *self {
            Self::Line { from, to } => from + (to - from) * t,
            Self::Arc(arc) => arc.at(t),
        }
    }

    /// The unit direction of travel at `t`.
    pub fn direction(&self, t: f64) -> Vec2 {
        match *self {
            Self::Line { from, to } => (to - from).unit(),
            Self::Arc(arc) => arc.direction(t),
        }
    }

    /// The shape at distance `d` to the right, if it exists.
    pub fn offset_right(&self, d: f64) -> Option<Self> {
        match *self {
            Self::Line { from, to } => {
                let normal = (to - from).unit().right();
                Some(Self::Line { from: from + normal * d, to: to + normal * d })
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
        self.direction(1.0).cross(after - before) > 0.0
    }

    /// The arc of radius `d` around the corner from this shape to the next, if the corner is convex on the
    /// right.
    pub fn corner_right(&self, next: &Self, d: f64) -> Option<Self> {
        let (incoming, outgoing) = (self.direction(1.0), next.direction(0.0));
        let (sine, cosine) = (incoming.cross(outgoing), incoming.dot(outgoing));
        // At a cusp the directions cannot distinguish a spike of material from a notch of zero width. Points
        // a little away on both shapes can.
        let cusp = cosine < -CUSP;
        let convex = if cusp { self.is_left_of_return(next) } else { sine > 0.0 };
        if !convex {
            return None;
        }
        let turned = if cusp { core::f64::consts::PI } else { atan2(sine, cosine) };
        let normal = incoming.right();
        let start = atan2(normal.y, normal.x);
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
    pub fn distance(&self, p: Vec2) -> f64 {
        match *self {
            Self::Line { from, to } => p.distance(p.nearest_on(from, to)),
            Self::Arc(arc) => match arc.share_beside(p) {
                Some(_) => (p.distance(arc.centre) - arc.radius).abs(),
                None => p.distance(arc.at(0.0)).min(p.distance(arc.at(1.0))),
            },
        }
    }

    /// The parameters on this shape of its intersections with the full line or circle of `other`. Keeps an
    /// intersection that is on this shape and near `other`.
    pub fn meetings(&self, other: &Self, tolerance: f64) -> [Option<f64>; 2] {
        let points = match (self.carrier(), other.carrier()) {
            (Carrier::Line(p, d), Carrier::Line(q, e)) => {
                let m = d.cross(e);
                if m.abs() > 1e-12 { [Some(p + d * ((q - p).cross(e) / m)), None] } else { [None, None] }
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

    fn parameter(&self, p: Vec2) -> Option<f64> {
        match *self {
            Self::Line { from, to } => {
                let d = to - from;
                let t = (p - from).dot(d) / d.dot(d);
                (0.0..=1.0).contains(&t).then_some(t)
            }
            Self::Arc(arc) => arc.share_beside(p),
        }
    }

    fn carrier(&self) -> Carrier {
        match *self {
            Self::Line { from, to } => Carrier::Line(from, (to - from).unit()),
            Self::Arc(arc) => Carrier::Circle(arc.centre, arc.radius),
        }
    }

    /// The contribution to twice the signed area about `origin`.
    pub fn double_area(&self, origin: Vec2) -> f64 {
        let (a, b) = (self.at(0.0) - origin, self.at(1.0) - origin);
        let chord = a.cross(b);
        match *self {
            Self::Line { .. } => chord,
            Self::Arc(arc) => chord + arc.double_segment_area(),
        }
    }
}

enum Carrier {
    Line(Vec2, Vec2),
    Circle(Vec2, f64),
}

fn line_circle(p: Vec2, d: Vec2, centre: Vec2, radius: f64) -> [Option<Vec2>; 2] {
    let w = p - centre;
    let along = -w.dot(d);
    let off = d.cross(w);
    let half_2 = radius * radius - off * off;
    if half_2 < 0.0 {
        // A near miss of a tangent still divides the curve there.
        let miss = off.abs() - radius;
        return [(miss < 1.0).then(|| p + d * along), None];
    }
    let half = sqrt(half_2);
    [Some(p + d * (along - half)), Some(p + d * (along + half))]
}

fn circle_circle(c: Vec2, r: f64, o: Vec2, s: f64) -> [Option<Vec2>; 2] {
    let w = o - c;
    let d = w.length();
    if d < 1e-9 {
        return [None, None];
    }
    let along = (d * d + r * r - s * s) / (2.0 * d);
    let half_2 = r * r - along * along;
    let axis = w / d;
    if half_2 < 0.0 {
        let miss = (d - r - s).max((r - s).abs() - d);
        return [(miss < 1.0).then(|| c + axis * r.min(along)), None];
    }
    let half = sqrt(half_2);
    let foot = c + axis * along;
    [Some(foot + axis.right() * half), Some(foot - axis.right() * half)]
}

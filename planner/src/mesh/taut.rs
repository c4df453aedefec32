//! Paths pulled taut: the shortest path of a disc's centre through a channel.
//!
//! The path bends only around ends of portals, in arcs. The funnel algorithm of
//! D. T. Lee and F. P. Preparata (1984) compares the directions of tangents in place of those to points.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

use keepout_kernel::Vec2;
use keepout_kernel::{Point, curve};

use super::channel::Portal;

/// A place where the path bends: around a corner of the part, or its start or end.
#[derive(Clone, Copy)]
struct Pin {
    centre: Vec2,
    /// 1 with the corner on the left of the path, −1 on the right, 0 for the start and the end.
    bend: f64,
}

/// The funnel: all shortest paths from the start to the last portal.
struct Funnel {
    radius: f64,
    /// The bends that these paths have in common. They part after the last one.
    common: Vec<Pin>,
    /// The bends to the left end of the portal.
    left: VecDeque<Pin>,
    /// The bends to its right end.
    right: VecDeque<Pin>,
}

impl Funnel {
    /// Narrows the funnel to a new end of a portal, on the left or on the right.
    fn add(&mut self, pin: Pin, on_left: bool) {
        let Self { radius, common, left, right } = self;
        let (own, other, sign) = if on_left { (left, right, 1.0) } else { (right, left, -1.0) };
        let apex = |common: &[Pin]| common.last().copied().unwrap_or(pin);
        if own.back().map_or(apex(common), |&last| last).centre == pin.centre {
            return;
        }
        // Angle from the tangent to one pin to the tangent to another, away from this side.
        let inward = |from: Pin, one: Pin, other: Pin| {
            -sign * turned(tangent(from, one, *radius), tangent(from, other, *radius))
        };
        while let Some(&last) = own.back() {
            let before = own.len().checked_sub(2).map_or(apex(common), |index| own[index]);
            let nearer = reach(before, pin, *radius) < reach(before, last, *radius);
            if inward(before, last, pin) < 0.0 && !(pin.bend == 0.0 && nearer) {
                break;
            }
            own.pop_back();
        }
        while let Some(first) = other.front().copied().filter(|_| own.is_empty()) {
            let from = apex(common);
            if inward(from, first, pin) <= 0.0 {
                break;
            }
            if reach(from, pin, *radius) < reach(from, first, *radius) {
                // The way to the other side bends around the new pin.
                common.push(pin);
                while other.len() > 1 && inward(pin, other[0], other[1]) < 0.0 {
                    other.pop_front();
                }
                return;
            }
            common.push(first);
            other.pop_front();
        }
        own.push_back(pin);
    }
}

/// Points of the shortest path from `from` to `to` through the portals, without `from`. The path keeps
/// `radius` lattice units from the ends of the portals. Polygons of arcs of at most `turn` radians stand
/// for its arcs.
#[must_use]
pub fn taut(from: Point, to: Point, portals: &[Portal], radius: f64, turn: f64) -> Vec<Point> {
    let start = Pin { centre: Vec2::from(from), bend: 0.0 };
    let mut funnel = Funnel { radius, common: vec![start], left: VecDeque::new(), right: VecDeque::new() };
    for portal in portals {
        funnel.add(Pin { centre: Vec2::from(portal.left), bend: 1.0 }, true);
        funnel.add(Pin { centre: Vec2::from(portal.right), bend: -1.0 }, false);
    }
    funnel.add(Pin { centre: Vec2::from(to), bend: 0.0 }, true);
    let mut pins = funnel.common;
    pins.extend(funnel.left);
    rounded(&pins, radius, turn)
}

/// Direction of the tangent from one pin to another.
fn tangent(from: Pin, to: Pin, radius: f64) -> f64 {
    let along = to.centre - from.centre;
    let share = (to.bend - from.bend) * radius / along.length().max(f64::MIN_POSITIVE);
    along.y.atan2(along.x) - share.clamp(-1.0, 1.0).asin()
}

/// Length of the tangent from one pin to another.
fn reach(from: Pin, to: Pin, radius: f64) -> f64 {
    let aside = (to.bend - from.bend) * radius;
    let away = from.centre.distance(to.centre);
    (away * away - aside * aside).max(0.0).sqrt()
}

/// Angle from one direction to another, in [−π, π).
fn turned(from: f64, to: f64) -> f64 {
    (to - from + PI).rem_euclid(TAU) - PI
}

/// The path along the pins. Its corners lie on the tangents of the arcs, outside the arcs.
fn rounded(pins: &[Pin], radius: f64, turn: f64) -> Vec<Point> {
    let mut points = Vec::new();
    for triple in pins.windows(3) {
        let (before, pin, after) = (triple[0], triple[1], triple[2]);
        let (into, out) = (tangent(before, pin, radius), tangent(pin, after, radius));
        let bent = (pin.bend * (out - into)).rem_euclid(TAU);
        // A direction is off by rounding, so a turn in the other direction is a small one.
        let bent = if bent > TAU - 0.5 { 0.0 } else { bent };
        let count = (bent / turn).ceil().max(1.0);
        let reach = radius / (bent / (2.0 * count)).cos();
        let mut k = 0.5;
        while k < count {
            let (sin, cos) = (into + pin.bend * bent * k / count).sin_cos();
            points.extend(curve::nearest_point(pin.centre + Vec2::new(sin, -cos) * (pin.bend * reach)));
            k += 1.0;
        }
    }
    points.extend(pins.last().and_then(|end| curve::nearest_point(end.centre).ok()));
    points
}

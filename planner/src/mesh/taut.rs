//! Paths pulled taut: the shortest path of a disc's centre through a channel.
//!
//! The path bends only around ends of portals, in arcs. The funnel algorithm compares the directions of
//! tangents in place of the directions to points.

use std::f64::consts::{PI, TAU};

use keepout_kernel::curve::xy;
use keepout_kernel::{Point, curve};

use super::channel::{Portal, Xy};

/// Directions that differ by less are equal but for rounding, radians.
const SAME: f64 = 1e-9;

/// A place where the path bends: around a corner of the part, or its start or end.
#[derive(Clone, Copy)]
struct Pin {
    centre: Xy,
    /// 1 with the corner on the left of the path, −1 on the right, 0 for the start and the end.
    bend: f64,
}

/// Limit of the directions in which the path can leave a pin: the tangent to another pin.
#[derive(Clone, Copy)]
struct Limit {
    direction: f64,
    pin: Pin,
    /// The last portal that has this pin.
    portal: usize,
}

/// Points of the shortest path from `from` to `to` through the portals, without `from`. The path keeps
/// `radius` lattice units from the ends of the portals. Polygons of arcs of at most `turn` radians stand
/// for its arcs.
#[must_use]
pub fn taut(from: Point, to: Point, portals: &[Portal], radius: f64, turn: f64) -> Vec<Point> {
    let mut pins = vec![Pin { centre: xy(from), bend: 0.0 }];
    let mut first = 0;
    let end = Pin { centre: xy(to), bend: 0.0 };
    // Each round ends nearer to the last portal, or stays there at another pin.
    for _ in 0..2 * portals.len() + 2 {
        let last = pins[pins.len() - 1];
        match next_pin(last, end, portals, first, radius) {
            Some(limit) => {
                pins.push(limit.pin);
                first = limit.portal + 1;
            }
            None => break,
        }
    }
    pins.push(end);
    rounded(&pins, radius, turn)
}

/// The next corner around which the path bends; `None` when it can go straight to the end.
fn next_pin(apex: Pin, end: Pin, portals: &[Portal], first: usize, radius: f64) -> Option<Limit> {
    let (mut left, mut right): (Option<Limit>, Option<Limit>) = (None, None);
    let towards = |pin: Pin, near: Option<Limit>| {
        let direction = tangent(apex, pin, radius);
        near.map_or(direction, |near| near.direction + turned(near.direction, direction))
    };
    for (portal, ends) in portals.iter().enumerate().skip(first) {
        let pin = Pin { centre: xy(ends.left), bend: 1.0 };
        if pin.centre != apex.centre {
            let limit = Limit { direction: towards(pin, left.or(right)), pin, portal };
            if let Some(right) = right.filter(|right| limit.direction < right.direction) {
                return Some(right);
            }
            if left.is_none_or(|left| limit.direction <= left.direction + SAME) {
                left = Some(limit);
            }
        }
        let pin = Pin { centre: xy(ends.right), bend: -1.0 };
        if pin.centre != apex.centre {
            let limit = Limit { direction: towards(pin, right.or(left)), pin, portal };
            if let Some(left) = left.filter(|left| limit.direction > left.direction) {
                return Some(left);
            }
            if right.is_none_or(|right| limit.direction >= right.direction - SAME) {
                right = Some(limit);
            }
        }
    }
    let straight = towards(end, left.or(right));
    left.filter(|left| straight > left.direction).or(right.filter(|right| straight < right.direction))
}

/// Direction of the tangent from one pin to another.
fn tangent(from: Pin, to: Pin, radius: f64) -> f64 {
    let (dx, dy) = (to.centre.0 - from.centre.0, to.centre.1 - from.centre.1);
    let share = (to.bend - from.bend) * radius / dx.hypot(dy).max(f64::MIN_POSITIVE);
    dy.atan2(dx) - share.clamp(-1.0, 1.0).asin()
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
            let (x, y) = (pin.centre.0 + pin.bend * reach * sin, pin.centre.1 - pin.bend * reach * cos);
            points.extend(curve::nearest_point(x, y));
            k += 1.0;
        }
    }
    points.extend(pins.last().and_then(|end| curve::nearest_point(end.centre.0, end.centre.1).ok()));
    points
}

//! Manual mode: from the operator's wish to certified jogs.
//!
//! Everything here proposes a target; [`Guard::jog`] decides.

use std::time::Duration;

use keepout_kernel::clip::{SLIDE_TURNS, contact_band, longest_prefix};
use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{FreePoint, Point, UNITS_PER_MM, Vector};

use super::guard::Guard;
use super::{Command, Counts, Wish};
use crate::time::Time;

/// What the machine can do, as far as steering needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Top speed along one axis, mm/s.
    pub speed_mm_s: f64,
    /// Acceleration, mm/s².
    pub acceleration_mm_s2: f64,
}

/// A wish older than this counts as none: the device is gone, or the program behind it.
const STALE: Duration = Duration::from_millis(250);
/// Below this deflection nothing moves.
const DEAD_ZONE: f64 = 0.03;
/// Jog targets lie on this grid, lattice units (1 µm): they are then written exactly with three decimals.
const GRID: i64 = 100;
/// Jogs shorter than this are not worth sending, mm.
const SHORTEST_MM: f64 = 0.01;
/// A wish that turns by more than this (cosine) cancels what is in flight.
const TURNED: f64 = 0.7;
/// In-flight motion shorter than this is left to end by itself, mm.
const SHORT_QUEUE_MM: f64 = 1.0;

/// What manual mode remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Manual {
    /// A cancel was sent: nothing is sent until the tool has settled.
    cancelling: bool,
    /// Direction of the last jog's wish.
    heading: Option<(f64, f64)>,
}

/// The wish, or none when it is stale or no number.
pub(super) fn fresh(wish: Wish, at: Option<Time>, now: Time) -> Option<(f64, f64)> {
    let (x, y) = wish.direction;
    let length = x.hypot(y);
    let recent = at.is_some_and(|at| now.since(at) <= STALE);
    if !recent || !length.is_finite() || length < DEAD_ZONE {
        return None;
    }
    let scale = 1.0 / length.max(1.0);
    Some((x * scale, y * scale))
}

/// A feed word for a speed, mm/min. Not below 60: slower steps would outlast [`super::guard::DRAIN`].
pub(super) fn feed(speed_mm_s: f64) -> u32 {
    u32::try_from(nearest_unit((speed_mm_s * 60.0).floor())).unwrap_or(1).max(60)
}

impl Manual {
    /// The tool has come to rest with nothing in flight.
    pub(super) fn settle(&mut self) {
        self.cancelling = false;
    }

    /// Nothing is sent until the tool has settled.
    pub(super) fn wait_for_rest(&mut self) {
        self.cancelling = true;
    }

    /// Sends what the wish asks for, as far as it is certified and not already under way.
    pub(super) fn steer(
        &mut self,
        wish: Option<(f64, f64)>,
        round_trip: Duration,
        limits: &Limits,
        guard: &mut Guard,
        counts: &mut Counts,
        commands: &mut Vec<Command>,
    ) {
        // One line at a time is unacknowledged, and none when a cancel leaves: a line that waits for planner space
        // would otherwise be executed after it.
        if self.cancelling || guard.unacknowledged() > 0 {
            return;
        }
        let queued_mm = queue_length_mm(guard);
        let Some((x, y)) = wish else {
            self.cancel_if(!guard.settled(), counts, commands);
            return;
        };
        let length = x.hypot(y);
        let unit = (x / length, y / length);
        let turned = self.heading.is_some_and(|(hx, hy)| hx * unit.0 + hy * unit.1 < TURNED);
        if turned && queued_mm > SHORT_QUEUE_MM {
            self.cancel_if(true, counts, commands);
            self.heading = None;
            return;
        }
        let speed = length * limits.speed_mm_s;
        let horizon = (round_trip.as_secs_f64() * 1.5 + 0.03).clamp(0.06, 2.0);
        let wanted_mm = speed * speed / (2.0 * limits.acceleration_mm_s2) + speed * horizon;
        let missing_mm = wanted_mm - queued_mm;
        if missing_mm < speed * 0.02 {
            return;
        }
        let Some(end) = guard.end() else { return };
        let step =
            |d: f64| i32::try_from(nearest_unit(d * missing_mm * f64::from(UNITS_PER_MM))).unwrap_or(0);
        let wish = Vector { dx: step(unit.0), dy: step(unit.1) };
        if let Some(target) = reach(guard, end, wish, counts)
            && let Ok(certified) = guard.jog(target, feed(speed))
        {
            self.heading = Some(unit);
            counts.jogs += 1;
            commands.push(Command::Move(certified));
        }
    }

    fn cancel_if(&mut self, moving: bool, counts: &mut Counts, commands: &mut Vec<Command>) {
        if moving {
            counts.cancels += 1;
            self.cancelling = true;
            commands.push(Command::Cancel);
        }
    }
}

/// The way along the targets in flight, from where the tool was last known to be, mm.
fn queue_length_mm(guard: &Guard) -> f64 {
    let points: Vec<Point> = guard.in_flight().collect();
    points.windows(2).map(|pair| length_mm(pair[1].minus(pair[0]))).sum()
}

fn length_mm(v: Vector) -> f64 {
    f64::from(v.dx).hypot(f64::from(v.dy)) / f64::from(UNITS_PER_MM)
}

/// The target that goes farthest along the wish: straight, or along the wall when the wall is near.
fn reach(guard: &Guard, end: FreePoint, wish: Vector, counts: &mut Counts) -> Option<Point> {
    let straight = prefix(guard, end.point(), wish);
    let wished = length_mm(wish);
    let gained = straight.map_or(0.0, |p| length_mm(p.minus(end.point())));
    if gained >= wished * 0.999 {
        return straight;
    }
    counts.clipped += 1;
    let wall = guard.part().wall(end, contact_band());
    let Some(wall) = wall.filter(|wall| !wall.is_left_by(wish)) else {
        return straight.filter(|_| gained >= SHORTEST_MM);
    };
    let slides = SLIDE_TURNS.iter().filter_map(|&turn| {
        let along = wall.slide(wish, turn)?;
        let target = prefix(guard, end.point(), along)?;
        let moved = target.minus(end.point());
        let progress = f64::from(moved.dx) * f64::from(along.dx) + f64::from(moved.dy) * f64::from(along.dy);
        let progress = progress / f64::from(along.dx).hypot(f64::from(along.dy)) / f64::from(UNITS_PER_MM);
        Some((progress, target))
    });
    let best = slides.max_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((progress, target))
            if progress > gained && length_mm(target.minus(end.point())) >= SHORTEST_MM =>
        {
            Some(target)
        }
        _ => straight.filter(|_| gained >= SHORTEST_MM),
    }
}

/// The longest admitted prefix of a motion, on the grid; `None` when that is nothing.
fn prefix(guard: &Guard, from: Point, wish: Vector) -> Option<Point> {
    let to = from.translated(wish).ok()?;
    let mut best = None;
    longest_prefix(from, to, |point| {
        let Some(target) = on_grid(point) else { return false };
        let admitted = guard.admits(target).is_ok();
        if admitted {
            best = Some(target);
        }
        admitted
    });
    best.filter(|&target| target != from)
}

fn on_grid(point: Point) -> Option<Point> {
    let round = |c: i32| (i64::from(c) + GRID / 2).div_euclid(GRID) * GRID;
    Point::from_units(round(point.x.units()), round(point.y.units())).ok()
}

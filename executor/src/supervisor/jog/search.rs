//! The search for a jog target: straight, along a wall or along a soft limit, as far as the guard admits.

use keepout_guard::{Admission, Admissions, Certified, FreePlace, Guard, Interpolation};
use keepout_kernel::clip::contact_band;
use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{FreePoint, Height, Length, Point, Segment, UNITS_PER_MM, Vector};
use keepout_planner::Mm2;
use keepout_planner::units::{mm, vector_mm};

use super::feed;
use super::pace::LookAhead;

/// Grid of jog targets, lattice units (1 µm). Three decimals in mm write such a target exactly.
const GRID: i64 = 100;
/// The same, mm.
const GRID_MM: f64 = 0.001;
/// Shortest jog worth sending, mm.
pub(super) const SHORTEST_MM: f64 = 0.01;
/// Step along a wall with non-interpolated axes, mm.
const STAIR_MM: f64 = 0.5;
/// Number of halvings of a motion that the in-flight set blocks: down to one part in 64.
const HALVINGS: u32 = 6;
/// Distance that jogs keep beyond the jogging clearance, so that places on them can be rounded (1 µm).
const ROUNDING: Length = Length::small(100);
/// Least share of the input speed for sliding. With an input straight at the wall (within 3°), the tool rests
/// there.
pub(super) const CREEP: f64 = 0.05;

/// The contact of a proposed jog with the wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallContact {
    /// Unknown: no jog was proposed, or the jog ends short of a wall.
    Unknown,
    /// No contact: the tool goes where the input leads.
    Free,
    /// Contact: the wall shortens the jog, or the jog runs along the wall.
    Wall,
}

/// A push of the stick, and the path already ahead of the tool.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push {
    /// Direction of the push, a unit vector.
    pub(super) unit: Mm2,
    /// Requested speed.
    pub(super) speed_mm_s: f64,
    /// Length of the path ahead of the tool, and the speed at its end.
    pub(super) ahead_mm: f64,
    pub(super) ahead_mm_s: f64,
    pub(super) look: LookAhead,
}

impl Push {
    /// Missing part of the look-ahead distance at a speed, mm. A path ahead at a higher speed takes less
    /// time, so it counts for less.
    pub(super) fn missing_mm(&self, speed_mm_s: f64) -> f64 {
        let lasts = (speed_mm_s / self.ahead_mm_s).min(1.0);
        self.look.distance_mm(speed_mm_s) - self.ahead_mm * lasts
    }

    /// A jog at this share of the speed.
    pub(super) fn jog<'a>(&self, admission: Admission<'a>, share: f64) -> Proposal<'a> {
        Proposal { admission, speed_mm_s: self.speed_mm_s * share }
    }
}

/// An admitted jog and its speed.
#[derive(Debug)]
pub(super) struct Proposal<'a> {
    pub(super) admission: Admission<'a>,
    pub(super) speed_mm_s: f64,
}

/// A search for the target of one jog. It borrows the guard, so it tries all candidates against the same
/// in-flight set.
#[derive(Debug)]
pub(super) struct Search<'a>(Admissions<'a>);

pub(in super::super) fn length_mm(v: Vector) -> f64 {
    vector_mm(v).length()
}

/// A direction times a length in mm, on the lattice.
pub(super) fn vector(Mm2 { x, y }: Mm2, mm: f64) -> Vector {
    let step = |d: f64| i32::try_from(nearest_unit(d * mm * f64::from(UNITS_PER_MM))).unwrap_or(0);
    Vector { dx: step(x), dy: step(y) }
}

/// A share of a vector.
pub(super) fn part_of(v: Vector, share: f64) -> Vector {
    vector(vector_mm(v), share)
}

impl<'a> Search<'a> {
    pub(super) fn new(guard: &'a mut Guard) -> Self {
        Self(guard.admissions())
    }

    pub(super) fn guard(&self) -> &Guard {
        self.0.guard()
    }

    /// The height of the last target: a jog in the plane keeps it.
    fn height(&self) -> Height {
        self.guard().end().map_or(Height::ZERO, FreePlace::height)
    }

    /// Sends the jog that was found.
    pub(super) fn send(self, proposal: Proposal<'a>) -> Certified {
        self.0.jog(proposal.admission, feed(proposal.speed_mm_s))
    }

    /// The jog that follows the push best, straight or along a wall, and its contact.
    pub(super) fn reach(&self, base: FreePoint, push: &Push) -> (Option<Proposal<'a>>, WallContact) {
        let missing_mm = push.missing_mm(push.speed_mm_s);
        let (input, pace) = self.within_travel(base.point(), vector(push.unit, missing_mm));
        if let Some(admission) = self.whole(base, input) {
            return (Some(push.jog(admission, pace)), WallContact::Free);
        }
        let length = length_mm(input).max(1e-9);
        let push = Push { unit: vector_mm(input) / length, speed_mm_s: push.speed_mm_s * pace, ..*push };
        match self.guard().rules().interpolation {
            Interpolation::Linear => self.slide(base, &push, input),
            Interpolation::Independent => self.climb(base, &push, input),
        }
    }

    /// The input up to the soft limit, or along it when the tool is there, and the remaining share of the
    /// speed.
    fn within_travel(&self, from: Point, input: Vector) -> (Vector, f64) {
        let (x0, y0, x1, y1) = self.guard().rules().travel.corners();
        let (x, y) = (from.x.units(), from.y.units());
        let along = Vector { dx: input.dx.clamp(x0 - x, x1 - x), dy: input.dy.clamp(y0 - y, y1 - y) };
        let share =
            |part: i32, whole: i32| if part == whole { 1.0 } else { f64::from(part) / f64::from(whole) };
        let up_to_there = share(along.dx, input.dx).min(share(along.dy, input.dy));
        if up_to_there * length_mm(input) >= SHORTEST_MM {
            return (part_of(input, up_to_there), 1.0);
        }
        (along, (length_mm(along) / length_mm(input).max(1e-9)).clamp(CREEP, 1.0))
    }

    /// The jog for a push that meets the part, with non-interpolated axes. It is straight, along a wall
    /// parallel to an axis, or a step of one axis.
    fn climb(&self, base: FreePoint, push: &Push, input: Vector) -> (Option<Proposal<'a>>, WallContact) {
        let straight = self.prefix(base, input, SHORTEST_MM);
        let way = |admission: &Admission<'_>| length_mm(admission.target().point.minus(base.point()));
        let gained = straight.as_ref().map_or(0.0, way);
        let whole = |admission| push.jog(admission, 1.0);
        let wall = self.guard().part().wall(base, contact_band());
        let Some(wall) = wall.filter(|wall| !wall.is_left_by(input)) else {
            let contact = if gained > 0.0 { WallContact::Unknown } else { WallContact::Wall };
            return (straight.map(whole), contact);
        };
        let along = wall.slide(input, 12).filter(|&along| length_mm(along) >= CREEP * length_mm(input));
        let Some(along) = along else { return (straight.map(whole), WallContact::Wall) };
        let length = length_mm(along).max(1e-9);
        let share = (length / length_mm(input).max(1e-9)).clamp(CREEP, 1.0);
        let mut best: Option<(f64, Admission<'_>)> = None;
        for way in steps_along(along).into_iter().flatten() {
            let Some(admission) = self.prefix(base, way, SHORTEST_MM) else { continue };
            let moved = admission.target().point.minus(base.point());
            let progress = vector_mm(moved).dot(vector_mm(along)) / length;
            if progress > best.as_ref().map_or(gained, |(most, _)| *most) {
                best = Some((progress, admission));
            }
        }
        (best.map(|(_, admission)| push.jog(admission, share)).or(straight.map(whole)), WallContact::Wall)
    }

    /// Whether the motion to `to` keeps a little more than the jogging clearance, unless it begins nearer.
    /// Rounded places on it are then still clear. Without this, a tool at rest at the wall might have no
    /// certified position.
    pub(super) fn stands_off(&self, to: Point) -> bool {
        let Some(end) = self.guard().end() else { return false };
        let more = standing_off(end.threshold());
        let part = self.guard().part();
        let way = Segment { from: end.point(), to };
        part.motion_clear(way, more).is_clear() || !part.point_clear(end.point(), more).is_clear()
    }

    /// The end of a motion, on the grid, if the guard admits the whole motion.
    fn whole(&self, from: FreePoint, input: Vector) -> Option<Admission<'a>> {
        from.point().translated(input).ok().and_then(on_grid).and_then(|target| self.admit(from, target))
    }

    /// The target, if the guard admits it and the motion stands off the wall.
    pub(super) fn admit(&self, from: FreePoint, target: Point) -> Option<Admission<'a>> {
        if target == from.point() {
            return None;
        }
        self.0.admit(target.at_height(self.height())).ok().filter(|_| self.stands_off(target))
    }

    /// The longest admitted prefix of a motion, on the grid. `None` when the search finds no prefix longer
    /// than `least_mm`.
    pub(super) fn prefix(&self, from: FreePoint, input: Vector, least_mm: f64) -> Option<Admission<'a>> {
        let to = from.point().translated(input).ok()?;
        let admitted = |point: Point| on_grid(point).and_then(|at| self.admit(from, at));
        // The guard refuses a shorter jog.
        let least_mm = least_mm.max(mm(self.guard().rules().shortest.units()) - GRID_MM);
        // Rounding to the grid hardly makes a motion longer than this.
        let is_longer = |length_mm: f64| length_mm + GRID_MM > least_mm;
        let length = length_mm(input).max(1e-9);
        if !is_longer(length) {
            return None;
        }
        if let Some(target) = admitted(to) {
            return Some(target);
        }
        let clipped = self.guard().part().clip(from, to).point();
        let span = clipped.minus(from.point());
        let clear_mm = length_mm(span);
        if clipped == from.point() || !is_longer(clear_mm) {
            return None;
        }
        for back_mm in [0.001, 0.002, 0.004] {
            let set_back = part_of(input, -back_mm / length);
            if let Some(target) = clipped.translated(set_back).ok().and_then(admitted) {
                return Some(target);
            }
        }
        // The motion is clear, but its hull with the in-flight set is not: halve the motion.
        let at = |share: f64| from.point().translated(part_of(span, share)).ok().and_then(admitted);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            share /= 2.0;
            if !is_longer(clear_mm * share * 1.5) {
                return None;
            }
            if let Some(target) = at(share) {
                return at(share * 1.5).or(Some(target));
            }
        }
        None
    }
}

/// The motions to try along a wall with non-interpolated axes: along a wall parallel to an axis, or a step of
/// one axis.
fn steps_along(along: Vector) -> [Option<Vector>; 3] {
    let length = length_mm(along).max(1e-9);
    let scale = STAIR_MM.min(length) / length;
    let Mm2 { x, y } = vector_mm(along) * scale;
    let flat = x.abs() < 0.002 || y.abs() < 0.002;
    [Some(along).filter(|_| flat), Some(vector(Mm2::new(x, 0.0), 1.0)), Some(vector(Mm2::new(0.0, y), 1.0))]
}

pub(super) fn on_grid(point: Point) -> Option<Point> {
    let round = |c: i32| (i64::from(c) + GRID / 2).div_euclid(GRID) * GRID;
    Point::from_units(round(point.x.units()), round(point.y.units())).ok()
}

/// The threshold that jogs keep, so that places on them can be rounded.
pub(in crate::supervisor) fn standing_off(threshold: Length) -> Length {
    threshold.saturating_plus(ROUNDING)
}

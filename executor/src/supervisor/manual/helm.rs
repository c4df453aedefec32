//! Looking for a target: straight, along a wall, along the end of the travel, as far as the guard admits.

use std::time::Duration;

use keepout_kernel::clip::contact_band;
use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{FreePoint, Length, Point, Segment, UNITS_PER_MM, Vector};

use super::super::guard::{Asking, Certified, Guard, MotionShape};
use super::super::{Command, Counts};
use super::Limits;
use crate::link::Abilities;

/// Jog targets lie on this grid, lattice units (1 µm): they are then written exactly with three decimals.
const GRID: i64 = 100;
/// The same, mm.
const GRID_MM: f64 = 0.001;
/// Jogs shorter than this are not worth sending, mm.
const SHORTEST_MM: f64 = 0.01;
/// Step along a wall where axes run apart, mm.
const STAIR_MM: f64 = 0.5;
/// How finely a motion is cut short where something in flight is in its way: to one part in 64.
const HALVINGS: u32 = 6;
/// What ways keep beyond the threshold, so that places on them can be rounded (1 µm).
const ROUNDING: Length = Length::small(100);
/// Nothing slides more slowly than this share of the wish: one straight at the wall (to 3°) rests there.
const CREEP: f64 = 0.05;
/// A slide that gets this share of its way is taken without trying others.
const GOOD_SHARE: f64 = 0.98;

/// What a proposal ran into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// Nothing new was proposed.
    Unknown,
    /// Nothing: the tool goes where it is wished.
    Free,
    /// The wall: the motion was cut short, or runs along it.
    Wall,
}

/// What steering works with.
pub(in crate::supervisor) struct Helm<'a> {
    pub(in crate::supervisor) guard: &'a mut Guard,
    pub(in crate::supervisor) counts: &'a mut Counts,
    pub(in crate::supervisor) commands: &'a mut Vec<Command>,
    pub(in crate::supervisor) limits: Limits,
    pub(in crate::supervisor) abilities: Abilities,
    pub(in crate::supervisor) round_trip: Duration,
}

pub(super) fn mm_of(units: i32) -> f64 {
    f64::from(units) / f64::from(UNITS_PER_MM)
}

pub(super) fn length_mm(v: Vector) -> f64 {
    mm_of(v.dx).hypot(mm_of(v.dy))
}

/// A direction times a length in mm, on the lattice.
pub(super) fn vector((x, y): (f64, f64), mm: f64) -> Vector {
    let step = |d: f64| i32::try_from(nearest_unit(d * mm * f64::from(UNITS_PER_MM))).unwrap_or(0);
    Vector { dx: step(x), dy: step(y) }
}

/// A share of a vector.
pub(super) fn part_of(v: Vector, share: f64) -> Vector {
    vector((mm_of(v.dx), mm_of(v.dy)), share)
}

impl Helm<'_> {
    pub(super) fn send(&mut self, certified: Certified) {
        self.counts.jogs += 1;
        self.commands.push(Command::Move(certified));
    }

    /// The target that goes farthest along the wish, straight or along the wall when that is near, with the share of the
    /// wished speed that is left; and what was met.
    pub(super) fn reach(
        &mut self,
        base: FreePoint,
        wish: Vector,
        turns: &[u32],
    ) -> (Option<(Point, f64)>, Contact) {
        let (wish, pace) = self.within_travel(base.point(), wish);
        let (target, contact) = self.reach_in_travel(base, wish, turns);
        (target.map(|(target, share)| (target, share * pace)), contact)
    }

    /// The wish up to the end of the machine's travel, or along it when the tool is there, and the share of the speed that is
    /// left.
    fn within_travel(&self, from: Point, wish: Vector) -> (Vector, f64) {
        let (x0, y0, x1, y1) = self.guard.rules().stroke.corners();
        let (x, y) = (from.x.units(), from.y.units());
        let along = Vector { dx: wish.dx.clamp(x0 - x, x1 - x), dy: wish.dy.clamp(y0 - y, y1 - y) };
        let share =
            |part: i32, whole: i32| if part == whole { 1.0 } else { f64::from(part) / f64::from(whole) };
        let up_to_there = share(along.dx, wish.dx).min(share(along.dy, wish.dy));
        if up_to_there * length_mm(wish) >= SHORTEST_MM {
            return (part_of(wish, up_to_there), 1.0);
        }
        (along, (length_mm(along) / length_mm(wish).max(1e-9)).clamp(CREEP, 1.0))
    }

    fn reach_in_travel(
        &mut self,
        base: FreePoint,
        wish: Vector,
        turns: &[u32],
    ) -> (Option<(Point, f64)>, Contact) {
        let asked = self.guard.asking();
        let straight = self.prefix(&asked, base, wish, 0.0);
        let wished = length_mm(wish);
        let gained = straight.map_or(0.0, |p| length_mm(p.minus(base.point())));
        if gained >= wished * 0.999 {
            return (straight.map(|target| (target, 1.0)), Contact::Free);
        }
        self.counts.clipped += 1;
        let straight = straight.filter(|_| gained >= SHORTEST_MM).map(|target| (target, 1.0));
        let wall = self.guard.part().wall(base, contact_band());
        let Some(wall) = wall.filter(|wall| !wall.is_left_by(wish)) else {
            return (straight, if gained > 0.0 { Contact::Unknown } else { Contact::Wall });
        };
        let mut best: Option<(f64, Point, f64)> = None;
        for &turn in turns {
            let along = wall.slide(wish, turn).filter(|&along| length_mm(along) >= CREEP * wished);
            let Some(along) = along else { continue };
            for along in self.ways_along(along).into_iter().flatten() {
                let most = best.map_or(gained, |(most, ..)| most.max(gained)).max(SHORTEST_MM - GRID_MM);
                let Some(target) = self.prefix(&asked, base, along, most) else { continue };
                let moved = target.minus(base.point());
                let length = length_mm(along).max(1e-9);
                let progress =
                    (mm_of(moved.dx) * mm_of(along.dx) + mm_of(moved.dy) * mm_of(along.dy)) / length;
                let share = (length / wished).clamp(CREEP, 1.0);
                if best.is_none_or(|(most, ..)| progress > most) {
                    best = Some((progress, target, share));
                }
                if progress >= GOOD_SHARE * length && progress > gained {
                    return (Some((target, share)), Contact::Wall);
                }
            }
        }
        let along = best.filter(|&(progress, target, _)| {
            progress > gained && length_mm(target.minus(base.point())) >= SHORTEST_MM
        });
        (along.map(|(_, target, share)| (target, share)).or(straight), Contact::Wall)
    }

    /// The motions to try along a wall: straight along it, or a stair where axes run apart.
    fn ways_along(&self, along: Vector) -> [Option<Vector>; 3] {
        if self.abilities.shape == MotionShape::Line {
            return [Some(along), None, None];
        }
        let length = length_mm(along).max(1e-9);
        let scale = STAIR_MM.min(length) / length;
        let (x, y) = (mm_of(along.dx) * scale, mm_of(along.dy) * scale);
        let flat = x.abs() < 0.002 || y.abs() < 0.002;
        [Some(along).filter(|_| flat), Some(vector((x, 0.0), 1.0)), Some(vector((0.0, y), 1.0))]
    }

    /// Whether the way to `to` keeps a little more than the threshold, unless it begins nearer: places on it are still clear
    /// when they are rounded. Otherwise a tool that rests at the wall could have no certified place.
    fn stands_off(&self, to: Point) -> bool {
        let Some(end) = self.guard.end() else { return false };
        let more = standing_off(end.threshold());
        let part = self.guard.part();
        let way = Segment { from: end.point(), to };
        part.motion_clear(way, more).is_clear() || !part.point_clear(end.point(), more).is_clear()
    }

    /// The longest admitted prefix of a motion, on the grid; `None` when that is nothing, or not longer than `least_mm`.
    pub(super) fn prefix(
        &self,
        asked: &Asking<'_>,
        from: FreePoint,
        wish: Vector,
        least_mm: f64,
    ) -> Option<Point> {
        let to = from.point().translated(wish).ok()?;
        let admitted = |point: Point| {
            let here = |&at: &Point| at != from.point() && asked.admits(at).is_ok();
            on_grid(point).filter(here).filter(|&at| self.stands_off(at))
        };
        // The guard refuses what is shorter.
        let least_mm = least_mm.max(mm_of(self.guard.rules().shortest.units()) - GRID_MM);
        // What is not longer before it is rounded is hardly so afterwards.
        let is_longer = |length_mm: f64| length_mm + GRID_MM > least_mm;
        let length = length_mm(wish).max(1e-9);
        if !is_longer(length) {
            return None;
        }
        if let Some(target) = admitted(to) {
            return Some(target);
        }
        let clipped = self.guard.part().clip(from, to).point();
        let span = clipped.minus(from.point());
        let clear_mm = length_mm(span);
        if clipped == from.point() || !is_longer(clear_mm) {
            return None;
        }
        for back_mm in [0.001, 0.002, 0.004] {
            let set_back = part_of(wish, -back_mm / length);
            if let Some(target) = clipped.translated(set_back).ok().and_then(admitted) {
                return Some(target);
            }
        }
        // The way is clear, and something in flight is in the way of the fan: halve.
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

pub(super) fn on_grid(point: Point) -> Option<Point> {
    let round = |c: i32| (i64::from(c) + GRID / 2).div_euclid(GRID) * GRID;
    Point::from_units(round(point.x.units()), round(point.y.units())).ok()
}

/// The threshold that ways keep, so that places on them can be rounded.
pub(in crate::supervisor) fn standing_off(threshold: Length) -> Length {
    threshold.saturating_plus(ROUNDING)
}

//! The contouring job: from the point of touch along the finishing loops and back, as one chain of motions.
//!
//! It only proposes. The executor's guard certifies every motion again before the first is sent.

use keepout_kernel::curve::{angle, fit_arc};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::shortest_arc;
use keepout_kernel::{Curve, FreePoint, Point, Segment};
use thiserror::Error;

use crate::plan::CertifiedPlan;
use crate::route::route;
use crate::units::{along_mm, place, point_from_mm, point_mm};

/// A stretch of a contouring job.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// The finishing loop that it cuts; `None` for a way through clear space.
    pub cuts: Option<usize>,
    /// Its motions.
    pub curves: Vec<Curve>,
}

/// A contouring job and what it leaves out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContourJob {
    /// The legs, each beginning where the one before ends.
    pub legs: Vec<Leg>,
    /// Loops of the same free space that no way was found to.
    pub unreached: Vec<usize>,
}

/// Why contouring can not begin.
#[derive(Debug, Error, PartialEq, Eq)]
pub enum JobError {
    /// No finishing loop lies in the free space of the tool.
    #[error("no contour to finish can be reached from {}", place(*from))]
    NothingHere {
        /// Where the tool is.
        from: Point,
    },
    /// The tool is not clear of the roughing threshold.
    #[error("the tool at {} is nearer to the part than roughing allows", place(*from))]
    NotClear {
        /// Where the tool is.
        from: Point,
    },
}

/// Stand-off of an approach point from the roughing threshold, mm.
const STAND_OFF_MM: f64 = 0.05;
/// Points tried on a loop for leading in.
const TRIES: u32 = 64;

/// The job that contours every finishing loop in the free space around `from`, the nearest first, and ends where the
/// last loop was entered. Ways between loops keep the roughing threshold and stay inside `within`.
///
/// # Errors
/// [`JobError`] when the tool stands too near, or there is nothing to finish here.
pub fn contour_job(plan: &CertifiedPlan, from: Point, within: Window) -> Result<ContourJob, JobError> {
    let mut here = plan.part.free_point(from, plan.roughing).map_err(|_| JobError::NotClear { from })?;
    let component = plan.plan.finish.component_of(from);
    let loops = &plan.plan.finish.loops;
    let mut open: Vec<usize> = (0..loops.len()).filter(|&i| loops[i].component == component).collect();
    if open.is_empty() {
        return Err(JobError::NothingHere { from });
    }
    let mut job = ContourJob::default();
    while !open.is_empty() {
        let near = |i: usize| nearest_on(&loops[i].curves, here.point()).0;
        open.sort_by(|&a, &b| near(b).total_cmp(&near(a)));
        let Some(next) = open.pop() else { break };
        match legs_for(plan, here, next, within) {
            Some((legs, end)) => {
                job.legs.extend(legs);
                here = end;
            }
            None => job.unreached.push(next),
        }
    }
    if job.legs.is_empty() { Err(JobError::NothingHere { from }) } else { Ok(job) }
}

/// The way to a loop and once around it: straight in from here when that is clear, else by an approach point.
fn legs_for(
    plan: &CertifiedPlan,
    here: FreePoint,
    index: usize,
    within: Window,
) -> Option<(Vec<Leg>, FreePoint)> {
    let curves = &plan.plan.finish.loops[index].curves;
    let touched = nearest_on(curves, here.point()).1;
    if leads_in(plan, here.point(), curves, touched) {
        let cut = around(curves, touched, here.point())?;
        return Some((vec![Leg { cuts: Some(index), curves: cut }], here));
    }
    let mut entries: Vec<Entry> =
        (0..TRIES).map(|k| entry_at(curves, f64::from(k) / f64::from(TRIES))).collect();
    let (x, y) = point_mm(here.point());
    let far = |entry: &Entry| (entry.at.0 - x).hypot(entry.at.1 - y);
    entries.sort_by(|a, b| far(a).total_cmp(&far(b)));
    let stand_off = crate::units::mm(plan.plan.allowance.units()) + STAND_OFF_MM;
    entries.iter().find_map(|entry| {
        let (nx, ny) = entry.outward;
        let approach = point_from_mm((entry.at.0 + nx * stand_off, entry.at.1 + ny * stand_off)).ok()?;
        let clear = plan.part.free_point(approach, plan.roughing).is_ok() && within.holds(approach);
        if !clear || !leads_in(plan, approach, curves, *entry) {
            return None;
        }
        let way = route(&plan.part, here, approach, within)?;
        let free = plan.part.free_point(approach, plan.roughing).ok()?;
        let cut = around(curves, *entry, approach)?;
        let way = Leg { cuts: None, curves: polyline(here.point(), &way) };
        Some((vec![way, Leg { cuts: Some(index), curves: cut }], free))
    })
}

fn leads_in(plan: &CertifiedPlan, from: Point, curves: &[Curve], entry: Entry) -> bool {
    let Some(point) = entry.point(curves) else { return false };
    plan.part.free_point(from, plan.finishing).is_ok_and(|free| plan.part.motion(free, point).is_ok())
}

fn polyline(from: Point, points: &[Point]) -> Vec<Curve> {
    let starts = std::iter::once(&from).chain(points);
    let pairs = starts.zip(points).filter(|(a, b)| a != b);
    pairs.map(|(&from, &to)| Curve::Line(Segment { from, to })).collect()
}

/// A place on a loop: the curve, and where on it in mm, with the direction away from the part.
#[derive(Clone, Copy, Debug)]
struct Entry {
    index: usize,
    at: (f64, f64),
    outward: (f64, f64),
}

impl Entry {
    /// The lattice point to enter at: the place itself, or the curve's end when it is that.
    fn point(&self, curves: &[Curve]) -> Option<Point> {
        let point = point_from_mm(self.at).ok()?;
        let curve = &curves[self.index];
        let close = |end: Point| {
            let d = end.minus(point);
            d.dx.abs() <= SHORT && d.dy.abs() <= SHORT
        };
        Some(if close(curve.from()) {
            curve.from()
        } else if close(curve.to()) {
            curve.to()
        } else {
            point
        })
    }
}

/// Nothing shorter than this is split off a curve, lattice units (10 µm).
const SHORT: i32 = 1000;

/// The place at a share `t` in [0, 1) of the loop's length.
fn entry_at(curves: &[Curve], t: f64) -> Entry {
    let total: f64 = curves.iter().map(Curve::length).sum();
    let mut left = total * t;
    for (index, curve) in curves.iter().enumerate() {
        if left <= curve.length() || index + 1 == curves.len() {
            let share = (left / curve.length()).clamp(0.0, 1.0);
            return place_on(curve, index, share);
        }
        left -= curve.length();
    }
    place_on(&curves[0], 0, 0.0)
}

fn place_on(curve: &Curve, index: usize, share: f64) -> Entry {
    let (at, (dx, dy)) = along_mm(curve, share);
    // The part is on the left of the path.
    Entry { index, at, outward: (dy, -dx) }
}

/// The place on the loop that is nearest to `point`, and its distance in mm.
fn nearest_on(curves: &[Curve], point: Point) -> (f64, Entry) {
    let p = point_mm(point);
    let far = |entry: &Entry| (entry.at.0 - p.0).hypot(entry.at.1 - p.1);
    let mut best = (f64::INFINITY, place_on(&curves[0], 0, 0.0));
    for (index, curve) in curves.iter().enumerate() {
        for share in [0.0, share_nearest(curve, p), 1.0] {
            let entry = place_on(curve, index, share);
            if far(&entry) < best.0 {
                best = (far(&entry), entry);
            }
        }
    }
    best
}

fn share_nearest(curve: &Curve, p: (f64, f64)) -> f64 {
    match curve {
        Curve::Line(segment) => {
            let (a, b) = (point_mm(segment.from), point_mm(segment.to));
            let (dx, dy) = (b.0 - a.0, b.1 - a.1);
            (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0)
        }
        Curve::Arc(arc) => {
            let c = point_mm(arc.centre());
            let sign = if arc.turn() == keepout_kernel::Turn::Left { 1.0 } else { -1.0 };
            let turned = sign * ((p.1 - c.1).atan2(p.0 - c.0) - angle(arc.centre(), arc.from()));
            let share = turned.rem_euclid(std::f64::consts::TAU) / keepout_kernel::curve::sweep(arc);
            if share <= 1.0 { share } else { 0.0 }
        }
    }
}

/// In from `outside`, once around from the entry, and out again. `None` when an arc can not be split there.
fn around(curves: &[Curve], entry: Entry, outside: Point) -> Option<Vec<Curve>> {
    let at = entry.point(curves)?;
    let split = &curves[entry.index];
    let line = |from: Point, to: Point| (from != to).then_some(Curve::Line(Segment { from, to }));
    let mut path: Vec<Curve> = line(outside, at).into_iter().collect();
    path.extend(between(split, at, split.to())?);
    path.extend(&curves[entry.index + 1..]);
    path.extend(&curves[..entry.index]);
    path.extend(between(split, split.from(), at)?);
    path.extend(line(at, outside));
    Some(path)
}

/// The part of `curve` from one of its points to another; nothing when they are the same.
fn between(curve: &Curve, from: Point, to: Point) -> Option<Option<Curve>> {
    if from == to {
        return Some(None);
    }
    match curve {
        Curve::Line(_) => Some(Some(Curve::Line(Segment { from, to }))),
        Curve::Arc(arc) => {
            let centre = (f64::from(arc.centre().x.units()), f64::from(arc.centre().y.units()));
            let part = fit_arc(from, to, centre, arc.turn()).ok()?;
            let line = Curve::Line(Segment { from, to });
            let short = line.length() <= f64::from(shortest_arc(part.radius()).units());
            Some(Some(if short { line } else { Curve::Arc(part) }))
        }
    }
}

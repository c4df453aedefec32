//! The contouring job: from the point of touch along the finishing loops and back, as one chain of motions.
//!
//! It only proposes. The executor's guard certifies every motion again before the first is sent.

use keepout_kernel::curve::{angle, fit_arc};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::{certify_path, shortest_arc};
use keepout_kernel::{Curve, FreePoint, Point, Segment, Turn, UNITS_PER_MM};
use thiserror::Error;

use crate::finish::FinishingLoop;
use crate::plan::{CertifiedPlan, Cut};
use crate::route::route;
use crate::units::{along_mm, place, point_from_mm, point_mm};

/// A stretch of a contouring job.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// The finishing loop that it cuts; `None` for a way through clear space.
    pub cuts: Option<LoopNumber>,
    /// Its motions.
    pub curves: Vec<Curve>,
}

/// A loop of a finishing pass, both counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LoopNumber {
    /// The pass.
    pub pass: usize,
    /// The loop of its path.
    pub index: usize,
}

impl std::fmt::Display for LoopNumber {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "loop {} of pass {}", self.index + 1, self.pass + 1)
    }
}

/// A contouring job and what it leaves out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContourJob {
    /// The legs, each beginning where the one before ends.
    pub legs: Vec<Leg>,
    /// Loops of the same free space that no way was found to.
    pub unreached: Vec<LoopNumber>,
    /// Cuts that begin and end along the contour's own direction; others run straight at it.
    pub tangential: usize,
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
/// A loop is cut from where the tool stands when it is this near, in tool radii.
const BESIDE: f64 = 4.0;
/// Points tried on a loop for leading in.
const TRIES: u32 = 64;

/// The job that contours every finishing loop in the free space around `from`, pass by pass, in each the nearest loop
/// first, and ends where the last loop was entered. Ways between loops keep the roughing threshold and stay inside
/// `within`.
///
/// # Errors
/// [`JobError`] when the tool stands too near, or there is nothing to finish here.
pub fn contour_job(plan: &CertifiedPlan, from: Point, within: Window) -> Result<ContourJob, JobError> {
    let mut here = plan.part.free_point(from, plan.roughing).map_err(|_| JobError::NotClear { from })?;
    let mut job = ContourJob::default();
    for (pass, each) in plan.plan.passes.iter().enumerate() {
        let component = each.path.component_of(from);
        let loops = &each.path.loops;
        let mut open: Vec<usize> = (0..loops.len()).filter(|&i| loops[i].component == component).collect();
        while !open.is_empty() {
            let near = |i: usize| nearest_on(&loops[i].curves, here.point()).0;
            open.sort_by(|&a, &b| near(b).total_cmp(&near(a)));
            let Some(index) = open.pop() else { break };
            let number = LoopNumber { pass, index };
            match legs_for(plan, here, number, within) {
                Some((legs, end, tangential)) => {
                    job.legs.extend(legs);
                    job.tangential += usize::from(tangential);
                    here = end;
                }
                None => job.unreached.push(number),
            }
        }
    }
    if job.legs.is_empty() { Err(JobError::NothingHere { from }) } else { Ok(job) }
}

/// Loops and edges up to which a preview is made.
const PREVIEW_MAX: (usize, usize) = (300, 20_000);

/// The jobs as they would be run from one place of touch in each free space; empty for plans too large to draw them in.
#[must_use]
pub fn preview(plan: &CertifiedPlan) -> Vec<ContourJob> {
    if plan.plan.loop_count() > PREVIEW_MAX.0 || plan.part.edges().len() > PREVIEW_MAX.1 {
        return Vec::new();
    }
    let finish = plan.plan.finish();
    let mut components: Vec<usize> = finish.loops.iter().map(|each| each.component).collect();
    components.sort_unstable();
    components.dedup();
    let field = plan.part.region().bounds().grown(plan.roughing).grown(plan.roughing);
    let spaces = finish.free_spaces();
    let starts = components.into_iter().filter_map(|component| {
        let loops = finish.loops.iter().filter(|each| each.component == component);
        let beside = |each: &FinishingLoop| {
            (0..TRIES).find_map(|k| {
                let stand_off = crate::units::mm(plan.plan.allowance.units()) + STAND_OFF_MM;
                let place = entry_at(&each.curves, f64::from(k) / f64::from(TRIES)).aside(0.0, stand_off)?;
                let clear = plan.part.free_point(place, plan.roughing).is_ok();
                (clear && spaces.component_of(place) == component).then_some(place)
            })
        };
        loops.into_iter().find_map(beside)
    });
    starts.filter_map(|start| contour_job(plan, start, field).ok()).collect()
}

/// The way to a loop and once around it: in from here when that is clear, else by an approach point. Says also whether the
/// cut begins and ends along the contour.
fn legs_for(
    plan: &CertifiedPlan,
    here: FreePoint,
    number: LoopNumber,
    within: Window,
) -> Option<(Vec<Leg>, FreePoint, bool)> {
    let pass = &plan.plan.passes[number.pass];
    let curves = &pass.path.loops[number.index].curves;
    let (distance, touched) = nearest_on(curves, here.point());
    let cutter = Cutter { plan, curves, within };
    let from_here = || {
        let (cut, tangential) = cutter.around(touched, here.point())?;
        Some((vec![Leg { cuts: Some(number), curves: cut }], here, tangential))
    };
    // From farther away the tool is better not led back to where it came from.
    let beside = distance <= crate::units::mm(plan.plan.tool_radius.units()) * BESIDE;
    if let Some(legs) = beside.then(from_here).flatten() {
        return Some(legs);
    }
    let mut entries: Vec<Entry> =
        (0..TRIES).map(|k| entry_at(curves, f64::from(k) / f64::from(TRIES))).collect();
    let (x, y) = point_mm(here.point());
    let far = |entry: &Entry| (entry.at.0 - x).hypot(entry.at.1 - y);
    entries.sort_by(|a, b| far(a).total_cmp(&far(b)));
    let left_by_roughing = plan.plan.allowance.units() - pass.allowance.units();
    let stand_off = crate::units::mm(left_by_roughing) + STAND_OFF_MM;
    let by_approach = entries.iter().find_map(|entry| {
        let approach = entry.aside(0.0, stand_off)?;
        let free = plan.part.free_point(approach, plan.roughing).ok().filter(|_| within.holds(approach))?;
        let (cut, tangential) = cutter.around(*entry, approach)?;
        let way = route(&plan.part, here, approach, within)?;
        let way = Leg { cuts: None, curves: polyline(here.point(), &way) };
        Some((vec![way, Leg { cuts: Some(number), curves: cut }], free, tangential))
    });
    by_approach.or_else(from_here)
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
    /// The lattice point so far along the direction of travel and so far away from the part, mm.
    fn aside(&self, along_mm: f64, out_mm: f64) -> Option<Point> {
        let (nx, ny) = self.outward;
        // The part is on the left: travel is the outward direction turned to the left.
        let (dx, dy) = (-ny, nx);
        let (x, y) = (self.at.0 + dx * along_mm + nx * out_mm, self.at.1 + dy * along_mm + ny * out_mm);
        point_from_mm((x, y)).ok()
    }

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

/// Radii that are tried for the arcs along which a cut begins and ends, as shares of the tool's radius.
const LEAD_SHARES: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.06];

/// Makes the cut around one loop.
struct Cutter<'a> {
    plan: &'a CertifiedPlan,
    curves: &'a [Curve],
    within: Window,
}

impl Cutter<'_> {
    /// In from `outside`, once around from the entry, and out again, in the plan's direction; and whether it is led in and
    /// out along the contour. `None` when no way in and out keeps clear.
    fn around(&self, entry: Entry, outside: Point) -> Option<(Vec<Curve>, bool)> {
        let at = entry.point(self.curves)?;
        let split = &self.curves[entry.index];
        let mut round: Vec<Curve> = between(split, at, split.to())?.into_iter().collect();
        round.extend(&self.curves[entry.index + 1..]);
        round.extend(&self.curves[..entry.index]);
        round.extend(between(split, split.from(), at)?);
        let radius = crate::units::mm(self.plan.plan.tool_radius.units());
        let arcs = LEAD_SHARES.iter().filter_map(|share| self.arcs(entry, at, outside, radius * share));
        let straight = || {
            let line = line_between(outside, at).into_iter().collect();
            Some((line, line_between(at, outside).into_iter().collect()))
        };
        let clear = |(lead_in, lead_out): &(Vec<Curve>, Vec<Curve>)| {
            self.is_clear(outside, lead_in) && self.is_clear(at, lead_out)
        };
        let mut tangential = true;
        let led = arcs.into_iter().find(clear).or_else(|| {
            tangential = false;
            straight().filter(clear)
        })?;
        let path: Vec<Curve> = led.0.into_iter().chain(round).chain(led.1).collect();
        match self.plan.plan.cut {
            Cut::Conventional => Some((path, tangential)),
            Cut::Climb => {
                let backwards = path.iter().rev().map(Curve::reversed).collect::<Option<_>>()?;
                Some((backwards, tangential))
            }
        }
    }

    /// Quarter circles that touch the path at the entry, on the tool's side, with lines from and to the outside.
    fn arcs(
        &self,
        entry: Entry,
        at: Point,
        outside: Point,
        radius_mm: f64,
    ) -> Option<(Vec<Curve>, Vec<Curve>)> {
        let centre = point_mm(entry.aside(0.0, radius_mm)?);
        let centre = (centre.0 * f64::from(UNITS_PER_MM), centre.1 * f64::from(UNITS_PER_MM));
        let (begin, end) = (entry.aside(-radius_mm, radius_mm)?, entry.aside(radius_mm, radius_mm)?);
        // The tool's side is on the right.
        let lead_in = fit_arc(begin, at, centre, Turn::Right).ok()?;
        let lead_out = fit_arc(at, end, centre, Turn::Right).ok()?;
        let to_arc = line_between(outside, begin);
        let back = line_between(end, outside);
        Some((
            to_arc.into_iter().chain([Curve::Arc(lead_in)]).collect(),
            std::iter::once(Curve::Arc(lead_out)).chain(back).collect(),
        ))
    }

    fn is_clear(&self, from: Point, path: &[Curve]) -> bool {
        let inside =
            path.iter().all(|curve| self.within.holds(curve.from()) && self.within.holds(curve.to()));
        // A lead ends on the path, which keeps the finishing threshold.
        let begins = path.first().is_none_or(|first| first.from() == from);
        inside && begins && certify_path(&self.plan.part, self.plan.finishing, path).is_ok()
    }
}

fn line_between(from: Point, to: Point) -> Option<Curve> {
    (from != to).then_some(Curve::Line(Segment { from, to }))
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

//! Touching and contouring: from the wall around the part, held, gone on with, given up.

use std::f64::consts::FRAC_PI_2;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Arc, Curve, Length, Point, Segment, Turn};
use keepout_planner::job::{ContourJob, Leg, LoopNumber, Progress, resume_in_place, resume_job};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{length_up_from_mm, point_from_mm, point_mm};

use super::event::Command;
use super::guard::{Certification, MotionShape};
use super::manual::{self, Steering};
use super::state::{Run, State, Touch};
use super::{CERTIFIED_AT_ONCE, Supervisor};

/// The wall counts as touched within this distance beyond the roughing threshold, mm.
const TOUCH_MM: f64 = 0.1;

impl Supervisor {
    /// Whether the tool stands at the wall.
    pub(super) fn touches(&self) -> bool {
        let Some(at) = self.guard.end() else { return false };
        let Ok(band) = length_up_from_mm(TOUCH_MM) else { return false };
        let here = Segment { from: at.point(), to: at.point() };
        self.work.coarse().edges_clear(here, at.threshold().saturating_plus(band)).is_err()
    }

    /// The contouring job that is wanted. It is worked out elsewhere, and comes as an event.
    #[must_use]
    pub fn wanted_job(&self) -> Option<JobRequest> {
        let State::Touching(Touch::Asked { in_place }) = self.state else { return None };
        let from = self.guard.tail()?.point();
        Some(JobRequest {
            from,
            within: self.guard.rules().stroke,
            progress: self.progress.clone(),
            interrupted: self.interrupted.clone().filter(|_| in_place),
        })
    }

    pub(super) fn wants_job(&self) -> bool {
        matches!(self.state, State::Touching(Touch::Asked { .. }))
    }

    /// Goes on with what is left of the contour: from where the tool stands on it, or from clear space.
    pub(super) fn resume(&mut self) {
        let in_place = self.guard.stands_inside();
        let begun = match &self.interrupted {
            Some(interrupted) if in_place && interrupted.led_away => {
                let (x, y) = point_mm(self.guard.end().map_or(Point::ORIGIN, |end| end.point()));
                self.note(format!(
                    "at {x:.3},{y:.3} mm the contour does not go on, for the tool was led there by hand: lead it farther from the part, and ask again"
                ));
                false
            }
            interrupted if in_place => interrupted.is_some(),
            _ => self.progress != Progress::default(),
        };
        if self.guard.settled() && begun {
            self.state = State::Touching(Touch::Asked { in_place });
        }
    }

    pub(super) fn take_job(&mut self, job: Result<ContourJob, String>) {
        if !self.wants_job() {
            return;
        }
        let taken = job.and_then(|job| self.begin(job));
        match taken {
            Ok(run) => self.state = State::Touching(Touch::Certifying(Box::new(run))),
            Err(reason) => self.give_up(&reason),
        }
    }

    fn give_up(&mut self, reason: &str) {
        self.guard.withdraw_contour();
        self.note(format!("no contour: {reason}"));
        let steering = Steering::default();
        self.state =
            if self.guard.stands_inside() { State::Escaping(steering) } else { State::Sliding(steering) };
    }

    fn begin(&mut self, job: ContourJob) -> Result<Run, String> {
        if let Some(number) =
            job.legs.iter().filter_map(|leg| leg.cuts).find(|number| !number.is_of(&self.work.plan))
        {
            return Err(format!("the plan has no {number}"));
        }
        let fast = manual::feed(self.limits.speed_mm_s / 2.0);
        let of_pass = |cut: LoopNumber| self.work.plan.plan.passes[cut.pass].feed_mm_min;
        let feed = |leg: &Leg| match leg.cuts {
            Some(cut) => of_pass(cut).unwrap_or(self.options.feed_mm_min),
            None => fast,
        };
        let mut curves: Vec<(Curve, u32)> = Vec::new();
        let mut sources = Vec::new();
        let motions = job.legs.iter().flat_map(|leg| leg.curves.iter().map(move |curve| (leg, curve)));
        for (source, (leg, curve)) in motions.enumerate() {
            self.as_sent(curve, feed(leg), self.stock(leg), &mut curves)?;
            sources.resize(curves.len(), source);
        }
        self.guard.begin_contour(curves).map_err(|refusal| refusal.to_string())?;
        self.unreached = job.unreached.len();
        for unreached in &job.unreached {
            self.note(format!("no way wide enough for roughing leads to finishing {unreached}"));
        }
        if job.recut_mm > 0.0 {
            self.note(format!("{:.2} mm are cut again, to enter where it was left", job.recut_mm));
        }
        let done = Progress::after(&job, job.legs.len(), 0, Point::ORIGIN);
        Ok(Run::new(job, sources, done))
    }

    /// What a leg leaves on the part beyond what its contour may touch.
    fn stock(&self, leg: &Leg) -> Length {
        let plan = &self.work.plan.plan;
        leg.cuts.map_or(plan.allowance, |cut| plan.passes[cut.pass].allowance)
    }

    /// The motions that the controller is sent for a curve: itself, or lines where it knows no arcs, in steps where it can
    /// not be held or its axes run apart.
    fn as_sent(
        &self,
        curve: &Curve,
        feed: u32,
        stock: Length,
        into: &mut Vec<(Curve, u32)>,
    ) -> Result<(), String> {
        let whole = self.abilities.holds && self.abilities.contours == MotionShape::Line;
        match curve {
            Curve::Line(_) if whole => {
                into.push((*curve, feed));
                return Ok(());
            }
            Curve::Arc(arc) if self.abilities.arcs && self.abilities.contours == MotionShape::Line => {
                let longest = if whole { f64::INFINITY } else { STEP_MAX_MM };
                for piece in quarters(arc, longest)? {
                    into.push((Curve::Arc(piece), feed));
                }
                return Ok(());
            }
            _ => {}
        }
        let points = curve.chord_points(self.chord_slack()).map_err(|error| error.to_string())?;
        for pair in points.windows(2) {
            let line = Segment { from: pair[0], to: pair[1] };
            self.steps(line, stock, &mut |from, to| into.push((Curve::Line(Segment { from, to }), feed)))?;
        }
        Ok(())
    }

    /// How far chords may leave an arc: what the certified threshold leaves for it.
    fn chord_slack(&self) -> Length {
        let left = self.plan().finishing.units() - self.guard.rules().finishing.units();
        Length::from_units(i64::from(left) - 2).unwrap_or(CHORD_LEAST).max(CHORD_LEAST)
    }

    /// Cuts a line into steps: short enough to stop after, and where the axes run apart so short that the box of each stays
    /// within the stock.
    fn steps(&self, line: Segment, stock: Length, take: &mut dyn FnMut(Point, Point)) -> Result<(), String> {
        let d = line.to.minus(line.from);
        let mut count = i64::from(d.dx.abs().max(d.dy.abs())).div_euclid(STEP_MAX) + 1;
        if self.abilities.contours == MotionShape::Box && d.dx != 0 && d.dy != 0 {
            let room = i64::from(stock.units()) - BOX_ROUNDING;
            if room < BOX_ROOM_LEAST {
                return Err(format!(
                    "this controller's axes run apart, and a slanted wall needs stock for that: give a finishing pass that leaves at least {BOX_STOCK_MM} mm"
                ));
            }
            // The corner of a box lies so far beside its diagonal; that of the n-th part, the n-th part of it.
            let (x, y) = (f64::from(d.dx), f64::from(d.dy));
            let beside = keepout_kernel::curve::nearest_unit((x * y).abs() / x.hypot(y));
            count = count.max(beside.div_euclid(room) + 1);
        }
        let mut from = line.from;
        for k in 1..=count {
            let part = |c: i32, d: i32| i64::from(c) + i64::from(d) * k / count;
            let to = Point::from_units(part(line.from.x.units(), d.dx), part(line.from.y.units(), d.dy));
            let to = if k == count { line.to } else { to.unwrap_or(line.to) };
            if to != from {
                take(from, to);
            }
            from = to;
        }
        Ok(())
    }

    /// Certifies a little more of the contour.
    pub(super) fn certify_on(&mut self) {
        match self.guard.certify_contour(CERTIFIED_AT_ONCE) {
            Ok(Certification::Under { .. }) => {}
            Ok(Certification::Done) => {
                if let State::Touching(Touch::Certifying(run)) =
                    std::mem::replace(&mut self.state, State::Done)
                {
                    self.state = State::Contouring(*run);
                }
            }
            Err(refusal) => self.give_up(&format!("contouring refused: {refusal}")),
        }
    }

    /// Holds the contour: at once where the controller can, or after the motion under way.
    pub(super) fn hold(&mut self, commands: &mut Vec<Command>) {
        if let State::Contouring(run) = std::mem::replace(&mut self.state, State::Done) {
            self.state = State::Holding(run);
            if self.abilities.holds {
                self.guard.contour_held();
                commands.push(Command::Hold);
            }
        }
    }

    /// Goes on with a contour that was held.
    pub(super) fn go_on(&mut self, commands: &mut Vec<Command>) {
        if let State::Holding(run) = std::mem::replace(&mut self.state, State::Done) {
            self.state = State::Contouring(run);
            if self.abilities.holds {
                self.guard.contour_held();
                commands.push(Command::Continue);
            }
        }
    }

    /// What is done of the contours of this plan, now.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let under_way = match &self.state {
            State::Contouring(run) | State::Holding(run) => run.progress(),
            _ => None,
        };
        under_way.unwrap_or_else(|| self.progress.clone())
    }

    /// Keeps what is needed to go on with a contour that ends here unfinished.
    pub(super) fn interrupt(&mut self) {
        self.progress = self.progress();
        if let State::Contouring(run) | State::Holding(run) = &mut self.state {
            let first = run.source();
            let sent = self.guard.contour_progress().map_or(0, |(sent, _)| sent);
            let end = sent.checked_sub(1).and_then(|last| run.sources.get(last)).map_or(0, |last| last + 1);
            let job = std::mem::take(&mut run.job);
            self.interrupted = Some(Interrupted { job, first, end, led_away: false });
        }
    }
}

/// The arc in pieces that turn by a quarter at most, and are no longer than `longest` mm.
fn quarters(arc: &Arc, longest: f64) -> Result<Vec<Arc>, String> {
    let (cx, cy) = point_mm(arc.centre());
    let (x, y) = point_mm(arc.from());
    let (radius, begin) = ((x - cx).hypot(y - cy), (y - cy).atan2(x - cx));
    let sweep = keepout_kernel::curve::sweep(arc);
    let count = (sweep / FRAC_PI_2).max(sweep * radius / longest).ceil().max(1.0);
    let sign = if arc.turn() == Turn::Left { 1.0 } else { -1.0 };
    let mut pieces = Vec::new();
    let (mut from, mut k) = (arc.from(), 1.0);
    while k <= count {
        let angle = begin + sign * sweep * k / count;
        let at = (cx + radius * angle.cos(), cy + radius * angle.sin());
        let to =
            if k + 0.5 > count { arc.to() } else { point_from_mm(at).map_err(|error| error.to_string())? };
        // The joints are rounded to the lattice: where that puts one off the circle, a centre a unit away fits.
        let centre = (f64::from(arc.centre().x.units()), f64::from(arc.centre().y.units()));
        let piece = Arc::new(from, to, arc.centre(), arc.turn())
            .or_else(|_| keepout_kernel::curve::fit_arc(from, to, centre, arc.turn()));
        pieces.push(piece.map_err(|error| error.to_string())?);
        (from, k) = (to, k + 1.0);
    }
    Ok(pieces)
}

/// A contour that was interrupted.
#[derive(Clone, Debug, PartialEq)]
pub struct Interrupted {
    job: ContourJob,
    /// The first of its motions that may not be done.
    first: usize,
    /// The first of its motions that was not sent.
    end: usize,
    /// Whether the operator has moved the tool since: what lies on that way was not cut.
    pub(super) led_away: bool,
}

/// A contouring job that the supervisor wants.
#[derive(Clone, Debug, PartialEq)]
pub struct JobRequest {
    from: Point,
    within: Window,
    progress: Progress,
    interrupted: Option<Interrupted>,
}

impl JobRequest {
    /// Works the job out. May take long.
    ///
    /// # Errors
    /// What the operator should know when there is none.
    pub fn work_out(&self, plan: &CertifiedPlan) -> Result<ContourJob, String> {
        match &self.interrupted {
            Some(interrupted) => interrupted.go_on(plan, self.from, &self.progress),
            None => {
                resume_job(plan, self.from, self.within, &self.progress).map_err(|error| error.to_string())
            }
        }
    }
}

impl Interrupted {
    /// The rest of the job, for a tool that stands on it.
    fn go_on(&self, plan: &CertifiedPlan, at: Point, done: &Progress) -> Result<ContourJob, String> {
        let all = self.job.legs.iter().flat_map(|leg| leg.curves.iter().copied());
        let left: Vec<Curve> = all.skip(self.first).collect();
        let begun = self.end.saturating_sub(self.first);
        let rest = resume_in_place(plan, &left, begun, at)
            .ok_or("the tool stands where no way leads on along the contour: lead it away from the part")?;
        Ok(ContourJob {
            legs: dealt(&self.job.legs, rest),
            before: done.clone(),
            unreached: self.job.unreached.clone(),
            ..ContourJob::default()
        })
    }
}

/// The legs with the motions of `rest`, dealt from the last leg backwards: what is left of the first is led onto.
fn dealt(legs: &[Leg], mut rest: Vec<Curve>) -> Vec<Leg> {
    let mut result = Vec::new();
    for leg in legs.iter().rev() {
        if rest.is_empty() {
            break;
        }
        let earlier = result.len() + 1 < legs.len();
        let first = if earlier { rest.len().saturating_sub(leg.curves.len()) } else { 0 };
        let curves = rest.split_off(first);
        let moved = |index: usize| (index + curves.len()).saturating_sub(leg.curves.len());
        let on_loop = moved(leg.on_loop.start)..moved(leg.on_loop.end);
        result.push(Leg { cuts: leg.cuts, entry: leg.entry, on_loop, curves });
    }
    result.reverse();
    result
}

/// Longest motion of a contour where the controller can not hold it, lattice units (2 mm).
const STEP_MAX: i64 = 200_000;
const STEP_MAX_MM: f64 = 2.0;
/// Rounding of steps and of the chords of arcs, lattice units (0.5 µm).
const BOX_ROUNDING: i64 = 50;
/// Where axes run apart, less room than this beside the path makes steps too short to be driven, lattice units (9.5 µm).
const BOX_ROOM_LEAST: i64 = 950;
/// The stock that leaves that room, mm.
const BOX_STOCK_MM: f64 = 0.01;
/// Chords never leave an arc by less than this: 0.1 µm.
const CHORD_LEAST: Length = Length::small(10);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_of_every_size_fall_into_quarters() {
        let mut random = fastrand::Rng::with_seed(5);
        for _ in 0..20_000 {
            let radius = 2000.0 * 50_000.0_f64.powf(random.f64());
            let (begin, sweep) = (random.f64() * 6.0, 0.05 + random.f64() * 6.2);
            let at = |phi: f64| {
                let (x, y) = (radius * phi.cos(), radius * phi.sin());
                point_from_mm((x / 1e5, y / 1e5)).unwrap()
            };
            let turn = if random.bool() { Turn::Left } else { Turn::Right };
            let sign = if turn == Turn::Left { 1.0 } else { -1.0 };
            let ends = (at(begin), at(begin + sign * sweep));
            let Ok(arc) = keepout_kernel::curve::fit_arc(ends.0, ends.1, (0.0, 0.0), turn) else { continue };
            let pieces = quarters(&arc, f64::INFINITY).unwrap();
            assert!(pieces.first().unwrap().from() == ends.0 && pieces.last().unwrap().to() == ends.1);
            assert!(pieces.windows(2).all(|pair| pair[0].to() == pair[1].from()));
            let longest = pieces.iter().map(keepout_kernel::curve::sweep).fold(0.0, f64::max);
            assert!(longest < FRAC_PI_2 + 0.01, "{longest}");
        }
    }
}

//! Contact start and contouring: start at the wall, feed hold, cycle start and interruption.
//!
//! Implements SR-24.

use keepout_guard::{Certification, ContourMotion, Refusal};
use keepout_kernel::exact::arc::ArcError;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Curve, LatticeError, Length, Place, Point, Segment};
use keepout_planner::job::{ContourJob, JobError, Leg, LoopNumber, Progress, resume_in_place, resume_job};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{length_up_from_mm, point_mm};
use thiserror::Error;

use super::contour_motions::BOX_STOCK_MM;
use super::jog::{self, JogPlanner};
use super::notice::Notice;
use super::state::{Run, State, Touch};
use super::{CERTIFIED_AT_ONCE, Supervisor};

/// The tool is in contact with the wall within this distance beyond the jogging clearance, mm.
const TOUCH_MM: f64 = 0.1;

impl Supervisor {
    /// Whether the tool is in contact with the wall.
    pub(super) fn touches(&self) -> bool {
        let Some(at) = self.guard.end() else { return false };
        let Ok(band) = length_up_from_mm(TOUCH_MM) else { return false };
        let here = Segment { from: at.point(), to: at.point() };
        self.guard.part().edges_clear(here, at.threshold().saturating_plus(band)).is_err()
    }

    /// The contouring job that the supervisor requests. The session computes it and returns it as an event.
    #[must_use]
    pub fn wanted_job(&self) -> Option<JobRequest> {
        let State::Touching(Touch::Asked { in_place }) = self.state else { return None };
        let from = self.guard.confirmed()?.place();
        Some(JobRequest {
            from,
            within: self.guard.rules().travel,
            progress: self.contours.progress.clone(),
            interrupted: self.contours.interrupted.clone().filter(|_| in_place && !self.climbs()),
        })
    }

    /// Whether the session has a third axis. The tool then rises before it goes on with a contour, so it need not
    /// stand on it.
    pub(super) fn climbs(&self) -> bool {
        self.work.plan.plan.relief.is_some()
    }

    pub(super) fn wants_job(&self) -> bool {
        matches!(self.state, State::Touching(Touch::Asked { .. }))
    }

    /// Goes on with the remaining contour: from the place of the tool on it, or from outside the jogging
    /// clearance.
    pub(super) fn resume(&mut self) {
        let in_place = self.guard.is_inside_jogging_clearance();
        let begun = match &self.contours.interrupted {
            Some(interrupted) if in_place && interrupted.led_away && !self.climbs() => {
                let at = point_mm(self.guard.end().map_or(Point::ORIGIN, |end| end.point()));
                self.note(Notice::LedAway(at));
                false
            }
            interrupted if in_place => interrupted.is_some(),
            // From above the part, there is no wall to touch.
            _ => self.contours.progress != Progress::default() || self.climbs() && self.operation.armed,
        };
        if self.guard.in_position() && begun && self.spindle_is_stated() {
            self.state = State::Touching(Touch::Asked { in_place });
        }
    }

    pub(super) fn take_job(&mut self, job: Result<ContourJob, JobError>) {
        if !self.wants_job() {
            return;
        }
        match job.map_err(NoContour::Job).and_then(|job| self.begin(job)) {
            Ok(run) => self.state = State::Touching(Touch::Certifying(Box::new(run))),
            Err(reason) => self.give_up(&reason),
        }
    }

    fn give_up(&mut self, reason: &NoContour) {
        self.guard.withdraw_contour();
        self.note(Notice::NoContour(reason.to_string()));
        let steering = JogPlanner::default();
        self.state = if self.guard.is_inside_jogging_clearance() {
            State::Retracting(steering)
        } else {
            State::Sliding(steering)
        };
    }

    fn begin(&mut self, job: ContourJob) -> Result<Run, NoContour> {
        if let Some(number) =
            job.legs.iter().filter_map(|leg| leg.cuts).find(|number| !number.is_of(&self.work.plan))
        {
            return Err(NoContour::NoSuchLoop(number));
        }
        let fast = jog::feed(self.limits.speed_mm_s / 2.0);
        let of_pass = |cut: LoopNumber| self.work.plan.plan.passes[cut.pass].feed_mm_min;
        let feed = |leg: &Leg| match leg.cuts {
            Some(cut) => of_pass(cut).unwrap_or(self.options.feed_mm_min),
            None => fast,
        };
        let mut curves: Vec<ContourMotion> = Vec::new();
        let mut sources = Vec::new();
        for (source, (leg, &curve, heights)) in job.motions().enumerate() {
            let motion = ContourMotion { curve, heights, feed_mm_min: feed(leg) };
            self.as_sent(&motion, self.stock(leg), &mut curves)?;
            sources.resize(curves.len(), source);
        }
        self.guard.begin_contour(curves)?;
        self.contours.unreached.clone_from(&job.unreached);
        for &unreached in &job.unreached {
            self.note(Notice::Unreached(self.work.plan.loop_name(unreached)));
        }
        if job.recut_mm > 0.0 {
            self.note(Notice::Recut(job.recut_mm));
        }
        let done = Progress::after(&job, job.legs.len(), 0, Point::ORIGIN);
        Ok(Run::new(job, sources, done))
    }

    /// The stock that a leg leaves on the part.
    fn stock(&self, leg: &Leg) -> Length {
        let plan = &self.work.plan.plan;
        leg.cuts.map_or(plan.stock_to_leave, |cut| plan.passes[cut.pass].stock_to_leave)
    }

    /// Certifies a few more motions of the contour.
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
            Err(refusal) => self.give_up(&NoContour::Refused(refusal)),
        }
    }

    /// Feed hold: sends no more motions of the contour, and the tool stops at the end of the queued motions.
    /// The feed hold of the controller would be faster, but it can run away (`docs/safety/controllers.md`).
    pub(super) fn pause(&mut self) {
        if let State::Contouring(run) = std::mem::replace(&mut self.state, State::Done) {
            self.state = State::Holding(run);
        }
    }

    /// Cycle start: goes on with a contour on feed hold.
    pub(super) fn go_on(&mut self) {
        if let State::Holding(run) = std::mem::replace(&mut self.state, State::Done) {
            self.state = State::Contouring(run);
        }
    }

    /// The present progress of the contours of this plan.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let under_way = match &self.state {
            State::Contouring(run) | State::Holding(run) => run.progress(),
            _ => None,
        };
        under_way.unwrap_or_else(|| self.contours.progress.clone())
    }

    /// Keeps the data to go on with a contour that ends here unfinished.
    pub(super) fn interrupt(&mut self) {
        self.contours.progress = self.progress();
        if let State::Contouring(run) | State::Holding(run) = &mut self.state {
            let first = run.source();
            let sent = self.guard.contour_progress().map_or(0, |(sent, _)| sent);
            let end = sent.checked_sub(1).and_then(|last| run.sources.get(last)).map_or(0, |last| last + 1);
            let job = std::mem::take(&mut run.job);
            self.contours.interrupted = Some(Interrupted { job, first, end, led_away: false });
        }
    }
}

/// A contour that was interrupted.
#[derive(Clone, Debug, PartialEq)]
pub struct Interrupted {
    job: ContourJob,
    /// Index of the first of its motions that may be incomplete.
    first: usize,
    /// Index of the first of its motions that was not sent.
    end: usize,
    /// Whether the operator has jogged since. The contour beside such a jog was not cut.
    pub(super) led_away: bool,
}

/// The reason why a contour does not begin.
#[derive(Debug, Error)]
pub(super) enum NoContour {
    /// The planner found no job.
    #[error(transparent)]
    Job(#[from] JobError),
    /// The job belongs to another plan.
    #[error("the plan has no {0}")]
    NoSuchLoop(LoopNumber),
    /// A motion cannot be split into shorter motions.
    #[error(transparent)]
    Motion(#[from] ArcError),
    /// A joint of its motions leaves the lattice.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// Non-interpolated axes need stock along a slanted wall.
    #[error(
        "this controller does not interpolate its axes, and a slanted wall then needs stock: \
         plan a finishing pass that leaves at least {BOX_STOCK_MM} mm"
    )]
    NoStock,
    /// The guard refuses the contour.
    #[error("contouring refused: {0}")]
    Refused(#[from] Refusal),
}

/// A contouring job that the supervisor requests.
#[derive(Clone, Debug, PartialEq)]
pub struct JobRequest {
    from: Place,
    within: Window,
    progress: Progress,
    interrupted: Option<Interrupted>,
}

impl JobRequest {
    /// Computes the job. This may take long.
    ///
    /// # Errors
    /// [`JobError`] with the reason why there is no job, for the operator.
    pub fn work_out(&self, plan: &CertifiedPlan) -> Result<ContourJob, JobError> {
        match &self.interrupted {
            Some(interrupted) => interrupted.go_on(plan, self.from.point, &self.progress),
            None => resume_job(plan, self.from, self.within, &self.progress),
        }
    }
}

impl Interrupted {
    /// The rest of the job, for a tool that stands on its contour.
    fn go_on(&self, plan: &CertifiedPlan, at: Point, done: &Progress) -> Result<ContourJob, JobError> {
        let all = self.job.legs.iter().flat_map(|leg| leg.curves.iter().copied());
        let left: Vec<Curve> = all.skip(self.first).collect();
        let begun = self.end.saturating_sub(self.first);
        let rest = resume_in_place(plan, &left, begun, at).ok_or(JobError::NoWayOn)?;
        Ok(ContourJob {
            legs: dealt(&self.job.legs, rest),
            before: done.clone(),
            unreached: self.job.unreached.clone(),
            ..ContourJob::default()
        })
    }
}

/// The legs with the motions of `rest`, distributed from the last leg backwards. The first leg takes the
/// remaining motions, with those that lead onto it.
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
        result.push(Leg { cuts: leg.cuts, entry: leg.entry, on_loop, curves, heights: Vec::new() });
    }
    result.reverse();
    result
}

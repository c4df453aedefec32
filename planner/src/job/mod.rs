//! The contouring job: from the point of touch along the finishing loops and back, as one chain of motions; and what is left of
//! one that was interrupted.
//!
//! It only proposes. The executor's guard certifies every motion again before the first is sent.

mod cutter;
mod in_place;
mod preview;
mod progress;
mod track;

use std::ops::Range;

use cutter::{Cutter, LoopLegs};
pub use in_place::resume_in_place;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Curve, FreePoint, Point};
pub use preview::preview;
use progress::Rest;
pub use progress::{DONE_MM, PartialLoop, Progress, ProgressError, SNAP_MM};
use serde::{Deserialize, Serialize};
use thiserror::Error;
use track::Track;

use crate::plan::{CertifiedPlan, Pass};

/// A stretch of a contouring job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Leg {
    /// The finishing loop that it cuts; `None` for a way through clear space.
    pub cuts: Option<LoopNumber>,
    /// Its motions.
    #[serde(with = "crate::stored::many")]
    pub curves: Vec<Curve>,
    /// Those of its motions that cut what of the loop was not cut before; those before and behind lead in and out, and
    /// may cut a little of the loop again. Empty for a way.
    pub on_loop: Range<usize>,
    /// Where the loop was first entered, in this job or the one that it goes on with: the cut ends there. `None` for a way.
    #[serde(with = "crate::stored::maybe")]
    pub entry: Option<Point>,
}

/// A loop of a finishing pass, both counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LoopNumber {
    /// The pass.
    pub pass: usize,
    /// The loop of its path.
    pub index: usize,
}

impl LoopNumber {
    /// Whether the plan has the loop.
    #[must_use]
    pub fn is_of(self, plan: &CertifiedPlan) -> bool {
        plan.plan.passes.get(self.pass).is_some_and(|pass| self.index < pass.path.loops.len())
    }
}

impl std::fmt::Display for LoopNumber {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "loop {} of pass {}", self.index + 1, self.pass + 1)
    }
}

/// A contouring job and what it leaves out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContourJob {
    /// The legs, each beginning where the one before ends.
    pub legs: Vec<Leg>,
    /// Loops of the same free space that no way was found to.
    pub unreached: Vec<LoopNumber>,
    /// Cuts that begin and end along the contour's own direction; others run straight at it.
    pub tangential: usize,
    /// What was done before it.
    pub before: Progress,
    /// What it cuts a second time, mm: where a loop could not be entered again just where it was left.
    pub recut_mm: f64,
}

impl ContourJob {
    /// The leg, and the motion of that leg, that the job's motion `index` is, all counted from 0.
    #[must_use]
    pub fn motion(&self, index: usize) -> Option<(usize, usize)> {
        let mut left = index;
        for (number, leg) in self.legs.iter().enumerate() {
            match left.checked_sub(leg.curves.len()) {
                None => return Some((number, left)),
                Some(beyond) => left = beyond,
            }
        }
        None
    }
}

/// Why contouring can not begin.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
pub enum JobError {
    /// No finishing loop lies in the free space of the tool.
    #[error("no contour to finish can be reached from {from}")]
    NothingHere {
        /// Where the tool is.
        #[serde(with = "crate::stored")]
        from: Point,
    },
    /// Every finishing loop in the free space of the tool is cut.
    #[error("every contour in the free space around {from} is finished")]
    AllFinished {
        /// Where the tool is.
        #[serde(with = "crate::stored")]
        from: Point,
    },
    /// Nothing is left but an interrupted loop that can not be entered again.
    #[error(
        "no way leads back to {number} at {}, where it was interrupted, nor to the tool radius of contour before. Bring the tool near it by hand, or have that loop cut anew: `keepout run --resume LOG --recut {}:{}`.",
        at, number.index + 1, number.pass + 1
    )]
    NoWayBack {
        /// The loop.
        number: LoopNumber,
        /// Where it was interrupted.
        #[serde(with = "crate::stored")]
        at: Point,
    },
    /// The tool is not clear of the roughing threshold.
    #[error("the tool at {from} is nearer to the part than roughing allows")]
    NotClear {
        /// Where the tool is.
        #[serde(with = "crate::stored")]
        from: Point,
    },
    /// The tool stands on an interrupted contour, and no certified motion leads on along it.
    #[error("the tool stands where no way leads on along the contour: lead it away from the part")]
    NoWayOn,
    /// The search for a job ended without an answer.
    #[error("working out the contour failed. Lead the tool away from the part, and try again.")]
    Failed,
    /// What is said to be done does not fit the plan.
    #[error(transparent)]
    Progress(#[from] ProgressError),
}

/// The job that contours every finishing loop in the free space around `from`, pass by pass, in each the nearest loop
/// first, and ends where the last loop was entered. Ways between loops keep the roughing threshold and stay inside
/// `within`.
///
/// # Errors
/// [`JobError`] when the tool stands too near, or there is nothing to finish here.
pub fn contour_job(plan: &CertifiedPlan, from: Point, within: Window) -> Result<ContourJob, JobError> {
    resume_job(plan, from, within, &Progress::default())
}

/// As [`contour_job`], for what `done` leaves: first what is left of loops that are cut in part, from where each was cut to
/// (or, where it can not be entered there, up to a tool radius before) to where it was first entered; then the loops that
/// are not begun.
///
/// # Errors
/// [`JobError`] as there, when everything here is finished, or when `done` does not fit the plan.
pub fn resume_job(
    plan: &CertifiedPlan,
    from: Point,
    within: Window,
    done: &Progress,
) -> Result<ContourJob, JobError> {
    done.check(plan)?;
    let here = plan.part.free_point(from, plan.roughing).map_err(|_| JobError::NotClear { from })?;
    let job = ContourJob { before: done.clone(), ..ContourJob::default() };
    let mut work = Work { plan, within, here, job };
    let passes = &plan.plan.passes;
    let components: Vec<usize> = passes.iter().map(|pass| pass.path.component_of(from)).collect();
    for partial in &done.partial {
        let LoopNumber { pass, index } = partial.number;
        if passes[pass].path.loops[index].component == components[pass] {
            work.go_on(partial)?;
        }
    }
    for (number, (pass, component)) in passes.iter().zip(components).enumerate() {
        work.pass(number, pass, component);
    }
    work.done(from)
}

/// A job as it is put together.
struct Work<'a> {
    plan: &'a CertifiedPlan,
    within: Window,
    here: FreePoint,
    job: ContourJob,
}

impl Work<'_> {
    /// Adds what is left of a loop.
    fn go_on(&mut self, partial: &PartialLoop) -> Result<(), ProgressError> {
        let number = partial.number;
        let each = &self.plan.plan.passes[number.pass].path.loops[number.index];
        let Some(track) = Track::of(each, self.plan.plan.cut) else {
            self.job.unreached.push(number);
            return Ok(());
        };
        match Rest::of(&track, partial)? {
            None => self.job.before.finish(number),
            Some(rest) => {
                let legs = self.cutter(number, &track).rest(self.here, &rest);
                self.take(number, legs);
            }
        }
        Ok(())
    }

    /// Adds the loops of a pass that are not begun, the nearest first.
    fn pass(&mut self, pass: usize, each: &Pass, component: usize) {
        let begun = |number| {
            let before = &self.job.before;
            before.has_finished(number) || before.partial.iter().any(|partial| partial.number == number)
        };
        let loops = each.path.loops.iter().enumerate();
        let mut open = Vec::new();
        let mut turned = Vec::new();
        for (index, each) in loops.filter(|(_, each)| each.component == component) {
            let number = LoopNumber { pass, index };
            match Track::of(each, self.plan.plan.cut) {
                _ if begun(number) => {}
                Some(track) => open.push((number, track)),
                None => turned.push(number),
            }
        }
        self.job.unreached.extend(turned);
        while !open.is_empty() {
            let near = |track: &Track| track.nearest(self.here.point()).0;
            open.sort_by(|(_, a), (_, b)| near(b).total_cmp(&near(a)));
            let Some((number, track)) = open.pop() else { break };
            let legs = self.cutter(number, &track).whole(self.here);
            self.take(number, legs);
        }
    }

    fn done(self, from: Point) -> Result<ContourJob, JobError> {
        let Self { job, .. } = self;
        if !job.legs.is_empty() {
            return Ok(job);
        }
        let lost = job.before.partial.iter().find(|partial| job.unreached.contains(&partial.number));
        Err(match lost {
            Some(&PartialLoop { number, resume_point, .. }) => {
                JobError::NoWayBack { number, at: resume_point }
            }
            None if job.unreached.is_empty() && job.before != Progress::default() => {
                JobError::AllFinished { from }
            }
            None => JobError::NothingHere { from },
        })
    }

    fn cutter<'b>(&'b self, number: LoopNumber, track: &'b Track) -> Cutter<'b> {
        Cutter { plan: self.plan, number, track, within: self.within }
    }

    fn take(&mut self, number: LoopNumber, legs: Option<LoopLegs>) {
        let Some(found) = legs else {
            self.job.unreached.push(number);
            return;
        };
        self.job.legs.extend(found.legs);
        self.job.tangential += usize::from(found.tangential);
        self.job.recut_mm += found.recut_mm;
        self.here = found.end;
    }
}

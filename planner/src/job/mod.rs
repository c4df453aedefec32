//! The contouring job: one chain of motions from the contact start along the finishing loops, and the
//! remaining contour of an interrupted job.
//!
//! The planner only proposes. The executor's guard certifies every motion again before it sends the first
//! one.

mod cutter;
mod deep;
mod in_place;
mod preview;
mod progress;
mod track;

use std::ops::Range;

use cutter::{Cutter, LoopLegs};
use deep::DeepWork;
pub use in_place::resume_in_place;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Curve, FreePoint, Height, Place, Point};
pub use preview::preview;
use progress::RemainingContour;
pub use progress::{DONE_MM, PartialLoop, Progress, ProgressError, SNAP_MM};
use serde::{Deserialize, Serialize};
use thiserror::Error;
use track::Track;
pub(crate) use track::share_nearest;

use crate::plan::{CertifiedPlan, Pass};

/// Section of a contouring job: a link move, or the cut along one loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Leg {
    /// The finishing loop that it cuts; `None` for a link move.
    pub cuts: Option<LoopNumber>,
    /// Its motions.
    #[serde(with = "crate::stored::many")]
    pub curves: Vec<Curve>,
    /// The height at the end of each motion. Empty for a job of two axes.
    #[serde(with = "crate::stored::many", default, skip_serializing_if = "Vec::is_empty")]
    pub heights: Vec<Height>,
    /// Motions that cut new material. Motions before them are the lead-in, motions after them the
    /// lead-out; these may recut a little of the loop. Empty for a link move.
    pub on_loop: Range<usize>,
    /// Point where the tool first entered the loop, in this job or in the job that it continues. The cut
    /// ends there. `None` for a link move.
    #[serde(with = "crate::stored::maybe")]
    pub entry: Option<Point>,
}

/// A loop of a finishing pass; both numbers count from 0.
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

/// A contouring job, and the loops that it leaves out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContourJob {
    /// The legs. Each begins at the end of the one before.
    pub legs: Vec<Leg>,
    /// Loops of the same free space for which no certified cut was found.
    pub unreached: Vec<LoopNumber>,
    /// Number of cuts with tangential lead-in and lead-out. The others approach the contour straight.
    pub tangential: usize,
    /// Progress of the job before this one.
    pub before: Progress,
    /// The height at which the job begins. It is zero for a job of two axes.
    #[serde(
        with = "crate::stored",
        default = "crate::stored::height_zero",
        skip_serializing_if = "crate::stored::is_height_zero"
    )]
    pub from: Height,
    /// Length of contour that it recuts, mm. It recuts where the tool could not enter or leave an
    /// interrupted loop exactly.
    pub recut_mm: f64,
}

impl ContourJob {
    /// Its motions in order: the leg, the curve, and the heights at its start and its end.
    pub fn motions(&self) -> impl Iterator<Item = (&Leg, &Curve, [Height; 2])> {
        let curves = self.legs.iter().flat_map(|leg| (0..leg.curves.len()).map(move |index| (leg, index)));
        curves.scan(self.from, |from, (leg, index)| {
            let to = leg.heights.get(index).copied().unwrap_or(*from);
            let heights = [std::mem::replace(from, to), to];
            Some((leg, leg.curves.get(index)?, heights))
        })
    }

    /// The leg of the job's motion `index`, and the motion's number in that leg. All numbers count from
    /// 0.
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

/// Reason why contouring cannot begin.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
pub enum JobError {
    /// No finishing loop lies in the free space of the tool.
    #[error("no contour to finish can be reached from {from}")]
    NothingHere {
        /// Position of the tool.
        #[serde(with = "crate::stored")]
        from: Point,
    },
    /// Every finishing loop in the free space of the tool is finished.
    #[error("every contour in the free space around {from} is finished")]
    AllFinished {
        /// Position of the tool.
        #[serde(with = "crate::stored")]
        from: Point,
    },
    /// Only an interrupted loop is left, and the tool cannot enter it again.
    #[error(
        "no link move leads back to {number} at {}, where it was interrupted, nor to a place up to one \
         tool radius before. Jog the tool near that place, or recut the contour: \
         `keepout run --resume LOG --recut CONTOUR`.",
        at
    )]
    NoWayBack {
        /// The loop.
        number: LoopNumber,
        /// Point where it was interrupted.
        #[serde(with = "crate::stored")]
        at: Point,
    },
    /// The tool is inside the jogging clearance.
    #[error("the tool at {from} is inside the jogging clearance. Jog it away from the part.")]
    NotClear {
        /// Position of the tool.
        #[serde(with = "crate::stored")]
        from: Point,
    },
    /// The tool is on an interrupted contour, and no certified motion leads on along it.
    #[error("no certified motion leads on along the contour from here. Jog the tool away from the part.")]
    NoWayOn,
    /// The search for a job ended without an answer.
    #[error("planning the contour failed. Jog the tool away from the part, and try again.")]
    Failed,
    /// The stated progress does not fit the plan.
    #[error(transparent)]
    Progress(#[from] ProgressError),
}

/// A job that contours every finishing loop in the free space around `from`. With a third axis, it contours all
/// loops at all depths, because the tool crosses above the part. It goes pass by pass, and in
/// each pass takes the nearest loop first. It ends at the point from which the tool entered the last
/// loop. Link moves keep the jogging clearance and stay inside `within`.
///
/// # Errors
/// [`JobError`] when the tool is inside the jogging clearance, or when this free space holds no loop to
/// finish.
pub fn contour_job(plan: &CertifiedPlan, from: Place, within: Window) -> Result<ContourJob, JobError> {
    resume_job(plan, from, within, &Progress::default())
}

/// A job that finishes the remaining contour after `done`; otherwise as [`contour_job`]. Interrupted
/// loops come first, each from its resume point to its entry. Where the tool cannot enter or leave a loop
/// exactly there, the job recuts up to one tool radius at that end. The loops that are not begun come
/// next.
///
/// # Errors
/// As [`contour_job`]; also when everything here is finished, or when `done` does not fit the plan.
pub fn resume_job(
    plan: &CertifiedPlan,
    from: Place,
    within: Window,
    done: &Progress,
) -> Result<ContourJob, JobError> {
    done.check(plan)?;
    if let Some(relief) = &plan.plan.relief {
        let job = ContourJob { before: done.clone(), ..ContourJob::default() };
        return DeepWork::new(plan, relief, from, job).finished();
    }
    let from = from.point;
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

/// A job under construction.
struct Work<'a> {
    plan: &'a CertifiedPlan,
    within: Window,
    here: FreePoint,
    job: ContourJob,
}

impl Work<'_> {
    /// Adds the remaining contour of a loop.
    fn go_on(&mut self, partial: &PartialLoop) -> Result<(), ProgressError> {
        let number = partial.number;
        let each = &self.plan.plan.passes[number.pass].path.loops[number.index];
        let Some(track) = Track::of(each, self.plan.plan.cut) else {
            self.job.unreached.push(number);
            return Ok(());
        };
        match RemainingContour::of(&track, partial)? {
            None => self.job.before.finish(number),
            Some(remaining) => {
                let legs = self.cutter(number, &track).remaining(self.here, &remaining);
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
        let mut unreached = Vec::new();
        for (index, each) in loops.filter(|(_, each)| each.component == component) {
            let number = LoopNumber { pass, index };
            match Track::of(each, self.plan.plan.cut) {
                _ if begun(number) => {}
                Some(track) => open.push((number, track)),
                None => unreached.push(number),
            }
        }
        self.job.unreached.extend(unreached);
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

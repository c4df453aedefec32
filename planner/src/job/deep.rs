//! The contouring job with a third axis: every contour from the top of the stock down to its bottom.
//!
//! Between contours the tool rises to the safe height, crosses, and lowers to just above the stock. It enters the
//! stock along the contour itself, on a ramp, so the entry needs no room beside the contour. A tool that cuts at
//! its centre plunges. Every motion is certified at its lower end.

use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, Height, Length, Place, Point, Segment};

use super::progress::RemainingContour;
use super::track::{Joint, Track, length_mm};
use super::{ContourJob, JobError, Leg, LoopNumber, PartialLoop, ProgressError};
use crate::depth::{EntryMove, Relief};
use crate::finish::FinishingLoop;
use crate::plan::CertifiedPlan;
use crate::units::{length_up_from_mm, mm};

/// Height above the stock, or above the last depth, at which the tool slows down to its cutting feed, mm.
const APPROACH_MM: f64 = 0.5;

/// A contour from its first depth to its last: the same loop in passes at successive depths.
struct Chain<'a> {
    /// The loops, downward.
    numbers: Vec<LoopNumber>,
    each: &'a FinishingLoop,
    track: Track,
}

/// A job under construction.
pub(super) struct DeepWork<'a> {
    plan: &'a CertifiedPlan,
    relief: &'a Relief,
    here: Place,
    job: ContourJob,
}

/// Motions with the height at the end of each.
#[derive(Default)]
struct Motions {
    curves: Vec<Curve>,
    heights: Vec<Height>,
}

impl Motions {
    fn push(&mut self, curve: Curve, height: Height) {
        self.curves.push(curve);
        self.heights.push(height);
    }

    /// Straight up or down, above one point.
    fn climb(&mut self, at: Place, to: Height) {
        if at.height != to {
            self.push(Curve::Line(Segment { from: at.point, to: at.point }), to);
        }
    }

    /// Along the curves, evenly from one height to another.
    fn along(&mut self, curves: Vec<Curve>, from: Height, to: Height) {
        let all: f64 = curves.iter().map(length_mm).sum();
        let (count, mut gone) = (curves.len(), 0.0);
        for (index, curve) in curves.into_iter().enumerate() {
            gone += length_mm(&curve);
            let share = if index + 1 == count { 1.0 } else { (gone / all.max(f64::MIN_POSITIVE)).min(1.0) };
            self.push(curve, between(from, to, share));
        }
    }
}

/// A height between two others.
fn between(from: Height, to: Height, share: f64) -> Height {
    let (low, high) = (f64::from(from.units()), f64::from(to.units()));
    Height::from_units(keepout_kernel::curve::nearest_unit(low + (high - low) * share)).unwrap_or(to)
}

impl<'a> DeepWork<'a> {
    pub(super) fn new(plan: &'a CertifiedPlan, relief: &'a Relief, here: Place, job: ContourJob) -> Self {
        Self { plan, relief, here, job: ContourJob { from: here.height, ..job } }
    }

    /// The whole job: interrupted loops first, then the contour nearest to the tool, then the others, with
    /// outlines last.
    pub(super) fn finished(mut self) -> Result<ContourJob, JobError> {
        let from = self.here.point;
        for partial in self.job.before.partial.clone() {
            self.go_on(&partial)?;
        }
        for stock in 0..self.plan.plan.passes_at_a_depth() {
            self.cut_chains(stock);
        }
        if !self.job.legs.is_empty() {
            return Ok(self.job);
        }
        let lost = self.job.before.partial.iter().find(|each| self.job.unreached.contains(&each.number));
        Err(match lost {
            Some(&PartialLoop { number, resume_point, .. }) => {
                JobError::NoWayBack { number, at: resume_point }
            }
            None if self.job.unreached.is_empty() => JobError::AllFinished { from },
            None => JobError::NothingHere { from },
        })
    }

    /// The contours in the passes with this number at each depth.
    fn chains(&self, stock: usize) -> Vec<Chain<'a>> {
        let plan = &self.plan.plan;
        let count = plan.passes_at_a_depth();
        let mut chains: Vec<Chain<'a>> = Vec::new();
        for (pass, each) in plan.passes.iter().enumerate().skip(stock).step_by(count) {
            for (index, each) in each.path.loops.iter().enumerate() {
                let number = LoopNumber { pass, index };
                let above = |chain: &&mut Chain<'_>| {
                    chain.numbers.last().is_some_and(|last| last.pass + count == pass)
                        && chain.each.curves == each.curves
                };
                if let Some(chain) = chains.iter_mut().find(above) {
                    chain.numbers.push(number);
                } else if let Some(track) = Track::of(each, plan.cut) {
                    chains.push(Chain { numbers: vec![number], each, track });
                }
            }
        }
        chains
    }

    fn cut_chains(&mut self, stock: usize) {
        let mut open = self.chains(stock);
        let mut first = true;
        while !open.is_empty() {
            let here = self.here.point;
            let key = |chain: &Chain<'_>| {
                let outline = !first && chain.each.component == 0;
                (outline, chain.track.nearest(here).0)
            };
            let nearest = open.iter().enumerate().min_by(|(_, a), (_, b)| {
                let ((a_last, a_mm), (b_last, b_mm)) = (key(a), key(b));
                a_last.cmp(&b_last).then(a_mm.total_cmp(&b_mm))
            });
            let Some(index) = nearest.map(|(index, _)| index) else { break };
            let chain = open.swap_remove(index);
            first = false;
            self.cut_chain(&chain, stock > 0);
        }
    }

    /// Cuts a contour depth by depth. `open`: an earlier pass left only the stock beside the contour.
    fn cut_chain(&mut self, chain: &Chain<'_>, open: bool) {
        let (mut opened, mut joint) = (Height::ZERO, None);
        for &number in &chain.numbers {
            let depth = self.plan.plan.passes[number.pass].height;
            if self.job.unreached.contains(&number) {
                break;
            }
            // The rest of an interrupted loop comes first in the job.
            let goes_on = self.job.before.partial.iter().any(|partial| partial.number == number);
            if goes_on || self.job.before.has_finished(number) {
                (opened, joint) = (depth, None);
                continue;
            }
            let start = joint.or_else(|| chain.track.joint(chain.track.nearest(self.here.point).1));
            // After an earlier pass only a thin wall is left, and the tool lowers through it at its cutting feed.
            let (slow, from) = if open { (Height::ZERO, depth) } else { (opened, opened) };
            let leg = start.and_then(|start| self.cut(chain, number, start, [slow, from, depth]));
            let Some((leg, end)) = leg else {
                self.job.unreached.push(number);
                break;
            };
            self.take(leg, end.point.at_height(depth));
            (opened, joint) = (depth, Some(end));
        }
        self.rise();
    }

    /// The cut along one loop at its depth, from a place on it, and the place where it ends. The tool comes down
    /// fast to above `slow`, and at its cutting feed to `opened`, the height down to which the stock is gone.
    fn cut(
        &mut self,
        chain: &Chain<'_>,
        number: LoopNumber,
        start: Joint,
        [slow, opened, depth]: [Height; 3],
    ) -> Option<(Leg, Joint)> {
        let mut motions = Motions::default();
        let mut at = start.point.at_height(opened);
        if self.here != at {
            self.go_above(start.point, slow)?;
            motions.climb(self.here, opened);
        }
        let mut end = start;
        let steps = self.steps(opened, depth);
        for (index, &to) in steps.iter().enumerate() {
            end = self.enter(&chain.track, &mut motions, (end, at.height), to)?;
            at = end.point.at_height(to);
            if index + 1 < steps.len() {
                motions.along(chain.track.stretch(&end, &end)?, to, to);
            }
        }
        let round = chain.track.stretch(&end, &end)?;
        let on_loop = motions.curves.len()..motions.curves.len() + round.len();
        motions.along(round, depth, depth);
        let Motions { curves, heights } = motions;
        let leg = Leg { cuts: Some(number), curves, heights, on_loop, entry: Some(end.point) };
        self.is_certified(&leg).then_some((leg, end))
    }

    /// The heights of the laps from `opened` down to `depth`, each at most the step-down below the one before.
    fn steps(&self, opened: Height, depth: Height) -> Vec<Height> {
        let down = i64::from(opened.units()) - i64::from(depth.units());
        let most = i64::from(self.relief.step_down.units()).max(1);
        let count = (down + most - 1).div_euclid(most).max(1);
        let lap = |k: i64| opened.lowered(Length::from_units(down * k / count).unwrap_or(Length::ZERO));
        (1..=count).map(lap).collect()
    }

    /// Enters the stock from a place on the loop down to a height: straight, or on a ramp along the loop. Returns
    /// the place where the tool reaches that height.
    fn enter(
        &self,
        track: &Track,
        motions: &mut Motions,
        (start, from): (Joint, Height),
        to: Height,
    ) -> Option<Joint> {
        let EntryMove::Ramp { slope } = self.relief.entry else {
            motions.climb(start.point.at_height(from), to);
            return Some(start);
        };
        let drop_mm = mm(from.units()) - mm(to.units());
        if drop_mm <= 0.0 {
            return Some(start);
        }
        let (length_mm, mut left_mm) = (track.length_mm(), drop_mm / slope);
        let mut way = Vec::new();
        while left_mm > length_mm {
            way.extend(track.stretch(&start, &start)?);
            left_mm -= length_mm;
        }
        let end = track.joint_behind(start.entry.along_mm + left_mm)?;
        way.extend(track.stretch(&start, &end)?);
        motions.along(way, from, to);
        Some(end)
    }

    /// Adds the remaining contour of an interrupted loop. The tool enters one radius before the resume point, where
    /// the stock is open. A loop of which less is cut is cut again.
    fn go_on(&mut self, partial: &PartialLoop) -> Result<(), ProgressError> {
        let number = partial.number;
        let pass = &self.plan.plan.passes[number.pass];
        let each = &pass.path.loops[number.index];
        let Some(track) = Track::of(each, self.plan.plan.cut) else {
            self.job.unreached.push(number);
            return Ok(());
        };
        let back_mm = mm(self.plan.plan.tool_radius.units());
        match RemainingContour::of(&track, partial)? {
            None => self.job.before.finish(number),
            Some(remaining) if remaining.cut_mm() < 2.0 * back_mm => self.job.before.forget(number),
            Some(remaining) => match self.remaining(number, pass.height, &track, (&remaining, back_mm)) {
                None => self.job.unreached.push(number),
                Some((leg, end)) => {
                    self.take(leg, end.at_height(pass.height));
                    self.job.recut_mm += back_mm;
                    self.rise();
                }
            },
        }
        Ok(())
    }

    fn remaining(
        &mut self,
        number: LoopNumber,
        depth: Height,
        track: &Track,
        (remaining, back_mm): (&RemainingContour, f64),
    ) -> Option<(Leg, Point)> {
        let (begin, end) = remaining.joints(track)?;
        let first = remaining.joint_before(track, back_mm)?;
        self.go_above(first.point, Height::ZERO)?;
        let mut motions = Motions::default();
        motions.climb(self.here, depth);
        motions.along(track.stretch(&first, &begin)?, depth, depth);
        let left = track.stretch(&begin, &end)?;
        let on_loop = motions.curves.len()..motions.curves.len() + left.len();
        motions.along(left, depth, depth);
        let Motions { curves, heights } = motions;
        let leg = Leg { cuts: Some(number), curves, heights, on_loop, entry: Some(end.point) };
        self.is_certified(&leg).then_some((leg, end.point))
    }

    /// Adds the link move to just above a point that is open down to a height: up, across, down.
    fn go_above(&mut self, point: Point, opened: Height) -> Option<()> {
        let safe = self.relief.safe.max(self.here.height);
        let near = opened.raised(length_up_from_mm(APPROACH_MM).ok()?).min(safe);
        let mut motions = Motions::default();
        if self.here.point != point {
            motions.climb(self.here, safe);
            motions.push(Curve::Line(Segment { from: self.here.point, to: point }), safe);
            motions.climb(point.at_height(safe), near);
        } else {
            motions.climb(self.here, near);
        }
        let Motions { curves, heights } = motions;
        if curves.is_empty() {
            return Some(());
        }
        let leg = Leg { cuts: None, curves, heights, on_loop: 0..0, entry: None };
        self.is_certified(&leg).then(|| self.take(leg, point.at_height(near)))
    }

    /// Adds the rise to the safe height.
    fn rise(&mut self) {
        let mut motions = Motions::default();
        let safe = self.relief.safe.max(self.here.height);
        motions.climb(self.here, safe);
        let Motions { curves, heights } = motions;
        if !curves.is_empty() {
            let leg = Leg { cuts: None, curves, heights, on_loop: 0..0, entry: None };
            self.take(leg, self.here.point.at_height(safe));
        }
    }

    /// Whether every motion keeps the finishing clearance from what stands above its lower end.
    fn is_certified(&self, leg: &Leg) -> bool {
        let mut from = self.here.height;
        leg.curves.iter().zip(&leg.heights).all(|(curve, &to)| {
            let lowest = from.min(to);
            from = to;
            certify_path(self.plan.region(lowest), self.plan.finishing, std::slice::from_ref(curve)).is_ok()
        })
    }

    fn take(&mut self, leg: Leg, end: Place) {
        self.job.legs.push(leg);
        self.here = end;
    }
}

//! Progress of a contouring job, and the remaining contour of an interrupted loop.

use std::collections::BTreeSet;

use keepout_kernel::{Curve, Point};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::track::{Joint, PIECE_MM, Track, length_mm, share_nearest};
use super::{ContourJob, Leg, LoopNumber};
use crate::plan::CertifiedPlan;
use crate::units::{along_mm, point_from_mm, point_mm};

/// Largest distance of a stored or reported place from its loop, mm. Reports are rounded, to a step or
/// two.
pub const SNAP_MM: f64 = 0.05;
/// A loop counts as finished when at most this length remains, mm. There the tool's disc leaves less than
/// 0.1 µm, for any tool of at least 0.3 mm.
pub const DONE_MM: f64 = 0.01;
/// Two places on a loop are ambiguous when their distances from a reported point differ by at most this,
/// mm.
const ALIKE_MM: f64 = 0.005;
/// The same for a point that was chosen on the loop, and not reported, mm.
const EXACT_MM: f64 = 0.000_1;

/// Progress of a contouring job, over this run and earlier runs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Progress {
    /// Finished loops.
    pub finished: Vec<LoopNumber>,
    /// Loops that are cut in part: at most one for each free space in which a job was interrupted.
    pub partial: Vec<PartialLoop>,
}

/// A loop that is cut from its entry to the last certain place of the tool on it, in the plan's direction
/// of cut. A loop without any cut is not listed: a `resume_point` at the entry means that the loop was
/// cut once around.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartialLoop {
    /// The loop.
    pub number: LoopNumber,
    /// Point where the tool first entered it. The remaining contour ends there.
    #[serde(with = "crate::stored")]
    pub entry: Point,
    /// Last point to which it was certainly cut.
    #[serde(with = "crate::stored")]
    pub resume_point: Point,
}

/// Reason why a progress does not fit a plan.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
pub enum ProgressError {
    /// The plan has no such loop.
    #[error(
        "the plan has no {number}: the progress belongs to another plan. \
         Use that plan, or start without --resume."
    )]
    NoSuchLoop {
        /// The loop.
        number: LoopNumber,
    },
    /// The progress lists a loop twice.
    #[error("the progress lists {number} twice: it was changed. Start without --resume.")]
    Twice {
        /// The loop.
        number: LoopNumber,
    },
    /// A stored place is not on the loop.
    #[error(
        "the progress has {at} on {number}, but that point is {away_mm:.3} mm off the loop \
         (at most {SNAP_MM} mm). \
         Use the plan and the origin of the interrupted run, or start without --resume."
    )]
    Off {
        /// The loop.
        number: LoopNumber,
        /// The place.
        #[serde(with = "crate::stored")]
        at: Point,
        /// Its distance, mm.
        away_mm: f64,
    },
    /// The loop crosses its entry point twice.
    #[error(
        "{number} crosses its entry point {at} twice, so its progress is ambiguous. Recut its contour: --recut CONTOUR"
    )]
    EnteredTwice {
        /// The loop.
        number: LoopNumber,
        /// The entry.
        #[serde(with = "crate::stored")]
        at: Point,
    },
}

impl Progress {
    /// Progress of `job` when `at` is the last position of the tool, on curve `curve` of leg `leg`. Both
    /// numbers count from 0, and everything before that curve is done. A leg number beyond the last leg
    /// means a finished job, and a curve number beyond the last curve a finished leg.
    ///
    /// When `at` is farther than [`SNAP_MM`] from the curve, no part of the curve counts as done.
    #[must_use]
    pub fn after(job: &ContourJob, leg: usize, curve: usize, at: Point) -> Self {
        let mut progress = job.before.clone();
        let done = job.legs.iter().take(leg).filter_map(|leg| leg.cuts);
        for number in done {
            progress.finish(number);
        }
        let under_way = job.legs.get(leg).and_then(|leg| Some((leg, leg.cuts?, leg.entry?)));
        if let Some((leg, number, entry)) = under_way {
            match leg.resume_point(curve, at) {
                CutExtent::Nothing => {}
                CutExtent::Here(resume_point) => {
                    progress.partial.retain(|each| each.number != number);
                    progress.partial.push(PartialLoop { number, entry, resume_point });
                }
                CutExtent::End => progress.finish(number),
            }
        }
        progress
    }

    /// Whether the loop is finished.
    #[must_use]
    pub fn has_finished(&self, number: LoopNumber) -> bool {
        self.finished.contains(&number)
    }

    /// Removes a loop from the progress, so the next job recuts it.
    pub fn forget(&mut self, number: LoopNumber) {
        self.partial.retain(|each| each.number != number);
        self.finished.retain(|each| *each != number);
    }

    /// Marks a loop as finished.
    pub fn finish(&mut self, number: LoopNumber) {
        self.partial.retain(|each| each.number != number);
        if !self.has_finished(number) {
            self.finished.push(number);
        }
    }

    /// Checks that every loop is a loop of the plan, and is listed once.
    ///
    /// # Errors
    /// [`ProgressError`] for the first loop that fails.
    pub fn check(&self, plan: &CertifiedPlan) -> Result<(), ProgressError> {
        let mut listed = BTreeSet::new();
        for number in self.finished.iter().copied().chain(self.partial.iter().map(|each| each.number)) {
            if !number.is_of(plan) {
                return Err(ProgressError::NoSuchLoop { number });
            }
            if !listed.insert((number.pass, number.index)) {
                return Err(ProgressError::Twice { number });
            }
        }
        Ok(())
    }
}

/// Extent of the cut along a leg's loop.
enum CutExtent {
    Nothing,
    Here(Point),
    End,
}

impl Leg {
    fn resume_point(&self, curve: usize, at: Point) -> CutExtent {
        if curve >= self.on_loop.end {
            return CutExtent::End;
        }
        if curve < self.on_loop.start {
            return CutExtent::Nothing;
        }
        let Some(under_way) = self.curves.get(curve) else { return CutExtent::Nothing };
        let length = |curves: &[Curve]| curves.iter().map(length_mm).sum::<f64>();
        let (share, resume_point) = place_of(under_way, at).unwrap_or((0.0, under_way.from()));
        // A job from a file may claim curves that it does not have.
        let of = |range| length(self.curves.get(range).unwrap_or(&[]));
        let cut = of(self.on_loop.start..curve) + share * length_mm(under_way);
        match of(self.on_loop.clone()) - cut {
            left if left <= DONE_MM => CutExtent::End,
            _ if cut <= DONE_MM => CutExtent::Nothing,
            _ => CutExtent::Here(resume_point),
        }
    }
}

/// The place on the curve nearest to `at`, within [`SNAP_MM`].
fn place_of(curve: &Curve, at: Point) -> Option<(f64, Point)> {
    let (share, away_mm) = nearest_share(curve, at);
    let on = along_mm(curve, share).0;
    (away_mm <= SNAP_MM).then_some((share, point_from_mm(on).ok()?))
}

/// Share of a curve's length at which it is nearest to `at`, and the distance there, mm.
pub(super) fn nearest_share(curve: &Curve, at: Point) -> (f64, f64) {
    let at = point_mm(at);
    let share = share_nearest(curve, at);
    (share, along_mm(curve, share).0.distance(at))
}

/// Remaining contour of a loop: from `cut_mm` beyond its entry, once around, to the entry.
pub(super) struct RemainingContour {
    entry_mm: f64,
    cut_mm: f64,
    length_mm: f64,
}

impl RemainingContour {
    /// The remaining contour of the track; `None` when the loop is finished. Where the loop passes near
    /// itself, `resume_point` may fit two places. The earlier place counts: a second cut is better than
    /// an uncut stretch.
    pub fn of(track: &Track, partial: &PartialLoop) -> Result<Option<Self>, ProgressError> {
        let PartialLoop { number, entry, resume_point } = *partial;
        let length_mm = track.length_mm();
        let entry_mm = single(track, number, entry)?;
        let beyond_entry = |along_mm: f64| {
            let beyond = (along_mm - entry_mm).rem_euclid(length_mm);
            if beyond < AT_ENTRY_MM { length_mm } else { beyond }
        };
        let cut_mm = candidates(track, number, resume_point, ALIKE_MM)?;
        let cut_mm = cut_mm.into_iter().map(beyond_entry).fold(length_mm, f64::min);
        // Half of it, because places are rounded: what [`Progress::after`] lists as partial is never finished here.
        Ok((length_mm - cut_mm > 0.5 * DONE_MM).then_some(Self { entry_mm, cut_mm, length_mm }))
    }

    /// Start and end of the remaining contour.
    pub fn joints(&self, track: &Track) -> Option<(Joint, Joint)> {
        let end = self.joint_behind(track, 0.0)?;
        // The cut is so short that the joints could pass each other. The whole loop remains.
        let whole = self.cut_mm < 4.0 * PIECE_MM;
        Some((if whole { end } else { self.joint_before(track, 0.0)? }, end))
    }

    /// The joint `back_mm` before the start of the remaining contour.
    pub fn joint_before(&self, track: &Track, back_mm: f64) -> Option<Joint> {
        track.joint_before(self.entry_mm + self.cut_mm - back_mm)
    }

    /// The joint `beyond_mm` beyond its end.
    pub fn joint_behind(&self, track: &Track, beyond_mm: f64) -> Option<Joint> {
        track.joint_behind(self.entry_mm + beyond_mm)
    }

    /// Length that is cut, mm.
    pub fn cut_mm(&self) -> f64 {
        self.cut_mm
    }

    /// Length that remains, mm.
    pub fn left_mm(&self) -> f64 {
        self.length_mm - self.cut_mm
    }
}

/// A place less than this beyond the entry counts as the entry, mm.
const AT_ENTRY_MM: f64 = 0.001;

/// Position of `at` along the track, mm, when it is unambiguous.
fn single(track: &Track, number: LoopNumber, at: Point) -> Result<f64, ProgressError> {
    let (_, nearest) = track.nearest(at);
    let apart = |along_mm: &f64| {
        let away = (along_mm - nearest.along_mm).rem_euclid(track.length_mm());
        away.min(track.length_mm() - away) > SNAP_MM
    };
    if candidates(track, number, at, EXACT_MM)?.iter().any(apart) {
        return Err(ProgressError::EnteredTwice { number, at });
    }
    Ok(nearest.along_mm)
}

/// Positions along the track, mm, of all places that may be `at`: each is at most `alike_mm` farther from
/// it than the nearest.
fn candidates(
    track: &Track,
    number: LoopNumber,
    at: Point,
    alike_mm: f64,
) -> Result<Vec<f64>, ProgressError> {
    let (away_mm, _) = track.nearest(at);
    if away_mm > SNAP_MM {
        return Err(ProgressError::Off { number, at, away_mm });
    }
    let alike = track.nearest_of_each(at).filter(|(distance, _)| *distance <= away_mm + alike_mm);
    Ok(alike.map(|(_, entry)| entry.along_mm).collect())
}

#[cfg(test)]
mod tests {
    use crate::Mm2;
    use keepout_kernel::Segment;

    use super::*;
    use crate::finish::FinishingLoop;
    use crate::plan::Cut;

    const NUMBER: LoopNumber = LoopNumber { pass: 0, index: 0 };

    fn at(x_mm: f64, y_mm: f64) -> Point {
        point_from_mm(Mm2::new(x_mm, y_mm)).unwrap()
    }

    /// A slot of 10 mm: two walls in opposite directions, 2 µm apart.
    fn slot(cut: Cut) -> Track {
        let corners = [at(0.0, 0.0), at(10.0, 0.0), at(10.0, 0.002), at(0.0, 0.002)];
        let next = corners.iter().cycle().skip(1);
        let lines = corners.iter().zip(next).map(|(&from, &to)| Curve::Line(Segment { from, to }));
        Track::of(&FinishingLoop { curves: lines.collect(), component: 0 }, cut).unwrap()
    }

    #[test]
    fn ambiguous_resume_point_counts_as_the_earlier_place() {
        for (cut, entry) in [(Cut::Conventional, at(1.0, 0.0)), (Cut::Climb, at(1.0, 0.002))] {
            let track = slot(cut);
            for y in [0.0, 0.001, 0.002, 0.004] {
                let partial = PartialLoop { number: NUMBER, entry, resume_point: at(4.0, y) };
                let remaining = RemainingContour::of(&track, &partial).unwrap().unwrap();
                assert!((remaining.cut_mm() - 3.0).abs() < 1e-6, "{cut:?} {y}: {}", remaining.cut_mm());
            }
        }
    }

    #[test]
    fn ambiguous_entry_is_refused() {
        let entry = at(5.0, 0.001);
        let partial = PartialLoop { number: NUMBER, entry, resume_point: at(6.0, 0.0) };
        let refused = RemainingContour::of(&slot(Cut::Conventional), &partial).err();
        assert_eq!(refused, Some(ProgressError::EnteredTwice { number: NUMBER, at: entry }));
    }

    #[test]
    fn loop_that_is_cut_back_to_its_entry_is_finished() {
        let track = slot(Cut::Conventional);
        let entry = at(0.0, 0.0);
        for (x, done) in [(0.0, true), (0.005, false), (0.03, false)] {
            let remaining = RemainingContour::of(
                &track,
                &PartialLoop { number: NUMBER, entry, resume_point: at(x, 0.0) },
            )
            .unwrap();
            assert_eq!(remaining.is_none(), done, "{x}");
        }
    }
}

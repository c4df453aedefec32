//! What of a contouring job is done, and what is left of a loop that was interrupted.

use std::collections::BTreeSet;

use keepout_kernel::{Curve, Point};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::track::{Joint, PIECE_MM, Track, length_mm, share_nearest};
use super::{ContourJob, Leg, LoopNumber};
use crate::plan::CertifiedPlan;
use crate::units::{along_mm, point_from_mm, point_mm};

/// Places of an interrupted loop are looked for on it within this, mm: reported positions are rounded, to a step or two.
pub const SNAP_MM: f64 = 0.05;
/// A loop of which no more than this is left counts as finished, mm: the disc leaves less than 0.1 µm there for any tool of
/// 0.3 mm and more.
pub const DONE_MM: f64 = 0.01;
/// Places on a loop that are nearer to a point than the nearest by no more than this can not be told apart, mm.
const ALIKE_MM: f64 = 0.005;
/// The same where the point was chosen on the loop, and not reported, mm.
const EXACT_MM: f64 = 0.000_1;

/// What is done of a contouring job, by this and earlier runs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Progress {
    /// The loops that are cut whole.
    pub finished: Vec<LoopNumber>,
    /// The loops that are cut in part: one for each free space in which a job was interrupted, at most.
    pub partial: Vec<PartialLoop>,
}

/// A loop that is cut from where it was entered to where the tool was last on it, in the plan's direction of cut. One that
/// nothing is cut of yet is none: `resume_point` at the entry means that it was cut once around.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartialLoop {
    /// The loop.
    pub number: LoopNumber,
    /// Where it was first entered: what is left of it ends there.
    #[serde(with = "crate::stored")]
    pub entry: Point,
    /// The last place to which it was certainly cut.
    #[serde(with = "crate::stored")]
    pub resume_point: Point,
}

/// Why a progress does not fit a plan.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
pub enum ProgressError {
    /// The plan has no such loop.
    #[error(
        "the plan has no {number}: this progress is that of another plan. Take that plan, or begin anew."
    )]
    NoSuchLoop {
        /// The loop.
        number: LoopNumber,
    },
    /// It is told twice how far a loop is cut.
    #[error("it is told twice how far {number} is cut: this progress was changed. Begin anew.")]
    Twice {
        /// The loop.
        number: LoopNumber,
    },
    /// A place is not on the loop.
    #[error(
        "{} is {away_mm:.3} mm from {number}, on which it is said to lie, more than {SNAP_MM} mm. Take the plan and the place of the drawing of the run that was interrupted, or begin anew.",
        at
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
    /// The loop passes the place where it was entered twice.
    #[error(
        "{number} passes its entry at {at} twice, so that nobody can tell what of it is cut. Cut it anew."
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
    /// The progress when the tool was last seen at `at` on a curve of a leg, both counted from 0; what came before them is
    /// done. A leg beyond the last means that the job is finished, a curve beyond a leg's last that the leg is. When `at` is
    /// farther than [`SNAP_MM`] from the curve, nothing of the curve counts as done.
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
                CutTo::Nothing => {}
                CutTo::Here(resume_point) => {
                    progress.partial.retain(|each| each.number != number);
                    progress.partial.push(PartialLoop { number, entry, resume_point });
                }
                CutTo::End => progress.finish(number),
            }
        }
        progress
    }

    /// Whether the loop is cut whole.
    #[must_use]
    pub fn has_finished(&self, number: LoopNumber) -> bool {
        self.finished.contains(&number)
    }

    /// Forgets what is known of a loop, so that it is cut anew.
    pub fn forget(&mut self, number: LoopNumber) {
        self.partial.retain(|each| each.number != number);
        self.finished.retain(|each| *each != number);
    }

    /// Marks a loop as cut whole.
    pub fn finish(&mut self, number: LoopNumber) {
        self.partial.retain(|each| each.number != number);
        if !self.has_finished(number) {
            self.finished.push(number);
        }
    }

    /// Checks that every loop is one of the plan's, and is told of once.
    ///
    /// # Errors
    /// [`ProgressError`] naming the first loop that is not.
    pub fn check(&self, plan: &CertifiedPlan) -> Result<(), ProgressError> {
        let mut told = BTreeSet::new();
        for number in self.finished.iter().copied().chain(self.partial.iter().map(|each| each.number)) {
            if !number.is_of(plan) {
                return Err(ProgressError::NoSuchLoop { number });
            }
            if !told.insert((number.pass, number.index)) {
                return Err(ProgressError::Twice { number });
            }
        }
        Ok(())
    }
}

/// How far a leg has cut its loop.
enum CutTo {
    Nothing,
    Here(Point),
    End,
}

impl Leg {
    fn resume_point(&self, curve: usize, at: Point) -> CutTo {
        if curve >= self.on_loop.end {
            return CutTo::End;
        }
        if curve < self.on_loop.start {
            return CutTo::Nothing;
        }
        let Some(under_way) = self.curves.get(curve) else { return CutTo::Nothing };
        let length = |curves: &[Curve]| curves.iter().map(length_mm).sum::<f64>();
        let (share, resume_point) = place_of(under_way, at).unwrap_or((0.0, under_way.from()));
        // A job that was made by somebody else may claim what it does not have.
        let of = |range| length(self.curves.get(range).unwrap_or(&[]));
        let cut = of(self.on_loop.start..curve) + share * length_mm(under_way);
        match of(self.on_loop.clone()) - cut {
            left if left <= DONE_MM => CutTo::End,
            _ if cut <= DONE_MM => CutTo::Nothing,
            _ => CutTo::Here(resume_point),
        }
    }
}

/// The place on the curve nearest to `at`, when it is near.
fn place_of(curve: &Curve, at: Point) -> Option<(f64, Point)> {
    let (share, away_mm) = nearest_share(curve, at);
    let on = along_mm(curve, share).0;
    (away_mm <= SNAP_MM).then_some((share, point_from_mm(on).ok()?))
}

/// The share of a curve's length at which it is nearest to `at`, and the distance there, mm.
pub(super) fn nearest_share(curve: &Curve, at: Point) -> (f64, f64) {
    let (x, y) = point_mm(at);
    let share = share_nearest(curve, (x, y));
    let on = along_mm(curve, share).0;
    (share, (on.0 - x).hypot(on.1 - y))
}

/// What is left of a loop: from `cut_mm` beyond its entry once around to the entry.
pub(super) struct Rest {
    entry_mm: f64,
    cut_mm: f64,
    length_mm: f64,
}

impl Rest {
    /// What is left of the track; `None` when it is finished. Where the loop passes near itself, and `resume_point` can be two places,
    /// the earlier counts: rather is cut twice than not.
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
        Ok((length_mm - cut_mm > DONE_MM).then_some(Self { entry_mm, cut_mm, length_mm }))
    }

    /// Where the rest begins and ends.
    pub fn joints(&self, track: &Track) -> Option<(Joint, Joint)> {
        let end = self.joint_behind(track, 0.0)?;
        // So little is cut that joints could pass each other: the whole loop is left.
        let whole = self.cut_mm < 4.0 * PIECE_MM;
        Some((if whole { end } else { self.joint_before(track, 0.0)? }, end))
    }

    /// A place so far before the rest's beginning, mm.
    pub fn joint_before(&self, track: &Track, back_mm: f64) -> Option<Joint> {
        track.joint_before(self.entry_mm + self.cut_mm - back_mm)
    }

    /// A place so far beyond the rest's end, mm.
    pub fn joint_behind(&self, track: &Track, beyond_mm: f64) -> Option<Joint> {
        track.joint_behind(self.entry_mm + beyond_mm)
    }

    /// What is cut, mm.
    pub fn cut_mm(&self) -> f64 {
        self.cut_mm
    }

    /// What is left, mm.
    pub fn left_mm(&self) -> f64 {
        self.length_mm - self.cut_mm
    }
}

/// Nearer than this beyond the entry counts as at the entry, mm.
const AT_ENTRY_MM: f64 = 0.001;

/// How far along the track `at` is, when it can be only one place.
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

/// How far along the track each place is that can not be told from the nearest to `at`, mm.
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
    use keepout_kernel::Segment;

    use super::*;
    use crate::finish::FinishingLoop;
    use crate::plan::Cut;

    const NUMBER: LoopNumber = LoopNumber { pass: 0, index: 0 };

    fn at(x_mm: f64, y_mm: f64) -> Point {
        point_from_mm((x_mm, y_mm)).unwrap()
    }

    /// There and back along a slot of 10 mm, 2 µm apart.
    fn slot(cut: Cut) -> Track {
        let corners = [at(0.0, 0.0), at(10.0, 0.0), at(10.0, 0.002), at(0.0, 0.002)];
        let next = corners.iter().cycle().skip(1);
        let lines = corners.iter().zip(next).map(|(&from, &to)| Curve::Line(Segment { from, to }));
        Track::of(&FinishingLoop { curves: lines.collect(), component: 0 }, cut).unwrap()
    }

    #[test]
    fn of_places_that_can_not_be_told_apart_the_earlier_counts() {
        for (cut, entry) in [(Cut::Conventional, at(1.0, 0.0)), (Cut::Climb, at(1.0, 0.002))] {
            let track = slot(cut);
            for y in [0.0, 0.001, 0.002, 0.004] {
                let partial = PartialLoop { number: NUMBER, entry, resume_point: at(4.0, y) };
                let rest = Rest::of(&track, &partial).unwrap().unwrap();
                assert!((rest.cut_mm() - 3.0).abs() < 1e-6, "{cut:?} {y}: {}", rest.cut_mm());
            }
        }
    }

    #[test]
    fn an_entry_that_can_be_two_places_is_refused() {
        let entry = at(5.0, 0.001);
        let partial = PartialLoop { number: NUMBER, entry, resume_point: at(6.0, 0.0) };
        let refused = Rest::of(&slot(Cut::Conventional), &partial).err();
        assert_eq!(refused, Some(ProgressError::EnteredTwice { number: NUMBER, at: entry }));
    }

    #[test]
    fn at_its_end_a_loop_is_finished() {
        let track = slot(Cut::Conventional);
        let entry = at(0.0, 0.0);
        for (x, done) in [(0.0, true), (0.005, false), (0.03, false)] {
            let rest =
                Rest::of(&track, &PartialLoop { number: NUMBER, entry, resume_point: at(x, 0.0) }).unwrap();
            assert_eq!(rest.is_none(), done, "{x}");
        }
    }
}

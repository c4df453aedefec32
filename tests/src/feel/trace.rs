//! True tool positions over time, and the figures from them.

use keepout_executor::session::Sample;
use keepout_planner::Mm2;

use super::scene::Scene;
use super::{DIP, Release, Slide};

/// Time between two compared positions, s.
const WINDOW_S: f64 = 0.02;
/// The tool stood still between two samples that are farther apart than this, s.
const GAP_S: f64 = 0.025;
/// A tool stands still if it moves no farther than this in a window, mm. It is less than a step.
const STILL_MM: f64 = 0.002;

/// True tool positions.
pub(super) struct Trace {
    samples: Vec<(f64, Mm2)>,
}

impl Trace {
    pub(super) fn of(samples: &[Sample]) -> Self {
        let place = |sample: &Sample| (sample.at.elapsed().as_secs_f64(), sample.position_mm.plane());
        Self { samples: samples.iter().map(place).collect() }
    }

    /// The position of the tool at time `t`, interpolated.
    fn at(&self, t: f64) -> Mm2 {
        let after = self.samples.partition_point(|sample| sample.0 <= t);
        let before = self.samples[after.saturating_sub(1)];
        match self.samples.get(after) {
            Some(next) if next.0 - before.0 < GAP_S => {
                let share = ((t - before.0) / (next.0 - before.0).max(1e-9)).clamp(0.0, 1.0);
                before.1 + (next.1 - before.1) * share
            }
            _ => before.1,
        }
    }

    fn end(&self) -> f64 {
        self.samples.last().map_or(0.0, |sample| sample.0)
    }

    /// The time of the first sample with such a position.
    pub(super) fn first(&self, is: impl Fn(Mm2) -> bool) -> Option<f64> {
        self.samples.iter().find(|sample| is(sample.1)).map(|sample| sample.0)
    }

    /// The first time after `t` at which the tool was this fast.
    pub(super) fn first_speed_after(&self, t: f64, speed_mm_s: f64) -> Option<f64> {
        let mut times = self.samples.iter().map(|sample| sample.0).filter(|&at| at > t);
        times.find(|&at| self.at(at - WINDOW_S).distance(self.at(at)) >= speed_mm_s * WINDOW_S)
    }

    /// The figures of a slide. Heights count from the first of the times, speeds from the second, both up to
    /// the third. `whole` chooses from commanded and mean speed. A dip is below the share [`DIP`] of that
    /// choice.
    pub(super) fn slide(
        &self,
        scene: &Scene,
        (arrived, settled, end): (f64, f64, Option<f64>),
        commanded: f64,
        whole: impl Fn(f64, f64) -> f64,
    ) -> Slide {
        // At its end the session brings the tool to rest: that part does not count.
        let last = self.end() - 1.0_f64.min((self.end() - arrived) / 4.0);
        let end = end.unwrap_or(f64::INFINITY).min(last);
        let times = |from: f64| {
            let mut t = from;
            std::iter::from_fn(move || {
                t += WINDOW_S;
                (t < end).then_some(t)
            })
        };
        let mut heights: Vec<f64> = times(arrived).map(|t| scene.height_mm(self.at(t))).collect();
        heights.sort_by(f64::total_cmp);
        let steps: Vec<f64> = times(settled).map(|t| self.at(t - WINDOW_S).distance(self.at(t))).collect();
        let length_mm: f64 = steps.iter().sum();
        let mean = length_mm / (number(steps.len()).max(1.0) * WINDOW_S);
        let least = DIP * whole(commanded, mean) * WINDOW_S;
        let entered = |below: &dyn Fn(f64) -> bool| {
            let mut was = false;
            steps.iter().filter(|&&step| !std::mem::replace(&mut was, below(step)) && was).count()
        };
        Slide {
            share: mean / commanded,
            speed_mm_s: mean,
            dips_per_m: number(entered(&|step| step < least)) / (length_mm / 1000.0).max(1e-3),
            height_mm: percentile(&heights, 90),
            stops: entered(&|step| step < STILL_MM),
            length_mm,
        }
    }

    /// Seconds from `t`, with the tool at rest, to its first step. The computation goes back from the first
    /// moved sample with the acceleration.
    pub(super) fn first_step_after(&self, t: f64, acceleration_mm_s2: f64) -> Option<f64> {
        let rest = self.at(t);
        let moved = self.samples.iter().find(|sample| sample.0 > t && sample.1.distance(rest) > STILL_MM)?;
        let since = |mm: f64| (2.0 * mm / acceleration_mm_s2).sqrt();
        Some(moved.0 - since(moved.1.distance(rest)) + since(STILL_MM) - t)
    }

    /// The stop of the tool after `t`.
    pub(super) fn rest_after(&self, t: f64) -> Release {
        let end = self.samples.last().map_or(Mm2::ZERO, |sample| sample.1);
        let rest = self.samples.iter().rev().find(|sample| sample.1.distance(end) > STILL_MM);
        let seconds = rest.map_or(0.0, |sample| (sample.0 - t).max(0.0));
        Release { seconds, distance_mm: self.at(t).distance(end) }
    }
}

fn number(count: usize) -> f64 {
    u32::try_from(count).map_or(f64::INFINITY, f64::from)
}

fn percentile(ascending: &[f64], percent: usize) -> f64 {
    let index = ascending.len() * percent / 100;
    ascending.get(index.min(ascending.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}

/// The median and the 99th percentile of ascending values.
#[must_use]
pub fn median_and_p99(ascending: &[f64]) -> (f64, f64) {
    (percentile(ascending, 50), percentile(ascending, 99))
}

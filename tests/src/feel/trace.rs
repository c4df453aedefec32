//! True tool positions over time, and what is read from them.

use keepout_executor::session::Sample;

use super::scene::Scene;
use super::{DIP, Release, Slide};

/// Positions are compared so far apart, s.
const WINDOW_S: f64 = 0.02;
/// Between samples farther apart than this the tool stood still, s.
const GAP_S: f64 = 0.025;
/// A tool that moves no farther than this in a window stands still, mm: less than a step.
const STILL_MM: f64 = 0.002;

/// True tool positions.
pub(super) struct Trace {
    samples: Vec<(f64, (f64, f64))>,
}

fn way(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

impl Trace {
    pub(super) fn of(samples: &[Sample]) -> Self {
        let place = |sample: &Sample| (sample.at.elapsed().as_secs_f64(), sample.position_mm);
        Self { samples: samples.iter().map(place).collect() }
    }

    /// Where the tool was.
    fn at(&self, t: f64) -> (f64, f64) {
        let after = self.samples.partition_point(|sample| sample.0 <= t);
        let before = self.samples[after.saturating_sub(1)];
        match self.samples.get(after) {
            Some(next) if next.0 - before.0 < GAP_S => {
                let share = ((t - before.0) / (next.0 - before.0).max(1e-9)).clamp(0.0, 1.0);
                let between = |a: f64, b: f64| a + (b - a) * share;
                (between(before.1.0, next.1.0), between(before.1.1, next.1.1))
            }
            _ => before.1,
        }
    }

    fn end(&self) -> f64 {
        self.samples.last().map_or(0.0, |sample| sample.0)
    }

    /// When the tool was first at such a place.
    pub(super) fn first(&self, is: impl Fn((f64, f64)) -> bool) -> Option<f64> {
        self.samples.iter().find(|sample| is(sample.1)).map(|sample| sample.0)
    }

    /// When the tool was first this fast after `t`.
    pub(super) fn first_speed_after(&self, t: f64, speed_mm_s: f64) -> Option<f64> {
        let mut times = self.samples.iter().map(|sample| sample.0).filter(|&at| at > t);
        times.find(|&at| way(self.at(at - WINDOW_S), self.at(at)) >= speed_mm_s * WINDOW_S)
    }

    /// The slide, with heights from the first of the times on, and speeds from the second on, up to the
    /// third. Dips are below a share of what `whole` makes of the commanded and the mean speed.
    pub(super) fn slide(
        &self,
        scene: &Scene,
        (arrived, settled, end): (f64, f64, Option<f64>),
        commanded: f64,
        whole: impl Fn(f64, f64) -> f64,
    ) -> Slide {
        // The session ends with the tool being brought to rest.
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
        let ways: Vec<f64> = times(settled).map(|t| way(self.at(t - WINDOW_S), self.at(t))).collect();
        let length_mm: f64 = ways.iter().sum();
        let mean = length_mm / (number(ways.len()).max(1.0) * WINDOW_S);
        let least = DIP * whole(commanded, mean) * WINDOW_S;
        let entered = |below: &dyn Fn(f64) -> bool| {
            let mut was = false;
            ways.iter().filter(|&&way| !std::mem::replace(&mut was, below(way)) && was).count()
        };
        Slide {
            share: mean / commanded,
            speed_mm_s: mean,
            dips_per_m: number(entered(&|way| way < least)) / (length_mm / 1000.0).max(1e-3),
            height_mm: percentile(&heights, 90),
            stops: entered(&|way| way < STILL_MM),
            length_mm,
        }
    }

    /// Seconds from `t`, when the tool rested, to its first step: worked out from where it was seen
    /// first, with the acceleration.
    pub(super) fn first_step_after(&self, t: f64, acceleration_mm_s2: f64) -> Option<f64> {
        let rest = self.at(t);
        let moved = self.samples.iter().find(|sample| sample.0 > t && way(sample.1, rest) > STILL_MM)?;
        let since = |mm: f64| (2.0 * mm / acceleration_mm_s2).sqrt();
        Some(moved.0 - since(way(moved.1, rest)) + since(STILL_MM) - t)
    }

    /// How the tool came to rest after `t`.
    pub(super) fn rest_after(&self, t: f64) -> Release {
        let end = self.samples.last().map_or((0.0, 0.0), |sample| sample.1);
        let rest = self.samples.iter().rev().find(|sample| way(sample.1, end) > STILL_MM);
        let seconds = rest.map_or(0.0, |sample| (sample.0 - t).max(0.0));
        Release { seconds, distance_mm: way(self.at(t), end) }
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

//! The inverse compensation filter, IKF (section 4.3): a low-pass filter in front of ZPETC.
//!
//! The paper does not state the filter. Two poles of 10 ms reproduce its text.

use super::zero_phase::ZeroPhase;
use super::{Belief, Controller};
use crate::Axes;
use crate::reference::ReferenceWindow;

/// ZPETC behind a low-pass filter of two equal poles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseFilter {
    zero_phase: ZeroPhase,
    share: f64,
    poles: Option<[Axes; 2]>,
    /// Filtered references, from one sample ago to two samples ahead.
    filtered: [Axes; 4],
}

/// Time constant of the two poles, s.
pub const FILTER_S: f64 = 0.010;

impl InverseFilter {
    /// The filter for a P controller of `gain`, bits/pulse.
    #[must_use]
    pub fn new(belief: &Belief, gain: f64) -> Self {
        Self {
            zero_phase: ZeroPhase::new(belief, gain),
            share: -(-belief.period_s / FILTER_S).exp_m1(),
            poles: None,
            filtered: [Axes::zeros(); 4],
        }
    }
}

impl Controller for InverseFilter {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        // The filter runs two samples ahead of the current sample.
        let newest = window.position(2);
        let [first, second] = self.poles.get_or_insert([window.position(-1); 2]);
        if self.filtered == [Axes::zeros(); 4] {
            self.filtered = [*second; 4];
        }
        *first += (newest - *first) * self.share;
        *second += (*first - *second) * self.share;
        self.filtered.rotate_left(1);
        self.filtered[3] = *second;
        let filtered = self.filtered;
        self.zero_phase.command(|ahead| filtered[usize::try_from(ahead + 1).unwrap_or(0).min(3)], measured)
    }
}

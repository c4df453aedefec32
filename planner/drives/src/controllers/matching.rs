//! Adaptive matching (section 6.3; Pak 1991): both axes respond like the slower one.
//!
//! A mismatch of the loops then causes no contour error. The slower axis is the one with the larger lag
//! behind a ramp.

use super::estimator::{self, Estimator};
use super::{Belief, Controller};
use crate::Axes;
use crate::drive::Loop;
use crate::reference::ReferenceWindow;

/// A model of the slower loop, then a zero-phase inverse for each axis, then the P loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matching {
    estimators: [Estimator; 2],
    gain: f64,
    limit: Option<f64>,
    command: Axes,
    /// Responses of the slower loop, from three samples ago to two samples ahead, oldest first.
    answers: Option<[Axes; 6]>,
}

/// Index of the current sample among the responses.
const NOW: usize = 3;

impl Matching {
    /// Matching for a P controller of `gain`, bits/pulse. The estimates start with the model `belief`.
    #[must_use]
    pub fn new(belief: &Belief, gain: f64) -> Self {
        let estimators = estimator::of_loops(belief, gain);
        Self { estimators, gain, limit: belief.limit, command: Axes::zeros(), answers: None }
    }

    /// Advances the model of the slower loop by one sample, and returns its responses.
    fn answer(&mut self, slower: &Loop, window: &ReferenceWindow) -> [Axes; 6] {
        let answers = self.answers.get_or_insert([window.position(-1); 6]);
        answers.rotate_left(1);
        let Loop { poles: [_, a1, a2], zeros: [b0, b1] } = *slower;
        answers[NOW + 2] =
            window.position(1) * b0 + window.position(0) * b1 - answers[NOW + 1] * a1 - answers[NOW] * a2;
        *answers
    }
}

impl Controller for Matching {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        estimator::see(&mut self.estimators, measured, self.command, self.limit);
        let [x, y] = self.estimators.map(|estimator| estimator.known());
        let slower = if x.lag() >= y.lag() { x } else { y };
        let answers = self.answer(&slower, window);
        let mut reference = Axes::zeros();
        for (axis, each) in [x, y].iter().enumerate() {
            reference[axis] =
                each.zero_phase(|ahead| answers[NOW.saturating_add_signed(ahead).min(NOW + 2)][axis]);
            self.estimators[axis].give(reference[axis]);
        }
        self.command = (reference - measured) * self.gain;
        self.command
    }
}

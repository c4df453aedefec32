//! Adaptive matching (section 6.3; Pak 1991): both axes are made to answer as the slower one does, so that a mismatch of their
//! loops bends no path. The slower one is that which lags farther behind a ramp.

use super::estimator::{self, Estimator};
use super::{Belief, Controller};
use crate::Axes;
use crate::drive::Loop;
use crate::reference::Window;

/// P loops behind zero-phase inverses of themselves, behind the slower one's model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matching {
    estimators: [Estimator; 2],
    gain: f64,
    limit: Option<f64>,
    command: Axes,
    /// What the slower loop answers, three samples ago to two ahead, oldest first.
    answers: Option<[Axes; 6]>,
}

/// Where the sample that is due stands among the answers.
const NOW: usize = 3;

impl Matching {
    /// For a P controller of `gain`, bits/pulse, beginning with what is believed.
    #[must_use]
    pub fn new(belief: &Belief, gain: f64) -> Self {
        let estimators = estimator::of_loops(belief, gain);
        Self { estimators, gain, limit: belief.limit, command: Axes::zeros(), answers: None }
    }

    /// What the slower loop would answer; two samples ahead of what is due.
    fn answer(&mut self, slower: &Loop, window: &Window) -> [Axes; 6] {
        let answers = self.answers.get_or_insert([window.position(-1); 6]);
        answers.rotate_left(1);
        let Loop { poles: [_, a1, a2], zeros: [b0, b1] } = *slower;
        answers[NOW + 2] =
            window.position(1) * b0 + window.position(0) * b1 - answers[NOW + 1] * a1 - answers[NOW] * a2;
        *answers
    }
}

impl Controller for Matching {
    fn step(&mut self, window: &Window, measured: Axes) -> Axes {
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

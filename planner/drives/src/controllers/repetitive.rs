//! Repetitive control (section 6.4): what was off in one round is taken back in the next. On a P loop, and for what repeats only.

use super::zero_phase::loops;
use super::{Belief, Controller};
use crate::Axes;
use crate::drive::Loop;
use crate::reference::Window;

/// How much of the error of a round is taken back in the next.
pub const LEARNING: f64 = 0.7;

/// A P controller whose reference is corrected by what was learned in the rounds before.
#[derive(Clone, Debug)]
pub struct Repetitive {
    loops: [Loop; 2],
    gain: f64,
    /// Corrections of a round.
    corrections: Vec<Axes>,
    now: usize,
    /// The last errors, newest first.
    errors: [Axes; 4],
}

impl Repetitive {
    /// For a P controller of `gain`, bits/pulse, and rounds of so many samples (at least four). Allocates a round.
    #[must_use]
    pub fn new(belief: &Belief, gain: f64, round: usize) -> Self {
        let corrections = vec![Axes::zeros(); round.max(4)];
        Self { loops: loops(belief, gain), gain, corrections, now: 0, errors: [Axes::zeros(); 4] }
    }

    /// The place of a round `behind` samples ago.
    fn place(&self, behind: usize) -> usize {
        let round = self.corrections.len();
        (self.now + round - behind) % round
    }
}

impl Controller for Repetitive {
    fn step(&mut self, window: &Window, measured: Axes) -> Axes {
        let error = window.position(0) - measured;
        self.errors = [error, self.errors[0], self.errors[1], self.errors[2]];
        let errors = self.errors;
        // The zero-phase inverse looks two samples ahead: it is for the place of two samples ago.
        let learned = self.place(2);
        for (axis, each) in self.loops.iter().enumerate() {
            let at = |ahead: isize| errors[2_usize.saturating_add_signed(-ahead).min(3)][axis];
            self.corrections[learned][axis] += LEARNING * each.zero_phase(at);
        }
        let correction = self.corrections[self.now];
        self.now = (self.now + 1) % self.corrections.len();
        (error + correction) * self.gain
    }
}

//! Repetitive control (section 6.4): each round corrects the errors of the previous round.
//!
//! It works on a P loop, and only for paths and loads that repeat.

use super::zero_phase::loops;
use super::{Belief, Controller};
use crate::Axes;
use crate::drive::Loop;
use crate::reference::ReferenceWindow;

/// Share of the error of a round that the next round corrects.
pub const LEARNING: f64 = 0.7;

/// A P controller with a reference that is corrected by the errors of the previous rounds.
#[derive(Clone, Debug)]
pub struct Repetitive {
    loops: [Loop; 2],
    gain: f64,
    /// Corrections of one round, pulses.
    corrections: Vec<Axes>,
    now: usize,
    /// The last errors, newest first.
    errors: [Axes; 4],
}

impl Repetitive {
    /// Repetitive control for a P controller of `gain`, bits/pulse, and rounds of `round` samples (at least
    /// four). Allocates the corrections of one round.
    #[must_use]
    pub fn new(belief: &Belief, gain: f64, round: usize) -> Self {
        let corrections = vec![Axes::zeros(); round.max(4)];
        Self { loops: loops(belief, gain), gain, corrections, now: 0, errors: [Axes::zeros(); 4] }
    }

    /// Index in the round, `behind` samples ago.
    fn place(&self, behind: usize) -> usize {
        let round = self.corrections.len();
        (self.now + round - behind) % round
    }
}

impl Controller for Repetitive {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let error = window.position(0) - measured;
        self.errors = [error, self.errors[0], self.errors[1], self.errors[2]];
        let errors = self.errors;
        // The zero-phase inverse looks two samples ahead, so its result belongs to two samples ago.
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

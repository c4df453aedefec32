//! Adaptive ZPETC (section 6.3; Tsao & Tomizuka 1987): it estimates the parameters of the loop during the
//! run.

use super::estimator::{self, Estimator};
use super::{Belief, Controller};
use crate::Axes;
use crate::reference::ReferenceWindow;

/// ZPETC with estimated loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    estimators: [Estimator; 2],
    gain: f64,
    limit: Option<f64>,
    command: Axes,
}

impl Adaptive {
    /// Adaptive ZPETC for a P controller of `gain`, bits/pulse. The estimates start with the model `belief`.
    #[must_use]
    pub fn new(belief: &Belief, gain: f64) -> Self {
        let estimators = estimator::of_loops(belief, gain);
        Self { estimators, gain, limit: belief.limit, command: Axes::zeros() }
    }
}

impl Controller for Adaptive {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        estimator::see(&mut self.estimators, measured, self.command, self.limit);
        let mut reference = Axes::zeros();
        for (axis, estimator) in self.estimators.iter_mut().enumerate() {
            reference[axis] = estimator.known().zero_phase(|ahead| window.position(ahead)[axis]);
            estimator.give(reference[axis]);
        }
        self.command = (reference - measured) * self.gain;
        self.command
    }
}

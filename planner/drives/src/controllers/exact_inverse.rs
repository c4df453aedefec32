//! Feedforward of the loop's exact inverse (Fig. 5a).
//!
//! It is perfect in theory. In practice it oscillates at half the sampling frequency, because the zero of the
//! loop is close to −1.

use super::zero_phase::loops;
use super::{Belief, Controller};
use crate::Axes;
use crate::drive::Loop;
use crate::reference::ReferenceWindow;

/// The exact inverse `G0⁻¹(z)` in front of a P loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactInverse {
    loops: [Loop; 2],
    gain: f64,
    before: Option<Axes>,
}

impl ExactInverse {
    /// The inverse for a P controller of `gain`, bits/pulse.
    #[must_use]
    pub fn new(belief: &Belief, gain: f64) -> Self {
        Self { loops: loops(belief, gain), gain, before: None }
    }
}

impl Controller for ExactInverse {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let before = self.before.unwrap_or(window.position(-1));
        let on = |axis: usize| {
            let Loop { poles: [a0, a1, a2], zeros: [b0, b1] } = self.loops[axis];
            let wanted = |ahead: isize| window.position(ahead)[axis];
            (a0 * wanted(1) + a1 * wanted(0) + a2 * wanted(-1) - b1 * before[axis]) / b0
        };
        let reference = Axes::new(on(0), on(1));
        self.before = Some(reference);
        (reference - measured) * self.gain
    }
}

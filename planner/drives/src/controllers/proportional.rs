//! The P controller (section 3.1). Eq. (7) recommends its gain: see `recommended_gain` in the studies.

use super::Controller;
use crate::Axes;
use crate::reference::ReferenceWindow;

/// `U = Kp·E` on each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proportional {
    /// Kp, bits/pulse.
    pub gain: f64,
}

impl Controller for Proportional {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        (window.position(0) - measured) * self.gain
    }
}

//! The P controller (section 3.1).

use super::Controller;
use crate::servo::Axes;
use crate::servo::reference::Window;

/// `U = Kp·E` on each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proportional {
    /// Kp, bits/pulse.
    pub gain: f64,
}

impl Proportional {
    /// The open-loop gain of eq. (7), 1/s, for a closed loop damped by 0.707: `1/(T + 2·tau)`.
    #[must_use]
    pub fn recommended_open_loop_gain(period_s: f64, time_constant_s: f64) -> f64 {
        1.0 / (period_s + 2.0 * time_constant_s)
    }
}

impl Controller for Proportional {
    fn step(&mut self, window: &Window, measured: Axes) -> Axes {
        (window.position(0) - measured) * self.gain
    }
}

//! State feedback of position and speed with integral action (section 3.3), by pole placement.

use super::speed::Speed;
use super::{Belief, Controller};
use crate::Axes;
use crate::drive::Drive;
use crate::reference::ReferenceWindow;

/// Gains of the state feedback.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateGains {
    /// Gain of the position error, bits/pulse.
    pub position: f64,
    /// Gain of the speed, bits·s/pulse.
    pub speed: f64,
    /// Gain of the integral of the position error, bits/(pulse·s).
    pub integral: f64,
}

impl StateGains {
    /// The gains that place the poles of `tau·s³ + (1 + K·ks)s² + K·kp·s + K·ki`: one at `−w`, and a pair of
    /// frequency `w = quickness/tau` with a damping of 0.707.
    #[must_use]
    pub fn placing(drive: Drive, quickness: f64) -> Self {
        let tau = drive.time_constant_s;
        let w = quickness / tau;
        let spread = 1.0 + std::f64::consts::SQRT_2;
        Self {
            position: tau * w * w * spread / drive.gain,
            speed: (tau * w * spread - 1.0) / drive.gain,
            integral: tau * w * w * w / drive.gain,
        }
    }
}

/// State feedback on each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateFeedback {
    gains: [StateGains; 2],
    period_s: f64,
    speed: Speed,
    sum: Axes,
}

impl StateFeedback {
    /// State feedback with gains by pole placement.
    #[must_use]
    pub fn new(belief: &Belief, quickness: f64) -> Self {
        Self::with(belief.drives.map(|drive| StateGains::placing(drive, quickness)), belief.period_s)
    }

    /// State feedback with these gains for X and Y.
    #[must_use]
    pub fn with(gains: [StateGains; 2], period_s: f64) -> Self {
        Self { gains, period_s, speed: Speed::new(period_s), sum: Axes::zeros() }
    }
}

impl Controller for StateFeedback {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let error = window.position(0) - measured;
        let speed = self.speed.see(measured);
        self.sum += error * self.period_s;
        let on = |axis: usize| {
            let StateGains { position, speed: by_speed, integral } = self.gains[axis];
            position * error[axis] - by_speed * speed[axis] + integral * self.sum[axis]
        };
        Axes::new(on(0), on(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_are_where_they_were_placed() {
        let drive = Drive { gain: 10.0, time_constant_s: 0.045 };
        let gains = StateGains::placing(drive, 1.2);
        let w = 1.2 / 0.045;
        // s = −w must be a root.
        let at = |s: f64| {
            0.045 * s.powi(3)
                + (1.0 + 10.0 * gains.speed) * s * s
                + 10.0 * gains.position * s
                + 10.0 * gains.integral
        };
        assert!(at(-w).abs() < 1e-9 * 0.045 * w.powi(3), "{}", at(-w));
    }
}

//! The PID law of eq. (8), and of the cross-coupling controller.

use serde::{Deserialize, Serialize};

/// Gains of a PID law: bits/pulse, bits/(pulse·s), bits·s/pulse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PidGains {
    /// Of the error.
    pub proportional: f64,
    /// Of its integral.
    pub integral: f64,
    /// Of its change.
    pub derivative: f64,
}

/// `Kp + Ki·T·z/(z − 1) + Kd·(z − 1)/(T·z)` in motion: backward differences, from zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    gains: PidGains,
    period_s: f64,
    sum: f64,
    before: f64,
}

impl Law {
    /// At rest.
    #[must_use]
    pub fn new(gains: PidGains, period_s: f64) -> Self {
        Self { gains, period_s, sum: 0.0, before: 0.0 }
    }

    /// The law's output for the next error.
    pub fn step(&mut self, error: f64) -> f64 {
        self.sum += self.period_s * error;
        let change = (error - self.before) / self.period_s;
        self.before = error;
        self.gains.proportional * error + self.gains.integral * self.sum + self.gains.derivative * change
    }
}

//! The PID law of eq. (8). The cross-coupling controller uses it too.

use serde::{Deserialize, Serialize};

/// Gains of a PID law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PidGains {
    /// Gain of the error, bits/pulse.
    pub proportional: f64,
    /// Gain of its integral, bits/(pulse·s).
    pub integral: f64,
    /// Gain of its derivative, bits·s/pulse.
    pub derivative: f64,
}

/// The PID law `Kp + Ki·T·z/(z − 1) + Kd·(z − 1)/(T·z)` with its state: backward differences, from zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    gains: PidGains,
    period_s: f64,
    sum: f64,
    before: f64,
}

impl Law {
    /// A law at rest.
    #[must_use]
    pub fn new(gains: PidGains, period_s: f64) -> Self {
        Self { gains, period_s, sum: 0.0, before: 0.0 }
    }

    /// The output for the next error.
    pub fn step(&mut self, error: f64) -> f64 {
        self.sum += self.period_s * error;
        self.without_integral(error) + self.gains.integral * self.sum
    }

    /// The output for the next error with the integral action off: it adds nothing, and its sum stays.
    pub fn without_integral(&mut self, error: f64) -> f64 {
        let change = (error - self.before) / self.period_s;
        self.before = error;
        self.gains.proportional * error + self.gains.derivative * change
    }
}

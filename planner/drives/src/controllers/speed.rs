//! Speed by differences of the measured position.

use crate::Axes;

/// Backward differences; the first sample is taken for rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    period_s: f64,
    before: Option<Axes>,
}

impl Speed {
    /// At rest.
    #[must_use]
    pub fn new(period_s: f64) -> Self {
        Self { period_s, before: None }
    }

    /// The speed, pulses/s, now that `measured` was seen.
    pub fn see(&mut self, measured: Axes) -> Axes {
        let before = self.before.replace(measured).unwrap_or(measured);
        (measured - before) / self.period_s
    }
}

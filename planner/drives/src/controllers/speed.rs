//! Speed as the difference of measured positions.

use crate::Axes;

/// Backward differences of the position. The first sample counts as rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    period_s: f64,
    before: Option<Axes>,
}

impl Speed {
    /// A speed of zero.
    #[must_use]
    pub fn new(period_s: f64) -> Self {
        Self { period_s, before: None }
    }

    /// The speed after the measurement `measured`, pulses/s.
    pub fn see(&mut self, measured: Axes) -> Axes {
        let before = self.before.replace(measured).unwrap_or(measured);
        (measured - before) / self.period_s
    }
}

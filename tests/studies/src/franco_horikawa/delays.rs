//! Delays of the paper's system.
//!
//! The paper names "the time spent since the moment in which a command is sent by the control algorithm to
//! the NC controller, asking for the position, until the moment in which the stop command is sent" (section
//! 7). The motion that continues after the stop adds to it.

use serde::{Deserialize, Serialize};

use super::invasion::Classified;

/// The delay model. [`super::calibration`] finds its five free values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Delays {
    /// Bits per second. Each byte takes ten bits.
    pub baud: f64,
    /// Bytes of a position query.
    pub query_bytes: f64,
    /// Bytes of its answer.
    pub answer_bytes: f64,
    /// Bytes of a motion.
    pub motion_bytes: f64,
    /// Bytes of a stop.
    pub stop_bytes: f64,
    /// Processing time of the controller for a line, s.
    pub controller_s: f64,
    /// Whether a stop ends the current motion. If not, the motion runs to its end, and the stop removes only
    /// queued motions.
    pub stop_cuts: bool,
    /// Free: length of one joystick motion, mm.
    pub unit_mm: f64,
    /// Free: intervals by which the third check selects segments.
    pub classified: Looked,
    /// Free: number of motions queued behind the current one.
    pub ahead: u32,
    /// Free: mean time of one round of the computation, s.
    pub compute_s: f64,
    /// Free: time constant of the table, s.
    pub inertia_s: f64,
}

/// Intervals by which the third method selects segments. The text of the method names x. Its introduction
/// names x and y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Looked {
    /// By x.
    ByX,
    /// By x, or by y.
    ByXOrY,
}

impl From<Looked> for Classified {
    fn from(looked: Looked) -> Self {
        match looked {
            Looked::ByX => Self::ByX,
            Looked::ByXOrY => Self::ByXOrY,
        }
    }
}

impl Delays {
    /// Transmission time of `bytes`, s.
    #[must_use]
    pub fn line_s(&self, bytes: f64) -> f64 {
        bytes * 10.0 / self.baud
    }

    /// Random time of one round of the computation, s: half of the mean, plus an exponentially distributed
    /// part.
    pub fn computation_s(&self, random: &mut fastrand::Rng) -> f64 {
        self.compute_s * 0.5 * (1.0 - (1.0 - random.f64()).ln())
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenario::Scenarios;

    #[test]
    fn lines_and_computations_take_the_modelled_times() {
        let delays = Scenarios::built_in().unwrap().delays;
        assert!((delays.line_s(96.0) - 0.1).abs() < 1e-12);
        let mut random = fastrand::Rng::with_seed(1);
        let times: Vec<f64> = (0..20_000).map(|_| delays.computation_s(&mut random)).collect();
        let mean = times.iter().sum::<f64>() / 20_000.0;
        assert!((mean / delays.compute_s - 1.0).abs() < 0.02, "{mean}");
        assert!(times.iter().all(|time| *time >= delays.compute_s / 2.0 && time.is_finite()));
    }
}

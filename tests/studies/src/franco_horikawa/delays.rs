//! What delays the paper's system: "the time spent since the moment in which a command is sent by the control algorithm to the NC
//! controller, asking for the position, until the moment in which the stop command is sent" (section 7), and what runs on.

use serde::{Deserialize, Serialize};

use super::invasion::Classified;

/// The delay model. Five of its figures are free, and found by [`super::calibration`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Delays {
    /// Bits per second; ten for each byte.
    pub baud: f64,
    /// Bytes of a position query.
    pub query_bytes: f64,
    /// Bytes of its answer.
    pub answer_bytes: f64,
    /// Bytes of a motion.
    pub motion_bytes: f64,
    /// Bytes of a stop.
    pub stop_bytes: f64,
    /// The controller's own time for a line, s.
    pub controller_s: f64,
    /// Whether a stop cuts the motion that runs; otherwise that is run to its end, and what was sent ahead is not.
    pub stop_cuts: bool,
    /// Free: length of one direction motion, mm.
    pub unit_mm: f64,
    /// Free: which intervals a segment is looked up by.
    pub classified: Looked,
    /// Free: motions sent ahead of the one that runs.
    pub ahead: u32,
    /// Free: mean time of one round of the computation, s.
    pub compute_s: f64,
    /// Free: time constant with which the table follows, s.
    pub inertia_s: f64,
}

/// Which intervals the third method looks segments up by: its text names x, what leads to it both.
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
    /// Time on the line, s.
    #[must_use]
    pub fn line_s(&self, bytes: f64) -> f64 {
        bytes * 10.0 / self.baud
    }

    /// The time of one round of the computation, s: half of the mean at least, the rest exponentially distributed.
    pub fn computation_s(&self, random: &mut fastrand::Rng) -> f64 {
        self.compute_s * 0.5 * (1.0 - (1.0 - random.f64()).ln())
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenario::Scenarios;

    #[test]
    fn lines_and_computations_take_what_they_say() {
        let delays = Scenarios::built_in().unwrap().delays;
        assert!((delays.line_s(96.0) - 0.1).abs() < 1e-12);
        let mut random = fastrand::Rng::with_seed(1);
        let times: Vec<f64> = (0..20_000).map(|_| delays.computation_s(&mut random)).collect();
        let mean = times.iter().sum::<f64>() / 20_000.0;
        assert!((mean / delays.compute_s - 1.0).abs() < 0.02, "{mean}");
        assert!(times.iter().all(|time| *time >= delays.compute_s / 2.0 && time.is_finite()));
    }
}

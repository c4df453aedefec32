//! The weights of the contouring MPC.

use serde::{Deserialize, Serialize};

use crate::controllers::observer::RandomSteps;
use crate::drive::Drive;

/// Weights of the costs, relative to a weight of 1 for the distance from the path. They have no unit and do not depend
/// on the sampling period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weights {
    /// Frequency of the closed loop that the cost of the commands alone would leave, as an angle per sample, rad.
    pub bandwidth: f64,
    /// Frequency of the closed loop that the cost of their changes alone would leave, as an angle per sample, rad.
    pub changes: f64,
    /// Weight of a small lag behind the reference along the path.
    pub lag: f64,
    /// Frequency of the observer that random speeds alone would leave, as an angle per sample, rad.
    pub observer: f64,
    /// Frequency of the observer that random loads alone would leave, as an angle per sample, rad.
    pub load: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self { bandwidth: 10.0, changes: 6.0, lag: 0.09, observer: 0.03, load: 0.265 }
    }
}

/// Lag above which its weight falls in inverse proportion to the lag: a share of the feed of one sample. Only a limit
/// or a jump of the feed causes a larger lag, and it must not pull the tool off the path.
const BEND: f64 = 0.1;
/// The same for a slow feed, pulses.
const LEAST_BEND: f64 = 0.5;
/// Smallest weight of a large lag, relative to that of a small one.
pub(super) const LEAST_LAG: f64 = 0.01;

/// Costs of a command that the path does not ask for, and of a change of it: weights of the distance that it causes in
/// its first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Efforts {
    pub(super) command: f64,
    pub(super) change: f64,
}

impl Weights {
    /// The weight of a lag of the size `lag`, pulses, where the feed covers `step` pulses in a sample, relative to
    /// that of a small lag.
    pub(super) fn lag_share(lag: f64, step: f64) -> f64 {
        let bend = (BEND * step).max(LEAST_BEND);
        (bend / lag.abs()).clamp(LEAST_LAG, 1.0)
    }

    /// The costs of commands and of their changes.
    ///
    /// For changes that are fast beside tau, a drive is `K/(tau·s²)`. The optimum of `∫ e² + r·u²` has its two poles
    /// on a circle of the radius `w = √(K/(tau·√r))`, that of `∫ e² + r·(du/dt)²` its three on one of the radius
    /// `w = (K/(tau·√r))^(1/3)`, Butterworth patterns (Kwakernaak & Sivan, "Linear optimal control systems",
    /// section 3.8). The first sample of a command covers `K·T²/(2·tau)`.
    pub(super) fn efforts(&self) -> Efforts {
        Efforts { command: 4.0 / self.bandwidth.powi(4), change: 4.0 / self.changes.powi(6) }
    }

    /// Random changes of speed and load in a sample, for a measurement with a noise of one pulse. The poles of the
    /// observer are the dual of those of the controller ([`Weights::efforts`]): `w² = T·speed/noise` and
    /// `w³ = K/tau·load/noise`.
    pub(super) fn random_steps(&self, drive: Drive, period_s: f64) -> RandomSteps {
        RandomSteps {
            speed: self.observer.powi(2) / period_s,
            load: self.load.powi(3) / (2.0 * drive.held(period_s).b0),
        }
    }
}

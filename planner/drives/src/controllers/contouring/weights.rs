//! The weights of the contouring MPC.

use serde::{Deserialize, Serialize};

use crate::drive::Drive;

/// Weights of the costs, relative to a weight of 1 for the distance from the path. They have no unit and do not depend
/// on the sampling period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weights {
    /// Frequency of the closed loop, as an angle per sample, rad.
    pub bandwidth: f64,
    /// Weight of a small lag behind the reference along the path.
    pub lag: f64,
    /// Frequency of the observer, as an angle per sample, rad.
    pub observer: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self { bandwidth: 0.15, lag: 0.3, observer: 1.5 }
    }
}

/// Lag above which its weight falls in inverse proportion to the lag: a share of the feed of one sample. Only a limit
/// or a jump of the feed causes a larger lag, and it must not pull the tool off the path.
const BEND: f64 = 0.1;
/// The same for a slow feed, pulses.
const LEAST_BEND: f64 = 0.5;
/// Smallest weight of a large lag, relative to that of a small one.
const LEAST_LAG: f64 = 0.01;

impl Weights {
    /// The weight of a lag of the size `lag`, pulses, where the feed covers `step` pulses in a sample.
    pub(super) fn lag_share(&self, lag: f64, step: f64) -> f64 {
        let bend = (BEND * step).max(LEAST_BEND);
        self.lag * (bend / lag.abs()).clamp(LEAST_LAG, 1.0)
    }

    /// Weight of the distance that a change of command causes in its first sample.
    ///
    /// For changes that are fast beside tau, a drive is `K/(tau·s²)`, and the optimum of `∫ e² + r·(du/dt)²` has its
    /// three poles on a circle of the radius `w = (K/(tau·√r))^(1/3)`, a Butterworth pattern (Kwakernaak & Sivan,
    /// "Linear optimal control systems", section 3.8). The first sample of a command covers `K·T²/(2·tau)`.
    pub(super) fn effort(&self) -> f64 {
        4.0 / self.bandwidth.powi(6)
    }

    /// Random change of the load in a sample, bits, for a measurement with a noise of one pulse. The poles of the
    /// observer are the dual of those of the controller ([`Weights::effort`]): `w³ = K/tau·load/noise`.
    pub(super) fn load(&self, drive: Drive, period_s: f64) -> f64 {
        self.observer.powi(3) / (2.0 * drive.held(period_s).b0)
    }
}

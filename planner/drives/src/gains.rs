//! Gains and weights of the controllers.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use super::controllers::contouring::Weights;
use super::controllers::law::PidGains;
use super::controllers::optimal::Index;

/// Gains of the paper's controllers, and the parameters of the others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gains {
    /// Kp of the P controller, bits/pulse.
    pub proportional: f64,
    /// Gains of the PID controller.
    pub pid: PidGains,
    /// Gains of W(z), the PID law of the cross-coupling controller.
    pub cross_coupling: PidGains,
    /// Parameters of the controllers that compute their gains from the drive model.
    #[serde(default, skip_serializing_if = "Design::is_default")]
    pub design: Design,
}

/// Parameters of the controllers that compute their gains from the drive model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Design {
    /// Frequency of the poles of the state feedback, times tau.
    pub quickness: f64,
    /// The performance index of the optimal controllers.
    pub index: Index,
    /// Weight of the squared contour error of the optimal cross-coupling, relative to the squared tracking error.
    pub contour: f64,
    /// Weight of an increment of GPC, in terms of the distance that it causes in one sample.
    pub predictive_effort: f64,
    /// Weights of the contouring MPC.
    pub contouring: Weights,
}

impl Default for Design {
    /// For the paper's machine at T = 4 ms: about as fast as its PID controller.
    fn default() -> Self {
        Self {
            quickness: 1.2,
            index: Index::default(),
            contour: 25.0,
            predictive_effort: 1600.0,
            contouring: Weights::default(),
        }
    }
}

/// A value of a profile with its field.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileFigure {
    /// The field.
    pub field: &'static str,
    /// The value.
    pub value: f64,
    /// The accepted range.
    pub range: RangeInclusive<f64>,
}

impl Design {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl Gains {
    /// All values, with their fields and the accepted ranges.
    #[must_use]
    pub fn figures(&self) -> Vec<ProfileFigure> {
        let above = 1e-9..=1e9;
        let from_0 = 0.0..=1e9;
        let Design { quickness, index, contour, predictive_effort, contouring } = self.design;
        let figures = [
            ("gains.proportional", self.proportional, above.clone()),
            ("gains.pid.proportional", self.pid.proportional, above.clone()),
            ("gains.pid.integral", self.pid.integral, from_0.clone()),
            ("gains.pid.derivative", self.pid.derivative, from_0.clone()),
            ("gains.cross_coupling.proportional", self.cross_coupling.proportional, above.clone()),
            ("gains.cross_coupling.integral", self.cross_coupling.integral, from_0.clone()),
            ("gains.cross_coupling.derivative", self.cross_coupling.derivative, from_0.clone()),
            ("gains.design.quickness", quickness, 1e-3..=1e3),
            ("gains.design.index.integral", index.integral, from_0.clone()),
            ("gains.design.index.effort", index.effort, above.clone()),
            ("gains.design.contour", contour, from_0.clone()),
            ("gains.design.predictive_effort", predictive_effort, above.clone()),
            ("gains.design.contouring.bandwidth", contouring.bandwidth, 1e-3..=30.0),
            ("gains.design.contouring.changes", contouring.changes, 1e-3..=30.0),
            ("gains.design.contouring.lag", contouring.lag, 1e-6..=1e3),
            ("gains.design.contouring.observer", contouring.observer, 1e-3..=30.0),
            ("gains.design.contouring.load", contouring.load, 1e-3..=30.0),
        ];
        figures.map(|(field, value, range)| ProfileFigure { field, value, range }).to_vec()
    }
}

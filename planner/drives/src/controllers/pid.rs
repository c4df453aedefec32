//! PID in the structures of Fig. 4 (section 3.2).
//!
//! We do not have the figure. By the text, (a) is "the most common structure", and (b) becomes state feedback
//! of position and velocity "without the integral action". For (c) and (d) we use the remaining practical
//! structures that the paper cites: I-PD, and a P position loop around a PI velocity loop.

use serde::{Deserialize, Serialize};

use super::Controller;
use super::law::{Law, PidGains};
use super::speed::Speed;
use crate::Axes;
use crate::reference::ReferenceWindow;

/// The input of each of the three actions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Structure {
    /// (a) P, I and D act on the error.
    #[default]
    OnError,
    /// (b) P and I act on the error, D acts on the measured position.
    DerivativeOnPosition,
    /// (c) I acts on the error, P and D act on the measured position.
    IntegralOnError,
    /// (d) P on the position error gives the desired speed. PI on the speed error gives the command.
    Cascade,
}

/// A PID controller for each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pid {
    structure: Structure,
    gains: PidGains,
    period_s: f64,
    laws: [Law; 2],
    speed: Speed,
    sum: Axes,
    /// The first measured position.
    began: Option<Axes>,
}

impl Pid {
    /// A controller at rest.
    #[must_use]
    pub fn new(structure: Structure, gains: PidGains, period_s: f64) -> Self {
        let laws = [Law::new(gains, period_s); 2];
        Self {
            structure,
            gains,
            period_s,
            laws,
            speed: Speed::new(period_s),
            sum: Axes::zeros(),
            began: None,
        }
    }

    /// Structures (b) and (c). P acts on `proportion`.
    fn on_position(&mut self, proportion: Axes, error: Axes, measured: Axes) -> Axes {
        let speed = self.speed.see(measured);
        self.sum += error * self.period_s;
        let PidGains { proportional, integral, derivative } = self.gains;
        proportion * proportional + self.sum * integral - speed * derivative
    }

    /// Structure (d). `Kd` is the gain of the speed loop, so without the integral it equals (b) without I.
    /// The integral removes the speed error at the same rate as in (b).
    fn cascade(&mut self, error: Axes, measured: Axes) -> Axes {
        let speed = self.speed.see(measured);
        let PidGains { proportional, integral, derivative } = self.gains;
        let wanted = error * (proportional / derivative);
        let off = wanted - speed;
        self.sum += off * self.period_s;
        off * derivative + self.sum * (integral * derivative / proportional)
    }
}

impl Controller for Pid {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let error = window.position(0) - measured;
        match self.structure {
            Structure::OnError => Axes::new(self.laws[0].step(error.x), self.laws[1].step(error.y)),
            Structure::DerivativeOnPosition => self.on_position(error, error, measured),
            Structure::IntegralOnError => {
                let began = *self.began.get_or_insert(measured);
                self.on_position(began - measured, error, measured)
            }
            Structure::Cascade => self.cascade(error, measured),
        }
    }
}

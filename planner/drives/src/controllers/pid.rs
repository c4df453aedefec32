//! PID in the structures of Fig. 4 (section 3.2).
//!
//! We do not have the figure. By the text, (a) is "the most common structure", and (b) becomes state feedback
//! of position and velocity "without the integral action". For (c) and (d) we use the remaining practical
//! structures that the paper cites: I-PD, and a P position loop around a PI velocity loop.

use serde::{Deserialize, Serialize};

use super::law::{Law, PidGains};
use super::passed::PassedPieces;
use super::speed::Speed;
use super::{Belief, Controller};
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

#[expect(clippy::cast_precision_loss, reason = "a few samples")]
const MOST_AHEAD_F: f64 = MOST_AHEAD as f64;
/// Largest number of samples before a corner in which the integral action is off.
pub const MOST_AHEAD: usize = 64;

/// The integral action around corners (section 8: "the I component of the PID controller can be turned off before the
/// corner"). It is off from one time constant before the reference comes to a corner until the tool has passed it.
#[derive(Clone, Debug)]
struct Corners {
    passed: PassedPieces,
    /// Number of samples before the corner.
    ahead: isize,
}

impl Corners {
    /// Whether a corner lies between the tool and the reference some samples from now.
    fn near(&mut self, window: &ReferenceWindow, measured: Axes) -> bool {
        let turns = |ahead: isize| window.ahead(ahead).foot.turns_to(&window.ahead(ahead + 1).foot);
        self.passed.foot(window.ahead(0), measured).before_corner || (0..self.ahead).any(turns)
    }
}

/// A PID controller for each axis.
#[derive(Clone, Debug)]
pub struct Pid {
    structure: Structure,
    gains: PidGains,
    period_s: f64,
    laws: [Law; 2],
    speed: Speed,
    sum: Axes,
    /// The first measured position.
    began: Option<Axes>,
    corners: Option<Corners>,
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
            corners: None,
        }
    }

    /// The same controller, which turns its integral action off around corners. For structure (a).
    #[must_use]
    pub fn without_integral_at_corners(self, belief: &Belief) -> Self {
        let slowest = belief.drives.iter().map(|drive| drive.time_constant_s).fold(0.0, f64::max);
        #[expect(clippy::cast_possible_truncation, reason = "clamped")]
        let ahead = (slowest / belief.period_s).ceil().clamp(1.0, MOST_AHEAD_F) as isize;
        Self { corners: Some(Corners { passed: PassedPieces::default(), ahead }), ..self }
    }

    /// Structure (a).
    fn on_error(&mut self, window: &ReferenceWindow, error: Axes, measured: Axes) -> Axes {
        let off = self.corners.as_mut().is_some_and(|corners| corners.near(window, measured));
        let [x, y] = &mut self.laws;
        if off {
            Axes::new(x.without_integral(error.x), y.without_integral(error.y))
        } else {
            Axes::new(x.step(error.x), y.step(error.y))
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
            Structure::OnError => self.on_error(window, error, measured),
            Structure::DerivativeOnPosition => self.on_position(error, error, measured),
            Structure::IntegralOnError => {
                let began = *self.began.get_or_insert(measured);
                self.on_position(began - measured, error, measured)
            }
            Structure::Cascade => self.cascade(error, measured),
        }
    }
}

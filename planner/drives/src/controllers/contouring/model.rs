//! What the contouring MPC predicts: responses to commands, and the cost after the horizon.

use nalgebra::{RowVector3, SMatrix, Vector3};

use super::HORIZON;
use crate::Axes;
use crate::controllers::optimal::regulator;
use crate::drive::{Drive, DriveMotion, HeldLate};

/// The cost of everything after the horizon: of the error, its speed and the command, as a steady speed, in one
/// direction. It is that of the optimal controller without limits, which follows the path exactly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tail {
    pub(super) value: SMatrix<f64, 3, 3>,
}

impl Tail {
    /// The cost for a drive of gain 1 and this weight of the error. `None` if there is no optimum.
    pub(super) fn new(time_constant_s: f64, period_s: f64, weight: f64, effort: f64) -> Option<Self> {
        let held = Drive { gain: 1.0, time_constant_s }.held(period_s);
        let step = SMatrix::<f64, 3, 3>::from_rows(&[
            RowVector3::new(1.0, held.run, held.b0),
            RowVector3::new(0.0, held.decay, held.push),
            RowVector3::new(0.0, 0.0, 1.0),
        ]);
        let input = Vector3::new(held.b0, held.push, 1.0);
        let state_cost = SMatrix::<f64, 3, 3>::from_diagonal(&Vector3::new(weight, 0.0, 0.0));
        let input_cost = SMatrix::<f64, 1, 1>::new(effort * held.b0 * held.b0);
        let found = regulator(&step, &input, &state_cost, &input_cost, |m| m.try_inverse())?;
        // The error at the end of the horizon has its own cost.
        Some(Self { value: found.value - state_cost })
    }
}

/// Positions and speeds after 1, 2, … samples, for a command of one bit in the first sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    pub(super) positions: [f64; HORIZON],
    pub(super) speeds: [f64; HORIZON],
}

impl Response {
    pub(super) fn of(held: &HeldLate) -> Self {
        let mut response = Self { positions: [0.0; HORIZON], speeds: [0.0; HORIZON] };
        let mut motion = DriveMotion::default();
        let mut commands = [0.0, 1.0];
        for i in 0..HORIZON {
            motion = held.after(motion, commands);
            (response.positions[i], response.speeds[i]) = (motion.position, motion.velocity);
            commands = [commands[1], 0.0];
        }
        response
    }
}

/// Positions after 1, 2, … samples, and the speed after the last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prediction {
    pub(super) positions: [Axes; HORIZON],
    pub(super) speed: Axes,
}

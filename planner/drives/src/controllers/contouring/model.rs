//! What the contouring MPC predicts: responses to commands, and the cost after the horizon.

use nalgebra::{RowVector3, SMatrix, Vector3};

use super::HORIZON;
use super::weights::{Efforts, LEAST_LAG, Weights};
use crate::Axes;
use crate::controllers::optimal::regulator;
use crate::drive::{Drive, DriveMotion, HeldLate};

/// The cost of everything after the horizon: of the error, its speed and the command, as a steady speed, in one
/// direction. It is that of the optimal controller without limits, which follows the path exactly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tail {
    pub(super) value: SMatrix<f64, 3, 3>,
}

/// Number of costs after the horizon along the path.
const LAGS: u8 = 9;

/// The costs after the horizon in the two directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tails {
    pub(super) across: Tail,
    /// For weights of the lag from that of a small one to that of the largest. A cost does not grow in proportion to
    /// the weight: where the lag costs little, speed costs much beside it, and the loop must stay damped.
    along: [Tail; LAGS as usize],
}

impl Tails {
    /// The costs for drives with this time constant. `None` if there is no optimum.
    pub(super) fn new(time_constant_s: f64, period_s: f64, weights: &Weights) -> Option<Self> {
        let tail = |weight| Tail::new(time_constant_s, period_s, weight, weights.efforts());
        let across = tail(1.0)?;
        let mut along = [across; LAGS as usize];
        for (number, along) in (0..LAGS).zip(&mut along) {
            *along = tail(weights.lag * LEAST_LAG.powf(f64::from(number) / f64::from(LAGS - 1)))?;
        }
        Some(Self { across, along })
    }

    /// The cost along the path for a lag with this share of the weight of a small lag.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to the number of costs"
    )]
    pub(super) fn along(&self, share: f64) -> &Tail {
        let number = (share.ln() / LEAST_LAG.ln() * f64::from(LAGS - 1)).round();
        &self.along[(number.max(0.0) as usize).min(self.along.len() - 1)]
    }
}

impl Tail {
    /// The cost for a drive of gain 1 and this weight of the error. `None` if there is no optimum.
    pub(super) fn new(time_constant_s: f64, period_s: f64, weight: f64, efforts: Efforts) -> Option<Self> {
        let held = Drive { gain: 1.0, time_constant_s }.held(period_s);
        let step = SMatrix::<f64, 3, 3>::from_rows(&[
            RowVector3::new(1.0, held.run, held.b0),
            RowVector3::new(0.0, held.decay, held.push),
            RowVector3::new(0.0, 0.0, 1.0),
        ]);
        let input = Vector3::new(held.b0, held.push, 1.0);
        let by_command = efforts.command * held.b0.powi(2);
        let state_cost = SMatrix::<f64, 3, 3>::from_diagonal(&Vector3::new(weight, 0.0, by_command));
        let input_cost = SMatrix::<f64, 1, 1>::new(efforts.change * held.b0.powi(2));
        let found = regulator(&step, &input, &state_cost, &input_cost, |m| m.try_inverse())?;
        // The error at the end of the horizon and the last command have their own costs.
        Some(Self { value: found.value - state_cost })
    }
}

/// Positions and speeds after 1, 2, … samples, for a command of one bit in the first sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    pub(super) positions: [f64; HORIZON],
    pub(super) speeds: [f64; HORIZON],
    /// The positions from the last to the first.
    reversed: [f64; HORIZON],
}

impl Response {
    /// The changes of the predicted position `i` by one bit of the commands 0 to `i`.
    pub(super) fn until(&self, i: usize) -> &[f64] {
        &self.reversed[HORIZON - 1 - i..]
    }

    pub(super) fn of(held: &HeldLate) -> Self {
        let mut response =
            Self { positions: [0.0; HORIZON], speeds: [0.0; HORIZON], reversed: [0.0; HORIZON] };
        let mut motion = DriveMotion::default();
        let mut commands = [0.0, 1.0];
        for i in 0..HORIZON {
            motion = held.after(motion, commands);
            (response.positions[i], response.speeds[i]) = (motion.position, motion.velocity);
            response.reversed[HORIZON - 1 - i] = motion.position;
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

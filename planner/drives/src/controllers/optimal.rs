//! Optimal control (section 6.1): the Riccati equation gives the gains that minimise a quadratic performance
//! index.

use nalgebra::{RowVector3, SMatrix, Vector3};
use serde::{Deserialize, Serialize};

use super::Belief;
use super::state_feedback::{StateFeedback, StateGains};
use crate::drive::{Drive, Held};

/// Weights of the performance index `Σ e² + integral·(∫e)² + effort·u²`.
///
/// The error e is in pulses. The command u is given as its steady speed, pulses/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Index {
    /// Weight of the integral of the error, 1/s².
    pub integral: f64,
    /// Weight of the command, s².
    pub effort: f64,
}

impl Default for Index {
    /// Weights for a response about as fast as that of the paper's PID controller.
    fn default() -> Self {
        Self { integral: 100.0, effort: 1e-4 }
    }
}

/// Bound on the iterations of the Riccati equation. It converges much earlier.
const RICCATI: u32 = 20_000;

/// The optimum of `Σ xᵀQx + uᵀRu` under `x' = Ax + Bu`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regulator<const N: usize, const M: usize> {
    /// K of `u = −K·x`.
    pub gain: SMatrix<f64, M, N>,
    /// S of the least sum `xᵀSx`, that of `x` itself included.
    pub value: SMatrix<f64, N, N>,
}

/// Solves the Riccati equation. `None` if the iteration does not converge.
#[must_use]
pub fn regulator<const N: usize, const M: usize>(
    step: &SMatrix<f64, N, N>,
    input: &SMatrix<f64, N, M>,
    state_cost: &SMatrix<f64, N, N>,
    input_cost: &SMatrix<f64, M, M>,
    inverse: impl Fn(SMatrix<f64, M, M>) -> Option<SMatrix<f64, M, M>>,
) -> Option<Regulator<N, M>> {
    let mut value = *state_cost;
    let mut gain = SMatrix::<f64, M, N>::zeros();
    for _ in 0..RICCATI {
        let push = input.transpose() * value;
        let next = inverse(input_cost + push * input)? * push * step;
        let converged = (next - gain).amax() <= 1e-12 * next.amax();
        gain = next;
        if converged {
            return Some(Regulator { gain, value });
        }
        let closed = step - input * gain;
        value = state_cost + gain.transpose() * input_cost * gain + closed.transpose() * value * closed;
    }
    None
}

/// The model of one axis with the states position, speed and integral of the position.
#[must_use]
pub(super) fn augmented(held: &Held, period_s: f64) -> (SMatrix<f64, 3, 3>, Vector3<f64>) {
    let step = SMatrix::<f64, 3, 3>::from_rows(&[
        RowVector3::new(1.0, held.run, 0.0),
        RowVector3::new(0.0, held.decay, 0.0),
        RowVector3::new(period_s, 0.0, 1.0),
    ]);
    (step, Vector3::new(held.b0, held.push, 0.0))
}

/// LQ state feedback with integral action for each axis. `None` if the index has no optimum.
#[must_use]
pub fn linear_quadratic(belief: &Belief, index: Index) -> Option<StateFeedback> {
    let gains = |drive: Drive| {
        let (step, input) = augmented(&drive.held(belief.period_s), belief.period_s);
        let state_cost = SMatrix::<f64, 3, 3>::from_diagonal(&Vector3::new(1.0, 0.0, index.integral));
        let input_cost = SMatrix::<f64, 1, 1>::new(index.effort * drive.gain * drive.gain);
        let Regulator { gain, .. } =
            regulator(&step, &input, &state_cost, &input_cost, |m: SMatrix<f64, 1, 1>| m.try_inverse())?;
        Some(StateGains { position: gain[0], speed: gain[1], integral: gain[2] })
    };
    let [x, y] = belief.drives;
    Some(StateFeedback::with([gains(x)?, gains(y)?], belief.period_s))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No other gain near the optimum costs less.
    #[test]
    fn regulator_gain_has_the_least_cost() {
        let held = Drive { gain: 10.0, time_constant_s: 0.045 }.held(0.004);
        let (step, input) = augmented(&held, 0.004);
        let q = SMatrix::<f64, 3, 3>::from_diagonal(&Vector3::new(1.0, 0.0, 100.0));
        let r = SMatrix::<f64, 1, 1>::new(0.01);
        let Regulator { gain, value } = regulator(&step, &input, &q, &r, |m| m.try_inverse()).unwrap();
        let cost = |gain: &SMatrix<f64, 1, 3>| {
            let (mut x, mut sum) = (Vector3::new(1.0, 0.0, 0.0), 0.0);
            for _ in 0..5000 {
                let u = -(gain * x)[0];
                sum += (x.transpose() * q * x)[0] + 0.01 * u * u;
                x = step * x + input * u;
            }
            sum
        };
        let least = cost(&gain);
        assert!((least / value[(0, 0)] - 1.0).abs() < 1e-9, "{least} {value}");
        for i in 0..3 {
            for share in [0.97, 1.03] {
                let mut other = gain;
                other[i] *= share;
                assert!(cost(&other) > least, "{i} {share}");
            }
        }
    }
}

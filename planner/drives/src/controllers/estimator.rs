//! A recursive least-squares estimator of the P loop of one axis, for the adaptive controllers.

use nalgebra::{Matrix3, Vector3};

use super::{Belief, zero_phase};
use crate::Axes;
use crate::drive::Loop;

/// Estimator of the parameters of `p − p1 = a2·(p1 − p2) + b0·(r1 − p1) + b1·(r2 − p1)`.
///
/// This is the loop of eq. (10) with a known integrator: p1 is one sample before p, and r is the reference of
/// the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimator {
    parameters: Vector3<f64>,
    began: Vector3<f64>,
    spread: Matrix3<f64>,
    positions: Option<[f64; 2]>,
    references: [f64; 2],
}

/// Initial uncertainty of the parameters, as a share.
const UNSURE: f64 = 0.2;
/// Measurement noise, pulses.
const NOISE: f64 = 0.01;
/// Factor by which the weight of old samples decreases with each sample.
const FORGETTING: f64 = 0.9995;
/// Largest factor between a parameter and its initial value.
const FARTHEST: f64 = 2.0;

impl Estimator {
    /// An estimator that starts with the loop `begin`.
    #[must_use]
    pub fn new(begin: &Loop) -> Self {
        let began = Vector3::new(begin.poles[2], begin.zeros[0], begin.zeros[1]);
        let spread = unsure(&began);
        Self {
            parameters: began,
            began,
            spread: Matrix3::from_diagonal(&spread),
            positions: None,
            references: [0.0; 2],
        }
    }

    /// The estimated loop.
    #[must_use]
    pub fn known(&self) -> Loop {
        let [a2, b0, b1] = [self.parameters[0], self.parameters[1], self.parameters[2]];
        Loop { poles: [1.0, b0 + b1 - 1.0 - a2, a2], zeros: [b0, b1] }
    }

    /// Updates the estimate with the next position. Ignores a sample after a clipped command.
    pub fn see(&mut self, position: f64, cut_off: bool) {
        let [first, second] = self.positions.unwrap_or([position; 2]);
        let seen = Vector3::new(first - second, self.references[0] - first, self.references[1] - first);
        if self.positions.is_some() && !cut_off {
            self.learn(&seen, position - first);
        }
        self.positions = Some([position, first]);
    }

    fn learn(&mut self, seen: &Vector3<f64>, moved: f64) {
        let spread = self.spread * seen;
        let gain = spread / (FORGETTING + seen.dot(&spread));
        let next = self.parameters + gain * (moved - seen.dot(&self.parameters));
        let near = next.iter().zip(&self.began).all(|(&now, &began)| {
            let share = now / began;
            (1.0 / FARTHEST..=FARTHEST).contains(&share)
        });
        let spread = (self.spread - gain * spread.transpose()) / FORGETTING;
        if near && next[0] < 1.0 && spread.iter().all(|each| each.is_finite()) {
            self.parameters = next;
            // Without new information, forgetting lets the covariance grow without bound. Cap it.
            let most = unsure(&self.began);
            if (0..3).all(|i| spread[(i, i)] <= most[i] * 10.0) {
                self.spread = spread;
            }
        }
    }

    /// Records the reference of the loop for the next period.
    pub fn give(&mut self, reference: f64) {
        self.references = [reference, self.references[0]];
    }
}

/// Initial variances of the parameters, relative to the measurement noise.
fn unsure(began: &Vector3<f64>) -> Vector3<f64> {
    began.map(|parameter| (UNSURE * parameter / NOISE).powi(2))
}

/// Updates both estimators with the measured positions. An axis ignores a sample after a command beyond the
/// limit.
pub fn see(estimators: &mut [Estimator; 2], measured: Axes, command: Axes, limit: Option<f64>) {
    for (axis, estimator) in estimators.iter_mut().enumerate() {
        let cut_off = limit.is_some_and(|limit| command[axis].abs() > limit);
        estimator.see(measured[axis], cut_off);
    }
}

/// One estimator for each axis, for P loops of `gain`, bits/pulse.
#[must_use]
pub fn of_loops(belief: &Belief, gain: f64) -> [Estimator; 2] {
    zero_phase::loops(belief, gain).map(|each| Estimator::new(&each))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Drive;

    #[test]
    fn estimate_converges_to_the_real_loop() {
        let period = 0.004;
        let drive = Drive { gain: 10.0, time_constant_s: 0.045 };
        let real = drive.held(period).closed(1.0);
        let mut estimator = Estimator::new(&drive.off_by(0.08, -0.07).held(period).closed(1.0));
        let (mut r, mut p) = ([0.0; 2], [0.0; 2]);
        for k in 0..3000_i32 {
            let now =
                -real.poles[1] * p[0] - real.poles[2] * p[1] + real.zeros[0] * r[0] + real.zeros[1] * r[1];
            estimator.see(now, false);
            p = [now, p[0]];
            r = [2000.0 * (f64::from(k) * 0.01).sin() + 300.0 * (f64::from(k) * 0.31).sin(), r[0]];
            estimator.give(r[0]);
        }
        let known = estimator.known();
        for (known, real) in known.poles.iter().chain(&known.zeros).zip(real.poles.iter().chain(&real.zeros))
        {
            assert!((known - real).abs() < 1e-6, "{known} {real}");
        }
    }
}

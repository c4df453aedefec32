//! A Kalman observer of the position, speed and load of one axis.

use nalgebra::{Matrix3, RowVector3, Vector3};

use crate::drive::{DriveMotion, HeldLate};

/// Estimator of position (pulses), speed (pulses/s) and load (bits) of an axis, with the steady gain of a
/// Kalman filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    held: HeldLate,
    gain: Vector3<f64>,
    state: Option<Vector3<f64>>,
    /// The command before, bits.
    before: f64,
}

/// Standard deviations of the random changes of speed and load in a sample, for measurements with a noise of one
/// pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomSteps {
    /// Of the speed, pulses/s.
    pub speed: f64,
    /// Of the load, bits.
    pub load: f64,
}

impl Observer {
    /// An observer of a drive whose speed and load change at random.
    #[must_use]
    pub fn new(held: HeldLate, steps: RandomSteps) -> Self {
        Self { held, gain: steady_gain(&held, steps), state: None, before: 0.0 }
    }

    /// Updates the estimate with a measured position, pulses, and returns it. The first measurement counts as
    /// exact and at rest.
    pub fn see(&mut self, measured: f64) -> Vector3<f64> {
        let state = self.state.get_or_insert(Vector3::new(measured, 0.0, 0.0));
        let off = measured - state[0];
        *state += self.gain * off;
        *state
    }

    /// Predicts the state one period later under `command`, bits.
    pub fn go_on(&mut self, command: f64) {
        if let Some(state) = &mut self.state {
            let [position, velocity, load] = [state[0], state[1], state[2]];
            let net = [self.before - load, command - load];
            let next = self.held.after(DriveMotion { position, velocity }, net);
            (state[0], state[1]) = (next.position, next.velocity);
        }
        self.before = command;
    }

    /// Replaces the estimated load, bits.
    pub fn load_is(&mut self, load: f64) {
        if let Some(state) = &mut self.state {
            state[2] = load;
        }
    }
}

/// Bound on the iterations of the Riccati equation. It converges much earlier.
const RICCATI: u32 = 5000;

fn steady_gain(held: &HeldLate, steps: RandomSteps) -> Vector3<f64> {
    let [reach, push] = [held.reach, held.push].map(|by| by[0] + by[1]);
    let step = Matrix3::new(1.0, held.run, -reach, 0.0, held.decay, -push, 0.0, 0.0, 1.0);
    let look = RowVector3::new(1.0, 0.0, 0.0);
    let process = Matrix3::from_diagonal(&Vector3::new(0.0, steps.speed.powi(2), steps.load.powi(2)));
    let mut spread = Matrix3::identity() + process * 100.0;
    let mut gain = Vector3::zeros();
    for _ in 0..RICCATI {
        let seen = spread * look.transpose();
        let next = seen / (seen[0] + 1.0);
        let converged = (next - gain).amax() <= 1e-12 * next.amax();
        gain = next;
        if converged {
            break;
        }
        let after = spread - gain * seen.transpose();
        spread = step * after * step.transpose() + process;
    }
    gain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::Drive;

    /// The observer estimates a constant load from the positions of the drive.
    #[test]
    fn constant_load_is_estimated() {
        let drive = Drive { gain: 10.0, time_constant_s: 0.045 };
        let mut observer =
            Observer::new(drive.held_late(0.004, 0.0), RandomSteps { speed: 0.0, load: 4000.0 });
        let (mut motion, held) = (DriveMotion::default(), drive.held(0.004));
        let mut known = Vector3::zeros();
        for k in 0..200 {
            known = observer.see(motion.position);
            let command = f64::from(k % 7) * 30.0;
            observer.go_on(command);
            motion = held.after(motion, command - 55.0);
        }
        assert!((known[2] - 55.0).abs() < 1e-3, "{known}");
    }
}

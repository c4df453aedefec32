//! A Kalman observer of the position, speed and load of one axis.

use nalgebra::{Matrix3, RowVector3, Vector3};

use crate::drive::{Drive, Held};

/// Noise of the observer's model: standard deviations per sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wander {
    /// Random change of the speed, pulses/s.
    pub speed: f64,
    /// Random change of the load, bits.
    pub load: f64,
    /// Noise of a measurement, pulses.
    pub measurement: f64,
}

/// Estimator of position (pulses), speed (pulses/s) and load (bits) of an axis, with the steady gain of a
/// Kalman filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    held: Held,
    gain: Vector3<f64>,
    state: Option<Vector3<f64>>,
}

impl Observer {
    /// An observer of a drive. The load is modelled as a random walk.
    #[must_use]
    pub fn new(drive: Drive, period_s: f64, wander: Wander) -> Self {
        let held = drive.held(period_s);
        Self { held, gain: steady_gain(&held, wander), state: None }
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
            let net = command - state[2];
            let [position, speed] = [state[0], state[1]];
            state[0] = position + self.held.run * speed + self.held.b0 * net;
            state[1] = self.held.decay * speed + self.held.push * net;
        }
    }
}

/// Number of iterations of the Riccati equation. It converges much earlier.
const RICCATI: u32 = 5000;

fn steady_gain(held: &Held, wander: Wander) -> Vector3<f64> {
    let step = Matrix3::new(1.0, held.run, -held.b0, 0.0, held.decay, -held.push, 0.0, 0.0, 1.0);
    let look = RowVector3::new(1.0, 0.0, 0.0);
    let process = Matrix3::from_diagonal(&Vector3::new(0.0, wander.speed.powi(2), wander.load.powi(2)));
    let noise = wander.measurement.powi(2);
    let mut spread = process * 100.0;
    let mut gain = Vector3::zeros();
    for _ in 0..RICCATI {
        let seen = spread * look.transpose();
        gain = seen / (seen[0] + noise);
        let after = spread - gain * seen.transpose();
        spread = step * after * step.transpose() + process;
    }
    gain
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::DriveMotion;

    /// The observer estimates a constant load from the positions of the drive.
    #[test]
    fn constant_load_is_estimated() {
        let drive = Drive { gain: 10.0, time_constant_s: 0.045 };
        let mut observer = Observer::new(drive, 0.004, Wander { speed: 1.0, load: 200.0, measurement: 0.05 });
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

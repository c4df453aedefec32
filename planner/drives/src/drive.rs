//! One feed drive: amplifier, motor, gear, screw and encoder as a first-order lag and an integrator.

use serde::{Deserialize, Serialize};

/// A drive: `tau·v' + v = K·(u − d)`, `p' = v`, with `p` in pulses, `u` and `d` in bits (Koren & Lo, section
/// 7).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// K, the steady speed per bit, pulses/(s·bit). It is the open-loop gain with a P controller of gain 1.
    pub gain: f64,
    /// tau, s.
    pub time_constant_s: f64,
}

/// Position and speed of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveMotion {
    /// Position, pulses.
    pub position: f64,
    /// Speed, pulses/s.
    pub velocity: f64,
}

/// Exact discrete model of a drive with a zero-order hold: `(b0·z + b1)/((z − 1)(z − decay))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// `exp(−T/tau)`.
    pub decay: f64,
    /// Distance covered in a period per unit of initial speed, without a command, s.
    pub run: f64,
    /// Speed gained in a period per bit, pulses/(s·bit).
    pub push: f64,
    /// Distance covered in a period per bit, pulses/bit. First coefficient of the numerator.
    pub b0: f64,
    /// Second coefficient of the numerator, pulses/bit.
    pub b1: f64,
}

/// Exact discrete model of a drive whose commands act a share of the period late: in the first part of a period the
/// command before acts, in the rest the command of now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldLate {
    /// `exp(−T/tau)`.
    pub decay: f64,
    /// Distance covered in a period per unit of initial speed, without a command, s.
    pub run: f64,
    /// Speed gained in a period per bit of the command before and of now, pulses/(s·bit).
    pub push: [f64; 2],
    /// Distance covered in a period per bit of the command before and of now, pulses/bit.
    pub reach: [f64; 2],
}

impl HeldLate {
    /// The motion one period later, under net commands of `before` and `now`, bits.
    #[must_use]
    pub fn after(&self, from: DriveMotion, [before, now]: [f64; 2]) -> DriveMotion {
        DriveMotion {
            position: from.position + self.run * from.velocity + self.reach[0] * before + self.reach[1] * now,
            velocity: self.decay * from.velocity + self.push[0] * before + self.push[1] * now,
        }
    }
}

impl Drive {
    /// The discrete model for a period of `period_s`.
    #[must_use]
    pub fn held(self, period_s: f64) -> Held {
        let Self { gain, time_constant_s: tau } = self;
        let decay = (-period_s / tau).exp();
        let run = -tau * (-period_s / tau).exp_m1();
        Held {
            decay,
            run,
            push: gain * (1.0 - decay),
            b0: gain * (period_s - run),
            b1: gain * (run - period_s * decay),
        }
    }

    /// The discrete model for commands that act a share of the period late.
    #[must_use]
    pub fn held_late(self, period_s: f64, share: f64) -> HeldLate {
        let [before, now] = [share, 1.0 - share].map(|part| self.held(part * period_s));
        HeldLate {
            decay: now.decay * before.decay,
            run: before.run + now.run * before.decay,
            push: [now.decay * before.push, now.push],
            reach: [before.b0 + now.run * before.push, now.b0],
        }
    }

    /// The same drive with gain and time constant increased by these shares.
    #[must_use]
    pub fn off_by(self, gain: f64, time_constant: f64) -> Self {
        Self { gain: self.gain * (1.0 + gain), time_constant_s: self.time_constant_s * (1.0 + time_constant) }
    }

    /// The motion after `seconds` under a net command of `bits`.
    #[must_use]
    pub fn after(self, from: DriveMotion, bits: f64, seconds: f64) -> DriveMotion {
        let held = self.held(seconds);
        held.after(from, bits)
    }

    /// Seconds until the drive stands still under a net command of `bits`. `None` if it never does.
    #[must_use]
    pub fn stands_after(self, velocity: f64, bits: f64) -> Option<f64> {
        let end = self.gain * bits;
        (velocity * end < 0.0).then(|| self.time_constant_s * ((end - velocity) / end).ln())
    }
}

impl Held {
    /// The motion one period later, under a net command of `bits`.
    #[must_use]
    pub fn after(&self, from: DriveMotion, bits: f64) -> DriveMotion {
        DriveMotion {
            position: from.position + self.run * from.velocity + self.b0 * bits,
            velocity: self.decay * from.velocity + self.push * bits,
        }
    }

    /// `A(z⁻¹)` of the drive alone: `(1 − z⁻¹)(1 − e·z⁻¹)`.
    #[must_use]
    pub fn poles(&self) -> [f64; 3] {
        [1.0, -1.0 - self.decay, self.decay]
    }

    /// The closed loop with a P controller of this gain: `A(z⁻¹)` and `B(z⁻¹)` of eq. (10), with `d = 1`.
    #[must_use]
    pub fn closed(&self, proportional: f64) -> Loop {
        let zeros = [proportional * self.b0, proportional * self.b1];
        let [a0, a1, a2] = self.poles();
        Loop { poles: [a0, a1 + zeros[0], a2 + zeros[1]], zeros }
    }
}

/// Transfer function from reference to position: `z⁻¹·(b0 + b1·z⁻¹)/(a0 + a1·z⁻¹ + a2·z⁻²)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loop {
    /// a0, a1, a2.
    pub poles: [f64; 3],
    /// b0, b1.
    pub zeros: [f64; 2],
}

impl Loop {
    /// The reference that makes the loop follow `wanted` with zero phase error: `A(z⁻¹)·B(z)/B(1)²`.
    ///
    /// This is eq. (11), with both zeros treated as unacceptable. `wanted(i)` is the desired position `i`
    /// samples ahead.
    #[must_use]
    pub fn zero_phase(&self, wanted: impl Fn(isize) -> f64) -> f64 {
        let [b0, b1] = self.zeros;
        let smooth = |i: isize| b0 * wanted(1 - i) + b1 * wanted(2 - i);
        let [a0, a1, a2] = self.poles;
        (a0 * smooth(0) + a1 * smooth(1) + a2 * smooth(2)) / ((b0 + b1) * (b0 + b1))
    }

    /// The position of the loop with the reference [`Loop::zero_phase`]: `B(z⁻¹)·B(z)/B(1)²`, eq. (13).
    #[must_use]
    pub fn zero_phase_output(&self, wanted: impl Fn(isize) -> f64) -> f64 {
        let [b0, b1] = self.zeros;
        let beside = wanted(-1) + wanted(1);
        ((b0 * b0 + b1 * b1) * wanted(0) + b0 * b1 * beside) / ((b0 + b1) * (b0 + b1))
    }

    /// Lag behind a ramp, samples.
    #[must_use]
    pub fn lag(&self) -> f64 {
        let [b0, b1] = self.zeros;
        let [a0, a1, a2] = self.poles;
        1.0 + b1 / (b0 + b1) - (a1 + 2.0 * a2) / (a0 + a1 + a2)
    }

    /// Magnitude |G(e^{jwT})| at `angle` = wT, rad.
    #[must_use]
    pub fn magnitude(&self, angle: f64) -> f64 {
        let at = |coefficients: &[f64]| {
            let (mut re, mut im) = (0.0, 0.0);
            for (turns, c) in (0u8..).map(f64::from).zip(coefficients) {
                re += c * (turns * angle).cos();
                im -= c * (turns * angle).sin();
            }
            f64::hypot(re, im)
        };
        at(&self.zeros) / at(&self.poles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: Drive = Drive { gain: 10.0, time_constant_s: 0.045 };

    /// The discrete model is exact: two half periods equal one, and small Euler steps agree closely.
    #[test]
    fn held_command_is_integrated_exactly() {
        let from = DriveMotion { position: 3.0, velocity: -20.0 };
        let whole = DRIVE.after(from, 17.0, 0.004);
        let halves = DRIVE.after(DRIVE.after(from, 17.0, 0.002), 17.0, 0.002);
        assert!((whole.position - halves.position).abs() < 1e-12);
        assert!((whole.velocity - halves.velocity).abs() < 1e-12);
        let mut euler = from;
        for _ in 0..40_000 {
            euler.position += euler.velocity * 1e-7;
            euler.velocity += (DRIVE.gain * 17.0 - euler.velocity) / DRIVE.time_constant_s * 1e-7;
        }
        assert!(
            (whole.position - euler.position).abs() < 1e-5 && (whole.velocity - euler.velocity).abs() < 1e-3
        );
    }

    /// The late model is the drive under two commands, one after the other.
    #[test]
    fn late_command_is_integrated_exactly() {
        let from = DriveMotion { position: 3.0, velocity: -20.0 };
        let late = DRIVE.held_late(0.004, 0.3).after(from, [17.0, -5.0]);
        let parts = DRIVE.after(DRIVE.after(from, 17.0, 0.0012), -5.0, 0.0028);
        assert!((late.position - parts.position).abs() < 1e-12);
        assert!((late.velocity - parts.velocity).abs() < 1e-12);
        let held = DRIVE.held(0.004);
        let on_time = DRIVE.held_late(0.004, 0.0);
        assert_eq!([on_time.run, on_time.push[1], on_time.reach[1]], [held.run, held.push, held.b0]);
        assert_eq!([on_time.push[0], on_time.reach[0]], [0.0; 2]);
    }

    /// The transfer function gives the same positions as the state equations.
    #[test]
    fn transfer_function_agrees_with_the_state_equations() {
        let held = DRIVE.held(0.004);
        let commands = [5.0, -3.0, 11.0, 0.0, 2.0, 7.0, -1.0];
        let (mut motion, mut positions) = (DriveMotion::default(), vec![0.0]);
        for u in commands {
            motion = held.after(motion, u);
            positions.push(motion.position);
        }
        let [_, a1, a2] = held.poles();
        for k in 2..positions.len() {
            let by_z = -a1 * positions[k - 1] - a2 * positions[k - 2]
                + held.b0 * commands[k - 1]
                + held.b1 * commands[k - 2];
            assert!((by_z - positions[k]).abs() < 1e-12, "{k}");
        }
        // This zero makes the exact inverse useless (section 4.2: "e.g. z = -0.97").
        assert!((held.b1 / held.b0 - 0.971).abs() < 0.0005);
    }

    /// A P loop lags behind a ramp by 1/(Kp·K).
    #[test]
    fn lag_is_the_inverse_of_the_open_loop_gain() {
        let lag = DRIVE.held(0.004).closed(1.3).lag();
        assert!((lag * 0.004 - 1.0 / 13.0).abs() < 1e-12, "{lag}");
    }

    #[test]
    fn drive_stands_still_at_the_predicted_time() {
        let seconds = DRIVE.stands_after(30.0, -12.0).unwrap();
        let there = DRIVE.after(DriveMotion { position: 0.0, velocity: 30.0 }, -12.0, seconds);
        assert!(there.velocity.abs() < 1e-12);
        assert_eq!(DRIVE.stands_after(30.0, 12.0), None);
        assert_eq!(DRIVE.stands_after(30.0, 0.0), None);
    }

    /// With the zero-phase reference, the gain of the loop is |B(e^jw)/B(1)|² (eq. (14)).
    #[test]
    fn zero_phase_reference_has_the_gain_of_equation_14() {
        let closed = DRIVE.held(0.004).closed(1.0);
        let angle: f64 = 0.3;
        let wanted = |k: f64| (angle * k).sin();
        let (mut r, mut p) = ([0.0; 2], [0.0; 2]);
        let mut worst: f64 = 0.0;
        let gain = {
            let [b0, b1] = closed.zeros;
            (b0 * b0 + b1 * b1 + 2.0 * b0 * b1 * angle.cos()) / (b0 + b1).powi(2)
        };
        for k in 0..3000_i32 {
            let now = -closed.poles[1] * p[0] - closed.poles[2] * p[1]
                + closed.zeros[0] * r[0]
                + closed.zeros[1] * r[1];
            if k > 2000 {
                worst = worst.max((now - gain * wanted(f64::from(k))).abs());
            }
            p = [now, p[0]];
            #[expect(clippy::cast_precision_loss, reason = "offsets of two samples")]
            let next = closed.zero_phase(|i| wanted(f64::from(k) + i as f64));
            r = [next, r[0]];
        }
        assert!(worst < 1e-12, "{worst}");
    }
}

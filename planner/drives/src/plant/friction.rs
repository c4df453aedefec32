//! Friction of an axis.

use serde::{Deserialize, Serialize};

use crate::drive::{Drive, DriveMotion};
use keepout_planner::Mm2;

/// Friction of an axis, bits. It does not depend on the speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Friction {
    /// No friction.
    #[default]
    None,
    /// Friction against the direction of the reference, as in eq. (4).
    Reference(f64),
    /// Friction against the motion of the axis. At rest it holds the axis up to `stiction`, which is at least
    /// `coulomb`.
    Stick {
        /// Friction while the axis moves.
        coulomb: f64,
        /// Command above which an axis at rest starts to move.
        stiction: f64,
    },
}

impl Friction {
    /// The friction of a moving axis, bits.
    #[must_use]
    pub fn coulomb_bits(&self) -> f64 {
        match *self {
            Self::None => 0.0,
            Self::Reference(level) => level,
            Self::Stick { coulomb, .. } => coulomb,
        }
    }
}

/// The elastic part of sticking friction, and its fall with the speed: the LuGre model (Canudas de Wit, Olsson, Åström
/// & Lischinsky 1995, "A new model for control of systems with friction", eqs. (1) to (3)).
///
/// `z' = v − σ0·|v|/g(v)·z`, `F = σ0·z + σ1·z'`, `g(v) = Fc + (Fs − Fc)·exp(−(v/vs)²)`. The viscous part is in the
/// drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Presliding {
    /// σ0, bits/pulse.
    pub stiffness: f64,
    /// σ1, bits·s/pulse.
    pub damping: f64,
    /// vs, the speed at which the friction has fallen from the stiction almost to the Coulomb friction, pulses/s.
    pub stribeck: f64,
}

impl Presliding {
    /// The model for a drive whose friction of `coulomb` bits gives elastically by `distance`, pulses. The damping is
    /// half the critical one, as that of the paper (Table 1 there: `σ1 = √σ0` for a mass of 1).
    #[must_use]
    pub fn of(drive: Drive, coulomb: f64, distance: f64, stribeck: f64) -> Self {
        let stiffness = coulomb / distance;
        Self { stiffness, damping: (stiffness * drive.time_constant_s / drive.gain).sqrt(), stribeck }
    }

    /// g(v), bits, for the Coulomb friction and the stiction.
    fn level(&self, velocity: f64, Mm2 { x: coulomb, y: stiction }: Mm2) -> f64 {
        coulomb + (stiction - coulomb) * (-(velocity / self.stribeck).powi(2)).exp()
    }

    /// The share of the speed with which the deflection grows: `z'/v`.
    fn growth(&self, velocity: f64, deflection: f64, levels: Mm2) -> f64 {
        1.0 - self.stiffness * deflection * velocity.signum() / self.level(velocity, levels)
    }

    /// F, bits.
    pub(super) fn force(&self, velocity: f64, deflection: f64, levels: Mm2) -> f64 {
        self.stiffness * deflection + self.damping * velocity * self.growth(velocity, deflection, levels)
    }

    /// Motion and deflection after a short time under `bits`: half a step of the deflection, a step of the motor, half
    /// a step of the deflection. Each is exact.
    pub(super) fn after(
        &self,
        drive: Drive,
        motor: DriveMotion,
        deflection: f64,
        levels: Mm2,
        bits: f64,
        seconds: f64,
    ) -> (DriveMotion, f64) {
        let relaxed = |deflection: f64, velocity: f64| {
            let level = self.level(velocity, levels);
            let end = level / self.stiffness * velocity.signum();
            end + (deflection - end) * (-self.stiffness * velocity.abs() / level * seconds / 2.0).exp()
        };
        let between = relaxed(deflection, motor.velocity);
        // The damping acts like a smaller gain and time constant.
        let slower = 1.0 + drive.gain * self.damping * self.growth(motor.velocity, between, levels);
        let damped = Drive { gain: drive.gain / slower, time_constant_s: drive.time_constant_s / slower };
        let next = damped.after(motor, bits - self.stiffness * between, seconds);
        (next, relaxed(between, next.velocity))
    }
}

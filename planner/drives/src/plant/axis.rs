//! One axis of the plant: drive, friction, play and table.

use super::friction::{Friction, Presliding};
use super::resonance::Resonance;
use crate::controllers::FrictionBelief;
use crate::drive::{Drive, DriveMotion};
use keepout_planner::Mm2;

/// One axis of the plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// The drive.
    pub drive: Drive,
    /// The friction.
    pub friction: Friction,
    /// The elastic part of [`Friction::Stick`]. Without it, an axis at rest does not move at all.
    pub presliding: Option<Presliding>,
    /// Play between motor and table, pulses. The encoder is on the motor.
    pub backlash: f64,
    /// The spring between motor and table. Without it, the table is rigid.
    pub resonance: Option<Resonance>,
}

/// The motion of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisMotion {
    /// The motor, in terms of the table.
    pub motor: DriveMotion,
    /// The table.
    pub table: DriveMotion,
    /// Elastic deflection of the friction, pulses.
    pub deflection: f64,
}

/// What acts on an axis for a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Acting {
    /// Command of the amplifier, bits.
    pub(super) command: f64,
    /// Cutting force against positive motion, bits.
    pub(super) force: f64,
    /// Speed of the reference, pulses/s.
    pub(super) reference_velocity: f64,
}

/// Longest step of the integration, s.
const LONGEST_STEP_S: f64 = 5e-5;
/// Longest step, as an angle of the fastest oscillation, rad.
const LONGEST_ANGLE: f64 = 0.05;
/// Most steps in one call.
const MOST_STEPS: f64 = 20_000.0;

impl Axis {
    /// A drive without friction, play and spring.
    #[must_use]
    pub fn ideal(drive: Drive) -> Self {
        Self { drive, friction: Friction::None, presliding: None, backlash: 0.0, resonance: None }
    }

    /// The friction that a controller expects of this axis.
    #[must_use]
    pub fn friction_belief(&self) -> FrictionBelief {
        let coulomb = self.friction.coulomb_bits();
        FrictionBelief {
            coulomb,
            presliding: self.presliding.map_or(0.0, |presliding| coulomb / presliding.stiffness),
        }
    }

    /// The motion after `seconds`. Without a spring and pre-sliding it is exact; otherwise it is integrated in
    /// short steps, with an error of the second order.
    pub(super) fn after(&self, from: AxisMotion, acting: &Acting, seconds: f64) -> AxisMotion {
        if self.presliding.is_none() && self.resonance.is_none() {
            let net = acting.command - acting.force;
            let motor = self.moved(from.motor, net, acting.reference_velocity, seconds);
            return AxisMotion { motor, table: self.rigid_table(&from, motor), ..from };
        }
        let angular = |presliding: Presliding| {
            (self.drive.gain * presliding.stiffness / self.drive.time_constant_s).sqrt()
        };
        let fastest =
            self.presliding.map_or(0.0, angular).max(self.resonance.map_or(0.0, |spring| spring.angular));
        let longest_s =
            if fastest > 0.0 { LONGEST_STEP_S.min(LONGEST_ANGLE / fastest) } else { LONGEST_STEP_S };
        let steps = (seconds / longest_s).ceil().clamp(1.0, MOST_STEPS);
        let (mut motion, mut number) = (from, 0.0);
        while number < steps {
            motion = self.stepped(motion, acting, seconds / steps);
            number += 1.0;
        }
        motion
    }

    /// One short step. The spring pulls as in the middle of the step, at the motor and at the table alike.
    fn stepped(&self, motion: AxisMotion, acting: &Acting, seconds: f64) -> AxisMotion {
        let Some(spring) = self.resonance else {
            let mut next = motion;
            self.push(&mut next, self.drive, acting.command - acting.force, acting, seconds);
            next.table = self.rigid_table(&motion, next.motor);
            return next;
        };
        let middle = self.pulled(motion, &spring, &motion, acting, seconds / 2.0);
        self.pulled(motion, &spring, &middle, acting, seconds)
    }

    /// The motion after a step in which the spring pulls as at `at`.
    fn pulled(
        &self,
        mut motion: AxisMotion,
        spring: &Resonance,
        at: &AxisMotion,
        acting: &Acting,
        seconds: f64,
    ) -> AxisMotion {
        let Drive { gain, time_constant_s } = self.drive;
        let (pull, share) = (spring.pull(at, self.backlash / 2.0), spring.table_share);
        let motor = Drive { gain, time_constant_s: time_constant_s * (1.0 - share) };
        let reaction = pull * share * time_constant_s / gain;
        self.push(&mut motion, motor, acting.command - reaction, acting, seconds);
        let acceleration = pull - acting.force * gain / time_constant_s / share;
        motion.table.position += seconds * (motion.table.velocity + seconds / 2.0 * acceleration);
        motion.table.velocity += seconds * acceleration;
        motion
    }

    /// Moves the motor.
    fn push(&self, motion: &mut AxisMotion, drive: Drive, bits: f64, acting: &Acting, seconds: f64) {
        match (self.presliding, self.friction) {
            (Some(presliding), Friction::Stick { coulomb, stiction }) => {
                let levels = Mm2::new(coulomb, stiction);
                (motion.motor, motion.deflection) =
                    presliding.after(drive, motion.motor, motion.deflection, levels, bits, seconds);
            }
            _ => {
                let alone = Self { drive, ..*self };
                motion.motor = alone.moved(motion.motor, bits, acting.reference_velocity, seconds);
            }
        }
    }

    /// The table of a rigid axis: within the play around the motor.
    fn rigid_table(&self, from: &AxisMotion, motor: DriveMotion) -> DriveMotion {
        let play = self.backlash / 2.0;
        // After a divergence the bounds are not ordered, and the position is NaN.
        let (low, high) = (motor.position - play, motor.position + play);
        let position = if low <= high { from.table.position.clamp(low, high) } else { f64::NAN };
        DriveMotion { position, velocity: motor.velocity }
    }

    /// A bound on the acceleration of the table, pulses/s²: `(|v| + K·(|u − d| + friction))/tau`. It is not less at any
    /// time before the speed is farther from zero. With a spring or pre-sliding it is the acceleration now.
    pub(super) fn largest_acceleration(&self, motion: &AxisMotion, acting: &Acting) -> f64 {
        let Drive { gain, time_constant_s } = self.drive;
        let net = acting.command - acting.force;
        if let Some(spring) = self.resonance {
            let force = acting.force * gain / time_constant_s / spring.table_share;
            return (spring.pull(motion, self.backlash / 2.0) - force).abs();
        }
        match (self.presliding, self.friction) {
            (Some(presliding), Friction::Stick { coulomb, stiction }) => {
                let against =
                    presliding.force(motion.motor.velocity, motion.deflection, Mm2::new(coulomb, stiction));
                (gain * (net - against) - motion.motor.velocity).abs() / time_constant_s
            }
            _ => {
                let bits = net.abs() + self.friction.coulomb_bits();
                (motion.motor.velocity.abs() + gain * bits) / time_constant_s
            }
        }
    }

    /// The motion of a rigid axis without pre-sliding after `seconds` under a net command of `bits`.
    pub(crate) fn moved(
        &self,
        from: DriveMotion,
        bits: f64,
        reference_velocity: f64,
        seconds: f64,
    ) -> DriveMotion {
        match self.friction {
            Friction::None => self.drive.after(from, bits, seconds),
            Friction::Reference(level) => {
                let against =
                    if reference_velocity == 0.0 { 0.0 } else { level * reference_velocity.signum() };
                self.drive.after(from, bits - against, seconds)
            }
            Friction::Stick { coulomb, stiction } => {
                self.stuck_or_moved(from, bits, Mm2::new(coulomb, stiction), seconds)
            }
        }
    }

    /// [`Axis::moved`] with sticking friction. In one period the axis stops at most once and starts again at
    /// most once.
    fn stuck_or_moved(
        &self,
        from: DriveMotion,
        bits: f64,
        Mm2 { x: coulomb, y: stiction }: Mm2,
        seconds: f64,
    ) -> DriveMotion {
        let (mut motion, mut left) = (from, seconds);
        if motion.velocity != 0.0 {
            let net = bits - coulomb * motion.velocity.signum();
            match self.drive.stands_after(motion.velocity, net).filter(|&after| after < left) {
                None => return self.drive.after(motion, net, left),
                Some(after) => {
                    motion = DriveMotion { velocity: 0.0, ..self.drive.after(motion, net, after) };
                    left -= after;
                }
            }
        }
        if bits.abs() <= stiction {
            return motion;
        }
        self.drive.after(motion, bits - coulomb * bits.signum(), left)
    }
}

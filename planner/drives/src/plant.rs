//! The two-axis plant: drives, friction, saturation, whole-number encoders and commands, delay and backlash.

use serde::{Deserialize, Serialize};

use super::Axes;
use super::drive::{Drive, DriveMotion};
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

/// One axis of the plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// The drive.
    pub drive: Drive,
    /// The friction.
    pub friction: Friction,
    /// Play between motor and table, pulses. The encoder is on the motor.
    pub backlash: f64,
}

/// The parameters of a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantModel {
    /// X and Y.
    pub axes: [Axis; 2],
    /// T, the sampling period, s.
    pub period_s: f64,
    /// Largest command that the amplifier accepts, bits.
    pub limit: Option<f64>,
    /// Whether encoders count whole pulses and commands are whole bits.
    pub whole_numbers: bool,
    /// Delay of a command, whole samples: at most [`MOST_DELAY`].
    pub delay_samples: usize,
    /// The rest of the delay, as a share of a sample: from 0 to below 1.
    pub delay_share: f64,
}

/// The longest delay, samples.
pub const MOST_DELAY: usize = 8;

impl PlantModel {
    /// Two drives without friction, saturation, rounding, delay or backlash.
    #[must_use]
    pub fn ideal(drives: [Drive; 2], period_s: f64) -> Self {
        let axes = drives.map(|drive| Axis { drive, friction: Friction::None, backlash: 0.0 });
        Self { axes, period_s, limit: None, whole_numbers: false, delay_samples: 0, delay_share: 0.0 }
    }

    /// The two drives.
    #[must_use]
    pub fn drives(&self) -> [Drive; 2] {
        self.axes.map(|axis| axis.drive)
    }
}

/// The load on the plant during a period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Cutting force, bits.
    pub cutting: Axes,
    /// Speed of the reference, pulses/s. [`Friction::Reference`] uses its sign.
    pub reference_velocity: Axes,
}

/// A plant in motion.
#[derive(Clone, Debug)]
pub struct Plant {
    model: PlantModel,
    motors: [DriveMotion; 2],
    table: Axes,
    late: [Axes; MOST_DELAY],
    /// The command that acted last.
    acted: Axes,
    steps: u64,
    saturated: u64,
}

impl Plant {
    /// A plant at rest at `position`, pulses.
    #[must_use]
    pub fn at_rest(model: PlantModel, position: Axes) -> Self {
        let motor = |position| DriveMotion { position, velocity: 0.0 };
        Self {
            model,
            motors: [motor(position.x), motor(position.y)],
            table: position,
            late: [Axes::zeros(); MOST_DELAY],
            acted: Axes::zeros(),
            steps: 0,
            saturated: 0,
        }
    }

    /// Position by the encoders, pulses.
    #[must_use]
    pub fn measured(&self) -> Axes {
        let exact = Axes::new(self.motors[0].position, self.motors[1].position);
        if self.model.whole_numbers { exact.map(f64::round) } else { exact }
    }

    /// Position of the table, pulses.
    #[must_use]
    pub fn position(&self) -> Axes {
        self.table
    }

    /// Speed of the motors, pulses/s.
    #[must_use]
    pub fn velocity(&self) -> Axes {
        Axes::new(self.motors[0].velocity, self.motors[1].velocity)
    }

    /// Share of the commands that the amplifier clipped at its limit.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "a share needs few digits")]
    pub fn saturation_share(&self) -> f64 {
        if self.steps == 0 { 0.0 } else { self.saturated as f64 / self.steps as f64 }
    }

    /// Advances by one period under a constant `command`, bits.
    pub fn step(&mut self, command: Axes, load: &Load) {
        self.step_in_parts(command, load, 1, |_, _| {});
    }

    /// Advances by one period under a constant `command`, bits, in `parts` equal parts. Calls `look` after each part
    /// with the plant and with the largest acceleration of the motors in it, pulses/s².
    pub fn step_in_parts(
        &mut self,
        command: Axes,
        load: &Load,
        parts: u32,
        mut look: impl FnMut(&Self, f64),
    ) {
        let before = self.acted;
        let next = self.acting(command);
        let (period_s, part_s) = (self.model.period_s, self.model.period_s / f64::from(parts));
        let change_s = self.model.delay_share * period_s;
        for part in 0..parts {
            let begin_s = f64::from(part) * part_s;
            let late_s = (change_s - begin_s).clamp(0.0, part_s);
            let mut fastest = 0.0_f64;
            for (command, seconds) in [(before, late_s), (next, part_s - late_s)] {
                if seconds > 0.0 {
                    fastest = fastest.max(self.largest_acceleration(command, load));
                    self.go_on(command, load, seconds);
                    fastest = fastest.max(self.largest_acceleration(command, load));
                }
            }
            look(self, fastest);
        }
        self.acted = next;
    }

    /// Advances under a constant net command.
    fn go_on(&mut self, command: Axes, load: &Load, seconds: f64) {
        for (index, axis) in self.model.axes.iter().enumerate() {
            let net = command[index] - load.cutting[index];
            let motor = &mut self.motors[index];
            *motor = axis.moved(*motor, net, load.reference_velocity[index], seconds);
            let play = axis.backlash / 2.0;
            // After a divergence the bounds are not ordered, and the position is NaN.
            let (low, high) = (motor.position - play, motor.position + play);
            self.table[index] = if low <= high { self.table[index].clamp(low, high) } else { f64::NAN };
        }
    }

    /// A bound on the acceleration under a command, pulses/s²: `(|v| + K·(|u − d| + friction))/tau`, for both axes
    /// together. It is not less at any time before the speed is farther from zero.
    fn largest_acceleration(&self, command: Axes, load: &Load) -> f64 {
        let on = |index: usize| {
            let axis = &self.model.axes[index];
            let bits = (command[index] - load.cutting[index]).abs() + axis.friction.coulomb_bits();
            (self.motors[index].velocity.abs() + axis.drive.gain * bits) / axis.drive.time_constant_s
        };
        f64::hypot(on(0), on(1))
    }

    /// The command that acts in this period: rounded, clipped and delayed.
    fn acting(&mut self, command: Axes) -> Axes {
        let command = if self.model.whole_numbers { command.map(f64::round) } else { command };
        let bounded = self.model.limit.map_or(command, |limit| command.map(|u| u.clamp(-limit, limit)));
        self.steps += 1;
        self.saturated += u64::from(bounded != command);
        let delay = self.model.delay_samples.min(MOST_DELAY);
        if delay == 0 {
            return bounded;
        }
        let first = self.late[0];
        self.late.copy_within(1..delay, 0);
        self.late[delay - 1] = bounded;
        first
    }
}

impl Axis {
    /// The motion after `seconds` under a net command of `bits`.
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

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: Drive = Drive { gain: 10.0, time_constant_s: 0.045 };

    fn model() -> PlantModel {
        PlantModel::ideal([DRIVE; 2], 0.004)
    }

    fn run(model: PlantModel, commands: impl IntoIterator<Item = f64>) -> Plant {
        let mut plant = Plant::at_rest(model, Axes::zeros());
        for u in commands {
            plant.step(Axes::new(u, -u), &Load::default());
        }
        plant
    }

    #[test]
    fn saturation_bounds_the_command_and_is_counted() {
        let bounded = run(PlantModel { limit: Some(8.0), ..model() }, [100.0, 8.0, -3.0, -9.0]);
        let same = run(model(), [8.0, 8.0, -3.0, -8.0]);
        assert_eq!(bounded.position(), same.position());
        assert!((bounded.saturation_share() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn delay_shifts_commands() {
        let late = run(PlantModel { delay_samples: 2, ..model() }, [7.0, 3.0, 0.0, 0.0]);
        assert_eq!(late.position(), run(model(), [0.0, 0.0, 7.0, 3.0]).position());
    }

    #[test]
    fn stiction_holds_the_axis_until_the_command_exceeds_it() {
        let mut stuck = model();
        for axis in &mut stuck.axes {
            axis.friction = Friction::Stick { coulomb: 10.0, stiction: 15.0 };
        }
        assert_eq!(run(stuck, [14.9; 50]).position(), Axes::zeros());
        let moving = run(stuck, [15.1; 50]);
        assert_eq!(moving.position(), run(model(), [5.1; 50]).position());
        // A command below the friction lets it come to rest and stay at rest.
        let mut rest = moving.clone();
        for _ in 0..200 {
            rest.step(Axes::new(2.0, -2.0), &Load::default());
        }
        assert_eq!(rest.velocity(), Axes::zeros());
        assert!(rest.position().x > moving.position().x);
    }

    #[test]
    fn reference_friction_opposes_the_reference() {
        let mut model = model();
        model.axes[0].friction = Friction::Reference(4.0);
        let mut plant = Plant::at_rest(model, Axes::zeros());
        let load = Load { reference_velocity: Axes::new(-1.0, 0.0), ..Load::default() };
        plant.step(Axes::zeros(), &load);
        assert_eq!(plant.position().x, run(self::model(), [4.0]).position().x);
    }

    #[test]
    fn table_lags_by_the_backlash_after_a_reversal() {
        let mut model = model();
        model.axes[0].backlash = 0.5;
        let mut plant = Plant::at_rest(model, Axes::zeros());
        let gap = |plant: &Plant| plant.motors[0].position - plant.position().x;
        for _ in 0..30 {
            plant.step(Axes::new(10.0, 0.0), &Load::default());
        }
        assert!((gap(&plant) - 0.25).abs() < 1e-12);
        for _ in 0..100 {
            plant.step(Axes::new(-10.0, 0.0), &Load::default());
        }
        assert!((gap(&plant) + 0.25).abs() < 1e-12);
    }

    #[test]
    fn encoders_count_whole_pulses_and_commands_are_whole_bits() {
        let whole = PlantModel { whole_numbers: true, ..model() };
        let plant = run(whole, [2.4; 10]);
        assert_eq!(plant.position(), run(model(), [2.0; 10]).position());
        assert_eq!(plant.measured(), plant.position().map(f64::round));
    }
}

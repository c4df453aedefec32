//! The two-axis plant: drives, friction, saturation, whole-number encoders and commands, delay, backlash and resonance.

mod axis;
mod friction;
mod resonance;

use super::Axes;
use super::drive::{Drive, DriveMotion};
use axis::Acting;
pub use axis::{Axis, AxisMotion};
pub use friction::{Friction, Presliding};
pub use resonance::Resonance;

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
        Self {
            axes: drives.map(Axis::ideal),
            period_s,
            limit: None,
            whole_numbers: false,
            delay_samples: 0,
            delay_share: 0.0,
        }
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

impl Load {
    /// What acts on an axis under a command.
    fn acting(&self, command: Axes, axis: usize) -> Acting {
        Acting {
            command: command[axis],
            force: self.cutting[axis],
            reference_velocity: self.reference_velocity[axis],
        }
    }
}

/// A plant in motion.
#[derive(Clone, Debug)]
pub struct Plant {
    model: PlantModel,
    motions: [AxisMotion; 2],
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
        let motion = |position| {
            let rest = DriveMotion { position, velocity: 0.0 };
            AxisMotion { motor: rest, table: rest, deflection: 0.0 }
        };
        Self {
            model,
            motions: [motion(position.x), motion(position.y)],
            late: [Axes::zeros(); MOST_DELAY],
            acted: Axes::zeros(),
            steps: 0,
            saturated: 0,
        }
    }

    /// Position by the encoders, pulses.
    #[must_use]
    pub fn measured(&self) -> Axes {
        let [x, y] = self.motions;
        let exact = Axes::new(x.motor.position, y.motor.position);
        if self.model.whole_numbers { exact.map(f64::round) } else { exact }
    }

    /// Position of the table, pulses.
    #[must_use]
    pub fn position(&self) -> Axes {
        let [x, y] = self.motions;
        Axes::new(x.table.position, y.table.position)
    }

    /// Speed of the motors, pulses/s.
    #[must_use]
    pub fn velocity(&self) -> Axes {
        let [x, y] = self.motions;
        Axes::new(x.motor.velocity, y.motor.velocity)
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
            self.motions[index] = axis.after(self.motions[index], &load.acting(command, index), seconds);
        }
    }

    /// A bound on the acceleration under a command, pulses/s², for both axes together.
    fn largest_acceleration(&self, command: Axes, load: &Load) -> f64 {
        let on = |index: usize| {
            self.model.axes[index].largest_acceleration(&self.motions[index], &load.acting(command, index))
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

#[cfg(test)]
mod physics_tests;

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
        let gap = |plant: &Plant| plant.measured().x - plant.position().x;
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

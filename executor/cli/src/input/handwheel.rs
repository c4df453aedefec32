//! Handwheels: converts pulses of a manual pulse generator (MPG) to millimetres.

use keepout_planner::Mm3;

/// The axis that a handwheel turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WheelAxis {
    /// The table's x.
    #[default]
    X,
    /// The table's y.
    Y,
    /// The tool's height.
    Z,
}

/// Distance of one pulse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StepSize {
    /// 0.001 mm.
    Micron,
    /// 0.01 mm.
    Hundredth,
    /// 0.1 mm.
    #[default]
    Tenth,
    /// 1 mm.
    Millimetre,
}

impl StepSize {
    /// All sizes, from small to large.
    pub const ALL: [Self; 4] = [Self::Micron, Self::Hundredth, Self::Tenth, Self::Millimetre];

    /// The size in µm.
    #[must_use]
    pub const fn microns(self) -> i32 {
        match self {
            Self::Micron => 1,
            Self::Hundredth => 10,
            Self::Tenth => 100,
            Self::Millimetre => 1000,
        }
    }

    /// The size as the status line shows it, mm.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Micron => "0.001 mm",
            Self::Hundredth => "0.01 mm",
            Self::Tenth => "0.1 mm",
            Self::Millimetre => "1 mm",
        }
    }

    /// The next larger size. The smallest size follows the largest.
    #[must_use]
    pub const fn next(self) -> Self {
        match self {
            Self::Micron => Self::Hundredth,
            Self::Hundredth => Self::Tenth,
            Self::Tenth => Self::Millimetre,
            Self::Millimetre => Self::Micron,
        }
    }
}

/// A handwheel: converts pulses to the millimetres of
/// [`OperatorInput::turned_mm`](keepout_executor::supervisor::OperatorInput::turned_mm).
///
/// At most [`Self::PULSES_MAX`] pulses of an axis count between two inputs. Further pulses are dropped and
/// not saved, so that the tool does not run on after the hand has stopped. Sums are whole µm, so rounding
/// errors do not add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Handwheel {
    axis: WheelAxis,
    step: StepSize,
    pulses: [i32; 3],
    microns: [i32; 3],
}

impl Handwheel {
    /// Most pulses of an axis that count between two inputs: three times the rate of a quick hand on a
    /// 100-pulse wheel.
    pub const PULSES_MAX: i32 = 10;

    /// The selected axis.
    #[must_use]
    pub fn axis(&self) -> WheelAxis {
        self.axis
    }

    /// The selected step size.
    #[must_use]
    pub fn step(&self) -> StepSize {
        self.step
    }

    /// Selects the next axis.
    pub fn next_axis(&mut self) {
        self.axis = match self.axis {
            WheelAxis::X => WheelAxis::Y,
            WheelAxis::Y => WheelAxis::Z,
            WheelAxis::Z => WheelAxis::X,
        };
    }

    /// Selects a step size. Earlier pulses keep the size that they had.
    pub fn set_step(&mut self, step: StepSize) {
        self.step = step;
    }

    /// Counts pulses of the selected axis.
    pub fn turn(&mut self, pulses: i32) {
        self.turn_axis(self.axis, pulses);
    }

    /// Counts pulses of an axis.
    pub fn turn_axis(&mut self, axis: WheelAxis, pulses: i32) {
        let index = match axis {
            WheelAxis::X => 0,
            WheelAxis::Y => 1,
            WheelAxis::Z => 2,
        };
        let bound = Self::PULSES_MAX;
        let before = self.pulses[index];
        let after = before.saturating_add(pulses).clamp(-bound, bound);
        self.pulses[index] = after;
        // At most twice the bound of these pulses count, so the product does not overflow.
        let counted = (after - before) * self.step.microns();
        let most = bound * StepSize::Millimetre.microns();
        self.microns[index] = (self.microns[index] + counted).clamp(-most, most);
    }

    /// Takes the distance that the wheels were turned since the last call, mm.
    pub fn take_mm(&mut self) -> Mm3 {
        let [x, y, z] = self.microns.map(|microns| f64::from(microns) / 1000.0);
        self.forget();
        Mm3::new(x, y, z)
    }

    /// Drops the pulses since the last call of [`Self::take_mm`].
    pub fn forget(&mut self) {
        self.pulses = [0; 3];
        self.microns = [0; 3];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_become_millimetres_once() {
        let mut wheel = Handwheel::default();
        wheel.set_step(StepSize::Hundredth);
        wheel.turn(3);
        wheel.next_axis();
        wheel.set_step(StepSize::Millimetre);
        wheel.turn(-2);
        wheel.next_axis();
        wheel.turn(1);
        assert_eq!(wheel.take_mm(), Mm3::new(0.03, -2.0, 1.0));
        assert_eq!(wheel.take_mm(), Mm3::ZERO);
        wheel.next_axis();
        assert_eq!(wheel.axis(), WheelAxis::X);
    }

    #[test]
    fn pulses_beyond_the_bound_are_dropped() {
        let mut wheel = Handwheel::default();
        for _ in 0..100 {
            wheel.turn(i32::MAX);
        }
        assert_eq!(wheel.take_mm(), Mm3::new(1.0, 0.0, 0.0));
        assert_eq!(wheel.take_mm(), Mm3::ZERO, "no pulse is saved");
        wheel.turn(i32::MIN);
        wheel.turn_axis(WheelAxis::Y, i32::MIN);
        assert_eq!(wheel.take_mm(), Mm3::new(-1.0, -1.0, 0.0));
    }

    #[test]
    fn many_small_turns_add_up_exactly() {
        let mut wheel = Handwheel::default();
        wheel.set_step(StepSize::Micron);
        let mut random = fastrand::Rng::with_seed(1);
        let (mut pulses, mut microns) = (0, 0.0);
        for _ in 0..1000 {
            let by = random.i32(-5..=5);
            pulses += by;
            wheel.turn(by);
            microns += (wheel.take_mm().x * 1000.0).round();
        }
        assert_eq!(microns, f64::from(pulses));
    }

    #[test]
    fn smallest_step_size_follows_the_largest() {
        assert!(StepSize::ALL.iter().all(|size| size.next().next().next().next() == *size));
    }
}

//! Handwheels: pulses of a manual pulse generator (MPG), as millimetres.

/// The axis that a handwheel turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WheelAxis {
    /// The table's x.
    #[default]
    X,
    /// The table's y.
    Y,
}

/// How far one pulse goes.
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

    /// The size as shown, mm.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Micron => "0.001 mm",
            Self::Hundredth => "0.01 mm",
            Self::Tenth => "0.1 mm",
            Self::Millimetre => "1 mm",
        }
    }

    /// The next larger size; after the largest the smallest.
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

/// A handwheel: pulses in, millimetres for [`OperatorInput::turned_mm`](keepout_executor::supervisor::OperatorInput::turned_mm) out.
///
/// At most [`Self::PULSES_MAX`] pulses of an axis count between two inputs; the rest is dropped, not saved up, so that
/// the tool does not go on after the hand has stopped. Sums are whole µm: no rounding gathers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Handwheel {
    axis: WheelAxis,
    step: StepSize,
    pulses: [i32; 2],
    microns: [i32; 2],
}

impl Handwheel {
    /// Pulses of an axis that count between two inputs: three times what a quick hand gives on a 100-pulse wheel.
    pub const PULSES_MAX: i32 = 10;

    /// The axis that is turned.
    #[must_use]
    pub fn axis(&self) -> WheelAxis {
        self.axis
    }

    /// The size of a step.
    #[must_use]
    pub fn step(&self) -> StepSize {
        self.step
    }

    /// Turns the other axis from now on.
    pub fn swap_axis(&mut self) {
        self.axis = if self.axis == WheelAxis::X { WheelAxis::Y } else { WheelAxis::X };
    }

    /// Steps of another size from now on; what was turned before keeps its own.
    pub fn set_step(&mut self, step: StepSize) {
        self.step = step;
    }

    /// Pulses of the chosen axis.
    pub fn turn(&mut self, pulses: i32) {
        self.turn_axis(self.axis, pulses);
    }

    /// Pulses of an axis.
    pub fn turn_axis(&mut self, axis: WheelAxis, pulses: i32) {
        let index = usize::from(axis == WheelAxis::Y);
        let bound = Self::PULSES_MAX;
        let before = self.pulses[index];
        let after = before.saturating_add(pulses).clamp(-bound, bound);
        self.pulses[index] = after;
        // What counted of these pulses is at most twice the bound, so the sum stays small, whatever the sizes.
        let counted = (after - before) * self.step.microns();
        let most = bound * StepSize::Millimetre.microns();
        self.microns[index] = (self.microns[index] + counted).clamp(-most, most);
    }

    /// How far the wheels were turned since this was last commanded, mm.
    pub fn take_mm(&mut self) -> (f64, f64) {
        let [x, y] = self.microns;
        self.forget();
        (f64::from(x) / 1000.0, f64::from(y) / 1000.0)
    }

    /// Forgets pulses that were not taken.
    pub fn forget(&mut self) {
        self.pulses = [0; 2];
        self.microns = [0; 2];
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
        wheel.swap_axis();
        wheel.set_step(StepSize::Millimetre);
        wheel.turn(-2);
        assert_eq!(wheel.take_mm(), (0.03, -2.0));
        assert_eq!(wheel.take_mm(), (0.0, 0.0));
        wheel.swap_axis();
        assert_eq!(wheel.axis(), WheelAxis::X);
    }

    #[test]
    fn what_is_beyond_the_bound_is_dropped() {
        let mut wheel = Handwheel::default();
        for _ in 0..100 {
            wheel.turn(i32::MAX);
        }
        assert_eq!(wheel.take_mm(), (1.0, 0.0));
        assert_eq!(wheel.take_mm(), (0.0, 0.0), "nothing is saved up");
        wheel.turn(i32::MIN);
        wheel.turn_axis(WheelAxis::Y, i32::MIN);
        assert_eq!(wheel.take_mm(), (-1.0, -1.0));
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
            microns += (wheel.take_mm().0 * 1000.0).round();
        }
        assert_eq!(microns, f64::from(pulses));
    }

    #[test]
    fn sizes_go_round() {
        assert!(StepSize::ALL.iter().all(|size| size.next().next().next().next() == *size));
    }
}

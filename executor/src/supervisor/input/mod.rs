//! The operator's input: the one place that normalises it, applies dead zones and limits its age.
//!
//! Implements SR-21.
//!
//! A device gives raw axes. [`Stick`] turns them into a jog velocity with the dead zone and the response that
//! fit the device. [`OperatorInput::normalised`] bounds every input, from any source. [`Aged`] ignores the
//! last input when it is too old.
//!
//! [`OperatorCommand`]s are events: each counts once.

mod stick;

use std::time::Duration;

use keepout_guard::Time;
use keepout_planner::Mm2;
use serde::{Deserialize, Serialize};
pub use stick::{Stick, StickError, StickSettings};

/// Greatest age of a device's reading. An older reading does not count, because the thread that reads the
/// device hangs.
pub const READING_STALE: Duration = Duration::from_millis(100);
/// Greatest age of an input. Jogging stops on an older input, because the program that gives inputs hangs.
pub const INPUT_STALE: Duration = Duration::from_millis(250);
/// Least deflection that moves the tool, from any source.
const LEAST_DEFLECTION: f64 = 0.03;

/// The jog input of one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatorInput {
    /// Jog velocity as a share of full speed, −1 to 1 in length.
    pub velocity: Mm2,
    /// Turns of the handwheels since the last input, mm.
    pub turned_mm: Mm2,
    /// Speed along the third axis as a share of its full speed, −1 to 1: upward when it is positive.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub up: f64,
    /// Turns of the handwheel of the third axis since the last input, mm.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub turned_up_mm: f64,
    /// Whether the cycle is armed: a contact with the part then starts the contour.
    pub armed: bool,
}

/// Whether a file leaves the number out.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// A command of the operator. Each is an event, and counts once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OperatorCommand {
    /// Feed hold: the contour stops, and can go on later.
    FeedHold,
    /// Cycle start: the contour goes on.
    CycleStart,
    /// Begins again with the controller after a fault.
    Recover,
    /// Raises the tool to the safe height, from anywhere.
    Raise,
    /// Raises the tool, crosses to the contour with this number, and lowers to just above the stock.
    Cross {
        /// The contour's number in the drawing.
        contour: usize,
    },
    /// States whether the spindle runs. Below the top of the stock the tool only goes after this statement.
    Spindle {
        /// Whether it runs.
        runs: bool,
    },
    /// Overrides the feed of contours: 25 to 100 per cent.
    Feed {
        /// The override, per cent.
        percent: u8,
    },
    /// Stops the machine and ends the session.
    Stop,
}

impl OperatorInput {
    /// The input with zero for numbers that are not finite: an event log holds finite numbers only.
    #[must_use]
    pub fn finite(self) -> Self {
        let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
        let velocity = if self.velocity.is_finite() { self.velocity } else { Mm2::ZERO };
        let Mm2 { x, y } = self.turned_mm;
        let (up, turned_up_mm) = (finite(self.up), finite(self.turned_up_mm));
        Self { velocity, turned_mm: Mm2::new(finite(x), finite(y)), up, turned_up_mm, ..self }
    }

    /// Whether a handwheel was turned.
    #[must_use]
    pub fn turns(&self) -> bool {
        self.turned_mm != Mm2::ZERO || self.turned_up_mm != 0.0
    }

    /// The input within its bounds: finite, the velocity at most 1 in length, and zero below the least
    /// deflection.
    #[must_use]
    pub fn normalised(self) -> Self {
        let input = self.finite();
        let length = input.velocity.length();
        let deflected = length.is_finite() && length >= LEAST_DEFLECTION;
        let scale = if deflected { 1.0 / length.max(1.0) } else { 0.0 };
        let up = if input.up.abs() >= LEAST_DEFLECTION { input.up.clamp(-1.0, 1.0) } else { 0.0 };
        Self { velocity: input.velocity * scale, up, ..input }
    }
}

/// The last input and its time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Aged {
    input: OperatorInput,
    at: Option<Time>,
}

impl Aged {
    /// Takes an input and normalises it. Returns the input before it.
    pub(super) fn replace(&mut self, input: OperatorInput, now: Time) -> OperatorInput {
        self.at = Some(now);
        std::mem::replace(&mut self.input, input.normalised())
    }

    /// Whether the operator does not deflect the stick, whatever the age of the input.
    pub(super) fn is_centred(&self) -> bool {
        self.input.velocity == Mm2::ZERO && self.input.up == 0.0
    }

    /// Whether there is no input, or it is too old.
    pub(super) fn is_stale(&self, now: Time) -> bool {
        self.at.is_none_or(|at| now.since(at) > INPUT_STALE)
    }

    /// Time at which the input becomes stale. `None` without an input.
    pub(super) fn stale_at(&self) -> Option<Time> {
        self.at.map(|at| at.after(INPUT_STALE))
    }

    /// The speed along the third axis, as a share. Zero for a stale input.
    pub(super) fn up(&self, now: Time) -> f64 {
        if self.is_stale(now) { 0.0 } else { self.input.up }
    }

    /// The jog velocity. `None` for a centred stick or a stale input.
    pub(super) fn jog_velocity(&self, now: Time) -> Option<Mm2> {
        (!self.is_stale(now) && self.input.velocity != Mm2::ZERO).then_some(self.input.velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_finite_and_bounded() {
        let mut random = fastrand::Rng::with_seed(3);
        let numbers = [0.0, -0.0, f64::NAN, f64::INFINITY, 1e308, 1e-300, 0.029, 0.031];
        for _ in 0..20_000 {
            let mut number = || match random.u8(0..3) {
                0 => numbers[random.usize(0..numbers.len())],
                _ => 4.0 * random.f64() - 2.0,
            };
            let raw = OperatorInput {
                velocity: Mm2::new(number(), number()),
                turned_mm: Mm2::new(number(), number()),
                up: number(),
                turned_up_mm: number(),
                armed: true,
            };
            let input = raw.normalised();
            let length = input.velocity.length();
            assert!(length == 0.0 || (0.03..=1.0 + 1e-12).contains(&length), "{raw:?}");
            assert!(input.turned_mm.is_finite() && input.armed);
            assert!(input.up == 0.0 || (0.03..=1.0).contains(&input.up.abs()), "{raw:?}");
            assert!(input.turned_up_mm.is_finite());
            assert_eq!(input, raw.finite().normalised());
        }
    }

    // Evidence for SR-21.
    #[test]
    fn old_input_does_not_jog() {
        let mut last = Aged::default();
        assert!(last.is_stale(Time::ZERO) && last.jog_velocity(Time::ZERO).is_none());
        last.replace(OperatorInput { velocity: Mm2::new(1.0, 0.0), ..OperatorInput::default() }, Time::ZERO);
        assert_eq!(last.jog_velocity(Time::ZERO.after(INPUT_STALE)), Some(Mm2::new(1.0, 0.0)));
        assert_eq!(last.jog_velocity(Time::ZERO.after(INPUT_STALE + Duration::from_micros(1))), None);
    }
}

//! The enabling interlock: decides which part of a device's reading may move the tool.
//!
//! Implements SR-21.

use std::time::Duration;

use keepout_executor::operator::Panel;
use keepout_executor::supervisor::{OperatorInput, READING_STALE, Stick};

use super::reader::Reading;

/// Converts readings of a device to operator inputs.
///
/// The stick is enabled only after it was centred with the dead-man button released. This condition starts
/// again when the device is plugged in, loses events or goes silent. A stick that is held during such an
/// event does not move the tool.
#[derive(Clone, Debug)]
pub struct EnablingInterlock {
    stick: Stick,
    panel: Panel,
    /// The connection in which the stick was at rest. `None` if it was not.
    rested: Option<u64>,
}

impl EnablingInterlock {
    /// An interlock for a stick that was not at rest yet.
    #[must_use]
    pub fn new(stick: Stick, panel: Panel) -> Self {
        Self { stick, panel, rested: None }
    }

    /// The operator input for a reading of the given `age`. `None` without a device, or if it is silent: the
    /// operator could not stop the tool. A caller that passes a reading again must clear its handwheel turns
    /// first.
    pub fn input(&mut self, reading: &Reading, age: Duration) -> Option<OperatorInput> {
        let stale = age > READING_STALE;
        if stale || !reading.known {
            if stale && self.rested.is_some() {
                self.panel.say(
                    "the device does not answer in time: centre the stick, and release the dead-man button",
                );
            }
            self.rested = None;
            return None;
        }
        if self.stick.rests(reading.axes) && !reading.dead_man {
            self.rested = Some(reading.connection);
        }
        let mut input = OperatorInput { armed: reading.armed, ..OperatorInput::default() };
        if self.rested == Some(reading.connection) {
            input.velocity = self.stick.deflection(reading.axes, reading.dead_man);
            input.up = if reading.dead_man { reading.up } else { 0.0 };
            (input.turned_mm, input.turned_up_mm) = (reading.turned_mm.plane(), reading.turned_mm.z);
        }
        Some(input)
    }
}

#[cfg(test)]
mod tests {
    use keepout_executor::supervisor::StickSettings;
    use keepout_planner::Mm2;

    use super::*;

    const FRESH: Duration = Duration::from_millis(5);

    fn interlock() -> EnablingInterlock {
        let settings = StickSettings { dead_zone: 0.1, expo: 0.0, top: 1.0 };
        EnablingInterlock::new(Stick::new(settings).unwrap(), Panel::default())
    }

    fn reading(x: f64, dead_man: bool) -> Reading {
        Reading { connection: 1, known: true, axes: Mm2::new(x, 0.0), dead_man, ..Reading::default() }
    }

    fn velocity(interlock: &mut EnablingInterlock, reading: &Reading) -> Mm2 {
        interlock.input(reading, FRESH).unwrap().velocity
    }

    // Evidence for SR-21.
    #[test]
    fn stick_held_while_plugged_in_does_not_move_the_tool_until_it_was_at_rest() {
        let mut interlock = interlock();
        let turned = Reading { turned_mm: Mm2::new(1.0, 0.0).at_height(0.0), ..reading(1.0, true) };
        assert_eq!(interlock.input(&turned, FRESH), Some(OperatorInput::default()));
        assert_eq!(
            velocity(&mut interlock, &reading(0.0, true)),
            Mm2::ZERO,
            "centred, but the dead-man button is held"
        );
        assert_eq!(velocity(&mut interlock, &reading(1.0, true)), Mm2::ZERO);
        assert_eq!(velocity(&mut interlock, &reading(1.0, false)), Mm2::ZERO, "released, but not centred");
        assert_eq!(velocity(&mut interlock, &reading(1.0, true)), Mm2::ZERO);
        assert_eq!(velocity(&mut interlock, &reading(0.05, false)), Mm2::ZERO);
        assert_eq!(velocity(&mut interlock, &reading(1.0, true)), Mm2::new(1.0, 0.0));
        assert_eq!(interlock.input(&turned, FRESH).unwrap().turned_mm, Mm2::new(1.0, 0.0));
        let again = Reading { connection: 2, ..reading(1.0, true) };
        assert_eq!(
            velocity(&mut interlock, &again),
            Mm2::ZERO,
            "unplugged and plugged in between two inputs"
        );
    }

    // Evidence for SR-21.
    #[test]
    fn held_stick_is_not_stale_but_a_silent_reader_is() {
        let mut interlock = interlock();
        velocity(&mut interlock, &reading(0.0, false));
        let held = reading(1.0, true);
        for _ in 0..10_000 {
            assert_eq!(interlock.input(&held, READING_STALE).unwrap().velocity, Mm2::new(1.0, 0.0));
        }
        let late = READING_STALE + Duration::from_millis(1);
        assert_eq!(interlock.input(&held, late), None);
        assert_eq!(velocity(&mut interlock, &held), Mm2::ZERO, "no motion before it was at rest again");
    }

    #[test]
    fn without_a_device_there_is_no_input() {
        let mut interlock = interlock();
        let gone = Reading { known: false, armed: true, ..reading(1.0, true) };
        assert_eq!(interlock.input(&gone, FRESH), None);
    }
}

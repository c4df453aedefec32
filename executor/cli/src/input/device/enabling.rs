//! The enabling interlock: decides which part of a device's reading may move the tool.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_executor::operator::Panel;
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};

use super::reader::Reading;
use crate::input::stick::Stick;

/// Greatest age of a reading. An older reading does not count, because the thread that reads the device
/// hangs.
pub const STALE_AFTER: Duration = Duration::from_millis(100);
/// Most commands that wait for an input.
const COMMANDS_MAX: usize = 8;

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
    commands: VecDeque<OperatorCommand>,
    /// Command of the last input.
    commanded: Option<OperatorCommand>,
    quit: bool,
}

impl EnablingInterlock {
    /// An interlock for a stick that was not at rest yet.
    #[must_use]
    pub fn new(stick: Stick, panel: Panel) -> Self {
        Self { stick, panel, rested: None, commands: VecDeque::new(), commanded: None, quit: false }
    }

    /// The operator input for a reading of the given `age`. A caller that passes a reading again must clear
    /// its handwheel turns and its commands first.
    ///
    /// Without a device the tool does not move. A contour gets a feed hold, because the operator could not
    /// stop it.
    pub fn input(&mut self, reading: &Reading, age: Duration, phase: Phase) -> OperatorInput {
        self.keep(&reading.commands);
        let stale = age > STALE_AFTER;
        if stale || !reading.known {
            if stale && self.rested.is_some() {
                self.panel.say(
                    "the device does not answer in time: centre the stick, and release the dead-man button",
                );
            }
            self.rested = None;
            let pause = (phase == Phase::Contouring).then_some(OperatorCommand::FeedHold);
            let command = self.next_command().or(pause);
            return OperatorInput { command, ..OperatorInput::default() };
        }
        if self.stick.rests(reading.axes) && !reading.dead_man {
            self.rested = Some(reading.connection);
        }
        let mut input = OperatorInput {
            automatic: reading.automatic,
            command: self.next_command(),
            ..OperatorInput::default()
        };
        if self.rested == Some(reading.connection) {
            input.velocity = self.stick.deflection(reading.axes, reading.dead_man);
            input.turned_mm = reading.turned_mm;
        }
        input
    }

    fn keep(&mut self, commands: &[OperatorCommand]) {
        for &command in commands {
            self.quit |= command == OperatorCommand::Stop;
            if self.commands.len() < COMMANDS_MAX {
                self.commands.push_back(command);
            }
        }
    }

    /// The command of this input: one at a time. Between two equal commands, one input has no command, so
    /// that the supervisor counts both. The stop command stays.
    fn next_command(&mut self) -> Option<OperatorCommand> {
        let repeated = self.commanded.is_some() && self.commands.front() == self.commanded.as_ref();
        let next = if repeated { None } else { self.commands.pop_front() };
        self.commanded = if self.quit { Some(OperatorCommand::Stop) } else { next };
        self.commanded
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::stick::StickSettings;

    const FRESH: Duration = Duration::from_millis(5);

    fn interlock() -> EnablingInterlock {
        let settings = StickSettings { dead_zone: 0.1, expo: 0.0, top: 1.0 };
        EnablingInterlock::new(Stick::new(settings).unwrap(), Panel::default())
    }

    fn reading(x: f64, dead_man: bool) -> Reading {
        Reading { connection: 1, known: true, axes: (x, 0.0), dead_man, ..Reading::default() }
    }

    fn velocity(interlock: &mut EnablingInterlock, reading: &Reading) -> (f64, f64) {
        interlock.input(reading, FRESH, Phase::Manual).velocity
    }

    #[test]
    fn stick_held_while_plugged_in_does_not_move_the_tool_until_it_was_at_rest() {
        let mut interlock = interlock();
        let turned = Reading { turned_mm: (1.0, 0.0), ..reading(1.0, true) };
        assert_eq!(interlock.input(&turned, FRESH, Phase::Manual), OperatorInput::default());
        assert_eq!(
            velocity(&mut interlock, &reading(0.0, true)),
            (0.0, 0.0),
            "centred, but the dead-man button is held"
        );
        assert_eq!(velocity(&mut interlock, &reading(1.0, true)), (0.0, 0.0));
        assert_eq!(velocity(&mut interlock, &reading(1.0, false)), (0.0, 0.0), "released, but not centred");
        assert_eq!(velocity(&mut interlock, &reading(1.0, true)), (0.0, 0.0));
        assert_eq!(velocity(&mut interlock, &reading(0.05, false)), (0.0, 0.0));
        assert_eq!(velocity(&mut interlock, &reading(1.0, true)), (1.0, 0.0));
        assert_eq!(interlock.input(&turned, FRESH, Phase::Manual).turned_mm, (1.0, 0.0));
        let again = Reading { connection: 2, ..reading(1.0, true) };
        assert_eq!(
            velocity(&mut interlock, &again),
            (0.0, 0.0),
            "unplugged and plugged in between two inputs"
        );
    }

    #[test]
    fn held_stick_is_not_stale_but_a_silent_reader_is() {
        let mut interlock = interlock();
        velocity(&mut interlock, &reading(0.0, false));
        let held = reading(1.0, true);
        for _ in 0..10_000 {
            assert_eq!(interlock.input(&held, STALE_AFTER, Phase::Manual).velocity, (1.0, 0.0));
        }
        let late = STALE_AFTER + Duration::from_millis(1);
        assert_eq!(interlock.input(&held, late, Phase::Manual), OperatorInput::default());
        assert_eq!(velocity(&mut interlock, &held), (0.0, 0.0), "no motion before it was at rest again");
    }

    #[test]
    fn without_a_device_a_contour_gets_a_feed_hold() {
        let mut interlock = interlock();
        let gone = Reading { known: false, automatic: true, ..reading(1.0, true) };
        let input = interlock.input(&gone, FRESH, Phase::Contouring);
        assert_eq!(
            input,
            OperatorInput { command: Some(OperatorCommand::FeedHold), ..OperatorInput::default() }
        );
        assert_eq!(interlock.input(&gone, FRESH, Phase::Manual), OperatorInput::default());
    }

    #[test]
    fn commands_come_one_by_one_and_stop_stays() {
        let mut interlock = interlock();
        let commands =
            vec![OperatorCommand::FeedHold, OperatorCommand::FeedHold, OperatorCommand::CycleStart];
        let all = Reading { commands, ..reading(0.0, false) };
        let mut issued = vec![interlock.input(&all, FRESH, Phase::Manual).command];
        issued.extend((0..4).map(|_| interlock.input(&reading(0.0, false), FRESH, Phase::Manual).command));
        assert_eq!(
            issued,
            [
                Some(OperatorCommand::FeedHold),
                None,
                Some(OperatorCommand::FeedHold),
                Some(OperatorCommand::CycleStart),
                None
            ]
        );
        let quit = Reading { commands: vec![OperatorCommand::Stop], ..reading(0.0, false) };
        interlock.input(&quit, FRESH, Phase::Manual);
        assert_eq!(
            interlock.input(&reading(0.0, false), FRESH, Phase::Manual).command,
            Some(OperatorCommand::Stop)
        );
    }
}

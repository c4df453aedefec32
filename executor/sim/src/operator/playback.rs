//! Plays inputs at their times, and loses none between two calls.

use std::time::Duration;

use keepout_executor::supervisor::{OperatorCommand, OperatorInput};
use keepout_planner::Mm2;

/// An input, and a command that the operator gives with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Step {
    /// Time since the beginning.
    pub(super) at: Duration,
    pub(super) input: OperatorInput,
    pub(super) command: Option<OperatorCommand>,
}

/// The steps of an operator; their times do not decrease.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Playback {
    steps: Vec<Step>,
    /// The number of played steps.
    played: usize,
    /// Command of the last played step, until it is taken.
    command: Option<OperatorCommand>,
}

impl Playback {
    pub(super) fn new(steps: Vec<Step>) -> Self {
        Self { steps, played: 0, command: None }
    }

    /// Whether every step was played.
    pub(super) fn over(&self) -> bool {
        self.played == self.steps.len()
    }

    #[cfg(test)]
    pub(super) fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The input at a time; the default input before the first.
    ///
    /// The velocity is that of the last step. Turns of the steps since the last call are summed, and given
    /// once. A step with a command, or one that changes the armed state, is never skipped: the later steps
    /// wait for the next call.
    pub(super) fn at(&mut self, time: Duration) -> OperatorInput {
        let before = self.current();
        let (mut turned_mm, mut turned_up_mm) = (Mm2::ZERO, 0.0);
        while let Some(&Step { at, input, command }) = self.steps.get(self.played)
            && at <= time
        {
            self.played += 1;
            turned_mm += input.turned_mm;
            turned_up_mm += input.turned_up_mm;
            self.command = command;
            let next = self.steps.get(self.played);
            let command_follows = next.is_some_and(|next| next.at == at && next.command.is_some());
            if command.is_some() || input.armed != before.armed && !command_follows {
                break;
            }
        }
        OperatorInput { turned_mm, turned_up_mm, ..self.current() }
    }

    /// Whether a command waits.
    pub(super) fn has_command(&self) -> bool {
        self.command.is_some()
    }

    /// Takes the command of the last played step.
    pub(super) fn command(&mut self) -> Option<OperatorCommand> {
        self.command.take()
    }

    /// Stops the session.
    pub(super) fn stop(&mut self) -> OperatorInput {
        self.command = Some(OperatorCommand::Stop);
        OperatorInput::default()
    }

    fn current(&self) -> OperatorInput {
        self.played.checked_sub(1).map_or(OperatorInput::default(), |last| self.steps[last].input)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(millis: u64) -> Duration {
        Duration::from_millis(millis)
    }

    #[test]
    fn turns_are_given_once_and_commands_are_not_skipped() {
        let turn = |at, x| {
            let input = OperatorInput { turned_mm: Mm2::new(x, 0.0), ..OperatorInput::default() };
            Step { at: ms(at), input, command: None }
        };
        let hold = Some(OperatorCommand::FeedHold);
        let steps = vec![
            turn(10, 1.0),
            turn(11, 2.0),
            Step { command: hold, ..turn(12, 0.0) },
            Step { command: hold, ..turn(14, 0.0) },
            turn(15, 4.0),
        ];
        let mut playback = Playback::new(steps);
        assert_eq!(playback.at(ms(0)), OperatorInput::default());
        let played: Vec<_> = (0..4).map(|_| (playback.at(ms(100)).turned_mm.x, playback.command())).collect();
        assert_eq!(played, [(3.0, hold), (0.0, hold), (4.0, None), (0.0, None)]);
        assert!(playback.over());
    }
}

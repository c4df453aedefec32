//! Plays inputs at their times, and loses none between two calls.

use std::time::Duration;

use keepout_executor::supervisor::OperatorInput;

/// Inputs, each with its time since the beginning; times do not decrease.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Playback {
    steps: Vec<(Duration, OperatorInput)>,
    /// The number of played inputs.
    played: usize,
}

impl Playback {
    pub(super) fn new(steps: Vec<(Duration, OperatorInput)>) -> Self {
        Self { steps, played: 0 }
    }

    /// Whether every input was played.
    pub(super) fn over(&self) -> bool {
        self.played == self.steps.len()
    }

    #[cfg(test)]
    pub(super) fn steps(&self) -> &[(Duration, OperatorInput)] {
        &self.steps
    }

    /// The input at a time; the default input before the first.
    ///
    /// The velocity is that of the last step. Turns of the steps since the last call are summed, and given
    /// once. A step that changes the command or the armed state is never skipped: the later steps wait for
    /// the next call.
    pub(super) fn at(&mut self, time: Duration) -> OperatorInput {
        let before = self.current();
        let mut turned_mm = (0.0, 0.0);
        while let Some(&(at, step)) = self.steps.get(self.played)
            && at <= time
        {
            self.played += 1;
            turned_mm = (turned_mm.0 + step.turned_mm.0, turned_mm.1 + step.turned_mm.1);
            if (step.command, step.automatic) != (before.command, before.automatic) {
                break;
            }
        }
        OperatorInput { turned_mm, ..self.current() }
    }

    fn current(&self) -> OperatorInput {
        self.played.checked_sub(1).map_or(OperatorInput::default(), |last| self.steps[last].1)
    }
}

#[cfg(test)]
mod tests {
    use keepout_executor::supervisor::OperatorCommand;

    use super::*;

    fn ms(millis: u64) -> Duration {
        Duration::from_millis(millis)
    }

    #[test]
    fn turns_are_given_once_and_commands_are_not_skipped() {
        let turn = |x| OperatorInput { turned_mm: (x, 0.0), ..OperatorInput::default() };
        let command = |command| OperatorInput { command: Some(command), ..OperatorInput::default() };
        let steps = vec![
            (ms(10), turn(1.0)),
            (ms(11), turn(2.0)),
            (ms(12), command(OperatorCommand::FeedHold)),
            (ms(13), OperatorInput::default()),
            (ms(14), command(OperatorCommand::FeedHold)),
            (ms(15), turn(4.0)),
        ];
        let mut playback = Playback::new(steps);
        assert_eq!(playback.at(ms(0)), OperatorInput::default());
        let played: Vec<OperatorInput> = (0..5).map(|_| playback.at(ms(100))).collect();
        let commands: Vec<_> = played.iter().map(|input| input.command).collect();
        assert_eq!(
            commands,
            [Some(OperatorCommand::FeedHold), None, Some(OperatorCommand::FeedHold), None, None]
        );
        let turned: Vec<f64> = played.iter().map(|input| input.turned_mm.0).collect();
        assert_eq!(turned, [3.0, 0.0, 0.0, 4.0, 0.0]);
        assert!(playback.over());
    }
}

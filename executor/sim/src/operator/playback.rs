//! Plays wishes at their times, so that nothing is lost between two looks.

use std::time::Duration;

use keepout_executor::supervisor::Wish;

/// Wishes, each with its time since the beginning; times do not go back.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Playback {
    steps: Vec<(Duration, Wish)>,
    /// How many were played.
    played: usize,
}

impl Playback {
    pub(super) fn new(steps: Vec<(Duration, Wish)>) -> Self {
        Self { steps, played: 0 }
    }

    /// Whether every wish was played.
    pub(super) fn over(&self) -> bool {
        self.played == self.steps.len()
    }

    #[cfg(test)]
    pub(super) fn steps(&self) -> &[(Duration, Wish)] {
        &self.steps
    }

    /// The wish at a time; no wish before the first.
    ///
    /// The direction is that of the last step. Turns of the steps since the last call are summed, and are given once.
    /// A step that asks for something else than the one before, or that changes automatic mode, is never passed over:
    /// the steps after it wait for the next call.
    pub(super) fn at(&mut self, time: Duration) -> Wish {
        let before = self.current();
        let mut turned_mm = (0.0, 0.0);
        while let Some(&(at, step)) = self.steps.get(self.played)
            && at <= time
        {
            self.played += 1;
            turned_mm = (turned_mm.0 + step.turned_mm.0, turned_mm.1 + step.turned_mm.1);
            if (step.ask, step.automatic) != (before.ask, before.automatic) {
                break;
            }
        }
        Wish { turned_mm, ..self.current() }
    }

    fn current(&self) -> Wish {
        self.played.checked_sub(1).map_or(Wish::default(), |last| self.steps[last].1)
    }
}

#[cfg(test)]
mod tests {
    use keepout_executor::supervisor::Ask;

    use super::*;

    fn ms(millis: u64) -> Duration {
        Duration::from_millis(millis)
    }

    #[test]
    fn turns_are_given_once_and_asks_are_not_passed_over() {
        let turn = |x| Wish { turned_mm: (x, 0.0), ..Wish::default() };
        let ask = |ask| Wish { ask: Some(ask), ..Wish::default() };
        let steps = vec![
            (ms(10), turn(1.0)),
            (ms(11), turn(2.0)),
            (ms(12), ask(Ask::Pause)),
            (ms(13), Wish::default()),
            (ms(14), ask(Ask::Pause)),
            (ms(15), turn(4.0)),
        ];
        let mut playback = Playback::new(steps);
        assert_eq!(playback.at(ms(0)), Wish::default());
        let played: Vec<Wish> = (0..5).map(|_| playback.at(ms(100))).collect();
        let asks: Vec<_> = played.iter().map(|wish| wish.ask).collect();
        assert_eq!(asks, [Some(Ask::Pause), None, Some(Ask::Pause), None, None]);
        let turned: Vec<f64> = played.iter().map(|wish| wish.turned_mm.0).collect();
        assert_eq!(turned, [3.0, 0.0, 0.0, 4.0, 0.0]);
        assert!(playback.over());
    }
}

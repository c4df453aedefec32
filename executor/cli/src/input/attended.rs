//! Operators around an operator: an attendant at the keyboard, and a flag that ends the session in order.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput};
use keepout_guard::Time;

use super::terminal::Keyboard;

/// A person who can stop the motion of another operator.
pub trait Attendant: Operator {
    /// Whether the attendant requests standstill.
    fn stopped(&self) -> bool;
}

impl Attendant for Keyboard {
    fn stopped(&self) -> bool {
        Self::stopped(self)
    }
}

/// An operator with an attendant. The attendant gives commands and stops the motion, but does not jog.
pub struct Attended<O, A> {
    operator: O,
    attendant: A,
}

impl<O: Operator, A: Attendant> Attended<O, A> {
    /// Combines the `operator`, who jogs, with the `attendant`, who watches.
    pub fn new(operator: O, attendant: A) -> Self {
        Self { operator, attendant }
    }
}

impl<O: Operator, A: Attendant> Operator for Attended<O, A> {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        let input = self.operator.input(view, now);
        self.attendant.input(view, now);
        if self.attendant.stopped() {
            OperatorInput { armed: input.armed, ..OperatorInput::default() }
        } else {
            input
        }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.attendant.command().or_else(|| self.operator.command())
    }

    fn every(&self) -> Duration {
        self.operator.every()
    }
}

/// An operator who stops the session when a flag is set, by a signal or by another thread.
pub struct Endable<O> {
    operator: O,
    end: Arc<AtomicBool>,
}

impl<O: Operator> Endable<O> {
    /// Passes the input of `operator` on until `end` is set.
    pub fn new(operator: O, end: Arc<AtomicBool>) -> Self {
        Self { operator, end }
    }
}

impl<O: Operator> Operator for Endable<O> {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        let input = self.operator.input(view, now);
        if self.end.load(Ordering::Relaxed) { OperatorInput::default() } else { input }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        if self.end.load(Ordering::Relaxed) { Some(OperatorCommand::Stop) } else { self.operator.command() }
    }

    fn every(&self) -> Duration {
        self.operator.every()
    }
}

#[cfg(test)]
mod tests {
    use keepout_executor::supervisor::Phase;
    use keepout_planner::Mm2;

    use super::*;
    use crate::input::testing::{Scripted, view};

    /// An attendant who gives a feed hold at each input.
    struct Watching {
        stopped: bool,
    }

    impl Operator for Watching {
        fn input(&mut self, _: &OperatorView, _: Time) -> OperatorInput {
            OperatorInput { velocity: Mm2::new(0.0, 1.0), ..OperatorInput::default() }
        }

        fn command(&mut self) -> Option<OperatorCommand> {
            Some(OperatorCommand::FeedHold)
        }
    }

    impl Attendant for Watching {
        fn stopped(&self) -> bool {
            self.stopped
        }
    }

    #[test]
    fn attendant_stops_and_commands_but_does_not_jog() {
        let jogged = OperatorInput { velocity: Mm2::new(1.0, 0.0), armed: true, ..OperatorInput::default() };
        let with = |stopped| {
            let mut both = Attended::new(Scripted::new(vec![jogged]), Watching { stopped });
            (both.input(&view(Phase::Manual), Time::ZERO), both.command())
        };
        assert_eq!(with(false), (jogged, Some(OperatorCommand::FeedHold)));
        let still = OperatorInput { armed: true, ..OperatorInput::default() };
        assert_eq!(with(true), (still, Some(OperatorCommand::FeedHold)));
    }

    #[test]
    fn set_flag_stops_the_session() {
        let end = Arc::new(AtomicBool::new(false));
        let mut operator = Endable::new(Scripted::new(vec![OperatorInput::default(); 2]), Arc::clone(&end));
        operator.input(&view(Phase::Manual), Time::ZERO);
        assert_eq!(operator.command(), None);
        end.store(true, Ordering::Relaxed);
        operator.input(&view(Phase::Manual), Time::ZERO);
        assert_eq!(operator.command(), Some(OperatorCommand::Stop));
    }
}

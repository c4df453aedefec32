//! Operators around an operator: an attendant at the keyboard, and a flag that ends the session in order.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::OperatorInput;
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
        let mut input = self.operator.input(view, now);
        let attendant = self.attendant.input(view, now);
        if self.attendant.stopped() {
            input = OperatorInput { velocity: (0.0, 0.0), turned_mm: (0.0, 0.0), ..input };
        }
        OperatorInput { command: attendant.command.or(input.command), ..input }
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
        if self.end.load(Ordering::Relaxed) { OperatorInput::STOP } else { self.operator.input(view, now) }
    }
}

#[cfg(test)]
mod tests {
    use keepout_executor::supervisor::{OperatorCommand, Phase};

    use super::*;
    use crate::input::testing::{Scripted, view};

    struct Watching(OperatorInput, bool);

    impl Operator for Watching {
        fn input(&mut self, _: &OperatorView, _: Time) -> OperatorInput {
            self.0
        }
    }

    impl Attendant for Watching {
        fn stopped(&self) -> bool {
            self.1
        }
    }

    #[test]
    fn attendant_stops_and_commands_but_does_not_jog() {
        let jogged = OperatorInput { velocity: (1.0, 0.0), automatic: true, ..OperatorInput::default() };
        let pause = OperatorInput {
            velocity: (0.0, 1.0),
            command: Some(OperatorCommand::FeedHold),
            ..OperatorInput::default()
        };
        let with = |stopped| {
            let operator = Scripted::new(vec![jogged]);
            Attended::new(operator, Watching(pause, stopped)).input(&view(Phase::Manual), Time::ZERO)
        };
        assert_eq!(with(false), OperatorInput { command: Some(OperatorCommand::FeedHold), ..jogged });
        assert_eq!(
            with(true),
            OperatorInput {
                command: Some(OperatorCommand::FeedHold),
                automatic: true,
                ..OperatorInput::default()
            }
        );
    }

    #[test]
    fn set_flag_stops_the_session() {
        let end = Arc::new(AtomicBool::new(false));
        let mut operator = Endable::new(Scripted::new(vec![OperatorInput::default(); 2]), Arc::clone(&end));
        assert_eq!(operator.input(&view(Phase::Manual), Time::ZERO), OperatorInput::default());
        end.store(true, Ordering::Relaxed);
        assert_eq!(operator.input(&view(Phase::Manual), Time::ZERO), OperatorInput::STOP);
    }
}

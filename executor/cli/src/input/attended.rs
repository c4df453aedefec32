//! A second pair of hands: keys beside whatever steers, and the signal that ends the session in order.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use keepout_executor::operator::{Operator, Seen};
use keepout_executor::supervisor::Wish;
use keepout_guard::Time;

use super::terminal::Keyboard;

/// Somebody who can stop what another operator does.
pub trait Attendant: Operator {
    /// Whether everything is to stand still.
    fn stopped(&self) -> bool;
}

impl Attendant for Keyboard {
    fn stopped(&self) -> bool {
        Self::stopped(self)
    }
}

/// An operator with an attendant, who asks and stops but does not steer.
pub struct Attended<O, A> {
    operator: O,
    attendant: A,
}

impl<O: Operator, A: Attendant> Attended<O, A> {
    /// `operator` steers, `attendant` watches.
    pub fn new(operator: O, attendant: A) -> Self {
        Self { operator, attendant }
    }
}

impl<O: Operator, A: Attendant> Operator for Attended<O, A> {
    fn wish(&mut self, seen: &Seen, now: Time) -> Wish {
        let mut wish = self.operator.wish(seen, now);
        let attendant = self.attendant.wish(seen, now);
        if self.attendant.stopped() {
            wish = Wish { direction: (0.0, 0.0), turned_mm: (0.0, 0.0), ..wish };
        }
        Wish { ask: attendant.ask.or(wish.ask), ..wish }
    }
}

/// An operator who quits once a flag is up: a signal's, or another thread's.
pub struct Endable<O> {
    operator: O,
    end: Arc<AtomicBool>,
}

impl<O: Operator> Endable<O> {
    /// `operator`, until `end` is up.
    pub fn new(operator: O, end: Arc<AtomicBool>) -> Self {
        Self { operator, end }
    }
}

impl<O: Operator> Operator for Endable<O> {
    fn wish(&mut self, seen: &Seen, now: Time) -> Wish {
        if self.end.load(Ordering::Relaxed) { Wish::QUIT } else { self.operator.wish(seen, now) }
    }
}

#[cfg(test)]
mod tests {
    use keepout_executor::supervisor::{Ask, Phase};

    use super::*;
    use crate::input::testing::{Told, seen};

    struct Watching(Wish, bool);

    impl Operator for Watching {
        fn wish(&mut self, _: &Seen, _: Time) -> Wish {
            self.0
        }
    }

    impl Attendant for Watching {
        fn stopped(&self) -> bool {
            self.1
        }
    }

    #[test]
    fn the_attendant_stops_and_asks_but_does_not_steer() {
        let steered = Wish { direction: (1.0, 0.0), automatic: true, ..Wish::default() };
        let pause = Wish { direction: (0.0, 1.0), ask: Some(Ask::Pause), ..Wish::default() };
        let with = |stopped| {
            let told = Told::new(vec![steered]);
            Attended::new(told, Watching(pause, stopped)).wish(&seen(Phase::Manual), Time::ZERO)
        };
        assert_eq!(with(false), Wish { ask: Some(Ask::Pause), ..steered });
        assert_eq!(with(true), Wish { ask: Some(Ask::Pause), automatic: true, ..Wish::default() });
    }

    #[test]
    fn the_flag_ends_it() {
        let end = Arc::new(AtomicBool::new(false));
        let mut operator = Endable::new(Told::new(vec![Wish::default(); 2]), Arc::clone(&end));
        assert_eq!(operator.wish(&seen(Phase::Manual), Time::ZERO), Wish::default());
        end.store(true, Ordering::Relaxed);
        assert_eq!(operator.wish(&seen(Phase::Manual), Time::ZERO), Wish::QUIT);
    }
}

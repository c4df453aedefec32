//! Sources of time: the computer's clock, and a virtual one for simulations.

use std::time::{Duration, Instant};

use keepout_guard::Time;

/// A source of time.
pub trait Clock {
    /// The time now.
    fn now(&mut self) -> Time;
    /// Waits for the next event, until `until` at the latest.
    fn wait(&mut self, until: Time);
    /// Whether this is real time. The session then runs the planner in a thread of its own.
    fn is_real(&self) -> bool;
}

/// The computer's monotonic clock.
#[derive(Debug)]
pub struct RealClock {
    began: Instant,
}

impl Default for RealClock {
    fn default() -> Self {
        Self { began: Instant::now() }
    }
}

impl Clock for RealClock {
    fn now(&mut self) -> Time {
        Time::ZERO.after(self.began.elapsed())
    }

    fn wait(&mut self, until: Time) {
        let left = until.since(self.now());
        std::thread::sleep(left.min(Duration::from_micros(500)));
    }

    fn is_real(&self) -> bool {
        true
    }
}

/// A clock that advances only in [`Clock::wait`].
#[derive(Debug, Default)]
pub struct VirtualClock {
    now: Time,
}

impl Clock for VirtualClock {
    fn now(&mut self) -> Time {
        self.now
    }

    fn wait(&mut self, until: Time) {
        self.now = until.max(self.now.after(Duration::from_micros(1)));
    }

    fn is_real(&self) -> bool {
        false
    }
}

impl<C: Clock> Clock for &mut C {
    fn now(&mut self) -> Time {
        (**self).now()
    }

    fn wait(&mut self, until: Time) {
        (**self).wait(until);
    }

    fn is_real(&self) -> bool {
        (**self).is_real()
    }
}

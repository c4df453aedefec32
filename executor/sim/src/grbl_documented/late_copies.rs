//! A bridge that repeats some lines late, and a controller that rejects their first copies.
//!
//! GRBL rejects a jog with `error:8` while it still counts a motion as programmed. A bridge over a network may repeat
//! a chunk. Together, a line is rejected, and accepted some time later. The link keeps the order: what the host sends
//! meanwhile arrives behind the copy, at once.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_guard::Time;

/// Time of a byte at 115200 baud.
const BYTE: Duration = Duration::from_micros(87);

/// The copies under way.
#[derive(Clone, Debug)]
pub(super) struct LateCopies {
    random: fastrand::Rng,
    copy: Option<(Time, Vec<u8>)>,
    /// Bytes behind the copy, and the arrival of the first.
    behind: VecDeque<u8>,
    next: Time,
    /// The next line is a copy, and is not rejected.
    accepts: bool,
}

impl LateCopies {
    pub fn of(seed: u64) -> Self {
        Self {
            random: fastrand::Rng::with_seed(seed),
            copy: None,
            behind: VecDeque::new(),
            next: Time::ZERO,
            accepts: false,
        }
    }

    /// The arrival of the next copy.
    pub fn due(&self) -> Time {
        match &self.copy {
            Some((due, _)) => *due,
            None if self.behind.is_empty() => Time::NEVER,
            None => self.next,
        }
    }

    /// Holds a byte that arrives behind the copy. Returns whether there is one.
    pub fn holds(&mut self, byte: u8) -> bool {
        let holds = self.copy.is_some() || !self.behind.is_empty();
        self.behind.extend(holds.then_some(byte));
        holds
    }

    /// Takes the next byte from behind the copy.
    pub fn next_byte(&mut self, now: Time) -> Option<u8> {
        if self.copy.is_some() || self.next > now {
            return None;
        }
        self.next = now.after(BYTE);
        self.behind.pop_front()
    }

    /// Whether the controller rejects this line. Its copy then comes 1 ms to 200 ms later.
    pub fn rejects(&mut self, line: &[u8], now: Time) -> bool {
        if std::mem::take(&mut self.accepts) || self.due() != Time::NEVER || self.random.u8(0..12) != 0 {
            return false;
        }
        let late = Duration::from_secs_f64(0.001 * 200.0_f64.powf(self.random.f64()));
        self.copy = Some((now.after(late), line.to_vec()));
        true
    }

    /// Takes the copy that has arrived.
    pub fn take(&mut self, now: Time) -> Option<Vec<u8>> {
        let (_, line) = self.copy.take_if(|(due, _)| *due <= now)?;
        (self.accepts, self.next) = (true, now.after(BYTE));
        Some(line)
    }
}

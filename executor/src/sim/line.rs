//! One direction of a serial line: bytes leave at the baud rate and arrive after a latency.

use std::collections::VecDeque;
use std::time::Duration;

use crate::time::Time;

/// One direction of a serial line, in order and without loss.
#[derive(Clone, Debug)]
pub struct Wire {
    byte: Duration,
    latency: Duration,
    free_at: Time,
    under_way: VecDeque<(Time, u8)>,
}

impl Wire {
    /// A line at `baud` bits per second, ten bits a byte, that delivers `latency` later.
    #[must_use]
    pub fn new(baud: u32, latency: Duration) -> Self {
        let byte = Duration::from_secs(10) / baud.max(1);
        Self { byte, latency, free_at: Time::ZERO, under_way: VecDeque::new() }
    }

    /// Puts bytes on the line.
    pub fn send(&mut self, bytes: &[u8], now: Time) {
        for &byte in bytes {
            self.free_at = self.free_at.max(now).after(self.byte);
            self.under_way.push_back((self.free_at.after(self.latency), byte));
        }
    }

    /// Takes the next byte that has arrived by `now`, with the moment it did.
    pub fn receive(&mut self, now: Time) -> Option<(Time, u8)> {
        match self.under_way.front() {
            Some(&(at, _)) if at <= now => self.under_way.pop_front(),
            _ => None,
        }
    }

    /// When the next byte arrives.
    #[must_use]
    pub fn next_arrival(&self) -> Option<Time> {
        self.under_way.front().map(|&(at, _)| at)
    }
}

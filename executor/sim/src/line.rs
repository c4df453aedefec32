//! One direction of a serial line: bytes leave at the baud rate and arrive after a latency.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_guard::Time;

use crate::faults::{Fate, Faults};

/// Most bytes on the line. Further bytes are lost, as in a full driver.
const BYTES_MAX: usize = 65_536;

/// One direction of a serial line. It keeps the order and loses no byte unless it is impaired.
#[derive(Clone, Debug)]
pub struct Wire {
    byte: Duration,
    latency: Duration,
    free_at: Time,
    arrived_at: Time,
    under_way: VecDeque<(Time, u8)>,
    /// Bytes of the last chunk.
    last_chunk: usize,
    faults: Option<Faults>,
}

impl Wire {
    /// A line at `baud` bits per second, ten bits per byte, with a delay of `latency`.
    #[must_use]
    pub fn new(baud: u32, latency: Duration) -> Self {
        let byte = Duration::from_secs(10) / baud.max(1);
        Self {
            byte,
            latency,
            free_at: Time::ZERO,
            arrived_at: Time::ZERO,
            under_way: VecDeque::new(),
            last_chunk: 0,
            faults: None,
        }
    }

    /// Adds faults to the line.
    #[must_use]
    pub fn hurt(self, faults: Faults) -> Self {
        Self { faults: Some(faults), ..self }
    }

    /// The faults of the line.
    pub fn faults(&mut self) -> Option<&mut Faults> {
        self.faults.as_mut()
    }

    /// Puts a chunk on the line.
    pub fn send(&mut self, bytes: &[u8], now: Time) {
        let Some(mut faults) = self.faults.take() else {
            bytes.iter().for_each(|&byte| self.put(byte, now));
            return;
        };
        faults.piece();
        let lie = faults.lie(bytes);
        let bytes = lie.as_deref().unwrap_or(bytes);
        if let Some(noise) = faults.noise() {
            self.put(noise, now);
        }
        let held_up = faults.delay();
        self.arrived_at = self.arrived_at.max(now).after(held_up);
        let fate = faults.fate();
        let before = self.under_way.len();
        let times = match fate {
            Fate::Lost => 0,
            Fate::Doubled => 2,
            Fate::Arrives | Fate::Swapped => 1,
        };
        for _ in 0..times {
            for &byte in bytes {
                if let Some(byte) = faults.hurt(byte) {
                    self.put(byte, now);
                }
            }
        }
        if fate == Fate::Swapped && self.last_chunk <= before {
            self.swap(before - self.last_chunk, before);
        }
        self.last_chunk = self.under_way.len().saturating_sub(before);
        self.faults = Some(faults);
    }

    fn put(&mut self, byte: u8, now: Time) {
        self.free_at = self.free_at.max(now).after(self.byte);
        self.arrived_at = self.arrived_at.max(self.free_at.after(self.latency));
        if self.under_way.len() < BYTES_MAX {
            self.under_way.push_back((self.arrived_at, byte));
        }
    }

    /// Exchanges the bytes from `last` on with those from `first` to `last`.
    fn swap(&mut self, first: usize, last: usize) {
        let bytes: Vec<u8> = self.under_way.iter().skip(first).map(|&(_, byte)| byte).collect();
        let turned = bytes.iter().skip(last - first).chain(bytes.iter().take(last - first));
        for (place, &byte) in self.under_way.iter_mut().skip(first).zip(turned) {
            place.1 = byte;
        }
    }

    /// Takes the next byte that has arrived by `now`, with its arrival time.
    pub fn receive(&mut self, now: Time) -> Option<(Time, u8)> {
        match self.under_way.front() {
            Some(&(at, _)) if at <= now => self.under_way.pop_front(),
            _ => None,
        }
    }

    /// The arrival time of the next byte.
    #[must_use]
    pub fn next_arrival(&self) -> Option<Time> {
        self.under_way.front().map(|&(at, _)| at)
    }

    /// The arrival time of the next realtime character.
    #[must_use]
    pub fn next_minded(&self, is_realtime: impl Fn(u8) -> bool) -> Option<Time> {
        self.under_way.iter().find(|&&(_, byte)| is_realtime(byte)).map(|&(at, _)| at)
    }

    /// The time when the next line is complete, or when the last byte on the line arrives.
    #[must_use]
    pub fn next_line(&self) -> Option<Time> {
        let line = self.under_way.iter().find(|&&(_, byte)| byte == b'\n');
        line.or(self.under_way.back()).map(|&(at, _)| at)
    }

    /// Drops the bytes on the line, because the cable is pulled.
    pub fn cut(&mut self) {
        self.under_way.clear();
        self.last_chunk = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faults::{ByteDamage, Rates};

    fn through(rates: Rates, chunks: &[&[u8]]) -> String {
        let mut wire = Wire::new(115_200, Duration::from_millis(10)).hurt(Faults::new(rates, 5));
        chunks.iter().for_each(|chunk| wire.send(chunk, Time::ZERO));
        let mut text = Vec::new();
        let mut last = Time::ZERO;
        while let Some((at, byte)) = wire.receive(Time::NEVER) {
            assert!(at >= last, "bytes arrive in order");
            (last, _) = (at, text.push(byte));
        }
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn chunks_are_lost_duplicated_swapped_and_damaged() {
        let chunks: [&[u8]; 3] = [b"one ", b"two ", b"three "];
        let rates = Rates::default();
        assert_eq!(through(rates, &chunks), "one two three ");
        assert_eq!(through(Rates { loss: 1.0, ..rates }, &chunks), "");
        assert_eq!(through(Rates { doubling: 1.0, ..rates }, &chunks), "one one two two three three ");
        assert_eq!(through(Rates { swap: 1.0, ..rates }, &chunks), "two three one ");
        assert!(!through(Rates { damage: 1.0, ..rates }, &chunks).contains(char::is_alphabetic));
        let delay = Rates { delay: 1.0, delay_max: Duration::from_secs(1), ..rates };
        assert_eq!(through(delay, &chunks), "one two three ");
    }

    #[test]
    fn one_digit_alone_is_altered() {
        let sent = "G90 X12.5";
        let heard = through(
            Rates { damage: 1.0, kind: ByteDamage::Digit, ..Rates::default() },
            &[sent.as_bytes(), b"Y7"],
        );
        assert!(heard.starts_with('G') && heard.ends_with("0 X12.5Y7"), "{heard}");
        assert!(heard.as_bytes()[1].is_ascii_digit() && heard.as_bytes()[1] != b'9', "{heard}");
    }
}

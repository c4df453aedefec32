//! Faults of an impaired serial line, reproducible from a seed.
//!
//! Each direction of a line has its own faults. They act on the written chunks: a chunk can be delayed, lost,
//! duplicated, exchanged with the previous chunk while that is still on the line, or damaged.

use std::time::Duration;

/// The probabilities of faults: per written chunk, and for damage per byte.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// A chunk and all later ones are delayed.
    pub delay: f64,
    /// Longest delay.
    pub delay_max: Duration,
    /// A chunk is lost.
    pub loss: f64,
    /// A chunk arrives twice.
    pub doubling: f64,
    /// A chunk is exchanged with the previous one.
    pub swap: f64,
    /// A byte is damaged.
    pub damage: f64,
    /// The form of damage.
    pub kind: ByteDamage,
    /// A noise byte arrives before a chunk.
    pub noise: f64,
    /// A long chunk is replaced by an earlier one (a replayed reply). At least [`LIES_APART`] long chunks lie
    /// between two replacements.
    pub lie: f64,
}

/// Least number of long chunks between two replayed ones.
pub const LIES_APART: u64 = 12;
/// Least length of a replayed chunk, bytes: longer than an acknowledgement, as a report is.
const LIE_BYTES: usize = 20;
/// Chunks kept for a replay.
const REMEMBERED: usize = 8;

/// The result of damage to a byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ByteDamage {
    /// A byte that no dialect uses, so the receiver rejects the line. A wrong baud rate, or a line with
    /// parity or its own checksum, turns damage into such bytes.
    #[default]
    Detectable,
    /// Any byte, or a lost byte: only a checksum detects it.
    Any,
    /// As [`ByteDamage::Any`], with at most one damaged byte per chunk: a sum over the chunk always detects it.
    /// Two damaged bytes can cancel in a sum.
    One,
    /// Once in all, a digit becomes another digit. Only a checksum detects it.
    Digit,
}

/// The fate of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It arrives.
    Arrives,
    /// It is lost.
    Lost,
    /// It arrives twice.
    Doubled,
    /// It arrives before the previously written chunk.
    Swapped,
}

/// A source of faults for one direction of a line.
#[derive(Clone, Debug)]
pub struct Faults {
    rates: Rates,
    random: fastrand::Rng,
    happened: u64,
    rubbish: bool,
    /// Whether the present chunk is damaged.
    hurt: bool,
    /// The last long chunks.
    earlier: std::collections::VecDeque<Vec<u8>>,
    /// Long chunks since the last replay.
    since_lie: u64,
}

impl Faults {
    /// Faults at these rates.
    #[must_use]
    pub fn new(rates: Rates, seed: u64) -> Self {
        Self {
            rates,
            random: fastrand::Rng::with_seed(seed),
            happened: 0,
            rubbish: false,
            hurt: false,
            earlier: std::collections::VecDeque::new(),
            since_lie: 0,
        }
    }

    /// The number of faults so far.
    #[must_use]
    pub fn happened(&self) -> u64 {
        self.happened
    }

    /// Sets the two ends to different baud rates, or back to the same. With different rates every byte is
    /// damaged.
    pub fn rubbish(&mut self, rubbish: bool) {
        self.rubbish = rubbish;
    }

    /// Ends all faults.
    pub fn end(&mut self) {
        self.rates = Rates::default();
        self.rubbish = false;
    }

    fn happens(&mut self, chance: f64) -> bool {
        let happens = chance > 0.0 && self.random.f64() < chance;
        self.happened += u64::from(happens);
        happens
    }

    /// Begins a chunk.
    pub fn piece(&mut self) {
        self.hurt = false;
    }

    /// Whether the present chunk is damaged and must not be damaged again.
    fn spares(&self) -> bool {
        self.hurt && self.rates.kind == ByteDamage::One && !self.rubbish
    }

    /// Whether this kind of damage leaves the byte as it is.
    fn spares_byte(&self, byte: u8) -> bool {
        let digit = self.rates.kind == ByteDamage::Digit && !self.rubbish;
        self.spares() || digit && (self.happened > 0 || !byte.is_ascii_digit())
    }

    /// Draws the fate of the next chunk.
    pub fn fate(&mut self) -> Fate {
        let Rates { loss, doubling, swap, .. } = self.rates;
        if self.happens(loss) {
            Fate::Lost
        } else if self.happens(doubling) {
            Fate::Doubled
        } else if self.happens(swap) {
            Fate::Swapped
        } else {
            Fate::Arrives
        }
    }

    /// Draws the delay before the next chunk.
    pub fn delay(&mut self) -> Duration {
        if self.happens(self.rates.delay) {
            // Log-uniform over three decades: short and long delays are equally frequent.
            let share = 10.0_f64.powf(-3.0 * self.random.f64());
            self.rates.delay_max.mul_f64(share)
        } else {
            Duration::ZERO
        }
    }

    /// Draws an earlier chunk that replaces this one, if a replay happens.
    pub fn lie(&mut self, piece: &[u8]) -> Option<Vec<u8>> {
        if self.rates.lie <= 0.0 || piece.len() < LIE_BYTES {
            return None;
        }
        self.since_lie += 1;
        let earlier = self.earlier.front().cloned();
        self.earlier.push_back(piece.to_vec());
        if self.earlier.len() > REMEMBERED {
            self.earlier.pop_front();
        }
        let lies = self.since_lie > LIES_APART && self.happens(self.rates.lie);
        earlier.filter(|_| lies).inspect(|_| self.since_lie = 0)
    }

    /// Draws the received form of a byte: the same, another, or `None` for a lost one.
    pub fn hurt(&mut self, byte: u8) -> Option<u8> {
        if self.spares_byte(byte) || !self.happens(if self.rubbish { 1.0 } else { self.rates.damage }) {
            return Some(byte);
        }
        self.hurt = true;
        match self.rates.kind {
            ByteDamage::Detectable => Some(b"#@`{}\\"[self.random.usize(0..6)]),
            ByteDamage::Digit => Some(b'0' + (byte.wrapping_sub(b'0') + self.random.u8(1..10)) % 10),
            // Only a checksum detects a digit that becomes another digit.
            ByteDamage::Any | ByteDamage::One if byte.is_ascii_digit() && self.random.bool() => {
                Some(self.random.u8(b'0'..=b'9'))
            }
            ByteDamage::Any | ByteDamage::One => match self.random.u8(0..10) {
                0 => None,
                // A single bit, as on a real line.
                1..=6 => Some(byte ^ 1 << self.random.u8(0..8)),
                _ => Some(self.random.u8(..)),
            },
        }
    }

    /// Draws noise before the next chunk.
    pub fn noise(&mut self) -> Option<u8> {
        let noise = self.rates.noise;
        if self.spares() || !self.happens(noise) {
            return None;
        }
        self.hurt = true;
        Some(match self.rates.kind {
            ByteDamage::Detectable => b'#',
            ByteDamage::Any | ByteDamage::One | ByteDamage::Digit => self.random.u8(..),
        })
    }
}

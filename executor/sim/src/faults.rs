//! What a serial line does to bytes on a bad day: a source of faults, reproducible from a seed.
//!
//! Each direction of a line has its own. Bytes are hurt in the pieces in which they were written: a piece can be held up,
//! lost, doubled, swapped with the one before it while that is still on the line, or damaged.

use std::time::Duration;

/// How often what happens. Chances are for each piece that is written, and damage for each byte.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// A piece and all behind it are held up.
    pub delay: f64,
    /// For this long at most.
    pub delay_max: Duration,
    /// A piece is lost.
    pub loss: f64,
    /// A piece arrives twice.
    pub doubling: f64,
    /// A piece changes places with the one before it.
    pub swap: f64,
    /// A byte is damaged.
    pub damage: f64,
    /// What a damaged byte can become.
    pub kind: Damage,
    /// Noise arrives where nothing was sent.
    pub noise: f64,
    /// A long piece is replaced by an earlier one; no two within [`LIES_APART`] pieces.
    pub lie: f64,
}

/// Between two pieces that are replaced by earlier ones lie at least so many.
pub const LIES_APART: u64 = 12;
/// Pieces of at least so many bytes are replaced: reports, not acknowledgements.
const LIE_BYTES: usize = 20;
/// Pieces that are remembered.
const REMEMBERED: usize = 8;

/// What a damaged byte becomes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Damage {
    /// A byte that the language does not have: every line that holds it is refused. What a wrong baud rate, and a line with
    /// parity or a checksum of its own, make of damage.
    #[default]
    Detectable,
    /// Any byte, or none: only a checksum notices.
    Any,
    /// The same, but no more than one in a piece: what a sum over the piece always notices. Two damaged bytes can cancel in a sum.
    One,
}

/// What becomes of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It arrives.
    Arrives,
    /// It is lost.
    Lost,
    /// It arrives twice.
    Doubled,
    /// It arrives before the piece that was written before it.
    Swapped,
}

/// A source of faults for one direction of a line.
#[derive(Clone, Debug)]
pub struct Faults {
    rates: Rates,
    random: fastrand::Rng,
    happened: u64,
    rubbish: bool,
    /// The piece under way is damaged.
    hurt: bool,
    /// The last long pieces.
    earlier: std::collections::VecDeque<Vec<u8>>,
    /// Long pieces since one was replaced.
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

    /// Faults that have happened.
    #[must_use]
    pub fn happened(&self) -> u64 {
        self.happened
    }

    /// The two ends are set to different rates, or no longer: every byte is damaged.
    pub fn rubbish(&mut self, rubbish: bool) {
        self.rubbish = rubbish;
    }

    /// From here on nothing happens any more.
    pub fn end(&mut self) {
        self.rates = Rates::default();
        self.rubbish = false;
    }

    fn happens(&mut self, chance: f64) -> bool {
        let happens = chance > 0.0 && self.random.f64() < chance;
        self.happened += u64::from(happens);
        happens
    }

    /// A piece begins.
    pub fn piece(&mut self) {
        self.hurt = false;
    }

    /// Whether the piece is damaged already, and is not to be once more.
    fn spares(&self) -> bool {
        self.hurt && self.rates.kind == Damage::One && !self.rubbish
    }

    /// What becomes of the next piece.
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

    /// How long the line stands still before the next piece.
    pub fn delay(&mut self) -> Duration {
        if self.happens(self.rates.delay) {
            // As many short ones as long ones, in each power of ten.
            let share = 10.0_f64.powf(-3.0 * self.random.f64());
            self.rates.delay_max.mul_f64(share)
        } else {
            Duration::ZERO
        }
    }

    /// An earlier piece that arrives in the place of this one, if so it happens.
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

    /// What a byte arrives as: itself, another, or nothing.
    pub fn hurt(&mut self, byte: u8) -> Option<u8> {
        if self.spares() || !self.happens(if self.rubbish { 1.0 } else { self.rates.damage }) {
            return Some(byte);
        }
        self.hurt = true;
        match self.rates.kind {
            Damage::Detectable => Some(b"#@`{}\\"[self.random.usize(0..6)]),
            // A digit that becomes another is what nothing but a checksum notices.
            Damage::Any | Damage::One if byte.is_ascii_digit() && self.random.bool() => {
                Some(self.random.u8(b'0'..=b'9'))
            }
            Damage::Any | Damage::One => match self.random.u8(0..10) {
                0 => None,
                // A single bit, as on a real line.
                1..=6 => Some(byte ^ 1 << self.random.u8(0..8)),
                _ => Some(self.random.u8(..)),
            },
        }
    }

    /// Noise before the next piece.
    pub fn noise(&mut self) -> Option<u8> {
        let noise = self.rates.noise;
        if self.spares() || !self.happens(noise) {
            return None;
        }
        self.hurt = true;
        Some(match self.rates.kind {
            Damage::Detectable => b'#',
            Damage::Any | Damage::One => self.random.u8(..),
        })
    }
}

//! Sources of a property's inputs: every case of a small lattice, random cases, or bytes.

use std::collections::VecDeque;

use fastrand::Rng;
use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::width::{Narrow, Product};

use crate::properties::{FromPlain, Xy};

/// A source of inputs. A property draws its inputs from it, and must hold for all of them.
pub trait Draw {
    /// The width at which generic predicates run.
    type Width: FromPlain;

    /// A whole number from `low` to `high`, both included.
    fn int(&mut self, low: i64, high: i64) -> i64;

    /// A coordinate of this case's field.
    fn coordinate(&mut self) -> i64;

    /// A length from zero to the size of this case's field.
    fn radius(&mut self) -> i64;

    /// A point of this case's field.
    fn point(&mut self) -> Xy {
        (self.coordinate(), self.coordinate())
    }

    /// A threshold, often equal or close to the distance of `p` and `q`.
    fn threshold(&mut self, _p: Xy, _q: Xy) -> i64 {
        self.radius()
    }

    /// An index below `count`.
    fn one_of(&mut self, count: usize) -> usize {
        let last = i64::try_from(count).unwrap_or(1) - 1;
        usize::try_from(self.int(0, last.max(0))).unwrap_or(0)
    }

    /// A boolean.
    fn coin(&mut self) -> bool {
        self.int(0, 1) == 1
    }
}

/// Every case, one after the other. Coordinates run from `-side / 2` to `side - side / 2`, lengths from 0
/// to `side`.
#[derive(Debug)]
pub struct Every {
    side: i64,
    /// The values drawn in this case and the largest value of each, both relative to the lower bound of the
    /// draw.
    drawn: Vec<(i64, i64)>,
    next: usize,
}

impl Every {
    /// The first case of a field of `side + 1` coordinates each way.
    #[must_use]
    pub fn of(side: i64) -> Self {
        Self { side, drawn: Vec::new(), next: 0 }
    }

    /// Moves on to the next case; `false` after the last.
    pub fn advance(&mut self) -> bool {
        self.next = 0;
        while let Some((value, last)) = self.drawn.pop() {
            if value < last {
                self.drawn.push((value + 1, last));
                return true;
            }
        }
        false
    }
}

impl Draw for Every {
    type Width = Narrow;

    fn int(&mut self, low: i64, high: i64) -> i64 {
        if self.next == self.drawn.len() {
            self.drawn.push((0, high - low));
        }
        let (value, _) = self.drawn[self.next];
        self.next += 1;
        low + value
    }

    fn coordinate(&mut self) -> i64 {
        let low = -(self.side / 2);
        self.int(low, low + self.side)
    }

    fn radius(&mut self) -> i64 {
        self.int(0, self.side)
    }
}

/// Random cases over the whole lattice, reproducible from a seed. The field's size varies from a few units,
/// where points coincide, to the whole lattice with its extremes.
#[derive(Debug)]
pub struct Chance {
    random: Rng,
    reach: i64,
    half: i64,
    origin: Xy,
    odd: bool,
}

const LIMIT: i64 = COORD_MAX as i64;

impl Chance {
    /// Cases from a seed; [`Chance::advance`] begins the first.
    #[must_use]
    pub fn of(seed: u64) -> Self {
        Self { random: Rng::with_seed(seed), reach: 0, half: 1, origin: (0, 0), odd: false }
    }

    /// The largest magnitude that was drawn.
    #[must_use]
    pub fn reach(&self) -> i64 {
        self.reach
    }

    fn saw(&mut self, value: i64) -> i64 {
        self.reach = self.reach.max(value.saturating_abs());
        value
    }

    /// Begins a case.
    pub fn advance(&mut self) {
        self.half = 1 << self.random.u32(1..=29);
        let room = LIMIT - self.half;
        let mut place = || match self.random.u8(0..4) {
            0 => 0,
            1 => room * (i64::from(self.random.bool()) * 2 - 1),
            _ => self.random.i64(-room..=room),
        };
        self.origin = (place(), place());
        self.odd = false;
    }
}

impl Draw for Chance {
    type Width = Product;

    fn int(&mut self, low: i64, high: i64) -> i64 {
        let value = self.random.i64(low..=high);
        self.saw(value)
    }

    fn coordinate(&mut self) -> i64 {
        self.odd = !self.odd;
        let origin = if self.odd { self.origin.0 } else { self.origin.1 };
        let value = match self.random.u8(0..12) {
            0 => origin - self.half,
            1 => origin + self.half,
            2 => origin,
            _ => origin + self.random.i64(-self.half..=self.half),
        };
        self.saw(value)
    }

    fn point(&mut self) -> Xy {
        self.odd = false;
        (self.coordinate(), self.coordinate())
    }

    fn radius(&mut self) -> i64 {
        let value = self.random.i64(0..=(2 * self.half).min(LIMIT));
        self.saw(value)
    }

    fn threshold(&mut self, p: Xy, q: Xy) -> i64 {
        let (dx, dy) = (i128::from(p.0 - q.0), i128::from(p.1 - q.1));
        let distance = i64::try_from((dx * dx + dy * dy).isqrt()).unwrap_or(LIMIT);
        match self.random.u8(0..4) {
            0 => (distance + self.random.i64(-1..=1)).clamp(0, LIMIT),
            1 => ((p.0 - q.0).abs().min((p.1 - q.1).abs()) + self.random.i64(-1..=1)).clamp(0, LIMIT),
            _ => self.radius(),
        }
    }
}

/// A case from a fuzzer's bytes. Missing bytes count as zero.
#[derive(Debug)]
pub struct Bytes {
    left: VecDeque<u8>,
    half: i64,
}

impl Bytes {
    /// The case of these bytes. The first byte sets the size of the field.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        let mut left: VecDeque<u8> = bytes.iter().copied().collect();
        let first = left.pop_front().unwrap_or(0);
        Self { left, half: 1 << (1 + u32::from(first) % 29) }
    }
}

impl Draw for Bytes {
    type Width = Product;

    fn int(&mut self, low: i64, high: i64) -> i64 {
        let span = i128::from(high) - i128::from(low) + 1;
        let mut value: i128 = 0;
        let mut room: i128 = 1;
        while room < span {
            let byte = self.left.pop_front().unwrap_or(0);
            (value, room) = (value << 8 | i128::from(byte), room << 8);
        }
        low + i64::try_from(value % span).unwrap_or(0)
    }

    fn coordinate(&mut self) -> i64 {
        self.int(-self.half, self.half)
    }

    fn radius(&mut self) -> i64 {
        self.int(0, (2 * self.half).min(LIMIT))
    }
}

//! Given and random inputs, for tests and for counterexamples.

use std::collections::VecDeque;

use fastrand::Rng;

use crate::{Cases, ModelHarness};

/// All harnesses.
#[must_use]
pub fn all() -> Vec<&'static ModelHarness> {
    let groups = [
        crate::lattice::ALL,
        crate::windows::ALL,
        crate::predicates::ALL,
        crate::arcs::ALL,
        crate::rings::ALL,
        crate::index::ALL,
        crate::parts::ALL,
        crate::guard::ALL,
    ];
    groups.into_iter().flatten().collect()
}

/// False statements, each of which a model checker must refute.
#[must_use]
pub fn canaries() -> Vec<&'static ModelHarness> {
    crate::canaries::ALL.iter().collect()
}

/// Inputs of a harness: the numbers of a counterexample, or random ones.
#[derive(Debug)]
pub struct Inputs {
    given: VecDeque<i32>,
    random: Option<Rng>,
}

impl Inputs {
    /// These numbers, in the order in which the harness draws them. Missing ones are zero.
    #[must_use]
    pub fn given(numbers: &[i32]) -> Self {
        Self { given: numbers.iter().copied().collect(), random: None }
    }

    /// Random numbers from a seed.
    #[must_use]
    pub fn random(seed: u64) -> Self {
        Self { given: VecDeque::new(), random: Some(Rng::with_seed(seed)) }
    }
}

impl Cases for Inputs {
    fn int(&mut self, low: i32, high: i32) -> i32 {
        let Some(random) = &mut self.random else {
            return self.given.pop_front().unwrap_or(0).clamp(low, high);
        };
        match random.u8(0..6) {
            0 => low,
            1 => high,
            2 if low <= 0 && 0 <= high => 0,
            3 => random.i32(low.max(-3).min(high)..=high.min(3).max(low)),
            _ => random.i32(low..=high),
        }
    }

    fn wide(&mut self) -> i64 {
        let Some(random) = &mut self.random else {
            let (high, low) = (self.given.pop_front().unwrap_or(0), self.given.pop_front().unwrap_or(0));
            return i64::from(high) << 32 | i64::from(low.cast_unsigned());
        };
        let edge = [0, 1 << 29, -1 << 29, i64::MAX, i64::MIN + 4][random.usize(0..5)];
        match random.u8(0..3) {
            0 => edge.saturating_add(random.i64(-3..=3)),
            1 => random.i64(-1 << 30..=1 << 30),
            _ => random.i64(..),
        }
    }
}

/// All inputs at once, for Kani.
#[cfg(kani)]
pub(crate) struct KaniInputs;

#[cfg(kani)]
impl Cases for KaniInputs {
    fn int(&mut self, low: i32, high: i32) -> i32 {
        #[cfg(kani_shim)]
        use shim as kani;
        let value: i32 = kani::any();
        kani::assume(low <= value && value <= high);
        value
    }

    fn wide(&mut self) -> i64 {
        #[cfg(kani_shim)]
        use shim as kani;
        kani::any()
    }
}

/// The names of Kani that the harnesses use, so that the compiler can check them without Kani: `cargo rustc -p
/// keepout-harnesses --lib -- --cfg kani --cfg kani_shim`. A harness that runs on it panics.
#[cfg(all(kani, kani_shim))]
mod shim {
    pub fn any<T>() -> T {
        panic!("only Kani has all values")
    }

    pub fn assume(_: bool) {
        panic!("only Kani can assume")
    }
}

/// Runs a harness on random inputs.
#[cfg(test)]
pub(crate) fn try_many(name: &str) {
    let harness = all().into_iter().find(|each| each.name == name).expect("it is in the table");
    (0..20_000).for_each(|seed| (harness.run)(&mut Inputs::random(seed)));
}

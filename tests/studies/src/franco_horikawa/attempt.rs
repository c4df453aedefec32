//! Attempts: somebody drives the tool at the part until the system keeps it from going on.

use std::borrow::Borrow;

use keepout_sim::operator::ModelKind;
use serde::{Deserialize, Serialize};

use super::scenario::Mm;

/// What came of an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// How deep the tool was in the part, mm; zero is a success.
    pub depth_mm: f64,
    /// The least distance between the tool's edge and the part, mm: the under-cutting of a success.
    pub closest_mm: f64,
    /// How long it took, s.
    pub seconds: f64,
    /// The way of the tool's centre, drawing coordinates, mm.
    pub path: Vec<Mm>,
    /// Stops before it that nothing called for.
    pub false_alarms: u64,
    /// The fastest that the tool went, mm/s, where drives moved it.
    pub fastest_mm_s: Option<f64>,
}

/// Models of people who steer at the part: they drive the paper's system. The stick of the last sticks at times.
pub const PEOPLE: [ModelKind; 4] = [ModelKind::Calm, ModelKind::Wall, ModelKind::Jittery, ModelKind::Stuck];

/// Every model: besides people, random directions, and reversals timed to the wall. They drive the product.
pub const ALL: [ModelKind; 6] = [
    ModelKind::Calm,
    ModelKind::Wall,
    ModelKind::Jittery,
    ModelKind::Stuck,
    ModelKind::Random,
    ModelKind::Reversal,
];

/// The operator of an attempt: each of them in turn.
///
/// # Panics
/// When there is none.
#[must_use]
pub fn operator_of(operators: &[ModelKind], attempt: u64) -> ModelKind {
    let index = usize::try_from(attempt % operators.len() as u64);
    operators[index.expect("less than there are")]
}

/// Attempts of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// All of them.
    pub attempts: u64,
    /// Those in which the tool was never in the part.
    pub successes: u64,
    /// Mean least distance of the tool to the part in a success, mm; none without success.
    pub mean_mm: Option<f64>,
    /// The largest of these, mm.
    pub worst_mm: Option<f64>,
    /// The deepest the tool was in the part, mm.
    pub deepest_mm: f64,
    /// Mean duration, s.
    pub seconds: f64,
    /// Stops that nothing called for.
    pub false_alarms: u64,
    /// The fastest that the tool went, mm/s, where drives moved it.
    pub fastest_mm_s: Option<f64>,
}

impl Tally {
    /// Adds attempts up, in their order.
    pub fn of<A: Borrow<Attempt>>(attempts: impl IntoIterator<Item = A>) -> Self {
        let mut tally = Self::default();
        let (mut sum, mut worst, mut seconds) = (0.0, 0.0_f64, 0.0);
        for attempt in attempts {
            let attempt = attempt.borrow();
            tally.attempts += 1;
            tally.false_alarms += attempt.false_alarms;
            tally.fastest_mm_s = larger(tally.fastest_mm_s, attempt.fastest_mm_s);
            seconds += attempt.seconds;
            if attempt.depth_mm > 0.0 {
                tally.deepest_mm = tally.deepest_mm.max(attempt.depth_mm);
            } else {
                tally.successes += 1;
                sum += attempt.closest_mm;
                worst = worst.max(attempt.closest_mm);
            }
        }
        if tally.successes > 0 {
            tally.mean_mm = Some(sum / real(tally.successes));
            tally.worst_mm = Some(worst);
        }
        tally.seconds = seconds / real(tally.attempts.max(1));
        tally
    }

    /// Several tallies as one.
    #[must_use]
    pub fn together(tallies: &[Self]) -> Self {
        let sum = |of: fn(&Self) -> u64| tallies.iter().map(of).sum::<u64>();
        let (attempts, successes) = (sum(|tally| tally.attempts), sum(|tally| tally.successes));
        let weighed = |of: fn(&Self) -> f64| tallies.iter().map(of).sum::<f64>();
        let under_cutting = weighed(|tally| tally.mean_mm.unwrap_or(0.0) * real(tally.successes));
        Self {
            attempts,
            successes,
            mean_mm: (successes > 0).then(|| under_cutting / real(successes)),
            worst_mm: tallies.iter().filter_map(|tally| tally.worst_mm).reduce(f64::max),
            deepest_mm: tallies.iter().map(|tally| tally.deepest_mm).fold(0.0, f64::max),
            seconds: weighed(|tally| tally.seconds * real(tally.attempts)) / real(attempts.max(1)),
            false_alarms: sum(|tally| tally.false_alarms),
            fastest_mm_s: tallies.iter().map(|tally| tally.fastest_mm_s).fold(None, larger),
        }
    }

    /// Share of attempts without an gouge.
    #[must_use]
    pub fn success(&self) -> f64 {
        real(self.successes) / real(self.attempts.max(1))
    }
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

impl FromIterator<Attempt> for Tally {
    /// Attempts added up as they come: none is kept.
    fn from_iter<I: IntoIterator<Item = Attempt>>(attempts: I) -> Self {
        Self::of(attempts)
    }
}

/// A count as a number to reckon with.
#[expect(clippy::cast_precision_loss, reason = "counts of attempts are below 2^52")]
#[must_use]
pub fn real(count: u64) -> f64 {
    count as f64
}

/// The seed of an attempt: of the study's seed, the row and the number, so that neighbours give unrelated streams (Steele, Lea and
/// Flood's mixer).
#[must_use]
pub fn seed_of(study: u64, row: u64, attempt: u64) -> u64 {
    [study, row, attempt].into_iter().fold(0, |so_far: u64, value| {
        let value = (so_far ^ value).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let value = (value ^ value >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let value = (value ^ value >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        value ^ value >> 31
    })
}

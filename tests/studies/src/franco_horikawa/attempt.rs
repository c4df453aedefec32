//! Attempts: an operator moves the tool toward the part until the system stops it.

use std::borrow::Borrow;

use keepout_sim::operator::ModelKind;
use serde::{Deserialize, Serialize};

use keepout_planner::Mm2;

/// Result of an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// Largest depth of the tool in the part, mm. Zero is a success.
    pub depth_mm: f64,
    /// Smallest distance between the tool's edge and the part, mm. In a success, this is the under-cutting.
    pub closest_mm: f64,
    /// Duration, s.
    pub seconds: f64,
    /// Path of the tool's centre, drawing coordinates, mm.
    pub path: Vec<Mm2>,
    /// Number of earlier false stops.
    pub false_alarms: u64,
    /// Highest speed of the tool, mm/s. Only for runs with simulated drives.
    pub fastest_mm_s: Option<f64>,
}

impl Attempt {
    /// An attempt in one dimension. The table went `beyond_mm` past a barrier. Negative: it stopped before it.
    #[must_use]
    pub fn at_a_barrier(beyond_mm: f64, seconds: f64, path: Vec<Mm2>) -> Self {
        let (depth_mm, closest_mm) = (beyond_mm.max(0.0), (-beyond_mm).max(0.0));
        Self { depth_mm, closest_mm, seconds, path, false_alarms: 0, fastest_mm_s: None }
    }
}

/// Models of people who jog toward the part. They operate the paper's system. The stick of the last one
/// sticks at times.
pub const PEOPLE: [ModelKind; 4] = [ModelKind::Calm, ModelKind::Wall, ModelKind::Jittery, ModelKind::Stuck];

/// All models: people, random directions, and reversals timed to the wall. They operate Keepout.
pub const ALL: [ModelKind; 6] = [
    ModelKind::Calm,
    ModelKind::Wall,
    ModelKind::Jittery,
    ModelKind::Stuck,
    ModelKind::Random,
    ModelKind::Reversal,
];

/// The operator of an attempt. The operators take turns.
///
/// # Panics
/// If `operators` is empty.
#[must_use]
pub fn operator_of(operators: &[ModelKind], attempt: u64) -> ModelKind {
    let index = usize::try_from(attempt % operators.len() as u64);
    operators[index.expect("the index is less than the number of operators")]
}

/// Statistics of the attempts of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Number of attempts.
    pub attempts: u64,
    /// Number of attempts in which the tool never entered the part.
    pub successes: u64,
    /// Mean under-cutting of the successes, mm. `None` without a success.
    pub mean_mm: Option<f64>,
    /// Largest under-cutting of the successes, mm.
    pub worst_mm: Option<f64>,
    /// Largest depth of the tool in the part, mm.
    pub deepest_mm: f64,
    /// Mean duration, s.
    pub seconds: f64,
    /// Number of false stops.
    pub false_alarms: u64,
    /// Highest speed of the tool, mm/s. Only for runs with simulated drives.
    pub fastest_mm_s: Option<f64>,
}

impl Tally {
    /// Computes the statistics of `attempts`.
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

    /// Computes the statistics of attempts in one dimension, and counts those in which the table followed back.
    #[must_use]
    pub fn with_released(tried: &[(Attempt, bool)]) -> (Self, u64) {
        let released = tried.iter().filter(|(_, released)| *released).count() as u64;
        (Self::of(tried.iter().map(|(attempt, _)| attempt)), released)
    }

    /// Combines several tallies.
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

    /// Share of attempts without a gouge.
    #[must_use]
    pub fn success(&self) -> f64 {
        real(self.successes) / real(self.attempts.max(1))
    }
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

impl FromIterator<Attempt> for Tally {
    /// Computes the statistics without storing the attempts.
    fn from_iter<I: IntoIterator<Item = Attempt>>(attempts: I) -> Self {
        Self::of(attempts)
    }
}

/// A count as a real number.
#[expect(clippy::cast_precision_loss, reason = "counts of attempts are below 2^52")]
#[must_use]
pub fn real(count: u64) -> f64 {
    count as f64
}

/// The seed of an attempt, from the seed of the study, the row and the number of the attempt.
///
/// The mixer of Steele, Lea and Flood gives neighbouring attempts unrelated random streams.
#[must_use]
pub fn seed_of(study: u64, row: u64, attempt: u64) -> u64 {
    [study, row, attempt].into_iter().fold(0, |so_far: u64, value| {
        let value = (so_far ^ value).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let value = (value ^ value >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let value = (value ^ value >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        value ^ value >> 31
    })
}

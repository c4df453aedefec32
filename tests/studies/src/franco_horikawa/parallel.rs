//! Parallel execution of independent tasks, with the results in order.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use super::scenario::StudyError;

/// A callback with the number of finished tasks and the number of all tasks.
pub type ProgressCallback<'a> = dyn Fn(u64, u64) + Sync + 'a;

/// Runs `work` for the numbers below `count` on all processors, and returns the results in the order of the
/// numbers.
///
/// # Errors
/// The error of the smallest number that failed.
pub fn parallel<T: Send>(
    count: usize,
    progress: &ProgressCallback<'_>,
    work: impl Fn(usize) -> Result<T, StudyError> + Sync,
) -> Result<Vec<T>, StudyError> {
    let (next, done, failed) = (AtomicUsize::new(0), AtomicU64::new(0), AtomicBool::new(false));
    let found = Mutex::new(Vec::with_capacity(count));
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        for _ in 0..threads.min(count) {
            scope.spawn(|| {
                while !failed.load(Ordering::Relaxed) {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        return;
                    }
                    let outcome = work(number);
                    failed.fetch_or(outcome.is_err(), Ordering::Relaxed);
                    if let Ok(mut found) = found.lock() {
                        found.push((number, outcome));
                    }
                    progress(done.fetch_add(1, Ordering::Relaxed) + 1, count as u64);
                }
            });
        }
    });
    let mut found = found.into_inner().unwrap_or_default();
    found.sort_by_key(|(number, _)| *number);
    found.into_iter().map(|(_, outcome)| outcome).collect()
}

//! Killed sessions leave a correct log, and a second session finishes the contour from it. For more moments:
//! `cargo run --release -p keepout-tests --bin kills`.
#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use keepout_tests::kills::{KillMoment, KilledPart, Trials, keepout_program};

#[test]
fn killed_sessions_are_resumed_and_finished() {
    kill("kills", KilledPart::Flat, 12);
}

#[test]
fn killed_sessions_with_depths_are_resumed_and_finished() {
    kill("kills-deep", KilledPart::Deep, 6);
}

/// Kills and resumes so many sessions, four at a time.
fn kill(name: &str, part: KilledPart, moments: u64) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let trials = Trials::new(&folder, keepout_program().unwrap(), part).unwrap();
    let next = AtomicU64::new(1);
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|_| {
                scope.spawn(|| {
                    let numbers =
                        || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|number| *number <= moments);
                    std::iter::from_fn(numbers)
                        .filter_map(|number| trials.go(KillMoment::of(number)).err())
                        .collect()
                })
            })
            .collect();
        threads.into_iter().flat_map(|thread| -> Vec<String> { thread.join().unwrap() }).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

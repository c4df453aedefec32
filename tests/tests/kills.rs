//! Killed sessions leave a correct log, and a second session finishes the contour from it. For more moments:
//! `cargo run --release -p keepout-tests --bin kills`.
#![cfg(unix)]

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use keepout_tests::kills::{KillMoment, Trials, keepout_program};

#[test]
fn killed_sessions_are_resumed_and_finished() {
    let trials =
        Trials::new(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("kills"), keepout_program().unwrap())
            .unwrap();
    let next = AtomicU64::new(1);
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|_| {
                scope.spawn(|| {
                    let numbers =
                        || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|number| *number <= 12);
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

//! Runs the differential soaks: `soak [seed] [predicate cases] [index queries] [arcs]`, on two threads; a difference ends
//! it with a panic that names the case.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use fastrand::Rng;
use keepout_proofs::soak;

const CHUNK: u64 = 20_000;

fn main() {
    let numbers: Vec<u64> = std::env::args().skip(1).filter_map(|text| text.parse().ok()).collect();
    let number = |i: usize, default: u64| numbers.get(i).copied().unwrap_or(default);
    let seed = number(0, 1);
    let begin = Instant::now();
    run("predicate cases", seed, number(1, 10_000_000), soak::predicates);
    run("index and cell queries", seed, number(2, 200_000), soak::queries);
    run("arcs", seed, number(3, 200_000), soak::arcs);
    println!("seed {seed}, {:.0} s", begin.elapsed().as_secs_f64());
}

fn run(what: &str, seed: u64, cases: u64, soak: fn(&mut Rng, u64)) {
    let done = AtomicU64::new(0);
    let show = std::io::stderr().is_terminal();
    std::thread::scope(|scope| {
        for thread in 0..2 {
            let done = &done;
            scope.spawn(move || {
                let mut random = Rng::with_seed(seed * 1000 + thread);
                while done.fetch_add(CHUNK, Ordering::Relaxed) < cases {
                    soak(&mut random, CHUNK);
                    if show && thread == 0 {
                        eprint!("\r{what}: {} of {cases}", done.load(Ordering::Relaxed));
                        let _ = std::io::stderr().flush();
                    }
                }
            });
        }
    });
    println!("{cases} {what}: 0 differences");
}

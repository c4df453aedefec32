//! `soak`: compares random cases with their definitions.

use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use fastrand::Rng;
use keepout_proofs::soak;

/// The number of comparisons. A difference ends the run with a panic that names the case.
#[derive(Debug, clap::Args)]
pub struct Soak {
    /// Seed of the random cases.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Number of predicate cases.
    #[arg(long, default_value_t = 10_000_000)]
    predicates: u64,
    /// Number of queries of the index and the cells.
    #[arg(long, default_value_t = 200_000)]
    queries: u64,
    /// Number of arcs.
    #[arg(long, default_value_t = 200_000)]
    arcs: u64,
}

const CHUNK: u64 = 20_000;

impl Soak {
    /// Compares on two threads.
    pub fn run(&self) -> ExitCode {
        let begin = Instant::now();
        compare("predicate cases", self.seed, self.predicates, soak::predicates);
        compare("index and cell queries", self.seed, self.queries, soak::queries);
        compare("arcs", self.seed, self.arcs, soak::arcs);
        println!("seed {}, {:.0} s", self.seed, begin.elapsed().as_secs_f64());
        ExitCode::SUCCESS
    }
}

fn compare(what: &str, seed: u64, cases: u64, soak: fn(&mut Rng, u64)) {
    let done = AtomicU64::new(0);
    let show = std::io::stderr().is_terminal();
    std::thread::scope(|scope| {
        for thread in 0..2 {
            let done = &done;
            scope.spawn(move || {
                let mut random = Rng::with_seed(seed.wrapping_mul(1000).wrapping_add(thread));
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
    if show {
        eprint!("\r\x1b[K");
    }
    println!("{cases} {what}: 0 differences");
}

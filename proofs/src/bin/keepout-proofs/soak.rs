//! `soak`: compares random cases with their definitions.

use std::any::Any;
use std::io::{IsTerminal, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use fastrand::Rng;
use keepout_campaigns::{ItemOutcome, ShardOptions, ShardRecord, numbered};
use keepout_proofs::soak;

/// The number of comparisons. The cases are compared in chunks. A difference ends the run with the case and its chunk.
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
    #[command(flatten)]
    shard: ShardOptions,
}

/// Cases of one chunk. The seed of the run and the number of a chunk determine its cases.
const CHUNK: u64 = 20_000;

/// A kind of cases.
struct Kind {
    /// Name of the option with the number of cases.
    option: &'static str,
    /// Name of the cases.
    what: &'static str,
    /// The number of cases.
    cases: u64,
    compare: fn(&mut Rng, u64),
}

impl Soak {
    /// Compares on two threads.
    pub fn run(&self) -> ExitCode {
        super::code(self.compare_all())
    }

    fn compare_all(&self) -> std::io::Result<bool> {
        let begin = Instant::now();
        let record = Mutex::new(super::begin(&self.shard, &[])?);
        for kind in self.kinds() {
            let compared = self.compare(&kind, &record);
            if let Ok(mut record) = record.lock() {
                record.total(kind.what, compared);
            }
        }
        println!("seed {}, {:.0} s", self.seed, begin.elapsed().as_secs_f64());
        super::finish(record.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    fn kinds(&self) -> [Kind; 3] {
        let kind = |option, what, cases, compare| Kind { option, what, cases, compare };
        [
            kind("predicates", "predicate cases", self.predicates, soak::predicates as fn(&mut Rng, u64)),
            kind("queries", "index and cell queries", self.queries, soak::queries),
            kind("arcs", "arcs", self.arcs, soak::arcs),
        ]
    }

    /// Compares the chunks of the shard, up to a difference. Returns the number of cases.
    fn compare(&self, kind: &Kind, record: &Mutex<ShardRecord>) -> u64 {
        let chunks = kind.cases.div_ceil(CHUNK);
        let (taken, done, differs) = (AtomicU64::new(0), AtomicU64::new(0), AtomicBool::new(false));
        let show = std::io::stderr().is_terminal();
        let work = || {
            while !differs.load(Ordering::Relaxed) {
                let chunk = self.shard.shard.number(taken.fetch_add(1, Ordering::Relaxed));
                if chunk >= chunks {
                    break;
                }
                let mut random = Rng::with_seed(numbered(self.seed, chunk));
                if let Err(panic) = catch_unwind(AssertUnwindSafe(|| (kind.compare)(&mut random, CHUNK))) {
                    differs.store(true, Ordering::Relaxed);
                    self.keep(kind, chunk, &*panic, record);
                }
                let cases = done.fetch_add(CHUNK, Ordering::Relaxed) + CHUNK;
                if show {
                    eprint!("\r{}: {cases} of {} in all shards", kind.what, kind.cases);
                    let _ = std::io::stderr().flush();
                }
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(work);
            scope.spawn(work);
        });
        if show {
            eprint!("\r\x1b[K");
        }
        let cases = done.into_inner();
        let found = if differs.into_inner() { "A DIFFERENCE" } else { "0 differences" };
        println!("{cases} {}: {found}", kind.what);
        cases
    }

    /// Keeps a chunk with a difference. As a shard by itself the chunk runs again alone.
    fn keep(&self, kind: &Kind, chunk: u64, panic: &(dyn Any + Send), record: &Mutex<ShardRecord>) {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic without a text");
        let options = self.kinds().map(|each| {
            let cases = if each.option == kind.option { kind.cases } else { 0 };
            format!("--{} {cases}", each.option)
        });
        let chunks = kind.cases.div_ceil(CHUNK);
        let again = format!("soak --seed {} {} --shard {}/{chunks}", self.seed, options.join(" "), chunk + 1);
        println!("{text}\n  again: {again}");
        if let Ok(mut record) = record.lock() {
            record.row(ItemOutcome::Failed, &format!("{}, chunk {}", kind.what, chunk + 1), text, &again);
        }
    }
}

//! The run: sessions one after another on all threads, until there are enough or one fails.

use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use keepout_campaigns::{ItemOutcome, ShardRecord, mix, numbered};
use keepout_kernel::Length;
use keepout_tests::hostile::{HostileWorld, Outcome, Spec, Verdict, Worlds, play, shrink};

use crate::Arguments;
use crate::totals::Totals;

/// A run over the drawings of one shard.
pub struct Hunt<'a> {
    worlds: &'a Worlds,
    arguments: &'a Arguments,
    began: Instant,
    /// Drawings of the shard that a thread has taken.
    taken: AtomicU64,
    failed: AtomicBool,
    totals: Totals,
    record: Mutex<ShardRecord>,
}

impl<'a> Hunt<'a> {
    /// Plays the sessions of the shard and prints the sums.
    pub fn run(worlds: &'a Worlds, arguments: &'a Arguments) -> ExitCode {
        let record = match arguments.shard.begin("hostile", data(worlds), &[]) {
            Ok(record) => Mutex::new(record),
            Err(error) => {
                eprintln!("hostile: {error}");
                return ExitCode::from(2);
            }
        };
        let hunt = Hunt {
            worlds,
            arguments,
            began: Instant::now(),
            taken: AtomicU64::new(0),
            failed: AtomicBool::new(false),
            totals: Totals::default(),
            record,
        };
        std::thread::scope(|scope| {
            for _ in 0..arguments.threads.max(1) {
                scope.spawn(|| {
                    while !hunt.is_over() {
                        let turn = hunt.taken.fetch_add(1, Ordering::Relaxed);
                        let number = arguments.shard.shard.number(turn);
                        if arguments.drawings.is_some_and(|drawings| number >= drawings) {
                            break;
                        }
                        hunt.play_drawing(number);
                    }
                });
            }
        });
        hunt.end()
    }

    /// Whether no further session begins.
    fn is_over(&self) -> bool {
        let arguments = self.arguments;
        let shards = arguments.shard.shard.of();
        let elapsed_s = self.began.elapsed().as_secs_f64();
        let late = arguments.minutes.is_some_and(|minutes| elapsed_s > minutes * 60.0);
        // Each shard has its share of the hours and of the sessions.
        let enough = arguments.drawings.is_none()
            && self.totals.hours() >= arguments.hours / f64::from(shards)
            && self.totals.sessions.load(Ordering::Relaxed) >= arguments.sessions.div_ceil(shards.into());
        late || enough || self.failed.load(Ordering::Relaxed)
    }

    fn play_drawing(&self, number: u64) {
        let (seed, _) = seeds(self.arguments.seed, number, 0);
        let Some(world) = self.worlds.world(seed) else { return };
        self.totals.worlds.fetch_add(1, Ordering::Relaxed);
        for mut spec in self.arguments.sessions(number) {
            self.arguments.sets(&mut spec);
            let outcome = play(&world, &spec);
            self.totals.add(&world, &spec, &outcome);
            self.judge(&world, &spec, &outcome);
            if self.is_over() {
                break;
            }
        }
    }

    /// Prints and keeps a session that failed.
    fn judge(&self, world: &HostileWorld, spec: &Spec, outcome: &Outcome) {
        let calm = spec.faults.is_empty() && !self.arguments.first;
        if let Some(fault) = outcome.fault.as_ref().filter(|_| calm) {
            self.failed.store(true, Ordering::Relaxed);
            println!(
                "a fault in a session without faults: {fault}\n  in {} ({}), {spec:?}",
                world.name,
                world.language.name()
            );
            println!("  again: --replay {}:{}", world.seed, spec.seed);
            self.keep(world, spec, &format!("a fault in a session without faults: {fault}"));
        }
        if outcome.ended.is_none() {
            println!("a session did not reach its end\n  again: --replay {}:{}", world.seed, spec.seed);
            self.keep(world, spec, "the session did not reach its end");
        }
        if let Some(verdict) = outcome.verdict.filter(|_| !self.arguments.altered_digit) {
            self.failed.store(true, Ordering::Relaxed);
            self.keep(world, spec, &format!("verdict: {verdict}"));
            report(world, spec, verdict, !self.arguments.first);
        }
    }

    fn keep(&self, world: &HostileWorld, spec: &Spec, detail: &str) {
        if let Ok(mut record) = self.record.lock() {
            let item = format!("{}:{}", world.seed, spec.seed);
            let again = format!("{} --replay {item}", record.arguments());
            record.row(ItemOutcome::Failed, &item, &format!("{detail}, in {}", world.name), again.trim());
        }
    }

    fn end(self) -> ExitCode {
        self.totals.print();
        if self.arguments.altered_digit {
            self.totals.print_verdicts();
        }
        println!(
            "{:.0} s of real time on {} threads",
            self.began.elapsed().as_secs_f64(),
            self.arguments.threads
        );
        let broken = self.totals.broken.load(Ordering::Relaxed);
        let failed = self.failed.load(Ordering::Relaxed) || broken > 0;
        if failed {
            println!(
                "FAILED: a session has a verdict or a fault, or did not reach its end ({broken} sessions)"
            );
        } else if !self.arguments.altered_digit {
            println!("0 gouges, the stock to leave kept while jogging");
        }
        let mut record = self.record.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        self.totals.enter(&mut record);
        match record.finish() {
            Ok(_) => ExitCode::from(u8::from(failed)),
            Err(error) => {
                eprintln!("hostile: {error}");
                ExitCode::from(2)
            }
        }
    }
}

/// The data from outside of the repository that the drawings depend on.
fn data(worlds: &Worlds) -> String {
    let real = worlds.real.iter().filter(|path| path.exists()).count();
    format!("{real} real drawings")
}

/// The seed of a drawing, and of a session in it.
pub fn seeds(run: u64, world: u64, session: u64) -> (u64, u64) {
    let world = mix(run).wrapping_add(world);
    (world, numbered(world, session))
}

/// Prints a verdict with the seeds, and with a smaller session if `shrinks`.
pub fn report(world: &HostileWorld, spec: &Spec, verdict: Verdict, shrinks: bool) {
    let (Verdict::Gouge { centre, .. } | Verdict::StockToLeave { centre, .. }) = verdict;
    let mm = |length: Length| keepout_planner::units::mm(length.units());
    println!(
        "  clearance {:?} mm, tool radius {} mm, least while jogging {} mm, jogging clearance {} mm, {:?}",
        world.work.plan.part.clearance(centre).map(mm),
        mm(world.work.plan.plan.tool_radius),
        mm(world.by_hand),
        mm(world.work.plan.roughing),
        world.machine
    );
    println!("verdict: {verdict}\n  in {} ({}), {spec:?}", world.name, world.language.name());
    println!("  again: --replay {}:{}", world.seed, spec.seed);
    if shrinks {
        println!("  smaller: {:?}", shrink(world, spec));
    }
}

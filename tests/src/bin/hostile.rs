//! Hostile simulation: thousands of sessions, each from a seed. The collision monitor decides exactly.
//!
//! `cargo run --release -p keepout-tests --bin hostile -- --seed 1 --hours 100`
//!
//! If a session fails, the program prints its seeds for `--replay` and a smaller session that fails, too. The
//! run then ends with a failure.
//!
//! Evidence for SR-07, SR-08, SR-09, SR-10, SR-11, SR-12, SR-14, SR-22.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::Parser;
use keepout_executor::dialect::DialectName;
use keepout_kernel::Length;
use keepout_tests::REAL_DRAWINGS;
use keepout_tests::hostile::{
    HostileFault, HostileWorld, Outcome, Spec, Verdict, Worlds, play, play_logged, shrink,
};

/// Hostile operators, lines and controllers against the guard.
#[derive(Debug, Parser)]
struct Arguments {
    /// Seed of the whole run.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Least simulated hours.
    #[arg(long, default_value_t = 1.0)]
    hours: f64,
    /// Least count of sessions.
    #[arg(long, default_value_t = 0)]
    sessions: u64,
    /// Stop after this real time, min.
    #[arg(long)]
    minutes: Option<f64>,
    /// Sessions in each drawing.
    #[arg(long, default_value_t = 200)]
    per_drawing: u64,
    /// Threads.
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Dialect of the controllers. Give it more than once for several dialects.
    #[arg(long)]
    dialect: Vec<String>,
    /// Replay one session, by the seeds of its drawing and its own: WORLD:SESSION.
    #[arg(long)]
    replay: Option<String>,
    /// Write the log of the replayed session.
    #[arg(long, requires = "replay")]
    log: Option<std::path::PathBuf>,
    /// Only sessions with this fault, such as `Doubling`. Give it more than once for several faults.
    #[arg(long, value_name = "FAULT")]
    suffering: Vec<String>,
    /// Only sessions in which the operator starts the contour.
    #[arg(long)]
    cycle_start: bool,
    /// Only sessions in which the operator jogs all the time.
    #[arg(long, conflicts_with = "cycle_start")]
    jogging: bool,
    /// Only controllers that may leave the path, or run away, at a stop.
    #[arg(long)]
    stops_astray: bool,
    /// Only lines with more delay than this each way, ms.
    #[arg(long, value_name = "MS", default_value_t = 0)]
    latency_above_ms: u128,
    /// Stop at the first verdict, without the search for a smaller session.
    #[arg(long)]
    first: bool,
    /// Only drawings with depths, on machines with three axes.
    #[arg(long)]
    three_axes: bool,
    /// Simulate the feed drives in every session.
    #[arg(long)]
    driven: bool,
    /// Steer every session at the panel, with screens that lie, flood, stall and replay.
    #[arg(long)]
    panel: bool,
    /// Only GRBL controllers, by the second model, which another author wrote from the documentation.
    #[arg(long, conflicts_with = "dialect")]
    second_model: bool,
}

#[derive(Default)]
struct Totals {
    sessions: AtomicU64,
    worlds: AtomicU64,
    millis: AtomicU64,
    /// Of these, with three axes.
    deep_millis: AtomicU64,
    jogs: AtomicU64,
    contour_motions: AtomicU64,
    cancels: AtomicU64,
    rounds: AtomicU64,
    way_m: AtomicU64,
    contours: AtomicU64,
    faults: AtomicU64,
    recoveries: AtomicU64,
    broken: AtomicU64,
    ends: Mutex<BTreeMap<String, u64>>,
}

impl Totals {
    fn add(&self, outcome: &Outcome, deep: bool) {
        let add = |counter: &AtomicU64, value: u64| {
            counter.fetch_add(value, Ordering::Relaxed);
        };
        add(&self.sessions, 1);
        let millis = Duration::from_secs_f64(outcome.seconds).as_millis().try_into().unwrap_or(0);
        add(&self.millis, millis);
        add(&self.deep_millis, if deep { millis } else { 0 });
        add(&self.jogs, outcome.counts.jogs);
        add(&self.contour_motions, outcome.counts.contour_motions);
        add(&self.cancels, outcome.counts.cancels);
        add(&self.rounds, outcome.rounds);
        add(
            &self.way_m,
            Duration::from_secs_f64(outcome.way_mm / 1000.0).as_micros().try_into().unwrap_or(0),
        );
        add(&self.contours, outcome.contoured.try_into().unwrap_or(0));
        add(&self.faults, outcome.faults);
        add(&self.recoveries, outcome.recoveries);
        add(&self.broken, u64::from(outcome.ended.is_none()));
        let end = outcome
            .fault
            .as_deref()
            .map_or("ended without a fault", |fault| fault.split([':', '.', '(']).next().unwrap_or(fault));
        // Garbage has many forms: count all of it in one row.
        let garbled = end.starts_with("the controller sent");
        let end = if garbled { "the controller sent what is not its language" } else { end };
        let end: String = end.chars().filter(|letter| !letter.is_ascii_digit()).take(60).collect();
        if let Ok(mut ends) = self.ends.lock() {
            *ends.entry(end).or_default() += 1;
        }
    }

    fn hours(&self) -> f64 {
        Duration::from_millis(self.millis.load(Ordering::Relaxed)).as_secs_f64() / 3600.0
    }

    fn print(&self) {
        let get = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        println!(
            "{:.1} simulated hours, {:.1} of them with three axes, {} sessions, {} drawings",
            self.hours(),
            Duration::from_millis(get(&self.deep_millis)).as_secs_f64() / 3600.0,
            get(&self.sessions),
            get(&self.worlds)
        );
        println!(
            "{} jogs, {} cancels, {} contour motions, {} loops contoured, {:.1} km travelled",
            get(&self.jogs),
            get(&self.cancels),
            get(&self.contour_motions),
            get(&self.contours),
            Duration::from_micros(get(&self.way_m)).as_secs_f64() / 1000.0
        );
        println!(
            "{} decisions, {} line faults, {} recoveries",
            get(&self.rounds),
            get(&self.faults),
            get(&self.recoveries)
        );
        if let Ok(ends) = self.ends.lock() {
            for (end, count) in ends.iter() {
                println!("  {count:>9}  {end}");
            }
        }
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let worlds = match worlds(&arguments) {
        Ok(worlds) => worlds,
        Err(message) => {
            eprintln!("hostile: {message}");
            return ExitCode::from(2);
        }
    };
    if let Some(seeds) = &arguments.replay {
        return replay(&worlds, seeds, &arguments);
    }
    if let Some(unknown) = arguments.suffering.iter().find(|name| fault_named(name).is_none()) {
        eprintln!("hostile: there is no fault {unknown}. Choose one of {:?}", HostileFault::ALL);
        return ExitCode::from(2);
    }
    hunt(&worlds, &arguments)
}

fn worlds(arguments: &Arguments) -> Result<Worlds, String> {
    let described = [
        concat!(env!("CARGO_MANIFEST_DIR"), "/../executor/dialects/nsk-style.toml"),
        concat!(env!("CARGO_MANIFEST_DIR"), "/../executor/sim/tests/described/three-axes.toml"),
    ];
    let names: Vec<&str> = if arguments.second_model {
        vec![DialectName::Grbl.name()]
    } else if arguments.dialect.is_empty() {
        DialectName::NAMES.into_iter().chain(described).collect()
    } else {
        arguments.dialect.iter().map(String::as_str).collect()
    };
    let languages = names.into_iter().map(DialectName::named).collect::<Result<_, _>>();
    let languages = languages.map_err(|error| error.to_string())?;
    let shared = std::env::var_os("KEEPOUT_SHARED").map(std::path::PathBuf::from);
    let real = shared.map_or(Vec::new(), |shared| {
        REAL_DRAWINGS.iter().map(|(name, _)| shared.join("dxf/dev").join(name)).collect()
    });
    Ok(Worlds { real, languages, three_axes: arguments.three_axes })
}

fn fault_named(name: &str) -> Option<HostileFault> {
    HostileFault::ALL.into_iter().find(|fault| format!("{fault:?}") == name)
}

impl Arguments {
    /// Gives a session what all sessions of the run have.
    fn sets(&self, spec: &mut Spec) {
        spec.driven |= self.driven;
        spec.at_panel |= self.panel;
        spec.second_model |= self.second_model;
    }

    /// Whether the arguments ask for this session.
    fn wants(&self, spec: &Spec) -> bool {
        let suffers = |name: &String| fault_named(name).is_some_and(|fault| spec.suffers(fault));
        self.suffering.iter().all(suffers)
            && (!self.cycle_start || spec.automatic)
            && (!self.jogging || !spec.automatic)
            && (!self.stops_astray || !spec.quirks.plain_hold || spec.quirks.stops_run_away)
            && spec.latency.as_millis() > self.latency_above_ms
    }

    /// The sessions of the drawing of this number, in order.
    fn sessions(&self, number: u64) -> impl Iterator<Item = Spec> {
        let specs = (0..).map(move |session| Spec::of(seeds(self.seed, number, session).1));
        let wanted = specs.filter(|spec| self.wants(spec));
        wanted.take(usize::try_from(self.per_drawing).unwrap_or(usize::MAX))
    }
}

/// The seed of a drawing, and of a session in it.
fn seeds(run: u64, world: u64, session: u64) -> (u64, u64) {
    let mix = |value: u64| {
        // Steele, Lea and Flood's mixer: neighbouring numbers give unrelated streams.
        let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let value = (value ^ value >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let value = (value ^ value >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        value ^ value >> 31
    };
    let world = mix(run).wrapping_add(world);
    (world, mix(mix(world) ^ session))
}

fn hunt(worlds: &Worlds, arguments: &Arguments) -> ExitCode {
    let began = Instant::now();
    let totals = Totals::default();
    let next = AtomicU64::new(0);
    let failed = AtomicBool::new(false);
    let over = || {
        let late = arguments.minutes.is_some_and(|minutes| began.elapsed().as_secs_f64() > minutes * 60.0);
        let enough = totals.hours() >= arguments.hours
            && totals.sessions.load(Ordering::Relaxed) >= arguments.sessions;
        late || enough || failed.load(Ordering::Relaxed)
    };
    std::thread::scope(|scope| {
        for _ in 0..arguments.threads.max(1) {
            scope.spawn(|| {
                while !over() {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let (seed, _) = seeds(arguments.seed, number, 0);
                    let Some(world) = worlds.world(seed) else { continue };
                    totals.worlds.fetch_add(1, Ordering::Relaxed);
                    for mut spec in arguments.sessions(number) {
                        arguments.sets(&mut spec);
                        let outcome = play(&world, &spec);
                        totals.add(&outcome, world.place.z.is_some());
                        let calm = spec.faults.is_empty() && !arguments.first;
                        if let Some(fault) = outcome.fault.as_ref().filter(|_| calm) {
                            failed.store(true, Ordering::Relaxed);
                            println!(
                                "a fault in a session without faults: {fault}\n  in {} ({}), {spec:?}",
                                world.name,
                                world.language.name()
                            );
                            println!("  again: --replay {}:{}", world.seed, spec.seed);
                        }
                        if let Some(verdict) = outcome.verdict {
                            failed.store(true, Ordering::Relaxed);
                            report(&world, &spec, verdict, !arguments.first);
                        }
                        if over() {
                            break;
                        }
                    }
                }
            });
        }
    });
    totals.print();
    println!("{:.0} s of real time on {} threads", began.elapsed().as_secs_f64(), arguments.threads);
    let broken = totals.broken.load(Ordering::Relaxed);
    if failed.load(Ordering::Relaxed) || broken > 0 {
        println!("FAILED: a session has a verdict or a fault, or did not reach its end ({broken} sessions)");
        ExitCode::FAILURE
    } else {
        println!("0 gouges, the stock to leave kept while jogging");
        ExitCode::SUCCESS
    }
}

fn report(world: &HostileWorld, spec: &Spec, verdict: Verdict, shrinks: bool) {
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

fn replay(worlds: &Worlds, seeds: &str, arguments: &Arguments) -> ExitCode {
    let parsed =
        seeds.split_once(':').and_then(|(world, session)| Some((world.parse().ok()?, session.parse().ok()?)));
    let Some((world, session)) = parsed else {
        eprintln!("hostile: \"{seeds}\" is not WORLD:SESSION, two numbers");
        return ExitCode::from(2);
    };
    let Some(world) = worlds.world(world) else {
        eprintln!(
            "hostile: that drawing gives no plan. Give the dialects of the first run, and the real drawings"
        );
        return ExitCode::from(2);
    };
    let mut spec = Spec::of(session);
    arguments.sets(&mut spec);
    let path = arguments.log.as_deref();
    let outcome = match path.map_or_else(|| Ok(play(&world, &spec)), |path| play_logged(&world, &spec, path))
    {
        Ok(outcome) => outcome,
        Err(error) => {
            eprintln!("hostile: {error}");
            return ExitCode::from(2);
        }
    };
    println!("{} ({})\n{spec:#?}\n{outcome:#?}", world.name, world.language.name());
    let Some(verdict) = outcome.verdict else { return ExitCode::SUCCESS };
    report(&world, &spec, verdict, true);
    ExitCode::FAILURE
}

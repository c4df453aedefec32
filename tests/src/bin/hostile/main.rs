//! Hostile simulation: thousands of sessions, each from a seed. The collision monitor decides exactly.
//!
//! `cargo run --release -p keepout-tests --bin hostile -- --seed 1 --hours 100`
//!
//! Shard I of N (`--shard I/N`) plays every Nth drawing. So no session belongs to two shards.
//!
//! If a session fails, the program prints its seeds for `--replay` and a smaller session that fails, too. The
//! run then ends with a failure.
//!
//! Evidence for SR-07, SR-08, SR-09, SR-10, SR-11, SR-12, SR-14, SR-22.

mod hunt;
mod totals;

use std::process::ExitCode;

use clap::Parser;
use keepout_campaigns::ShardOptions;
use keepout_executor::dialect::DialectName;
use keepout_tests::REAL_DRAWINGS;
use keepout_tests::hostile::{HostileFault, Spec, Worlds, play, play_logged};

use crate::hunt::{Hunt, report, seeds};

/// Hostile operators, lines and controllers against the guard.
#[derive(Debug, Parser)]
struct Arguments {
    /// Seed of the whole run.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Least simulated hours. A shard plays its share of them.
    #[arg(long, default_value_t = 1.0)]
    hours: f64,
    /// All sessions of so many drawings, instead of hours. All shards together play exactly these sessions.
    #[arg(long, value_name = "N", conflicts_with_all = ["hours", "sessions", "minutes"])]
    drawings: Option<u64>,
    /// Least count of sessions. A shard plays its share of them.
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
    /// Alter one digit of one line to the controller in each session, and nothing else. Gouges are counted, and do
    /// not end the run. This measures the assumption A-04 (docs/safety/assumptions.md).
    #[arg(long, conflicts_with = "suffering")]
    altered_digit: bool,
    #[command(flatten)]
    shard: ShardOptions,
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
    Hunt::run(&worlds, &arguments)
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
        if self.altered_digit {
            spec.faults = vec![HostileFault::AlteredDigit];
        }
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

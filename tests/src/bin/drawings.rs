//! Runs the end-to-end job on real drawings of the shared set, with three operators each, and prints a table.
//!
//! `KEEPOUT_SHARED=... cargo run --release -p keepout-tests --bin drawings -- --link pty`

use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use clap::{Parser, ValueEnum};
use keepout_executor::session::{Going, NoEventLog};
use keepout_executor::supervisor::PreparedPlan;
use keepout_sim::operator;
use keepout_sim::session::{Link, SimRun, run_simulated};
use keepout_tests::{REAL_DRAWINGS, most_left_mm, order, plan_of, shared};

#[derive(Clone, Copy, Debug, ValueEnum)]
enum LinkArgument {
    Pty,
    Virtual,
}

/// The end-to-end job on real drawings: hostile, calm and random operator, slow line.
#[derive(Debug, Parser)]
struct Arguments {
    /// The link to the simulated machine.
    #[arg(long, value_enum, default_value = "virtual")]
    link: LinkArgument,
    /// Seconds that each operator jogs.
    #[arg(long, default_value_t = 60.0)]
    jog_s: f64,
    /// Added delay each way, ms.
    #[arg(long, default_value_t = 150)]
    latency_ms: u64,
    /// Baud rate.
    #[arg(long, default_value_t = 9600)]
    baud: u32,
    /// Tool diameter, mm.
    #[arg(long, default_value_t = 3.0)]
    tool_mm: f64,
    /// Seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Runs at the same time.
    #[arg(long, default_value_t = 8)]
    parallel: usize,
}

const OPERATORS: [&str; 3] = ["wall", "calm", "random"];

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let Some(shared) = shared() else { return ExitCode::from(2) };
    let jobs: Vec<(usize, &str)> =
        (0..REAL_DRAWINGS.len()).flat_map(|i| OPERATORS.iter().map(move |&operator| (i, operator))).collect();
    let next = AtomicUsize::new(0);
    let rows = Mutex::new(vec![String::new(); jobs.len()]);
    let bad = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..arguments.parallel.max(1) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(&(drawing, operator)) = jobs.get(index) else { break };
                    let (name, exporter) = REAL_DRAWINGS[drawing];
                    let (good, text) = one(&shared.join("dxf/dev").join(name), operator, &arguments);
                    bad.fetch_add(usize::from(!good), Ordering::Relaxed);
                    let row = format!("| {name} | {exporter} | {operator} | {text} |");
                    eprintln!("{row}");
                    if let Ok(mut rows) = rows.lock() {
                        rows[index] = row;
                    }
                }
            });
        }
    });
    println!(
        "| drawing | exporter | operator | jogs | contour motions | time s | deepest mm | closest mm \
         | cut to profile mm | result |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for row in rows.lock().map(|rows| rows.clone()).unwrap_or_default() {
        println!("{row}");
    }
    let bad = bad.into_inner();
    println!("\n{} runs, {bad} failed", jobs.len());
    if bad == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn one(path: &std::path::Path, name: &str, arguments: &Arguments) -> (bool, String) {
    let run = || -> Result<(bool, String), String> {
        let plan = plan_of(path, &order(arguments.tool_mm))?;
        let most_left_mm = most_left_mm(&plan);
        let mut run = SimRun {
            link: match arguments.link {
                LinkArgument::Pty => Link::Pty,
                LinkArgument::Virtual => Link::Virtual,
            },
            baud: arguments.baud,
            latency: Duration::from_millis(arguments.latency_ms),
            seed: arguments.seed,
            feed_mm_min: 3000,
            ..SimRun::default()
        };
        run.machine.travel_mm = [480.0, 440.0];
        let operator = operator::named(name, arguments.jog_s, arguments.seed).map_err(|e| e.to_string())?;
        let result =
            run_simulated(PreparedPlan::new(plan), &run, operator, Box::new(NoEventLog), &mut |_, _, _| {
                Going::On
            })
            .map_err(|error| error.to_string())?;
        let facts = result.facts;
        let coverage = facts.coverage.unwrap_or_default();
        let good = facts.outcome.is_by_operator()
            && facts.deepest_mm == Some(0.0)
            && !facts.outcome.lacks_link_move()
            && coverage.reachable > 0
            && coverage.missed == 0
            && coverage.worst_mm <= most_left_mm;
        let text = format!(
            "{} | {} | {:.1} | {:.5} | {:.5} | {:.4} | {}",
            facts.counts.jogs,
            facts.counts.contour_motions,
            facts.seconds,
            facts.deepest_mm.unwrap_or(f64::NAN),
            facts.closest_mm.unwrap_or(f64::NAN),
            coverage.worst_mm,
            if good { "good".into() } else { facts.outcome.to_string() }
        );
        Ok((good, text))
    };
    run().unwrap_or_else(|message| (false, format!("– | – | – | – | – | – | {message}")))
}

//! Kills sessions at random moments, takes them up again, and prints what came of it. The exit code is 1
//! when anything is not as wanted.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;
use keepout_tests::kills::{KillMoment, KillOutcome, Trials, keepout_program};

/// Kills executor, controller or cable at random moments, and takes the session up again.
#[derive(Debug, Parser)]
struct Arguments {
    /// How many moments.
    #[arg(long, default_value_t = 60)]
    moments: u64,
    /// The first moment's number: it is the seed of all that is random in it.
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Sessions at the same time.
    #[arg(long, default_value_t = 4)]
    parallel: usize,
    /// Where the files of moments go that are not as wanted.
    #[arg(long, default_value = "target/kills")]
    output: PathBuf,
    /// The keepout program; the one beside this, built anew, when not given.
    #[arg(long)]
    program: Option<PathBuf>,
}

#[derive(Default)]
struct Row {
    moments: u64,
    resumed: u64,
    commands: u64,
    watched: u64,
    closest_mm: f64,
    worst_mm: f64,
}

type Rows = BTreeMap<(String, String), Row>;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let program = arguments.program.map_or_else(keepout_program, Ok);
    let trials = match program.and_then(|program| Trials::new(&arguments.output, program)) {
        Ok(trials) => trials,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::from(2);
        }
    };
    let next = AtomicU64::new(arguments.first);
    let end = arguments.first + arguments.moments;
    let (rows, wrong) = (Mutex::new(Rows::new()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..arguments.parallel.max(1) {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= end {
                        break;
                    }
                    let moment = KillMoment::of(number);
                    match trials.go(moment) {
                        Ok(outcome) => enter(&rows, moment, &outcome),
                        Err(reason) => {
                            eprintln!("{reason}");
                            wrong.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(reason);
                        }
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    print(&rows.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner), wrong.len());
    if wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn enter(rows: &Mutex<Rows>, moment: KillMoment, outcome: &KillOutcome) {
    let phase = if outcome.phase.is_empty() { "before the log" } else { &outcome.phase };
    let key = (format!("{:?}", moment.victim), phase.to_string());
    let mut rows = rows.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let row = rows.entry(key).or_insert(Row { closest_mm: f64::INFINITY, ..Row::default() });
    row.moments += 1;
    row.resumed += u64::from(outcome.resumed);
    row.commands += outcome.commands;
    row.watched += outcome.watched;
    row.closest_mm = row.closest_mm.min(outcome.closest_mm);
    row.worst_mm = row.worst_mm.max(outcome.worst_mm);
}

fn print(rows: &Rows, wrong: usize) {
    println!(
        "| killed | in phase | moments | taken up again | commands replayed | positions watched \
         | closest, mm | cut to profile, mm |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|--:|");
    for ((victim, phase), row) in rows {
        println!(
            "| {victim} | {phase} | {} | {} | {} | {} | {:.5} | {:.4} |",
            row.moments, row.resumed, row.commands, row.watched, row.closest_mm, row.worst_mm
        );
    }
    let all: u64 = rows.values().map(|row| row.moments).sum();
    println!("\n{all} moments as wanted, {wrong} not; no incursion in any that is as wanted.");
}

//! Kills sessions at random moments, resumes them, and prints the results. The exit code is 1 if a check
//! fails.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;
use keepout_tests::kills::{KillMoment, KillOutcome, KilledPart, Trials, keepout_program};

/// Kills the executor or the controller, or pulls the cable, at random moments, and resumes the session.
#[derive(Debug, Parser)]
struct Arguments {
    /// Count of moments.
    #[arg(long, default_value_t = 60)]
    moments: u64,
    /// Number of the first moment. The number is the seed of the moment.
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Sessions on three axes, of a part with depths.
    #[arg(long)]
    three_axes: bool,
    /// Sessions at the same time.
    #[arg(long, default_value_t = 4)]
    parallel: usize,
    /// Folder for the files of failed moments.
    #[arg(long, default_value = "target/kills")]
    output: PathBuf,
    /// The keepout program. Without this option Cargo builds the one in this program's folder.
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
    let part = if arguments.three_axes { KilledPart::Deep } else { KilledPart::Flat };
    let trials = match program.and_then(|program| Trials::new(&arguments.output, program, part)) {
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
        "| killed | in phase | moments | resumed | commands replayed | positions checked | closest, mm \
         | cut to profile, mm |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|--:|");
    for ((victim, phase), row) in rows {
        println!(
            "| {victim} | {phase} | {} | {} | {} | {} | {:.5} | {:.4} |",
            row.moments, row.resumed, row.commands, row.watched, row.closest_mm, row.worst_mm
        );
    }
    let all: u64 = rows.values().map(|row| row.moments).sum();
    println!("\n{all} moments passed, {wrong} failed. No gouge in any moment that passed.");
}

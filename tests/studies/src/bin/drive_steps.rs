//! Measures the time of a step of each drive controller, and compares it with the sampling period.
//!
//! `cargo run --release -p keepout-studies --bin drive_steps -- --steps 1000000`

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use keepout_drives::controllers::kind::Kind;
use keepout_drives::plant::Plant;
use keepout_drives::profile::DriveProfile;
use keepout_drives::reference::ReferenceWindow;
use keepout_studies::koren_lo::comparison::{ModelError, Row};
use keepout_studies::koren_lo::scenario::DriveScenario;

/// Measure the time of controller steps over all built-in scenarios.
#[derive(Debug, Parser)]
struct Arguments {
    /// Number of steps of each controller.
    #[arg(long, default_value_t = 1_000_000)]
    steps: usize,
    /// Measure this controller only.
    #[arg(long, value_name = "NAME")]
    controller: Option<String>,
    /// Number of measurements of the same steps. The shortest time of each step counts, which removes the
    /// influence of other programs on this computer.
    #[arg(long, default_value_t = 1)]
    repeats: u32,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("drive_steps: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let kinds = match &arguments.controller {
        None => Kind::ALL.to_vec(),
        Some(name) => vec![Kind::named(name).ok_or_else(|| format!("unknown controller {name}"))?],
    };
    let mut rows = Vec::new();
    for scenario in DriveScenario::built_in().map_err(|error| error.to_string())? {
        let machine = DriveProfile::load(&scenario.machine).map_err(|error| error.to_string())?;
        rows.push(Row::new(&scenario, &machine));
    }
    if arguments.repeats > 1 {
        println!("Shortest of {} measurements of each step.\n", arguments.repeats);
    }
    println!(
        "| step of | steps | p50 µs | p99 µs | p99.9 µs | max µs | max / 4 ms |\n\
         |---|---|---|---|---|---|---|"
    );
    for kind in kinds {
        let mut taken = timed(&rows, kind, arguments.steps);
        for _ in 1..arguments.repeats {
            let again = timed(&rows, kind, arguments.steps);
            taken.iter_mut().zip(again).for_each(|(least, again)| *least = again.min(*least));
        }
        println!("{}", line(kind, taken));
    }
    Ok(())
}

fn line(kind: Kind, mut taken: Vec<u32>) -> String {
    taken.sort_unstable();
    let at = |numerator: usize, denominator: usize| {
        let index = (taken.len() * numerator / denominator).min(taken.len().saturating_sub(1));
        f64::from(taken.get(index).copied().unwrap_or(0)) / 1000.0
    };
    let max = at(1, 1);
    format!(
        "| {} | {} | {:.2} | {:.2} | {:.2} | {max:.1} | {:.1} % |",
        kind.names().1,
        taken.len(),
        at(1, 2),
        at(99, 100),
        at(999, 1000),
        max / 40.0
    )
}

/// Times of `steps` steps, ns, over all rows in turn.
fn timed(rows: &[Row], kind: Kind, steps: usize) -> Vec<u32> {
    let mut taken = Vec::with_capacity(steps);
    while taken.len() < steps {
        let before = taken.len();
        for row in rows {
            let Some(mut controller) = kind.built(&row.setting(ModelError::NONE)) else { continue };
            let samples = &row.task.reference;
            let mut plant = Plant::at_rest(row.task.plant, samples[0].position());
            for (now, sample) in samples.iter().enumerate().take(steps - taken.len()) {
                let (window, measured) = (ReferenceWindow::new(samples, now), plant.measured());
                let start = Instant::now();
                let command = controller.step(&window, measured);
                let ns = start.elapsed().as_nanos();
                taken.push(u32::try_from(ns).unwrap_or(u32::MAX));
                plant.step(command, &row.task.load(sample));
            }
        }
        if taken.len() == before {
            break;
        }
    }
    taken
}

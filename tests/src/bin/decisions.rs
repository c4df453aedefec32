//! How long a decision takes: operator input or reply in, command bytes out.
//!
//! `cargo run --release -p keepout-tests --bin decisions -- --segments 100000 --decisions 10000000`

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use keepout_executor::supervisor::{Phase, Workpiece};
use keepout_tests::decisions::{Cause, Decisions};
use keepout_tests::hostile::{Hostile, Style};
use keepout_tests::{order, plan_bytes};

/// Times decisions on a large plan.
#[derive(Debug, Parser)]
struct Arguments {
    /// Segments of the drawing.
    #[arg(long, default_value_t = 100_000)]
    segments: u32,
    /// Decisions that are timed.
    #[arg(long, default_value_t = 10_000_000)]
    decisions: u64,
}

/// Times in classes of a sixteenth of a power of two, in ns.
struct Histogram {
    classes: [u64; 16 * 40],
    count: u64,
    max: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { classes: [0; 16 * 40], count: 0, max: 0 }
    }
}

impl Histogram {
    fn add(&mut self, ns: u64) {
        let ns = ns.max(16);
        let log = ns.ilog2();
        let within = (ns >> (log - 4)) & 15;
        let class = usize::try_from(u64::from(log - 4) * 16 + within).unwrap_or(usize::MAX);
        self.classes[class.min(16 * 40 - 1)] += 1;
        self.count += 1;
        self.max = self.max.max(ns);
    }

    /// The upper end of the class in which the share `(numerator / denominator)` of all times is reached, µs.
    fn quantile(&self, numerator: u64, denominator: u64) -> f64 {
        let wanted = (self.count * numerator).div_ceil(denominator);
        let mut sum = 0;
        for (class, &count) in (0_u32..).zip(&self.classes) {
            sum += count;
            if sum >= wanted {
                return f64::from(16 + class % 16 + 1) * 2.0_f64.powi(i32::try_from(class / 16).unwrap_or(0))
                    / 1000.0;
            }
        }
        0.0
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("decisions: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let drawing = wavy(arguments.segments);
    let plan = plan_bytes("wavy", drawing.as_bytes(), &order(3.0)).map_err(|error| error.to_string())?;
    let motions: usize = plan.plan.finish().loops.iter().map(|each| each.curves.len()).sum();
    println!("{} edges, {motions} motions in the finishing path", plan.part.edges().len());
    let work = Workpiece::new(plan);
    let mut all = Histogram::default();
    let mut by_cause = [
        (Cause::Reply, Histogram::default()),
        (Cause::Wish, Histogram::default()),
        (Cause::Tick, Histogram::default()),
    ];
    let mut seed = 0;
    'all: loop {
        for style in Style::ALL {
            seed += 1;
            let mut run = Decisions::new(work.clone(), Box::new(Hostile::new(style, false, seed)))?;
            let end = all.count + arguments.decisions / 50;
            while all.count < end {
                if all.count >= arguments.decisions {
                    break 'all;
                }
                let started = run.phase() != Phase::Starting;
                run.step(|cause, take| {
                    let began = Instant::now();
                    take();
                    let ns = u64::try_from(began.elapsed().as_nanos()).unwrap_or(u64::MAX);
                    if started {
                        all.add(ns);
                        by_cause.iter_mut().filter(|each| each.0 == cause).for_each(|each| each.1.add(ns));
                    }
                });
            }
        }
    }
    println!(
        "| decisions on | count | p50 µs | p99 µs | p99.9 µs | p99.99 µs | max µs |\n|---|---|---|---|---|---|---|"
    );
    row("all", &all);
    for (cause, histogram) in &by_cause {
        row(&format!("{cause:?}"), histogram);
    }
    Ok(())
}

fn row(name: &str, histogram: &Histogram) {
    let us = |numerator, denominator| histogram.quantile(numerator, denominator);
    println!(
        "| {name} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {}.{} |",
        histogram.count,
        us(1, 2),
        us(99, 100),
        us(999, 1000),
        us(9999, 10_000),
        histogram.max / 1000,
        histogram.max % 1000 / 100
    );
}

/// A wavy outline of so many lines, 300 mm across.
fn wavy(segments: u32) -> String {
    let mut text =
        String::from("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n");
    let _ = write!(text, "0\nLWPOLYLINE\n8\n0\n90\n{segments}\n70\n1\n");
    for k in 0..segments {
        let phi = TAU * f64::from(k) / f64::from(segments);
        let r = 130.0 + 15.0 * (9.0 * phi).sin() + 0.4 * (170.0 * phi).sin();
        let _ = write!(text, "10\n{:.5}\n20\n{:.5}\n", r * phi.cos(), r * phi.sin());
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    text
}

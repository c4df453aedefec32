//! Measures the time of a decision: from an operator's input or a reply to the command bytes.
//!
//! `cargo run --release -p keepout-tests --bin decisions -- --segments 100000 --decisions 10000000`

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use keepout_executor::supervisor::{Phase, PreparedPlan};
use keepout_guard::Time;
use keepout_kernel::Height;
use keepout_planner::Mm2;
use keepout_planner::depth::{DepthParameters, EntryMove, FaceChoice, FaceDepth};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::point_mm;
use keepout_tests::decisions::{Cause, Decisions};
use keepout_tests::histogram::Histogram;
use keepout_tests::hostile::{Hostile, Style};
use keepout_tests::order;

/// Measures the time of decisions on a large plan.
#[derive(Debug, Parser)]
struct Arguments {
    /// Segments of the drawing.
    #[arg(long, default_value_t = 100_000)]
    segments: u32,
    /// Count of decisions.
    #[arg(long, default_value_t = 10_000_000)]
    decisions: u64,
    /// Repeat the same run, and take the least time of each decision. This leaves out the time of other
    /// programs.
    #[arg(long, default_value_t = 1)]
    repeats: u32,
    /// Measure a part on three axes too: first with its lowest level alone, then with this many levels.
    #[arg(long)]
    levels: Option<u32>,
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
    let Some(levels) = arguments.levels else {
        return measure(arguments, plan(&wavy(arguments.segments, 1), None)?).map(drop);
    };
    if !(2..=LEVELS_MAX).contains(&levels) {
        return Err(format!("--levels must be from 2 to {LEVELS_MAX}"));
    }
    let mut measured = Vec::new();
    for levels in [1, levels] {
        let drawing = wavy(arguments.segments, levels);
        let began = Instant::now();
        let plan = plan(&drawing, Some(levels))?;
        let planned_s = began.elapsed().as_secs_f64();
        println!("{levels} levels: planned in {planned_s:.2} s");
        measured.push((planned_s, measure(arguments, plan)?));
    }
    let [(plan_one, p999_one), (plan_all, p999_all)] = measured[..] else { return Ok(()) };
    println!(
        "{levels} levels to one: {:.2} in the time of planning, {:.2} in the p99.9 of decisions",
        plan_all / plan_one,
        p999_all / p999_one
    );
    Ok(())
}

/// The plan of a drawing. With levels, each ring of the drawing stands a step higher than the one around it.
fn plan(drawing: &str, levels: Option<u32>) -> Result<CertifiedPlan, String> {
    let mut request = order(3.0);
    let mut machine = MachineProfile::simulated();
    if let Some(levels) = levels {
        let face = |ring: u32| FaceDepth {
            of: FaceChoice::Contour(usize::try_from(ring).unwrap_or(usize::MAX)),
            depth_mm: Some(f64::from(levels - ring)),
        };
        let thickness_mm = f64::from(levels);
        request.job.depth = Some(DepthParameters {
            faces: (1..=levels).map(face).collect(),
            step_down_mm: Some(thickness_mm + 1.0),
            entry: EntryMove::Plunge,
            ..DepthParameters::of(thickness_mm)
        });
        machine = MachineProfile::simulated_three_axes();
    }
    request.plan("wavy", drawing.as_bytes(), &machine, &mut |_| {}).map_err(|error| error.to_string())
}

/// Measures decisions with a plan, and prints them. Returns the p99.9 of all, µs.
fn measure(arguments: &Arguments, plan: CertifiedPlan) -> Result<f64, String> {
    let motions: usize = plan.plan.finish().loops.iter().map(|each| each.curves.len()).sum();
    let edges = plan.part.edges().len();
    let deepest = plan.plan.relief.as_ref().map_or(Height::ZERO, |relief| relief.deepest);
    let work = PreparedPlan::new(plan);
    let simplified = work.simplified().at(deepest).edges().len();
    println!("{edges} edges, {simplified} for jogging, {motions} motions in the finishing path");
    let mut taken = Vec::new();
    let mut travelled = Travelled::default();
    for _ in 0..arguments.repeats.max(1) {
        travelled = Travelled::default();
        let decisions = time_decisions(arguments, &work, &mut travelled)?;
        if taken.is_empty() {
            taken = decisions;
        } else {
            taken.iter_mut().zip(decisions).for_each(|(least, again)| least.ns = least.ns.min(again.ns));
        }
    }
    println!("{}", Histogram::heading("decisions on"));
    let all = row("all", taken.iter());
    for cause in [Cause::Reply, Cause::OperatorInput, Cause::Tick] {
        row(&format!("{cause:?}"), taken.iter().filter(|each| each.cause == cause));
    }
    for phase in [Phase::Manual, Phase::Sliding, Phase::Retracting, Phase::Touching, Phase::Contouring] {
        row(&format!("{phase:?}"), taken.iter().filter(|each| each.phase == phase));
    }
    println!("\n{travelled}");
    Ok(all)
}

/// The time of one decision.
struct Taken {
    ns: u32,
    cause: Cause,
    phase: Phase,
}

/// The motion that the operators' inputs caused.
#[derive(Default)]
struct Travelled {
    way_mm: f64,
    hours: f64,
    jogs: u64,
    cancels: u64,
    clipped: u64,
}

impl std::fmt::Display for Travelled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { way_mm, hours, jogs, cancels, clipped } = self;
        write!(
            f,
            "{:.0} m travelled in {hours:.2} h, {jogs} jogs, {cancels} cancels, {clipped} jogs clipped",
            way_mm / 1000.0
        )
    }
}

impl Travelled {
    fn add(&mut self, run: &Decisions) {
        let counts = run.supervisor().counts();
        self.hours += run.now().since(Time::ZERO).as_secs_f64() / 3600.0;
        self.jogs += counts.jogs;
        self.cancels += counts.cancels;
        self.clipped += counts.clipped;
    }
}

fn time_decisions(
    arguments: &Arguments,
    work: &PreparedPlan,
    travelled: &mut Travelled,
) -> Result<Vec<Taken>, String> {
    let wanted = usize::try_from(arguments.decisions).unwrap_or(usize::MAX);
    let mut taken: Vec<Taken> = Vec::new();
    let mut seed = 0;
    loop {
        for style in Style::ALL {
            seed += 1;
            let mut run = Decisions::new(work.clone(), Box::new(Hostile::new(style, false, seed)))?;
            let end = (taken.len() + wanted / 50).min(wanted);
            let mut at = None;
            while taken.len() < end {
                let phase = run.phase();
                run.step(|cause, take| {
                    let began = Instant::now();
                    take();
                    let ns = u32::try_from(began.elapsed().as_nanos()).unwrap_or(u32::MAX);
                    if phase != Phase::Starting {
                        taken.push(Taken { ns, cause, phase });
                    }
                });
                if let Some(Mm2 { x, y }) = run.supervisor().position().map(|place| point_mm(place.point)) {
                    if let Some((x0, y0)) = at {
                        travelled.way_mm += f64::hypot(x - x0, y - y0);
                    }
                    at = Some((x, y));
                }
            }
            travelled.add(&run);
            if taken.len() >= wanted {
                return Ok(taken);
            }
        }
    }
}

/// Prints a row of the table. Returns its p99.9, µs.
fn row<'a>(name: &str, decisions: impl Iterator<Item = &'a Taken>) -> f64 {
    let mut histogram = Histogram::default();
    decisions.for_each(|each| histogram.add(u64::from(each.ns)));
    println!("{}", histogram.row(name));
    histogram.quantile(999, 1000)
}

/// Most levels of the measured part: its rings are 8 mm apart.
const LEVELS_MAX: u32 = 14;

/// Wavy outlines of `segments` lines each, one within the other, as DXF. The outer one is about 300 mm across.
fn wavy(segments: u32, rings: u32) -> String {
    let mut text =
        String::from("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n");
    for ring in 0..rings {
        let _ = write!(text, "0\nLWPOLYLINE\n8\n0\n90\n{segments}\n70\n1\n");
        for k in 0..segments {
            let phi = TAU * f64::from(k) / f64::from(segments);
            let r = 130.0 - 8.0 * f64::from(ring) + 15.0 * (9.0 * phi).sin() + 0.4 * (170.0 * phi).sin();
            let _ = write!(text, "10\n{:.5}\n20\n{:.5}\n", r * phi.cos(), r * phi.sin());
        }
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    text
}

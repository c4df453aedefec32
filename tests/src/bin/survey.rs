//! Reads and plans every drawing of the shared set, compares it with the independent reading, and prints a
//! table.
//!
//! `KEEPOUT_SHARED=... cargo run --release -p keepout-tests --bin survey -- --write
//! docs/research/drawings.md`

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Parser;
use keepout_planner::drawing::{EntityFilter, read_file};
use keepout_planner::file::OUTPUT;
use keepout_planner::inspect::{Inspection, inspect};
use keepout_planner::plan::PlanError;
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::PlanRequestError;
use keepout_tests::oracle::{self, Oracle};
use keepout_tests::{order, plan_bytes, shared};
use serde::Deserialize;

/// Reads, compares and plans every drawing of the shared set, with four tools on both sides.
#[derive(Debug, Parser)]
struct Arguments {
    /// File for the page. Without it the program prints the page.
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
    /// Write a drawing with this count of lines to this file instead, for tests of large drawings.
    #[arg(long, num_args = 2, value_names = ["COUNT", "FILE"])]
    make_lines: Option<Vec<String>>,
}

const TOOLS_MM: [f64; 4] = [1.0, 3.0, 6.0, 12.0];
const SIDES: [(MachinedSide, &str); 2] =
    [(MachinedSide::Outside, "outside"), (MachinedSide::Inside, "inside")];

/// Reasons for our differences from the oracle, by file name.
#[derive(Deserialize)]
struct Explained {
    reason: BTreeMap<String, String>,
}

/// The results of one drawing.
struct Row {
    name: String,
    clean: bool,
    agrees: Option<Result<(), String>>,
    text: String,
    notes: Vec<String>,
    plans: usize,
    refusals: BTreeMap<String, usize>,
    faults: Vec<String>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some([count, file]) = arguments.make_lines.as_deref() {
        return make_lines(count, Path::new(file));
    }
    let Some(shared) = shared() else { return ExitCode::from(2) };
    let entries = match oracle::read(&shared) {
        Ok(entries) => entries,
        Err(reason) => {
            eprintln!("{reason}");
            return ExitCode::from(2);
        }
    };
    let names: Vec<(&String, &Oracle)> = entries.iter().collect();
    let next = AtomicUsize::new(0);
    let rows = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some((name, oracle)) = names.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let row = look_at(&shared.join("dxf").join(name), name, oracle);
                    eprintln!("{}", row.text);
                    if let Ok(mut rows) = rows.lock() {
                        rows.push(row);
                    }
                }
            });
        }
    });
    let mut rows = rows.into_inner().unwrap_or_default();
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    let page = page(&rows);
    let faults: usize = rows.iter().map(|row| row.faults.len()).sum();
    match &arguments.write {
        Some(path) => {
            if let Err(error) = OUTPUT.write(path, page.as_bytes()) {
                eprintln!("{error}");
                return ExitCode::from(2);
            }
        }
        None => println!("{page}"),
    }
    ExitCode::from(u8::from(faults > 0))
}

/// Writes a wavy outline of separate lines, with noise of ±0.3 µm.
fn make_lines(count: &str, file: &Path) -> ExitCode {
    let Some(count) = count.parse::<u32>().ok().filter(|count| (3..=2_000_000).contains(count)) else {
        eprintln!("{count} is not a count of lines: give 3 to 2000000");
        return ExitCode::from(2);
    };
    let mut random = fastrand::Rng::with_seed(5);
    let noise: Vec<f64> = (0..count).map(|_| random.f64() * 0.000_6 - 0.000_3).collect();
    let at = |k: usize| {
        let share = f64::from(u32::try_from(k).unwrap_or(0)) / f64::from(count);
        let a = std::f64::consts::TAU * share;
        let r = 150.0 * (0.75 + 0.2 * (5.0 * a).sin() + 0.04 * (37.0 * a).sin()) + noise[k];
        (200.0 + r * a.cos(), 175.0 + r * a.sin())
    };
    let mut text = String::from("0\nSECTION\n2\nENTITIES\n");
    for k in 0..noise.len() {
        let ((x0, y0), (x1, y1)) = (at(k), at((k + 1) % noise.len()));
        let _ = write!(
            text,
            "  0\nLINE\n  8\n0\n 10\n{x0:.9}\n 20\n{y0:.9}\n 30\n0.0\n 11\n{x1:.9}\n 21\n{y1:.9}\n 31\n0.0\n"
        );
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    match OUTPUT.write(file, text.as_bytes()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn look_at(path: &Path, name: &str, oracle: &Oracle) -> Row {
    let file = name.trim_start_matches("dev/").to_string();
    let mut row = Row {
        name: file.clone(),
        clean: oracle.defects.is_empty(),
        agrees: None,
        text: String::new(),
        notes: Vec::new(),
        plans: 0,
        refusals: BTreeMap::new(),
        faults: Vec::new(),
    };
    let read = read_file(path).map_err(|error| error.to_string()).and_then(|bytes| {
        let contours = order(3.0).contours(&bytes).map_err(|error| error.to_string())?;
        Ok((bytes, inspect(&contours.0, &contours.1, &EntityFilter::default())))
    });
    let reading = match read {
        Err(message) => {
            row.notes.push(message);
            "message".to_string()
        }
        Ok((bytes, found)) => {
            row.agrees = oracle.reading.as_ref().map(|reading| reading.agrees(&found));
            plan_all(&file, &bytes, &found, &mut row);
            let [repairs, problems] = [found.repairs.len(), found.problems.len()];
            if let Some(first) = found.problems.first() {
                row.notes.push(format!("{problems} problems, the first: {}", first.text));
            }
            format!(
                "{} contours, {:.2} mm², {repairs} repairs, {problems} problems",
                found.contours.len(),
                found.area_mm2
            )
        }
    };
    let verdict = match &row.agrees {
        None => "–".to_string(),
        Some(Ok(())) => "agrees".to_string(),
        Some(Err(difference)) => format!("**{difference}**"),
    };
    let refusals: Vec<String> = row.refusals.iter().map(|(why, count)| format!("{count} {why}")).collect();
    let plans = match (row.plans, refusals.is_empty()) {
        (0, true) => "–".to_string(),
        (n, true) => format!("{n} of 8 certified"),
        (n, false) => format!("{n} of 8 certified; {}", refusals.join(", ")),
    };
    row.text = format!(
        "| {file} | {} | {} | {} | {reading} | {verdict} | {plans} |",
        oracle.exporter,
        oracle.version,
        oracle.defects.join(", ")
    );
    row
}

/// Plans with every tool on both sides. Each plan must certify again from its file, or give an expected
/// message.
fn plan_all(file: &str, bytes: &[u8], found: &Inspection, row: &mut Row) {
    for tool_mm in TOOLS_MM {
        for (side, side_name) in SIDES {
            let mut wanted = order(tool_mm);
            wanted.job.side = side;
            let fault = |text: String| format!("{file}, {tool_mm} mm, {side_name}: {text}");
            match plan_bytes(file, bytes, &wanted) {
                Ok(plan) => {
                    row.plans += 1;
                    let again = keepout_planner::plan_file::encode(&plan.plan)
                        .and_then(|bytes| keepout_planner::plan_file::decode(&bytes));
                    match again.map(keepout_planner::plan::Plan::certify) {
                        Ok(Ok(_)) => {}
                        Ok(Err(error)) => row.faults.push(fault(error.to_string())),
                        Err(error) => row.faults.push(fault(error.to_string())),
                    }
                }
                Err(error) => {
                    let why = match &error {
                        PlanRequestError::Plan(PlanError::Finish(finish)) => match finish {
                            keepout_planner::finish::FinishError::ToolFitsNowhere { .. } => {
                                "tool fits nowhere"
                            }
                            keepout_planner::finish::FinishError::LooseEnds { .. } => "no closed path found",
                        },
                        PlanRequestError::Plan(PlanError::Pass { .. }) => "path not certified",
                        PlanRequestError::Plan(PlanError::Profile(_)) => "contours touch or cross",
                        PlanRequestError::Plan(_) => "other",
                        PlanRequestError::Drawing(_)
                        | PlanRequestError::Select(_)
                        | PlanRequestError::Travel { .. } => "contours open",
                    };
                    *row.refusals.entry(why.into()).or_default() += 1;
                    let expected = matches!(why, "tool fits nowhere") || !found.problems.is_empty();
                    if !expected {
                        row.faults.push(fault(error.to_string()));
                    }
                }
            }
        }
    }
}

fn page(rows: &[Row]) -> String {
    let explained: Explained = toml::from_str(include_str!("../../disagreements.toml"))
        .unwrap_or(Explained { reason: BTreeMap::new() });
    let clean: Vec<&Row> = rows.iter().filter(|row| row.clean).collect();
    let agree = |rows: &[&Row]| rows.iter().filter(|row| matches!(row.agrees, Some(Ok(())))).count();
    let all: Vec<&Row> = rows.iter().collect();
    let plans: usize = rows.iter().map(|row| row.plans).sum();
    let faults: Vec<&String> = rows.iter().flat_map(|row| &row.faults).collect();
    let mut out = format!(
        "# Real drawings\n\nMade by `KEEPOUT_SHARED=... cargo run --release -p keepout-tests --bin survey -- \
         --write docs/research/drawings.md`.\n\n\
         The survey reads {} drawings of many exporters, without options. It compares each with an independent\n\
         reading, which other libraries made: the number of closed contours, their area by the even-odd rule\n\
         within 0.1 %, and the box around them within 0.02 mm. It plans each with tools of 1, 3, 6 and 12 mm on\n\
         both sides. It certifies every plan, writes it, reads it, and certifies it again.\n\n\
         - Drawings without a defect by the independent reading: {} of {} agree.\n\
         - All drawings: {} of {} agree.\n\
         - Plans certified: {plans}. Plans that failed unexpectedly: {}.\n\n\
         | drawing | exporter | version | defects by the independent reading | our reading | compared \
         | plans |\n\
         |---|---|---|---|---|---|---|\n",
        rows.len(),
        agree(&clean),
        clean.len(),
        agree(&all),
        rows.iter().filter(|row| row.agrees.is_some()).count(),
        faults.len()
    );
    for row in rows {
        let _ = writeln!(out, "{}", row.text);
    }
    out.push_str("\n## Differences\n\n");
    for row in rows {
        if let Some(Err(difference)) = &row.agrees {
            let why = explained.reason.get(&row.name).map_or("not explained", String::as_str);
            let _ = writeln!(out, "- **{}**: {difference}. {why}", row.name);
        }
    }
    out.push_str("\n## Messages\n\n");
    for row in rows {
        for note in &row.notes {
            let _ = writeln!(out, "- **{}**: {}", row.name, note.lines().next().unwrap_or(""));
        }
    }
    if !faults.is_empty() {
        out.push_str("\n## Plans that failed\n\n");
        for fault in faults {
            let _ = writeln!(out, "- {fault}");
        }
    }
    out
}

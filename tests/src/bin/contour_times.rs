//! Compares contour times with plain streaming of the same G-code on the simulated controller, as a table.
//!
//! `KEEPOUT_SHARED=... cargo run --release -p keepout-tests --bin contour_times`
//!
//! The peer is a sender with character counting: it keeps the controller's receive buffer full, and does not
//! check the result of a line. Both use the same serial line and the same controller. Times are machine
//! times, so they are the same on every computer.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Duration;

use clap::Parser;
use keepout_executor::dialect::DialectName;
use keepout_executor::session::{
    EventLog, EventLogError, Going, LoggedEvent, Sample, SampleKind, place_on_table,
};
use keepout_executor::supervisor::{Phase, PreparedPlan};
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::drawing::read_file;
use keepout_planner::machine::MachineProfile;
use keepout_planner::units::mm;
use keepout_sim::session::{SimRun, run_simulated};
use keepout_sim::{PositioningError, SimMachine, SimSettings, operator, speaking};
use keepout_tests::{REAL_DRAWINGS, order, plan_bytes};

/// Compares contour times with plain streaming.
#[derive(Debug, Parser)]
struct Arguments {
    /// Feeds, mm/min.
    #[arg(long, value_delimiter = ',', default_values_t = [900, 3000, 6000])]
    feeds: Vec<u32>,
    /// Delays each way, ms.
    #[arg(long, value_delimiter = ',', default_values_t = [0, 100])]
    delays_ms: Vec<u64>,
    /// Tool diameter, mm.
    #[arg(long, default_value_t = 3.0)]
    tool_mm: f64,
    /// Dialect of the controller: grbl or grblhal.
    #[arg(long, default_value = "grbl")]
    dialect: String,
    /// Only drawings whose name contains this.
    #[arg(long, default_value = "")]
    only: String,
}

/// A time, s, and the true position at it, mm.
type Place = (f64, Mm2);

/// The figures of a run along a contour.
#[derive(Clone, Copy, Debug, Default)]
struct Measured {
    seconds: f64,
    length_mm: f64,
    /// Count of stops, without the one at the end.
    stops: usize,
    /// Count of falls below 40 % of the feed, without the one at the end.
    dips: usize,
}

/// Time between two compared positions, s.
const BIN_S: f64 = 0.010;

fn measure(places: &[Place], feed_mm_min: u32) -> Measured {
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return Measured::default() };
    let mut measured = Measured { seconds: last.0 - first.0, ..Measured::default() };
    let mut speeds = Vec::new();
    let (mut before, mut due) = (*first, first.0 + BIN_S);
    for pair in places.windows(2) {
        let ((t0, a), (t1, b)) = (pair[0], pair[1]);
        measured.length_mm += a.distance(b);
        while t1 >= due && t1 > t0 {
            let share = (due - t0) / (t1 - t0);
            let at = a + (b - a) * share;
            speeds.push(before.1.distance(at) / BIN_S);
            (before, due) = ((due, at), due + BIN_S);
        }
    }
    let feed = f64::from(feed_mm_min) / 60.0;
    measured.stops = falls_below(&speeds, 0.05 * feed);
    measured.dips = falls_below(&speeds, 0.4 * feed);
    measured
}

/// Counts how often the speed falls below a level. The fall at the end does not count.
fn falls_below(speeds: &[f64], level: f64) -> usize {
    let falls = speeds.windows(2).filter(|pair| pair[0] >= level && pair[1] < level).count();
    let ends_below = speeds.last().is_some_and(|&last| last < level);
    falls - usize::from(ends_below && falls > 0)
}

/// An event log that keeps the sent lines of the contour.
#[derive(Clone, Default)]
struct Lines(Rc<RefCell<Vec<String>>>);

impl EventLog for Lines {
    fn take(&mut self, _: Time, event: &LoggedEvent<'_>) -> Result<(), EventLogError> {
        if let LoggedEvent::Sent(bytes) = event {
            let text = String::from_utf8_lossy(bytes);
            let lines = text.lines().filter(|line| ["G1G", "G2G", "G3G"].iter().any(|g| line.starts_with(g)));
            self.0.borrow_mut().extend(lines.map(plain));
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), EventLogError> {
        Ok(())
    }
}

/// The line of a plain sender: without the modal words.
fn plain(line: &str) -> String {
    let words = line.find('X').unwrap_or(0);
    format!("{}{}", &line[..2], &line[words..])
}

struct Case<'a> {
    work: &'a PreparedPlan,
    language: DialectName,
    feed_mm_min: u32,
    delay: Duration,
}

/// The product's contour: its figures, its lines, and its first position in machine coordinates, mm.
type Cut = (Measured, Vec<String>, Mm2);

/// A machine with travel for every drawing.
fn machine() -> MachineProfile {
    MachineProfile { travel_mm: [900.0, 900.0], repeatability_mm: 0.0, ..MachineProfile::simulated() }
}

impl Case<'_> {
    /// Runs the product: contact start, and the whole contour.
    fn ours(&self) -> Result<Cut, String> {
        let run = SimRun {
            machine: machine(),
            servo: None,
            dialect: self.language.clone(),
            latency: self.delay,
            feed_mm_min: self.feed_mm_min,
            limit: Duration::from_secs(20_000),
            ..SimRun::default()
        };
        let offset =
            place_on_table(&self.work.plan, &run.machine, None).map_err(|error| error.to_string())?.offset;
        let lines = Lines::default();
        let operator = operator::named("calm", 0.1, 1).map_err(|error| error.to_string())?;
        let (mut begins, mut first) = (None, None);
        let result = run_simulated(
            self.work.clone(),
            &run,
            operator,
            Box::new(lines.clone()),
            &mut |supervisor, _, now| {
                if supervisor.phase() == Phase::Contouring {
                    begins.get_or_insert(now);
                    first = first.or(supervisor.position());
                }
                Going::On
            },
        )
        .map_err(|error| error.to_string())?;
        if !result.facts.outcome.is_by_operator() {
            return Err(result.facts.outcome.to_string());
        }
        let first = first.ok_or("no contour was cut")?;
        let places: Vec<Place> = result
            .samples
            .iter()
            .filter(|sample| sample.kind == SampleKind::Run)
            .map(|sample| (sample.at.elapsed().as_secs_f64(), sample.position_mm.plane()))
            .collect();
        let at = Mm2::new(mm(first.point.x.units() + offset.dx), mm(first.point.y.units() + offset.dy));
        let lines = lines.0.borrow().clone();
        Ok((measure(&places, self.feed_mm_min), lines, at))
    }

    /// Streams the same lines from a sender with character counting.
    fn streamed(&self, lines: &[String], start_mm: Mm2) -> Measured {
        let settings = SimSettings::of(machine(), start_mm.at_height(0.0));
        let buffer = if self.language == DialectName::Grbl { 127 } else { 1023 };
        let controller = speaking(&self.language, settings);
        let mut machine = SimMachine::new(
            controller,
            115_200,
            self.delay,
            PositioningError::wandering(0.0, machine().steps_per_mm, 1),
        );
        let (mut now, step) = (Time::ZERO, Duration::from_micros(500));
        let (mut open, mut bytes, mut samples, mut received) =
            (VecDeque::new(), Vec::new(), Vec::new(), Vec::new());
        let mut left: VecDeque<String> = lines.iter().map(|line| format!("{line}\n")).collect();
        let mut rest = 0;
        // It ends after half a minute without an open line.
        while rest < 60_000 {
            while let Some(line) = left.pop_front_if(|line| open.iter().sum::<usize>() + line.len() <= buffer)
            {
                open.push_back(line.len());
                machine.host_writes(line.as_bytes(), now);
            }
            now = now.after(step);
            machine.advance(now);
            bytes.clear();
            machine.host_reads(&mut bytes, now);
            received.extend(&bytes);
            while let Some(end) = received.iter().position(|&byte| byte == b'\n') {
                if received.drain(..=end).collect::<Vec<u8>>().starts_with(b"ok") {
                    open.pop_front();
                }
            }
            machine.take_samples(&mut samples);
            rest = if left.is_empty() && open.is_empty() { rest + 1 } else { 0 };
        }
        let moving = |sample: &&Sample| sample.kind == SampleKind::Run;
        let places: Vec<Place> = samples
            .iter()
            .filter(moving)
            .map(|sample| (sample.at.elapsed().as_secs_f64(), sample.position_mm.plane()))
            .collect();
        measure(&places, self.feed_mm_min)
    }
}

/// An egg of 900 chords of 0.2 mm, as CAM programs and converters export a curve.
fn egg() -> Vec<u8> {
    let mut text = String::from(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n\
         0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\n0\n90\n900\n70\n1\n",
    );
    for k in 0..900 {
        let phi = f64::from(k) / 900.0 * std::f64::consts::TAU;
        let radius = 28.65 * (1.0 + 0.12 * phi.cos());
        text += &format!("10\n{:.6}\n20\n{:.6}\n", radius * phi.cos(), radius * phi.sin());
    }
    text += "0\nENDSEC\n0\nEOF\n";
    text.into_bytes()
}

fn drawings(only: &str) -> Vec<(String, Vec<u8>)> {
    let mut all = vec![
        ("bracket (ours)".to_owned(), include_bytes!("../../../executor/cli/drawings/bracket.dxf").to_vec()),
        ("egg of 0.2 mm chords (ours)".to_owned(), egg()),
    ];
    if let Some(shared) = keepout_tests::shared() {
        for (name, _) in REAL_DRAWINGS {
            if let Ok(bytes) = read_file(&shared.join("dxf/dev").join(name)) {
                all.push((name.to_owned(), bytes));
            }
        }
    }
    all.retain(|(name, _)| name.contains(only));
    all
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let Ok(language) = DialectName::named(&arguments.dialect) else {
        eprintln!("contour_times: there is no dialect {}", arguments.dialect);
        return ExitCode::from(2);
    };
    println!(
        "| drawing | feed mm/min | delay ms | motions | mm | streamed s | ours / streamed \
         | stops ours, streamed | dips per m ours, streamed |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (name, bytes) in drawings(&arguments.only) {
        let work = match plan_bytes(&name, &bytes, &order(arguments.tool_mm)) {
            Ok(plan) => PreparedPlan::new(plan),
            Err(error) => {
                println!("| {name} | – | – | – | – | – | {error} | – | – |");
                continue;
            }
        };
        for &delay_ms in &arguments.delays_ms {
            for &feed_mm_min in &arguments.feeds {
                let delay = Duration::from_millis(delay_ms);
                let case = Case { work: &work, language: language.clone(), feed_mm_min, delay };
                println!("{}", row(&name, &case));
            }
        }
    }
    ExitCode::SUCCESS
}

fn row(name: &str, case: &Case<'_>) -> String {
    let begins = format!("| {name} | {} | {}", case.feed_mm_min, case.delay.as_millis());
    let (ours, lines, start) = match case.ours() {
        Ok(measured) => measured,
        Err(error) => return format!("{begins} | – | – | – | {error} | – | – |"),
    };
    let peer = case.streamed(&lines, start);
    let per_m = |measured: &Measured| {
        let dips: u32 = measured.dips.try_into().unwrap_or(u32::MAX);
        f64::from(dips) * 1000.0 / measured.length_mm.max(1.0)
    };
    format!(
        "{begins} | {} | {:.0} | {:.1} | {:.2} | {}, {} | {:.0}, {:.0} |",
        lines.len(),
        ours.length_mm,
        peer.seconds,
        ours.seconds / peer.seconds.max(1e-9),
        ours.stops,
        peer.stops,
        per_m(&ours),
        per_m(&peer)
    )
}

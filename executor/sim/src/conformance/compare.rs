//! The differences between two recordings of the same scenarios.

use std::collections::BTreeSet;
use std::fmt::{self, Display, Formatter, Write as _};
use std::time::Duration;

use super::findings::{Latency, latency};
use super::observe::{Observed, observe};
use super::recording::Recording;

/// The aspect in which two controllers differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aspect {
    /// Only one recording has the scenario.
    Scenario,
    /// The largest distance from the commanded path.
    Distance,
    /// The order and kind of replies.
    Replies,
    /// The reported states.
    States,
    /// The longest time from a query to its answer.
    Answer,
    /// The longest time from a line to its answer.
    Acknowledgement,
    /// The time from a cancel or hold to rest.
    Stop,
}

impl Display for Aspect {
    fn fmt(&self, to: &mut Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::Scenario => "scenario",
            Self::Distance => "distance from path",
            Self::Replies => "replies",
            Self::States => "states",
            Self::Answer => "answer to a query",
            Self::Acknowledgement => "answer to a line",
            Self::Stop => "stop to rest",
        })
    }
}

/// One difference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The scenario.
    pub scenario: String,
    /// The aspect.
    pub aspect: Aspect,
    /// The value in the first recording.
    pub first: String,
    /// The value in the second recording.
    pub second: String,
}

/// Upper bounds of the timing classes, ms.
const CLASSES_MS: [u64; 4] = [5, 20, 100, 500];
/// Times that differ by at most this share of the longer one are alike, whatever their classes.
const ALIKE: f64 = 0.25;
/// Distances from the path that differ by less than this factor are alike: the deviation depends on the phase
/// of the cancel.
const ALIKE_DISTANCE: f64 = 1.5;
/// Least number of reports that prove a state. A single report can be chance.
const SHOWN: u32 = 2;

/// Lists the differences, by scenario. The phases of one scenario are compared together, because a real
/// machine does not reproduce them to the millisecond.
#[must_use]
pub fn compare(first: &Recording, second: &Recording) -> Vec<Difference> {
    let (ours, theirs) = (observe(first), observe(second));
    let alike = Alike {
        tolerance_mm: first.header.tolerance_mm().max(second.header.tolerance_mm()),
        jitter: jitter(latency(&ours), latency(&theirs)),
    };
    let mut differences = Vec::new();
    for (name, a) in grouped(&ours) {
        match grouped(&theirs).into_iter().find(|(other, _)| *other == name) {
            Some((_, b)) => Pair { name, a, b, alike }.list(&mut differences),
            None => differences.push(only(name, ["played", "missing"])),
        }
    }
    for (name, _) in grouped(&theirs) {
        if !grouped(&ours).iter().any(|(other, _)| *other == name) {
            differences.push(only(name, ["missing", "played"]));
        }
    }
    differences
}

/// The largest difference between two times that the two lines alone explain.
fn jitter(a: Latency, b: Latency) -> Duration {
    let spread = |latency: Latency| latency.most.saturating_sub(latency.median);
    spread(a) + spread(b) + a.median.abs_diff(b.median)
}

/// The scenarios, with their phases grouped.
fn grouped(observed: &[Observed]) -> Vec<(&str, Vec<&Observed>)> {
    let mut groups: Vec<(&str, Vec<&Observed>)> = Vec::new();
    for each in observed {
        let name = match each.name.rsplit_once(", ") {
            Some((name, phase)) if phase.contains(" of ") => name,
            _ => &each.name,
        };
        match groups.iter_mut().find(|(other, _)| *other == name) {
            Some((_, group)) => group.push(each),
            None => groups.push((name, vec![each])),
        }
    }
    groups
}

fn only(scenario: &str, [first, second]: [&str; 2]) -> Difference {
    let (first, second) = (first.into(), second.into());
    Difference { scenario: scenario.into(), aspect: Aspect::Scenario, first, second }
}

/// The limits below which differences do not count.
#[derive(Clone, Copy, Debug)]
struct Alike {
    tolerance_mm: f64,
    jitter: Duration,
}

impl Alike {
    fn distances(self, a: f64, b: f64) -> bool {
        let (less, more) = (a.min(b), a.max(b));
        more <= self.tolerance_mm || less > self.tolerance_mm && more < ALIKE_DISTANCE * less
    }

    fn times(self, a: Duration, b: Duration) -> bool {
        let apart = a.abs_diff(b);
        class(a) == class(b) || apart <= self.jitter || apart <= a.max(b).mul_f64(ALIKE)
    }
}

/// One scenario of both recordings.
struct Pair<'a> {
    name: &'a str,
    a: Vec<&'a Observed>,
    b: Vec<&'a Observed>,
    alike: Alike,
}

impl Pair<'_> {
    fn list(&self, into: &mut Vec<Difference>) {
        let mut differ = |aspect, first: String, second: String| {
            into.push(Difference { scenario: self.name.into(), aspect, first, second });
        };
        let off = |group: &[&Observed]| group.iter().map(|each| each.deviation_mm).fold(0.0, f64::max);
        let (first, second) = (off(&self.a), off(&self.b));
        if !self.alike.distances(first, second) {
            differ(Aspect::Distance, format!("{first:.3} mm"), format!("{second:.3} mm"));
        }
        if let Some((a, b)) = self.a.iter().zip(&self.b).find(|(a, b)| a.replies != b.replies) {
            let (first, second) = first_difference(&a.replies, &b.replies);
            differ(Aspect::Replies, first, second);
        }
        let (first, second) = (missing(&self.a, &self.b), missing(&self.b, &self.a));
        if !first.is_empty() || !second.is_empty() {
            differ(Aspect::States, first, second);
        }
        for aspect in [Aspect::Answer, Aspect::Acknowledgement, Aspect::Stop] {
            let (first, second) = (longest(&self.a, aspect), longest(&self.b, aspect));
            if !self.alike.times(first, second) {
                differ(aspect, class_name(first), class_name(second));
            }
        }
    }
}

/// The longest time of the aspect.
fn longest(group: &[&Observed], aspect: Aspect) -> Duration {
    let time = |each: &&Observed| match aspect {
        Aspect::Answer => each.longest_answer(),
        Aspect::Acknowledgement => each.acknowledged,
        _ => each.stopped.unwrap_or_default(),
    };
    group.iter().map(time).max().unwrap_or_default()
}

/// The states of `a` that `b` does not report.
fn missing(a: &[&Observed], b: &[&Observed]) -> String {
    let reports = |group: &[&Observed], state: &str| -> u32 {
        let states = group.iter().flat_map(|each| &each.states);
        states.filter(|(other, _)| other == state).map(|(_, count)| count).sum()
    };
    let states: BTreeSet<&str> =
        a.iter().flat_map(|each| &each.states).map(|(state, _)| state.as_str()).collect();
    let missing = states.into_iter().filter(|state| reports(a, state) >= SHOWN && reports(b, state) == 0);
    missing.collect::<Vec<_>>().join(" ")
}

/// The first reply that differs in each, with its number.
fn first_difference(a: &[String], b: &[String]) -> (String, String) {
    let at = a.iter().zip(b).take_while(|(a, b)| a == b).count();
    let shown = |replies: &[String]| {
        let reply = replies.get(at).map_or("none", String::as_str);
        format!("{}: {reply}", at + 1)
    };
    (shown(a), shown(b))
}

fn class(time: Duration) -> usize {
    CLASSES_MS.iter().filter(|&&bound| time >= Duration::from_millis(bound)).count()
}

fn class_name(time: Duration) -> String {
    let ms = time.as_secs_f64() * 1e3;
    match CLASSES_MS.get(class(time)) {
        Some(bound) => format!("below {bound} ms ({ms:.1})"),
        None => format!("longer ({ms:.0} ms)"),
    }
}

/// The differences as a table, with at most `rows` rows.
#[must_use]
pub fn table(differences: &[Difference], [first, second]: [&str; 2], rows: usize) -> String {
    let mut text = format!("{:<56} {:<20} {first:<26} {second}\n", "scenario", "in");
    for each in differences.iter().take(rows) {
        let Difference { scenario, aspect, first, second } = each;
        // Writing to a string does not fail.
        let _ = writeln!(text, "{scenario:<56} {:<20} {first:<26} {second}", aspect.to_string());
    }
    if differences.len() > rows {
        let _ = writeln!(text, "and {} more", differences.len() - rows);
    }
    text
}

//! Where two recordings of the same scenarios differ.

use std::fmt::{self, Display, Formatter, Write as _};
use std::time::Duration;

use super::observe::{Observed, observe};
use super::recording::Recording;

/// In what two controllers differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aspect {
    /// Only one recording has the scenario.
    Scenario,
    /// The largest distance from the commanded path.
    Distance,
    /// Order and kind of replies.
    Replies,
    /// The states that were passed through.
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
    /// In what they differ.
    pub aspect: Aspect,
    /// What the first recording shows.
    pub first: String,
    /// What the second shows.
    pub second: String,
}

/// Upper bounds of the timing classes, ms.
const CLASSES_MS: [u64; 4] = [5, 20, 100, 500];
/// Times that differ by less than this share of the longer one are alike, whatever their classes.
const ALIKE: f64 = 0.25;
/// So many reports of a state show it; one report alone can be chance.
const SHOWN: u32 = 2;

/// Lists the differences, by scenario.
#[must_use]
pub fn compare(first: &Recording, second: &Recording) -> Vec<Difference> {
    let tolerance_mm = first.header.tolerance_mm().max(second.header.tolerance_mm());
    let (ours, theirs) = (observe(first), observe(second));
    let mut differences = Vec::new();
    for a in &ours {
        match theirs.iter().find(|b| b.name == a.name) {
            Some(b) => Pair { a, b, tolerance_mm }.list(&mut differences),
            None => differences.push(only(&a.name, ["played", "missing"])),
        }
    }
    for b in theirs.iter().filter(|b| !ours.iter().any(|a| a.name == b.name)) {
        differences.push(only(&b.name, ["missing", "played"]));
    }
    differences
}

fn only(scenario: &str, [first, second]: [&str; 2]) -> Difference {
    let (first, second) = (first.into(), second.into());
    Difference { scenario: scenario.into(), aspect: Aspect::Scenario, first, second }
}

/// One scenario of both recordings.
struct Pair<'a> {
    a: &'a Observed,
    b: &'a Observed,
    tolerance_mm: f64,
}

impl Pair<'_> {
    fn list(&self, into: &mut Vec<Difference>) {
        let (a, b) = (self.a, self.b);
        let mut differ = |aspect, first: String, second: String| {
            into.push(Difference { scenario: a.name.clone(), aspect, first, second });
        };
        if (a.deviation_mm - b.deviation_mm).abs() > self.tolerance_mm {
            let mm = |value: f64| format!("{value:.3} mm");
            differ(Aspect::Distance, mm(a.deviation_mm), mm(b.deviation_mm));
        }
        if a.replies != b.replies {
            let (first, second) = first_difference(&a.replies, &b.replies);
            differ(Aspect::Replies, first, second);
        }
        let (first, second) = (missing(a, b), missing(b, a));
        if !first.is_empty() || !second.is_empty() {
            differ(Aspect::States, first, second);
        }
        let zero = Duration::ZERO;
        let times = [
            (Aspect::Answer, a.longest_answer(), b.longest_answer()),
            (Aspect::Acknowledgement, a.acknowledged, b.acknowledged),
            (Aspect::Stop, a.stopped.unwrap_or(zero), b.stopped.unwrap_or(zero)),
        ];
        for (aspect, first, second) in times {
            if class(first) != class(second) && !alike(first, second) {
                differ(aspect, class_name(first), class_name(second));
            }
        }
    }
}

/// States of `a` that `b` was not seen in.
fn missing(a: &Observed, b: &Observed) -> String {
    let known = |state: &str| b.states.iter().any(|(other, _)| other == state);
    let shown = a.states.iter().filter(|(state, count)| *count >= SHOWN && !known(state));
    shown.map(|(state, _)| state.as_str()).collect::<Vec<_>>().join(" ")
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

fn alike(a: Duration, b: Duration) -> bool {
    let (a, b) = (a.as_secs_f64(), b.as_secs_f64());
    (a - b).abs() <= ALIKE * a.max(b)
}

/// The differences as a table, with at most so many rows.
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

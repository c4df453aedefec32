//! The differences between two conversations from the same script.

use std::collections::BTreeSet;
use std::time::Duration;

use keepout_planner::Mm3;

use crate::conversation::{DirectConversation, ReportStart, is_answer};
use crate::script::{Talk, play};

/// What two controllers did differently.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Differs {
    /// The answers, at this number from 0, in the first and in the second.
    Answers(usize, String, String),
    /// The state at the end.
    EndState(String, String),
    /// The position at the end, by this many µm.
    EndPlace(u64),
    /// The path, by this many µm.
    Path(u64),
    /// States that only one of the two reported, at least three times.
    States(String, String),
}

/// Fewer reports can show a state by chance.
const SHOWN: usize = 3;
/// Distance that counts as equal, mm: half a step of each model, and a digit of a report.
const EQUAL_MM: f64 = 0.004;
/// Distance of two paths that counts as equal, mm: the chords of two models may leave an arc on either side.
const PATH_MM: f64 = 0.012;

/// One conversation, and how it ended.
pub struct PlayedScript {
    pub talk: DirectConversation,
    state: String,
    place: [f64; 3],
}

impl PlayedScript {
    pub fn new(mut talk: DirectConversation, script: &[Talk]) -> Self {
        play(&mut talk, script);
        talk.await_open(0, Duration::from_secs(20));
        let (state, place) = talk.rest();
        Self { talk, state, place }
    }

    /// Whether the tool stayed on the way between the accepted targets, though a cancel may have shortened it.
    ///
    /// After a cancel the next jog starts on that way. So every place lies in the hull of the targets, and in
    /// particular in their box.
    pub fn keeps_to_jogs(&self, script: &[Talk]) -> bool {
        let absolute = |step: &Talk| match step {
            Talk::Line(line) => line.starts_with("$J=G53") || !line.starts_with("$J"),
            _ => true,
        };
        if !script.iter().all(absolute) {
            return true;
        }
        let targets = script.iter().filter_map(|step| match step {
            Talk::Line(line) => Some([word(line, 'X')?, word(line, 'Y')?]),
            _ => None,
        });
        let within = targets.fold([[-200.0, -150.0]; 2], |[low, high], target| {
            [
                [0, 1].map(|axis: usize| f64::min(low[axis], target[axis])),
                [0, 1].map(|axis| f64::max(high[axis], target[axis])),
            ]
        });
        let [low, high] = within;
        self.talk.samples.iter().all(|sample| {
            let place = [sample.position_mm.x, sample.position_mm.y];
            (0..2).all(|axis| (low[axis] - EQUAL_MM..=high[axis] + EQUAL_MM).contains(&place[axis]))
        })
    }

    /// Answers, alarms and greetings after the first greeting, in order.
    pub fn answers(&self) -> Vec<&str> {
        let counts = |line: &&str| is_answer(line) || line.starts_with("ALARM") || line.starts_with("Grbl");
        self.talk.lines.iter().map(|(_, line)| line.as_str()).filter(counts).skip(1).collect()
    }

    fn states(&self) -> Vec<String> {
        self.talk
            .lines
            .iter()
            .filter_map(|(_, line)| ReportStart::of(line))
            .map(|report| report.state)
            .collect()
    }
}

/// Compares two conversations. After a cancel, a hold in a jog or a reset in motion, the places may differ: the
/// models brake at other times.
pub fn differences(first: &PlayedScript, second: &PlayedScript, places: bool) -> Vec<Differs> {
    let mut found = Vec::new();
    let (ours, theirs) = (first.answers(), second.answers());
    if ours != theirs {
        let at = ours.iter().zip(&theirs).take_while(|(a, b)| a == b).count();
        let shown = |answers: &[&str]| (*answers.get(at).unwrap_or(&"none")).to_owned();
        found.push(Differs::Answers(at, shown(&ours), shown(&theirs)));
        return found;
    }
    if first.state != second.state {
        found.push(Differs::EndState(first.state.clone(), second.state.clone()));
    }
    let [a, b] = [first, second].map(|played| {
        let states = played.states();
        let often = |state: &&String| states.iter().filter(|other| other == state).count() >= SHOWN;
        (
            states.iter().filter(often).cloned().collect::<BTreeSet<_>>(),
            states.into_iter().collect::<BTreeSet<_>>(),
        )
    });
    let only = |often: &BTreeSet<String>, all: &BTreeSet<String>| {
        often.difference(all).cloned().collect::<Vec<_>>().join(" ")
    };
    let (ours, theirs) = (only(&a.0, &b.1), only(&b.0, &a.1));
    if !ours.is_empty() || !theirs.is_empty() {
        found.push(Differs::States(ours, theirs));
    }
    if places {
        let off = (0..3).map(|axis| (first.place[axis] - second.place[axis]).abs()).fold(0.0, f64::max);
        if off > EQUAL_MM {
            found.push(Differs::EndPlace(micrometres(off)));
        }
        let (one, other) = (first.talk.path(), second.talk.path());
        let off = apart(&one, &other).max(apart(&other, &one));
        if off > PATH_MM {
            found.push(Differs::Path(micrometres(off)));
        }
    }
    found
}

fn micrometres(length_mm: f64) -> u64 {
    Duration::from_secs_f64(length_mm.min(1e6)).as_micros().try_into().unwrap_or(u64::MAX) / 1000
}

/// The largest distance of a point of one path from the other path, mm.
pub fn apart(points: &[Mm3], path: &[Mm3]) -> f64 {
    let thin = thinned(path);
    let nearest = |point: &Mm3| {
        let ends = thin.windows(2).map(|pair| distance(*point, pair[0], pair[1]));
        let alone = thin.iter().map(|other| distance(*point, *other, *other));
        ends.chain(alone.take(1)).fold(f64::INFINITY, f64::min)
    };
    points.iter().map(nearest).fold(0.0, f64::max)
}

/// The corners of a path, without the points between that lie on a line to a quarter of the tolerance.
fn thinned(path: &[Mm3]) -> Vec<Mm3> {
    let Some((&first, _)) = path.split_first() else { return Vec::new() };
    let mut kept = vec![first];
    let mut anchor = 0;
    for end in 2..path.len() {
        let line = |at: usize| distance(path[at], path[anchor], path[end]) > PATH_MM / 4.0;
        if (anchor + 1..end).any(line) {
            anchor = end - 1;
            kept.push(path[anchor]);
        }
    }
    kept.extend(path.last().copied());
    kept
}

fn distance(p: Mm3, a: Mm3, b: Mm3) -> f64 {
    let minus = |p: Mm3, q: Mm3| [p.x - q.x, p.y - q.y, p.z - q.z];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let (along, from) = (minus(b, a), minus(p, a));
    let square = dot(along, along);
    let share = if square > 0.0 { (dot(along, from) / square).clamp(0.0, 1.0) } else { 0.0 };
    let off = [0, 1, 2].map(|axis| from[axis] - share * along[axis]);
    dot(off, off).sqrt()
}

/// The value of a word in a line.
fn word(line: &str, letter: char) -> Option<f64> {
    let (_, rest) = line.split_once(letter)?;
    let end = rest.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(rest.len());
    rest[..end].parse().ok()
}

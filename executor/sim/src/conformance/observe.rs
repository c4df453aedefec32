//! Observations of one scenario in a recording.

use std::time::Duration;

use keepout_executor::supervisor::Mode;
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::units::point_mm;

use super::recording::{RecordedEvent, Recording, What};
use super::scenario::{CANCEL, RESET};

/// The observations of one scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observed {
    /// Its name.
    pub name: String,
    /// Replies other than status reports, in order: `ok`, `error:22`, `greeting`, …
    pub replies: Vec<String>,
    /// The reported states with their number of reports, in order of first appearance.
    pub states: Vec<(String, u32)>,
    /// Largest distance of a reported position from the commanded path, mm.
    pub deviation_mm: f64,
    /// The same for the true position. Only a simulated machine provides it.
    pub true_deviation_mm: Option<f64>,
    /// Its last cancel, if no line was unanswered when it was sent: only then is the path after it known.
    pub cancel: Option<Stop>,
    /// Whether a cancel discarded unanswered lines; `None` without such lines.
    pub discards: Option<bool>,
    /// Whether a hold stopped a jog; `None` without one.
    pub hold_stops_jog: Option<bool>,
    /// Times from queries to their answers, without those in [`Observed::after_motion`].
    pub answers: Vec<Duration>,
    /// Times to the first idle report after each motion.
    pub after_motion: Vec<Duration>,
    /// Longest time from a line to its answer.
    pub acknowledged: Duration,
    /// Time from the last cancel or hold to the first report at rest after it.
    pub stopped: Option<Duration>,
}

/// The stop after a cancel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Largest distance of a reported position from the commanded path, up to rest, mm.
    pub deviation_mm: f64,
    /// Distance from the last position before the cancel to the position at rest, mm.
    pub distance_mm: f64,
}

impl Observed {
    fn count(&mut self, state: &str) {
        if let Some((_, count)) = self.states.iter_mut().find(|(known, _)| known == state) {
            *count += 1;
        } else if self.states.len() < KINDS_MAX {
            self.states.push((state.into(), 1));
        }
    }

    /// Longest time from a query to its answer.
    #[must_use]
    pub fn longest_answer(&self) -> Duration {
        self.answers.iter().chain(&self.after_motion).copied().max().unwrap_or_default()
    }
}

/// The observations of each scenario of a recording.
#[must_use]
pub fn observe(recording: &Recording) -> Vec<Observed> {
    let mut last = None;
    let scenario = |(name, origin, events): (&str, Mm2, &[RecordedEvent])| {
        let mut walk = Walk::new(name, *last.get_or_insert(origin));
        events.iter().for_each(|event| walk.take(event));
        last = Some(walk.at);
        walk.observed
    };
    recording.scenarios().map(scenario).collect()
}

/// The state of a walk along the events of a scenario.
struct Walk {
    observed: Observed,
    /// The last reported position.
    at: Mm2,
    /// The commanded path since rest.
    path: Vec<Mm2>,
    /// Whether the path is known: no line was queued behind a cancel.
    known: bool,
    mode: Mode,
    queried: Option<Time>,
    /// Send times of unanswered lines.
    open: Vec<Time>,
    jogs: bool,
    /// Send time of a cancel or hold that has not ended.
    stop_at: Option<Time>,
    cancel: Option<Cancel>,
}

struct Cancel {
    from: Mm2,
    deviation_mm: f64,
    had_open: bool,
}

impl Walk {
    fn new(name: &str, at: Mm2) -> Self {
        Self {
            observed: Observed { name: name.into(), ..Observed::default() },
            at,
            path: vec![at],
            known: true,
            mode: Mode::Idle,
            queried: None,
            open: Vec::new(),
            jogs: false,
            stop_at: None,
            cancel: None,
        }
    }

    fn take(&mut self, event: &RecordedEvent) {
        match &event.what {
            What::Begin { .. } => {}
            What::Sent(bytes) => self.sent(bytes, event.at),
            What::Received(line) => match event.status() {
                Some(status) => {
                    let at = status.position.map_or(self.at, |place| point_mm(place.point));
                    self.reported(status.state, status.mode, at, event.at);
                }
                None => self.replied(&String::from_utf8_lossy(line), event.at),
            },
            What::Rest => self.rests(),
            What::Tool { at, .. } if self.known => {
                let off = at.distance_to_path(&self.path);
                let before = self.observed.true_deviation_mm.unwrap_or(0.0);
                self.observed.true_deviation_mm = Some(before.max(off));
            }
            What::Tool { .. } => {}
        }
    }

    fn sent(&mut self, bytes: &[u8], at: Time) {
        match bytes {
            b"?" => self.queried = Some(at),
            [CANCEL] => {
                let had_open = !self.open.is_empty();
                self.known &= !had_open;
                self.cancel = Some(Cancel { from: self.at, deviation_mm: 0.0, had_open });
                self.stop_at = Some(at);
            }
            [RESET] => {
                self.known = false;
                self.open.clear();
            }
            b"!" => self.stop_at = Some(at),
            b"~" => self.resumed(),
            [.., b'\n'] => self.sent_line(&String::from_utf8_lossy(bytes), at),
            _ => {}
        }
    }

    fn sent_line(&mut self, line: &str, at: Time) {
        self.open.push(at);
        let Some(to) = target(line) else { return };
        self.jogs = line.starts_with("$J=");
        // A motion after a stop begins wherever the tool stops.
        self.known &= self.cancel.is_none() && !(self.jogs && self.stop_at.is_some());
        self.path.push(to);
    }

    /// Handles the end of a hold. The hold stopped the jog if the tool is then short of the target.
    fn resumed(&mut self) {
        if self.jogs && self.path.len() > 1 && self.stop_at.is_some() {
            let short = self.path.last().is_some_and(|&end| self.at.distance(end) > SHORT_MM);
            self.observed.hold_stops_jog = Some(short && matches!(self.mode, Mode::Idle | Mode::Held));
        }
    }

    fn reported(&mut self, state: &str, mode: Mode, at: Mm2, now: Time) {
        if let Some(queried) = self.queried.take() {
            let ended = mode == Mode::Idle && matches!(self.mode, Mode::Moving | Mode::Slowing);
            let times = if ended { &mut self.observed.after_motion } else { &mut self.observed.answers };
            times.push(now.since(queried));
        }
        self.observed.count(state);
        (self.mode, self.at) = (mode, at);
        if self.known {
            let off = at.distance_to_path(&self.path);
            self.observed.deviation_mm = self.observed.deviation_mm.max(off);
            if let Some(cancel) = &mut self.cancel {
                cancel.deviation_mm = cancel.deviation_mm.max(off);
            }
        }
        if let Some(since) = self.stop_at.filter(|_| matches!(mode, Mode::Idle | Mode::Held)) {
            self.observed.stopped.get_or_insert(now.since(since));
        }
    }

    fn replied(&mut self, line: &str, now: Time) {
        let Some(kind) = kind(line) else { return };
        if (kind == "ok" || kind.starts_with("error:")) && !self.open.is_empty() {
            let waited = now.since(self.open.remove(0));
            self.observed.acknowledged = self.observed.acknowledged.max(waited);
        }
        self.observed.replies.push(kind);
    }

    /// At rest, all commanded motions are over.
    fn rests(&mut self) {
        if let Some(cancel) = self.cancel.take() {
            if cancel.had_open {
                self.observed.discards = Some(!self.open.is_empty());
            } else if self.known {
                let (deviation_mm, distance_mm) = (cancel.deviation_mm, self.at.distance(cancel.from));
                self.observed.cancel = Some(Stop { deviation_mm, distance_mm });
            }
        }
        self.open.clear();
        (self.stop_at, self.jogs, self.known) = (None, false, true);
        self.path = vec![self.at];
    }
}

/// Largest distance to the target at which a jog counts as completed, mm.
const SHORT_MM: f64 = 0.05;
/// Most stored kinds of states.
const KINDS_MAX: usize = 32;

/// The target of a motion line of the recorder, machine coordinates.
fn target(line: &str) -> Option<Mm2> {
    let (_, words) = line.split_once("G53")?;
    let value = |letter: char| {
        let (_, rest) = words.split_once(letter)?;
        let end = rest.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(rest.len());
        rest[..end].parse::<f64>().ok()
    };
    Some(Mm2::new(value('X')?, value('Y')?))
}

/// The kind of a reply, which a controller and its model must share. `None` for an empty line.
fn kind(line: &str) -> Option<String> {
    let line = line.trim();
    if line.is_empty() {
        None
    } else if line.to_ascii_lowercase().starts_with("grbl") {
        Some("greeting".into())
    } else if let Some((tag, _)) = line.strip_prefix('[').and_then(|inner| inner.split_once(':')) {
        Some(format!("[{tag}]"))
    } else {
        Some(line.chars().take(80).collect())
    }
}

//! Examines a controller before its first session: identity, answer times and settings. Sends only queries.

use std::time::Duration;

use keepout_executor::dialect::{Dialect, Inspected, Inspector};
use keepout_executor::session::Clock;
use keepout_executor::session::port::{Port, PortError};
use keepout_executor::supervisor::{Command, Mode, Reply, Report};
use keepout_guard::Time;
use thiserror::Error;

/// Result of an examination.
#[derive(Clone, Debug)]
pub struct Examination {
    /// Identity and settings of the controller. `None` when its dialect has no questions that change nothing.
    pub inspector: Option<Inspected>,
    /// Last report of the controller.
    pub report: Report,
    /// Times from a query to its answer, in ascending order.
    pub round_trips: Vec<Duration>,
    /// Queries without an answer in time.
    pub unanswered: usize,
    /// Reports per second, with one query at a time.
    pub reports_per_s: f64,
}

impl Examination {
    /// The time within which `percent` % of the answers came. Zero without answers.
    #[must_use]
    pub fn round_trip(&self, percent: usize) -> Duration {
        let last = self.round_trips.len().saturating_sub(1);
        self.round_trips.get(last * percent / 100).copied().unwrap_or_default()
    }
}

/// Why a controller could not be examined.
#[derive(Debug, Error)]
pub enum ExamineError {
    /// The port failed.
    #[error(transparent)]
    Port(#[from] PortError),
    /// No report came.
    #[error(
        "the controller does not answer{}. Check cable, power, port, baud rate and dialect.",
        if garbled.is_empty() { String::new() } else { format!(" in its dialect, but sent {garbled:?}") }
    )]
    Silent {
        /// The last line that the dialect could not read.
        garbled: String,
    },
    /// The controller did not answer a question.
    #[error("the controller does not answer {question:?}. Is it the dialect's controller?")]
    Unanswered {
        /// The question.
        question: String,
    },
}

/// Longest time until the first report. Opening the port can reset a controller, which then starts again.
const WAKES_WITHIN: Duration = Duration::from_secs(4);
/// Longest time until the answer to a question.
const ANSWERS_WITHIN: Duration = Duration::from_secs(3);
/// Time after which the first query is repeated.
const ASK_AGAIN: Duration = Duration::from_millis(500);
/// Longest line that is kept, bytes.
const LINE_MAX: usize = 256;

/// A conversation with a controller.
struct Talk<'a, P, C> {
    port: P,
    clock: C,
    dialect: &'a mut dyn Dialect,
    inspector: Option<Box<dyn Inspector>>,
    line: Vec<u8>,
    garbled: String,
    report: Option<Report>,
    answered: bool,
}

/// Examines the controller at the port with `queries` queries.
///
/// `steps_per_mm` and `arc_tolerance_mm` are the values of the machine profile. Sends only status queries and
/// the questions of the dialect's [`Inspector`].
///
/// # Errors
/// [`ExamineError`] when the port fails, or the controller does not answer.
pub fn examine(
    port: impl Port,
    clock: impl Clock,
    dialect: &mut dyn Dialect,
    queries: usize,
    (steps_per_mm, arc_tolerance_mm): (f64, f64),
) -> Result<Examination, ExamineError> {
    let inspector = dialect.inspector();
    let (line, garbled) = (Vec::new(), String::new());
    let mut talk = Talk { port, clock, dialect, inspector, line, garbled, report: None, answered: false };
    talk.wake()?;
    talk.question()?;
    let begun = talk.clock.now();
    let (mut round_trips, mut unanswered) = (Vec::new(), 0);
    for _ in 0..queries {
        match talk.query(ANSWERS_WITHIN)? {
            Some(time) => round_trips.push(time),
            None => unanswered += 1,
        }
    }
    let seconds = talk.clock.now().since(begun).as_secs_f64().max(1e-6);
    let reports_per_s = f64::from(u32::try_from(round_trips.len()).unwrap_or(u32::MAX)) / seconds;
    round_trips.sort_unstable();
    let silent = ExamineError::Silent { garbled: talk.garbled };
    Ok(Examination {
        inspector: talk.inspector.map(|inspector| inspector.inspected(steps_per_mm, arc_tolerance_mm)),
        report: talk.report.ok_or(silent)?,
        round_trips,
        unanswered,
        reports_per_s,
    })
}

impl<P: Port, C: Clock> Talk<'_, P, C> {
    /// Queries the controller until the first report arrives.
    fn wake(&mut self) -> Result<(), ExamineError> {
        let end = self.clock.now().after(WAKES_WITHIN);
        while self.clock.now() < end {
            if self.query(ASK_AGAIN)?.is_some() {
                // Answers to earlier queries may still arrive.
                let end = self.clock.now().after(ASK_AGAIN);
                self.listen_until(end, |_| false)?;
                return Ok(());
            }
        }
        Err(ExamineError::Silent { garbled: std::mem::take(&mut self.garbled) })
    }

    /// Queries a report. Returns the time until it arrived, or `None` if it did not arrive within `within`.
    fn query(&mut self, within: Duration) -> Result<Option<Duration>, ExamineError> {
        let mut bytes = Vec::new();
        // A query cannot fail to encode: it has no target that could be off the lattice.
        let _ = self.dialect.encode(&Command::Query, &mut bytes);
        self.report = None;
        let sent = self.clock.now();
        self.port.write(&bytes, sent)?;
        let arrived = self.listen_until(sent.after(within), |talk| talk.report.is_some())?;
        Ok(arrived.then(|| self.clock.now().since(sent)))
    }

    /// Sends the dialect's questions, and waits for each answer.
    fn question(&mut self) -> Result<(), ExamineError> {
        let questions = self.inspector.as_ref().map_or(&[][..], |inspector| inspector.questions());
        for question in questions {
            self.answered = false;
            let sent = self.clock.now();
            self.port.write(question, sent)?;
            if !self.listen_until(sent.after(ANSWERS_WITHIN), |talk| talk.answered)? {
                let question = String::from_utf8_lossy(question).trim().to_string();
                return Err(ExamineError::Unanswered { question });
            }
        }
        Ok(())
    }

    /// Reads the port until `done`, or until `end`. Returns whether `done` held.
    fn listen_until(&mut self, end: Time, done: impl Fn(&Self) -> bool) -> Result<bool, ExamineError> {
        let mut bytes = Vec::new();
        loop {
            let now = self.clock.now();
            bytes.clear();
            self.port.read(&mut bytes, now)?;
            bytes.iter().for_each(|&byte| self.receive(byte));
            if done(self) {
                return Ok(true);
            }
            if now >= end {
                return Ok(false);
            }
            self.clock.wait(end.min(self.port.next_event()));
        }
    }

    fn receive(&mut self, byte: u8) {
        // Replies that the dialect would send are dropped, because they could store something in the
        // controller.
        match self.dialect.decode(byte, &mut Vec::new()) {
            Some(Reply::Report(report)) => self.report = Some(report),
            Some(Reply::Garbled(text)) => self.garbled = text.to_string(),
            _ => {}
        }
        if byte != b'\n' {
            if self.line.len() < LINE_MAX {
                self.line.push(byte);
            }
            return;
        }
        let line = String::from_utf8_lossy(&std::mem::take(&mut self.line)).trim().to_string();
        if let Some(inspector) = self.inspector.as_mut().filter(|_| !line.is_empty()) {
            self.answered |= inspector.hear(&line);
        }
    }
}

/// The remark on a controller's state, with the remedy if a session cannot begin. `None` when it is idle.
#[must_use]
pub fn remedy(mode: Mode) -> Option<&'static str> {
    match mode {
        Mode::Idle => None,
        Mode::Alarm => Some("locked: run with --home, tool raised"),
        Mode::Moving | Mode::Slowing | Mode::Homing => Some("moving: another program or person moves it"),
        Mode::Held => Some("held: a session ends the hold, and clears the queue"),
        Mode::Other => Some("a door is open, or the controller sleeps or is in check mode: bring it to idle"),
    }
}

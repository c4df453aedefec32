//! Examining a controller before anything is entrusted to it: who it is, how quickly it answers, how it is set up. Only
//! queries and questions are sent.

use std::time::Duration;

use keepout_executor::dialect::{Dialect, Inspected, Inspector};
use keepout_executor::session::Clock;
use keepout_executor::session::port::{Port, PortError};
use keepout_executor::supervisor::{Command, Mode, Reply, Report};
use keepout_guard::Time;
use thiserror::Error;

/// What was found.
#[derive(Clone, Debug)]
pub struct Examination {
    /// What the controller says of itself; `None` when its dialect has no questions that change nothing.
    pub inspector: Option<Inspected>,
    /// Its last report.
    pub report: Report,
    /// Times from a query to its answer, least first.
    pub round_trips: Vec<Duration>,
    /// Queries that were not answered in time.
    pub unanswered: usize,
    /// Reports per second, asked for one after the other.
    pub reports_per_s: f64,
}

impl Examination {
    /// The time that this share of the answers took at most; zero without answers.
    #[must_use]
    pub fn round_trip(&self, percent: usize) -> Duration {
        let last = self.round_trips.len().saturating_sub(1);
        self.round_trips.get(last * percent / 100).copied().unwrap_or_default()
    }
}

/// Why a controller could not be examined.
#[derive(Debug, Error)]
pub enum ExamineError {
    /// The port.
    #[error(transparent)]
    Port(#[from] PortError),
    /// Nothing that is understood came.
    #[error(
        "the controller does not answer{}. Check cable, power, port, baud rate and dialect.",
        if heard.is_empty() { String::new() } else { format!(" in its language, but sent {heard:?}") }
    )]
    Silent {
        /// What came instead.
        heard: String,
    },
    /// A question was not answered.
    #[error("the controller does not answer {question:?}. Is it the dialect's controller?")]
    Unanswered {
        /// The question.
        question: String,
    },
}

/// A controller that was opened may just have been reset by that, and says nothing for so long.
const WAKES_WITHIN: Duration = Duration::from_secs(4);
/// A question is answered within this.
const ANSWERS_WITHIN: Duration = Duration::from_secs(3);
/// A first query is repeated after this.
const ASK_AGAIN: Duration = Duration::from_millis(500);
/// Longest line that is kept.
const LINE_MAX: usize = 256;

/// A conversation with a controller.
struct Talk<'a, P, C> {
    port: P,
    clock: C,
    dialect: &'a mut dyn Dialect,
    inspector: Option<Box<dyn Inspector>>,
    line: Vec<u8>,
    heard: String,
    report: Option<Report>,
    answered: bool,
}

/// Examines the controller at the port with `queries` queries; `steps_per_mm` and `arc_tolerance_mm` are those that a plan
/// would be made for. Sends nothing but status queries and the questions of the dialect's [`Inspector`].
///
/// # Errors
/// [`ExamineError`] when the port fails, or nobody answers.
pub fn examine(
    port: impl Port,
    clock: impl Clock,
    dialect: &mut dyn Dialect,
    queries: usize,
    (steps_per_mm, arc_tolerance_mm): (f64, f64),
) -> Result<Examination, ExamineError> {
    let inspector = dialect.inspector();
    let (line, heard) = (Vec::new(), String::new());
    let mut talk = Talk { port, clock, dialect, inspector, line, heard, report: None, answered: false };
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
    let silent = ExamineError::Silent { heard: talk.heard };
    Ok(Examination {
        inspector: talk.inspector.map(|inspector| inspector.inspected(steps_per_mm, arc_tolerance_mm)),
        report: talk.report.ok_or(silent)?,
        round_trips,
        unanswered,
        reports_per_s,
    })
}

impl<P: Port, C: Clock> Talk<'_, P, C> {
    /// Asks until there is a first report.
    fn wake(&mut self) -> Result<(), ExamineError> {
        let end = self.clock.now().after(WAKES_WITHIN);
        while self.clock.now() < end {
            if self.query(ASK_AGAIN)?.is_some() {
                // Answers to earlier queries may still come.
                let end = self.clock.now().after(ASK_AGAIN);
                self.listen_until(end, |_| false)?;
                return Ok(());
            }
        }
        Err(ExamineError::Silent { heard: std::mem::take(&mut self.heard) })
    }

    /// Asks for a report; how long it took.
    fn query(&mut self, within: Duration) -> Result<Option<Duration>, ExamineError> {
        let mut bytes = Vec::new();
        // A query has no target that could be off the lattice.
        let _ = self.dialect.encode(&Command::Query, &mut bytes);
        self.report = None;
        let asked = self.clock.now();
        self.port.write(&bytes, asked)?;
        let came = self.listen_until(asked.after(within), |talk| talk.report.is_some())?;
        Ok(came.then(|| self.clock.now().since(asked)))
    }

    /// Asks the dialect's questions.
    fn question(&mut self) -> Result<(), ExamineError> {
        let questions = self.inspector.as_ref().map_or(&[][..], |inspector| inspector.questions());
        for question in questions {
            self.answered = false;
            let asked = self.clock.now();
            self.port.write(question, asked)?;
            if !self.listen_until(asked.after(ANSWERS_WITHIN), |talk| talk.answered)? {
                let question = String::from_utf8_lossy(question).trim().to_string();
                return Err(ExamineError::Unanswered { question });
            }
        }
        Ok(())
    }

    /// Listens until `done`, or the time is over; whether it was done.
    fn listen_until(&mut self, end: Time, done: impl Fn(&Self) -> bool) -> Result<bool, ExamineError> {
        let mut bytes = Vec::new();
        loop {
            let now = self.clock.now();
            bytes.clear();
            self.port.read(&mut bytes, now)?;
            bytes.iter().for_each(|&byte| self.hear(byte));
            if done(self) {
                return Ok(true);
            }
            if now >= end {
                return Ok(false);
            }
            self.clock.wait(end.min(self.port.next_event()));
        }
    }

    fn hear(&mut self, byte: u8) {
        // What the dialect would send on is left out: it might store something.
        match self.dialect.decode(byte, &mut Vec::new()) {
            Some(Reply::Report(report)) => self.report = Some(report),
            Some(Reply::Garbled(text)) => self.heard = text.to_string(),
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

/// Whether a session could begin in this state, or what to do.
#[must_use]
pub fn remedy(mode: Mode) -> Option<&'static str> {
    match mode {
        Mode::Idle => None,
        Mode::Alarm => Some("locked: run with --home, tool raised"),
        Mode::Moving | Mode::Slowing | Mode::Homing => Some("it moves: somebody else drives it"),
        Mode::Held => Some("held: a session takes the hold away, and forgets what is queued"),
        Mode::Other => Some("a door is open, or it sleeps or checks: make it idle"),
    }
}

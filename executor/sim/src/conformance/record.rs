//! The recorder: plays scenarios at a port and stores the bytes on the line.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_executor::session::port::Port;
use keepout_executor::session::{Clock, Sample};
use keepout_executor::supervisor::Mode;
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::units::point_mm;

use super::error::{LIMIT, RecordError};
use super::recording::{EVENTS_MAX, RecordedEvent, Recording, RecordingHeader, What};
use super::scenario::{RESET, Scenario, Step};
use super::start::{Setup, StatedIdentity};

/// The port and clock of a recorder.
#[derive(Debug)]
pub struct Bench<'a, P, C> {
    /// The controller's port.
    pub port: &'a mut P,
    /// The source of time.
    pub clock: &'a mut C,
    /// Takes the true tool positions from the port. A real machine provides none.
    pub tool: fn(&mut P, &mut Vec<Sample>),
}

/// A recording under way.
#[derive(Debug)]
pub struct ScenarioRecorder<'a, P, C> {
    pub(super) bench: Bench<'a, P, C>,
    pub(super) setup: Setup,
    pub(super) recording: Recording,
    pub(super) known: StatedIdentity,
    /// Lengths of the unanswered lines.
    pub(super) open: VecDeque<usize>,
    pub(super) reported: Option<Reported>,
    /// Agreeing idle reports in a row, to queries sent after the last action.
    pub(super) agreeing: u8,
    /// Send time of the last bytes other than a query.
    acted: Time,
    /// Whether the last report answers a query sent after that.
    fresh: bool,
    /// The middle of the box.
    pub(super) origin: Mm2,
    /// Send time of the unanswered query.
    queried: Option<Time>,
    query_due: Time,
    line: Vec<u8>,
    bytes: Vec<u8>,
    samples: Vec<Sample>,
    tool: Option<Mm2>,
    scenario: String,
}

/// The content of a report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reported {
    pub mode: Mode,
    pub at: Option<Mm2>,
}

/// Time after which an unanswered query is repeated.
const ASK_AGAIN: Duration = Duration::from_millis(500);
/// Time at rest after which an unanswered line counts as discarded.
const THROWN_AWAY: Duration = Duration::from_millis(300);
/// Longest stored received line, bytes.
const LINE_MAX: usize = 512;
/// Receive buffer of a controller that does not state it.
const RECEIVE_BUFFER: u32 = 128;
/// Planner blocks of a controller that does not state them.
const BLOCKS: u32 = 15;

impl<'a, P: Port, C: Clock> ScenarioRecorder<'a, P, C> {
    pub(super) fn new(bench: Bench<'a, P, C>, setup: Setup, header: RecordingHeader) -> Self {
        Self {
            bench,
            setup,
            recording: Recording { header, events: Vec::new() },
            known: StatedIdentity::default(),
            open: VecDeque::new(),
            reported: None,
            agreeing: 0,
            acted: Time::ZERO,
            fresh: false,
            origin: Mm2::default(),
            queried: None,
            query_due: Time::ZERO,
            line: Vec::new(),
            bytes: Vec::new(),
            samples: Vec::new(),
            tool: None,
            scenario: String::new(),
        }
    }

    /// The identity that the controller states.
    #[must_use]
    pub fn known(&self) -> &StatedIdentity {
        &self.known
    }

    /// Blocks of the controller's planner, as it states them, at least 2.
    #[must_use]
    pub fn blocks(&self) -> u32 {
        self.known.blocks.unwrap_or(BLOCKS).clamp(2, 1000)
    }

    /// The middle of the box.
    #[must_use]
    pub fn origin(&self) -> Mm2 {
        self.origin
    }

    /// Ends the recording.
    #[must_use]
    pub fn finish(self) -> Recording {
        self.recording
    }

    /// Plays a scenario. After an error the recorder sends no further bytes, and the queued motions end in
    /// the box.
    ///
    /// # Errors
    /// [`RecordError`] when the port fails, the scenario leaves the box, or the controller does not come to
    /// rest.
    pub fn play(&mut self, scenario: &Scenario) -> Result<(), RecordError> {
        self.scenario.clone_from(&scenario.name);
        let half = self.setup.box_mm / 2.0;
        let leaves = |step: &Step| match step {
            Step::Jog { to, .. } | Step::Cut { to, .. } => to.x.abs().max(to.y.abs()) > half,
            _ => false,
        };
        if scenario.steps.iter().any(leaves) {
            return Err(RecordError::OutsideBox { scenario: scenario.name.clone() });
        }
        let begin = What::Begin { name: scenario.name.clone(), origin: self.origin };
        let now = self.bench.clock.now();
        self.push(now, begin)?;
        scenario.steps.iter().try_for_each(|step| self.step(step))
    }

    pub(super) fn go_to_origin(&mut self) -> Result<(), RecordError> {
        self.step(&Step::Jog { to: Mm2::default(), feed: APPROACH })?;
        self.step(&Step::Rest)
    }

    fn step(&mut self, step: &Step) -> Result<(), RecordError> {
        match step {
            Step::Line(line) => self.send_line(line),
            Step::Jog { to, feed } => self.send_line(&self.motion("$J=G53G90G21", *to, *feed)),
            Step::Cut { to, feed } => self.send_line(&self.motion("G1G53G21G90G94", *to, *feed)),
            Step::Realtime(character) => self.send_realtime(*character),
            Step::Wait(time) => self.pump(*time, |_| false).map(drop),
            Step::Answered => self.within(|recorder| recorder.open.is_empty()),
            Step::Rest => self.rest(),
        }
    }

    fn motion(&self, words: &str, to: Mm2, feed: u32) -> String {
        let at = self.origin + to;
        format!("{words}X{:.3}Y{:.3}F{feed}", at.x, at.y)
    }

    /// Sends a line as soon as the controller's receive buffer has room for it.
    pub(super) fn send_line(&mut self, line: &str) -> Result<(), RecordError> {
        let length = line.len() + 1;
        let buffer = self.known.receive_buffer.unwrap_or(RECEIVE_BUFFER);
        let room = usize::try_from(buffer).unwrap_or(usize::MAX).saturating_sub(length + 1);
        self.within(|recorder| recorder.open.iter().sum::<usize>() <= room)?;
        self.send(format!("{line}\n").into_bytes())?;
        self.open.push_back(length);
        Ok(())
    }

    fn send_realtime(&mut self, character: u8) -> Result<(), RecordError> {
        self.send(vec![character])?;
        if character == RESET {
            self.open.clear();
            self.queried = None;
        }
        Ok(())
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<(), RecordError> {
        let now = self.bench.clock.now();
        self.bench.port.write(&bytes, now)?;
        self.act();
        self.push(now, What::Sent(bytes))
    }

    /// Marks an action. Answers to earlier queries do not describe the state after it.
    pub(super) fn act(&mut self) {
        (self.acted, self.agreeing, self.fresh) = (self.bench.clock.now(), 0, false);
    }

    /// Waits for rest: two agreeing idle reports, with every line answered or discarded by a cancel.
    fn rest(&mut self) -> Result<(), RecordError> {
        let mut thrown_away = Time::NEVER;
        self.act();
        self.within(|recorder| {
            if recorder.agreeing < 2 {
                thrown_away = recorder.last_event().after(THROWN_AWAY);
            }
            let settled = recorder.open.is_empty() || recorder.last_event() >= thrown_away;
            recorder.is_locked() || recorder.agreeing >= 2 && settled
        })?;
        if self.is_locked() {
            return Err(RecordError::Alarm { scenario: self.scenario.clone() });
        }
        self.open.clear();
        let now = self.bench.clock.now();
        self.push(now, What::Rest)
    }

    /// Whether the controller has reported an alarm since the last action.
    fn is_locked(&self) -> bool {
        self.fresh && self.reported.is_some_and(|reported| reported.mode == Mode::Alarm)
    }

    fn last_event(&self) -> Time {
        self.recording.events.last().map_or(Time::ZERO, |event| event.at)
    }

    fn within(&mut self, done: impl FnMut(&Self) -> bool) -> Result<(), RecordError> {
        if self.pump(LIMIT, done)? {
            return Ok(());
        }
        Err(RecordError::NoRest { scenario: self.scenario.clone() })
    }

    /// Reads and queries the status until `done` or the end of `within`. Returns whether `done` held.
    pub(super) fn pump(
        &mut self,
        within: Duration,
        mut done: impl FnMut(&Self) -> bool,
    ) -> Result<bool, RecordError> {
        let end = self.bench.clock.now().after(within);
        loop {
            let now = self.bench.clock.now();
            self.read(now)?;
            if done(self) {
                return Ok(true);
            }
            if now >= end {
                return Ok(false);
            }
            let due = self.queried.map_or(self.query_due, |queried| queried.after(ASK_AGAIN));
            if now >= due {
                self.bench.port.write(b"?", now)?;
                (self.queried, self.query_due) = (Some(now), now.after(self.setup.interval));
                self.push(now, What::Sent(b"?".to_vec()))?;
                continue;
            }
            self.bench.clock.wait(end.min(due).min(self.bench.port.next_event()));
        }
    }

    fn read(&mut self, now: Time) -> Result<(), RecordError> {
        let mut bytes = std::mem::take(&mut self.bytes);
        bytes.clear();
        let outcome = self.bench.port.read(&mut bytes, now);
        self.take_tool()?;
        for &byte in &bytes {
            match byte {
                b'\n' => self.take_line(now)?,
                b'\r' => {}
                _ if self.line.len() < LINE_MAX => self.line.push(byte),
                _ => {}
            }
        }
        self.bytes = bytes;
        Ok(outcome?)
    }

    /// Stores the true positions, each one once.
    fn take_tool(&mut self) -> Result<(), RecordError> {
        let mut samples = std::mem::take(&mut self.samples);
        (self.bench.tool)(self.bench.port, &mut samples);
        for Sample { at, position_mm: place, kind } in samples.drain(..) {
            if self.tool.replace(place.plane()) != Some(place.plane()) {
                self.push(at, What::Tool { at: place.plane(), kind })?;
            }
        }
        self.samples = samples;
        Ok(())
    }

    fn take_line(&mut self, now: Time) -> Result<(), RecordError> {
        let line = std::mem::take(&mut self.line);
        let text = String::from_utf8_lossy(&line).into_owned();
        if text == "ok" || text.starts_with("error:") {
            self.open.pop_front();
        }
        self.known.take(&text);
        let event = RecordedEvent { at: now, what: What::Received(line) };
        if let Some(status) = event.status() {
            let at = status.position.map(|place| point_mm(place.point));
            self.take_report(Reported { mode: status.mode, at });
        }
        self.push(event.at, event.what)
    }

    fn take_report(&mut self, reported: Reported) {
        let queried = self.queried.take();
        self.fresh = queried.is_some_and(|queried| queried >= self.acted);
        let counts = reported.mode == Mode::Idle && self.fresh;
        let agrees = self.agreeing == 0 || self.reported == Some(reported);
        self.agreeing = if counts && agrees { self.agreeing.saturating_add(1) } else { u8::from(counts) };
        self.reported = Some(reported);
    }

    fn push(&mut self, at: Time, what: What) -> Result<(), RecordError> {
        if self.recording.events.len() >= EVENTS_MAX {
            return Err(RecordError::TooLong);
        }
        self.recording.events.push(RecordedEvent { at, what });
        Ok(())
    }
}

/// Feed of the move to the middle of the box, mm/min.
const APPROACH: u32 = 300;

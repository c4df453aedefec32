//! The supervisor: a pure state machine between operator, guard and controller.
//!
//! `step(event, now)` takes one event and the time, and answers with the commands to send; it reads no clock, touches
//! no port and draws no random numbers. Motions come only from the [`guard`].

mod event;
mod fault;
pub mod guard;
mod manual;
mod settings;
mod start;

pub use event::{Ask, Command, Event, Mode, Reply, Report, Wish};
pub use fault::Fault;

use std::time::Duration;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Curve, Length, Point};
use keepout_planner::job::{Leg, LoopNumber, contour_job};
use keepout_planner::margin::Budget;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{length_up_from_mm, mm};

use crate::time::Time;
use guard::{Guard, Sighting, Stamp};
use settings::Settings;

/// What the session was set up with.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Feed of the finishing contour, mm/min.
    pub feed_mm_min: u32,
    /// Home the machine before the start.
    pub home: bool,
    /// The machine's travel, drawing coordinates.
    pub stroke: Window,
    /// Longest silence of the controller.
    pub answer_within: Duration,
    /// Steps per mm below which the controller's own setting is refused.
    pub steps_per_mm: f64,
    /// Arc tolerance, mm, that the controller is given unless its own is smaller.
    pub arc_tolerance_mm: f64,
}

/// What the supervisor is doing; each state carries only its own data.
#[derive(Debug)]
enum State {
    /// Waiting for a first report; what came instead is kept for the message.
    Connecting {
        garbled: Option<String>,
    },
    /// Waiting for the answer to an empty line, whatever it is.
    Waking,
    ReadingSettings(Settings),
    /// Waiting for settings to be stored.
    Storing {
        open: u8,
    },
    Homing,
    /// Waiting for the lines that set modes to be accepted, then for a report at rest, with the work offset known.
    Locating {
        lines_open: u8,
    },
    Manual(manual::Manual),
    Contouring {
        /// The finishing loops that it cuts.
        cuts: Vec<LoopNumber>,
    },
    Stopping,
    Done,
    Faulted(Fault),
}

/// The state's name, for the operator and the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Connecting, reading settings, homing.
    Starting,
    /// Steered by the operator.
    Manual,
    /// Contouring by itself.
    Contouring,
    /// Coming to rest before the end.
    Stopping,
    /// Ended as wanted.
    Done,
    /// Stopped by a fault.
    Faulted,
}

/// Counters for the report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Jogs sent.
    pub jogs: u64,
    /// Contour motions sent.
    pub contour_motions: u64,
    /// Jogs cancelled.
    pub cancels: u64,
    /// Wishes that the wall shortened or turned.
    pub clipped: u64,
    /// Queries sent.
    pub queries: u64,
}

/// A status query without an answer is repeated after this time.
const QUERY_AGAIN: Duration = Duration::from_millis(1000);
/// Time between an answer and the next query.
const QUERY_PAUSE: Duration = Duration::from_millis(40);
/// Homing may keep the controller silent for this long.
const HOMING_MAX: Duration = Duration::from_secs(90);
/// Each step of the start is done within this, or something was lost.
const START_WITHIN: Duration = Duration::from_secs(20);
/// Refusals in a row after which the session ends.
const REFUSED_MAX: u8 = 20;
/// The wall counts as touched within this distance beyond the roughing threshold, mm.
const TOUCH_MM: f64 = 0.1;

/// The supervisor; see the module's documentation.
#[derive(Debug)]
pub struct Supervisor {
    plan: CertifiedPlan,
    guard: Guard,
    options: Options,
    state: State,
    wish: Wish,
    wished_at: Option<Time>,
    heard_at: Time,
    queries: std::collections::VecDeque<Stamp>,
    asked_at: Option<Time>,
    answered_at: Time,
    round_trip: Duration,
    planner_blocks: Option<usize>,
    limits: manual::Limits,
    finished: Vec<LoopNumber>,
    notices: Vec<String>,
    counts: Counts,
    position: Option<Point>,
    /// Whether a touch starts a contour: asked for, and not yet done since.
    armed: bool,
    unreached: usize,
    work_offset: Option<Point>,
    /// When the start last got on by an acknowledgement.
    progress_at: Time,
    /// Since when the controller rests although a line is unanswered.
    unanswered_since: Option<Time>,
    /// Jogs refused because the controller was still running, in a row.
    refused: u8,
}

impl Supervisor {
    /// A supervisor for a certified plan. The part is copied into the guard.
    #[must_use]
    pub fn new(plan: CertifiedPlan, options: Options) -> Self {
        let resolution = resolution(&plan.plan.budget);
        // Two steps and a little: the controller may have up to as few steps per mm as the profile says.
        let two_steps = length_up_from_mm(2.2 / options.steps_per_mm).unwrap_or(Length::small(u8::MAX));
        let mut part = plan.part.clone();
        // Cells only make answers at the roughing threshold faster; a part too large for them is asked by its index.
        let _ = part.prepare(plan.roughing);
        let guard = Guard::new(part, options.stroke, plan.roughing, plan.finishing, resolution, two_steps);
        let limits = manual::Limits {
            speed_mm_s: plan.plan.machine.max_rate_mm_s,
            acceleration_mm_s2: plan.plan.machine.acceleration_mm_s2,
        };
        Self {
            plan,
            guard,
            options,
            state: State::Connecting { garbled: None },
            wish: Wish::default(),
            wished_at: None,
            heard_at: Time::ZERO,
            queries: std::collections::VecDeque::new(),
            asked_at: None,
            answered_at: Time::ZERO,
            round_trip: Duration::from_millis(100),
            planner_blocks: None,
            limits,
            finished: Vec::new(),
            notices: Vec::new(),
            counts: Counts::default(),
            position: None,
            armed: false,
            unreached: 0,
            work_offset: None,
            progress_at: Time::ZERO,
            unanswered_since: None,
            refused: 0,
        }
    }

    /// Takes one event and answers with the commands to send, in order.
    pub fn step(&mut self, event: Event, now: Time) -> Vec<Command> {
        let mut commands = Vec::new();
        let tick = event == Event::Tick;
        let outcome = match event {
            Event::Reply(reply) => {
                // Noise is no sign of life.
                if !matches!(reply, Reply::Garbled(_)) {
                    self.heard_at = now;
                }
                if matches!(reply, Reply::Ok | Reply::Error(_))
                    || matches!(self.state, State::Connecting { .. })
                {
                    self.progress_at = now;
                }
                self.take_reply(reply, now, &mut commands)
            }
            Event::Operator(wish) => {
                // Automatic mode is armed by being chosen, and spent by a contour.
                self.armed = wish.automatic && (self.armed || !self.wish.automatic);
                self.wish = wish;
                self.wished_at = Some(now);
                Ok(())
            }
            Event::Tick => self.check_silence(now),
            Event::PortLost(reason) => Err(Fault::PortLost(reason)),
        };
        let outcome = outcome.and_then(|()| self.act(tick, now, &mut commands));
        if let Err(fault) = outcome {
            self.stop(fault, &mut commands);
        }
        commands
    }

    /// What the supervisor is doing.
    #[must_use]
    pub fn phase(&self) -> Phase {
        match self.state {
            State::Connecting { .. }
            | State::Waking
            | State::ReadingSettings(_)
            | State::Storing { .. }
            | State::Homing
            | State::Locating { .. } => Phase::Starting,
            State::Manual(_) => Phase::Manual,
            State::Contouring { .. } => Phase::Contouring,
            State::Stopping => Phase::Stopping,
            State::Done => Phase::Done,
            State::Faulted(_) => Phase::Faulted,
        }
    }

    /// The fault that ended the session.
    #[must_use]
    pub fn fault(&self) -> Option<&Fault> {
        if let State::Faulted(fault) = &self.state { Some(fault) } else { None }
    }

    /// The plan.
    #[must_use]
    pub fn plan(&self) -> &CertifiedPlan {
        &self.plan
    }

    /// The plan, when the session is over.
    #[must_use]
    pub fn into_plan(self) -> CertifiedPlan {
        self.plan
    }

    /// The guard, to look at.
    #[must_use]
    pub fn guard(&self) -> &Guard {
        &self.guard
    }

    #[cfg(test)]
    pub(crate) fn guard_mut(&mut self) -> &mut Guard {
        &mut self.guard
    }

    /// The last reported position of the tool centre.
    #[must_use]
    pub fn position(&self) -> Option<Point> {
        self.position
    }

    /// Finishing loops contoured so far.
    #[must_use]
    pub fn finished(&self) -> &[LoopNumber] {
        &self.finished
    }

    /// Finishing loops of the last contour's free space that no way was found to.
    #[must_use]
    pub fn unreached(&self) -> usize {
        self.unreached
    }

    /// Things the operator should know.
    #[must_use]
    pub fn notices(&self) -> &[String] {
        &self.notices
    }

    /// Counters.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    fn take_reply(&mut self, reply: Reply, now: Time, commands: &mut Vec<Command>) -> Result<(), Fault> {
        match reply {
            Reply::Report(report) => self.take_report(&report, now, commands),
            Reply::Ok => self.take_ok(commands),
            Reply::Error(code) => self.take_error(code, commands),
            Reply::Alarm(code) => Err(Fault::Alarm { code }),
            Reply::Garbled(line) => match &mut self.state {
                // What is left in the line from before the connection is not held against the controller.
                State::Connecting { garbled } => {
                    *garbled = Some(line);
                    Ok(())
                }
                _ => Err(Fault::Garbled { line }),
            },
            Reply::Greeting(_) => match self.state {
                State::Connecting { .. } => Ok(()),
                _ => Err(Fault::WasReset),
            },
            Reply::Setting(number, value) => {
                if let State::ReadingSettings(settings) = &mut self.state {
                    settings.take(number, value);
                }
                Ok(())
            }
            Reply::Message(text) => {
                self.notices.push(text);
                Ok(())
            }
        }
    }

    fn take_report(&mut self, report: &Report, now: Time, commands: &mut Vec<Command>) -> Result<(), Fault> {
        self.position = report.position.or(self.position);
        if let (Some(known), Some(now)) = (self.work_offset, report.work_offset)
            && known != now
            && self.phase() != Phase::Starting
        {
            return Err(Fault::OffsetChanged);
        }
        self.work_offset = report.work_offset.or(self.work_offset);
        if let Some(asked) = self.asked_at.take() {
            let measured = now.since(asked);
            // Quick to grow, slow to shrink.
            self.round_trip =
                if measured > self.round_trip { measured } else { (self.round_trip * 7 + measured) / 8 };
        }
        self.answered_at = now;
        let stamp = self.queries.pop_front();
        match &self.state {
            State::Connecting { .. } => self.connected(report, commands),
            State::Locating { lines_open: 0 } => self.take_place(report),
            State::Manual(_) | State::Contouring { .. } | State::Stopping => {
                self.check_mode(report)?;
                match stamp {
                    Some(stamp) => self.take_sighting(report, stamp, now),
                    None => Ok(()),
                }
            }
            _ => Ok(()),
        }
    }

    fn check_mode(&self, report: &Report) -> Result<(), Fault> {
        match report.mode {
            Mode::Idle | Mode::Moving => Ok(()),
            Mode::Held if matches!(self.state, State::Stopping) => Ok(()),
            Mode::Alarm => Err(Fault::Alarm { code: 0 }),
            mode => Err(Fault::Unexpected { mode }),
        }
    }

    fn take_sighting(&mut self, report: &Report, stamp: Stamp, now: Time) -> Result<(), Fault> {
        let queued = match (self.planner_blocks, report.free_blocks) {
            (Some(all), Some(free)) => Some(all.saturating_sub(free)),
            _ => None,
        };
        let Some(position) = report.position else { return Ok(()) };
        let sighting = Sighting { position, at_rest: report.mode == Mode::Idle, queued };
        self.check_answers(&sighting, now)?;
        self.guard.reported(&sighting, stamp, now)?;
        if report.mode == Mode::Held && matches!(self.state, State::Stopping) {
            self.state = State::Done;
        }
        if self.guard.settled() {
            match &mut self.state {
                State::Manual(manual) => manual.settle(),
                State::Contouring { cuts } => {
                    self.finished.append(cuts);
                    self.state = State::Manual(manual::Manual::default());
                }
                State::Stopping => self.state = State::Done,
                _ => {}
            }
        }
        Ok(())
    }

    /// A line is lost when the controller rests with an empty planner for long, and has not answered it.
    fn check_answers(&mut self, sighting: &Sighting, now: Time) -> Result<(), Fault> {
        let open = self.guard.unacknowledged() > 0;
        if !(open && sighting.at_rest && sighting.queued.is_none_or(|queued| queued == 0)) {
            self.unanswered_since = None;
            return Ok(());
        }
        let since = *self.unanswered_since.get_or_insert(now);
        if now.since(since) > self.options.answer_within { Err(Fault::LineLost) } else { Ok(()) }
    }

    fn check_silence(&self, now: Time) -> Result<(), Fault> {
        let silent = now.since(self.heard_at);
        let allowed =
            if matches!(self.state, State::Homing) { HOMING_MAX } else { self.options.answer_within };
        let over = matches!(self.state, State::Done | State::Faulted(_));
        match &self.state {
            State::Waking | State::ReadingSettings(_) | State::Storing { .. } | State::Locating { .. }
                if now.since(self.progress_at) > START_WITHIN.max(allowed) =>
            {
                Err(Fault::LineLost)
            }
            _ if silent <= allowed || over => Ok(()),
            State::Connecting { garbled: Some(line) } => Err(Fault::Garbled { line: line.clone() }),
            _ => Err(Fault::Silent { seconds: silent.as_secs_f64() }),
        }
    }

    /// What the state wants done now. A mere tick steers only when the operator has fallen silent.
    fn act(&mut self, tick: bool, now: Time, commands: &mut Vec<Command>) -> Result<(), Fault> {
        if self.wants_query(now) {
            self.query(now, commands);
        }
        match &self.state {
            State::Manual(_) => {
                if self.wish.ask == Some(Ask::Quit) {
                    self.begin_stopping(commands);
                    return Ok(());
                }
                if !tick || manual::fresh(self.wish, self.wished_at, now).is_none() {
                    self.touch_or_steer(now, commands);
                }
            }
            State::Contouring { .. } if self.wish.ask == Some(Ask::Quit) => self.begin_stopping(commands),
            State::Contouring { .. } => {
                if let Some(certified) = self.guard.next_of_contour() {
                    self.counts.contour_motions += 1;
                    commands.push(Command::Move(certified));
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn begin_stopping(&mut self, commands: &mut Vec<Command>) {
        let contouring = matches!(self.state, State::Contouring { .. });
        self.state = if self.guard.settled() { State::Done } else { State::Stopping };
        if !self.guard.settled() {
            commands.push(if contouring { Command::Hold } else { Command::Cancel });
        }
    }

    /// Brings the machine to rest and ends the session.
    pub fn halt(&mut self) -> Vec<Command> {
        let mut commands = Vec::new();
        match self.state {
            State::Manual(_) | State::Contouring { .. } => self.begin_stopping(&mut commands),
            State::Stopping | State::Done | State::Faulted(_) => {}
            _ => self.state = State::Done,
        }
        commands
    }

    fn wants_query(&self, now: Time) -> bool {
        let over = matches!(self.state, State::Done | State::Faulted(_) | State::Homing);
        let waiting = matches!(self.state, State::Waking | State::ReadingSettings(_) | State::Storing { .. });
        let due = match self.asked_at {
            Some(asked) => now.since(asked) >= QUERY_AGAIN.max(self.round_trip * 2),
            None => now.since(self.answered_at) >= QUERY_PAUSE,
        };
        !over && !waiting && due
    }

    fn query(&mut self, now: Time, commands: &mut Vec<Command>) {
        self.asked_at = Some(now);
        self.queries.push_back(self.guard.stamp(now));
        self.counts.queries += 1;
        commands.push(Command::Query);
    }

    fn touch_or_steer(&mut self, now: Time, commands: &mut Vec<Command>) {
        if self.armed && self.guard.settled() && self.touches() {
            match self.begin_contour() {
                Ok(()) => return,
                Err(reason) => {
                    if self.notices.last() != Some(&reason) {
                        self.notices.push(reason);
                    }
                }
            }
        }
        let State::Manual(manual) = &mut self.state else { return };
        let wish = manual::fresh(self.wish, self.wished_at, now);
        manual.steer(wish, self.round_trip, &self.limits, &mut self.guard, &mut self.counts, commands);
    }

    /// Whether the tool stands at the wall.
    fn touches(&self) -> bool {
        let Some(at) = self.guard.end() else { return false };
        let Ok(band) = length_up_from_mm(TOUCH_MM) else { return false };
        let here = keepout_kernel::Segment { from: at.point(), to: at.point() };
        self.plan.part.edges_clear(here, at.threshold().saturating_plus(band)).is_err()
    }

    fn begin_contour(&mut self) -> Result<(), String> {
        let from = self.guard.end().ok_or("the tool's position is not known")?.point();
        let job = contour_job(&self.plan, from, self.options.stroke).map_err(|error| error.to_string())?;
        let fast = manual::feed(self.limits.speed_mm_s / 2.0);
        let of_pass = |cut: LoopNumber| self.plan.plan.passes[cut.pass].feed_mm_min;
        let feed = |leg: &Leg| match leg.cuts {
            Some(cut) => of_pass(cut).unwrap_or(self.options.feed_mm_min),
            None => fast,
        };
        let curves: Vec<(Curve, u32)> =
            job.legs.iter().flat_map(|leg| leg.curves.iter().map(|&curve| (curve, feed(leg)))).collect();
        let cuts = job.legs.iter().filter_map(|leg| leg.cuts).collect();
        self.guard.take_contour(curves).map_err(|refusal| format!("contouring refused: {refusal}"))?;
        self.unreached = job.unreached.len();
        for unreached in &job.unreached {
            self.notices.push(format!("no way wide enough for roughing leads to finishing {unreached}"));
        }
        self.state = State::Contouring { cuts };
        self.armed = false;
        Ok(())
    }

    fn stop(&mut self, fault: Fault, commands: &mut Vec<Command>) {
        if matches!(self.state, State::Faulted(_) | State::Done) {
            return;
        }
        commands.retain(|command| !matches!(command, Command::Move(_)));
        commands.push(if matches!(self.state, State::Contouring { .. }) {
            Command::Hold
        } else {
            Command::Cancel
        });
        self.guard.forget();
        self.state = State::Faulted(fault);
    }
}

/// How far a reported position can be from the commanded one: the budget's controller resolution.
fn resolution(budget: &Budget) -> Length {
    let terms = budget.terms.iter().filter(|term| term.name.starts_with("controller resolution"));
    let sum: f64 = terms.map(|term| term.mm).sum();
    length_up_from_mm(sum).unwrap_or(Length::small(100))
}

/// A point for the log, in mm.
#[must_use]
pub fn log_point(point: Point) -> String {
    format!("{:.5},{:.5}", mm(point.x.units()), mm(point.y.units()))
}

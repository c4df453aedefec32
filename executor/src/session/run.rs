//! The session loop: it feeds the engine from port, operator and clock.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use keepout_guard::Time;
use keepout_kernel::Place;
use keepout_planner::job::{ContourJob, JobError};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{mm, point_mm};
use keepout_planner::{Box2, Mm2};

use super::clock::Clock;
use super::engine::Engine;
use super::event_log::{EventLog, EventLogError, LoggedEvent};
use super::outcome::{Ending, JobOutcome};
use crate::operator::{Operator, OperatorView};
use crate::session::port::{Port, PortError};
use crate::supervisor::{JobRequest, OperatorCommand, Phase, Supervisor};

/// Longest time from the halt of a session to standstill.
const REST_WITHIN: Duration = Duration::from_secs(10);
/// Time between two flushes of the log.
const FLUSH_EVERY: Duration = Duration::from_millis(500);
/// Time between two attempts to reopen a lost port.
const REOPEN_EVERY: Duration = Duration::from_secs(1);

/// A planner of contouring jobs.
pub type Planner<'a> = Box<dyn FnMut(&JobRequest, &CertifiedPlan) -> Result<ContourJob, JobError> + 'a>;

/// Reopens a lost port.
pub type Reopen<'a, P> = Box<dyn FnMut() -> Result<P, PortError> + 'a>;

/// A running session.
pub struct Session<'a, P: Port> {
    engine: Engine,
    port: Option<P>,
    reopen: Option<Reopen<'a, P>>,
    operator: Box<dyn Operator + Send + 'a>,
    event_log: Box<dyn EventLog + 'a>,
    input_due: Time,
    flush_due: Time,
    reopen_due: Time,
    bytes: Vec<u8>,
    job: Option<JoinHandle<Result<ContourJob, JobError>>>,
    /// Replaces the product's planner, in virtual time only.
    planner: Option<Planner<'a>>,
    part_box: Box2,
    /// Whether the operator can recover from a fault. A fault then does not end the session.
    recovers: bool,
    /// The operator has given Stop.
    stop_given: bool,
}

impl<'a, P: Port> Session<'a, P> {
    /// Builds a session.
    pub fn new(
        engine: Engine,
        port: P,
        operator: Box<dyn Operator + Send + 'a>,
        event_log: Box<dyn EventLog + 'a>,
    ) -> Self {
        Self {
            part_box: engine.supervisor.plan().part_box(),
            engine,
            port: Some(port),
            reopen: None,
            operator,
            event_log,
            input_due: Time::ZERO,
            flush_due: Time::ZERO,
            reopen_due: Time::ZERO,
            bytes: Vec::with_capacity(4096),
            job: None,
            recovers: false,
            stop_given: false,
            planner: None,
        }
    }

    /// The same session with recovery: the operator can recover from a fault, and `reopen` opens a lost port
    /// again.
    #[must_use]
    pub fn recovering(self, reopen: Reopen<'a, P>) -> Self {
        Self { reopen: Some(reopen), recovers: true, ..self }
    }

    /// The same session with another planner, in virtual time. The guard certifies its motions all the same.
    #[must_use]
    pub fn planned_by(self, planner: Planner<'a>) -> Self {
        Self { planner: Some(planner), ..self }
    }

    /// The supervisor.
    #[must_use]
    pub fn supervisor(&self) -> &Supervisor {
        &self.engine.supervisor
    }

    /// Ends the session and returns the supervisor.
    #[must_use]
    pub fn into_supervisor(self) -> Supervisor {
        self.engine.supervisor
    }

    /// The port, unless it is lost.
    pub fn port(&mut self) -> Option<&mut P> {
        self.port.as_mut()
    }

    /// Reads and drops the bytes that the machine still sends.
    pub fn drain(&mut self, now: Time) {
        self.bytes.clear();
        if let Some(port) = &mut self.port {
            let _ = port.read(&mut self.bytes, now);
        }
    }

    /// Runs the session to its end. After `limit` it brings the machine to rest. It calls `watch` after every
    /// round, and `watch` may end the session.
    ///
    /// # Errors
    /// [`EventLogError`] if the log cannot be written. The session then sends [`Engine::stop_bytes`] only.
    /// Motions that these do not cancel run to their certified ends.
    pub fn run(
        &mut self,
        clock: &mut impl Clock,
        limit: Duration,
        mut watch: impl FnMut(&mut Self, Time) -> Going,
    ) -> Result<JobOutcome, EventLogError> {
        let mut over: Option<Time> = None;
        let mut halted = false;
        loop {
            let now = clock.now();
            if over.is_none() && (halted || now >= Time::ZERO.after(limit)) {
                over = Some(now);
                self.guarded(now, |session| {
                    let (engine, log) = (&mut session.engine, session.event_log.as_mut());
                    if halted { engine.halt(now, log) } else { engine.time_limit(now, log) }
                })?;
            }
            self.guarded(now, |session| session.round(now, clock.is_real()))?;
            halted |= watch(self, now) == Going::Halt;
            if let Some(outcome) = self.outcome(over.filter(|_| !halted), over, now) {
                let words = outcome.to_string();
                self.event_log.take(now, &LoggedEvent::Outcome(words.into()))?;
                self.event_log.flush()?;
                return Ok(outcome);
            }
            clock.wait(self.due(limit, over));
        }
    }

    /// The outcome, once the session has ended.
    fn outcome(&self, out_of_time: Option<Time>, over: Option<Time>, now: Time) -> Option<JobOutcome> {
        let supervisor = self.supervisor();
        match supervisor.phase() {
            // A fault after Stop ends the session: the operator does not want to recover.
            Phase::Faulted if !self.recovers || self.stop_given || over.is_some() => {
                let fault = supervisor.fault().map(ToString::to_string).unwrap_or_default();
                Some(JobOutcome::of(supervisor, Ending::Fault(fault)))
            }
            Phase::Done if out_of_time.is_none() => Some(JobOutcome::by_operator(supervisor)),
            Phase::Done => Some(JobOutcome::of(supervisor, Ending::TimeLimit)),
            _ if over.is_some_and(|over| now.since(over) > REST_WITHIN) => {
                Some(JobOutcome::of(supervisor, Ending::TimeLimit))
            }
            _ => None,
        }
    }

    /// The time of the next event.
    fn due(&self, limit: Duration, over: Option<Time>) -> Time {
        let port = self.port.as_ref().map_or(self.reopen_due, Port::next_event);
        let end = over.map_or(Time::ZERO.after(limit), |over| over.after(REST_WITHIN).after(FLUSH_EVERY));
        self.engine.supervisor.due().min(self.input_due).min(self.flush_due).min(port).min(end)
    }

    /// Acts, and writes the engine's output. If the log fails, it sends the stop bytes only: the motions in
    /// flight end at their certified targets, or sooner.
    fn guarded(
        &mut self,
        now: Time,
        act: impl FnOnce(&mut Self) -> Result<(), EventLogError>,
    ) -> Result<(), EventLogError> {
        let outcome = act(self).and_then(|()| self.write(now));
        outcome.inspect_err(|_| {
            let stop = self.engine.stop_bytes();
            if let Some(port) = &mut self.port {
                let _ = port.write(&stop, now);
            }
        })
    }

    /// One round: it reads replies, the operator's commands and input, and the timer.
    fn round(&mut self, now: Time, real: bool) -> Result<(), EventLogError> {
        self.read(now)?;
        if now >= self.input_due {
            self.input_due = now.after(self.operator.every());
            let seen = self.seen();
            let input = self.operator.input(&seen, now);
            // Some operators repeat Stop at each input. It counts once.
            let stopped = self.stop_given;
            if let Some(command) = self.operator.command().filter(|_| !stopped) {
                self.stop_given = command == OperatorCommand::Stop;
                self.engine.command(command, now, self.event_log.as_mut())?;
            }
            self.engine.input(input, now, self.event_log.as_mut())?;
        }
        if now >= self.engine.supervisor.due() {
            self.engine.tick(now, self.event_log.as_mut())?;
        }
        self.work_out(now, real)?;
        if now >= self.flush_due {
            self.flush_due = now.after(FLUSH_EVERY);
            self.event_log.flush()?;
        }
        Ok(())
    }

    fn read(&mut self, now: Time) -> Result<(), EventLogError> {
        self.bytes.clear();
        let Some(port) = &mut self.port else { return self.find_port(now) };
        let outcome = port.read(&mut self.bytes, now);
        self.engine.receive(&self.bytes, now, self.event_log.as_mut())?;
        match outcome {
            Ok(()) => Ok(()),
            Err(error) => self.lose_port(&error, now),
        }
    }

    fn lose_port(&mut self, error: &PortError, now: Time) -> Result<(), EventLogError> {
        if self.reopen.is_some() {
            self.port = None;
            self.reopen_due = now.after(REOPEN_EVERY);
        }
        self.engine.port_lost(&error.to_string(), now, self.event_log.as_mut())
    }

    fn find_port(&mut self, now: Time) -> Result<(), EventLogError> {
        let Some(reopen) = self.reopen.as_mut().filter(|_| now >= self.reopen_due) else { return Ok(()) };
        self.reopen_due = now.after(REOPEN_EVERY);
        if let Ok(port) = reopen() {
            self.port = Some(port);
            self.engine.port_found(now, self.event_log.as_mut())?;
        }
        Ok(())
    }

    /// Computes the contouring job that the supervisor waits for. In real time a thread does it.
    fn work_out(&mut self, now: Time, real: bool) -> Result<(), EventLogError> {
        if let Some(thread) = self.job.take_if(|thread| thread.is_finished()) {
            let job = thread.join().unwrap_or(Err(JobError::Failed));
            return self.engine.job(job, now, self.event_log.as_mut());
        }
        if self.job.is_some() {
            return Ok(());
        }
        let Some(request) = self.engine.wanted_job() else { return Ok(()) };
        let plan = Arc::clone(&self.supervisor().work().plan);
        if real {
            self.job = Some(std::thread::spawn(move || request.work_out(&plan)));
            return Ok(());
        }
        let job = match &mut self.planner {
            Some(planner) => planner(&request, &plan),
            None => request.work_out(&plan),
        };
        self.engine.job(job, now, self.event_log.as_mut())
    }

    /// Writes the engine's output to the port, after a flush of the log.
    fn write(&mut self, now: Time) -> Result<(), EventLogError> {
        let mut lost = None;
        for _ in 0..2 {
            self.bytes.clear();
            let mut chunks = 0;
            let (bytes, port) = (&mut self.bytes, &mut self.port);
            let event_log = &mut self.event_log;
            let mut flushed = Ok(());
            self.engine.drain(|chunk| {
                if chunks == 0 {
                    flushed = event_log.flush();
                }
                chunks += 1;
                let Some(port) = port.as_mut().filter(|_| flushed.is_ok() && lost.is_none()) else { return };
                lost = port.write(chunk, now).err();
                bytes.extend(chunk);
            });
            flushed?;
            match lost.take() {
                Some(error) => self.lose_port(&error, now)?,
                None => return Ok(()),
            }
        }
        Ok(())
    }

    fn seen(&self) -> OperatorView {
        let supervisor = self.supervisor();
        let plan = supervisor.plan();
        let position_mm = supervisor.position().map(|place| point_mm(place.point));
        OperatorView {
            position_mm,
            height_mm: supervisor.height_mm(),
            wall_mm: supervisor.position().and_then(|position| nearest_wall(plan, position)),
            part_box: self.part_box,
            end_mm: supervisor.guard().end().map(|end| point_mm(end.point())),
            unacknowledged: supervisor.guard().unacknowledged(),
            spindle_runs: supervisor.spindle_runs() == Some(true),
            phase: supervisor.phase(),
            contoured: supervisor.finished().len() > supervisor.finished_before(),
        }
    }
}

/// The choice of `watch` after a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Going {
    /// The session goes on.
    On,
    /// The session brings the machine to rest, and ends.
    Halt,
}

/// The way that the tool may still move toward the nearest wall, for display, mm.
#[must_use]
pub fn free_way_mm(supervisor: &Supervisor) -> Option<f64> {
    let (plan, position) = (supervisor.plan(), supervisor.position()?);
    let contouring = matches!(supervisor.phase(), Phase::Contouring | Phase::Holding);
    let clearance = if contouring { plan.finishing } else { plan.roughing };
    let distance = point_mm(position.point).distance(nearest_wall(plan, position)?);
    Some((distance - mm(clearance.units())).max(0.0))
}

/// The point of what stands above the tip that is nearest to the tool, for display, mm.
#[must_use]
pub fn nearest_wall(plan: &CertifiedPlan, position: Place) -> Option<Mm2> {
    let part = plan.region(position.height);
    let nearest = part.index().nearest(position.point, None)?;
    let chord = part.edges().get(nearest.edge)?.chord;
    Some(point_mm(position.point).nearest_on(point_mm(chord.from), point_mm(chord.to)))
}

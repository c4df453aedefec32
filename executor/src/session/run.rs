//! The loop that feeds the engine.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use keepout_guard::Time;
use keepout_kernel::Point;
use keepout_planner::job::{ContourJob, JobError};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{nearest_on_mm, point_mm};

use super::engine::Engine;
use super::event_log::{EventLog, EventLogError};
use crate::operator::{Operator, OperatorView};
use crate::session::port::{Port, PortError};
use crate::supervisor::{JobRequest, OperatorCommand, Phase, Supervisor};

/// Where time comes from.
pub trait Clock {
    /// The time now.
    fn now(&mut self) -> Time;
    /// Waits until something may be due: `until` at the latest.
    fn wait(&mut self, until: Time);
    /// Whether work that takes long must be done elsewhere.
    fn is_real(&self) -> bool;
}

/// The machine's clock.
#[derive(Debug)]
pub struct RealClock {
    began: Instant,
}

impl Default for RealClock {
    fn default() -> Self {
        Self { began: Instant::now() }
    }
}

impl Clock for RealClock {
    fn now(&mut self) -> Time {
        Time::ZERO.after(self.began.elapsed())
    }

    fn wait(&mut self, until: Time) {
        let left = until.since(self.now());
        std::thread::sleep(left.min(Duration::from_micros(500)));
    }

    fn is_real(&self) -> bool {
        true
    }
}

/// A clock that moves only when waited for.
#[derive(Debug, Default)]
pub struct VirtualClock {
    now: Time,
}

impl Clock for VirtualClock {
    fn now(&mut self) -> Time {
        self.now
    }

    fn wait(&mut self, until: Time) {
        self.now = until.max(self.now.after(Duration::from_micros(1)));
    }

    fn is_real(&self) -> bool {
        false
    }
}

impl<C: Clock> Clock for &mut C {
    fn now(&mut self) -> Time {
        (**self).now()
    }

    fn wait(&mut self, until: Time) {
        (**self).wait(until);
    }

    fn is_real(&self) -> bool {
        (**self).is_real()
    }
}

/// After the time is over, the machine comes to rest within this.
const REST_WITHIN: Duration = Duration::from_secs(10);
/// Time between two flushes of the log.
const FLUSH_EVERY: Duration = Duration::from_millis(500);
/// Time between two attempts to open a lost port again.
const REOPEN_EVERY: Duration = Duration::from_secs(1);

/// Most operator commands that one round takes.
const COMMANDS_MAX: usize = 8;

/// How a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// As the operator wanted.
    Done,
    /// By a fault; the supervisor says which.
    Faulted,
    /// The time that was allowed is over.
    OutOfTime,
}

/// Works out contouring jobs.
pub type Planner<'a> = Box<dyn FnMut(&JobRequest, &CertifiedPlan) -> Result<ContourJob, JobError> + 'a>;

/// Opens a port again.
pub type Reopen<'a, P> = Box<dyn FnMut() -> Result<P, PortError> + 'a>;

/// A session under way.
pub struct Session<'a, P: Port> {
    engine: Engine,
    port: Option<P>,
    reopen: Option<Reopen<'a, P>>,
    operator: Box<dyn Operator + Send + 'a>,
    tape: Box<dyn EventLog + 'a>,
    input_due: Time,
    flush_due: Time,
    reopen_due: Time,
    bytes: Vec<u8>,
    job: Option<JoinHandle<Result<ContourJob, JobError>>>,
    /// In virtual time, instead of the planner.
    planner: Option<Planner<'a>>,
    part_box_mm: (f64, f64, f64, f64),
    /// A fault does not end the session: the operator can recover from it.
    recovers: bool,
}

impl<'a, P: Port> Session<'a, P> {
    /// Puts a session together.
    pub fn new(
        engine: Engine,
        port: P,
        operator: Box<dyn Operator + Send + 'a>,
        tape: Box<dyn EventLog + 'a>,
    ) -> Self {
        let (low, high) = engine.supervisor.plan().part_box();
        let ((x0, y0), (x1, y1)) = (point_mm(low), point_mm(high));
        Self {
            part_box_mm: (x0, y0, x1, y1),
            engine,
            port: Some(port),
            reopen: None,
            operator,
            tape,
            input_due: Time::ZERO,
            flush_due: Time::ZERO,
            reopen_due: Time::ZERO,
            bytes: Vec::with_capacity(4096),
            job: None,
            recovers: false,
            planner: None,
        }
    }

    /// The same session, from whose faults the operator can recover; a lost port is opened again by `reopen`.
    #[must_use]
    pub fn recovering(self, reopen: Reopen<'a, P>) -> Self {
        Self { reopen: Some(reopen), recovers: true, ..self }
    }

    /// The same session with another planner, in virtual time: what it proposes is certified all the same.
    #[must_use]
    pub fn planned_by(self, planner: Planner<'a>) -> Self {
        Self { planner: Some(planner), ..self }
    }

    /// The supervisor.
    #[must_use]
    pub fn supervisor(&self) -> &Supervisor {
        &self.engine.supervisor
    }

    /// Gives the supervisor back.
    #[must_use]
    pub fn into_supervisor(self) -> Supervisor {
        self.engine.supervisor
    }

    /// The port, unless it is lost.
    pub fn port(&mut self) -> Option<&mut P> {
        self.port.as_mut()
    }

    /// Reads and forgets what the machine still says.
    pub fn drain(&mut self, now: Time) {
        self.bytes.clear();
        if let Some(port) = &mut self.port {
            let _ = port.read(&mut self.bytes, now);
        }
    }

    /// Runs until the end; after `limit` the machine is brought to rest. `watch` is called after every round, and may end
    /// the session.
    ///
    /// # Errors
    /// [`EventLogError`] when the log can not be written on. Nothing more is sent then, and the queued motions run to their certified ends.
    pub fn run(
        &mut self,
        clock: &mut impl Clock,
        limit: Duration,
        mut watch: impl FnMut(&mut Self, Time) -> Going,
    ) -> Result<Ended, EventLogError> {
        let mut over: Option<Time> = None;
        let mut halted = false;
        loop {
            let now = clock.now();
            if over.is_none() && (halted || now >= Time::ZERO.after(limit)) {
                over = Some(now);
                self.guarded(now, |session| session.engine.halt(now, session.tape.as_mut()))?;
            }
            self.guarded(now, |session| session.round(now, clock.is_real()))?;
            halted |= watch(self, now) == Going::Halt;
            if let Some(ended) = self.ended(over.filter(|_| !halted), over, now) {
                self.tape.flush()?;
                return Ok(ended);
            }
            clock.wait(self.due(limit, over));
        }
    }

    fn ended(&self, out_of_time: Option<Time>, over: Option<Time>, now: Time) -> Option<Ended> {
        match self.supervisor().phase() {
            Phase::Faulted if !self.recovers || over.is_some() => Some(Ended::Faulted),
            Phase::Done if out_of_time.is_some() => Some(Ended::OutOfTime),
            Phase::Done => Some(Ended::Done),
            _ if over.is_some_and(|over| now.since(over) > REST_WITHIN) => Some(Ended::OutOfTime),
            _ => None,
        }
    }

    /// When something is due.
    fn due(&self, limit: Duration, over: Option<Time>) -> Time {
        let port = self.port.as_ref().map_or(self.reopen_due, Port::next_event);
        let end = over.map_or(Time::ZERO.after(limit), |over| over.after(REST_WITHIN).after(FLUSH_EVERY));
        self.engine.supervisor.due().min(self.input_due).min(self.flush_due).min(port).min(end)
    }

    /// Without a log nothing may go on: what is in flight ends at its certified target, or sooner.
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

    /// One round: replies in, the operator's input, a tick; commands out.
    fn round(&mut self, now: Time, real: bool) -> Result<(), EventLogError> {
        self.read(now)?;
        if now >= self.input_due {
            self.input_due = now.after(self.operator.every());
            let seen = self.seen();
            let input = self.operator.input(&seen, now);
            for _ in 0..COMMANDS_MAX {
                let Some(command) = self.operator.command() else { break };
                self.engine.command(command, now, self.tape.as_mut())?;
                if command == OperatorCommand::Stop {
                    break;
                }
            }
            self.engine.input(input, now, self.tape.as_mut())?;
        }
        if now >= self.engine.supervisor.due() {
            self.engine.tick(now, self.tape.as_mut())?;
        }
        self.work_out(now, real)?;
        if now >= self.flush_due {
            self.flush_due = now.after(FLUSH_EVERY);
            self.tape.flush()?;
        }
        Ok(())
    }

    fn read(&mut self, now: Time) -> Result<(), EventLogError> {
        self.bytes.clear();
        let Some(port) = &mut self.port else { return self.find_port(now) };
        let outcome = port.read(&mut self.bytes, now);
        self.engine.receive(&self.bytes, now, self.tape.as_mut())?;
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
        self.engine.port_lost(&error.to_string(), now, self.tape.as_mut())
    }

    fn find_port(&mut self, now: Time) -> Result<(), EventLogError> {
        let Some(reopen) = self.reopen.as_mut().filter(|_| now >= self.reopen_due) else { return Ok(()) };
        self.reopen_due = now.after(REOPEN_EVERY);
        if let Ok(port) = reopen() {
            self.port = Some(port);
            self.engine.port_found(now, self.tape.as_mut())?;
        }
        Ok(())
    }

    /// Works out a contouring job that is wanted: in a thread when time is real.
    fn work_out(&mut self, now: Time, real: bool) -> Result<(), EventLogError> {
        if let Some(thread) = self.job.take_if(|thread| thread.is_finished()) {
            let job = thread.join().unwrap_or(Err(JobError::Failed));
            return self.engine.job(job, now, self.tape.as_mut());
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
        self.engine.job(job, now, self.tape.as_mut())
    }

    /// Writes what the engine wants sent, after the log has been handed to the system.
    fn write(&mut self, now: Time) -> Result<(), EventLogError> {
        let mut lost = None;
        for _ in 0..2 {
            self.bytes.clear();
            let mut pieces = 0;
            let (bytes, port) = (&mut self.bytes, &mut self.port);
            let tape = &mut self.tape;
            let mut flushed = Ok(());
            self.engine.drain(|piece| {
                if pieces == 0 {
                    flushed = tape.flush();
                }
                pieces += 1;
                let Some(port) = port.as_mut().filter(|_| flushed.is_ok() && lost.is_none()) else { return };
                lost = port.write(piece, now).err();
                bytes.extend(piece);
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
        let position_mm = supervisor.position().map(point_mm);
        OperatorView {
            position_mm,
            wall_mm: supervisor.position().and_then(|position| nearest_wall(plan, position)),
            part_box_mm: self.part_box_mm,
            end_mm: supervisor.guard().end().map(|end| point_mm(end.point())),
            unacknowledged: supervisor.guard().unacknowledged(),
            phase: supervisor.phase(),
            contoured: supervisor.finished().len() > supervisor.finished_before(),
        }
    }
}

/// Whether a session goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Going {
    /// It does.
    On,
    /// The machine is to be brought to rest, and the session ends.
    Halt,
}

/// The nearest point of the part, for the operator's eye.
#[must_use]
pub fn nearest_wall(plan: &CertifiedPlan, position: Point) -> Option<(f64, f64)> {
    let nearest = plan.part.index().nearest(position, None)?;
    let chord = plan.part.edges().get(nearest.edge)?.chord;
    Some(nearest_on_mm(point_mm(position), point_mm(chord.from), point_mm(chord.to)))
}

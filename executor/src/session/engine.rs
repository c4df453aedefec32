//! The engine: supervisor and dialect. It turns bytes and inputs into bytes, without clock, port or file.

use std::borrow::Cow;

use keepout_guard::Time;
use keepout_planner::job::{ContourJob, JobError};

use super::event_log::{Certificate, EventLog, EventLogError, LoggedEvent};
use crate::dialect::Dialect;
use crate::supervisor::{
    Command, Event, JobRequest, OperatorCommand, OperatorInput, Phase, Supervisor, text,
};

/// The supervisor and its dialect. The engine writes every input and every output into an [`EventLog`]. A
/// replay of the inputs must give the same outputs.
pub struct Engine {
    /// The supervisor.
    pub supervisor: Supervisor,
    dialect: Box<dyn Dialect>,
    commands: Vec<Command>,
    out: Vec<u8>,
    /// The end of each chunk of `out`.
    ends: Vec<usize>,
}

/// Initial capacity of the output, bytes. The output of one step fits in general. A longer one allocates
/// memory.
const OUT: usize = 1024;

impl Engine {
    /// Builds an engine.
    #[must_use]
    pub fn new(supervisor: Supervisor, dialect: Box<dyn Dialect>) -> Self {
        Self {
            supervisor,
            dialect,
            commands: Vec::with_capacity(16),
            out: Vec::with_capacity(OUT),
            ends: Vec::with_capacity(16),
        }
    }

    /// Takes bytes from the controller.
    ///
    /// # Errors
    /// [`EventLogError`] if the event log cannot take the event. The caller may then send only
    /// [`Engine::stop_bytes`].
    pub fn receive(
        &mut self,
        bytes: &[u8],
        now: Time,
        event_log: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        if bytes.is_empty() {
            return Ok(());
        }
        event_log.take(now, &LoggedEvent::Received(bytes.into()))?;
        for &byte in bytes {
            let first = self.out.len();
            let reply = self.dialect.decode(byte, &mut self.out);
            self.chunk(first, now, event_log)?;
            if let Some(reply) = reply {
                self.feed(Event::Reply(reply), now, event_log)?;
            }
        }
        Ok(())
    }

    /// Takes the operator's input.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn input(
        &mut self,
        input: OperatorInput,
        now: Time,
        event_log: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        let input = input.finite();
        event_log.take(now, &LoggedEvent::Input(input))?;
        self.feed(Event::Input(input), now, event_log)
    }

    /// Takes an operator command.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn command(
        &mut self,
        command: OperatorCommand,
        now: Time,
        event_log: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        event_log.take(now, &LoggedEvent::Command(command))?;
        self.feed(Event::Command(command), now, event_log)
    }

    /// Passes the time `now` to the supervisor.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn tick(&mut self, now: Time, event_log: &mut dyn EventLog) -> Result<(), EventLogError> {
        event_log.take(now, &LoggedEvent::Tick)?;
        self.feed(Event::Tick, now, event_log)
    }

    /// Takes the planner's answer to [`Engine::wanted_job`].
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn job(
        &mut self,
        job: Result<ContourJob, JobError>,
        now: Time,
        event_log: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        event_log.take(now, &LoggedEvent::Job(Cow::Borrowed(&job)))?;
        self.feed(Event::Job(Box::new(job)), now, event_log)
    }

    /// Takes the failure of the port.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn port_lost(
        &mut self,
        reason: &str,
        now: Time,
        event_log: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        event_log.take(now, &LoggedEvent::PortLost(reason.into()))?;
        self.feed(Event::PortLost(text(reason)), now, event_log)
    }

    /// Takes the return of the port.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn port_found(&mut self, now: Time, event_log: &mut dyn EventLog) -> Result<(), EventLogError> {
        event_log.take(now, &LoggedEvent::PortFound)?;
        self.dialect.reset();
        self.feed(Event::PortFound, now, event_log)
    }

    /// Brings the machine to rest and ends the session.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn halt(&mut self, now: Time, event_log: &mut dyn EventLog) -> Result<(), EventLogError> {
        self.end(&LoggedEvent::Halt, now, event_log)
    }

    /// Brings the machine to rest and ends the session, because its time is over.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn time_limit(&mut self, now: Time, event_log: &mut dyn EventLog) -> Result<(), EventLogError> {
        self.end(&LoggedEvent::TimeLimit, now, event_log)
    }

    fn end(
        &mut self,
        why: &LoggedEvent<'_>,
        now: Time,
        event_log: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        event_log.take(now, why)?;
        let before = self.supervisor.phase();
        self.commands.extend(self.supervisor.halt());
        self.send(now, event_log)?;
        let after = self.supervisor.phase();
        if after != before { self.log_phase(after, now, event_log) } else { Ok(()) }
    }

    /// The contouring job that the supervisor waits for.
    #[must_use]
    pub fn wanted_job(&self) -> Option<JobRequest> {
        self.supervisor.wanted_job()
    }

    /// Hands the bytes to `write`, one chunk after the other. They then count as written.
    pub fn drain(&mut self, mut write: impl FnMut(&[u8])) {
        let mut first = 0;
        for &end in &self.ends {
            write(&self.out[first..end]);
            first = end;
        }
        self.out.clear();
        self.ends.clear();
    }

    /// The bytes of the last stop, for a session that can no longer use its event log.
    ///
    /// They cancel the jogs if the guard certifies the cancel. Without it the jogs end at their certified
    /// targets. A contour runs to the end of its queued motions.
    pub fn stop_bytes(&mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        if let Some(command) = self.supervisor.last_stop() {
            let _ = self.dialect.encode(&command, &mut bytes);
        }
        bytes
    }

    fn feed(&mut self, event: Event, now: Time, event_log: &mut dyn EventLog) -> Result<(), EventLogError> {
        let before = self.supervisor.phase();
        self.supervisor.step(event, now, &mut self.commands);
        self.send(now, event_log)?;
        let after = self.supervisor.phase();
        if after != before { self.log_phase(after, now, event_log) } else { Ok(()) }
    }

    fn log_phase(
        &mut self,
        phase: Phase,
        now: Time,
        event_log: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        let fault = self.supervisor.fault().map(ToString::to_string);
        event_log.take(now, &LoggedEvent::Phase { phase, fault })
    }

    /// Encodes the commands. If one cannot be encoded, it drops the rest, and encodes the supervisor's stop
    /// instead.
    fn send(&mut self, now: Time, event_log: &mut dyn EventLog) -> Result<(), EventLogError> {
        let mut failed = None;
        for index in 0..self.commands.len() {
            let command = self.commands[index];
            if let Command::Move(certified) = &command {
                let certificate = Certificate::of(certified, self.supervisor.guard());
                event_log.take(now, &LoggedEvent::Certificate(certificate))?;
            }
            let first = self.out.len();
            if let Err(error) = self.dialect.encode(&command, &mut self.out) {
                failed = Some(error);
                break;
            }
            self.chunk(first, now, event_log)?;
        }
        self.commands.clear();
        let Some(error) = failed else { return Ok(()) };
        let mut last = Vec::new();
        self.supervisor.step(Event::NotSent(error), now, &mut last);
        for command in last {
            let first = self.out.len();
            let _ = self.dialect.encode(&command, &mut self.out);
            self.chunk(first, now, event_log)?;
        }
        Ok(())
    }

    /// Closes the chunk of the bytes from `first` on.
    fn chunk(&mut self, first: usize, now: Time, event_log: &mut dyn EventLog) -> Result<(), EventLogError> {
        if self.out.len() > first {
            self.ends.push(self.out.len());
            event_log.take(now, &LoggedEvent::Sent(self.out[first..].into()))?;
        }
        Ok(())
    }
}

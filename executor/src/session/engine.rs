//! The engine: supervisor and dialect, from bytes and inputs to bytes. No clock, no port, no file.

use std::borrow::Cow;

use keepout_guard::Time;
use keepout_planner::job::{ContourJob, JobError};

use super::event_log::{Certificate, EventLog, EventLogError, LoggedEvent};
use crate::dialect::Dialect;
use crate::supervisor::{
    Command, Event, JobRequest, OperatorCommand, OperatorInput, Phase, Supervisor, text,
};

/// Supervisor and dialect. Everything that goes in, and everything that comes out, is told to a [`EventLog`]: played again, it
/// must come out the same.
pub struct Engine {
    /// The supervisor.
    pub supervisor: Supervisor,
    dialect: Box<dyn Dialect>,
    commands: Vec<Command>,
    out: Vec<u8>,
    /// Where each piece of `out` ends.
    ends: Vec<usize>,
}

/// Bytes that one step is expected to send at most; more is allowed, and allocates.
const OUT: usize = 1024;

impl Engine {
    /// An engine.
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
    /// [`EventLogError`] when the tape can not be written on; then nothing must be sent.
    pub fn receive(&mut self, bytes: &[u8], now: Time, tape: &mut dyn EventLog) -> Result<(), EventLogError> {
        if bytes.is_empty() {
            return Ok(());
        }
        tape.take(now, &LoggedEvent::Received(bytes.into()))?;
        for &byte in bytes {
            let first = self.out.len();
            let reply = self.dialect.decode(byte, &mut self.out);
            self.piece(first, now, tape)?;
            if let Some(reply) = reply {
                self.feed(Event::Reply(reply), now, tape)?;
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
        tape: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        let input = input.finite();
        tape.take(now, &LoggedEvent::Input(input))?;
        self.feed(Event::Input(input), now, tape)
    }

    /// Takes an operator command.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn command(
        &mut self,
        command: OperatorCommand,
        now: Time,
        tape: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        tape.take(now, &LoggedEvent::Command(command))?;
        self.feed(Event::Command(command), now, tape)
    }

    /// Time has passed.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn tick(&mut self, now: Time, tape: &mut dyn EventLog) -> Result<(), EventLogError> {
        tape.take(now, &LoggedEvent::Tick)?;
        self.feed(Event::Tick, now, tape)
    }

    /// Takes a contouring job that was wanted.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn job(
        &mut self,
        job: Result<ContourJob, JobError>,
        now: Time,
        tape: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        tape.take(now, &LoggedEvent::Job(Cow::Borrowed(&job)))?;
        self.feed(Event::Job(Box::new(job)), now, tape)
    }

    /// The port failed.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn port_lost(
        &mut self,
        reason: &str,
        now: Time,
        tape: &mut dyn EventLog,
    ) -> Result<(), EventLogError> {
        tape.take(now, &LoggedEvent::PortLost(reason.into()))?;
        self.feed(Event::PortLost(text(reason)), now, tape)
    }

    /// The port is back.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn port_found(&mut self, now: Time, tape: &mut dyn EventLog) -> Result<(), EventLogError> {
        tape.take(now, &LoggedEvent::PortFound)?;
        self.dialect.reset();
        self.feed(Event::PortFound, now, tape)
    }

    /// Brings the machine to rest and ends the session.
    ///
    /// # Errors
    /// As [`Engine::receive`].
    pub fn halt(&mut self, now: Time, tape: &mut dyn EventLog) -> Result<(), EventLogError> {
        tape.take(now, &LoggedEvent::Halt)?;
        let before = self.supervisor.phase();
        self.commands.extend(self.supervisor.halt());
        self.send(now, tape)?;
        let after = self.supervisor.phase();
        if after != before { self.tell(after, now, tape) } else { Ok(()) }
    }

    /// The contouring job that is wanted.
    #[must_use]
    pub fn wanted_job(&self) -> Option<JobRequest> {
        self.supervisor.wanted_job()
    }

    /// Bytes to write, piece by piece in order; they count as written.
    pub fn drain(&mut self, mut write: impl FnMut(&[u8])) {
        let mut first = 0;
        for &end in &self.ends {
            write(&self.out[first..end]);
            first = end;
        }
        self.out.clear();
        self.ends.clear();
    }

    /// The bytes that stop whatever moves, should nothing else work any more: as far as the controller then stays where it was
    /// certified. What can not be stopped so ends at its certified target.
    pub fn stop_bytes(&mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        if let Some(command) = self.supervisor.last_stop() {
            let _ = self.dialect.encode(&command, &mut bytes);
        }
        bytes
    }

    fn feed(&mut self, event: Event, now: Time, tape: &mut dyn EventLog) -> Result<(), EventLogError> {
        let before = self.supervisor.phase();
        self.supervisor.step(event, now, &mut self.commands);
        self.send(now, tape)?;
        let after = self.supervisor.phase();
        if after != before { self.tell(after, now, tape) } else { Ok(()) }
    }

    fn tell(&mut self, phase: Phase, now: Time, tape: &mut dyn EventLog) -> Result<(), EventLogError> {
        let fault = self.supervisor.fault().map(ToString::to_string);
        tape.take(now, &LoggedEvent::Phase { phase, fault })
    }

    /// Encodes the commands; when one can not be, nothing after it is, but what the supervisor then wants: to stop.
    fn send(&mut self, now: Time, tape: &mut dyn EventLog) -> Result<(), EventLogError> {
        let mut failed = None;
        for index in 0..self.commands.len() {
            let command = self.commands[index];
            if let Command::Move(certified) = &command {
                let certificate = Certificate::of(certified, self.supervisor.guard());
                tape.take(now, &LoggedEvent::Certificate(certificate))?;
            }
            let first = self.out.len();
            if let Err(error) = self.dialect.encode(&command, &mut self.out) {
                failed = Some(error);
                break;
            }
            self.piece(first, now, tape)?;
        }
        self.commands.clear();
        let Some(error) = failed else { return Ok(()) };
        let mut last = Vec::new();
        self.supervisor.step(Event::NotSent(error), now, &mut last);
        for command in last {
            let first = self.out.len();
            let _ = self.dialect.encode(&command, &mut self.out);
            self.piece(first, now, tape)?;
        }
        Ok(())
    }

    /// What was added since `first` is a piece of its own.
    fn piece(&mut self, first: usize, now: Time, tape: &mut dyn EventLog) -> Result<(), EventLogError> {
        if self.out.len() > first {
            self.ends.push(self.out.len());
            tape.take(now, &LoggedEvent::Sent(self.out[first..].into()))?;
        }
        Ok(())
    }
}

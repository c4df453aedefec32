//! What a session tells its log: everything that goes into the engine, and everything that comes out.

use keepout_guard::{Certified, Guard, Time};
use keepout_planner::job::ContourJob;
use thiserror::Error;

use crate::supervisor::{Fault, OperatorInput, Phase};

/// One thing that happened.
#[derive(Clone, Copy, Debug)]
pub enum LoggedEvent<'a> {
    /// Bytes came from the controller.
    Received(&'a [u8]),
    /// The operator's input.
    OperatorInput(OperatorInput),
    /// Time passed.
    Tick,
    /// A contouring job was worked out.
    Job(&'a Result<ContourJob, String>),
    /// The port failed.
    PortLost(&'a str),
    /// The port is back.
    PortFound,
    /// The session is to end.
    Halt,
    /// The motion that follows was certified with this in-flight set, which now holds its target.
    Certificate(&'a Certified, &'a Guard),
    /// Bytes go to the controller.
    Sent(&'a [u8]),
    /// The supervisor is in another state.
    Phase(Phase, Option<&'a Fault>),
}

/// Why a tape takes nothing more.
#[derive(Debug, Error)]
pub enum EventLogError {
    /// It can not be written on.
    #[error("the log could not be written on: {0}. The machine was stopped.")]
    Write(#[from] std::io::Error),
    /// What comes out is not what came out before.
    #[error("{0}")]
    Differs(String),
}

/// Something that is told all.
pub trait EventLog {
    /// Takes a record.
    ///
    /// # Errors
    /// [`EventLogError`] when it can not be kept; the session must stop then.
    fn take(&mut self, now: Time, record: &LoggedEvent<'_>) -> Result<(), EventLogError>;

    /// OperatorSetup everything to the system that is to outlive this program. Called before anything is sent.
    ///
    /// # Errors
    /// As [`EventLog::take`].
    fn flush(&mut self) -> Result<(), EventLogError>;
}

/// No tape.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoEventLog;

impl EventLog for NoEventLog {
    fn take(&mut self, _: Time, _: &LoggedEvent<'_>) -> Result<(), EventLogError> {
        Ok(())
    }

    fn flush(&mut self) -> Result<(), EventLogError> {
        Ok(())
    }
}

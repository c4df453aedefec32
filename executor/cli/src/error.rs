//! Errors of the command line and their exit codes.

use std::path::PathBuf;
use std::process::ExitCode;

use keepout_drives::profile::DriveProfileError;
use keepout_executor::session::log::{LogError, LogReadError};
use keepout_executor::session::port::PortError;
use keepout_executor::session::replay::ReplayError;
use keepout_executor::session::{EventLogError, PlaceError};
use keepout_executor::supervisor::StickError;
use keepout_planner::align::AlignmentError;
use keepout_planner::align::file::AlignmentFileError;
use keepout_planner::file::FileError;
use keepout_planner::machine::MachineError;
use keepout_planner::plan::PlanError;
use keepout_planner::plan_file::PlanFileError;
use keepout_planner::request::PlanRequestError;
use keepout_sim::conformance::{RecordError, RecordingError};
use keepout_sim::operator::OperatorError;
use keepout_sim::session::SimError;
#[cfg(unix)]
use keepout_sim::standalone::StandaloneError;
use thiserror::Error;

use crate::examine::ExamineError;
use crate::input::TerminalError;
use crate::input::device::DeviceError;

/// Why a command failed.
#[derive(Debug, Error)]
pub enum CliError {
    /// The drawing cannot be read.
    #[error(transparent)]
    Drawing(FileError),
    /// The drawing cannot be used, or no plan can be made of it.
    #[error("{path}: {source}", path = path.display())]
    PlanRequest {
        /// The file.
        path: PathBuf,
        /// Why.
        source: PlanRequestError,
    },
    /// A claim of a plan file does not hold.
    #[error("{path}: not certified: {source}", path = path.display())]
    NotCertified {
        /// The file.
        path: PathBuf,
        /// Which claim fails.
        source: PlanError,
    },
    /// A plan file cannot be read or written.
    #[error("{0}")]
    PlanFile(#[from] PlanFileError),
    /// A machine profile is not valid.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// A profile of feed drives is not valid.
    #[error(transparent)]
    Drives(#[from] DriveProfileError),
    /// The probe points do not determine how the workpiece lies.
    #[error(transparent)]
    Alignment(#[from] AlignmentError),
    /// An alignment file is not valid, or does not fit the plan.
    #[error(transparent)]
    AlignmentFile(#[from] AlignmentFileError),
    /// The operator cannot be set up.
    #[error(transparent)]
    Operator(#[from] OperatorError),
    /// No device to jog with.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A stick setting is out of range.
    #[error(transparent)]
    Stick(#[from] StickError),
    /// No terminal for the keyboard or the view.
    #[error(transparent)]
    Terminal(#[from] TerminalError),
    /// The job does not fit on the machine.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The port failed.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The log cannot be created.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The log could not be continued during the run.
    #[error(transparent)]
    EventLog(#[from] EventLogError),
    /// The simulated machine cannot run.
    #[cfg(unix)]
    #[error(transparent)]
    Simulate(#[from] StandaloneError),
    /// The panel cannot serve.
    #[cfg(unix)]
    #[error(transparent)]
    Panel(#[from] keepout_panel::server::ServeError),
    /// The controller could not be examined.
    #[error(transparent)]
    Examine(#[from] ExamineError),
    /// A conformance scenario could not be recorded.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A log cannot be read.
    #[error(transparent)]
    LogRead(#[from] LogReadError),
    /// The replay of a log differs from the log.
    #[error("{path}: {source}", path = path.display())]
    Replay {
        /// The log.
        path: PathBuf,
        /// The first difference.
        source: ReplayError,
    },
    /// The plan of a log was not found.
    #[error(
        "the log {} is of the plan with SHA-256 {hash} of {drawing}. \
         None of the {seen} plan files in {} has this hash. Give the plan with --plan.",
        log.display(),
        folder.display()
    )]
    NoPlan {
        /// The log.
        log: PathBuf,
        /// The plan's hash.
        hash: String,
        /// The drawing's name.
        drawing: String,
        /// The searched folder.
        folder: PathBuf,
        /// Number of plan files in it.
        seen: usize,
    },
    /// A fault stopped a touch-off.
    #[error("stopped: {0}")]
    Stopped(String),
    /// An argument is out of range.
    #[error("{0}")]
    Argument(String),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
}

impl From<SimError> for CliError {
    fn from(error: SimError) -> Self {
        match error {
            SimError::Place(error) => Self::Place(error),
            SimError::Port(error) => Self::Port(error),
            SimError::EventLog(error) => Self::EventLog(error),
        }
    }
}

impl CliError {
    /// The exit code of the error's class; see `keepout --help`.
    #[must_use]
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::AlignmentFile(AlignmentFileError::Turned { .. } | AlignmentFileError::Moved { .. }) => 4,
            Self::File(FileError::Write { .. })
            | Self::AlignmentFile(AlignmentFileError::File(FileError::Write { .. }))
            | Self::PlanFile(PlanFileError::File(FileError::Write { .. }))
            | Self::Log(_)
            | Self::EventLog(_) => 7,
            Self::Argument(_)
            | Self::Operator(_)
            | Self::Device(_)
            | Self::Stick(_)
            | Self::Terminal(_)
            | Self::Machine(_)
            | Self::Drives(_)
            | Self::Alignment(_)
            | Self::AlignmentFile(_)
            | Self::File(_) => 2,
            Self::Drawing(_)
            | Self::PlanRequest {
                source:
                    PlanRequestError::Drawing(_) | PlanRequestError::Select(_) | PlanRequestError::Travel { .. },
                ..
            } => 3,
            Self::PlanRequest { .. } | Self::Place(_) => 4,
            Self::LogRead(LogReadError::File(_))
            | Self::NoPlan { .. }
            | Self::Record(RecordError::Dialect { .. })
            | Self::Recording(RecordingError::File(_)) => 2,
            Self::Recording(_)
            | Self::PlanFile(_)
            | Self::NotCertified { .. }
            | Self::LogRead(_)
            | Self::Replay { .. } => 5,
            #[cfg(unix)]
            Self::Simulate(StandaloneError::Pty(_)) => 6,
            #[cfg(unix)]
            Self::Simulate(StandaloneError::File(_)) => 7,
            #[cfg(unix)]
            Self::Simulate(_) => 2,
            #[cfg(unix)]
            Self::Panel(_) => 6,
            Self::Port(_) | Self::Examine(_) | Self::Record(_) | Self::Stopped(_) => 6,
        })
    }
}

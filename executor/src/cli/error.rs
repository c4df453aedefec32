//! Errors of the command line and their exit codes.

use std::path::PathBuf;
use std::process::ExitCode;

use keepout_executor::link::port::PortError;
use keepout_executor::operator::OperatorError;
use keepout_executor::session::log::LogError;
use keepout_executor::session::{PlaceError, SimError, TapeError};
use keepout_planner::machine::MachineError;
use keepout_planner::order::OrderError;
use keepout_planner::plan::PlanError;
use keepout_planner::plan_file::PlanFileError;
use keepout_planner::registration::RegistrationError;
use keepout_planner::setup::SetupError;
use thiserror::Error;

/// Why a command failed.
#[derive(Debug, Error)]
pub enum CliError {
    /// The drawing can not be used, or no plan can be made of it.
    #[error("{path}: {source}", path = path.display())]
    Order {
        /// The file.
        path: PathBuf,
        /// Why.
        source: OrderError,
    },
    /// A plan file does not hold what it claims.
    #[error("{path}: not certified: {source}", path = path.display())]
    NotCertified {
        /// The file.
        path: PathBuf,
        /// Which claim fails.
        source: PlanError,
    },
    /// A plan file can not be read or written.
    #[error("{0}")]
    PlanFile(#[from] PlanFileError),
    /// A machine profile is refused.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// The touches do not say how the workpiece lies.
    #[error(transparent)]
    Registration(#[from] RegistrationError),
    /// A setup is refused.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// There is no operator.
    #[error(transparent)]
    Operator(#[from] OperatorError),
    /// The job does not lie on the machine.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The port.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The log.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The log could not be written on.
    #[error(transparent)]
    Tape(#[from] TapeError),
    /// An argument is out of range.
    #[error("{0}")]
    Argument(String),
    /// A file can not be written.
    #[error("can not write {}: {source}. Nothing was changed.", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

impl From<SimError> for CliError {
    fn from(error: SimError) -> Self {
        match error {
            SimError::Place(error) => Self::Place(error),
            SimError::Port(error) => Self::Port(error),
            SimError::Tape(error) => Self::Tape(error),
        }
    }
}

impl CliError {
    /// The exit code of the error's class; see `keepout --help`.
    #[must_use]
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Setup(SetupError::Turned { .. } | SetupError::Moved { .. }) => 4,
            Self::Setup(SetupError::Write { .. }) => 7,
            Self::Argument(_)
            | Self::Operator(_)
            | Self::Machine(_)
            | Self::Registration(_)
            | Self::Setup(_) => 2,
            Self::Order {
                source: OrderError::Drawing(_) | OrderError::Select(_) | OrderError::Stroke { .. },
                ..
            } => 3,
            Self::Order { .. } | Self::Place(_) => 4,
            Self::PlanFile(PlanFileError::Write { .. })
            | Self::Write { .. }
            | Self::Log(_)
            | Self::Tape(_) => 7,
            Self::PlanFile(_) | Self::NotCertified { .. } => 5,
            Self::Port(_) => 6,
        })
    }
}

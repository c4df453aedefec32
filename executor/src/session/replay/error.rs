//! The errors of a replay.

use keepout_planner::job::ProgressError;
use thiserror::Error;

use super::MotionTextFault;
use crate::dialect::DialectNameError;
use crate::session::log::LogReadError;

/// An error that a replay finds in a log.
#[derive(Debug, Error)]
pub enum ReplayError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogReadError),
    /// The log belongs to another plan.
    #[error(
        "the log is of another plan: it names {logged}, this one is {given}. Give the plan that was run."
    )]
    OtherPlan {
        /// The plan's hash, as logged.
        logged: String,
        /// The hash of the given plan.
        given: String,
    },
    /// The logged progress of earlier sessions does not fit the plan.
    #[error("line 1 of the log: {0}")]
    Progress(#[from] ProgressError),
    /// The plan cannot be encoded for its hash.
    #[error(transparent)]
    Plan(#[from] keepout_planner::plan_file::PlanFileError),
    /// The dialect is not known.
    #[error(transparent)]
    DialectName(#[from] DialectNameError),
    /// The dialect's file has changed.
    #[error(
        "the log was written with another text of {file}: it names {logged}, this one is {given}. \
         Put that file back as it was when the part was cut."
    )]
    OtherDialect {
        /// The file.
        file: String,
        /// The hash of its text, as logged.
        logged: String,
        /// The hash of its text now.
        given: String,
    },
    /// An output differs from the logged output.
    #[error(
        "line {line} of the log, {seconds:.3} s: logged {logged}, played again {played}. \
         The log was changed, or another version of this program wrote it."
    )]
    Differs {
        /// The line of the log, from 1.
        line: usize,
        /// Its time, s.
        seconds: f64,
        /// The logged output.
        logged: String,
        /// The output of the replay.
        played: String,
    },
    /// The plan has heights, and the log is of a session with two axes.
    #[error(
        "line 1 of the log: it states no third axis, and the plan has heights. The log was changed, or another \
         version of this program wrote it."
    )]
    NoThirdAxis,
    /// A text that was sent does not fit its certificate.
    #[error("line {line} of the log, {seconds:.3} s: {fault}")]
    Text {
        /// The line of the log, from 1.
        line: usize,
        /// Its time, s.
        seconds: f64,
        /// The fault.
        fault: MotionTextFault,
    },
    /// A certificate does not hold.
    #[error("line {line} of the log, {seconds:.3} s: the logged certificate does not hold: {reason}")]
    NotCertified {
        /// The line of the log, from 1.
        line: usize,
        /// Its time, s.
        seconds: f64,
        /// The reason.
        reason: String,
    },
}

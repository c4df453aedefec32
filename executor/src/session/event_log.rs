//! What a session writes into its event log: everything that goes into the engine, and everything that comes out.

use std::borrow::Cow;

use arrayvec::ArrayVec;
use keepout_guard::{Certified, Guard, Motion, Time};
use keepout_kernel::{Curve, Point};
use keepout_planner::job::{ContourJob, JobError};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::characters;
use crate::supervisor::{OperatorCommand, OperatorInput, Phase};

/// An event of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LoggedEvent<'a> {
    /// Bytes came from the controller.
    #[serde(with = "characters")]
    Received(Cow<'a, [u8]>),
    /// The jog input.
    Input(OperatorInput),
    /// An operator command.
    Command(OperatorCommand),
    /// Time passed.
    Tick,
    /// The planner answered the request for a contouring job.
    Job(Cow<'a, Result<ContourJob, JobError>>),
    /// The port failed.
    PortLost(Cow<'a, str>),
    /// The port is back.
    PortFound,
    /// The session is to end.
    Halt,
    /// The guard certified the motion that follows.
    Certificate(Certificate),
    /// Bytes go to the controller.
    #[serde(with = "characters")]
    Sent(Cow<'a, [u8]>),
    /// The supervisor entered another state.
    Phase {
        /// The state.
        phase: Phase,
        /// The fault behind it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        fault: Option<String>,
    },
}

impl LoggedEvent<'_> {
    /// Whether it went into the engine, and did not come out of it.
    #[must_use]
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Sent(_) | Self::Certificate(_) | Self::Phase { .. })
    }

    /// The event with its own copy of everything.
    #[must_use]
    pub fn into_owned(self) -> LoggedEvent<'static> {
        match self {
            Self::Received(bytes) => LoggedEvent::Received(Cow::Owned(bytes.into_owned())),
            Self::Input(input) => LoggedEvent::Input(input),
            Self::Command(command) => LoggedEvent::Command(command),
            Self::Tick => LoggedEvent::Tick,
            Self::Job(job) => LoggedEvent::Job(Cow::Owned(job.into_owned())),
            Self::PortLost(reason) => LoggedEvent::PortLost(Cow::Owned(reason.into_owned())),
            Self::PortFound => LoggedEvent::PortFound,
            Self::Halt => LoggedEvent::Halt,
            Self::Certificate(certificate) => LoggedEvent::Certificate(certificate),
            Self::Sent(bytes) => LoggedEvent::Sent(Cow::Owned(bytes.into_owned())),
            Self::Phase { phase, fault } => LoggedEvent::Phase { phase, fault },
        }
    }
}

/// Most points of an in-flight set.
pub const SET_MAX: usize = 16;

/// What the guard certified a motion with, lattice units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Certificate {
    /// A jog.
    Jog {
        /// Its target.
        #[serde(with = "keepout_planner::stored")]
        to: Point,
        /// Its feed, mm/min.
        feed_mm_min: u32,
        /// The in-flight set, which holds the target.
        #[serde(with = "in_flight_set")]
        set: ArrayVec<Point, SET_MAX>,
    },
    /// A motion of a contour.
    Contour {
        /// The motion.
        #[serde(with = "keepout_planner::stored")]
        curve: Curve,
        /// Its feed, mm/min.
        feed_mm_min: u32,
    },
}

impl Certificate {
    /// The certificate of a motion that the guard has just handed out.
    #[must_use]
    pub fn of(certified: &Certified, guard: &Guard) -> Self {
        match *certified.motion() {
            Motion::Jog { to, feed_mm_min } => {
                Self::Jog { to, feed_mm_min, set: guard.in_flight().take(SET_MAX).collect() }
            }
            Motion::Contour { curve, feed_mm_min } => Self::Contour { curve, feed_mm_min },
        }
    }
}

/// The points of an in-flight set as a list.
mod in_flight_set {
    use arrayvec::ArrayVec;
    use keepout_kernel::Point;
    use keepout_planner::stored::many;
    use serde::de::Error as _;
    use serde::{Deserializer, Serializer};

    use super::SET_MAX;

    pub fn serialize<S: Serializer>(set: &[Point], serializer: S) -> Result<S::Ok, S::Error> {
        many::serialize(set, serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<ArrayVec<Point, SET_MAX>, D::Error> {
        let points = many::deserialize::<Point, D>(deserializer)?;
        ArrayVec::try_from(points.as_slice()).map_err(D::Error::custom)
    }
}

/// Why an event log takes nothing more.
#[derive(Debug, Error)]
pub enum EventLogError {
    /// It can not be written.
    #[error("the log could not be written on: {0}. The machine was stopped.")]
    Write(#[from] std::io::Error),
    /// What comes out is not what came out before.
    #[error("{0}")]
    Differs(String),
}

/// Something that takes every event.
pub trait EventLog {
    /// Takes an event.
    ///
    /// # Errors
    /// [`EventLogError`] when it can not be kept; the session must stop then.
    fn take(&mut self, now: Time, event: &LoggedEvent<'_>) -> Result<(), EventLogError>;

    /// Hands everything to the system that is to outlive this program. The engine calls it before anything is sent.
    ///
    /// # Errors
    /// As [`EventLog::take`].
    fn flush(&mut self) -> Result<(), EventLogError>;
}

/// No event log.
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

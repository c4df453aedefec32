//! The event log of a session: every input and every output of the engine.

use std::borrow::Cow;

use arrayvec::ArrayVec;
use keepout_guard::{Certified, Guard, Motion, Time};
use keepout_kernel::{Curve, Height, Place, Point};
use keepout_planner::job::{ContourJob, JobError};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::characters;
use crate::supervisor::{OperatorCommand, OperatorInput, Phase};

/// An event of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum LoggedEvent<'a> {
    /// The controller sent bytes.
    #[serde(with = "characters")]
    Received(Cow<'a, [u8]>),
    /// The operator's jog input.
    Input(OperatorInput),
    /// An operator command.
    Command(OperatorCommand),
    /// The supervisor's timer was due.
    Tick,
    /// The planner answered the request for a contouring job.
    Job(Cow<'a, Result<ContourJob, JobError>>),
    /// The port failed.
    PortLost(Cow<'a, str>),
    /// The port is back.
    PortFound,
    /// The session began its end, because its program asked for it.
    Halt,
    /// The session began its end, because its time is over.
    TimeLimit,
    /// The outcome of the job, in words. It is the last event of a session.
    Outcome(Cow<'a, str>),
    /// The guard certified the motion that follows.
    Certificate(Certificate),
    /// The engine sent bytes to the controller.
    #[serde(with = "characters")]
    Sent(Cow<'a, [u8]>),
    /// The supervisor entered another phase.
    Phase {
        /// The phase.
        phase: Phase,
        /// The fault that caused it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        fault: Option<String>,
    },
}

impl LoggedEvent<'_> {
    /// Whether the event is an input of the engine. The others are outputs.
    #[must_use]
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Sent(_) | Self::Certificate(_) | Self::Phase { .. } | Self::Outcome(_))
    }

    /// The event with owned data.
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
            Self::TimeLimit => LoggedEvent::TimeLimit,
            Self::Outcome(outcome) => LoggedEvent::Outcome(Cow::Owned(outcome.into_owned())),
            Self::Certificate(certificate) => LoggedEvent::Certificate(certificate),
            Self::Sent(bytes) => LoggedEvent::Sent(Cow::Owned(bytes.into_owned())),
            Self::Phase { phase, fault } => LoggedEvent::Phase { phase, fault },
        }
    }
}

/// Most points of an in-flight set.
pub const SET_MAX: usize = 16;

/// The facts by which the guard certified a motion, in lattice units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Certificate {
    /// A jog.
    Jog {
        /// Its target.
        #[serde(with = "keepout_planner::stored")]
        to: Point,
        /// The height of its target.
        #[serde(
            with = "keepout_planner::stored",
            default = "keepout_planner::stored::height_zero",
            skip_serializing_if = "keepout_planner::stored::is_height_zero"
        )]
        height: Height,
        /// Its feed, mm/min.
        feed_mm_min: u32,
        /// The in-flight set. It contains the target.
        #[serde(with = "in_flight_set")]
        set: ArrayVec<Point, SET_MAX>,
        /// The lowest height of that set.
        #[serde(
            with = "keepout_planner::stored",
            default = "keepout_planner::stored::height_zero",
            skip_serializing_if = "keepout_planner::stored::is_height_zero"
        )]
        lowest: Height,
    },
    /// A motion of a contour.
    Contour {
        /// The motion.
        #[serde(with = "keepout_planner::stored")]
        curve: Curve,
        /// The height at its start.
        #[serde(
            with = "keepout_planner::stored",
            default = "keepout_planner::stored::height_zero",
            skip_serializing_if = "keepout_planner::stored::is_height_zero"
        )]
        from: Height,
        /// The height at its end.
        #[serde(
            with = "keepout_planner::stored",
            default = "keepout_planner::stored::height_zero",
            skip_serializing_if = "keepout_planner::stored::is_height_zero"
        )]
        to: Height,
        /// Its feed, mm/min.
        feed_mm_min: u32,
    },
}

impl Certificate {
    /// The certificate of a motion. Call it before the guard admits the next one: it reads the in-flight set.
    #[must_use]
    pub fn of(certified: &Certified, guard: &Guard) -> Self {
        match *certified.motion() {
            Motion::Jog { to, feed_mm_min } => {
                let set = guard.in_flight().take(SET_MAX).collect();
                let lowest = guard.lowest().unwrap_or(to.height);
                Self::Jog { to: to.point, height: to.height, feed_mm_min, set, lowest }
            }
            Motion::Contour { curve, heights: [from, to], feed_mm_min } => {
                Self::Contour { curve, from, to, feed_mm_min }
            }
        }
    }

    /// The motion.
    #[must_use]
    pub fn motion(&self) -> Motion {
        match *self {
            Self::Jog { to, height, feed_mm_min, .. } => {
                Motion::Jog { to: to.at_height(height), feed_mm_min }
            }
            Self::Contour { curve, from, to, feed_mm_min } => {
                Motion::Contour { curve, heights: [from, to], feed_mm_min }
            }
        }
    }

    /// The end of the motion.
    #[must_use]
    pub fn target(&self) -> Place {
        match *self {
            Self::Jog { to, height, .. } => to.at_height(height),
            Self::Contour { curve, to, .. } => curve.to().at_height(to),
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

/// An error that ends an event log.
#[derive(Debug, Error)]
pub enum EventLogError {
    /// The log file cannot be written.
    #[error("the log could not be written on: {0}. The machine was stopped.")]
    Write(#[from] std::io::Error),
    /// An output differs from the logged output.
    #[error("{0}")]
    Differs(String),
}

/// A receiver of every event of a session.
pub trait EventLog {
    /// Takes an event.
    ///
    /// # Errors
    /// [`EventLogError`] if the log cannot keep the event. The session must then stop.
    fn take(&mut self, now: Time, event: &LoggedEvent<'_>) -> Result<(), EventLogError>;

    /// Hands all events to the operating system, so that they outlive this program. The session calls it
    /// before it sends bytes.
    ///
    /// # Errors
    /// As [`EventLog::take`].
    fn flush(&mut self) -> Result<(), EventLogError>;
}

/// An event log that drops every event.
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

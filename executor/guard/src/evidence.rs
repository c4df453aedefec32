//! TRUSTED. Evidence: a status report, and what is known of the query that it answers.
//!
//! Implements SR-08.

use keepout_kernel::Place;

use crate::{Guard, Time};

/// The contents of a status report that the guard uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionFeedback {
    /// The reported position.
    pub position: Place,
    /// Whether the controller reports that it is at rest and waits for commands.
    pub in_position: bool,
    /// Number of motions in the controller's queue. `None` when the report does not state it.
    pub queued: Option<usize>,
    /// Whether the controller has received input that it has not acted on.
    pub waiting: bool,
}

impl PositionFeedback {
    /// Whether the controller is at rest, with an empty queue and no waiting input. A report without a queue
    /// length counts as an empty queue.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.in_position && !self.waiting && self.queued.is_none_or(|queued| queued == 0)
    }
}

/// Number of lines sent and acknowledged when a query left, and the time when it left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QueryStamp {
    pub(crate) sent: u64,
    pub(crate) acknowledged: u64,
    pub(crate) at: Time,
}

impl Guard {
    /// Whether the query of this stamp left before the newest acknowledged line. Its answer can no longer
    /// arrive.
    #[must_use]
    pub fn is_outdated(&self, stamp: &QueryStamp) -> bool {
        stamp.sent < self.acknowledged
    }

    /// The stamp of a query that leaves now.
    #[must_use]
    pub fn stamp(&self, now: Time) -> QueryStamp {
        QueryStamp { sent: self.sent, acknowledged: self.acknowledged, at: now }
    }
}

/// A report as evidence: what it states, and what is known of the query behind it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence<'a> {
    pub(crate) feedback: &'a PositionFeedback,
    /// Every line ever sent was acknowledged before the query left.
    pub(crate) all_acknowledged: bool,
    /// Number of lines acknowledged so far.
    pub(crate) acknowledged: u64,
    /// Time when the query left.
    pub(crate) asked: Time,
    /// Time of the report.
    pub(crate) now: Time,
}

impl Evidence<'_> {
    /// Whether the controller is at rest with nothing left to do, of all lines ever sent.
    pub(crate) fn rests(&self) -> bool {
        self.feedback.rests() && self.all_acknowledged
    }
}

//! What goes over the line between the host and the model of a controller.

use crate::properties::Xy;

/// What is on the way to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sent {
    /// A motion.
    Line(Xy),
    /// A status query.
    Query,
    /// Stop, and forget what is planned.
    Cancel,
}

/// What is on the way back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Answer {
    /// The oldest line is accepted.
    Accepted,
    /// The oldest line is refused.
    Refused,
    /// A status report.
    Report(Report),
}

/// A status report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Report {
    /// Where the tool is.
    pub place: Xy,
    /// Nothing moves.
    pub in_position: bool,
    /// Blocks in the planner.
    pub queued: usize,
    /// Something is in the receive buffer.
    pub waiting: bool,
    /// Not the only copy: the next one follows at once.
    pub doubled: bool,
}

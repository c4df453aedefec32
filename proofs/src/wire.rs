//! Messages between the host and the controller model.

use crate::properties::Xyz;

/// A message to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sent {
    /// A motion.
    Line(Xyz),
    /// A status query.
    Query,
    /// Stop, and discard planned motions.
    Cancel,
}

/// A message to the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HostMessage {
    /// The controller accepted the oldest line.
    Accepted,
    /// The controller rejected the oldest line.
    Refused,
    /// A status report.
    Report(StatusReport),
}

/// A status report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StatusReport {
    /// Position of the tool.
    pub place: Xyz,
    /// The machine is at rest.
    pub in_position: bool,
    /// Blocks in the planner.
    pub queued: usize,
    /// The receive buffer holds a line.
    pub waiting: bool,
    /// A copy of this report follows at once.
    pub doubled: bool,
}

//! What the supervisor tells about its session.

use std::time::Duration;

use keepout_guard::{FeedOverride, Guard};
use keepout_kernel::Place;
use keepout_planner::job::LoopNumber;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::mm;

use super::event::Mode;
use super::state::State;
use super::{Counts, Fault, Notice, PreparedPlan, Supervisor};

impl Supervisor {
    /// The fault that stopped the machine.
    #[must_use]
    pub fn fault(&self) -> Option<&Fault> {
        if let State::Faulted { fault, .. } = &self.state { Some(fault) } else { None }
    }

    /// The fault from which the session had not recovered at its end.
    #[must_use]
    pub fn unrecovered(&self) -> Option<&Fault> {
        self.unrecovered.as_ref()
    }

    /// The plan and its part.
    #[must_use]
    pub fn work(&self) -> &PreparedPlan {
        &self.work
    }

    /// The plan.
    #[must_use]
    pub fn plan(&self) -> &CertifiedPlan {
        &self.work.plan
    }

    /// The guard.
    #[must_use]
    pub fn guard(&self) -> &Guard {
        &self.guard
    }

    /// The last reported position of the tool.
    #[must_use]
    pub fn position(&self) -> Option<Place> {
        self.position
    }

    /// The last reported height of the tool's tip, mm. `None` in a session with two axes.
    #[must_use]
    pub fn height_mm(&self) -> Option<f64> {
        self.position.filter(|_| self.climbs()).map(|place| mm(place.height.units()))
    }

    /// Whether the last report showed the machine at rest.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        matches!(self.mode, Some(Mode::Idle | Mode::Held))
    }

    /// The feed override of contours.
    #[must_use]
    pub fn feed_override(&self) -> FeedOverride {
        self.operation.feed
    }

    /// Number of finishing loops that earlier sessions had finished.
    #[must_use]
    pub fn finished_before(&self) -> usize {
        self.options.progress.finished.len()
    }

    /// Finishing loops contoured so far.
    #[must_use]
    pub fn finished(&self) -> &[LoopNumber] {
        &self.contours.progress.finished
    }

    /// Finishing loops of the last contouring job that no link move reaches.
    #[must_use]
    pub fn unreached(&self) -> &[LoopNumber] {
        &self.contours.unreached
    }

    /// Whether the cycle is armed: a contact starts the contour.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.operation.armed
    }

    /// Whether a contour was interrupted and is not finished.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.contours.interrupted.is_some()
    }

    /// Notices for the operator.
    #[must_use]
    pub fn notices(&self) -> &[Notice] {
        &self.notices
    }

    /// Counters.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Recent time from a query to its answer.
    #[must_use]
    pub fn round_trip(&self) -> Duration {
        self.polling.round_trip
    }
}

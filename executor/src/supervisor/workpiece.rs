//! What is worked on: the plan, its part prepared for steering, and what the guard is to keep to for it.

use std::sync::Arc;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Length, ProhibitedRegion};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::length_up_from_mm;

use super::guard::Rules;
use super::manual::standing_off;
use crate::link::Abilities;

/// A certified plan, and its part prepared for steering. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Workpiece {
    /// The plan.
    pub plan: Arc<CertifiedPlan>,
    pub(super) part: Arc<ProhibitedRegion>,
    pub(super) coarse: Arc<ProhibitedRegion>,
}

/// Runs of edges are under one chord while the tool is steered by hand, as many short edges would make decisions slow: as far
/// as they keep within this share of the allowance of it, and within 5 µm.
const COARSE_SHARE: i64 = 40;
const COARSE_MAX: i64 = 500;

impl Workpiece {
    /// Prepares the part of a certified plan.
    #[must_use]
    pub fn new(plan: CertifiedPlan) -> Self {
        let tolerance = (i64::from(plan.plan.allowance.units()) / COARSE_SHARE).min(COARSE_MAX);
        let tolerance = Length::from_units(tolerance).unwrap_or(Length::ZERO);
        let mut coarse = plan.part.coarsened(tolerance).unwrap_or_else(|_| plan.part.clone());
        // Cells only make answers at the roughing threshold and where ways stand off it
        // faster; a part too large for them is asked by its index.
        let _ = coarse.prepare(plan.roughing);
        let _ = coarse.prepare(standing_off(plan.roughing));
        let part = Arc::new(plan.part.clone());
        Self { plan: Arc::new(plan), part, coarse: Arc::new(coarse) }
    }

    /// The part as steering by hand sees it: up to 10 µm larger.
    #[must_use]
    pub fn coarse(&self) -> &ProhibitedRegion {
        &self.coarse
    }

    /// The part.
    #[must_use]
    pub fn part(&self) -> &ProhibitedRegion {
        &self.part
    }
}

/// What the guard keeps to.
pub(super) fn rules(plan: &CertifiedPlan, stroke: Window, abilities: Abilities) -> Rules {
    let machine = &plan.plan.machine;
    // Two steps and a little: the controller may have up to as few steps per mm as the profile says.
    let shortest = length_up_from_mm(2.2 / machine.steps_per_mm).unwrap_or(Length::small(u8::MAX));
    Rules {
        stroke,
        manual: plan.roughing,
        finishing: finishing_as_sent(plan, abilities),
        resolution: plan.plan.budget.resolution().unwrap_or(Length::small(100)),
        shortest,
        shape: abilities.shape,
        contours: abilities.contours,
        checked: abilities.checked,
    }
}

/// The threshold of contours as they are sent. A controller that turns arcs into chords leaves them by a term of the margin;
/// one that is sent chords does not, and the chords are asked without that term.
fn finishing_as_sent(plan: &CertifiedPlan, abilities: Abilities) -> Length {
    let term = plan.plan.budget.terms.iter().find(|term| term.name == "controller arcs");
    let units = term.filter(|_| !abilities.arcs).and_then(|term| length_up_from_mm(term.mm).ok());
    let less = units.map_or(0, |term| i64::from(term.units()) - 1).max(0);
    Length::from_units(i64::from(plan.finishing.units()) - less).unwrap_or(plan.finishing)
}

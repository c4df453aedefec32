//! The loaded plan: its part prepared for jogging, and the rules of the guard for it.
//!
//! Implements SR-16.

use std::sync::Arc;

use keepout_guard::{HeightRules, Rules};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Height, Length, Levels};
use keepout_planner::margin::TermKind;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::length_up_from_mm;

use super::jog::standing_off;
use crate::supervisor::Abilities;

/// A certified plan with its part prepared for jogging. Cheap to clone.
#[derive(Clone, Debug)]
pub struct PreparedPlan {
    /// The plan.
    pub plan: Arc<CertifiedPlan>,
    pub(super) levels: Arc<Levels>,
    pub(super) simplified: Arc<Levels>,
}

/// Divisor of the stock to leave that gives the tolerance of the simplified outline. One chord replaces a run
/// of edges within this tolerance, because many short edges would make jogging slow.
const TOLERANCE_SHARE: i64 = 40;
/// Greatest tolerance of the simplified outline, lattice units (5 µm).
const TOLERANCE_MAX: i64 = 500;

impl PreparedPlan {
    /// Prepares the part of a certified plan.
    #[must_use]
    pub fn new(plan: CertifiedPlan) -> Self {
        let tolerance = (i64::from(plan.plan.stock_to_leave.units()) / TOLERANCE_SHARE).min(TOLERANCE_MAX);
        let tolerance = Length::from_units(tolerance).unwrap_or(Length::ZERO);
        let levels = Arc::clone(&plan.levels);
        let thresholds = [plan.roughing, standing_off(plan.roughing)];
        let simplified = levels.simplified(tolerance);
        let simplified = simplified.as_ref().unwrap_or(&levels).prepared(&thresholds);
        // Names and places of contours are worked out once: not by the first crossing, while the tool moves.
        let _ = plan.contours();
        Self { plan: Arc::new(plan), levels, simplified: Arc::new(simplified) }
    }

    /// The simplified outlines for jogs: up to 10 µm larger than the part.
    #[must_use]
    pub fn simplified(&self) -> &Arc<Levels> {
        &self.simplified
    }

    /// The part.
    #[must_use]
    pub fn levels(&self) -> &Arc<Levels> {
        &self.levels
    }
}

/// The rules of the guard for this plan.
pub(super) fn rules(
    plan: &CertifiedPlan,
    (travel, heights): (Window, Option<[Height; 2]>),
    abilities: Abilities,
) -> Rules {
    let machine = &plan.plan.machine;
    let heights = height_rules(plan, heights);
    // Two steps and a reserve. The controller has at least as many steps per mm as the profile states.
    let shortest = length_up_from_mm(2.2 / machine.steps_per_mm).unwrap_or(Length::small(u8::MAX));
    Rules {
        travel,
        jogging_clearance: plan.roughing,
        finishing_clearance: finishing_as_sent(plan, abilities),
        resolution: plan.plan.budget.resolution().unwrap_or(Length::small(100)),
        shortest,
        interpolation: abilities.interpolation,
        on_cancel: abilities.on_cancel,
        contours: abilities.contours,
        checked: abilities.checked,
        heights,
    }
}

/// The rules of the third axis, whose travel runs from one height to the other. A plan or a session for two axes
/// keeps the tool at height zero.
fn height_rules(plan: &CertifiedPlan, travel: Option<[Height; 2]>) -> HeightRules {
    let machine = plan.plan.machine.z.as_ref();
    let (Some(relief), Some(z), Some([lowest, highest])) = (&plan.plan.relief, machine, travel) else {
        return HeightRules::TWO_AXES;
    };
    HeightRules {
        lowest,
        highest,
        margin: plan.height_margin,
        resolution: relief.budget.resolution().unwrap_or(plan.height_margin),
        shortest: length_up_from_mm(2.2 / z.steps_per_mm).unwrap_or(Length::small(u8::MAX)),
    }
}

/// The finishing clearance of contours as they are sent. A controller that turns arcs into chords leaves the
/// arcs, and the margin has a term for this. A controller that gets chords does not, so the term is left out.
fn finishing_as_sent(plan: &CertifiedPlan, abilities: Abilities) -> Length {
    let term = plan.plan.budget.terms.iter().find(|term| term.kind == TermKind::ControllerArcs);
    let units = term.filter(|_| !abilities.arcs).and_then(|term| length_up_from_mm(term.mm).ok());
    let less = units.map_or(0, |term| i64::from(term.units()) - 1).max(0);
    Length::from_units(i64::from(plan.finishing.units()) - less).unwrap_or(plan.finishing)
}

#[cfg(test)]
mod tests {
    use keepout_kernel::Point;
    use keepout_planner::machine::MachineProfile;
    use keepout_planner::plan::PlanParameters;
    use keepout_planner::request::PlanRequest;
    use keepout_planner::units::mm;

    use super::super::transitions::ABILITIES;
    use super::*;

    // Evidence for SR-16.
    /// The jogging clearance is R + A + M, and the finishing clearance is R + M. For a controller that gets
    /// chords, the finishing clearance leaves out the term for its arcs. Jogs keep at least twice the
    /// resolution beyond M.
    #[test]
    fn thresholds_contain_the_radius_and_each_term_of_the_margin() {
        let bytes = include_bytes!("../../cli/drawings/bracket.dxf");
        let mut random = fastrand::Rng::with_seed(8);
        for case in 0..24 {
            let machine = MachineProfile {
                steps_per_mm: [80.0, 400.0, 3200.0][case % 3],
                report_digit_mm: [0.001, 0.01][case % 2],
                repeatability_mm: random.f64() * 0.05,
                contour_error_mm: random.f64() * 0.05,
                ..MachineProfile::simulated()
            };
            let job = PlanParameters {
                tool_diameter_mm: 3.0 + random.f64() * 3.0,
                stock_to_leave_mm: [0.0, 0.01, 0.3][case % 3],
                ..PlanParameters::default()
            };
            let order = PlanRequest { job, ..PlanRequest::default() };
            let plan = order.plan("bracket", bytes, &machine, &mut |_| {}).unwrap();
            let travel = Window::of(Point::ORIGIN);
            let [arcs, chords] =
                [true, false].map(|arcs| rules(&plan, (travel, None), Abilities { arcs, ..ABILITIES }));
            let radius = order.job.tool_diameter_mm / 2.0;
            let terms = &plan.plan.budget.terms;
            let sum: f64 = terms.iter().map(|term| term.mm).sum();
            let of = |counts: fn(TermKind) -> bool| -> f64 {
                terms.iter().filter(|term| counts(term.kind)).map(|term| term.mm).sum()
            };
            let of_arcs = of(|kind| kind == TermKind::ControllerArcs);
            assert!(terms.iter().all(|term| term.mm > 0.0) && of_arcs > 0.0);
            let close = |length: Length, least: f64| (0.0..1e-4).contains(&(mm(length.units()) - least));
            assert!(close(arcs.finishing_clearance, radius + sum), "{case}: {:?}", arcs.finishing_clearance);
            assert!(
                close(chords.finishing_clearance, radius + sum - of_arcs),
                "{case}: {:?}",
                chords.finishing_clearance
            );
            let kept = order.job.stock_to_leave_mm.max(2.0 * mm(arcs.resolution.units()));
            for rules in [arcs, chords] {
                assert!(
                    close(rules.jogging_clearance, radius + sum + kept),
                    "{case}: {:?} {kept}",
                    rules.jogging_clearance
                );
                assert!(close(rules.resolution, of(TermKind::is_resolution)), "{case}");
            }
        }
    }
}

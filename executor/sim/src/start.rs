//! Where a simulated session may start.

use keepout_executor::session::{PlaceError, TablePlacement};
use keepout_kernel::{Height, Point, Vector};
use keepout_planner::Mm2;
use keepout_planner::job::contour_job;
use keepout_planner::plan::CertifiedPlan;

pub(crate) fn check_start(plan: &CertifiedPlan, place: &TablePlacement, at: Point) -> Result<(), PlaceError> {
    if !place.travel.holds(at) {
        return Err(PlaceError::Start { at, reason: "it is beyond the machine's travel".into() });
    }
    // A tool with a third axis starts at its end of travel, above the part.
    let part = if plan.plan.relief.is_some() { plan.region(Height::HIGHEST) } else { &plan.part };
    let free = part.free_point(at, plan.roughing);
    free.map_err(|blocked| PlaceError::Start { at, reason: blocked.to_string() })?;
    Ok(())
}

/// Whether the tool can stand at the home position, and can reach a contour to finish from there.
pub(crate) fn comes_from_home(plan: &CertifiedPlan, place: &TablePlacement, home: Mm2) -> bool {
    let back = Vector { dx: -place.offset.dx, dy: -place.offset.dy };
    let Ok(point) = keepout_planner::units::point_from_mm(home).and_then(|point| point.translated(back))
    else {
        return false;
    };
    plan.part.free_point(point, plan.roughing).is_ok()
        && contour_job(plan, point.in_plane(), place.travel).is_ok()
}

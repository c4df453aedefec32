//! Jobs of a plan, for its picture.

use keepout_kernel::Point;

use super::cutter::{STAND_OFF_MM, TRIES};
use super::track::Track;
use super::{ContourJob, contour_job};
use crate::finish::FinishingLoop;
use crate::plan::CertifiedPlan;
use crate::units::mm;

/// Largest numbers of loops and of edges for which a preview is made.
const PREVIEW_MAX: (usize, usize) = (300, 20_000);

/// Jobs from one contact start in each free space; empty for a plan that is too large to draw them.
#[must_use]
pub fn preview(plan: &CertifiedPlan) -> Vec<ContourJob> {
    if plan.plan.loop_count() > PREVIEW_MAX.0 || plan.part.edges().len() > PREVIEW_MAX.1 {
        return Vec::new();
    }
    let field = plan.part.region().bounds().grown(plan.roughing).grown(plan.roughing);
    if let Some(relief) = &plan.plan.relief {
        // From above, one job reaches every contour.
        let (x, y, ..) = field.corners();
        let corner = Point::from_units(x.into(), y.into());
        return corner
            .ok()
            .and_then(|at| contour_job(plan, at.at_height(relief.safe), field).ok())
            .into_iter()
            .collect();
    }
    let finish = plan.plan.finish();
    let mut components: Vec<usize> = finish.loops.iter().map(|each| each.component).collect();
    components.sort_unstable();
    components.dedup();
    let spaces = finish.free_spaces();
    let starts = components.into_iter().filter_map(|component| {
        let loops = finish.loops.iter().filter(|each| each.component == component);
        let beside = |each: &FinishingLoop| {
            let track = Track::of(each, plan.plan.cut)?;
            (0..TRIES).find_map(|k| {
                let stand_off = mm(plan.plan.stock_to_leave.units()) + STAND_OFF_MM;
                let place =
                    track.at(track.length_mm() * f64::from(k) / f64::from(TRIES)).aside(0.0, stand_off)?;
                let clear = plan.part.free_point(place, plan.roughing).is_ok();
                (clear && spaces.component_of(place) == component).then_some(place)
            })
        };
        loops.into_iter().find_map(beside)
    });
    starts.filter_map(|start| contour_job(plan, start.in_plane(), field).ok()).collect()
}

//! Resuming an interrupted path from the tool's place on it.

use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, Point, Segment};

use super::progress::{SNAP_MM, nearest_share};
use super::track::{between, length_mm};
use crate::plan::CertifiedPlan;
use crate::units::{along_mm, dividing_point, point_from_mm};

/// Curves that are at most this much farther from the tool than the nearest curve count as equally near,
/// mm.
const ALIKE_MM: f64 = 0.005;
/// Distances ahead of the tool at which it returns onto an arc, mm. The first certified one is used.
const AHEAD_MM: [f64; 4] = [0.05, 0.02, 0.01, 0.005];

/// The remaining contour of an interrupted path, for a tool at rest on the path. `path` holds the motions
/// that may not be completed. The executor sent the first `begun` of them, and `at` is the reported
/// position.
///
/// The result begins at `at`. A report is rounded, so `at` may lie inside the finishing clearance. The
/// result then begins at the nearest point of the path. Every motion of the result is certified at the
/// finishing clearance. The result is empty when the path is completed.
///
/// `None` when `at` is farther than [`SNAP_MM`] from the sent motions, for example because something
/// moved the tool along the part. `None` too when no certified motion leads on. Where the path passes
/// near itself, the earlier motion counts.
#[must_use]
pub fn resume_in_place(plan: &CertifiedPlan, path: &[Curve], begun: usize, at: Point) -> Option<Vec<Curve>> {
    let near: Vec<(f64, f64)> = path.iter().take(begun).map(|curve| nearest_share(curve, at)).collect();
    let least = near.iter().map(|(_, away)| *away).fold(f64::INFINITY, f64::min);
    let index = near.iter().position(|(_, away)| *away <= (least + ALIKE_MM).min(SNAP_MM))?;
    let (curve, share) = (path.get(index)?, near[index].0);
    let foot = point_from_mm(along_mm(curve, share).0).ok()?;
    let starts = [at, foot].into_iter().flat_map(|from| AHEAD_MM.map(|ahead| (from, ahead)));
    starts
        .filter_map(|(from, ahead)| {
            let mut remaining = onto(curve, share, from, ahead)?;
            remaining.extend(&path[index + 1..]);
            Some(remaining)
        })
        .find(|remaining| certify_path(&plan.part, plan.finishing, remaining).is_ok())
}

/// From a place beside a curve along its remainder beyond `share`: straight to the end of a line, or onto
/// an arc a little ahead.
fn onto(curve: &Curve, share: f64, from: Point, ahead_mm: f64) -> Option<Vec<Curve>> {
    let line = |to: Point| (from != to).then_some(Curve::Line(Segment { from, to }));
    let ahead = share + ahead_mm / length_mm(curve);
    if matches!(curve, Curve::Line(_)) || ahead >= 1.0 {
        return Some(line(curve.to()).into_iter().collect());
    }
    let joint = dividing_point(curve, along_mm(curve, ahead).0).ok()?;
    let remainder = between(curve, joint, curve.to())?;
    Some(line(joint).into_iter().chain(remainder).collect())
}

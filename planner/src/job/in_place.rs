//! Going on from where the tool stands on a path that was interrupted.

use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, Point, Segment};

use super::progress::{SNAP_MM, nearest_share};
use super::track::{between, length_mm};
use crate::plan::CertifiedPlan;
use crate::units::{along_mm, point_from_mm};

/// Curves of a path this little farther from a place than the nearest one are as likely to be the one it is on, mm.
const ALIKE_MM: f64 = 0.005;
/// The tool is led back onto an arc so far ahead of where it stands, mm: the first length that is clear is taken.
const AHEAD_MM: [f64; 4] = [0.05, 0.02, 0.01, 0.005];

/// The rest of an interrupted path, for a tool that stands on it at rest: `path` are the motions that may not be done yet, the
/// first `begun` of them were sent, and `at` is where it was reported. Begins exactly at `at`; or, where that is nearer to the
/// part than finishing allows because a report is rounded, at the path's own nearest point. Certified at the finishing threshold.
///
/// `None` when `at` is farther than [`SNAP_MM`] from the motions that were sent, as where something else has moved the tool
/// along the part, or no way on is certified. Empty when the path is done. Where the path passes near itself, the earlier of its
/// motions is taken.
#[must_use]
pub fn resume_in_place(plan: &CertifiedPlan, path: &[Curve], begun: usize, at: Point) -> Option<Vec<Curve>> {
    let near: Vec<(f64, f64)> = path.iter().take(begun).map(|curve| nearest_share(curve, at)).collect();
    let least = near.iter().map(|(_, away)| *away).fold(f64::INFINITY, f64::min);
    let index = near.iter().position(|(_, away)| *away <= (least + ALIKE_MM).min(SNAP_MM))?;
    let (curve, share) = (path.get(index)?, near[index].0);
    let foot = point_from_mm(along_mm(curve, share).0).ok()?;
    let ways = [at, foot].into_iter().flat_map(|from| AHEAD_MM.map(|ahead| (from, ahead)));
    ways.filter_map(|(from, ahead)| {
        let mut rest = onto(curve, share, from, ahead)?;
        rest.extend(&path[index + 1..]);
        Some(rest)
    })
    .find(|rest| certify_path(&plan.part, plan.finishing, rest).is_ok())
}

/// From beside a curve along what is left of it beyond `share`: along a line straight to its end, onto an arc a little ahead.
fn onto(curve: &Curve, share: f64, from: Point, ahead_mm: f64) -> Option<Vec<Curve>> {
    let line = |to: Point| (from != to).then_some(Curve::Line(Segment { from, to }));
    let ahead = share + ahead_mm / length_mm(curve);
    if matches!(curve, Curve::Line(_)) || ahead >= 1.0 {
        return Some(line(curve.to()).into_iter().collect());
    }
    let joint = point_from_mm(along_mm(curve, ahead).0).ok()?;
    let rest = between(curve, joint, curve.to())?;
    Some(line(joint).into_iter().chain(rest).collect())
}

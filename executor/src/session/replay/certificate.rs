//! The check of a logged certificate by itself, without the guard.

use keepout_guard::{Interpolation, Rules};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::certify_path;
use keepout_kernel::{FreePoint, Length, Levels, Point, ProhibitedRegion};

use crate::session::event_log::Certificate;

/// Checks a certificate. `retracts` says whether the tool may stand inside the jogging clearance: a jog may
/// then be a retract move.
///
/// # Errors
/// The reason why the certificate does not hold.
pub(super) fn check(
    certificate: &Certificate,
    levels: &Levels,
    rules: &Rules,
    retracts: bool,
) -> Result<(), String> {
    match certificate {
        Certificate::Jog { to, set, .. } if !set.contains(to) => {
            Err("the in-flight set lacks the target".into())
        }
        Certificate::Jog { height, lowest, .. } if height < lowest => {
            Err("the lowest height of the in-flight set is above the target".into())
        }
        Certificate::Jog { to, set, lowest, .. } => {
            let part = levels.at(rules.heights.certified_for(*lowest));
            let hull =
                if rules.interpolation == Interpolation::Independent { corners(set) } else { set.to_vec() };
            match check_hull(part, rules.jogging_clearance, &hull) {
                Err(_) if retracts => check_retract(part, rules.jogging_clearance, *to, set),
                checked => checked,
            }
        }
        Certificate::Contour { curve, from, to, .. } => {
            let part = levels.at(rules.heights.certified_for(*from.min(to)));
            match certify_path(part, rules.finishing_clearance, &[*curve]) {
                Ok(_) => Ok(()),
                Err(gouge) => Err(gouge.to_string()),
            }
        }
    }
}

/// Checks that the convex hull of the points is clear, and on the free side. Swept triangles of the points
/// cover the hull, and each begins at a free point.
fn check_hull(part: &ProhibitedRegion, jogging_clearance: Length, set: &[Point]) -> Result<(), String> {
    let free: Vec<FreePoint> = set
        .iter()
        .map(|&point| part.free_point(point, jogging_clearance))
        .collect::<Result<_, _>>()
        .map_err(|blocked| blocked.to_string())?;
    for (i, &a) in free.iter().enumerate() {
        for (j, &b) in free.iter().enumerate().skip(i + 1) {
            for c in free.iter().skip(j) {
                part.fan(a, b, c.point()).map_err(|blocked| blocked.to_string())?;
            }
        }
    }
    Ok(())
}

/// The corners of the box around the points: non-interpolated axes can reach all of it.
fn corners(set: &[Point]) -> Vec<Point> {
    let window = set.iter().map(|&point| Window::of(point));
    let Some(window) = window.reduce(Window::union) else {
        return Vec::new();
    };
    let (x0, y0, x1, y1) = window.corners();
    let corner = |x: i32, y: i32| Point::from_units(x.into(), y.into()).ok();
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].into_iter().filter_map(|(x, y)| corner(x, y)).collect()
}

/// Checks that the retract move comes nearer to no edge of the part.
fn check_retract(
    part: &ProhibitedRegion,
    jogging_clearance: Length,
    target: Point,
    set: &[Point],
) -> Result<(), String> {
    let from = set.iter().copied().find(|&point| point != target).unwrap_or(target);
    let clearance = part.clearance(from).ok_or("the retract move begins in the part")?;
    let from = part.free_point(from, clearance).map_err(|blocked| blocked.to_string())?;
    part.retract(from, target, jogging_clearance).map(|_| ()).map_err(|blocked| blocked.to_string())
}

//! The check of a logged certificate by itself, without the guard.

use arrayvec::ArrayVec;
use keepout_guard::{Interpolation, Rules};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, FreePoint, Height, Length, Levels, Place, Point, ProhibitedRegion};

use crate::session::event_log::{Certificate, SET_MAX};

/// The rules for the certificates of a session.
pub(super) struct CertificateRules<'a> {
    pub(super) levels: &'a Levels,
    pub(super) rules: &'a Rules,
    /// Whether the tool may stand inside the jogging clearance: a jog may then be a retract move.
    pub(super) retracts: bool,
}

impl CertificateRules<'_> {
    /// Checks a certificate. `before` is the target of the certified motion before it, if the position was not
    /// located again since then.
    ///
    /// # Errors
    /// The reason why the certificate does not hold.
    pub(super) fn check(&self, certificate: &Certificate, before: Option<Place>) -> Result<(), String> {
        let Self { levels, rules, .. } = self;
        match certificate {
            Certificate::Jog { to, set, .. } if !set.contains(to) => {
                Err("the in-flight set lacks the target".into())
            }
            Certificate::Jog { height, lowest, .. } if height < lowest => {
                Err("the lowest height of the in-flight set is above the target".into())
            }
            Certificate::Jog { to, set, lowest, .. } => {
                let part = levels.at(rules.heights.certified_for(*lowest));
                let boxed = rules.interpolation == Interpolation::Independent;
                let hull = if boxed { corners(set) } else { set.to_vec() };
                match check_hull(part, rules.jogging_clearance, &hull) {
                    Err(_) if self.retracts && self.may_retract(set, *to, *lowest, before) => {
                        check_retract(part, rules, *to, set)
                    }
                    checked => checked,
                }
            }
            Certificate::Contour { curve, from, to, .. } => {
                let part = levels.at(rules.heights.certified_for(*from.min(to)));
                self.check_contour(part, curve)
            }
        }
    }

    /// Whether a jog can be a retract move. It begins at rest, at one place. A rise can follow before it ends: then the
    /// target stays, and without a checksum the set has two places of the tool.
    ///
    /// The move is not lower than the motion before it, to the resolution of the two reports that may lie between
    /// them. A certificate does not state the height of its start.
    fn may_retract(&self, set: &[Point], to: Point, lowest: Height, before: Option<Place>) -> bool {
        let mut others: ArrayVec<Point, SET_MAX> = ArrayVec::new();
        for &point in set.iter().filter(|point| **point != to) {
            if !others.contains(&point) {
                others.push(point);
            }
        }
        let places = if before.is_some_and(|before| before.point == to) { 2 } else { 1 };
        let resolution = self.rules.heights.resolution;
        let stays_up =
            before.is_none_or(|before| lowest >= before.height.lowered(resolution).lowered(resolution));
        others.len() <= places && stays_up
    }

    fn check_contour(&self, part: &ProhibitedRegion, curve: &Curve) -> Result<(), String> {
        let clearance = self.rules.finishing_clearance;
        certify_path(part, clearance, &[*curve]).map_err(|gouge| gouge.to_string())?;
        match (self.rules.contours, curve) {
            (Interpolation::Linear, _) => Ok(()),
            (Interpolation::Independent, Curve::Line(line)) => {
                check_hull(part, clearance, &corners(&[line.from, line.to]))
            }
            (Interpolation::Independent, Curve::Arc(_)) => {
                Err("the axes are not interpolated, and the motion is an arc".into())
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
                part.swept_triangle(a, b, c.point()).map_err(|blocked| blocked.to_string())?;
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

/// Checks a retract move: the way from each place of the set straight to the target comes nearer to no edge of the part
/// within the jogging clearance.
fn check_retract(part: &ProhibitedRegion, rules: &Rules, target: Point, set: &[Point]) -> Result<(), String> {
    for &from in set {
        let way = target.minus(from);
        if rules.interpolation == Interpolation::Independent && way.dx != 0 && way.dy != 0 {
            return Err("the axes are not interpolated, and the retract move is not along one of them".into());
        }
        let clearance = part.clearance(from).ok_or("the retract move begins in the part")?;
        let threshold = clearance.min(rules.jogging_clearance);
        let from = part.free_point(from, threshold).map_err(|blocked| blocked.to_string())?;
        part.retract(from, target, rules.jogging_clearance).map_err(|blocked| blocked.to_string())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use keepout_guard::{HeightRules, OnCancel};
    use keepout_kernel::{Region, Ring, Side};

    use super::*;

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    /// Checks a jog beside a square of 1000 units, at a clearance of 400. The set holds the target.
    fn check(interpolation: Interpolation, to: Point, others: &[Point], before: Option<Place>) -> bool {
        let square = Ring::new(vec![at(0, 0), at(1000, 0), at(1000, 1000), at(0, 1000)]).unwrap();
        let part = ProhibitedRegion::new(Region::new(vec![square]).unwrap(), Side::Outside).unwrap();
        let levels = Levels::flat(part.into());
        let rules = Rules {
            travel: Window::of(at(-9000, -9000)).including(at(9000, 9000)),
            jogging_clearance: Length::small(250).saturating_plus(Length::small(150)),
            finishing_clearance: Length::small(200),
            resolution: Length::small(1),
            shortest: Length::small(1),
            interpolation,
            on_cancel: OnCancel::NotOffered,
            contours: interpolation,
            checked: true,
            heights: HeightRules::TWO_AXES,
        };
        let set = others.iter().copied().chain([to]).collect();
        let (height, lowest) = (Height::ZERO, Height::ZERO);
        let certificate = Certificate::Jog { to, height, feed_mm_min: 60, set, lowest };
        CertificateRules { levels: &levels, rules: &rules, retracts: true }
            .check(&certificate, before)
            .is_ok()
    }

    #[test]
    fn retract_move_leads_straight_away_from_one_place() {
        use Interpolation::{Independent, Linear};
        let (near, far) = (at(1300, 500), at(1350, 520));
        assert!(check(Linear, far, &[near], None));
        assert!(!check(Linear, near, &[far], None), "toward the part");
        assert!(!check(Linear, far, &[at(900, 500)], None), "from the part");
        assert!(!check(Independent, far, &[near], None), "not along an axis");
        assert!(check(Independent, at(1350, 500), &[near], None));
        // From two places only if the target is that of the motion before.
        let two = [near, at(1301, 500)];
        assert!(!check(Linear, far, &two, None));
        assert!(check(Linear, far, &two, Some(far.at_height(Height::ZERO))));
        // Not lower than the motion before.
        let above = Height::from_units(5).unwrap();
        assert!(!check(Linear, far, &[near], Some(near.at_height(above))));
        assert!(
            check(Linear, at(2000, 520), &[at(1500, 520)], Some(near.at_height(above))),
            "no retract move"
        );
    }
}

//! Construction of the prohibited profile and the tool path for a tool of radius R (section 5.3).

use keepout_planner::Mm2;
use keepout_planner::profile::MachinedSide;
use thiserror::Error;

use super::segments;

/// Reasons for which a prohibited profile can not be constructed.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum RadiusError {
    /// The radius is not a finite length above zero.
    #[error("the tool radius {radius_mm} mm is invalid. Give a finite radius above zero.")]
    Radius {
        /// The requested radius, mm.
        radius_mm: f64,
    },
    /// A corner has a coordinate that is not finite.
    #[error("corner {index} of the profile, ({}, {}) mm, is invalid. Give finite coordinates.", at.x, at.y)]
    NotFinite {
        /// Number of the corner, from 0.
        index: usize,
        /// Its coordinates, mm.
        at: Mm2,
    },
    /// A corner has the same coordinates as the previous one.
    #[error("corner {index} of the profile, {at}, repeats the previous corner. Remove it.")]
    Repeats {
        /// Number of the corner, from 0.
        index: usize,
        /// Its coordinates, mm.
        at: Mm2,
    },
    /// Too few corners remain for a polygon.
    #[error(
        "a tool radius of {radius_mm} mm leaves {left} corners of the profile, but a polygon needs three. \
         Use a smaller tool."
    )]
    TooFew {
        /// Number of corners after the filter.
        left: usize,
        /// The radius, mm.
        radius_mm: f64,
    },
}

/// Eq. (4): the angle φ by which the route turns at `b`, in [0, π]. NaN if `b` repeats a neighbour.
#[must_use]
pub fn turn_rad(a: Mm2, b: Mm2, c: Mm2) -> f64 {
    let (ab, bc) = (b - a, c - b);
    (ab.dot(bc) / (ab.length() * bc.length())).clamp(-1.0, 1.0).acos()
}

/// Eq. (3): d = R tan(φ/2), the distance along the segment between the corners of path and profile, mm.
#[must_use]
pub fn setback_mm(radius_mm: f64, turn_rad: f64) -> f64 {
    radius_mm * (turn_rad / 2.0).tan()
}

/// Step 1: the profile without the points that are "very close" for a tool of this radius.
///
/// For consecutive points A, B, C along the route, the paper removes B if d > |AB|, and C if d > |BC|. It
/// does not state the order. We go along the route from the first triple, remove the first such point, and
/// start again. We end if no point is left to remove, or fewer than three points remain. We also remove a
/// point that repeats the previous one.
///
/// The filter ignores the machined side, so it removes convex corners of the part as well as concave ones.
#[must_use]
pub fn filter_very_close(profile: &[Mm2], radius_mm: f64) -> Vec<Mm2> {
    let mut kept = profile.to_vec();
    while let Some(index) = first_very_close(&kept, radius_mm) {
        kept.remove(index);
    }
    kept
}

fn first_very_close(profile: &[Mm2], radius_mm: f64) -> Option<usize> {
    if profile.len() < 3 {
        return None;
    }
    triples(profile).enumerate().find_map(|(index, [a, b, c])| {
        let setback = setback_mm(radius_mm, turn_rad(a, b, c));
        if a == b || setback > a.distance(b) {
            Some((index + 1) % profile.len())
        } else if setback > b.distance(c) {
            Some((index + 2) % profile.len())
        } else {
            None
        }
    })
}

/// A, B, C for each corner B, from the second corner on.
fn triples(profile: &[Mm2]) -> impl Iterator<Item = [Mm2; 3]> {
    let corner = |i: usize| profile[i % profile.len()];
    (0..profile.len()).map(move |i| [corner(i), corner(i + 1), corner(i + 2)])
}

/// Eq. (5): whether B lies above AC, on the tool's side.
///
/// V is the component of AB across AC. The paper does not define H. We use the perpendicular (−y, x) of AC,
/// the direction of the shift in eq. (8). Then V·H > 0 means that `b` lies to the left of AC, and the route
/// turns right at `b`. A point on AC is not above.
#[must_use]
pub fn is_above(a: Mm2, b: Mm2, c: Mm2) -> bool {
    (c - a).cross(b - a) > 0.0
}

/// Steps 1 and 2: the polygon that the tool's centre must not enter, eqs. (6) to (13).
///
/// The construction reverses the route if necessary, so that the perpendicular (−y, x) points to the tool. It
/// filters the corners, and makes a corner B' for each remaining one, starting with the second. If the filter
/// removes no corner, the result is the offset polygon with mitred corners.
///
/// # Errors
/// [`RadiusError`] if the radius is not above zero, a corner is not finite or repeats the previous one, or
/// fewer than three corners remain after the filter.
pub fn prohibited(profile: &[Mm2], radius_mm: f64, side: MachinedSide) -> Result<Vec<Mm2>, RadiusError> {
    check(profile, radius_mm)?;
    let kept = filter_very_close(&tool_on_left(profile, side), radius_mm);
    if kept.len() < 3 {
        return Err(RadiusError::TooFew { left: kept.len(), radius_mm });
    }
    Ok(triples(&kept).map(|corner| shifted(corner, radius_mm)).collect())
}

fn check(profile: &[Mm2], radius_mm: f64) -> Result<(), RadiusError> {
    if !(radius_mm.is_finite() && radius_mm > 0.0) {
        return Err(RadiusError::Radius { radius_mm });
    }
    let before = profile.iter().cycle().skip(profile.len().saturating_sub(1));
    for (index, (&at, &before)) in profile.iter().zip(before).enumerate() {
        if !at.is_finite() {
            return Err(RadiusError::NotFinite { index, at });
        }
        if at == before {
            return Err(RadiusError::Repeats { index, at });
        }
    }
    Ok(())
}

/// The profile in the direction that has the tool on its left.
fn tool_on_left(profile: &[Mm2], side: MachinedSide) -> Vec<Mm2> {
    let double_area: f64 = segments(profile).map(|(a, b)| a.cross(b)).sum();
    let inside_on_left = double_area > 0.0;
    let mut route = profile.to_vec();
    if inside_on_left != (side == MachinedSide::Inside) {
        route.reverse();
    }
    route
}

/// B' for the corner B: eq. (11) above AC, eq. (13) below.
fn shifted([a, b, c]: [Mm2; 3], radius_mm: f64) -> Mm2 {
    let ab = b - a;
    let parallel = ab / ab.length();
    let setback = setback_mm(radius_mm, turn_rad(a, b, c));
    let along = if is_above(a, b, c) { setback } else { -setback };
    b + parallel.left() * radius_mm + parallel * along
}

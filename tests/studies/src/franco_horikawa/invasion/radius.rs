//! The prohibited profile and tool path for a tool of radius R, section 5.3.

use keepout_planner::profile::MachinedSide;
use keepout_planner::units::mm_pair;
use thiserror::Error;

use super::{PointMm, cross, dot, length, segments, vector};

/// Why no prohibited profile is constructed.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum RadiusError {
    /// The radius is no length.
    #[error("a tool radius of {radius_mm} mm is no length. Give a finite radius above zero.")]
    Radius {
        /// The radius asked for, mm.
        radius_mm: f64,
    },
    /// A corner has a coordinate that is no number.
    #[error("corner {index} of the profile, ({}, {}) mm, is no place. Give finite coordinates.", at.0, at.1)]
    NotFinite {
        /// Which corner, from 0.
        index: usize,
        /// Its coordinates, mm.
        at: PointMm,
    },
    /// A corner lies where the one before lies.
    #[error("corner {index} of the profile, {}, repeats the one before. Leave it out.", mm_pair(*at))]
    Repeats {
        /// Which corner, from 0.
        index: usize,
        /// Its coordinates, mm.
        at: PointMm,
    },
    /// Too few corners are left for a polygon.
    #[error(
        "{left} corners of the profile are left for a tool radius of {radius_mm} mm, and a polygon needs three. Take a smaller tool."
    )]
    TooFew {
        /// How many the filter left.
        left: usize,
        /// The radius, mm.
        radius_mm: f64,
    },
}

/// Eq. (4): the angle φ by which the route turns at `b`, in [0, π]; NaN when `b` repeats a neighbour.
#[must_use]
pub fn turn_rad(a: PointMm, b: PointMm, c: PointMm) -> f64 {
    let (ab, bc) = (vector(a, b), vector(b, c));
    (dot(ab, bc) / (length(ab) * length(bc))).clamp(-1.0, 1.0).acos()
}

/// Eq. (3): d = R tan(φ/2), how far along the segment the path's corner lies from the profile's, mm.
#[must_use]
pub fn setback_mm(radius_mm: f64, turn_rad: f64) -> f64 {
    radius_mm * (turn_rad / 2.0).tan()
}

/// Step 1: the profile without the points that are "very close" for a tool of this radius.
///
/// For consecutive points A, B, C along the route, B is removed when d > |AB|, and C when d > |BC|. The paper does not say
/// in what order. Read here: go along the route from the first triple, remove the first point that is to go, and begin
/// again, until none is or fewer than three are left. A point that repeats the one before is removed as well.
///
/// This knows nothing of which side is machined: it removes convex corners of the part as well as concave ones.
#[must_use]
pub fn filter_very_close(profile: &[PointMm], radius_mm: f64) -> Vec<PointMm> {
    let mut kept = profile.to_vec();
    while let Some(index) = first_very_close(&kept, radius_mm) {
        kept.remove(index);
    }
    kept
}

fn first_very_close(profile: &[PointMm], radius_mm: f64) -> Option<usize> {
    if profile.len() < 3 {
        return None;
    }
    triples(profile).enumerate().find_map(|(index, [a, b, c])| {
        let setback = setback_mm(radius_mm, turn_rad(a, b, c));
        if a == b || setback > length(vector(a, b)) {
            Some((index + 1) % profile.len())
        } else if setback > length(vector(b, c)) {
            Some((index + 2) % profile.len())
        } else {
            None
        }
    })
}

/// A, B, C for each corner B, from the second corner on.
fn triples(profile: &[PointMm]) -> impl Iterator<Item = [PointMm; 3]> {
    let corner = |i: usize| profile[i % profile.len()];
    (0..profile.len()).map(move |i| [corner(i), corner(i + 1), corner(i + 2)])
}

/// Eq. (5): whether B lies above AC, on the tool's side of it.
///
/// V is AB's part across AC. The paper does not define H; read here as AC's perpendicular (−y, x), the way that eq. (8)
/// shifts. V·H > 0 is then: `b` lies left of AC, and the route turns right at it. On AC is not above.
#[must_use]
pub fn is_above(a: PointMm, b: PointMm, c: PointMm) -> bool {
    cross(vector(a, c), vector(a, b)) > 0.0
}

/// Steps 1 and 2: the polygon that the tool's centre is kept out of, eqs. (6) to (13).
///
/// The route is reversed when needed so that the perpendicular (−y, x) points to the tool, then filtered, and a corner B'
/// made for each that is left, beginning with the second. Where nothing is filtered it is the offset polygon with mitred
/// corners.
///
/// # Errors
/// [`RadiusError`] when the radius is no length above zero, a corner is not finite or repeats the one before, or fewer than
/// three are left by the filter.
pub fn prohibited(
    profile: &[PointMm],
    radius_mm: f64,
    side: MachinedSide,
) -> Result<Vec<PointMm>, RadiusError> {
    check(profile, radius_mm)?;
    let kept = filter_very_close(&tool_on_left(profile, side), radius_mm);
    if kept.len() < 3 {
        return Err(RadiusError::TooFew { left: kept.len(), radius_mm });
    }
    Ok(triples(&kept).map(|corner| shifted(corner, radius_mm)).collect())
}

fn check(profile: &[PointMm], radius_mm: f64) -> Result<(), RadiusError> {
    if !(radius_mm.is_finite() && radius_mm > 0.0) {
        return Err(RadiusError::Radius { radius_mm });
    }
    let before = profile.iter().cycle().skip(profile.len().saturating_sub(1));
    for (index, (&at, &before)) in profile.iter().zip(before).enumerate() {
        if !(at.0.is_finite() && at.1.is_finite()) {
            return Err(RadiusError::NotFinite { index, at });
        }
        if at == before {
            return Err(RadiusError::Repeats { index, at });
        }
    }
    Ok(())
}

/// The profile in the direction that has the tool on its left.
fn tool_on_left(profile: &[PointMm], side: MachinedSide) -> Vec<PointMm> {
    let double_area: f64 = segments(profile).map(|(a, b)| cross(a, b)).sum();
    let inside_on_left = double_area > 0.0;
    let mut route = profile.to_vec();
    if inside_on_left != (side == MachinedSide::Inside) {
        route.reverse();
    }
    route
}

/// B' for the corner B: eq. (11) above AC, eq. (13) below.
fn shifted([a, b, c]: [PointMm; 3], radius_mm: f64) -> PointMm {
    let ab = vector(a, b);
    let parallel = (ab.0 / length(ab), ab.1 / length(ab));
    let perpendicular = (-parallel.1, parallel.0);
    let setback = setback_mm(radius_mm, turn_rad(a, b, c));
    let along = if is_above(a, b, c) { setback } else { -setback };
    (
        b.0 + perpendicular.0 * radius_mm + parallel.0 * along,
        b.1 + perpendicular.1 * radius_mm + parallel.1 * along,
    )
}

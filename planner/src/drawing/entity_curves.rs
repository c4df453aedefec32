//! The curves of single entities: arcs, ellipses, polylines; and points along a curve.

use std::f64::consts::TAU;

use super::RawCurve;
use super::entity::{Ellipse, Polyline, Vec3};
use super::placement::{Placement, bulge, cross, unit};
use crate::Mm2;

pub(super) fn arc(
    plane: &Placement,
    centre: Vec3,
    radius: f64,
    angles: Option<(f64, f64)>,
    out: &mut Vec<RawCurve>,
) -> Result<(), &'static str> {
    if radius < 0.0 {
        return Err("its radius is negative");
    }
    if radius == 0.0 {
        return Ok(());
    }
    let (start, sweep) = match angles {
        None => (0.0, TAU),
        Some((start, end)) => (start.to_radians(), sweep_of(start.to_radians(), end.to_radians())?),
    };
    plane.arc(centre, ([radius, 0.0, 0.0], [0.0, radius, 0.0]), start, sweep, out);
    Ok(())
}

/// The angle from `start` forward to `end`, radians.
///
/// Exporters round 2π, so a sweep up to 1e-4 rad above a full turn counts as a full turn. A sweep below a
/// full turn leaves a gap, which the joiner closes like any other gap. If `end` is less than `start`, the arc
/// crosses angle 0, and a small sweep is a short arc, not a full turn.
///
/// # Errors
/// Equal angles are ambiguous: some programs read a full turn, others read no arc.
fn sweep_of(start: f64, end: f64) -> Result<f64, &'static str> {
    const ROUNDED: f64 = 1e-4;
    const EXACT: f64 = 1e-9;
    let turned = end - start;
    if turned == 0.0 {
        return Err(
            "it begins and ends at the same angle: some programs read a full turn, others read no arc",
        );
    }
    let sweep = turned.rem_euclid(TAU);
    let over = if turned > 0.0 { ROUNDED } else { EXACT };
    let whole = turned.abs() > 1.0 && sweep < over || TAU - sweep < EXACT;
    Ok(if whole { TAU } else { sweep })
}

pub(super) fn ellipse(
    placement: &Placement,
    ellipse: &Ellipse,
    normal: Vec3,
    out: &mut Vec<RawCurve>,
) -> Result<(), &'static str> {
    let Ellipse { centre, major, ratio, range: (start, end) } = *ellipse;
    let normal = unit(normal).unwrap_or([0.0, 0.0, 1.0]);
    let minor = cross(normal, major).map(|c| c * ratio);
    let sweep = sweep_of(start, end)?;
    if ratio == 0.0 || major == [0.0; 3] {
        return Err("one of its axes has no length");
    }
    placement.arc(centre, (major, minor), start, sweep, out);
    Ok(())
}

pub(super) fn polyline(placement: &Placement, line: &Polyline, out: &mut Vec<RawCurve>) {
    let vertices = &line.vertices;
    for (i, &(from, b)) in vertices.iter().enumerate() {
        let Some(&(to, _)) = vertices.get(i + 1).or_else(|| vertices.first().filter(|_| line.closed)) else {
            return;
        };
        bulge(placement, from, to, b, out);
    }
}

/// Points along a curve, for a picture.
pub(super) fn points_of(curve: &RawCurve) -> Vec<Mm2> {
    let shares = |count: u8| (0..=count).map(move |k| f64::from(k) / f64::from(count));
    match curve {
        RawCurve::Line { from, to } => vec![*from, *to],
        RawCurve::Arc { arc, .. } => shares(24).map(|share| arc.at(share).into()).collect(),
        RawCurve::Bezier(bezier) => shares(12).map(|share| bezier.at(share)).collect(),
    }
}

//! What a finishing path does to a part: distances in `f64`, from the definitions. Thresholds, and the side that the part is on, are
//! the product's.

use std::f64::consts::TAU;

use keepout_kernel::curve::xy;
use keepout_kernel::offset::{COVERAGE, RESOLUTION};
use keepout_kernel::{Arc, Curve, Turn};
use keepout_planner::finish::centre_distance;
use keepout_planner::plan::{CertifiedPlan, Pass};

type Xy = (f64, f64);

/// Places looked at on each curve.
const PLACES: u32 = 7;
/// Rounding: of arcs' radii, of places on them, in lattice units.
const ROUNDING: f64 = 3.0;

/// Looks at places on the path of every pass, and at places where a pass has to be.
///
/// # Panics
/// When the tool would enter the part, or leave out what it can reach.
pub fn watch(plan: &CertifiedPlan) {
    for pass in &plan.plan.passes {
        let threshold = f64::from(plan.finishing.units()) + f64::from(pass.allowance.units());
        keeps_away(plan, pass, threshold);
        reaches_all(plan, pass);
    }
}

fn keeps_away(plan: &CertifiedPlan, pass: &Pass, threshold: f64) {
    for curve in pass.path.loops.iter().flat_map(|each| &each.curves) {
        for place in places(curve) {
            let left = distance(place, walls(plan));
            assert!(
                left > threshold - ROUNDING,
                "{curve:?} comes to {left} of the part at {place:?}, not {threshold}"
            );
        }
    }
}

/// A place beside an edge at the path's distance, and at no smaller one from any other edge, is on the true offset.
fn reaches_all(plan: &CertifiedPlan, pass: &Pass) {
    let profile = &plan.plan.profile;
    let threshold = plan.finishing.plus(pass.allowance).expect("it was certified");
    let d = centre_distance(profile, &plan.plan.zones, threshold);
    let room = profile.slack().max(plan.plan.zones.slack());
    // Edges that stand for splines may leave them; what is nearly a corner is no place to ask at.
    let apart = 2.0 * (ROUNDING + f64::from(room.units()));
    for curve in walls(plan) {
        for (place, normal) in places(curve).into_iter().zip(normals(curve)) {
            for side in [d, -d] {
                let beside = (place.0 + normal.0 * side, place.1 + normal.1 * side);
                let Ok(point) = keepout_kernel::curve::nearest_point(beside.0, beside.1) else { continue };
                let others = walls(plan).filter(|other| *other != curve);
                if plan.part.holds(point)
                    || distance(beside, others) < d + apart
                    || distance(beside, [curve].into_iter()) < d - ROUNDING
                {
                    continue;
                }
                let path = pass.path.loops.iter().flat_map(|each| &each.curves);
                let off = distance(beside, path);
                let missing = "the path leaves out";
                assert!(
                    off < RESOLUTION + COVERAGE + apart,
                    "{missing} {point:?}, by {off}, beside {curve:?}"
                );
            }
        }
    }
}

/// The curves of the part and the zones.
pub fn walls(plan: &CertifiedPlan) -> impl Iterator<Item = &Curve> {
    let loops = plan.plan.profile.loops.iter().chain(&plan.plan.zones.loops);
    loops.flat_map(|each| each.edges.iter().map(|edge| &edge.curve))
}

/// The least distance to the curves; infinite without any.
#[must_use]
pub fn distance<'a>(place: Xy, curves: impl Iterator<Item = &'a Curve>) -> f64 {
    curves.map(|curve| distance_to(place, curve)).fold(f64::INFINITY, f64::min)
}

fn distance_to(place: Xy, curve: &Curve) -> f64 {
    let away = |end: Xy| (place.0 - end.0).hypot(place.1 - end.1);
    let (a, b) = (xy(curve.from()), xy(curve.to()));
    match curve {
        Curve::Line(_) => {
            let (d, w) = ((b.0 - a.0, b.1 - a.1), (place.0 - a.0, place.1 - a.1));
            let share = ((w.0 * d.0 + w.1 * d.1) / (d.0 * d.0 + d.1 * d.1).max(1.0)).clamp(0.0, 1.0);
            (w.0 - share * d.0).hypot(w.1 - share * d.1)
        }
        Curve::Arc(arc) => {
            let centre = xy(arc.centre());
            let around = (place.1 - centre.1).atan2(place.0 - centre.0);
            let to_ends = away(a).min(away(b));
            if turned(arc, around) <= swept(arc) {
                let (from, to) = (radius(arc, a), radius(arc, b));
                (away(centre) - f64::midpoint(from, to)).abs().min(to_ends)
            } else {
                to_ends
            }
        }
    }
}

fn radius(arc: &Arc, end: Xy) -> f64 {
    let centre = xy(arc.centre());
    (end.0 - centre.0).hypot(end.1 - centre.1)
}

/// From the beginning of the arc to the angle, in its direction, in [0, 2π).
fn turned(arc: &Arc, angle: f64) -> f64 {
    let (centre, from) = (xy(arc.centre()), xy(arc.from()));
    let start = (from.1 - centre.1).atan2(from.0 - centre.0);
    (if arc.turn() == Turn::Left { angle - start } else { start - angle }).rem_euclid(TAU)
}

fn swept(arc: &Arc) -> f64 {
    let (centre, to) = (xy(arc.centre()), xy(arc.to()));
    let whole = turned(arc, (to.1 - centre.1).atan2(to.0 - centre.0));
    if whole > 0.0 { whole } else { TAU }
}

fn shares() -> impl Iterator<Item = f64> {
    (0..PLACES).map(|k| (f64::from(k) + 0.5) / f64::from(PLACES))
}

pub fn places(curve: &Curve) -> Vec<Xy> {
    let (a, b) = (xy(curve.from()), xy(curve.to()));
    let on = |share: f64| match curve {
        Curve::Line(_) => (a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share),
        Curve::Arc(arc) => {
            let (centre, (angle, r)) = (xy(arc.centre()), polar(arc, share));
            (centre.0 + r * angle.cos(), centre.1 + r * angle.sin())
        }
    };
    shares().map(on).collect()
}

/// Unit vectors across the curve at [`places`].
fn normals(curve: &Curve) -> Vec<Xy> {
    let (a, b) = (xy(curve.from()), xy(curve.to()));
    let length = (b.0 - a.0).hypot(b.1 - a.1).max(1.0);
    let across = |share: f64| match curve {
        Curve::Line(_) => ((a.1 - b.1) / length, (b.0 - a.0) / length),
        Curve::Arc(arc) => {
            let (angle, _) = polar(arc, share);
            (angle.cos(), angle.sin())
        }
    };
    shares().map(across).collect()
}

fn polar(arc: &Arc, share: f64) -> (f64, f64) {
    let (centre, from) = (xy(arc.centre()), xy(arc.from()));
    let start = (from.1 - centre.1).atan2(from.0 - centre.0);
    let by = swept(arc) * share;
    let angle = if arc.turn() == Turn::Left { start + by } else { start - by };
    (angle, radius(arc, from) * (1.0 - share) + radius(arc, xy(arc.to())) * share)
}

//! An independent check of finishing toolpaths, from the definitions and in `f64`. It takes thresholds from
//! the parameters and the machine, finds the part's side by winding numbers, and measures distances to
//! lines, arcs and splines. Straight motions along straight edges are checked with big integers where
//! floats are in doubt.

use std::f64::consts::{PI, SQRT_2, TAU};

use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::offset::{COVERAGE, RESOLUTION};
use keepout_kernel::{Arc, Curve, Point, Segment, Turn, Vec2};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{CertifiedPlan, Pass, PlanParameters};
use keepout_planner::profile::{MachinedSide, ProfileLoop, SourceCurve};
use keepout_proofs::soak::segments_within;
use keepout_proofs::square::plain;

/// A point or a vector, lattice units.
pub type Xy = (f64, f64);

/// The coordinates of a point.
pub fn xy(point: Point) -> Xy {
    (f64::from(point.x.units()), f64::from(point.y.units()))
}

/// Number of sampled points on each curve.
const PLACES: u32 = 7;
/// Rounding: of arcs' radii, of places on them, in lattice units.
const ROUNDING: f64 = 3.0;
/// How much farther than necessary a path may be, for its own rounding, lattice units.
pub const PATH_CLEARANCE: f64 = 60.0;
/// How much more clearance than tool, stock and errors a plan may have, lattice units. The plan has more
/// terms, and rounds up each.
const KEPT_MORE: f64 = 10.0;
/// Distance from a motion at which the check looks for the part, lattice units.
const ASIDE: f64 = 500.0;
/// Lattice units in a millimetre.
pub const UNIT: f64 = 1e5;
/// The path's chord-error bound, and rounding of the drawing, the path and a controller's floats, mm.
const LATTICE_MM: f64 = 0.000_2;

/// Checks points on the path of every pass, and points where a pass must be. A plan file has no parameters.
/// Without them, tool, stock and errors are those of the plan.
///
/// # Panics
/// When the tool would enter the part, or leaves out a place that it can reach.
pub fn watch(plan: &CertifiedPlan, job: Option<&PlanParameters>) {
    follows_sources(plan);
    let by_hand = f64::from(plan.roughing.units()) - f64::from(plan.finishing.units());
    let least = 2.0 * resolution_mm(&plan.plan.machine) * UNIT;
    assert!(
        by_hand > least - 0.01,
        "{by_hand} is left by hand, and {least} is what a stopped tool is known to"
    );
    for (number, pass) in plan.plan.passes.iter().enumerate() {
        let needed = match job {
            Some(job) => needed_mm(plan, job, number) * UNIT,
            None => {
                let margin_mm: f64 = plan.plan.budget.terms.iter().map(|term| term.mm).sum();
                let least_mm = rounding_mm(&plan.plan.machine);
                assert!(margin_mm > least_mm - 1e-9, "a margin of {margin_mm}, {least_mm} is needed");
                f64::from(plan.plan.tool_radius.units())
                    + f64::from(pass.stock_to_leave.units())
                    + margin_mm * UNIT
            }
        };
        let threshold = plan.finishing.plus(pass.stock_to_leave).expect("it was certified");
        let stated = f64::from(threshold.units());
        assert!(stated > needed - 0.01, "{stated} is kept, {needed} is what tool, stock and errors need");
        assert!(stated < needed + KEPT_MORE, "{stated} is kept, and no more than {needed} is needed");
        keeps_away(plan, pass, stated);
        lines_keep_away(plan, pass, i64::from(threshold.units()));
        closes(pass);
        goes_round(plan, pass);
        reaches_all(plan, pass);
    }
}

/// Radius, stock to leave, and margin: the requested one, or the one that the errors need.
fn needed_mm(plan: &CertifiedPlan, job: &PlanParameters, pass: usize) -> f64 {
    let left_mm = job.passes.get(pass).map_or(0.0, |pass| pass.stock_to_leave_mm);
    let margin_mm = job.margin_mm.unwrap_or_else(|| least_margin_mm(&plan.plan.machine));
    job.tool_diameter_mm / 2.0 + left_mm + margin_mm
}

/// The errors of a machine and the rounding that a margin must cover, mm.
pub fn least_margin_mm(machine: &MachineProfile) -> f64 {
    machine.repeatability_mm + machine.contour_error_mm + rounding_mm(machine)
}

/// The terms that every plan needs, mm: chords that turn twice the angle, the controller's resolution,
/// rounding.
fn rounding_mm(machine: &MachineProfile) -> f64 {
    4.0 * machine.arc_tolerance_mm + resolution_mm(machine) + LATTICE_MM
}

/// Half a step on both axes for the motion and for the report, and half the last digit, mm.
fn resolution_mm(machine: &MachineProfile) -> f64 {
    SQRT_2 / machine.steps_per_mm + SQRT_2 / 2.0 * machine.report_digit_mm
}

fn keeps_away(plan: &CertifiedPlan, pass: &Pass, threshold: f64) {
    let sources: Vec<Xy> = sources(plan).flat_map(|(_, source)| points_of(source)).collect();
    for curve in pass.path.loops.iter().flat_map(|each| &each.curves) {
        for place in places(curve).into_iter().chain([xy(curve.from())]) {
            let source = sources.iter().map(|&point| between(place, point)).fold(f64::INFINITY, f64::min);
            let left = distance(place, walls(plan)).min(source);
            assert!(
                left > threshold - ROUNDING,
                "{curve:?} comes to {left} of the part at {place:?}, not {threshold}"
            );
            assert!(!is_in_part(plan, place), "{curve:?} is in the part at {place:?}");
        }
    }
}

/// Checks with big integers that straight motions are clear of straight edges.
fn lines_keep_away(plan: &CertifiedPlan, pass: &Pass, threshold: i64) {
    let straight = |curve: &Curve| match *curve {
        Curve::Line(line) => Some(line),
        Curve::Arc(_) => None,
    };
    let edges: Vec<Segment> = walls(plan).filter_map(straight).collect();
    let motions = pass.path.loops.iter().flat_map(|each| &each.curves).filter_map(straight);
    for (motion, edge) in motions.flat_map(|motion| edges.iter().map(move |edge| (motion, edge))) {
        let (a, b, c, d) = (plain(motion.from), plain(motion.to), plain(edge.from), plain(edge.to));
        assert!(!segments_within(a, b, c, d, threshold), "{motion:?} comes to {threshold} of {edge:?}");
    }
}

/// Checks that each curve begins at the end of the one before, and the first at the end of the last.
fn closes(pass: &Pass) {
    for each in &pass.path.loops {
        let next = each.curves.iter().cycle().skip(1);
        let jump = each.curves.iter().zip(next).find(|(one, next)| one.to() != next.from());
        assert!(jump.is_none() && !each.curves.is_empty(), "the path has a jump: {jump:?}");
    }
}

/// Checks that the part is on the left of most of each loop: from the middle of a motion it is nearer on
/// that side. In a slot as wide as the tool it is as near on both sides.
fn goes_round(plan: &CertifiedPlan, pass: &Pass) {
    const MIDDLE: usize = PLACES as usize / 2;
    for each in &pass.path.loops {
        let other_way = |curve: &&Curve| {
            let (place, (nx, ny)) = (places(curve)[MIDDLE], normals(curve)[MIDDLE]);
            let inward = matches!(curve, Curve::Arc(arc) if arc.turn() == Turn::CounterClockwise);
            let aside = if inward { -ASIDE } else { ASIDE };
            let at = |by: f64| distance((place.0 + nx * by, place.1 + ny * by), walls(plan));
            at(aside) > at(-aside)
        };
        let length = |curves: &mut dyn Iterator<Item = &Curve>| curves.map(Curve::length).sum::<f64>();
        let (all, wrong) =
            (length(&mut each.curves.iter()), length(&mut each.curves.iter().filter(other_way)));
        assert!(wrong <= 0.8 * all, "{wrong} of {all} of a loop have the part on the right: {each:?}");
    }
}

/// Checks that the path is complete. A point at the path's distance from an edge, and no nearer to any
/// other edge, is on the true offset.
fn reaches_all(plan: &CertifiedPlan, pass: &Pass) {
    let threshold = plan.finishing.plus(pass.stock_to_leave).expect("it was certified");
    let loops = plan.plan.profile.loops.iter().chain(&plan.plan.zones.loops);
    let room = loops.flat_map(|each| &each.edges).map(|edge| edge.chord_error.units()).max().unwrap_or(0);
    let d = f64::from(threshold.units()) + PATH_CLEARANCE + f64::from(room);
    // Edges that stand for splines may leave them. A point near a corner is not suitable for the check.
    let apart = 2.0 * (ROUNDING + f64::from(room));
    for curve in walls(plan) {
        for (place, normal) in places(curve).into_iter().zip(normals(curve)) {
            for side in [d, -d] {
                let beside = (place.0 + normal.0 * side, place.1 + normal.1 * side);
                let others = walls(plan).filter(|other| *other != curve);
                if keepout_kernel::curve::nearest_point(Vec2::new(beside.0, beside.1)).is_err()
                    || distance(beside, others) < d + apart
                    || distance(beside, [curve].into_iter()) < d - ROUNDING
                    || is_in_part(plan, beside)
                {
                    continue;
                }
                let path = pass.path.loops.iter().flat_map(|each| &each.curves);
                let off = distance(beside, path);
                assert!(
                    off < RESOLUTION + COVERAGE + apart,
                    "the path leaves out {beside:?}, by {off}, beside {curve:?}"
                );
            }
        }
    }
}

/// Checks that splines and ellipses stay within the stated bounds of the edges that stand for them.
fn follows_sources(plan: &CertifiedPlan) {
    for (each, source) in sources(plan) {
        let edges = &each.edges[source.first..source.end];
        let chord_error = edges.iter().map(|edge| edge.chord_error.units()).max().unwrap_or(0);
        for point in points_of(source) {
            let off = distance(point, edges.iter().map(|edge| &edge.curve));
            assert!(
                off < f64::from(chord_error) + ROUNDING,
                "{source:?} is {off} from its edges, not {chord_error}"
            );
        }
    }
}

fn sources(plan: &CertifiedPlan) -> impl Iterator<Item = (&ProfileLoop, &SourceCurve)> {
    let loops = plan.plan.profile.loops.iter().chain(&plan.plan.zones.loops);
    loops.flat_map(|each| each.sources.iter().map(move |source| (each, source)))
}

/// Points on a rational Bézier curve, with its ends (de Casteljau, in homogeneous coordinates).
#[expect(clippy::cast_precision_loss, reason = "weights have 41 bits")]
fn points_of(source: &SourceCurve) -> impl Iterator<Item = Xy> {
    let curve: &Bezier = &source.curve;
    let row = |(&p, &w): (&Point, &u64)| (xy(p).0 * w as f64, xy(p).1 * w as f64, w as f64);
    let rows: Vec<(f64, f64, f64)> = curve.control().iter().zip(curve.weights()).map(row).collect();
    (0..PLACES).map(move |k| {
        let (mut rows, t) = (rows.clone(), f64::from(k) / f64::from(PLACES - 1));
        while rows.len() > 1 {
            let mix = |a: f64, b: f64| a * (1.0 - t) + b * t;
            let pair =
                |p: &[(f64, f64, f64)]| (mix(p[0].0, p[1].0), mix(p[0].1, p[1].1), mix(p[0].2, p[1].2));
            rows = rows.windows(2).map(pair).collect();
        }
        (rows[0].0 / rows[0].2, rows[0].1 / rows[0].2)
    })
}

/// Whether a place off every edge is in the part or in a keep-out zone, by the number of loops that wind
/// around it.
fn is_in_part(plan: &CertifiedPlan, place: Xy) -> bool {
    let winds = |each: &ProfileLoop| winds(each.edges.iter().map(|edge| &edge.curve), place);
    let around = |each: &&ProfileLoop| winds(each);
    let enclosed = plan.plan.profile.loops.iter().filter(around).count() % 2 == 1;
    let part = enclosed == (plan.plan.side == MachinedSide::Outside);
    part || plan.plan.zones.loops.iter().any(winds)
}

/// Whether a loop goes once round the place, in either direction: the sum of the angles that its curves
/// turn through, seen from there.
pub fn winds<'a>(curves: impl Iterator<Item = &'a Curve>, place: Xy) -> bool {
    let angle = |curve: &Curve| {
        let seen = |end: Xy| (end.0 - place.0, end.1 - place.1);
        let (a, b) = (seen(xy(curve.from())), seen(xy(curve.to())));
        // A place on the chord's line counts as left of it. −0 would give the other half-turn.
        let across = a.0 * b.1 - a.1 * b.0 + 0.0;
        let chord = across.atan2(a.0 * b.0 + a.1 * b.1);
        let Curve::Arc(arc) = curve else { return chord };
        // Between the chord and the arc, the loop winds once more.
        let left = arc.turn() == Turn::CounterClockwise;
        let whole = arc.from() == arc.to();
        let inside = between(place, xy(arc.centre())) < radius(arc, xy(arc.from()));
        match (inside && (whole || (across < 0.0) == left), left) {
            (false, _) => chord,
            (true, true) => chord + TAU,
            (true, false) => chord - TAU,
        }
    };
    let turned: f64 = curves.map(angle).sum();
    turned.abs() > PI
}

/// The distance of two places.
pub fn between(a: Xy, b: Xy) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// The point at a share of the straight way.
pub fn on_the_way(a: Xy, b: Xy, share: f64) -> Xy {
    (a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share)
}

/// The curves of the part and of the keep-out zones.
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
    let away = |end: Xy| between(place, end);
    let (a, b) = (xy(curve.from()), xy(curve.to()));
    match curve {
        Curve::Line(_) => to_chord(place, (a, b)),
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

/// The distance to the line between two places.
pub fn to_chord(place: Xy, (a, b): (Xy, Xy)) -> f64 {
    let (d, w) = ((b.0 - a.0, b.1 - a.1), (place.0 - a.0, place.1 - a.1));
    let share = ((w.0 * d.0 + w.1 * d.1) / (d.0 * d.0 + d.1 * d.1).max(1e-9)).clamp(0.0, 1.0);
    (w.0 - share * d.0).hypot(w.1 - share * d.1)
}

fn radius(arc: &Arc, end: Xy) -> f64 {
    between(xy(arc.centre()), end)
}

/// The angle from the beginning of the arc to `angle`, in the arc's direction, in [0, 2π).
fn turned(arc: &Arc, angle: f64) -> f64 {
    let (centre, from) = (xy(arc.centre()), xy(arc.from()));
    let start = (from.1 - centre.1).atan2(from.0 - centre.0);
    (if arc.turn() == Turn::CounterClockwise { angle - start } else { start - angle }).rem_euclid(TAU)
}

fn swept(arc: &Arc) -> f64 {
    let (centre, to) = (xy(arc.centre()), xy(arc.to()));
    let whole = turned(arc, (to.1 - centre.1).atan2(to.0 - centre.0));
    if whole > 0.0 { whole } else { TAU }
}

fn shares(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| (f64::from(k) + 0.5) / f64::from(count))
}

pub fn places(curve: &Curve) -> Vec<Xy> {
    places_along(curve, PLACES)
}

/// `count` points along the curve.
pub fn places_along(curve: &Curve, count: u32) -> Vec<Xy> {
    let (a, b) = (xy(curve.from()), xy(curve.to()));
    let on = |share: f64| match curve {
        Curve::Line(_) => on_the_way(a, b, share),
        Curve::Arc(arc) => {
            let (centre, (angle, r)) = (xy(arc.centre()), polar(arc, share));
            (centre.0 + r * angle.cos(), centre.1 + r * angle.sin())
        }
    };
    shares(count).map(on).collect()
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
    shares(PLACES).map(across).collect()
}

/// The angle and the radius at a share of an arc.
pub fn polar(arc: &Arc, share: f64) -> (f64, f64) {
    let (centre, from) = (xy(arc.centre()), xy(arc.from()));
    let start = (from.1 - centre.1).atan2(from.0 - centre.0);
    let by = swept(arc) * share;
    let angle = if arc.turn() == Turn::CounterClockwise { start + by } else { start - by };
    (angle, radius(arc, from) * (1.0 - share) + radius(arc, xy(arc.to())) * share)
}

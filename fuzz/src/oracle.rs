//! What a finishing path does to a part, from the definitions and in `f64`: thresholds from the job and the machine, the side that
//! the part is on by winding numbers, distances to lines, arcs and splines. Straight motions along straight edges are
//! asked by big integers wherever floats are in doubt.

use std::f64::consts::{PI, SQRT_2, TAU};

use keepout_kernel::curve::xy;
use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::offset::{COVERAGE, RESOLUTION};
use keepout_kernel::{Arc, Curve, Point, Segment, Turn};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{CertifiedPlan, Pass, PlanParameters};
use keepout_planner::profile::{MachinedSide, ProfileLoop, SourceCurve};
use keepout_proofs::soak::segments_within;
use keepout_proofs::square::plain;

pub type Xy = (f64, f64);

/// Places looked at on each curve.
const PLACES: u32 = 7;
/// Rounding: of arcs' radii, of places on them, in lattice units.
const ROUNDING: f64 = 3.0;
/// How much farther than it must be a path may be, lattice units: for its own rounding.
pub const PATH_CLEARANCE: f64 = 60.0;
/// How much more than tool, stock and errors may be kept, lattice units: the plan names more terms, and each is rounded up.
const KEPT_MORE: f64 = 10.0;
/// How far beside a motion is looked where the part is, lattice units.
const ASIDE: f64 = 500.0;
/// Lattice units in a millimetre.
pub const UNIT: f64 = 1e5;
/// The path's chords, and rounding of the drawing, the path and a controller's floats, mm.
const LATTICE_MM: f64 = 0.000_2;

/// Looks at places on the path of every pass, and at places where a pass has to be. Without the job, which is not in a plan's
/// file, tool, stock and errors are what the plan says.
///
/// # Panics
/// When the tool would enter the part, or leave out what it can reach.
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

/// Radius, what the pass leaves, and the margin: as ordered, or what it must cover.
fn needed_mm(plan: &CertifiedPlan, job: &PlanParameters, pass: usize) -> f64 {
    let left_mm = job.passes.get(pass).map_or(0.0, |pass| pass.stock_to_leave_mm);
    let margin_mm = job.margin_mm.unwrap_or_else(|| least_margin_mm(&plan.plan.machine));
    job.tool_diameter_mm / 2.0 + left_mm + margin_mm
}

/// The errors of a machine, and the rounding, that a margin must cover, mm.
pub fn least_margin_mm(machine: &MachineProfile) -> f64 {
    machine.repeatability_mm + machine.contour_error_mm + rounding_mm(machine)
}

/// What no order can do without, mm: chords that turn twice the angle, the controller's resolution, rounding.
fn rounding_mm(machine: &MachineProfile) -> f64 {
    4.0 * machine.arc_tolerance_mm + resolution_mm(machine) + LATTICE_MM
}

/// Half a step on both axes where it goes, and where it is reported; half the last digit; mm.
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

/// Straight motions are clear of straight edges, by big integers.
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

/// Each curve begins where the one before it ends, the first at the end of the last.
fn closes(pass: &Pass) {
    for each in &pass.path.loops {
        let next = each.curves.iter().cycle().skip(1);
        let jump = each.curves.iter().zip(next).find(|(one, next)| one.to() != next.from());
        assert!(jump.is_none() && !each.curves.is_empty(), "the path has a jump: {jump:?}");
    }
}

/// The part is on the left of most of each loop: from the middle of a motion it is nearer on that side. In a slot as wide as the tool it
/// is as near on both.
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

/// A place beside an edge at the path's distance, and at no smaller one from any other edge, is on the true offset.
fn reaches_all(plan: &CertifiedPlan, pass: &Pass) {
    let threshold = plan.finishing.plus(pass.stock_to_leave).expect("it was certified");
    let loops = plan.plan.profile.loops.iter().chain(&plan.plan.zones.loops);
    let room = loops.flat_map(|each| &each.edges).map(|edge| edge.chord_error.units()).max().unwrap_or(0);
    let d = f64::from(threshold.units()) + PATH_CLEARANCE + f64::from(room);
    // Edges that stand for splines may leave them; what is nearly a corner is no place to ask at.
    let apart = 2.0 * (ROUNDING + f64::from(room));
    for curve in walls(plan) {
        for (place, normal) in places(curve).into_iter().zip(normals(curve)) {
            for side in [d, -d] {
                let beside = (place.0 + normal.0 * side, place.1 + normal.1 * side);
                let others = walls(plan).filter(|other| *other != curve);
                if keepout_kernel::curve::nearest_point(beside.0, beside.1).is_err()
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

/// Splines and ellipses are no farther from the edges that stand for them than these say.
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

/// Places on a rational Bézier curve, its ends among them (de Casteljau, in homogeneous coordinates).
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

/// Whether a place is in the part or a zone: loops are counted that wind around it. It is off every edge.
fn is_in_part(plan: &CertifiedPlan, place: Xy) -> bool {
    let winds = |each: &ProfileLoop| winds(each.edges.iter().map(|edge| &edge.curve), place);
    let around = |each: &&ProfileLoop| winds(each);
    let enclosed = plan.plan.profile.loops.iter().filter(around).count() % 2 == 1;
    let part = enclosed == (plan.plan.side == MachinedSide::Outside);
    part || plan.plan.zones.loops.iter().any(winds)
}

/// Whether a loop goes round the place, once one way or the other: the angles that its curves turn through as seen from there.
pub fn winds<'a>(curves: impl Iterator<Item = &'a Curve>, place: Xy) -> bool {
    let angle = |curve: &Curve| {
        let seen = |end: Xy| (end.0 - place.0, end.1 - place.1);
        let (a, b) = (seen(xy(curve.from())), seen(xy(curve.to())));
        // On the chord's line counts as left of it; -0 would be the other half-turn.
        let across = a.0 * b.1 - a.1 * b.0 + 0.0;
        let chord = across.atan2(a.0 * b.0 + a.1 * b.1);
        let Curve::Arc(arc) = curve else { return chord };
        // Between the chord and the arc it is once more.
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

/// The place at a share of the way.
pub fn on_the_way(a: Xy, b: Xy, share: f64) -> Xy {
    (a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share)
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

/// From the beginning of the arc to the angle, in its direction, in [0, 2π).
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

/// So many places along the curve.
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

//! Crafted plans, which no drawing produces: their claims could pass a weak check, but not be true of the
//! part. A review found them.

use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::{Arc, Curve, Length, Point, Segment, Turn, Vec2};
use keepout_planner::Mm2;
use keepout_planner::finish::{FinishingLoop, PathRefusal};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{
    CertifiedPlan, PASSES_MAX, Plan, PlanError, PlanGeometry, PlanParameters, Provenance,
};
use keepout_planner::plan_file;
use keepout_planner::profile::{MachinedSide, Profile, ProfileEdge, ProfileError, ProfileLoop, SourceCurve};

#[expect(clippy::unwrap_used, reason = "the test gives valid coordinates")]
fn at(x_mm: f64, y_mm: f64) -> Point {
    keepout_planner::units::point_from_mm(Mm2::new(x_mm, y_mm)).unwrap()
}

#[expect(clippy::unwrap_used, reason = "the test gives valid chord errors")]
fn polygon(corners: &[Point], chord_error: i64) -> ProfileLoop {
    let chord_error = Length::from_units(chord_error).unwrap();
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    let edge = |(&from, &to)| ProfileEdge { curve: Curve::Line(Segment { from, to }), chord_error };
    ProfileLoop { edges: ends.map(edge).collect(), sources: Vec::new() }
}

fn round(radius_mm: f64, count: u32) -> ProfileLoop {
    let angle = |k: u32| f64::from(k) * std::f64::consts::TAU / f64::from(count);
    let corners: Vec<Point> =
        (0..count).map(|k| at(radius_mm * angle(k).cos(), radius_mm * angle(k).sin())).collect();
    polygon(&corners, 0)
}

fn square() -> ProfileLoop {
    polygon(&[at(-20.0, -20.0), at(20.0, -20.0), at(20.0, 20.0), at(-20.0, 20.0)], 0)
}

fn make(
    loops: Vec<ProfileLoop>,
    side: MachinedSide,
    tool_diameter_mm: f64,
) -> Result<CertifiedPlan, PlanError> {
    let geometry = PlanGeometry { profile: Profile { loops }, ..PlanGeometry::default() };
    let job = PlanParameters { side, tool_diameter_mm, ..PlanParameters::default() };
    Plan::make(Provenance::default(), geometry, &job, &MachineProfile::simulated(), &mut |_| {})
}

/// The plan after a round trip through its file, certified again.
#[expect(clippy::unwrap_used, reason = "the test reads the file that it wrote")]
fn certified_from_file(plan: &Plan) -> Result<CertifiedPlan, PlanError> {
    plan_file::decode(&plan_file::encode(plan).unwrap()).unwrap().certify()
}

fn refusal(plan: &Plan) -> PathRefusal {
    match error_of(certified_from_file(plan), "a wrong plan") {
        PlanError::Pass { refusal, .. } => refusal,
        other => panic!("{other}"),
    }
}

/// A printed name must not imitate the line that states a proof.
#[test]
fn names_with_control_characters_are_refused() {
    let good = make(vec![square()], MachinedSide::Outside, 4.0).expect("a square").plan;
    let wrong = |change: &dyn Fn(&mut Plan)| {
        let mut wrong = good.clone();
        change(&mut wrong);
        plan_file::decode(&plan_file::encode(&wrong).expect("it can be written"))
            .expect_err("a terminal cannot show it")
            .to_string()
    };
    let error = wrong(&|plan| plan.provenance.name = "x\nproved  all\u{1b}[8m".into());
    assert!(error.contains("control characters"), "{error}");
    let error = wrong(&|plan| plan.provenance.remarks.push("\r".to_string().into()));
    assert!(error.contains("control characters"), "{error}");
    let error = wrong(&|plan| plan.machine.name.push('\n'));
    assert!(error.contains("name must be"), "{error}");
}

/// Holes that a CAD system has flattened. The offset of each edge is shorter than the longest stretch that
/// the check may miss.
#[test]
fn missing_loop_in_a_hole_of_many_short_edges_is_refused() {
    for (radius, count) in [(3.25, 126), (3.3, 126), (3.5, 180), (4.0, 360)] {
        let mut wrong = make(vec![square(), round(radius, count)], MachinedSide::Outside, 6.0).unwrap().plan;
        let small =
            |each: &FinishingLoop| each.curves.iter().all(|curve| curve.from().x.units().abs() < 1_000_000);
        let before = wrong.finish().loops.len();
        wrong.passes[0].path_mut().loops.retain(|each| !small(each));
        assert_eq!(wrong.finish().loops.len() + 1, before);
        assert!(matches!(refusal(&wrong), PathRefusal::Incomplete(_)), "{radius} {count}");
        let mut none = make(vec![round(radius, count)], MachinedSide::Inside, 6.0).unwrap().plan;
        none.passes[0].path_mut().loops.clear();
        assert!(matches!(refusal(&none), PathRefusal::Incomplete(_)), "{radius} {count}, no path at all");
    }
}

#[test]
fn path_too_far_from_the_wall_of_such_a_hole_is_refused() {
    let good = make(vec![round(3.3, 126)], MachinedSide::Inside, 6.0).unwrap().plan;
    for inward in [200.0, 1_000.0, 5_000.0, 20_000.0] {
        let mut wrong = good.clone();
        let moved = |p: Point| {
            let Vec2 { x, y } = keepout_kernel::Vec2::from(p);
            let share = 1.0 - inward / x.hypot(y);
            keepout_kernel::curve::nearest_point(Vec2::new(x * share, y * share)).unwrap()
        };
        let each = &mut wrong.passes[0].path_mut().loops[0];
        let corners: Vec<Point> = each.curves.iter().map(|curve| moved(curve.from())).collect();
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        each.curves = ends.map(|(&from, &to)| Curve::Line(Segment { from, to })).collect();
        assert!(matches!(refusal(&wrong), PathRefusal::Incomplete(_)), "{inward} units");
    }
}

/// A disc with teeth of 10 µm all round.
#[test]
fn missing_path_around_a_serrated_disc_is_refused() {
    let teeth = 1_200_u32;
    let corner = |k: u32| {
        let angle = f64::from(k) * std::f64::consts::TAU / f64::from(2 * teeth);
        let r = if k.is_multiple_of(2) { 2.0 } else { 1.993 };
        at(r * angle.cos(), r * angle.sin())
    };
    let corners: Vec<Point> = (0..2 * teeth).map(corner).collect();
    let mut wrong = make(vec![polygon(&corners, 0)], MachinedSide::Outside, 1.0).unwrap().plan;
    wrong.passes[0].path_mut().loops.clear();
    assert!(matches!(refusal(&wrong), PathRefusal::Incomplete(_)));
}

#[test]
fn chord_error_without_a_source_curve_is_refused() {
    for edge in 0..4 {
        let mut each = square();
        each.edges[edge].chord_error = Length::from_units(500).unwrap();
        let error = error_of(make(vec![each], MachinedSide::Outside, 6.0), "no source");
        assert!(matches!(error, PlanError::Profile(ProfileError::Curve { .. })), "{error}");
    }
}

fn straight_source(from: Point, to: Point, first: usize, end: usize) -> SourceCurve {
    let curve = Bezier::new(vec![from, to], vec![1 << 30; 2]).expect("two points");
    SourceCurve { curve, first, end }
}

/// A straight source curve for edges that run through a neck 80 nm wide, around a pocket and back. By the
/// source curve, the pocket is material of the part.
#[test]
fn source_curve_across_the_neck_of_a_pocket_is_refused() {
    let g = 0.000_04;
    let corners = [
        at(-40.0, 20.0),
        at(-40.0, -20.0),
        at(40.0, -20.0),
        at(40.0, 20.0),
        at(g, 20.0),
        at(g, 19.0),
        at(10.0, 10.0),
        at(10.0, -10.0),
        at(-10.0, -10.0),
        at(-10.0, 10.0),
        at(-g, 19.0),
        at(-g, 20.0),
    ];
    let mut each = polygon(&corners, 0);
    let count = each.edges.len();
    each.edges[3..].iter_mut().for_each(|edge| edge.chord_error = Length::small(100));
    each.sources.push(straight_source(at(40.0, 20.0), at(-40.0, 20.0), 3, count));
    let error = error_of(make(vec![each], MachinedSide::Outside, 6.0), "the source does not follow");
    assert!(matches!(error, PlanError::Profile(ProfileError::Curve { .. })), "{error}");
}

#[test]
fn source_curves_that_are_points_or_overlap_are_refused() {
    let mut each = square();
    each.edges.iter_mut().for_each(|edge| edge.chord_error = Length::small(100));
    let corner = at(-20.0, -20.0);
    each.sources.push(straight_source(corner, corner, 0, 4));
    assert!(make(vec![each.clone()], MachinedSide::Outside, 6.0).is_err(), "a point for an outline");
    each.sources.clear();
    each.edges.iter_mut().skip(1).for_each(|edge| edge.chord_error = Length::ZERO);
    each.sources = vec![straight_source(corner, at(20.0, -20.0), 0, 1)];
    assert!(make(vec![each.clone()], MachinedSide::Outside, 6.0).is_ok(), "one edge, one source");
    each.sources.push(each.sources[0].clone());
    assert!(make(vec![each.clone()], MachinedSide::Outside, 6.0).is_err(), "the same edge twice");
    for (first, end) in [(1, 0), (0, 9), (usize::MAX, usize::MAX), (4, 4)] {
        each.sources = vec![straight_source(corner, at(20.0, -20.0), first, end)];
        assert!(make(vec![each.clone()], MachinedSide::Outside, 6.0).is_err(), "{first}..{end}");
    }
}

/// Shallow hollows whose edges have a coarse chord-error bound. The path along them is complete.
#[test]
fn paths_along_hollows_with_a_coarse_bound_are_complete() {
    for (degrees, chord_error) in [(2.0_f64, 100), (2.0, 200), (10.0, 1_000), (20.0, 1_000), (40.0, 1_000)] {
        let high = 20.0 * (degrees.to_radians() / 2.0).tan();
        let corners = [at(-20.0, -20.0), at(20.0, -20.0), at(20.0, high), at(0.0, 0.0), at(-20.0, high)];
        let mut each = polygon(&corners, chord_error);
        for i in 0..corners.len() {
            let (from, to) = (corners[i], corners[(i + 1) % corners.len()]);
            each.sources.push(straight_source(from, to, i, i + 1));
        }
        if let Err(error) = make(vec![each], MachinedSide::Outside, 6.0) {
            panic!("{degrees}°, chord error {chord_error}: {error}");
        }
    }
}

#[test]
fn empty_loops_and_too_many_passes_are_refused() {
    let good = make(vec![square()], MachinedSide::Outside, 6.0).unwrap().plan;
    let mut wrong = good.clone();
    wrong.passes[0].path_mut().loops.push(FinishingLoop { curves: Vec::new(), component: 0 });
    assert!(matches!(refusal(&wrong), PathRefusal::OpenLoop { number: 2 }));
    let mut wrong = good;
    wrong.passes = vec![wrong.passes[0].clone(); PASSES_MAX + 1];
    assert!(matches!(certified_from_file(&wrong), Err(PlanError::PassCount { .. })));
}

/// Thousands of arcs of a radius of metres. The check refuses them before their chords fill the memory.
#[test]
fn thousands_of_huge_arcs_are_refused() {
    let (a, b) = (Point::from_units(0, 270_000_000).unwrap(), Point::from_units(0, -270_000_000).unwrap());
    let half = |from, to| {
        let arc = Arc::new(from, to, Point::ORIGIN, Turn::CounterClockwise).expect("half a circle");
        ProfileEdge { curve: Curve::Arc(arc), chord_error: Length::ZERO }
    };
    let edges = (0..4_000).map(|k| if k % 2 == 0 { half(a, b) } else { half(b, a) }).collect();
    let each = ProfileLoop { edges, sources: Vec::new() };
    assert!(make(vec![each], MachinedSide::Outside, 6.0).is_err());
}

/// The error. A result without an error is too long to print.
fn error_of<T, E>(result: Result<T, E>, what: &str) -> E {
    match result {
        Err(error) => error,
        Ok(_) => panic!("{what} was accepted"),
    }
}

// Evidence for SR-20.
#[test]
fn files_of_other_versions_are_refused() {
    let good = make(vec![square()], MachinedSide::Outside, 4.0).expect("a square").plan;
    let bytes = plan_file::encode(&good).expect("it can be written");
    // Behind "KEEPOUT PLAN".
    let version = 12;
    for other in [plan_file::VERSION - 1, plan_file::VERSION + 1, 0] {
        let mut wrong = bytes.clone();
        wrong[version..version + 2].copy_from_slice(&other.to_le_bytes());
        let error = plan_file::decode(&wrong).expect_err("another version");
        assert!(matches!(error, plan_file::PlanFileError::Version { found } if found == other), "{error}");
    }
}

// Evidence for SR-20, SR-29.
#[test]
fn impossible_machines_in_a_plan_file_are_refused() {
    let good = make(vec![square()], MachinedSide::Outside, 4.0).expect("a square").plan;
    let changes: [fn(&mut MachineProfile); 3] = [
        |machine| machine.steps_per_mm = 1e15,
        |machine| machine.max_rate_mm_s = -1.0,
        |machine| machine.repeatability_mm = f64::NAN,
    ];
    for change in changes {
        let mut wrong = good.clone();
        change(&mut wrong.machine);
        let bytes = plan_file::encode(&wrong).expect("it can be written");
        assert!(plan_file::decode(&bytes).is_err(), "{:?}", wrong.machine);
    }
}

/// The curve leaves one edge by more than that edge's own bound, and by less than the bound of the other.
// Evidence for SR-02.
#[test]
fn a_source_is_checked_against_the_least_bound_of_its_edges() {
    let (from, middle, to) = (at(20.0, -20.0), at(20.0, 0.0), at(20.0, 20.0));
    let bulge = at(20.05, 0.0);
    let curve = Bezier::new(vec![from, bulge, to], vec![1 << 30; 3]).expect("three points");
    for (errors, fits) in [([5000, 5000], true), ([5000, 100], false), ([100, 5000], false)] {
        let mut each = polygon(&[at(-20.0, -20.0), from, middle, to, at(-20.0, 20.0)], 0);
        for (edge, units) in each.edges[1..3].iter_mut().zip(errors) {
            edge.chord_error = Length::from_units(units).expect("a length");
        }
        each.sources.push(SourceCurve { curve: curve.clone(), first: 1, end: 3 });
        assert_eq!(make(vec![each], MachinedSide::Outside, 6.0).is_ok(), fits, "{errors:?}");
    }
}

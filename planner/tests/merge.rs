//! Merged motions stay within the promised distance of the path that they replace, in both directions, on
//! random loops. Certified plans of random drawings have no more motions than the path before merging.
#![expect(clippy::unwrap_used, reason = "a test helper may panic")]

use std::f64::consts::TAU;
use std::fmt::Write as _;

use keepout_kernel::curve::{fit_arc, nearest_point, radius};
use keepout_kernel::{Curve, Point, Segment, Turn, Vec2};
use keepout_planner::Mm2;
use keepout_planner::finish::{centre_distance, propose};
use keepout_planner::machine::MachineProfile;
use keepout_planner::merge::{INWARD, OUTWARD, merged_loop};
use keepout_planner::plan::{CertifiedPlan, PlanParameters};
use keepout_planner::profile::{MachinedSide, Profile, free_outlines};
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{along_mm, mm, point_mm};
use proptest::prelude::{Strategy, proptest};
use proptest::test_runner::Config;

/// Number of intervals between the sample points of each motion.
const PLACES: u32 = 40;
/// Rounding, lattice units.
const TOLERANCE: f64 = 5.0;

/// `count` points on a wavy closed curve, counter-clockwise, lattice units.
fn wave(count: u32, size: f64, waves: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let place = |k: u32| {
        let a = TAU * f64::from(k) / f64::from(count);
        let add =
            |(order, (height, phase)): (f64, &(f64, f64))| height / order / order * (order * a + phase).sin();
        let r = size * (1.0 + (2..).map(f64::from).zip(waves).map(add).sum::<f64>());
        (r * a.cos(), r * a.sin())
    };
    (0..count).map(place).collect()
}

/// A loop of lines between the places. At each multiple of `arcs`, an arc through three places replaces two
/// lines.
fn loop_through(places: &[(f64, f64)], arcs: usize) -> Vec<Curve> {
    let points: Vec<Point> = places.iter().map(|&(x, y)| nearest_point(Vec2::new(x, y)).unwrap()).collect();
    let mut curves = Vec::new();
    let mut k = 0;
    while k < points.len() {
        let at = |i: usize| points[(k + i) % points.len()];
        let arc =
            if k % arcs == 0 && k + 2 <= points.len() { arc_through(at(0), at(1), at(2)) } else { None };
        let line = Curve::Line(Segment { from: at(0), to: at(1) });
        k += if arc.is_some() { 2 } else { 1 };
        curves.push(arc.unwrap_or(line));
    }
    curves
}

fn arc_through(from: Point, by: Point, to: Point) -> Option<Curve> {
    let (a, b, c) = (Vec2::from(from), Vec2::from(by), Vec2::from(to));
    let (u, v) = (b - a, c - a);
    let twice = 2.0 * u.cross(v);
    let centre = a + (u.left() * v.dot(v) - v.left() * u.dot(u)) / twice;
    let turn = if twice > 0.0 { Turn::CounterClockwise } else { Turn::Clockwise };
    let large = centre.distance(a) > 1e8 || !twice.is_normal();
    fit_arc(from, to, centre, turn).ok().filter(|_| !large).map(Curve::Arc)
}

/// Sample points on the curve with both its ends, mm.
fn places_on(curve: &Curve) -> Vec<Mm2> {
    let place = |k: u32| along_mm(curve, f64::from(k) / f64::from(PLACES)).0;
    (0..=PLACES).map(place).collect()
}

/// The distance of a place (mm) to the right of the curve, lattice units. For a place beyond the ends, the
/// distance from the nearer end.
fn right_of(Mm2 { x, y }: Mm2, curve: &Curve) -> f64 {
    let p = Vec2::new(x, y) / mm(1);
    let (a, b) = (Vec2::from(curve.from()), Vec2::from(curve.to()));
    let far = |q: Vec2| p.distance(q);
    let side = |a: Vec2, b: Vec2| (b - a).cross(p - a);
    let at_end = far(a).min(far(b));
    match curve {
        Curve::Line(_) => {
            let n = p.nearest_on(a, b);
            if n == a || n == b { at_end } else { -side(a, b) / a.distance(b) }
        }
        Curve::Arc(arc) => {
            let c = Vec2::from(arc.centre());
            let sign = if arc.turn() == Turn::CounterClockwise { 1.0 } else { -1.0 };
            // All arcs here turn by less than half a turn.
            let within = sign * side(c, a) >= 0.0 && sign * side(c, b) <= 0.0;
            if within { sign * (far(c) - radius(arc)) } else { at_end }
        }
    }
}

/// The distance of each place to the right of the nearest curve.
fn beside<'a>(places: &'a [Mm2], curves: &'a [&Curve]) -> impl Iterator<Item = f64> + 'a {
    places.iter().map(|&p| {
        let each = curves.iter().map(|curve| right_of(p, curve));
        each.min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap()
    })
}

/// Checks the promises of merging: a closed loop, no more motions, joints at joints of the path, distances.
fn check(before: &[Curve], after: &[Curve]) {
    assert!(after.len() <= before.len() && after.len() >= 2.min(before.len()));
    let next = after.iter().cycle().skip(1);
    assert!(after.iter().zip(next).all(|(curve, next)| curve.to() == next.from()));
    let start = before.iter().position(|curve| curve.from() == after[0].from()).unwrap();
    let mut left = before[start..].iter().chain(&before[..start]);
    for curve in after {
        let mut run = vec![];
        while run.last().is_none_or(|last: &&Curve| last.to() != curve.to()) {
            run.push(left.next().expect("merged motions end at joints of the path"));
        }
        if run.len() == 1 {
            assert_eq!(run[0], curve);
            continue;
        }
        for off in beside(&places_on(curve), &run) {
            assert!((-INWARD - TOLERANCE..=OUTWARD + TOLERANCE).contains(&off), "{off} {curve:?} {run:?}");
        }
        let path: Vec<_> = run.iter().flat_map(|each| places_on(each)).collect();
        for off in beside(&path, &[curve]) {
            assert!((-OUTWARD - TOLERANCE..=INWARD + TOLERANCE).contains(&off), "{off} {curve:?} {run:?}");
        }
    }
    assert!(left.next().is_none());
}

fn waves() -> impl Strategy<Value = Vec<(f64, f64)>> {
    proptest::collection::vec((-0.3..0.3, 0.0..TAU), 0..8)
}

proptest! {
    #![proptest_config(Config::with_cases(200))]

    #[test]
    fn merged_loops_stay_near_the_loop_that_they_replace(
        waves in waves(),
        count in 3_u32..400,
        size in 1e3..1e7_f64,
        arcs in 1_usize..9,
        noise in 0.0..40.0_f64,
    ) {
        let mut places = wave(count, size, &waves);
        for (k, place) in (0_u32..).map(f64::from).zip(&mut places) {
            *place = (place.0 + noise * (k * 1.7).sin(), place.1 + noise * (k * 2.9).cos());
        }
        let before = loop_through(&places, arcs);
        check(&before, &merged_loop(&before, &|_| true));
        // The loop stays closed, whichever merged motions the caller refuses.
        check(&before, &merged_loop(&before, &|curve| curve.from().x.units() % 3 == 0));
        assert_eq!(merged_loop(&before, &|_| false).len(), before.len());
    }
}

#[test]
fn fine_loops_become_few_motions_and_corners_stay() {
    let fine = loop_through(&wave(1500, 3e6, &[]), usize::MAX);
    let merged = merged_loop(&fine, &|_| true);
    assert!((4..=6).contains(&merged.len()), "a circle is {} motions", merged.len());
    // A square of short lines: four corners, four lines.
    let side = |k: u32| f64::from(k) * 1e4;
    let (up, down) = (|| (0..100).map(side), || (0..100).map(|k| 1e6 - side(k)));
    let square: Vec<(f64, f64)> = up()
        .map(|x| (x, 0.0))
        .chain(up().map(|y| (1e6, y)))
        .chain(down().map(|x| (x, 1e6)))
        .chain(down().map(|y| (0.0, y)))
        .collect();
    assert_eq!(merged_loop(&loop_through(&square, usize::MAX), &|_| true).len(), 4);
    // Corners between chords that turn by four degrees stay.
    let coarse = loop_through(&wave(90, 3e6, &[]), usize::MAX);
    assert_eq!(merged_loop(&coarse, &|_| true), coarse);
    assert_eq!(merged_loop(&[], &|_| true), []);
}

fn planned(dxf: &str, tool_diameter_mm: f64, side: MachinedSide) -> Option<CertifiedPlan> {
    let request = PlanRequest {
        job: PlanParameters { tool_diameter_mm, side, ..PlanParameters::default() },
        ..PlanRequest::default()
    };
    request.plan("", dxf.as_bytes(), &MachineProfile::simulated(), &mut |_| {}).ok()
}

/// Number of motions of the plan, and of the path before merging.
fn motions(plan: &CertifiedPlan) -> (usize, usize) {
    let (profile, none) = (&plan.plan.profile, Profile::default());
    let outlines = free_outlines(profile, &none, &plan.part);
    let d = centre_distance(profile, &none, plan.finishing);
    let found = propose(&outlines, &plan.part, d, 1.0).unwrap();
    (plan.certified_motions, found.loops.iter().map(|each| each.curves.len()).sum())
}

fn dxf_of(entity: &str) -> String {
    format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n\
         0\nSECTION\n2\nENTITIES\n{entity}0\nENDSEC\n0\nEOF\n"
    )
}

fn polyline(places: &[(f64, f64)]) -> String {
    let mut text = format!("0\nLWPOLYLINE\n8\n0\n90\n{}\n70\n1\n", places.len());
    for (x, y) in places {
        let _ = write!(text, "10\n{:.5}\n20\n{:.5}\n", x / 1e5, y / 1e5);
    }
    dxf_of(&text)
}

fn spline(places: &[(f64, f64)]) -> String {
    let mut text = String::from("0\nSPLINE\n8\n0\n70\n3\n71\n3\n");
    for k in 0..places.len() + 7 {
        let _ = write!(text, "40\n{k}.0\n");
    }
    for (x, y) in places.iter().chain(&places[..3]) {
        let _ = write!(text, "10\n{:.5}\n20\n{:.5}\n30\n0.0\n", x / 1e5, y / 1e5);
    }
    dxf_of(&text)
}

proptest! {
    #![proptest_config(Config::with_cases(40))]

    /// Each plan is certified when it is made, so merging removes motions but no part of the contour.
    #[test]
    fn plans_of_random_drawings_have_no_more_motions_after_merging(
        waves in waves(),
        count in 8_u32..500,
        size in 5e5..5e6_f64,
        tool_mm in 0.5..8.0_f64,
    ) {
        let places = wave(count, size, &waves);
        let control = wave(count.min(40), size, &waves);
        for side in [MachinedSide::Outside, MachinedSide::Inside] {
            for dxf in [polyline(&places), spline(&control)] {
                let Some(plan) = planned(&dxf, tool_mm, side) else { continue };
                let (merged, found) = motions(&plan);
                assert!(merged <= found, "{merged} of {found}");
            }
        }
    }
}

/// A contour of 1,510 chords of 0.12 mm with five decimals. Both sides take at most 100 motions.
#[test]
fn contours_of_short_chords_are_cut_in_few_motions() {
    let places = wave(1510, 3e6, &[(0.1, 0.3), (0.1, 2.0), (0.2, 1.0)]);
    for side in [MachinedSide::Outside, MachinedSide::Inside] {
        let (merged, found) = motions(&planned(&polyline(&places), 3.0, side).unwrap());
        assert!(found >= 1510 && merged <= 100, "{side:?}: {merged} of {found}");
    }
}

#[test]
fn merging_keeps_the_path_length() {
    let plan = planned(&polyline(&wave(1510, 3e6, &[])), 3.0, MachinedSide::Outside).unwrap();
    let radius_mm = 30.0 + mm(plan.finishing.units());
    let length_mm = plan.plan.finish().length_mm();
    assert!((length_mm - TAU * radius_mm).abs() < 0.02, "{length_mm}");
    let start = plan.plan.finish().loops[0].curves[0].from();
    let Mm2 { x, y } = point_mm(start);
    assert!((x.hypot(y) - radius_mm).abs() < 0.002);
}

//! Offsets with known lengths, loops and rest material, and the certificates that refuse wrong ones.
#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "a helper of a test may stop it; shapes are drawn in f64"
)]

use std::f64::consts::PI;

use keepout_kernel::offset::{
    CutContour, Offset, OffsetLoop, Outline, RESOLUTION, certify_complete, certify_path, propose,
};
use keepout_kernel::{Arc, Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, Turn, Vec2};

const MM: i64 = 100_000;

fn at(x: i64, y: i64) -> Point {
    Point::from_units(x * MM, y * MM).unwrap()
}

fn polygon(points: &[Point]) -> Vec<Curve> {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(&from, &to)| Curve::Line(Segment { from, to })).collect()
}

fn circle(centre: Point, radius: i64) -> Vec<Curve> {
    let (x, y) = (i64::from(centre.x.units()), i64::from(centre.y.units()));
    let east = Point::from_units(x + radius * MM, y).unwrap();
    let west = Point::from_units(x - radius * MM, y).unwrap();
    let half = |from, to| Curve::Arc(Arc::new(from, to, centre, Turn::CounterClockwise).unwrap());
    vec![half(east, west), half(west, east)]
}

fn part_of(outlines: &[Vec<Curve>], side: Side) -> ProhibitedRegion {
    let chord_error = Length::from_units(10).unwrap();
    let ring = |curves: &Vec<Curve>| {
        let pieces: Vec<_> =
            curves.iter().map(|curve| curve.piece(chord_error, Length::ZERO).unwrap()).collect();
        Ring::from_pieces(&pieces).unwrap()
    };
    ProhibitedRegion::new(Region::new(outlines.iter().map(ring).collect()).unwrap(), side).unwrap()
}

/// A counter-clockwise outline with the material inside.
fn outside(curves: Vec<Curve>) -> Outline {
    Outline { curves, free_on_left: false }
}

/// A counter-clockwise outline with the material outside.
fn inside(curves: Vec<Curve>) -> Outline {
    Outline { curves, free_on_left: true }
}

fn length_mm(offset: &Offset, which: usize) -> f64 {
    offset.loops[which].curves.iter().map(Curve::length).sum::<f64>() / 1e5
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() < tolerance, "{a} is not {b}");
}

#[test]
fn square_gets_round_joins_as_true_arcs() {
    let square = polygon(&[at(0, 0), at(40, 0), at(40, 30), at(0, 30)]);
    let offset = propose(&[outside(square.clone())], 3e5);
    assert!(offset.loose_ends.is_empty());
    assert_eq!(offset.loops.len(), 1);
    let arcs = offset.loops[0].curves.iter().filter(|curve| matches!(curve, Curve::Arc(_))).count();
    assert_eq!((offset.loops[0].curves.len(), arcs), (8, 4));
    close(length_mm(&offset, 0), 140.0 + 2.0 * PI * 3.0, 1e-4);
    close(offset.loops[0].cut.double_area() / 2e10, 1200.0, 1e-6);
}

#[test]
fn inside_corner_leaves_the_known_rest_material() {
    // A right-angled inside corner leaves an area of r²(1 − π/4).
    let l = polygon(&[at(0, 0), at(40, 0), at(40, 15), at(15, 15), at(15, 40), at(0, 40)]);
    let part = CutContour::of(&outside(l.clone()));
    let offset = propose(&[outside(l)], 3e5);
    assert_eq!(offset.loops.len(), 1);
    let rest = offset.loops[0].cut.double_area() - part.double_area();
    close(rest / 2e10, 9.0 * (1.0 - PI / 4.0), 1e-6);
}

#[test]
fn hole_is_offset_inward_and_vanishes_when_too_small() {
    let offset = propose(&[inside(circle(at(5, 5), 5))], 3e5);
    assert_eq!(offset.loops.len(), 1);
    close(length_mm(&offset, 0), 2.0 * PI * 2.0, 1e-4);
    assert!(propose(&[inside(circle(at(5, 5), 3))], 3e5).loops.is_empty());
}

#[test]
fn narrow_waist_splits_the_pocket_in_two() {
    // Two rooms of 20 × 20 mm with a passage 4 mm wide: a tool of 3 mm radius does not pass.
    let dumbbell = polygon(&[
        at(0, 0),
        at(20, 0),
        at(20, 8),
        at(30, 8),
        at(30, 0),
        at(50, 0),
        at(50, 20),
        at(30, 20),
        at(30, 12),
        at(20, 12),
        at(20, 20),
        at(0, 20),
    ]);
    let wide = propose(&[inside(dumbbell.clone())], 1e5);
    assert_eq!(wide.loops.len(), 1);
    let narrow = propose(&[inside(dumbbell)], 3e5);
    assert!(narrow.loose_ends.is_empty(), "{:?}", narrow.loose_ends);
    assert_eq!(narrow.loops.len(), 2);
}

#[test]
fn near_parts_share_one_path_and_far_parts_have_their_own() {
    let pair = |gap: i64| {
        let left = polygon(&[at(0, 0), at(10, 0), at(10, 10), at(0, 10)]);
        let x = 10 + gap;
        let right = polygon(&[at(x, 0), at(x + 10, 0), at(x + 10, 10), at(x, 10)]);
        propose(&[outside(left), outside(right)], 3e5)
    };
    assert_eq!(pair(5).loops.len(), 1);
    assert_eq!(pair(7).loops.len(), 2);
}

#[test]
fn certificate_holds_for_the_proposal_and_refuses_a_moved_one() {
    let shape = [outside(polygon(&[at(0, 0), at(40, 0), at(40, 15), at(15, 15), at(15, 40), at(0, 40)]))];
    let part = part_of(&[shape[0].curves.clone()], Side::Outside);
    let offset = propose(&shape, 3e5 + 60.0);
    let threshold = Length::from_units(300_000).unwrap();
    let path = &offset.loops[0].curves;
    assert!(certify_path(&part, threshold, path).unwrap().is_some());
    // A chord in place of an arc cuts the corner.
    let mut cut = path.clone();
    let arc = cut.iter().position(|curve| matches!(curve, Curve::Arc(_))).unwrap();
    cut[arc] = Curve::Line(Segment { from: cut[arc].from(), to: cut[arc].to() });
    assert_eq!(certify_path(&part, threshold, &cut).unwrap_err().index, arc);
    // An offset 1.4 µm inside the threshold is too near.
    let nearer = propose(&shape, 3e5 - 140.0);
    assert!(certify_path(&part, threshold, &nearer.loops[0].curves).is_err());
    // A missing motion is a gap.
    let mut gap = path.clone();
    gap.remove(1);
    assert_eq!(certify_path(&part, threshold, &gap).unwrap_err().index, 1);
}

#[test]
fn circles_of_all_sizes_certify() {
    for radius in [1, 2, 10, 100, 1000] {
        let shape = [outside(circle(at(3, 4), radius))];
        let part = part_of(&[shape[0].curves.clone()], Side::Outside);
        let offset = propose(&shape, 3e5 + 60.0);
        let threshold = Length::from_units(300_000).unwrap();
        certify_path(&part, threshold, &offset.loops[0].curves).unwrap();
    }
}

/// Random profiles: both certificates hold for each proposal, and the certificate of coverage finds a missing
/// loop.
#[test]
fn certificates_hold_both_ways_and_a_missing_loop_is_found() {
    let mut random = fastrand::Rng::with_seed(31);
    let mut loops_seen = 0;
    for case in 0..60 {
        let corners = random.usize(5..60);
        let share = |k: usize| std::f64::consts::TAU * k as f64 / corners as f64;
        let radius: Vec<f64> = (0..corners).map(|_| 1e5 * (8.0 + 40.0 * random.f64())).collect();
        let vertex = |k: usize| {
            let (sine, cosine) = share(k).sin_cos();
            keepout_kernel::curve::nearest_point(Vec2::new(radius[k] * cosine, radius[k] * sine)).unwrap()
        };
        let points: Vec<Point> = (0..corners).map(vertex).collect();
        for free_on_left in [false, true] {
            let outlines = [Outline { curves: polygon(&points), free_on_left }];
            let side = if free_on_left { Side::Inside } else { Side::Outside };
            let part = part_of(&[outlines[0].curves.clone()], side);
            let d = f64::from(random.i32(50_000..500_000));
            let offset = propose(&outlines, d + 60.0);
            assert!(offset.loose_ends.is_empty(), "case {case}");
            let threshold = Length::from_units(d as i64).unwrap();
            for each in &offset.loops {
                certify_path(&part, threshold, &each.curves).unwrap();
            }
            certify_complete(&part, &outlines, d + 60.0, CHORDS, curves(&offset.loops)).unwrap();
            for left_out in 0..offset.loops.len() {
                let mut loops = offset.loops.clone();
                let gone = loops.remove(left_out);
                let length: f64 = gone.curves.iter().map(Curve::length).sum();
                loops_seen += 1;
                // A loop of a few micrometres is below the resolution.
                let noticed = certify_complete(&part, &outlines, d + 60.0, CHORDS, curves(&loops)).is_err();
                assert!(noticed || length < 10.0 * RESOLUTION, "case {case}, loop of {length} units");
            }
        }
    }
    assert!(loops_seen > 100, "{loops_seen}");
}

#[test]
fn slots_pockets_and_rounds_are_complete() {
    let dumbbell = |waist: i64| {
        let (a, b) = (10 - waist / 2, 10 + waist - waist / 2);
        let at = |x: i64, y: i64| Point::from_units(x * MM, y * MM).unwrap();
        let points = [
            at(0, 0),
            at(20, 0),
            at(20, a),
            at(30, a),
            at(30, 0),
            at(50, 0),
            at(50, 20),
            at(30, 20),
            at(30, b),
            at(20, b),
            at(20, 20),
            at(0, 20),
        ];
        polygon(&points)
    };
    let shapes = [dumbbell(4), dumbbell(6), dumbbell(8), circle(at(5, 5), 9), circle(at(5, 5), 30)];
    for (case, shape) in shapes.into_iter().enumerate() {
        for (free_on_left, side) in [(false, Side::Outside), (true, Side::Inside)] {
            // The radius is 3 mm: the waist of 6 mm is exactly as wide as the tool, met from both sides.
            for d in [299_940.0, 300_000.0, 300_060.0] {
                let outlines = [Outline { curves: shape.clone(), free_on_left }];
                let part = part_of(std::slice::from_ref(&shape), side);
                let offset = propose(&outlines, d);
                certify_complete(&part, &outlines, d, CHORDS, curves(&offset.loops)).unwrap_or_else(
                    |missing| {
                        panic!("shape {case}, {side:?}, d {d}: {missing}; loose {:?}", offset.loose_ends)
                    },
                );
            }
        }
    }
}

// Evidence for SR-20.
/// A profile of edges shorter than the resolution, without a loop, is not complete. Neither is an arc whose
/// loop is its chord.
#[test]
fn missing_loops_are_found_along_short_edges_and_long_arcs() {
    let corner = |k: u32| {
        let phi = f64::from(k) * std::f64::consts::TAU / 628.0;
        keepout_kernel::curve::nearest_point(Vec2::new(1e5 * phi.cos(), 1e5 * phi.sin())).unwrap()
    };
    let points: Vec<Point> = (0..628).map(corner).collect();
    let outlines = [Outline { curves: polygon(&points), free_on_left: false }];
    let part = part_of(&[outlines[0].curves.clone()], Side::Outside);
    assert!(certify_complete(&part, &outlines, 1e5, CHORDS, curves(&[])).is_err());
    let offset = propose(&outlines, 1e5);
    certify_complete(&part, &outlines, 1e5, CHORDS, curves(&offset.loops)).unwrap();

    let round = [Outline { curves: circle(at(0, 0), 100), free_on_left: false }];
    let part = part_of(&[round[0].curves.clone()], Side::Outside);
    let mut loops = propose(&round, 3e5).loops;
    certify_complete(&part, &round, 3e5, CHORDS, curves(&loops)).unwrap();
    let straight = |curve: &Curve| Curve::Line(Segment { from: curve.from(), to: curve.to() });
    loops[0].curves = loops[0].curves.iter().map(straight).collect();
    assert!(certify_complete(&part, &round, 3e5, CHORDS, curves(&loops)).is_err());
}

/// Chord error of the arcs in these parts.
const CHORDS: Length = Length::small(20);

fn curves(loops: &[OffsetLoop]) -> impl Iterator<Item = &Curve> {
    loops.iter().flat_map(|each| &each.curves)
}

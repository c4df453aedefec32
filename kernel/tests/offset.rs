//! Offsets with known answers: lengths, loops, residuals; and the certificate that refuses wrong ones.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::f64::consts::PI;

use keepout_kernel::offset::{Offset, Outline, certify_path, propose};
use keepout_kernel::{Arc, Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, Turn};

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
    let half = |from, to| Curve::Arc(Arc::new(from, to, centre, Turn::Left).unwrap());
    vec![half(east, west), half(west, east)]
}

fn part_of(outlines: &[Vec<Curve>], side: Side) -> ProhibitedRegion {
    let slack = Length::from_units(10).unwrap();
    let ring = |curves: &Vec<Curve>| {
        let pieces: Vec<_> = curves.iter().map(|curve| curve.piece(slack, Length::ZERO).unwrap()).collect();
        Ring::from_pieces(&pieces).unwrap()
    };
    ProhibitedRegion::new(Region::new(outlines.iter().map(ring).collect()).unwrap(), side).unwrap()
}

/// Outlines given counter-clockwise, the material inside.
fn outside(curves: Vec<Curve>) -> Outline {
    Outline { curves, free_on_left: false }
}

/// Outlines given counter-clockwise, the material outside.
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
    close(offset.residual_area, 0.0, 1.0);
    close(offset.touched_length, offset.profile_length, 1.0);
}

#[test]
fn inside_corner_leaves_the_known_residual() {
    // A right inside corner keeps r²(1 − π/4) and 2r of contour.
    let l = polygon(&[at(0, 0), at(40, 0), at(40, 15), at(15, 15), at(15, 40), at(0, 40)]);
    let offset = propose(&[outside(l)], 3e5);
    assert_eq!(offset.loops.len(), 1);
    close(offset.residual_area / 1e10, 9.0 * (1.0 - PI / 4.0), 1e-3);
    close((offset.profile_length - offset.touched_length) / 1e5, 6.0, 1e-3);
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
    // Two rooms of 20 × 20 joined by a passage 4 wide: a 3 mm radius does not pass.
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
    assert_eq!(pair(5).loops[0].outlines, [0, 1]);
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
    // An arc replaced by its chord cuts the corner.
    let mut cut = path.clone();
    let arc = cut.iter().position(|curve| matches!(curve, Curve::Arc(_))).unwrap();
    cut[arc] = Curve::Line(Segment { from: cut[arc].from(), to: cut[arc].to() });
    assert_eq!(certify_path(&part, threshold, &cut).unwrap_err().index, arc);
    // Two micrometres nearer is too near.
    let nearer = propose(&shape, 3e5 - 140.0);
    assert!(certify_path(&part, threshold, &nearer.loops[0].curves).is_err());
    // A motion left out is a jump.
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

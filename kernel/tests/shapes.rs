//! Segments, boxes, convex polygons and curves, compared with their definitions on a small lattice.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use fastrand::Rng;
use keepout_kernel::exact::bezier::{Bezier, DEGREE_MAX, WEIGHTS};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Arc, Convex, Curve, Length, Point, Region, Ring, Segment, Turn};

fn at(x: i64, y: i64) -> Point {
    Point::from_units(x, y).unwrap()
}

fn length(units: i64) -> Length {
    Length::from_units(units).unwrap()
}

fn random_point(random: &mut Rng) -> Point {
    at(random.i64(-9..9), random.i64(-9..9))
}

#[test]
fn polygon_holds_what_is_right_of_no_side() {
    let triangle = [at(0, 0), at(8, 0), at(0, 6)];
    let polygon = Convex::check(&triangle).unwrap();
    for x in -2..11 {
        for y in -2..9 {
            let inside = x >= 0 && y >= 0 && 3 * x + 4 * y <= 24;
            assert_eq!(polygon.holds(at(x, y)), inside, "{x} {y}");
        }
    }
}

/// The distance to the wall is convex along the motion, so it never falls exactly when it does not fall at the start.
#[test]
fn motion_retracts_exactly_when_the_distance_does_not_fall_at_the_start() {
    // The squared distance to the wall, times its squared length.
    let distance = |p: (i128, i128), a: (i128, i128), b: (i128, i128)| {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (wx, wy) = (p.0 - a.0, p.1 - a.1);
        let (along, length_2) = (wx * dx + wy * dy, dx * dx + dy * dy);
        if along <= 0 {
            (wx * wx + wy * wy) * length_2.max(1)
        } else if along >= length_2 {
            ((p.0 - b.0).pow(2) + (p.1 - b.1).pow(2)) * length_2
        } else {
            (dx * wy - dy * wx).pow(2)
        }
    };
    // The start of the motion is a part of it so small that no distance falls and rises again within.
    let parts = 4096;
    let scaled = |(x, y): (i64, i64)| (i128::from(x * parts), i128::from(y * parts));
    let point = |(x, y): (i64, i64)| at(x, y);
    let mut random = Rng::with_seed(5);
    for _ in 0..20_000 {
        let mut pair = || (random.i64(-9..9), random.i64(-9..9));
        let (p, q, a, b) = (pair(), pair(), pair(), pair());
        let (from, wall) = (scaled(p), (scaled(a), scaled(b)));
        let next = (from.0 + i128::from(q.0 - p.0), from.1 + i128::from(q.1 - p.1));
        let falls = distance(next, wall.0, wall.1) < distance(from, wall.0, wall.1);
        let motion = Segment { from: point(p), to: point(q) };
        let wall = Segment { from: point(a), to: point(b) };
        assert_eq!(motion.retracts_from(wall), !falls, "{motion:?} {wall:?}");
    }
}

#[test]
fn box_within_reach_has_all_its_corners_within_reach() {
    let mut random = Rng::with_seed(6);
    for _ in 0..5_000 {
        let (low, high) = (random_point(&mut random), random_point(&mut random));
        let window = Window::of(low).including(high);
        let segment = Segment { from: random_point(&mut random), to: random_point(&mut random) };
        let reach = length(random.i64(0..20));
        let (x0, y0, x1, y1) = window.corners();
        let near = |x: i32, y: i32| !segment.near_point(at(i64::from(x), i64::from(y)), reach).is_clear();
        let all = (x0..=x1).all(|x| (y0..=y1).all(|y| near(x, y)));
        assert_eq!(window.within_reach_of(segment, reach), all, "{window:?} {segment:?}");
        let some = (x0..=x1).any(|x| (y0..=y1).any(|y| near(x, y)));
        assert!(!(some && window.near_segment(segment, reach).is_clear()), "{window:?} {segment:?}");
        let point = random_point(&mut random);
        let (x, y) = (point.x.units(), point.y.units());
        assert_eq!(window.holds(point), (x0..=x1).contains(&x) && (y0..=y1).contains(&y));
    }
}

/// A needle whose long edges cross a few of many short ones: the search for contacts divides the block of short edges,
/// though the long edge is larger.
#[test]
fn needle_into_a_ring_of_short_edges_is_refused() {
    // A ring of 64 edges: a comb of 31 teeth.
    let mut corners = vec![at(0, -10), at(124, -10)];
    for tooth in (0..31).rev() {
        corners.extend([at(tooth * 4 + 3, 5), at(tooth * 4 + 1, 0)]);
    }
    let comb = Ring::new(corners).unwrap();
    let needle = |tip: i64| Ring::new(vec![at(66, tip), at(68, 5_000), at(64, 5_000)]).unwrap();
    for (tip, refused) in [(-4, true), (2, true), (3, false)] {
        for rings in [vec![comb.clone(), needle(tip)], vec![needle(tip), comb.clone()]] {
            assert_eq!(Region::new(rings).is_err(), refused, "{tip}");
        }
    }
}

#[test]
fn curve_of_the_highest_degree_follows_its_chord() {
    let w = WEIGHTS.0;
    let control: Vec<Point> = (0..=i64::try_from(DEGREE_MAX).unwrap()).map(|k| at(k * 100, k % 2)).collect();
    let weights = vec![w; control.len()];
    let curve = Bezier::new(control.clone(), weights.clone()).unwrap();
    assert_eq!((curve.control(), curve.weights()), (&control[..], &weights[..]));
    let chord = Curve::Line(Segment { from: control[0], to: *control.last().unwrap() });
    assert_eq!(curve.follows(&[chord], length(5)), Ok(()));
    assert!(Bezier::new([control, vec![at(9, 9)]].concat(), vec![w; DEGREE_MAX + 2]).is_err());
}

/// The curve passes the end of the arc along its circle, comes back, and goes as far beyond the start.
#[test]
fn curve_that_passes_the_ends_of_an_arc_does_not_follow_it() {
    let w = WEIGHTS.0;
    let curve = |reach: i64| {
        Bezier::new(vec![at(0, 0), at(1000 + reach, 0), at(-reach, 0), at(1000, 0)], vec![w; 4]).unwrap()
    };
    let arc = Arc::new(at(0, 0), at(1000, 0), at(500, -10_000_000), Turn::Clockwise).unwrap();
    assert_eq!(curve(0).follows(&[Curve::Arc(arc)], length(8)), Ok(()));
    assert!(curve(8_000).follows(&[Curve::Arc(arc)], length(8)).is_err());
}

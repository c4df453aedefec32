//! Coordinates, lengths and windows: the values are exact, and no operation overflows.

use keepout_kernel::exact::lattice::{COORD_MAX, LatticeError};
use keepout_kernel::exact::segment::{Window, ahead, distance_2};
use keepout_kernel::{Coord, Length, Point, Segment, Vector};

use super::Xy;
use crate::draw::Draw;
use crate::families::{at, length};
use crate::oracle::{self, Big};
use crate::property::{passed_over, properties};

properties! {
    "lattice", "kernel/src/exact/lattice.rs, segment.rs";
    // Evidence for SR-01.
    coordinates_are_those_within_the_bound |d| coordinates_are_those_within_the_bound(any(d))
        => "a coordinate or a length accepts exactly the numbers within its bound, and keeps the number";
        random 200_000;
    points_move_by_vectors_or_say_so |d| points_move_by_vectors_or_say_so(d.point(), (any(d), any(d)))
        => "a moved point lies at the end of the vector; an end off the lattice is an error";
        random 200_000;
    differences_are_exact |d| differences_are_exact(d.point(), d.point())
        => "the difference of two points leads from one to the other; its square is the square of their \
            distance";
        every 5 random 200_000;
    sums_of_lengths_are_exact_or_errors |d| sums_of_lengths_are_exact_or_errors(any(d), any(d))
        => "the sum of two lengths is exact or an error; the saturating sum ends at the largest length";
        random 200_000;
    small_lengths_are_what_they_say |d| small_lengths_are_what_they_say(d.int(0, 255))
        => "lengths for constants have the stated number of units, or of millimetres";
        every 1 random 1_000;
    // Evidence for SR-01, SR-03.
    grown_windows_hold_what_is_within_reach |d|
        grown_windows_hold_what_is_within_reach([d.point(), d.point()], d.point(), d.radius())
        => "a window grown by r holds exactly the points within r of it in both coordinates";
        every 2 random 100_000;
    windows_meet_when_they_share_a_point |d|
        windows_meet_when_they_share_a_point([d.point(), d.point()], [d.point(), d.point()], d.point())
        => "windows meet exactly when their common part is not empty; union, common and contains agree \
            with sets of points";
        every 1 random 100_000;
    grown_windows_meet_whenever_shapes_are_near |d| {
        let p = d.point();
        grown_windows_meet_whenever_shapes_are_near(
            [p, d.point()],
            [d.point(), d.point()],
            d.threshold(p, (0, 0)),
        )
    }
        => "pruning: segments within r of each other have boxes that meet when one is grown by r";
        every 2 random 100_000;
    window_near_segment_is_of_its_part_on_the_lattice |d|
        window_near_segment_is_of_its_part_on_the_lattice(
            [(any(d), any(d)), (any(d), any(d))],
            [d.point(), d.point()],
            d.radius(),
        )
        => "a window, also one that leaves the lattice, is near a segment exactly when its part on the \
            lattice is near";
        random 60_000;
    within_reach_is_every_point |d|
        within_reach_is_every_point([d.point(), d.point()], [d.point(), d.point()], d.point(), d.radius())
        => "a window is within reach of a segment exactly when its four corners are; then all its points \
            are";
        every 1 random 100_000;
    touching_is_a_distance_of_nothing |d|
        touching_is_a_distance_of_nothing([d.point(), d.point()], [d.point(), d.point()])
        => "segments touch exactly when they share a point";
        every 3 random 100_000;
    ahead_is_the_projection |d| ahead_is_the_projection(d.point(), d.point(), d.point(), d.int(0, 127))
        => "a point is ahead exactly when its projection on the direction exceeds the given number of \
            units";
        random 200_000;
}

/// Any number: of up to 64 bits, or near the bounds.
fn any<D: Draw>(d: &mut D) -> i64 {
    let limit = i64::from(COORD_MAX);
    match d.one_of(6) {
        0 => d.int(-limit - 2, -limit + 2),
        1 => d.int(limit - 2, limit + 2),
        2 => d.int(-2, 2),
        3 => d.coordinate(),
        4 => d.int(i64::from(i32::MIN), i64::from(i32::MAX)),
        _ => d.int(i64::MIN / 4, i64::MAX / 4),
    }
}

fn coordinates_are_those_within_the_bound(units: i64) {
    let limit = i64::from(COORD_MAX);
    match Coord::from_units(units) {
        Ok(coord) => assert!(i64::from(coord.units()) == units && units.abs() <= limit),
        Err(error) => assert!(units.abs() > limit && error == LatticeError { units, least: -COORD_MAX }),
    }
    match Length::from_units(units) {
        Ok(length) => assert!(i64::from(length.units()) == units && (0..=limit).contains(&units)),
        Err(error) => assert!(!(0..=limit).contains(&units) && error == LatticeError { units, least: 0 }),
    }
    assert_eq!(Point::from_units(units, 0).is_ok(), units.abs() <= limit);
    assert_eq!(Point::from_units(0, units).is_ok(), units.abs() <= limit);
}

fn points_move_by_vectors_or_say_so(p: Xy, (dx, dy): Xy) {
    let (Ok(dx), Ok(dy)) = (i32::try_from(dx), i32::try_from(dy)) else { return passed_over() };
    let (x, y) = (p.0 + i64::from(dx), p.1 + i64::from(dy));
    let on = x.abs().max(y.abs()) <= i64::from(COORD_MAX);
    match at(p).translated(Vector { dx, dy }) {
        Ok(moved) => assert!(on && i64::from(moved.x.units()) == x && i64::from(moved.y.units()) == y),
        Err(_) => assert!(!on, "{p:?} {dx} {dy}"),
    }
}

fn differences_are_exact(p: Xy, q: Xy) {
    let d = at(p).minus(at(q));
    assert_eq!((i64::from(d.dx), i64::from(d.dy)), (p.0 - q.0, p.1 - q.1), "{p:?} {q:?}");
    let square = i128::from(p.0 - q.0).pow(2) + i128::from(p.1 - q.1).pow(2);
    assert_eq!(i128::from(distance_2(at(p), at(q))), square, "{p:?} {q:?}");
}

fn sums_of_lengths_are_exact_or_errors(a: i64, b: i64) {
    let (Ok(one), Ok(other)) = (Length::from_units(a), Length::from_units(b)) else { return passed_over() };
    let limit = i64::from(COORD_MAX);
    match one.plus(other) {
        Ok(sum) => assert!(i64::from(sum.units()) == a + b),
        Err(_) => assert!(a + b > limit, "{a} {b}"),
    }
    assert_eq!(i64::from(one.saturating_plus(other).units()), (a + b).min(limit));
}

fn small_lengths_are_what_they_say(count: i64) {
    let Ok(byte) = u8::try_from(count) else { return passed_over() };
    assert_eq!(i64::from(Length::small(byte).units()), count);
    assert_eq!(i64::from(Length::whole_mm(byte).units()), count * 100_000);
}

fn window([p, q]: [Xy; 2]) -> Window {
    Window::of(at(p)).including(at(q))
}

/// The corners of the box around two points.
fn corners([p, q]: [Xy; 2]) -> [Xy; 2] {
    [(p.0.min(q.0), p.1.min(q.1)), (p.0.max(q.0), p.1.max(q.1))]
}

fn inside([low, high]: [Xy; 2], p: Xy) -> bool {
    (low.0..=high.0).contains(&p.0) && (low.1..=high.1).contains(&p.1)
}

fn grown_windows_hold_what_is_within_reach(of: [Xy; 2], p: Xy, r: i64) {
    let [low, high] = corners(of);
    let grown = [(low.0 - r, low.1 - r), (high.0 + r, high.1 + r)];
    assert_eq!(window(of).grown(length(r)).holds(at(p)), inside(grown, p), "{of:?} {p:?} {r}");
    assert_eq!(window(of).holds(at(p)), inside([low, high], p), "{of:?} {p:?}");
}

fn windows_meet_when_they_share_a_point(one: [Xy; 2], other: [Xy; 2], p: Xy) {
    let (a, b, point) = (window(one), window(other), at(p));
    let both = a.holds(point) && b.holds(point);
    assert_eq!(a.meets(b), !a.common(b).is_empty(), "{one:?} {other:?}");
    assert_eq!(a.meets(b), b.meets(a));
    assert_eq!(a.common(b).holds(point) && !a.common(b).is_empty(), both, "{one:?} {other:?} {p:?}");
    assert!(a.union(b).contains(a) && a.union(b).contains(b));
    let all = [one[0], one[1], other[0], other[1]];
    let least = all.iter().fold(window([p, p]), |window, &q| window.including(at(q)));
    assert_eq!(least, a.union(b).including(point), "the least box");
    let [low, high] = corners(other);
    assert_eq!(a.contains(b), inside(corners(one), low) && inside(corners(one), high), "{one:?} {other:?}");
}

fn grown_windows_meet_whenever_shapes_are_near(one: [Xy; 2], other: [Xy; 2], r: i64) {
    let segment = |[a, b]: [Xy; 2]| Segment { from: at(a), to: at(b) };
    let (a, b) = (segment(one), segment(other));
    if !a.near_segment(b, length(r)).is_clear() {
        assert!(a.bounds().grown(length(r)).meets(b.bounds()), "{one:?} {other:?} {r}");
        assert!(b.bounds().grown(length(r)).meets(a.bounds()), "{one:?} {other:?} {r}");
    }
}

fn window_near_segment_is_of_its_part_on_the_lattice(of: [Xy; 2], [a, b]: [Xy; 2], r: i64) {
    let to_i32 = |v: i64| i32::try_from(v).ok();
    let [low, high] = corners(of);
    let (Some(x0), Some(y0), Some(x1), Some(y1)) =
        (to_i32(low.0), to_i32(low.1), to_i32(high.0), to_i32(high.1))
    else {
        return passed_over();
    };
    let window = Window::from_corners(x0, y0, x1, y1);
    let limit = i64::from(COORD_MAX);
    let cut = |(x, y): Xy| Big::new(x.clamp(-limit, limit), y.clamp(-limit, limit));
    let near = !window.near_segment(Segment { from: at(a), to: at(b) }, length(r)).is_clear();
    let truth =
        oracle::box_segment_within(&cut(low), &cut(high), &Big::new(a.0, a.1), &Big::new(b.0, b.1), r);
    assert_eq!(near, truth, "{of:?} {a:?} {b:?} {r}");
}

fn within_reach_is_every_point(of: [Xy; 2], [a, b]: [Xy; 2], p: Xy, r: i64) {
    let wall = Segment { from: at(a), to: at(b) };
    let all = window(of).within_reach_of(wall, length(r));
    let near = |p: Xy| !wall.near_point(at(p), length(r)).is_clear();
    if all && window(of).holds(at(p)) {
        assert!(near(p), "{of:?} {a:?} {b:?} {p:?} {r}");
    }
    let [low, high] = corners(of);
    assert_eq!(
        all,
        [low, high, (low.0, high.1), (high.0, low.1)].into_iter().all(near),
        "{of:?} {a:?} {b:?} {r}"
    );
}

fn touching_is_a_distance_of_nothing(one: [Xy; 2], other: [Xy; 2]) {
    let segment = |[a, b]: [Xy; 2]| Segment { from: at(a), to: at(b) };
    let [a, b] = one.map(|(x, y)| Big::new(x, y));
    let [c, d] = other.map(|(x, y)| Big::new(x, y));
    let truth = oracle::segment_segment_within(&a, &b, &c, &d, 0);
    assert_eq!(segment(one).touches(segment(other)), truth, "{one:?} {other:?}");
}

fn ahead_is_the_projection(origin: Xy, p: Xy, along: Xy, count: i64) {
    let Ok(units) = i8::try_from(count) else { return passed_over() };
    let way = Segment { from: at(origin), to: at(along) };
    let (w, v) = ((p.0 - origin.0, p.1 - origin.1), (along.0 - origin.0, along.1 - origin.1));
    let wide = i128::from;
    let dot = wide(w.0) * wide(v.0) + wide(w.1) * wide(v.1);
    let length_2 = wide(v.0).pow(2) + wide(v.1).pow(2);
    // dot > count · |v|, both sides squared where the left is positive.
    let truth = dot > 0 && dot * dot > wide(count).pow(2) * length_2;
    assert_eq!(ahead(at(origin), at(p), way, units), truth, "{origin:?} {p:?} {along:?} {count}");
}

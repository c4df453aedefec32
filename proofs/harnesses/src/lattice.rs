//! Coordinates, heights, lengths, points: over the full range.

use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::segment::distance_2;
use keepout_kernel::{Coord, Height, Length, Point, Vector};

use crate::{Cases, harnesses};

harnesses! {
    // Evidence for SR-01.
    "kernel/src/exact/lattice.rs" {
        coordinates_are_those_within_the_bound:
            "a coordinate accepts exactly the numbers up to 2^29, and keeps them", "every i64", unwind 1;
        lengths_are_those_within_the_bound:
            "a length accepts exactly the numbers from 0 to 2^29, and keeps them", "every i64", unwind 1;
        heights_are_those_within_the_bound:
            "a height accepts exactly the numbers up to 2^29, and keeps them", "every i64", unwind 1;
        refused_numbers_are_named:
            "the error of a refused number names it and the least number", "every i64", unwind 1;
        points_need_both_coordinates:
            "a point exists exactly when both of its coordinates do", "every pair of i64", unwind 1;
        points_move_exactly_or_say_so:
            "a moved point lies at the end of the vector, and an end off the lattice is an error",
            "every point and vector", unwind 1;
        differences_lead_back:
            "the difference of two points leads from one to the other", "every pair of points", unwind 1;
        sums_of_lengths_are_exact_or_errors:
            "the sum of two lengths is exact, or an error beyond the lattice", "every pair of lengths", unwind 1;
        saturating_sums_end_at_the_largest_length:
            "the saturating sum is the sum, or the largest length", "every pair of lengths", unwind 1;
        small_lengths_are_exact:
            "lengths of constants have the stated number of units or millimetres", "every u8", unwind 1;
        lowered_heights_are_exact_or_lowest:
            "a lowered height is lower by the length, or the lowest", "every height and length", unwind 1;
        raised_heights_are_exact_or_highest:
            "a raised height is higher by the length, or the highest", "every height and length", unwind 1;
        lowering_keeps_the_order:
            "lowering two heights by one length keeps their order", "every pair of heights, every length",
            unwind 1;
    }
    "kernel/src/exact/segment.rs" {
        squares_of_distances_are_exact:
            "the square of a distance is the sum of two squares", "points within ±2 units", unwind 1;
    }
}

const LIMIT: i64 = COORD_MAX as i64;

/// Any point of the lattice.
pub(crate) fn point(c: &mut impl Cases) -> Point {
    at(c.int(-COORD_MAX, COORD_MAX), c.int(-COORD_MAX, COORD_MAX))
}

/// A point within `half` units of the origin along each axis.
pub(crate) fn near_origin(c: &mut impl Cases, half: i32) -> Point {
    at(c.int(-half, half), c.int(-half, half))
}

/// A point of the lattice.
pub(crate) fn at(x: i32, y: i32) -> Point {
    Point::from_units(x.into(), y.into()).expect("it is on the lattice")
}

/// A length of the lattice.
pub(crate) fn length(units: i32) -> Length {
    Length::from_units(units.into()).expect("it is a length")
}

/// A height of the lattice.
pub(crate) fn height(units: i32) -> Height {
    Height::from_units(units.into()).expect("it is on the lattice")
}

fn any_length(c: &mut impl Cases) -> Length {
    length(c.int(0, COORD_MAX))
}

fn any_height(c: &mut impl Cases) -> Height {
    height(c.int(-COORD_MAX, COORD_MAX))
}

fn coordinates_are_those_within_the_bound(c: &mut impl Cases) {
    let units = c.wide();
    match Coord::from_units(units) {
        Ok(coord) => assert!(i64::from(coord.units()) == units && (-LIMIT..=LIMIT).contains(&units)),
        Err(_) => assert!(!(-LIMIT..=LIMIT).contains(&units)),
    }
}

fn lengths_are_those_within_the_bound(c: &mut impl Cases) {
    let units = c.wide();
    match Length::from_units(units) {
        Ok(length) => assert!(i64::from(length.units()) == units && (0..=LIMIT).contains(&units)),
        Err(_) => assert!(!(0..=LIMIT).contains(&units)),
    }
}

fn heights_are_those_within_the_bound(c: &mut impl Cases) {
    let units = c.wide();
    match Height::from_units(units) {
        Ok(height) => assert!(i64::from(height.units()) == units && (-LIMIT..=LIMIT).contains(&units)),
        Err(_) => assert!(!(-LIMIT..=LIMIT).contains(&units)),
    }
}

fn refused_numbers_are_named(c: &mut impl Cases) {
    let units = c.wide();
    if let Err(error) = Coord::from_units(units) {
        assert!(error.units == units && error.least == -COORD_MAX);
    }
    if let Err(error) = Length::from_units(units) {
        assert!(error.units == units && error.least == 0);
    }
}

fn points_need_both_coordinates(c: &mut impl Cases) {
    let (x, y) = (c.wide(), c.wide());
    let both = Coord::from_units(x).is_ok() && Coord::from_units(y).is_ok();
    assert!(Point::from_units(x, y).is_ok() == both);
}

fn points_move_exactly_or_say_so(c: &mut impl Cases) {
    let from = point(c);
    let (dx, dy) = (c.int(i32::MIN, i32::MAX), c.int(i32::MIN, i32::MAX));
    let x = i64::from(from.x.units()) + i64::from(dx);
    let y = i64::from(from.y.units()) + i64::from(dy);
    let on = (-LIMIT..=LIMIT).contains(&x) && (-LIMIT..=LIMIT).contains(&y);
    match from.translated(Vector { dx, dy }) {
        Ok(to) => assert!(on && i64::from(to.x.units()) == x && i64::from(to.y.units()) == y),
        Err(_) => assert!(!on),
    }
}

fn differences_lead_back(c: &mut impl Cases) {
    let (p, q) = (point(c), point(c));
    assert!(q.translated(p.minus(q)) == Ok(p));
}

fn sums_of_lengths_are_exact_or_errors(c: &mut impl Cases) {
    let (one, other) = (any_length(c), any_length(c));
    let sum = i64::from(one.units()) + i64::from(other.units());
    match one.plus(other) {
        Ok(length) => assert!(i64::from(length.units()) == sum),
        Err(_) => assert!(sum > LIMIT),
    }
}

fn saturating_sums_end_at_the_largest_length(c: &mut impl Cases) {
    let (one, other) = (any_length(c), any_length(c));
    let sum = i64::from(one.units()) + i64::from(other.units());
    assert!(i64::from(one.saturating_plus(other).units()) == sum.min(LIMIT));
}

fn small_lengths_are_exact(c: &mut impl Cases) {
    let count = c.up_to(255);
    assert!(Length::small(count).units() == i32::from(count));
    assert!(i64::from(Length::whole_mm(count).units()) == i64::from(count) * 100_000);
}

fn lowered_heights_are_exact_or_lowest(c: &mut impl Cases) {
    let (from, by) = (any_height(c), any_length(c));
    let exact = i64::from(from.units()) - i64::from(by.units());
    assert!(i64::from(from.lowered(by).units()) == exact.max(-LIMIT));
}

fn raised_heights_are_exact_or_highest(c: &mut impl Cases) {
    let (from, by) = (any_height(c), any_length(c));
    let exact = i64::from(from.units()) + i64::from(by.units());
    assert!(i64::from(from.raised(by).units()) == exact.min(LIMIT));
}

fn lowering_keeps_the_order(c: &mut impl Cases) {
    let (one, other, by) = (any_height(c), any_height(c), any_length(c));
    assert!(one > other || one.lowered(by) <= other.lowered(by));
}

fn squares_of_distances_are_exact(c: &mut impl Cases) {
    let (p, q) = (near_origin(c, 2), near_origin(c, 2));
    let (dx, dy) = (p.x.units() - q.x.units(), p.y.units() - q.y.units());
    assert!(distance_2(p, q) == i64::from(dx * dx + dy * dy));
}

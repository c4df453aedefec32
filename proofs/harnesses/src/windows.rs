//! Boxes along the axes: over the full range, as they use comparisons alone.

use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::segment::{Segment, Window};
use keepout_kernel::{Point, Triangle};

use crate::lattice::{length, point};
use crate::{Cases, harnesses};

harnesses! {
    // Evidence for SR-01, SR-03.
    "kernel/src/exact/segment.rs" {
        windows_meet_when_their_common_part_holds_a_point:
            "boxes meet exactly when their common part is not empty", "every pair of boxes", unwind 1;
        common_parts_hold_what_both_hold:
            "the common part of two boxes holds exactly the points of both", "every pair of boxes, every point",
            unwind 1;
        unions_hold_what_either_holds:
            "the union of two boxes holds every point of either", "every pair of boxes, every point", unwind 1;
        unions_are_the_least:
            "a box that contains two boxes contains their union", "every three boxes", unwind 1;
        windows_hold_the_points_that_they_include:
            "a box that includes a point holds it, and what it held before", "every box, every two points",
            unwind 1;
        windows_hold_what_lies_between_their_corners:
            "a box holds exactly the points between its corners", "every box, every point", unwind 1;
        grown_windows_hold_what_is_within_reach:
            "a box grown by r holds exactly the points within r of it along both axes",
            "every box, every point, every r", unwind 1;
        contained_windows_hold_no_other_point:
            "a box that is contained in another holds no point outside of it", "every pair of boxes, every point",
            unwind 1;
        windows_contain_each_other_only_when_equal:
            "two boxes that contain each other are one box", "every pair of boxes", unwind 1;
        empty_windows_hold_nothing:
            "a box with a least coordinate above its greatest holds no point", "every four coordinates, every point",
            unwind 1;
        bounds_of_a_segment_hold_its_ends:
            "the box of a segment is the least one that holds both ends", "every segment, every box", unwind 1;
        bounds_of_a_triangle_hold_its_corners:
            "the box of a triangle is the least one that holds its corners", "every triangle, every box", unwind 1;
    }
}

fn window(c: &mut impl Cases) -> Window {
    Window::of(point(c)).including(point(c))
}

fn windows_meet_when_their_common_part_holds_a_point(c: &mut impl Cases) {
    let (one, other) = (window(c), window(c));
    assert!(one.meets(other) != one.common(other).is_empty());
}

fn common_parts_hold_what_both_hold(c: &mut impl Cases) {
    let (one, other, p) = (window(c), window(c), point(c));
    assert!(one.common(other).holds(p) == (one.holds(p) && other.holds(p)));
}

fn unions_hold_what_either_holds(c: &mut impl Cases) {
    let (one, other, p) = (window(c), window(c), point(c));
    assert!(one.union(other).holds(p) || !(one.holds(p) || other.holds(p)));
}

fn unions_are_the_least(c: &mut impl Cases) {
    let (one, other, third) = (window(c), window(c), window(c));
    let both = third.contains(one) && third.contains(other);
    assert!(both == third.contains(one.union(other)));
}

fn windows_hold_the_points_that_they_include(c: &mut impl Cases) {
    let (window, p, q) = (window(c), point(c), point(c));
    let grown = window.including(p);
    assert!(grown.holds(p) && (grown.holds(q) || !window.holds(q)));
}

fn between(low: i32, c: i32, high: i32) -> bool {
    low <= c && c <= high
}

fn windows_hold_what_lies_between_their_corners(c: &mut impl Cases) {
    let (window, p) = (window(c), point(c));
    let (x0, y0, x1, y1) = window.corners();
    assert!(window.holds(p) == (between(x0, p.x.units(), x1) && between(y0, p.y.units(), y1)));
}

fn grown_windows_hold_what_is_within_reach(c: &mut impl Cases) {
    let (window, p, r) = (window(c), point(c), c.int(0, COORD_MAX));
    let (x0, y0, x1, y1) = window.corners();
    let within = between(x0 - r, p.x.units(), x1 + r) && between(y0 - r, p.y.units(), y1 + r);
    assert!(window.grown(length(r)).holds(p) == within);
}

fn contained_windows_hold_no_other_point(c: &mut impl Cases) {
    let (one, other, p) = (window(c), window(c), point(c));
    assert!(!one.contains(other) || !other.holds(p) || one.holds(p));
}

fn windows_contain_each_other_only_when_equal(c: &mut impl Cases) {
    let (one, other) = (window(c), window(c));
    assert!((one.contains(other) && other.contains(one)) == (one == other));
}

fn empty_windows_hold_nothing(c: &mut impl Cases) {
    let mut any = || c.int(-COORD_MAX, COORD_MAX);
    let window = Window::from_corners(any(), any(), any(), any());
    let p = point(c);
    assert!(!window.is_empty() || !window.holds(p));
}

fn is_least_box(bounds: Window, corners: &[Point], other: Window) {
    assert!(corners.iter().all(|&corner| bounds.holds(corner)));
    assert!(!corners.iter().all(|&corner| other.holds(corner)) || other.contains(bounds));
}

fn bounds_of_a_segment_hold_its_ends(c: &mut impl Cases) {
    let (from, to) = (point(c), point(c));
    is_least_box(Segment { from, to }.bounds(), &[from, to], window(c));
}

fn bounds_of_a_triangle_hold_its_corners(c: &mut impl Cases) {
    let corners = [point(c), point(c), point(c)];
    is_least_box(Triangle { corners }.bounds(), &corners, window(c));
}

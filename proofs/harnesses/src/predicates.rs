//! The predicates at the narrow width: 8 bits for coordinates, 16 for areas, 32 for volumes.

use core::cmp::Ordering;

use keepout_kernel::exact::predicate::{
    Orientation, Site, beyond, box_point, box_segment, convex_holds, crosses_properly, orientation,
    point_point, point_segment, ray_crosses, retract, strictly_inside, triangle_segment,
};
use keepout_kernel::exact::width::Narrow;

use crate::{Cases, harnesses};

harnesses! {
    // Evidence for SR-01.
    "kernel/src/exact/predicate.rs" {
        orientation_is_the_sign_of_the_determinant:
            "orientation is the sign of (b − a) × (c − a)", "a at the origin, b and c within ±7", unwind 1;
        orientation_changes_sign_with_its_corners:
            "two corners exchanged exchange left and right", "corners within ±3", unwind 1;
        orientation_of_two_equal_points_is_on:
            "three points of which two are equal lie on a line", "every narrow point", unwind 1;
        points_are_near_by_definition:
            "point–point: near exactly when dx² + dy² ≤ r²", "coordinates within ±7, r up to 14", unwind 1;
        point_segment_of_a_point_is_point_point:
            "a segment of length zero is its point", "coordinates within ±7, r up to 14", unwind 1;
        point_segment_is_near_at_its_ends:
            "a point near an end is near the segment", "coordinates within ±1, r up to 2", unwind 1;
        point_segment_stays_near_at_a_larger_threshold:
            "a point that is near at r is near at r + 1", "coordinates within ±2, r up to 4", unwind 1;
        crossing_has_no_order:
            "crossing properly is the same for both orders of the segments", "coordinates within ±1", unwind 1;
        crossing_segments_share_no_end:
            "segments that cross properly have no common end", "coordinates within ±3", unwind 1;
        a_corner_is_not_strictly_inside:
            "no corner of a triangle is strictly inside it", "corners within ±7", unwind 1;
        strictly_inside_is_on_one_side:
            "a point strictly inside a triangle is strictly on the same side of its three sides",
            "coordinates within ±2", unwind 1;
        triangles_are_near_at_their_corners:
            "a segment through a corner of a triangle is near it at every r", "coordinates within ±2, r up to 4",
            unwind 5;
        points_beyond_a_line_are_clear_of_it:
            "what is beyond a segment's line is clear of the segment", "coordinates within ±1, r up to 2", unwind 3;
        points_beyond_a_line_are_right_of_it:
            "what is beyond a line is right of it", "coordinates within ±3, r up to 6", unwind 3;
        box_point_is_the_distance_along_both_axes:
            "box–point: near exactly when the squared distances along the axes sum to at most r²",
            "coordinates within ±5, r up to 10", unwind 1;
        boxes_are_near_what_ends_in_them:
            "a segment that ends in a box is near it at every r", "coordinates within ±2, r up to 4", unwind 5;
        polygons_hold_their_corners:
            "a polygon of three corners holds each of them", "corners within ±1", unwind 5;
        // Evidence for SR-04.
        rays_count_an_edge_in_both_directions:
            "a ray crosses an edge exactly when it crosses the reversed edge", "coordinates within ±3", unwind 1;
        rays_pass_level_edges:
            "a ray crosses no edge along x", "every narrow point", unwind 1;
        rays_cross_two_edges_at_a_peak_or_none:
            "at the common end of two edges above the ray, both count or none", "coordinates within ±2", unwind 1;
        // Evidence for SR-14.
        a_motion_of_no_length_retracts:
            "a motion of length zero comes nearer to nothing", "coordinates within ±3", unwind 1;
        retracting_motions_end_no_nearer:
            "a motion that retracts from a point ends no nearer to it", "coordinates within ±4", unwind 1;
    }
}

type Place = Site<Narrow>;

fn small(c: &mut impl Cases, half: i8) -> i8 {
    i8::try_from(c.int(-i32::from(half), half.into())).unwrap_or(0)
}

fn site(c: &mut impl Cases, half: i8) -> Place {
    Site { x: small(c, half), y: small(c, half) }
}

fn radius(c: &mut impl Cases, most: u8) -> i8 {
    i8::try_from(c.up_to(most)).unwrap_or(0)
}

fn square(of: i8) -> i16 {
    i16::from(of) * i16::from(of)
}

/// The squared distance of two points.
fn away(p: Place, q: Place) -> i16 {
    square(p.x - q.x) + square(p.y - q.y)
}

fn orientation_is_the_sign_of_the_determinant(c: &mut impl Cases) {
    let (b, d) = (site(c, 7), site(c, 7));
    let wide = |of: i8| i16::from(of);
    let expected = match (wide(b.x) * wide(d.y)).cmp(&(wide(b.y) * wide(d.x))) {
        Ordering::Greater => Orientation::Left,
        Ordering::Equal => Orientation::On,
        Ordering::Less => Orientation::Right,
    };
    assert!(orientation::<Narrow>(Site { x: 0, y: 0 }, b, d) == expected);
}

fn orientation_changes_sign_with_its_corners(c: &mut impl Cases) {
    let (a, b, p) = (site(c, 3), site(c, 3), site(c, 3));
    let swapped = match orientation::<Narrow>(b, a, p) {
        Orientation::Left => Orientation::Right,
        Orientation::On => Orientation::On,
        Orientation::Right => Orientation::Left,
    };
    assert!(orientation::<Narrow>(a, b, p) == swapped);
}

fn orientation_of_two_equal_points_is_on(c: &mut impl Cases) {
    let (a, b) = (site(c, 31), site(c, 31));
    let of = orientation::<Narrow>;
    assert!([of(a, a, b), of(a, b, a), of(b, a, a)] == [Orientation::On; 3]);
}

fn points_are_near_by_definition(c: &mut impl Cases) {
    let (p, q, r) = (site(c, 7), site(c, 7), radius(c, 14));
    assert!(point_point::<Narrow>(p, q, r).is_clear() == (away(p, q) > square(r)));
}

fn point_segment_of_a_point_is_point_point(c: &mut impl Cases) {
    let (p, q, r) = (site(c, 7), site(c, 7), radius(c, 14));
    assert!(point_segment::<Narrow>(p, q, q, r).is_clear() == (away(p, q) > square(r)));
}

fn point_segment_is_near_at_its_ends(c: &mut impl Cases) {
    let (p, a, b, r) = (site(c, 1), site(c, 1), site(c, 1), radius(c, 2));
    assert!(away(p, a) > square(r) || !point_segment::<Narrow>(p, a, b, r).is_clear());
}

fn point_segment_stays_near_at_a_larger_threshold(c: &mut impl Cases) {
    let (p, a, b, r) = (site(c, 2), site(c, 2), site(c, 2), radius(c, 4));
    let clear = |r| point_segment::<Narrow>(p, a, b, r).is_clear();
    assert!(clear(r) || !clear(r + 1));
}

fn crossing_has_no_order(c: &mut impl Cases) {
    let (a, b, p, q) = (site(c, 1), site(c, 1), site(c, 1), site(c, 1));
    assert!(crosses_properly::<Narrow>(a, b, p, q) == crosses_properly::<Narrow>(p, q, a, b));
}

fn crossing_segments_share_no_end(c: &mut impl Cases) {
    let (a, b, q) = (site(c, 3), site(c, 3), site(c, 3));
    assert!(!crosses_properly::<Narrow>(a, b, a, q) && !crosses_properly::<Narrow>(a, b, q, b));
}

fn a_corner_is_not_strictly_inside(c: &mut impl Cases) {
    let (a, b, d) = (site(c, 7), site(c, 7), site(c, 7));
    assert!(![a, b, d].into_iter().any(|p| strictly_inside::<Narrow>(p, a, b, d)));
}

fn strictly_inside_is_on_one_side(c: &mut impl Cases) {
    let (p, a, b, d) = (site(c, 2), site(c, 2), site(c, 2), site(c, 2));
    let of = |a, b| orientation::<Narrow>(a, b, p);
    let side = of(a, b);
    let one_side = side != Orientation::On && of(b, d) == side && of(d, a) == side;
    assert!(strictly_inside::<Narrow>(p, a, b, d) == one_side);
}

fn triangles_are_near_at_their_corners(c: &mut impl Cases) {
    let (a, b, d, p, r) = (site(c, 2), site(c, 2), site(c, 2), site(c, 2), radius(c, 4));
    assert!(!triangle_segment::<Narrow>([a, b, d], [a, p], r).is_clear());
}

fn points_beyond_a_line_are_clear_of_it(c: &mut impl Cases) {
    let (a, b, p, r) = (site(c, 1), site(c, 1), site(c, 1), radius(c, 2));
    let is_beyond = beyond::<Narrow>([a, b], core::iter::once(p), r);
    assert!(!is_beyond || point_segment::<Narrow>(p, a, b, r).is_clear());
}

fn points_beyond_a_line_are_right_of_it(c: &mut impl Cases) {
    let (a, b, p, r) = (site(c, 3), site(c, 3), site(c, 3), radius(c, 6));
    let is_beyond = beyond::<Narrow>([a, b], core::iter::once(p), r);
    assert!(!is_beyond || orientation::<Narrow>(a, b, p) == Orientation::Right);
}

/// A box within `half` units of the origin.
fn corners(c: &mut impl Cases, half: i8) -> [Place; 2] {
    let (p, q) = (site(c, half), site(c, half));
    [Site { x: p.x.min(q.x), y: p.y.min(q.y) }, Site { x: p.x.max(q.x), y: p.y.max(q.y) }]
}

/// The distance of a coordinate from a range.
fn outside(low: i8, of: i8, high: i8) -> i8 {
    if of < low { low - of } else { (of - high).max(0) }
}

fn box_point_is_the_distance_along_both_axes(c: &mut impl Cases) {
    let ([low, high], p, r) = (corners(c, 5), site(c, 5), radius(c, 10));
    let off = square(outside(low.x, p.x, high.x)) + square(outside(low.y, p.y, high.y));
    assert!(box_point::<Narrow>(low, high, p, r).is_clear() == (off > square(r)));
}

fn boxes_are_near_what_ends_in_them(c: &mut impl Cases) {
    let ([low, high], p, q, r) = (corners(c, 2), site(c, 2), site(c, 2), radius(c, 4));
    let held = outside(low.x, p.x, high.x) == 0 && outside(low.y, p.y, high.y) == 0;
    assert!(!held || !box_segment::<Narrow>(low, high, p, q, r).is_clear());
}

fn polygons_hold_their_corners(c: &mut impl Cases) {
    let corners = [site(c, 1), site(c, 1), site(c, 1)];
    let [a, b, d] = corners;
    let left = orientation::<Narrow>(a, b, d) == Orientation::Left;
    assert!(!left || corners.into_iter().all(|p| convex_holds(corners.into_iter(), p)));
}

fn rays_count_an_edge_in_both_directions(c: &mut impl Cases) {
    let (p, a, b) = (site(c, 3), site(c, 3), site(c, 3));
    assert!(ray_crosses::<Narrow>(p, a, b) == ray_crosses::<Narrow>(p, b, a));
}

fn rays_pass_level_edges(c: &mut impl Cases) {
    let (p, a, x) = (site(c, 31), site(c, 31), small(c, 31));
    assert!(!ray_crosses::<Narrow>(p, a, Site { x, y: a.y }));
}

fn rays_cross_two_edges_at_a_peak_or_none(c: &mut impl Cases) {
    let (a, b, d) = (site(c, 2), site(c, 2), site(c, 2));
    let p = Site { x: small(c, 2), y: b.y };
    // The ray along x passes the common end of two edges to one side of it, or on it.
    let one_side = (a.y < p.y) == (d.y < p.y) && a.y != p.y && d.y != p.y;
    assert!(!one_side || ray_crosses::<Narrow>(p, a, b) == ray_crosses::<Narrow>(p, b, d));
}

fn a_motion_of_no_length_retracts(c: &mut impl Cases) {
    let (p, a, b) = (site(c, 3), site(c, 3), site(c, 3));
    assert!(retract::<Narrow>(p, p, a, b) || !point_segment::<Narrow>(p, a, b, 0).is_clear());
}

fn retracting_motions_end_no_nearer(c: &mut impl Cases) {
    let (p, q, a) = (site(c, 4), site(c, 4), site(c, 4));
    assert!(!retract::<Narrow>(p, q, a, a) || away(q, a) >= away(p, a));
}

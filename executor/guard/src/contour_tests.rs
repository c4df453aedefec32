//! Tests of what the guard believes and tells while a contour runs.

use keepout_kernel::offset::GougeCause;
use keepout_kernel::{Arc, Curve, Point, Segment, Turn};

use super::{at, feedback, guard, guard_of, take_contour, time};
use crate::hull::Hull;
use crate::*;

fn line(from: Point, to: Point) -> ContourMotion {
    ContourMotion::in_plane(Curve::Line(Segment { from, to }), 300)
}

/// A guard with a contour of three lines along x = −1000, certified, of which `sent` motions are acknowledged.
fn guard_in_contour(sent: usize) -> Guard {
    let mut guard = guard();
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    let motions = [0, 1000, 2000].map(|y| line(at(-1000, y), at(-1000, y + 1000)));
    take_contour(&mut guard, motions.to_vec()).unwrap();
    for _ in 0..sent {
        guard.next_of_contour().unwrap();
        guard.acknowledged().unwrap();
    }
    guard
}

fn on_the_way(guard: &mut Guard, x: i64, y: i64) -> Result<(), Refusal> {
    let stamp = guard.stamp(time(0));
    guard.reported(&feedback(at(x, y), false, 0), stamp, time(5))
}

#[test]
fn place_in_the_contour_follows_the_reports() {
    let mut guard = guard_in_contour(3);
    for (y, at_motion) in [(0, 0), (500, 0), (1000, 0), (1010, 0), (1011, 1), (1500, 1), (2500, 2)] {
        on_the_way(&mut guard, -1000, y).unwrap();
        assert_eq!(guard.contour_at(), Some(at_motion), "{y}");
        assert_eq!(guard.contour_left().len(), 3 - at_motion, "{y}");
    }
    assert_eq!(guard.contour_left()[0].to(), at(-1000, 3000).in_plane());
    assert!(on_the_way(&mut guard, -1000, 500).is_err(), "a motion that has passed");
    let guard = super::guard();
    assert!(guard.contour_at().is_none() && guard.contour_left().is_empty());
}

/// The first motion begins where the tool was reported at rest, to two resolutions. Each other motion begins at
/// the end of the motion before it.
#[test]
fn only_the_first_motion_of_a_contour_has_two_resolutions() {
    for (y, off, believed) in [(500, 10, true), (500, 11, false), (1500, 5, true), (1500, 6, false)] {
        let mut guard = guard_in_contour(3);
        let seen = on_the_way(&mut guard, -1000 - off, y);
        assert_eq!(seen.is_ok(), believed, "{y} {off} {seen:?}");
    }
}

#[test]
fn contour_is_withdrawn_before_its_first_motion_only() {
    for sent in 0..3 {
        let mut guard = guard_in_contour(sent);
        guard.withdraw_contour();
        assert_eq!(guard.contour_progress(), (sent > 0).then_some((sent, 3)));
    }
}

#[test]
fn gouge_names_its_motion() {
    let (p, q) = (at(-1000, 0), at(-1000, 1000));
    for (next, cause) in [
        (line(q, at(1000, 1000)), None),
        (line(at(-1000, 1001), at(-1000, 2000)), Some(GougeCause::Discontinuous)),
    ] {
        let mut guard = guard();
        guard.locate(p.in_plane()).unwrap();
        guard.begin_contour(vec![line(p, q), next]).unwrap();
        let Err(Refusal::Gouge(gouge)) = guard.certify_contour(2) else { panic!("certified") };
        assert_eq!(gouge.index, 1);
        assert!(cause.is_none_or(|cause| gouge.cause == cause), "{gouge:?}");
    }
}

#[test]
fn state_tells_each_step_of_a_contour() {
    let mut guard = guard();
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    // There and back: after two motions the end is the same place.
    let (p, q) = (at(-1000, 0), at(-1000, 1000));
    guard.begin_contour(vec![line(p, q), line(q, p), line(p, q), line(q, p)]).unwrap();
    guard.certify_contour(2).unwrap();
    let half = guard.state();
    guard.certify_contour(2).unwrap();
    assert_ne!(guard.state(), half);
}

/// The limit of the sweep has a cosine of −1/8.
#[test]
fn arc_at_the_limit_of_its_sweep_is_permitted() {
    for (beyond, permitted) in [(0, true), (1, false)] {
        let mut guard = guard();
        let (from, to) = (at(-4000, 0), at(-13_000 - beyond, 7937));
        let arc = Arc::new(from, to, at(-12_000, 0), Turn::CounterClockwise).unwrap();
        guard.locate(from.in_plane()).unwrap();
        guard.begin_contour(vec![ContourMotion::in_plane(Curve::Arc(arc), 300)]).unwrap();
        let certified = guard.certify_contour(1);
        assert_eq!(certified != Err(Refusal::ArcTooLong(from)), permitted, "{certified:?}");
        assert_eq!(certified.is_ok(), permitted, "{certified:?}");
    }
}

/// The tool is believed within the resolution and 200 units of an arc: inside, outside, and beyond its ends.
#[test]
fn reports_beside_an_arc_are_believed_to_the_unit() {
    let (centre, radius) = (at(-12_000, 0), 5000);
    let (from, to) = (at(-7000, 0), at(-12_000, radius));
    // The arc is the second motion. The believed distance is 205 units, and one more for the rounding of the
    // radius: 4795 to 5206 units from the centre.
    for (x, y, believed) in [
        (-12_000 + 3990, 3344, true),
        (-12_000 + 1143, 5080, false),
        (-12_000 + 2877, 3836, true),
        (-12_000 + 2256, 4230, false),
        (-7000, -205, true),
        (-7000, -206, false),
        (-12_205, radius, true),
        (-12_206, radius, false),
    ] {
        let mut guard = guard();
        let start = at(-6000, 0);
        guard.locate(start.in_plane()).unwrap();
        let arc = Arc::new(from, to, centre, Turn::CounterClockwise).unwrap();
        let arc = ContourMotion::in_plane(Curve::Arc(arc), 300);
        take_contour(&mut guard, vec![line(start, from), arc]).unwrap();
        for _ in 0..2 {
            guard.next_of_contour().unwrap();
            guard.acknowledged().unwrap();
        }
        assert_eq!(on_the_way(&mut guard, x, y).is_ok(), believed, "{x} {y}");
    }
}

/// Without interpolated axes, a retract move goes along one axis.
#[test]
fn retract_moves_of_independent_axes_are_not_slanted() {
    let mut guard = guard_of(Interpolation::Independent, true);
    guard.locate(at(-295, 1000).in_plane()).unwrap();
    let mut to = |x, y| guard.admissions().admit_retract(at(x, y).in_plane()).map(drop);
    assert_eq!(to(-500, 1200), Err(Refusal::Slanted(at(-295, 1000))));
    assert_eq!(to(-500, 1000), Ok(()));
    assert_eq!(to(-295, 1200), Ok(()));
}

#[test]
fn only_an_unacknowledged_jog_is_rejected() {
    let mut guard = guard();
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    assert!(!guard.refused(), "no line");
    guard.jog(at(-1000, 2000).in_plane(), 600).unwrap();
    guard.acknowledged().unwrap();
    assert!(!guard.refused(), "it is acknowledged");
    guard.jog(at(-1000, 3000).in_plane(), 600).unwrap();
    assert!(guard.refused());
    let mut guard = guard_in_contour(0);
    guard.next_of_contour().unwrap();
    assert!(!guard.refused(), "a motion of a contour");
}

#[test]
fn hull_of_one_place_has_one_corner() {
    for count in 1..5 {
        let hull = Hull::of([at(5, 7); 4].into_iter().take(count)).unwrap();
        assert_eq!(hull.corners(), [at(5, 7)]);
    }
    let twice = [at(0, 0), at(9, 0), at(0, 0), at(9, 0), at(9, 9), at(9, 9)];
    assert_eq!(Hull::of(twice.into_iter()).unwrap().corners(), [at(0, 0), at(9, 0), at(9, 9)]);
}

//! The guard: where contours begin and end.

use keepout_guard::{Certification, ContourMotion, Guard, Interpolation, PARSING, Refusal, Time};
use keepout_kernel::{Arc, Curve, Point, Segment, Turn};

use super::Xy;
use super::guard::{TRAVEL, feedback, guard};
use crate::families::at;
use crate::property::properties;

properties! {
    "guard: contours", "executor/guard/src/contour.rs";
    // Evidence for SR-12.
    contours_end_after_their_last_motion |d| {
        let spokes: Vec<Xy> = (0..3).map(|_| (d.int(-9000, -5000), d.int(-3000, 9000))).collect();
        contours_end_after_their_last_motion(&spokes, d.coin())
    }
        => "a contour that comes back to its start again and again ends only after its last motion: by one report at \
            rest with a checksum, and by two without";
        random 5_000;
    contours_begin_without_lines_in_flight |d|
        contours_begin_without_lines_in_flight((d.int(-9000, -5000), d.int(-3000, 9000)), d.coin())
        => "while a jog is in flight, no contour begins, and no position is taken as that of a tool at rest";
        random 5_000;
    // Evidence for SR-15.
    arcs_beyond_the_travel_are_refused |d|
        arcs_beyond_the_travel_are_refused(d.int(300, 2000), d.int(-100, 299), d.coin())
        => "an arc whose ends lie in the travel is certified only if the curve does, to the bound of its chords";
        random 5_000;
}

fn line(from: Point, to: Point) -> ContourMotion {
    ContourMotion::in_plane(Curve::Line(Segment { from, to }), 300)
}

/// A guard whose tool rests at a place left of the part.
fn at_rest(checked: bool) -> (Guard, Point) {
    let mut guard = guard(Interpolation::Linear, checked);
    let hub = at((-3000, 0));
    guard.locate(hub.in_plane()).expect("it is clear");
    (guard, hub)
}

/// Out and back along each spoke.
fn contours_end_after_their_last_motion(spokes: &[Xy], checked: bool) {
    let (mut guard, hub) = at_rest(checked);
    let motions: Vec<ContourMotion> =
        spokes.iter().flat_map(|&tip| [line(hub, at(tip)), line(at(tip), hub)]).collect();
    let count = motions.len();
    guard.begin_contour(motions).expect("it begins at the tool");
    assert_eq!(guard.certify_contour(usize::MAX), Ok(Certification::Done), "{spokes:?}");
    let rest = |guard: &mut Guard, place: Point| {
        let stamp = guard.stamp(Time::ZERO);
        guard.reported(&feedback(place, true, 0), stamp, Time::ZERO).expect("it is on the contour");
        guard.contour_progress()
    };
    for k in 1..=count {
        let place = guard.next_of_contour().expect("the one before was read").target().point;
        guard.acknowledged().expect("one line");
        let ends = k == count;
        let first = rest(&mut guard, place);
        assert_eq!(first.is_none(), ends && checked, "{spokes:?} {checked}: motion {k} of {count}");
        if !(ends && checked) {
            assert_eq!(
                rest(&mut guard, place).is_none(),
                ends,
                "{spokes:?} {checked}: motion {k} of {count}"
            );
        }
    }
    assert!(guard.in_position(), "{spokes:?} {checked}");
}

fn contours_begin_without_lines_in_flight(to: Xy, acknowledged: bool) {
    let (mut guard, hub) = at_rest(false);
    guard.jog(at(to).in_plane(), 600).expect("it is clear");
    if acknowledged {
        guard.acknowledged().expect("one line");
    }
    let contour = || vec![line(hub, at((-9000, 0)))];
    assert_eq!(guard.begin_contour(contour()), Err(Refusal::InMotion), "{to:?}");
    assert_eq!(guard.locate(hub.in_plane()), Err(Refusal::InMotion), "{to:?}");
    if !acknowledged {
        return;
    }
    for now in [Time::ZERO, Time::ZERO.after(PARSING)] {
        let stamp = guard.stamp(now);
        guard.reported(&feedback(hub, true, 0), stamp, now).expect("it has not moved");
    }
    assert_eq!(guard.begin_contour(contour()), Ok(()), "{to:?}: it rests");
}

/// An arc of 74° whose middle is as far beyond the left or lower border as stated. Its radius is 5 `size`, and its ends
/// are `size` behind its middle.
fn arcs_beyond_the_travel_are_refused(size: i64, beyond: i64, below: bool) {
    let middle = -TRAVEL - beyond;
    let turned = |(x, y): Xy| at(if below { (y, x) } else { (x, y) });
    let [from, to, centre] =
        [(middle + size, 3 * size), (middle + size, -3 * size), (middle + 5 * size, 0)].map(turned);
    let turn = if below { Turn::Clockwise } else { Turn::CounterClockwise };
    let arc = Arc::new(from, to, centre, turn).expect("its ends are on the circle");
    let mut guard = guard(Interpolation::Linear, true);
    guard.locate(from.in_plane()).expect("it is clear");
    guard.begin_contour(vec![ContourMotion::in_plane(Curve::Arc(arc), 300)]).expect("it begins at the tool");
    let certified = guard.certify_contour(1);
    // The chords leave the curve by at most 200 units, inward.
    if beyond > 200 {
        assert!(matches!(certified, Err(Refusal::SoftLimit(_))), "{size} {beyond} {below}: {certified:?}");
    } else if beyond <= 0 {
        assert_eq!(certified, Ok(Certification::Done), "{size} {beyond} {below}");
    }
}

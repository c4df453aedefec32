//! The guard: which reports are evidence that a line was executed.

use std::time::Duration;

use keepout_guard::{
    Certification, ContourMotion, DRAIN, Guard, Interpolation, OnCancel, PARSING, PositionFeedback, Refusal,
    Time,
};
use keepout_kernel::{Curve, Point, Segment};

use super::guard::{feedback, guard};
use super::heights::{self, HEIGHT_RESOLUTION, HIGHEST, LOWEST};
use super::{Xy, Xyz};
use crate::families::at;
use crate::property::properties;
use crate::square::place;

properties! {
    "guard: reports", "executor/guard/src/in_flight.rs, rest.rs, contour.rs";
    // Evidence for SR-08.
    one_queue_length_is_no_evidence |d| {
        let lie = d.one_of(6);
        one_queue_length_is_no_evidence(d.int(0, 1000), d.int(0, 60), lie)
    }
        => "without a checksum, one report of a queue that is too short completes no line, whatever reports follow";
        random 20_000;
    lines_complete_only_when_the_query_left_late_enough |d| {
        let early = u64::try_from(d.int(1, 600_000)).unwrap_or(1);
        lines_complete_only_when_the_query_left_late_enough(d.int(0, 1000), early, d.coin())
    }
        => "a line whose block left the queue completes only by a report whose query left at least the drain time \
            after that was known, however late the report arrives; then it does complete, and without a checksum by \
            the second such report";
        random 20_000;
    rest_shows_when_no_line_can_be_in_parsing |d| {
        let early = u64::try_from(d.int(1, 50_000)).unwrap_or(1);
        rest_shows_when_no_line_can_be_in_parsing(Stopped::ALL[d.one_of(4)], early, d.int(0, 5), d.coin())
    }
        => "after a rejected line or a cancel, no reports at rest settle whose queries left earlier than a controller \
            parses a line after the first of them arrived, however many; the next one does. Without either, two \
            reports settle";
        random 20_000;
    // Evidence for SR-09.
    contour_heights_off_the_motion_are_refused |d| {
        // Above the table.
        let heights = [d.int(-1000, HIGHEST), d.int(-1000, HIGHEST)];
        contour_heights_off_the_motion_are_refused(heights, d.int(LOWEST - 50, HIGHEST + 50), d.coin())
    }
        => "in a contour, a report above or below the heights of the motion under way is refused, and one between \
            them is not";
        random 20_000;
}

/// A jog north, and a jog west. Both are acknowledged, and the controller has read both.
fn two_jogs(aside: i64, checked: bool) -> (Guard, Point) {
    let mut guard = guard(Interpolation::Linear, checked);
    let [start, first, second] = [(-1000 - aside, 0), (-1000 - aside, 2000), (-3000 - aside, 2000)].map(at);
    guard.locate(start.in_plane()).expect("it is clear");
    for target in [first, second] {
        guard.jog(target.in_plane(), 600).expect("it is clear");
        guard.acknowledged().expect("one line");
        let stamp = guard.stamp(Time::ZERO);
        guard.reported(&feedback(start, false, 2), stamp, Time::ZERO).expect("it has not moved");
    }
    (guard, first)
}

/// Places in the triangle of the two jogs, ever nearer to the second target.
fn between(aside: i64, step: i64, k: i64) -> Xy {
    let along = k * (160 + step);
    (-1050 - aside - along, 1000 + along * 5 / 8)
}

fn one_queue_length_is_no_evidence(aside: i64, step: i64, lie: usize) {
    let (mut guard, first) = two_jogs(aside, false);
    for k in 0..6 {
        let now = Time::ZERO.after((DRAIN + DRAIN / 2) * u32::try_from(k).unwrap_or(0));
        let place = between(aside, step, i64::try_from(k).unwrap_or(0));
        let stamp = guard.stamp(now);
        let queued = if k == lie { 0 } else { 2 };
        guard.reported(&feedback(at(place), false, queued), stamp, now).expect("it is in the hull");
        assert!(guard.in_flight().any(|point| point == first), "{aside} {step} {lie}: at report {k}");
    }
}

/// Two reports show that the first motion left the queue. Then the tool is on the second one.
fn lines_complete_only_when_the_query_left_late_enough(aside: i64, early_us: u64, checked: bool) {
    let (mut guard, first) = two_jogs(aside, checked);
    let seen = Time::ZERO.after(DRAIN * 2);
    for _ in 0..2 {
        let stamp = guard.stamp(seen);
        guard.reported(&feedback(first, false, 1), stamp, seen).expect("it is in the hull");
    }
    let on_the_second = |k: i64| at((-1200 - aside - 200 * k, 2000));
    let kept = |guard: &Guard| guard.in_flight().any(|point| point == first);
    let early = DRAIN.saturating_sub(Duration::from_micros(early_us)).min(DRAIN - Duration::from_micros(1));
    for k in 0..3 {
        let stamp = guard.stamp(seen.after(early));
        let place = on_the_second(k);
        let arrives = seen.after(DRAIN * 4);
        guard.reported(&feedback(place, false, 1), stamp, arrives).expect("it is in the hull");
        assert!(kept(&guard), "{aside} {early_us} {checked}: the query left too early");
    }
    for k in 3..6 {
        let now = seen.after(DRAIN * 5);
        let stamp = guard.stamp(now);
        guard.reported(&feedback(on_the_second(k), false, 1), stamp, now).expect("it is in the hull");
        // Without a checksum the place in one report may be false.
        let stays = !checked && k == 3;
        assert_eq!(kept(&guard), stays, "{aside} {early_us} {checked}: after {} late reports", k - 2);
    }
}

/// What ended the last jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stopped {
    AtItsTarget,
    ByRejection,
    ByCancel,
    ByCancelThatStrays,
}

impl Stopped {
    const ALL: [Self; 4] = [Self::AtItsTarget, Self::ByRejection, Self::ByCancel, Self::ByCancelThatStrays];
}

/// A jog, and reports at rest. A report in motion between them makes them count anew.
fn rest_shows_when_no_line_can_be_in_parsing(stopped: Stopped, early_us: u64, reports: i64, moves: bool) {
    let mut guard = guard(Interpolation::Linear, false);
    guard.locate(at((-3000, 0)).in_plane()).expect("it is clear");
    guard.jog(at((-3000, 2000)).in_plane(), 1).expect("it is clear");
    match stopped {
        Stopped::AtItsTarget => guard.acknowledged().expect("one line"),
        Stopped::ByRejection => assert!(guard.refused()),
        Stopped::ByCancel | Stopped::ByCancelThatStrays => {
            let strays = stopped == Stopped::ByCancelThatStrays;
            let on_cancel = if strays { OnCancel::MayStray } else { OnCancel::KeepsPath };
            guard.learn_of_cancels(on_cancel, Some(u64::MAX));
            guard.cancel().map(drop).expect("it is clear around");
            guard.acknowledged().expect("one line");
        }
    }
    let mut report = |rests, asked: Time| {
        let stamp = guard.stamp(asked);
        guard
            .reported(&feedback(at((-3000, 1000)), rests, 0), stamp, asked.after(DRAIN))
            .expect("it is in the hull");
        guard.in_position()
    };
    assert!(!report(true, Time::ZERO), "{stopped:?}: one report is no evidence");
    let mut first = Time::ZERO.after(DRAIN);
    if stopped == Stopped::AtItsTarget {
        assert!(report(true, first), "two reports agree");
        return;
    }
    if moves {
        assert!(!report(false, first.after(2 * PARSING)) && !report(true, first.after(3 * PARSING)));
        first = first.after(3 * PARSING + DRAIN);
    }
    let early = first.after(PARSING - Duration::from_micros(early_us));
    for _ in 0..reports {
        assert!(!report(true, early), "{stopped:?} {early_us} {moves}: the query left too early");
    }
    assert!(report(true, first.after(PARSING)), "{stopped:?} {reports} {moves}: no line can be in parsing");
}

/// A contour of two motions far from the plate. The report is in the middle of the first or the second one.
fn contour_heights_off_the_motion_are_refused([from, to]: [i64; 2], reported: i64, second: bool) {
    let mut guard = heights::guard(Interpolation::Linear, true);
    let corners = [(-9000, -9000, from), (-9000, 9000, to), (-9000, 12_000, to)];
    guard.locate(place(corners[0])).expect("it is clear");
    let motion = |pair: &[Xyz]| {
        let [from, to] = [place(pair[0]), place(pair[1])];
        let curve = Curve::Line(Segment { from: from.point, to: to.point });
        ContourMotion { curve, heights: [from.height, to.height], feed_mm_min: 300 }
    };
    guard.begin_contour(corners.windows(2).map(motion).collect()).expect("it begins at the tool");
    assert_eq!(guard.certify_contour(usize::MAX), Ok(Certification::Done), "{from} {to}");
    for _ in 0..=usize::from(second) {
        assert!(guard.next_of_contour().is_some());
        guard.acknowledged().expect("one line");
    }
    let (y, range) = if second { (11_000, to..=to) } else { (0, from.min(to)..=from.max(to)) };
    let position = place((-9000, y, reported));
    let feedback = PositionFeedback { position, in_position: false, queued: Some(1), waiting: false };
    let stamp = guard.stamp(Time::ZERO);
    let outcome = guard.reported(&feedback, stamp, Time::ZERO);
    let off = (range.start() - reported).max(reported - range.end());
    if off > 2 * HEIGHT_RESOLUTION {
        assert_eq!(outcome, Err(Refusal::OffCertified(position.point)), "{from} {to} {reported} {second}");
    } else if off <= 0 {
        assert!(outcome.is_ok(), "{from} {to} {reported} {second}");
    }
}

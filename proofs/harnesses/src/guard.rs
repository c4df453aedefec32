//! The guard: evidence, cancels, contours, and the counts of lines.

use alloc::sync::Arc;
use alloc::vec;
use core::time::Duration;

use keepout_guard::{
    Certification, ContourMotion, FeedOverride, Guard, HeightRules, Interpolation, OnCancel,
    PositionFeedback, Refusal, Rules, Time,
};
use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Curve, Levels, Point, Segment};

use crate::lattice::{at, height, length};
use crate::parts::square;
use crate::{Cases, harnesses};

harnesses! {
    // Evidence for SR-08.
    "executor/guard/src/time.rs" {
        times_add_up_to_the_last_moment:
            "a moment after a span is later by it, or the last moment", "every moment, spans of up to 2^32 µs",
            unwind 1;
        time_since_a_later_moment_is_zero:
            "the time since a moment is the difference, or zero", "every pair of moments", unwind 1;
    }
    // Evidence for SR-24.
    "executor/guard/src/motion.rs" {
        overrides_only_slow:
            "a feed under an override is no faster, and not zero unless the feed is", "every feed and percentage",
            unwind 1;
        overrides_are_within_their_range:
            "an override is 25 to 100 per cent, and the given one within that range", "every percentage", unwind 1;
    }
    // Evidence for SR-13, SR-15.
    "executor/guard/src/rules.rs" {
        permitted_heights_are_within_the_travel:
            "a height is permitted exactly from the lowest to the highest", "every three heights", unwind 1;
        heights_are_certified_lower_by_the_margin:
            "the certified height is lower by the margin, or the lowest", "every height and margin", unwind 1;
    }
    // Evidence for SR-08.
    "executor/guard/src/evidence.rs" {
        rest_needs_an_empty_queue:
            "a report shows rest only at rest, with no queue and nothing waiting", "every such report", unwind 1;
    }
    "executor/guard/src/rest.rs" {
        two_reports_at_rest_empty_the_set:
            "without a checksum, one report in position at the target leaves it in the set, and a second one does not",
            "two reports at the target, the second in position or not", unwind 32;
    }
    "executor/guard/src/nearest.rs" {
        reports_are_as_near_as_the_box_allows:
            "with non-interpolated axes, a report is believed up to its bound beside the box, and no farther",
            "the last place that is believed, and the next", unwind 32;
    }
    // Evidence for SR-08, SR-10.
    "executor/guard/src/lib.rs" {
        acknowledgements_need_a_line:
            "the guard counts an acknowledgement only for a line that was sent",
            "no line or one line, then two acknowledgements", unwind 32;
        a_rejected_line_stays_in_the_set:
            "the target of a rejected line stays in the in-flight set", "a line acknowledged or not", unwind 32;
    }
    // Evidence for SR-11.
    "executor/guard/src/cancel.rs" {
        cancels_are_never_sent_where_there_are_none:
            "a guard of a controller without a cancel permits none", "with or without a line in flight", unwind 32;
        a_second_cancel_waits:
            "after a cancel the guard refuses another until a later line is acknowledged",
            "acknowledged or not", unwind 32;
        no_jog_follows_a_cancel_that_may_stray:
            "after a cancel that may leave the path no jog is admitted before rest",
            "five targets beside the tool", unwind 32;
    }
    // Evidence for SR-12.
    "executor/guard/src/contour.rs" {
        contours_wait_for_each_line:
            "the next motion is handed out only after the one before is acknowledged", "acknowledged or not", unwind 32;
    }
}

const RESOLUTION: i32 = 8;
const JOGGING: i32 = 30;
const FINISHING: i32 = 10;
/// Where the tool stands first, right of the square.
const START: (i32, i32) = (600, 0);
/// The target of the first line.
const TARGET: (i32, i32) = (600, 300);

fn rules() -> Rules {
    Rules {
        travel: Window::of(at(-900, -900)).including(at(900, 900)),
        jogging_clearance: length(JOGGING),
        finishing_clearance: length(FINISHING),
        resolution: length(RESOLUTION),
        shortest: length(2),
        interpolation: Interpolation::Linear,
        on_cancel: OnCancel::KeepsPath,
        contours: Interpolation::Linear,
        checked: true,
        heights: HeightRules {
            lowest: height(-500),
            highest: height(500),
            margin: length(5),
            resolution: length(RESOLUTION),
            shortest: length(2),
        },
    }
}

/// A guard of a square of 8 units, with the tool at rest right of it.
fn guard(rules: Rules) -> Guard {
    let part = Arc::new(Levels::flat(Arc::new(square())));
    let mut guard = Guard::new(Arc::clone(&part), part, rules);
    guard.locate(at(START.0, START.1).in_plane()).expect("the start is free");
    guard
}

/// The same with a line to the target in flight.
fn jogging(rules: Rules) -> Guard {
    let mut guard = guard(rules);
    guard.jog(target().in_plane(), 600).expect("the way is free");
    guard
}

fn target() -> Point {
    at(TARGET.0, TARGET.1)
}

fn flies(guard: &Guard, to: Point) -> bool {
    guard.in_flight().any(|point| point == to)
}

fn times_add_up_to_the_last_moment(c: &mut impl Cases) {
    let (micros, span) = (c.wide().cast_unsigned(), c.int(0, i32::MAX).cast_unsigned());
    let later = Time::from_micros(micros).after(Duration::from_micros(span.into()));
    assert!(later.micros() == micros.saturating_add(span.into()));
}

fn time_since_a_later_moment_is_zero(c: &mut impl Cases) {
    let (one, other) = (c.wide().cast_unsigned() >> 20, c.wide().cast_unsigned() >> 20);
    let since = Time::from_micros(one).since(Time::from_micros(other));
    assert!(since == Duration::from_micros(one.saturating_sub(other)));
}

fn overrides_only_slow(c: &mut impl Cases) {
    let (percent, feed) = (c.up_to(255), c.int(0, i32::MAX).cast_unsigned());
    let slowed = FeedOverride::of_percent(percent).of(feed);
    assert!(slowed <= feed && (slowed > 0 || feed == 0));
}

fn overrides_are_within_their_range(c: &mut impl Cases) {
    let percent = c.up_to(255);
    let kept = FeedOverride::of_percent(percent).percent();
    assert!((25..=100).contains(&kept) && (kept == percent || !(25..=100).contains(&percent)));
}

fn permitted_heights_are_within_the_travel(c: &mut impl Cases) {
    let mut any = || height(c.int(-COORD_MAX, COORD_MAX));
    let (lowest, highest, at) = (any(), any(), any());
    let rules = HeightRules { lowest, highest, ..HeightRules::TWO_AXES };
    assert!(rules.permit(at) == (lowest.units() <= at.units() && at.units() <= highest.units()));
}

fn heights_are_certified_lower_by_the_margin(c: &mut impl Cases) {
    let (units, margin) = (c.int(-COORD_MAX, COORD_MAX), c.int(0, COORD_MAX));
    let rules = HeightRules { margin: length(margin), ..HeightRules::TWO_AXES };
    let exact = i64::from(units) - i64::from(margin);
    assert!(i64::from(rules.certified_for(height(units)).units()) == exact.max(-i64::from(COORD_MAX)));
}

fn rest_needs_an_empty_queue(c: &mut impl Cases) {
    let (in_position, waiting, some) = (c.coin(), c.coin(), c.coin());
    let queued = some.then_some(usize::from(c.up_to(255)));
    let feedback = PositionFeedback { position: Point::ORIGIN.in_plane(), in_position, queued, waiting };
    let empty = queued.is_none() || queued == Some(0);
    assert!(feedback.rests() == (in_position && !waiting && empty));
}

/// A report of this place, in position or not, of a controller that has read all.
fn report(guard: &mut Guard, place: Point, in_position: bool) -> Result<(), Refusal> {
    let feedback = PositionFeedback { position: place.in_plane(), in_position, queued: None, waiting: false };
    let stamp = guard.stamp(Time::ZERO);
    guard.reported(&feedback, stamp, Time::ZERO)
}

fn two_reports_at_rest_empty_the_set(c: &mut impl Cases) {
    // A call for each case, as CBMC is slow where it does not know whether the set is empty.
    if c.coin() {
        assert!(places_after_rest_and(true) == 1);
    } else {
        assert!(places_after_rest_and(false) == 3);
    }
}

/// How many places the set has after a report in position at the target, and another: two confirmed positions and the
/// target, or one.
fn places_after_rest_and(in_position: bool) -> usize {
    let mut guard = jogging(Rules { checked: false, ..rules() });
    guard.acknowledged().expect("a line was sent");
    report(&mut guard, target(), true).expect("it is a place of the set");
    report(&mut guard, target(), in_position).expect("it is a place of the set");
    guard.in_flight().count()
}

fn reports_are_as_near_as_the_box_allows(c: &mut impl Cases) {
    // A report is believed up to two resolutions and a unit from the set.
    let most = 2 * RESOLUTION + 1;
    // Two calls with a place each, as CBMC does not finish with a place that it does not know.
    if c.coin() {
        assert!(is_believed(START.0 + most));
    } else {
        assert!(!is_believed(START.0 + most + 1));
    }
}

/// Whether a guard of non-interpolated axes believes a report there, halfway to the target.
fn is_believed(x: i32) -> bool {
    let mut guard = jogging(Rules { interpolation: Interpolation::Independent, ..rules() });
    report(&mut guard, at(x, 150), false).is_ok()
}

fn acknowledgements_need_a_line(c: &mut impl Cases) {
    let mut guard = guard(rules());
    let sent = c.coin();
    if sent {
        guard.jog(target().in_plane(), 600).expect("the way is free");
    }
    assert!(guard.acknowledged().is_ok() == sent);
    assert!(guard.acknowledged() == Err(Refusal::UnexpectedAcknowledgement));
}

fn a_rejected_line_stays_in_the_set(c: &mut impl Cases) {
    let mut guard = jogging(rules());
    let acknowledged = c.coin();
    if acknowledged {
        guard.acknowledged().expect("a line was sent");
    }
    assert!(guard.refused() != acknowledged);
    assert!(flies(&guard, target()));
}

fn cancels_are_never_sent_where_there_are_none(c: &mut impl Cases) {
    let rules = Rules { on_cancel: OnCancel::NotOffered, ..rules() };
    let mut guard = guard(rules);
    if c.coin() {
        guard.jog(target().in_plane(), 600).expect("the way is free");
    }
    assert!(guard.cancel().is_err());
}

fn a_second_cancel_waits(c: &mut impl Cases) {
    let mut guard = jogging(rules());
    assert!(guard.cancel().is_ok());
    if c.coin() {
        guard.acknowledged().expect("a line was sent");
    }
    assert!(guard.cancel() == Err(Refusal::Cancelled));
}

fn no_jog_follows_a_cancel_that_may_stray(c: &mut impl Cases) {
    let rules = Rules { on_cancel: OnCancel::MayStray, ..rules() };
    let mut guard = guard(rules);
    // At 1 mm/min the tool stops within 252 units.
    guard.learn_of_cancels(OnCancel::MayStray, Some(1 << 40));
    guard.jog(target().in_plane(), 1).expect("the way is free");
    assert!(guard.cancel().is_ok());
    assert!(guard.jog(at(600, 100 * c.int(-2, 2)).in_plane(), 1).is_err());
}

fn line(from: Point, to: Point) -> ContourMotion {
    ContourMotion::in_plane(Curve::Line(Segment { from, to }), 300)
}

fn contours_wait_for_each_line(c: &mut impl Cases) {
    let mut guard = guard(rules());
    let motions = vec![line(at(600, 0), at(600, 100)), line(at(600, 100), at(600, 200))];
    guard.begin_contour(motions).expect("it begins at the tool");
    assert!(guard.certify_contour(2) == Ok(Certification::Done));
    assert!(guard.next_of_contour().is_some());
    let acknowledged = c.coin();
    if acknowledged {
        guard.acknowledged().expect("a line was sent");
    }
    assert!(guard.next_of_contour().is_some() == acknowledged);
}

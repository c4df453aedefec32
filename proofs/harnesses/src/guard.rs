//! The guard: hulls, evidence, cancels, contours, and the counts of lines.

use alloc::sync::Arc;
use alloc::vec;
use core::time::Duration;

use keepout_guard::{
    Certification, ContourMotion, FeedOverride, Guard, HeightRules, Hull, Interpolation, OnCancel,
    PositionFeedback, Refusal, Rules, Time,
};
use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::segment::{Orientation, Window, orientation};
use keepout_kernel::{Curve, Height, Levels, Point, Segment};

use crate::lattice::{at, height, length, near_origin, point};
use crate::parts::square;
use crate::{Cases, harnesses};

harnesses! {
    "executor/guard/src/hull.rs" {
        hulls_hold_their_points:
            "the hull of three points holds each of them", "points within ±1", unwind 32;
        hulls_turn_left:
            "three corners of a hull turn left", "points within ±1", unwind 32;
        hulls_of_one_place_are_one_point:
            "the hull of equal points is that point, and holds no other", "any two points of the lattice", unwind 32;
    }
    "executor/guard/src/time.rs" {
        times_add_up_to_the_last_moment:
            "a moment after a span is later by it, or the last moment", "every moment, spans of up to 2^32 µs",
            unwind 1;
        time_since_a_later_moment_is_zero:
            "the time since a moment is the difference, or zero", "every pair of moments", unwind 1;
    }
    "executor/guard/src/motion.rs" {
        overrides_only_slow:
            "a feed under an override is no faster, and not zero unless the feed is", "every feed and percentage",
            unwind 1;
        overrides_are_within_their_range:
            "an override is 25 to 100 per cent, and the given one within that range", "every percentage", unwind 1;
    }
    "executor/guard/src/rules.rs" {
        permitted_heights_are_within_the_travel:
            "a height is permitted exactly from the lowest to the highest", "every three heights", unwind 1;
        heights_are_certified_lower_by_the_margin:
            "the certified height is lower by the margin, or the lowest", "every height and margin", unwind 1;
    }
    "executor/guard/src/evidence.rs" {
        rest_needs_an_empty_queue:
            "a report shows rest only at rest, with no queue and nothing waiting", "every such report", unwind 1;
    }
    "executor/guard/src/lib.rs" {
        acknowledgements_need_a_line:
            "the guard counts an acknowledgement only for a line that was sent",
            "no line or one line, then two acknowledgements", unwind 32;
        a_rejected_line_stays_in_the_set:
            "the target of a rejected line stays in the in-flight set", "a line acknowledged or not", unwind 32;
        jogs_stay_within_the_travel:
            "an admitted jog ends within the travel, sideways and up", "targets at any point and height", unwind 32;
    }
    "executor/guard/src/in_flight.rs" {
        a_line_stays_until_it_is_acknowledged:
            "the target of an unacknowledged line stays, whatever is reported",
            "reports of any kind at the start, the target or between", unwind 32;
        a_line_stays_while_the_tool_moves:
            "the target of an acknowledged line stays while a report shows motion or waiting input",
            "reports that do not show rest", unwind 32;
        one_report_of_rest_is_no_evidence_without_a_checksum:
            "without a checksum the target stays after one report of rest", "reports of any kind", unwind 32;
        reports_off_the_set_are_refused:
            "a report farther from the set than twice the resolution and a unit is refused",
            "reports up to 40 units beside the line, a resolution of 8", unwind 32;
        the_lowest_height_counts_every_place:
            "the lowest height of the set is the lower of the tool's height and the target's",
            "heights within ±400", unwind 32;
    }
    "executor/guard/src/cancel.rs" {
        cancels_are_never_sent_where_there_are_none:
            "a guard of a controller without a cancel permits none", "with or without a line in flight", unwind 32;
        a_second_cancel_waits:
            "after a cancel the guard refuses another until a later line is acknowledged",
            "acknowledged or not", unwind 32;
        no_jog_follows_a_cancel_that_may_stray:
            "after a cancel that may leave the path no jog is admitted before rest",
            "five targets beside the tool", unwind 32;
        a_cancel_that_may_stray_needs_its_stopping_distance:
            "a cancel that may leave the path is sent only when the set is clear by the stopping distance, too",
            "targets 236 to 336 units from the square, a stopping distance of 252", unwind 32;
    }
    "executor/guard/src/contour.rs" {
        contours_begin_at_the_tool:
            "a contour begins within the resolution of the tool", "starts within 12 units, a resolution of 8", unwind 32;
        contours_wait_for_each_line:
            "the next motion is handed out only after the one before is acknowledged", "acknowledged or not", unwind 32;
        contours_are_joined:
            "a contour is certified only when its motions join", "the joint off by up to 1 unit", unwind 32;
        contours_keep_the_finishing_clearance:
            "a certified motion beside the square keeps the finishing clearance",
            "vertical lines 1 to 40 units right of the square, a clearance of 10", unwind 32;
    }
    "executor/guard/src/admission.rs" {
        jogs_through_the_part_are_refused:
            "no jog from the right of the square leads to the left of it", "targets up to 60 units left of it",
            unwind 32;
        rises_only_rise:
            "an admitted rise leads up", "every height", unwind 32;
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

/// A report of any kind at the start, the target or half-way.
fn report(c: &mut impl Cases) -> PositionFeedback {
    let y = 150 * c.int(0, 2);
    let queued = c.coin().then_some(usize::from(c.coin()));
    PositionFeedback { position: at(600, y).in_plane(), in_position: c.coin(), queued, waiting: c.coin() }
}

fn hulls_hold_their_points(c: &mut impl Cases) {
    let points = [near_origin(c, 1), near_origin(c, 1), near_origin(c, 1)];
    let hull = Hull::of(points.into_iter()).expect("three points have a hull");
    assert!(points.into_iter().all(|point| hull.holds(point)));
}

fn hulls_turn_left(c: &mut impl Cases) {
    let points = [near_origin(c, 1), near_origin(c, 1), near_origin(c, 1)];
    let hull = Hull::of(points.into_iter()).expect("three points have a hull");
    if let &[a, b, d] = hull.corners() {
        assert!(orientation(a, b, d) == Orientation::Left);
    }
}

fn hulls_of_one_place_are_one_point(c: &mut impl Cases) {
    let (p, q) = (point(c), point(c));
    let hull = Hull::of([p, p].into_iter()).expect("a point has a hull");
    assert!(hull.corners().len() == 1 && hull.holds(q) == (p == q));
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

fn jogs_stay_within_the_travel(c: &mut impl Cases) {
    let mut guard = guard(rules());
    let (to, up) = (point(c), c.int(-COORD_MAX, COORD_MAX));
    // Below the tool's height the part would be asked: that is the question of other harnesses.
    let (x, y) = (to.x.units(), to.y.units());
    let within = x.abs() <= 900 && y.abs() <= 900 && up.abs() <= 500;
    if !within {
        assert!(guard.jog(to.at_height(height(up)), 600).is_err());
    }
}

fn a_line_stays_until_it_is_acknowledged(c: &mut impl Cases) {
    let mut guard = jogging(rules());
    let stamp = guard.stamp(Time::ZERO);
    let _ = guard.reported(&report(c), stamp, Time::ZERO);
    assert!(flies(&guard, target()));
}

fn a_line_stays_while_the_tool_moves(c: &mut impl Cases) {
    let mut guard = jogging(rules());
    guard.acknowledged().expect("a line was sent");
    let stamp = guard.stamp(Time::ZERO);
    let report = report(c);
    let _ = guard.reported(&report, stamp, Time::ZERO);
    assert!(report.rests() || flies(&guard, target()));
}

fn one_report_of_rest_is_no_evidence_without_a_checksum(c: &mut impl Cases) {
    let mut guard = jogging(Rules { checked: false, ..rules() });
    guard.acknowledged().expect("a line was sent");
    let stamp = guard.stamp(Time::ZERO);
    let _ = guard.reported(&report(c), stamp, Time::ZERO);
    assert!(flies(&guard, target()));
}

fn reports_off_the_set_are_refused(c: &mut impl Cases) {
    let mut guard = jogging(rules());
    let aside = c.int(0, 40);
    let position = at(600 + aside, 150).in_plane();
    let report = PositionFeedback { position, in_position: false, queued: Some(1), waiting: false };
    let stamp = guard.stamp(Time::ZERO);
    let taken = guard.reported(&report, stamp, Time::ZERO).is_ok();
    assert!(taken == (aside <= 2 * RESOLUTION + 1));
}

fn the_lowest_height_counts_every_place(c: &mut impl Cases) {
    let mut guard = guard(rules());
    let up = c.int(-400, 400);
    guard.jog(target().at_height(height(up)), 600).expect("the way is free at every height");
    assert!(guard.lowest() == Some(height(up.min(0))));
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

fn a_cancel_that_may_stray_needs_its_stopping_distance(c: &mut impl Cases) {
    let rules = Rules { on_cancel: OnCancel::MayStray, ..rules() };
    let mut guard = guard(rules);
    guard.learn_of_cancels(OnCancel::MayStray, Some(1 << 40));
    guard.jog(at(600, 100).in_plane(), 1).expect("the way is free");
    let x = c.int(240, 340);
    guard.jog(at(x, 0).in_plane(), 1).expect("the way is free");
    // The square ends at x = 4. Twice the resolution and some units of rounding belong to the reach.
    assert!(guard.cancel().is_err() || x - 4 > JOGGING + 252 + 2 * RESOLUTION);
}

fn line(from: Point, to: Point) -> ContourMotion {
    ContourMotion::in_plane(Curve::Line(Segment { from, to }), 300)
}

fn contours_begin_at_the_tool(c: &mut impl Cases) {
    let mut guard = guard(rules());
    let dy = c.int(-12, 12);
    let begun = guard.begin_contour(vec![line(at(600, dy), at(600, 100))]).is_ok();
    assert!(begun == (dy.abs() <= RESOLUTION));
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

fn contours_are_joined(c: &mut impl Cases) {
    let mut guard = guard(rules());
    let (dx, dy) = (c.int(-1, 1), c.int(-1, 1));
    let motions = vec![line(at(600, 0), at(600, 100)), line(at(600 + dx, 100 + dy), at(600, 200))];
    guard.begin_contour(motions).expect("it begins at the tool");
    assert!(guard.certify_contour(2).is_ok() == (dx == 0 && dy == 0));
}

fn contours_keep_the_finishing_clearance(c: &mut impl Cases) {
    let part = Arc::new(Levels::flat(Arc::new(square())));
    let mut guard = Guard::new(Arc::clone(&part), part, rules());
    let x = 4 + c.int(1, 40);
    if guard.locate(at(x, 100).in_plane()).is_err() {
        return;
    }
    let motions = vec![line(at(x, 100), at(x, 0)), line(at(x, 0), at(x, 100))];
    if guard.begin_contour(motions).is_ok() && guard.certify_contour(2).is_ok() {
        assert!(x - 4 > FINISHING);
    }
}

fn jogs_through_the_part_are_refused(c: &mut impl Cases) {
    let mut guard = guard(rules());
    let x = c.int(-64, -4);
    assert!(guard.jog(at(x, 0).in_plane(), 600).is_err());
}

fn rises_only_rise(c: &mut impl Cases) {
    let mut guard = guard(rules());
    let up = c.int(-COORD_MAX, COORD_MAX);
    assert!(guard.rise(height(up), 600).is_ok() == (1 < up && up <= 500));
    assert!(guard.lowest() == Some(Height::ZERO));
}

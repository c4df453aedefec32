//! The guard: hull, admission, position feedback, contours.

use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};

use keepout_guard::Hull;
use keepout_guard::{
    Certification, Certified, ContourMotion, DRAIN, FeedOverride, Guard, HeightRules, Interpolation, Motion,
    OnCancel, PositionFeedback, Refusal, Rules, Time,
};
use keepout_kernel::exact::segment::{Orientation, Window, distance_2, orientation};
use keepout_kernel::offset::shortest_arc;
use keepout_kernel::{
    Curve, Height, Length, Levels, Point, ProhibitedRegion, Region, Ring, Segment, Side, Triangle, Turn,
};

use super::Xy;
use crate::draw::Draw;
use crate::families::{at, length};
use crate::property::{passed_over, properties};

properties! {
    "guard", "executor/guard/src/";
    // Evidence for SR-07.
    hull_holds_its_points_and_no_others |d| {
        let set: Vec<Xy> = (0..3).map(|_| d.point()).collect();
        hull_holds_its_points_and_no_others(&set, d.point())
    }
        => "the hull of a set holds a point exactly when some triangle of the set does; its corners \
            belong to the set and turn left";
        every 2 random 20_000;
    large_hulls_hold_their_points_and_no_others |d| {
        let set = crowd(d);
        hull_holds_its_points_and_no_others(&set, crowd(d)[0])
    }
        => "the same for sets of one to fourteen points";
        random 20_000;
    hulls_of_more_than_fourteen_are_none |d| hulls_of_more_than_fourteen_are_none(d.one_of(30))
        => "a set with more points than the guard keeps has no hull, and neither has an empty set";
        every 1;
    nearest_of_a_hull_is_nearest |d| {
        let set: Vec<Xy> = (0..3).map(|_| d.point()).collect();
        let probe = d.point();
        nearest_of_a_hull_is_nearest(&set, probe, d.point())
    }
        => "the reported nearest point is in the hull, and no point of the hull is nearer, both to a unit";
        every 2 random 40_000;
    admitted_jogs_keep_the_hull_clear |d| {
        let targets: Vec<Xy> = (0..6).map(|_| field(d)).collect();
        admitted_jogs_keep_the_hull_clear(field(d), &targets, d.coin())
    }
        => "after any jogs, every triangle of the set's points, or the box around them, keeps the jogging \
            clearance";
        random 8_000;
    // Evidence for SR-11.
    admitted_cancels_keep_their_reach_clear |d| {
        let (speed, brakes) = (d.int(0, 6), d.int(1, 40));
        admitted_cancels_keep_their_reach_clear([field(d), field(d), field(d)], [speed, brakes], d.coin())
    }
        => "a cancel that may leave the path is admitted exactly when the hull with the stopping distance \
            added, or the box with that of each axis, is clear; no jog and no second cancel is admitted \
            before the tool is at rest";
        random 20_000;
    // Evidence for SR-08, SR-09.
    reports_are_never_farther_than_they_were |d| {
        let share = d.int(0, 16);
        reports_are_never_farther_than_they_were(
            [field(d), field(d), field(d)],
            share,
            [d.int(-3, 3), d.int(-3, 3)],
            d.coin(),
        )
    }
        => "the confirmed position is in the hull and no farther from the true position than the report, \
            to rounding";
        random 20_000;
    reports_off_the_set_are_refused |d| reports_off_the_set_are_refused([field(d), field(d)], field(d))
        => "a report farther than twice the resolution from the set is refused and does not change the \
            set";
        random 20_000;
    // Evidence for SR-08, SR-10.
    acknowledgements_are_counted |d| {
        let acts: Vec<usize> = (0..12).map(|_| d.one_of(5)).collect();
        acknowledgements_are_counted(&acts)
    }
        => "the guard accepts no more answers than lines; a line is rejected only when it is the only \
            open one, and its target stays in the set; no line is admitted before the answer to a query \
            that was sent after the last line";
        random 20_000;
    evidence_is_newer_than_what_it_settles |d| evidence_is_newer_than_what_it_settles(field(d), d.coin())
        => "an at-rest report counts only if its query left after the acknowledgement; two such reports \
            put the tool in position";
        random 20_000;
    refused_lines_did_not_leave_the_queue |d|
        refused_lines_did_not_leave_the_queue(d.int(0, 900), d.int(0, 40))
        => "a rejected line does not count as completed: the target before it stays in the set while one \
            motion is queued";
        random 5_000;
    // Evidence for SR-14.
    one_retract_move_at_a_time |d| one_retract_move_at_a_time(field(d), field(d), field(d))
        => "after a retract move no other is admitted until the tool is in position";
        random 40_000;
    // Evidence for SR-12.
    contours_go_on_one_by_one |d| {
        let path: Vec<Xy> = (0..5).map(|_| (d.int(-4000, -400), d.int(-3000, 9000))).collect();
        contours_go_on_one_by_one(&path, d.coin())
    }
        => "a contour begins where the tool is at rest; each motion is released only after the \
            acknowledgement of the one before and, without a checksum, the answer to a query that was \
            sent after it";
        random 20_000;
    certified_contours_are_joined_and_clear |d| {
        let path: Vec<Xy> = (0..4).map(|_| field(d)).collect();
        certified_contours_are_joined_and_clear(&path, d.one_of(4), d.coin())
    }
        => "a contour is certified exactly when its motions join, stay within travel, keep the finishing \
            clearance, and end with the jogging clearance";
        random 20_000;
    arcs_on_the_wire_are_short_and_not_too_short |d|
        arcs_on_the_wire_are_short_and_not_too_short(rim(d), rim(d), d.coin())
        => "an arc is released only when it turns by less than about a quarter turn and its ends are \
            apart";
        random 40_000;
    places_on_arcs_are_told |d|
        places_on_arcs_are_told(rim(d), rim(d), [rim(d), field(d)][d.one_of(2)], d.coin())
        => "a report during an arc is accepted only near the arc, and always on the arc";
        random 40_000;
    // Evidence for SR-24.
    slowed_motions_differ_in_their_feed_alone |d| {
        let (percent, more) = (d.int(0, 255), d.int(0, 255));
        slowed_motions_differ_in_their_feed_alone([field(d), field(d)], [percent, more], d.int(0, 20_000))
    }
        => "under a feed override a motion of a contour has the same curve and heights, a feed of at most the planned \
            one, at least a quarter of it, and never less under a higher override; a jog stays as it is";
        random 20_000;
    // Evidence for SR-15.
    jogs_beyond_the_travel_are_refused |d|
        jogs_beyond_the_travel_are_refused((d.int(-40_000, 40_000), d.int(-40_000, 40_000)))
        => "no admitted jog leads beyond the travel or is shorter than the controller resolves";
        random 20_000;
}

pub(super) const TRAVEL: i64 = 20_000;
const MANUAL: i64 = 300;
const FINISHING: i64 = 290;
const RESOLUTION: i64 = 5;
const CORNERS: [Xy; 6] = [(0, 0), (9000, 0), (9000, 2500), (3000, 2500), (3000, 7000), (0, 7000)];

fn field<D: Draw>(d: &mut D) -> Xy {
    match d.one_of(4) {
        // Near the jogging clearance.
        0 => (d.int(-320, -280), d.int(-320, 7320)),
        1 => (d.int(-320, 9320), d.int(-320, -280)),
        _ => (d.int(-4000, 13_000), d.int(-4000, 11_000)),
    }
}

/// Points on a circle of radius 2000 about (−3000, 2000), far from the part.
fn rim<D: Draw>(d: &mut D) -> Xy {
    let x = d.int(-2000, 2000);
    let y = (2000 * 2000 - x * x).isqrt();
    (x - 3000, if d.coin() { y } else { -y } + 2000)
}

fn crowd<D: Draw>(d: &mut D) -> Vec<Xy> {
    let (count, size) = (1 + d.one_of(14), 1 + d.int(0, 12));
    (0..count).map(|_| (d.int(0, size), d.int(0, size))).collect()
}

/// Position feedback without a line in the receive buffer.
pub(super) fn feedback(position: Point, in_position: bool, queued: usize) -> PositionFeedback {
    PositionFeedback { position: position.in_plane(), in_position, queued: Some(queued), waiting: false }
}

pub(super) fn guard(interpolation: Interpolation, checked: bool) -> Guard {
    static PART: OnceLock<Arc<ProhibitedRegion>> = OnceLock::new();
    let part = PART.get_or_init(|| {
        let ring = Ring::new(CORNERS.iter().map(|&p| at(p)).collect()).expect("an L");
        let region = Region::new(vec![ring]).expect("one ring");
        Arc::new(ProhibitedRegion::new(region, Side::Outside).expect("few edges"))
    });
    let rules = Rules {
        travel: Window::of(at((-TRAVEL, -TRAVEL))).including(at((TRAVEL, TRAVEL))),
        jogging_clearance: length(MANUAL),
        finishing_clearance: length(FINISHING),
        resolution: length(RESOLUTION),
        shortest: length(4),
        interpolation,
        on_cancel: OnCancel::KeepsPath,
        contours: interpolation,
        checked,
        heights: HeightRules::TWO_AXES,
    };
    let levels = Arc::new(Levels::flat(Arc::clone(part)));
    Guard::new(Arc::clone(&levels), levels, rules)
}

/// Free points. Their part is small and lies in a corner of the lattice.
fn in_some_triangle(set: &[Xy], p: Xy) -> bool {
    let here = Segment { from: at(p), to: at(p) };
    let holds =
        |a, b, c| !Triangle { corners: [at(a), at(b), at(c)] }.near_segment(here, Length::ZERO).is_clear();
    set.iter().any(|&a| set.iter().any(|&b| set.iter().any(|&c| holds(a, b, c))))
}

fn hull_holds_its_points_and_no_others(set: &[Xy], probe: Xy) {
    let hull = Hull::of(set.iter().map(|&p| at(p))).expect("few points have a hull");
    assert!(set.iter().all(|&p| hull.holds(at(p))), "{set:?}: {hull:?}");
    assert_eq!(hull.holds(at(probe)), in_some_triangle(set, probe), "{set:?} {probe:?}: {hull:?}");
    let corners = hull.corners();
    assert!(corners.iter().all(|corner| set.iter().any(|&p| at(p) == *corner)));
    let turn = |k: usize| corners[k % corners.len()];
    if corners.len() > 2 {
        let left = |k| orientation(turn(k), turn(k + 1), turn(k + 2)) == Orientation::Left;
        assert!((0..corners.len()).all(left), "{set:?}: {hull:?}");
    }
    // The sides go round the hull, from each corner to the next.
    let sides = if corners.len() == 2 { 1 } else { corners.len() };
    let round: Vec<(Point, Point)> = (0..sides).map(|k| (turn(k), turn(k + 1))).collect();
    assert_eq!(hull.sides().collect::<Vec<_>>(), round, "{set:?}");
}

fn hulls_of_more_than_fourteen_are_none(count: usize) {
    let set: Vec<Xy> = (0..30).map(|k| (k, k * k)).take(count).collect();
    assert_eq!(Hull::of(set.iter().map(|&p| at(p))).is_some(), (1..=14).contains(&count), "{count}");
}

fn nearest_of_a_hull_is_nearest(set: &[Xy], probe: Xy, other: Xy) {
    let hull = Hull::of(set.iter().map(|&p| at(p))).expect("few points have a hull");
    let (held, nearest) =
        (hull.holds(at(probe)), hull.nearest(at(probe)).expect("a hull has a nearest point"));
    assert!(!held || nearest == at(probe), "{set:?} {probe:?}");
    let beside =
        hull.sides().any(|(from, to)| !Segment { from, to }.near_point(nearest, length(1)).is_clear());
    assert!(held || beside, "{set:?} {probe:?}: {nearest:?} is off the hull");
    if hull.holds(at(other)) {
        let away = |p: Point| i128::from(distance_2(p, at(probe)));
        let (found, better) = (away(nearest), away(at(other)));
        // |found| ≤ |better| + 1, squared: found − better − 1 ≤ 2·√better.
        let gap = found - better - 1;
        assert!(
            gap <= 0 || gap * gap <= 4 * better,
            "{set:?} {probe:?}: {other:?} is nearer than {nearest:?}"
        );
    }
}

fn admitted_jogs_keep_the_hull_clear(start: Xy, targets: &[Xy], apart: bool) {
    let interpolation = if apart { Interpolation::Independent } else { Interpolation::Linear };
    let mut guard = guard(interpolation, true);
    if guard.locate(at(start).in_plane()).is_err() || guard.is_inside_jogging_clearance() {
        return passed_over();
    }
    for &target in targets {
        if let Ok(certified) = guard.jog(at(target).in_plane(), 600) {
            assert_eq!(*certified.motion(), Motion::Jog { to: at(target).in_plane(), feed_mm_min: 600 });
            assert!(guard.in_flight().any(|point| point == at(target)), "it is in the set");
        }
        let set: Vec<Point> = guard.in_flight().collect();
        assert!(set.contains(&at(start)), "no point leaves without evidence");
        let threshold = length(MANUAL);
        if apart {
            let window = set.iter().fold(Window::of(set[0]), |window, &p| window.including(p));
            assert!(guard.part().index().near_box(window, threshold).is_none(), "{start:?} {targets:?}");
        }
        for &a in &set {
            for &b in &set {
                let swept = Triangle { corners: [a, b, at(target)] };
                let inside = set.contains(&at(target));
                assert!(
                    !inside || guard.part().index().near_triangle(swept, threshold).is_none(),
                    "{start:?} {targets:?}"
                );
            }
        }
    }
}

/// Stopping distance in lattice units, rounded up: 150 ms at `speed` mm/min, and braking at `brakes`
/// thousand units/s².
fn stopping_distance(speed: i64, brakes: i64) -> i64 {
    let per_s = (speed * 100_000 + 59) / 60;
    (per_s * 150 + 999) / 1000 + (per_s * per_s + 2000 * brakes - 1) / (2000 * brakes)
}

/// Whether the hull of the points, grown by `stray`, keeps `clearance` from the part. With `apart` the box around the
/// points replaces the hull, and it grows by `stray` along each axis.
fn is_clear(guard: &Guard, set: &[Point], [stray, clearance]: [i64; 2], apart: bool) -> bool {
    let index = guard.part().index();
    if apart {
        let window = set.iter().fold(Window::of(set[0]), |window, &p| window.including(p));
        return index.near_box(window.grown(length(stray)), length(clearance)).is_none();
    }
    let triangles =
        set.iter().flat_map(|&a| set.iter().flat_map(move |&b| set.iter().map(move |&c| [a, b, c])));
    let mut triangles = triangles.map(|corners| Triangle { corners });
    triangles.all(|triangle| index.near_triangle(triangle, length(stray + clearance)).is_none())
}

fn admitted_cancels_keep_their_reach_clear(
    [start, first, second]: [Xy; 3],
    [speed, brakes]: [i64; 2],
    apart: bool,
) {
    let mut guard = guard(if apart { Interpolation::Independent } else { Interpolation::Linear }, true);
    guard.learn_of_cancels(OnCancel::MayStray, u64::try_from(brakes * 1000).ok());
    if guard.locate(at(start).in_plane()).is_err() || guard.is_inside_jogging_clearance() {
        return passed_over();
    }
    let feed = u32::try_from(speed).expect("it is small");
    let sent = [first, second].map(|to| guard.jog(at(to).in_plane(), feed).is_ok());
    if sent == [false, false] {
        return passed_over();
    }
    let set: Vec<Point> = guard.in_flight().collect();
    let stray = stopping_distance(speed, brakes);
    if guard.cancel().is_err() {
        // Beyond the corners of the box, √2 times the distance of one axis is as far as the tool comes. Beyond its
        // sides the guard keeps up to 3/7 of that distance more.
        let spare = MANUAL + 2 * RESOLUTION + 8 + if apart { stray * 3 / 7 } else { 0 };
        assert!(!is_clear(&guard, &set, [stray, spare], apart), "{start:?} {first:?} {second:?}");
        return;
    }
    assert!(
        is_clear(&guard, &set, [stray, MANUAL], apart),
        "{start:?} {first:?} {second:?} {speed} {brakes}"
    );
    assert_eq!(guard.cancel(), Err(Refusal::Cancelled));
    if speed > 0 {
        let target = at((-3900, 10_900));
        assert_eq!(
            guard.jog(target.in_plane(), feed).err(),
            Some(Refusal::InMotion),
            "before the tool is at rest"
        );
    }
}

fn reports_are_never_farther_than_they_were([a, b, c]: [Xy; 3], share: i64, noise: [i64; 2], checked: bool) {
    let mut guard = guard(Interpolation::Linear, checked);
    if guard.locate(at(a).in_plane()).is_err() || guard.is_inside_jogging_clearance() {
        return passed_over();
    }
    let stamp = guard.stamp(Time::ZERO);
    if guard.jog(at(b).in_plane(), 600).is_err() {
        return passed_over();
    }
    let _ = guard.jog(at(c).in_plane(), 600);
    let part = |from: i64, to: i64| from + (to - from) * share / 16;
    let place = (part(a.0, b.0), part(a.1, b.1));
    let reported = (place.0 + noise[0], place.1 + noise[1]);
    let feedback = feedback(at(reported), false, 1);
    let before: Vec<Point> = guard.in_flight().collect();
    guard.reported(&feedback, stamp, Time::ZERO).expect("it is within the resolution of the set");
    let confirmed = guard.confirmed().expect("it is known").point();
    let set: Vec<Point> = guard.in_flight().collect();
    assert!(before.iter().skip(1).all(|p| set.contains(p)), "targets stay: {before:?} {set:?}");
    assert!(checked || set.contains(&before[0]), "so does the place before, without a checksum");
    if confirmed == at(a) {
        return;
    }
    // Rounding moves the position by less than 1.5 units. It moves the nearest point by less than one, and
    // the snap by as much.
    let root = |p: Point, q: Point| distance_2(p, q).isqrt();
    assert!(
        root(confirmed, at(place)) <= root(at(reported), at(place)) + 5,
        "{a:?} {b:?} {c:?} {share} {noise:?}: {confirmed:?}"
    );
    assert!(guard.part().free_point(confirmed, length(MANUAL)).is_ok(), "it is free: {confirmed:?}");
}

fn reports_off_the_set_are_refused([a, b]: [Xy; 2], reported: Xy) {
    let mut guard = guard(Interpolation::Linear, true);
    if guard.locate(at(a).in_plane()).is_err()
        || guard.is_inside_jogging_clearance()
        || guard.jog(at(b).in_plane(), 600).is_err()
    {
        return passed_over();
    }
    let stamp = guard.stamp(Time::ZERO);
    let before: Vec<Point> = guard.in_flight().collect();
    let feedback = feedback(at(reported), true, 0);
    let outcome = guard.reported(&feedback, stamp, Time::ZERO);
    let way = Segment { from: at(a), to: at(b) };
    if way.near_point(at(reported), length(2 * RESOLUTION + 2)).is_clear() {
        assert_eq!(outcome, Err(Refusal::OffCertified(at(reported))), "{a:?} {b:?} {reported:?}");
        assert!(guard.in_flight().eq(before), "{a:?} {b:?} {reported:?}");
    } else if !way.near_point(at(reported), length(2 * RESOLUTION)).is_clear() {
        assert!(outcome.is_ok(), "{a:?} {b:?} {reported:?}");
    }
}

fn acknowledgements_are_counted(acts: &[usize]) {
    let mut guard = guard(Interpolation::Linear, false);
    let here = at((-1000, 0));
    guard.locate(here.in_plane()).expect("it is clear");
    let feedback = feedback(here, false, 0);
    let (mut sent, mut answered, mut read) = (0_u64, 0_u64, 0_u64);
    let (mut open, mut targets) = (VecDeque::new(), Vec::new());
    for (k, act) in acts.iter().enumerate() {
        match act {
            0 => {
                let to = at((-1000, 100 + 100 * i64::try_from(k).unwrap_or(0)));
                let outcome = guard.jog(to.in_plane(), 600);
                assert_eq!(outcome.is_ok(), sent == read, "{acts:?}");
                targets.extend(outcome.is_ok().then_some(to));
                sent += u64::from(outcome.is_ok());
            }
            1 => {
                let outcome = guard.acknowledged();
                assert_eq!(outcome.is_ok(), answered < sent, "{acts:?}");
                answered += u64::from(outcome.is_ok());
            }
            2 => {
                let only = sent - answered == 1;
                assert_eq!(guard.refused(), only, "{acts:?}");
                answered += u64::from(only);
            }
            3 => open.push_back((guard.stamp(Time::ZERO), sent)),
            _ => {
                let Some((stamp, sent_before)) = open.pop_front() else { continue };
                guard.reported(&feedback, stamp, Time::ZERO).expect("it has not moved");
                read = read.max(sent_before);
            }
        }
        assert_eq!((guard.sent(), guard.unacknowledged()), (sent, sent - answered), "{acts:?}");
        for (stamp, sent_before) in &open {
            assert_eq!(guard.is_outdated(stamp), *sent_before < answered, "{acts:?}");
        }
        let kept = |to| guard.in_flight().any(|point| point == to);
        assert!(targets.iter().all(|&to| kept(to)), "no target has left: {acts:?}");
    }
}

fn evidence_is_newer_than_what_it_settles(to: Xy, checked: bool) {
    let mut guard = guard(Interpolation::Linear, checked);
    let here = at((-1000, 0));
    guard.locate(here.in_plane()).expect("it is clear");
    if guard.jog(at(to).in_plane(), 600).is_err() {
        return passed_over();
    }
    let rests = feedback(here, true, 0);
    let stale = guard.stamp(Time::ZERO);
    guard.acknowledged().expect("one line");
    for _ in 0..3 {
        guard.reported(&rests, stale, Time::ZERO).expect("it has not moved");
        assert!(guard.in_flight().any(|point| point == at(to)), "{to:?}");
    }
    for settled in [false, true] {
        let stamp = guard.stamp(Time::ZERO);
        guard.reported(&rests, stamp, Time::ZERO).expect("it has not moved");
        assert_eq!(guard.in_position(), settled, "{to:?}");
    }
}

/// A jog north to A, and a jog west to B, which the controller rejects. One motion stays queued, while the
/// reports come nearer to B.
fn refused_lines_did_not_leave_the_queue(aside: i64, step: i64) {
    let mut guard = guard(Interpolation::Linear, false);
    let [start, a, b] = [(-1000 - aside, 0), (-1000 - aside, 2000), (-3000 - aside, 2000)].map(at);
    let seen = |position: Point| feedback(position, false, 1);
    guard.locate(start.in_plane()).expect("it is clear");
    guard.jog(a.in_plane(), 600).expect("it is clear");
    guard.acknowledged().expect("one line");
    let stamp = guard.stamp(Time::ZERO);
    guard.reported(&seen(start), stamp, Time::ZERO).expect("it has not moved");
    guard.jog(b.in_plane(), 600).expect("it is clear");
    assert!(guard.refused());
    for k in 0..6_u16 {
        let now = Time::ZERO.after((DRAIN + DRAIN / 2) * u32::from(k));
        let stamp = guard.stamp(now);
        let along = i64::from(k) * (160 + step);
        let place = at((-1050 - aside - along, 1000 + along * 5 / 8));
        guard.reported(&seen(place), stamp, now).expect("it is in the hull");
        assert!(guard.in_flight().any(|point| point == a), "{aside} {step} {k}");
    }
}

fn one_retract_move_at_a_time(place: Xy, to: Xy, other: Xy) {
    let mut guard = guard(Interpolation::Linear, true);
    if guard.locate(at(place).in_plane()).is_err()
        || !guard.is_inside_jogging_clearance()
        || guard.retract(at(to).in_plane(), 600).is_err()
    {
        return passed_over();
    }
    let farther = (2 * to.0 - place.0, 2 * to.1 - place.1);
    for next in [other, farther, place] {
        assert!(guard.admissions().admit_retract(at(next).in_plane()).is_err(), "{place:?} {to:?} {next:?}");
    }
}

/// A contour of lines far from the part.
fn contours_go_on_one_by_one(path: &[Xy], checked: bool) {
    let mut guard = guard(Interpolation::Linear, checked);
    guard.locate(at(path[0]).in_plane()).expect("it is clear");
    let line = |pair: &[Xy]| {
        ContourMotion::in_plane(Curve::Line(Segment { from: at(pair[0]), to: at(pair[1]) }), 300)
    };
    let away = distance_2(at(path[0]), at(path[1])) > RESOLUTION.pow(2);
    let elsewhere = guard.begin_contour(path[1..].windows(2).map(line).collect());
    assert!(!away || elsewhere.is_err(), "the contour begins where the tool is at rest: {path:?}");
    if !away {
        return passed_over();
    }
    let certified = guard.begin_contour(path.windows(2).map(line).collect()).is_ok()
        && guard.certify_contour(usize::MAX) == Ok(Certification::Done);
    if !certified {
        return passed_over();
    }
    for (k, &begin) in path[..path.len() - 1].iter().enumerate() {
        let early = guard.stamp(Time::ZERO);
        assert!(guard.next_of_contour().is_some(), "{path:?} {k}");
        assert_eq!(guard.next_of_contour(), None, "not before the acknowledgement: {path:?} {k}");
        let seen = feedback(at(begin), false, 1);
        guard.acknowledged().expect("one motion");
        let last = k + 2 == path.len();
        if !checked && !last {
            assert_eq!(
                guard.next_of_contour(),
                None,
                "not before a report shows that it was read: {path:?} {k}"
            );
            guard.reported(&seen, early, Time::ZERO).expect("it is on the contour");
            assert_eq!(guard.next_of_contour(), None, "nor after a report to an earlier query: {path:?} {k}");
        }
        let stamp = guard.stamp(Time::ZERO);
        guard.reported(&seen, stamp, Time::ZERO).expect("it is on the contour");
    }
}

fn certified_contours_are_joined_and_clear(path: &[Xy], torn: usize, apart: bool) {
    let interpolation = if apart { Interpolation::Independent } else { Interpolation::Linear };
    let mut guard = guard(interpolation, true);
    if guard.locate(at(path[0]).in_plane()).is_err() {
        return passed_over();
    }
    let mut curves: Vec<ContourMotion> = Vec::new();
    for (k, pair) in path.windows(2).enumerate() {
        let from = if k == torn { (pair[0].0 + 1, pair[0].1) } else { pair[0] };
        let curve = Curve::Line(Segment { from: at(from), to: at(pair[1]) });
        curves.push(ContourMotion::in_plane(curve, 300));
    }
    let lines: Vec<Segment> =
        curves.iter().map(|motion| Segment { from: motion.curve.from(), to: motion.curve.to() }).collect();
    let part = guard.part().clone();
    let manual = length(MANUAL);
    let joined = lines.windows(2).all(|pair| pair[0].to == pair[1].from);
    let clear = |r: i64| {
        lines.iter().all(|&line| {
            let near = part.index().near_motion(line, length(r)).is_some();
            let box_near = apart && part.index().near_box(line.bounds(), length(r)).is_some();
            !near && !box_near
        })
    };
    let begins = part.free_point(lines[0].from, length(FINISHING)).is_ok();
    let ends = part.free_point(lines[lines.len() - 1].to, manual).is_ok();
    if guard.begin_contour(curves).is_err() {
        assert!(!begins, "{path:?} {torn}");
        return;
    }
    assert_eq!(guard.next_of_contour(), None, "not before all is certified");
    let certified = guard.certify_contour(usize::MAX);
    let done = certified == Ok(Certification::Done);
    assert!(!done || joined && clear(FINISHING) && begins && ends, "{path:?} {torn} {apart}");
    // Each motion begins with a little more clearance, for the chords of arcs.
    assert!(
        done || !(joined && clear(FINISHING + 50) && begins && ends),
        "{path:?} {torn} {apart}: {certified:?}"
    );
    assert_eq!(guard.next_of_contour().is_some(), done);
    assert_eq!(guard.next_of_contour(), None, "not before the acknowledgement");
}

/// A guard with this arc as its contour, if the guard certifies it.
fn on_arc(from: Xy, to: Xy, left: bool) -> Option<(Guard, keepout_kernel::Arc)> {
    let turn = if left { Turn::CounterClockwise } else { Turn::Clockwise };
    let arc = keepout_kernel::Arc::new(at(from), at(to), at((-3000, 2000)), turn).ok()?;
    let mut guard = guard(Interpolation::Linear, true);
    guard.locate(at(from).in_plane()).ok()?;
    guard.begin_contour(vec![ContourMotion::in_plane(Curve::Arc(arc), 300)]).ok()?;
    (guard.certify_contour(1) == Ok(Certification::Done)).then_some((guard, arc))
}

fn arcs_on_the_wire_are_short_and_not_too_short(from: Xy, to: Xy, left: bool) {
    let Some((_, arc)) = on_arc(from, to, left) else { return passed_over() };
    assert!(
        distance_2(arc.from(), arc.to()) > i64::from(shortest_arc(arc.radius()).units()).pow(2),
        "{arc:?}"
    );
    let way = if left { Orientation::Left } else { Orientation::Right };
    assert_eq!(orientation(arc.centre(), arc.from(), arc.to()), way, "less than half a turn: {arc:?}");
    // A chord of 97.2° is 1.5 radii. The rest is rounding.
    assert!(
        distance_2(arc.from(), arc.to()).isqrt() <= i64::from(arc.radius().units()) * 3 / 2 + 8,
        "{arc:?}"
    );
}

fn places_on_arcs_are_told(from: Xy, to: Xy, place: Xy, left: bool) {
    let Some((mut guard, arc)) = on_arc(from, to, left) else { return passed_over() };
    if guard.next_of_contour().is_none() {
        return;
    }
    let stamp = guard.stamp(Time::ZERO);
    let feedback = feedback(at(place), false, 1);
    let believed = guard.reported(&feedback, stamp, Time::ZERO).is_ok();
    let ahead = if left { Orientation::Left } else { Orientation::Right };
    let between = |p: Point| {
        orientation(arc.centre(), arc.from(), p) == ahead && orientation(arc.centre(), p, arc.to()) == ahead
    };
    let (radius, away) = (i64::from(arc.radius().units()), distance_2(at(place), arc.centre()).isqrt());
    let end =
        [arc.from(), arc.to()].into_iter().map(|end| distance_2(end, at(place)).isqrt()).min().unwrap_or(0);
    // The resolution and 2 µm. The checks below allow 3 units of rounding.
    let reach = RESOLUTION + 200;
    let near = between(at(place)) && (radius - away).abs() <= reach + 3 || end <= reach + 3;
    assert!(!believed || near, "{arc:?} {place:?}");
    let on = between(at(place)) && (radius - away).abs() <= reach - 3;
    assert!(believed || !on, "{arc:?} {place:?}");
}

fn slowed_motions_differ_in_their_feed_alone(ends: [Xy; 2], percents: [i64; 2], feed: i64) {
    let feed = u32::try_from(feed).unwrap_or(0);
    let located = || {
        let mut guard = guard(Interpolation::Linear, true);
        guard.locate(at(ends[0]).in_plane()).ok().map(|_| guard)
    };
    let (Some(mut jogs), Some(mut guard)) = (located(), located()) else { return passed_over() };
    let [one, other] = percents.map(|percent| FeedOverride::of_percent(u8::try_from(percent).unwrap_or(0)));
    let slowed = |certified: Certified, by: FeedOverride| *certified.slowed(by).motion();
    let line = Curve::Line(Segment { from: at(ends[0]), to: at(ends[1]) });
    if let Ok(jog) = jogs.jog(at(ends[1]).in_plane(), feed) {
        assert_eq!(slowed(jog, one), *jog.motion());
    }
    if guard.begin_contour(vec![ContourMotion::in_plane(line, feed)]).is_err()
        || guard.certify_contour(1) != Ok(Certification::Done)
    {
        return passed_over();
    }
    let Some(certified) = guard.next_of_contour() else { return passed_over() };
    let feed_under = |by| match slowed(certified, by) {
        Motion::Contour { curve, heights, feed_mm_min } => {
            assert_eq!((curve, heights), (line, [Height::ZERO; 2]));
            feed_mm_min
        }
        jog @ Motion::Jog { .. } => panic!("{jog:?} was a motion of a contour"),
    };
    let (a, b) = (feed_under(one), feed_under(other));
    assert!(a <= feed && 4 * (a + 1) > feed, "{a} of {feed} mm/min");
    assert!(a > 0 || feed == 0, "{feed} mm/min");
    assert!(one.percent() > other.percent() || a <= b, "{one:?} {other:?}: {a} and {b} mm/min");
    assert_eq!(feed_under(FeedOverride::FULL), feed);
    assert!((FeedOverride::LEAST..=100).contains(&one.percent()), "{one:?}");
}

fn jogs_beyond_the_travel_are_refused(to: Xy) {
    let mut guard = guard(Interpolation::Linear, true);
    guard.locate(at((-1000, -1000)).in_plane()).expect("it is clear");
    let admitted = guard.jog(at(to).in_plane(), 600).is_ok();
    let within = to.0.abs().max(to.1.abs()) <= TRAVEL;
    let long = (to.0 + 1000).abs().max((to.1 + 1000).abs()) >= 4;
    assert!(!admitted || within && long, "{to:?}");
}

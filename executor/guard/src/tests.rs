//! Tests of the guard, with hand-made cases and an adversary.

#[path = "contour_tests.rs"]
mod contours;
#[path = "value_tests.rs"]
mod values;

use alloc::sync::Arc;

use keepout_kernel::curve::nearest_unit;
use keepout_kernel::exact::segment::{Window, points_within};
use keepout_kernel::{Curve, Height, Length, Levels, Point, ProhibitedRegion, Region, Ring, Segment, Side};

use crate::{Time, *};

fn at(x: i64, y: i64) -> Point {
    Point::from_units(x, y).unwrap()
}

/// A guard that keeps 300 lattice units from an L-shaped part.
fn guard_of(interpolation: Interpolation, checked: bool) -> Guard {
    let corners = [(0, 0), (9000, 0), (9000, 2500), (3000, 2500), (3000, 7000), (0, 7000)];
    let ring = Ring::new(corners.iter().map(|&(x, y)| at(x, y)).collect()).unwrap();
    let part = ProhibitedRegion::new(Region::new(vec![ring]).unwrap(), Side::Outside).unwrap();
    let length = |units| Length::from_units(units).unwrap();
    let rules = Rules {
        travel: Window::of(at(-20_000, -20_000)).including(at(20_000, 20_000)),
        jogging_clearance: length(300),
        finishing_clearance: length(290),
        resolution: length(5),
        shortest: length(4),
        interpolation,
        on_cancel: OnCancel::KeepsPath,
        contours: interpolation,
        checked,
        heights: HeightRules::TWO_AXES,
    };
    let part = Arc::new(Levels::flat(Arc::new(part)));
    Guard::new(Arc::clone(&part), part, rules)
}

fn guard() -> Guard {
    guard_of(Interpolation::Linear, true)
}

/// The adversary executes lines in any order and any number of times, each up to any point.
#[test]
fn no_execution_of_admitted_lines_comes_near_the_part() {
    let mut random = fastrand::Rng::with_seed(11);
    let (mut admitted, mut refused) = (0_u32, 0_u32);
    for _ in 0..400 {
        let mut guard = guard();
        guard.locate(at(-3000, random.i64(-3000..10_000)).in_plane()).unwrap();
        let mut tool = guard.end().unwrap().point();
        for _ in 0..6 {
            let target = at(random.i64(-4000..14_000), random.i64(-4000..11_000));
            match guard.jog(target.in_plane(), 600) {
                Ok(_) => admitted += 1,
                Err(_) => refused += 1,
            }
            let targets: Vec<Point> = guard.in_flight().collect();
            for _ in 0..12 {
                let to = targets[random.usize(0..targets.len())];
                let share = random.i64(0..=16);
                let d = to.minus(tool);
                let part = |d: i32| i64::from(d) * share / 16;
                let next = at(i64::from(tool.x.units()) + part(d.dx), i64::from(tool.y.units()) + part(d.dy));
                // Rounding to the lattice moves the tool by a unit or more at every step.
                let threshold = Length::from_units(300 - 12).unwrap();
                let motion = Segment { from: tool, to: next };
                guard.part().edges_clear(motion, threshold).unwrap();
                tool = if random.bool() { next } else { to };
                if tool == to {
                    guard.part().edges_clear(Segment { from: next, to }, threshold).unwrap();
                }
            }
        }
    }
    assert!(admitted > 400 && refused > 400, "{admitted} admitted, {refused} refused");
}

#[test]
fn guard_admits_no_jog_without_a_position() {
    let mut guard = guard();
    assert_eq!(guard.jog(at(-1000, 0).in_plane(), 600), Err(Refusal::PositionUnknown));
    assert!(matches!(guard.locate(at(100, 100).in_plane()), Err(Refusal::Blocked(_))));
    guard.locate(at(-200, 100).in_plane()).unwrap();
    assert!(guard.is_inside_jogging_clearance());
    assert_eq!(guard.jog(at(-900, 100).in_plane(), 600), Err(Refusal::InsideJoggingClearance));
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    assert_eq!(guard.jog(at(-30_000, 0).in_plane(), 600), Err(Refusal::SoftLimit(at(-30_000, 0))));
    assert_eq!(guard.jog(at(-1003, -3).in_plane(), 600), Err(Refusal::TooShort));
    guard.jog(at(-1000, 900).in_plane(), 600).unwrap();
    assert!(guard.refused() && !guard.refused() && guard.unacknowledged() == 0);
    assert_eq!(guard.locate(at(-1000, 0).in_plane()), Err(Refusal::InMotion));
    guard.forget();
    assert_eq!(guard.jog(at(-1000, 0).in_plane(), 600), Err(Refusal::PositionUnknown));
}

#[test]
fn rejected_line_stays_in_the_set_for_its_duplicate() {
    let mut guard = guard_of(Interpolation::Linear, false);
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    guard.jog(at(-1000, 2000).in_plane(), 600).unwrap();
    assert!(guard.refused());
    assert_eq!(guard.jog(at(-1000, 3000).in_plane(), 600), Err(Refusal::Full), "it may still be unread");
    // The controller accepted the duplicate, so it is in the queue. The line after it must not count as one
    // that left the queue.
    sees(&mut guard, &feedback(at(-1000, 100), false, 1), 0);
    guard.jog(at(-1000, 3000).in_plane(), 600).unwrap();
    guard.acknowledged().unwrap();
    for (ms, y) in [(20, 110), (600, 400), (1200, 700), (1800, 1000)] {
        sees(&mut guard, &feedback(at(-1000, y), false, 2), ms);
        assert_eq!(guard.in_flight().filter(|target| target.y.units() >= 2000).count(), 2, "{ms}");
    }
    for ms in [2400, 2500] {
        sees(&mut guard, &feedback(at(-1000, 3000), true, 0), ms);
    }
    assert!(guard.in_position());
}

#[test]
fn rejected_line_is_not_counted_as_completed() {
    let mut guard = guard_of(Interpolation::Linear, false);
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    guard.jog(at(-1000, 2000).in_plane(), 600).unwrap();
    guard.acknowledged().unwrap();
    sees(&mut guard, &feedback(at(-1000, 0), false, 1), 0);
    guard.jog(at(-3000, 2000).in_plane(), 600).unwrap();
    assert!(guard.refused());
    // The controller answered two lines and has one motion in its queue. The tool is reported off its path.
    for (x, y, ms) in [(-1050, 1000, 20), (-1200, 1100, 600), (-1400, 1210, 1200), (-1600, 1320, 1800)] {
        sees(&mut guard, &feedback(at(x, y), false, 1), ms);
        assert!(guard.in_flight().any(|target| target == at(-1000, 2000)), "{ms}");
    }
}

fn feedback(position: Point, in_position: bool, queued: usize) -> PositionFeedback {
    PositionFeedback { position: position.in_plane(), in_position, queued: Some(queued), waiting: false }
}

fn time(ms: u64) -> Time {
    Time::from_micros(ms * 1000)
}

/// Takes a report whose query leaves at `ms`, and which arrives 5 ms later.
fn sees(guard: &mut Guard, feedback: &PositionFeedback, ms: u64) {
    let stamp = guard.stamp(time(ms));
    guard.reported(feedback, stamp, time(ms + 5)).unwrap();
}

#[test]
fn targets_leave_only_by_evidence() {
    let mut guard = guard();
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    let before = guard.stamp(time(0));
    guard.jog(at(-1000, 2000).in_plane(), 600).unwrap();
    // A report at rest is no evidence if its query left before the line or before its acknowledgement.
    for _ in 0..3 {
        guard.reported(&feedback(at(-1000, 0), true, 0), before, time(50)).unwrap();
        assert_eq!(guard.in_flight().count(), 2);
        let unacknowledged = guard.stamp(time(50));
        guard.reported(&feedback(at(-1000, 0), true, 0), unacknowledged, time(60)).unwrap();
        assert_eq!(guard.in_flight().count(), 2);
    }
    guard.acknowledged().unwrap();
    assert_eq!(guard.acknowledged(), Err(Refusal::UnexpectedAcknowledgement));
    guard.jog(at(-1000, 4000).in_plane(), 600).unwrap();
    guard.acknowledged().unwrap();
    // The first block has left the planner queue. Its execution is certain only after the drain time.
    let stamp = guard.stamp(time(100));
    guard.reported(&feedback(at(-1000, 1500), false, 1), stamp, time(120)).unwrap();
    assert_eq!(guard.in_flight().count(), 3);
    let stamp = guard.stamp(time(200));
    guard.reported(&feedback(at(-1000, 2100), false, 1), stamp, time(220)).unwrap();
    assert_eq!(guard.in_flight().count(), 3, "too early");
    let stamp = guard.stamp(time(700));
    guard.reported(&feedback(at(-1000, 2500), false, 1), stamp, time(720)).unwrap();
    assert_eq!(guard.in_flight().collect::<Vec<_>>(), [at(-1000, 2500), at(-1000, 4000)]);
    // At rest short of the target: one report can fall between two motions, two reports show a stop.
    let stamp = guard.stamp(time(800));
    guard.reported(&feedback(at(-1000, 3000), true, 0), stamp, time(820)).unwrap();
    assert!(!guard.in_position());
    let stamp = guard.stamp(time(900));
    guard.reported(&feedback(at(-1000, 3000), true, 0), stamp, time(920)).unwrap();
    assert!(guard.in_position());
}

#[test]
fn position_off_the_certified_set_is_refused() {
    let mut guard = guard();
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    guard.jog(at(-1000, 2000).in_plane(), 600).unwrap();
    let stamp = guard.stamp(Time::ZERO);
    assert!(guard.reported(&feedback(at(-1004, 500), false, 1), stamp, Time::ZERO).is_ok());
    assert!(guard.reported(&feedback(at(-1010, 500), false, 1), stamp, Time::ZERO).is_ok());
    // Two resolutions, and a unit for rounding.
    assert!(guard.reported(&feedback(at(-1011, 500), false, 1), stamp, Time::ZERO).is_ok());
    let off = at(-1012, 500);
    assert_eq!(guard.reported(&feedback(off, false, 1), stamp, Time::ZERO), Err(Refusal::OffCertified(off)));
}

fn take_contour(guard: &mut Guard, curves: Vec<ContourMotion>) -> Result<(), Refusal> {
    guard.begin_contour(curves)?;
    assert_eq!(guard.next_of_contour(), None, "not before it is certified");
    while guard.certify_contour(1)? != Certification::Done {}
    Ok(())
}

#[test]
fn contour_is_certified_whole_and_handed_out_one_by_one() {
    let mut guard = guard();
    guard.locate(at(-310, 0).in_plane()).unwrap();
    let line = |from, to| ContourMotion::in_plane(Curve::Line(Segment { from, to }), 300);
    let (p, q, r) = (at(-310, 0), at(-301, 3000), at(-310, 6000));
    let gouge = vec![line(p, at(-280, 3000)), line(at(-280, 3000), r)];
    assert!(matches!(take_contour(&mut guard, gouge), Err(Refusal::Gouge(gouge)) if gouge.index == 0));
    let jump = vec![line(q, r)];
    assert_eq!(take_contour(&mut guard, jump), Err(Refusal::OffCertified(q)));
    take_contour(&mut guard, vec![line(p, q), line(q, r)]).unwrap();
    assert_eq!(guard.next_of_contour().unwrap().target(), q.in_plane());
    assert_eq!(guard.next_of_contour(), None, "not before the acknowledgement");
    assert_eq!(guard.jog(p.in_plane(), 600), Err(Refusal::InMotion));
    guard.acknowledged().unwrap();
    assert_eq!(guard.next_of_contour().unwrap().target(), r.in_plane());
    guard.acknowledged().unwrap();
    let stamp = guard.stamp(Time::ZERO);
    guard.reported(&feedback(r, true, 0), stamp, Time::ZERO).unwrap();
    assert!(guard.in_position());
    assert_eq!(guard.end().unwrap().point(), r);
}

/// Rounding has blocked the straight motion from the confirmed position to the last target by a unit, as
/// happens in sliding contact. A tool at rest at the target must still be in position, or it could never move
/// again.
#[test]
fn tool_at_rest_at_its_target_is_in_position_although_the_motion_to_it_is_blocked() {
    let mut guard = guard();
    let time = time(1);
    guard.locate(at(-301, -500).in_plane()).unwrap();
    guard.jog(at(-301, 7200).in_plane(), 600).unwrap();
    guard.acknowledged().unwrap();
    // Rounded toward the wall, beyond the reach of the corner. The point is free, but the motion along the
    // wall is blocked.
    let free = guard.part().free_point(at(-280, -120), Length::from_units(300).unwrap()).unwrap();
    guard.set.confirmed = Some(FreePlace { free, height: Height::ZERO });
    let confirmed = guard.set.confirmed.unwrap();
    assert!(guard.part().motion(confirmed.free(), at(-301, 7200)).is_err());
    for _ in 0..2 {
        let stamp = guard.stamp(time);
        guard.reported(&feedback(at(-304, 7198), true, 0), stamp, time).unwrap();
    }
    assert!(guard.in_position());
    guard.jog(at(-900, 7200).in_plane(), 600).unwrap();
}

/// A cancelled jog may leave its line, while a contour keeps to it.
#[test]
fn jogs_can_be_certified_as_boxes_and_contours_as_lines() {
    let slanted = Curve::Line(Segment { from: at(-1000, 2000), to: at(-400, 2600) });
    let certify = |interpolation, contours, to: Point| {
        let mut guard = guard_of(interpolation, true);
        guard.rules.contours = contours;
        guard.locate(at(-1000, 2000).in_plane()).unwrap();
        let jog = guard.admissions().admit(to.in_plane()).map(|admission| admission.target());
        guard.begin_contour(vec![ContourMotion::in_plane(slanted, 600)]).unwrap();
        (jog.is_ok(), guard.certify_contour(9).is_ok())
    };
    // Past the corner of the L: the line is clear, its box is not.
    let past = at(300, 12_000);
    assert_eq!(certify(Interpolation::Linear, Interpolation::Linear, past), (true, true));
    assert_eq!(certify(Interpolation::Independent, Interpolation::Linear, past), (false, true));
    assert_eq!(certify(Interpolation::Independent, Interpolation::Independent, at(-400, 2600)), (true, true));
    let arc = |to: Point| {
        let turn = keepout_kernel::Turn::CounterClockwise;
        Curve::Arc(keepout_kernel::Arc::new(at(-1000, 2000), to, at(-2000, 2000), turn).unwrap())
    };
    let quarter = arc(at(-2000, 3000));
    let mut guard = guard_of(Interpolation::Linear, true);
    guard.locate(at(-1000, 2000).in_plane()).unwrap();
    guard.begin_contour(vec![ContourMotion::in_plane(arc(at(-3000, 2000)), 600)]).unwrap();
    assert_eq!(guard.certify_contour(9), Err(Refusal::ArcTooLong(at(-1000, 2000))));
    for (contours, clear) in [(Interpolation::Linear, true), (Interpolation::Independent, false)] {
        let mut guard = guard_of(Interpolation::Independent, true);
        guard.rules.contours = contours;
        guard.locate(at(-1000, 2000).in_plane()).unwrap();
        guard.begin_contour(vec![ContourMotion::in_plane(quarter, 600)]).unwrap();
        assert_eq!(guard.certify_contour(9).is_ok(), clear, "{contours:?}");
    }
}

/// A damaged or old report states that the tool is at rest at its target. In truth the tool is half-way,
/// beyond the part. A checksum excludes this case, so one report is then enough. Without a checksum, two
/// reports must agree.
#[test]
fn one_report_at_rest_is_no_evidence_without_a_checksum() {
    for checked in [false, true] {
        let mut guard = guard_of(Interpolation::Linear, checked);
        let time = time(1);
        let (home, far, across) = (at(-1000, -1000), at(-1000, 8000), at(9900, -1000));
        guard.locate(home.in_plane()).unwrap();
        for target in [far, home] {
            guard.jog(target.in_plane(), 600).unwrap();
            guard.acknowledged().unwrap();
            let stamp = guard.stamp(time);
            guard.reported(&feedback(home, false, 1), stamp, time).unwrap();
        }
        let stamp = guard.stamp(time);
        guard.reported(&feedback(home, true, 0), stamp, time).unwrap();
        assert_eq!(guard.in_position(), checked);
        // The motion is clear from home. From the true place of the tool it leads through the part.
        assert_eq!(guard.jog(across.in_plane(), 600).is_ok(), checked);
        let true_way = Segment { from: far, to: across };
        assert!(guard.part().edges_clear(true_way, Length::ZERO).is_err());
        if !checked {
            guard.reported(&feedback(home, true, 0), stamp, time).unwrap();
            assert!(guard.in_position(), "two reports that agree are evidence");
        }
    }
}

/// A repeated acknowledgement does not release a line before the controller has read the line before it.
#[test]
fn lines_go_out_only_as_the_controller_reads_them() {
    let mut guard = guard_of(Interpolation::Linear, false);
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    guard.jog(at(-1000, 1000).in_plane(), 600).unwrap();
    guard.acknowledged().unwrap();
    assert_eq!(guard.jog(at(-1000, 3000).in_plane(), 600), Err(Refusal::Full));
    let (asked, later) = (guard.stamp(Time::ZERO), Time::ZERO.after(DRAIN));
    let full = PositionFeedback { waiting: true, ..feedback(at(-1000, 0), false, 0) };
    guard.reported(&full, asked, later).unwrap();
    assert_eq!(guard.jog(at(-1000, 3000).in_plane(), 600), Err(Refusal::Full));
    guard.reported(&feedback(at(-1000, 0), false, 1), asked, later).unwrap();
    guard.jog(at(-1000, 3000).in_plane(), 600).unwrap();

    let mut guard = guard_of(Interpolation::Linear, false);
    guard.locate(at(-1000, 0).in_plane()).unwrap();
    let line = |y| Curve::Line(Segment { from: at(-1000, y), to: at(-1000, y + 100) });
    guard.begin_contour((0..4).map(|k| ContourMotion::in_plane(line(100 * k), 300)).collect()).unwrap();
    assert_eq!(guard.certify_contour(4), Ok(Certification::Done));
    let before = guard.stamp(Time::ZERO);
    assert!(guard.next_of_contour().is_some());
    guard.acknowledged().unwrap();
    assert!(guard.awaits_reading() && guard.next_of_contour().is_none());
    guard.reported(&feedback(at(-1000, 0), false, 1), before, later).unwrap();
    assert!(guard.next_of_contour().is_none());
    let behind = guard.stamp(Time::ZERO);
    guard.reported(&feedback(at(-1000, 0), false, 1), behind, later).unwrap();
    assert!(!guard.awaits_reading() && guard.next_of_contour().is_some());
}

/// The clock jumps while the tool still has to drive to the first target and back. A report on the way there
/// must not count as one on the way back.
#[test]
fn clock_jump_completes_no_line() {
    for checked in [false, true] {
        for interpolation in [Interpolation::Linear, Interpolation::Independent] {
            let mut guard = guard_of(interpolation, checked);
            let (south, west) = (at(-1000, -1000), at(-1000, 8000));
            guard.locate(south.in_plane()).unwrap();
            for target in [west, south] {
                guard.jog(target.in_plane(), 600).unwrap();
                guard.acknowledged().unwrap();
                let mut now = Time::ZERO;
                for _ in 0..4 {
                    let stamp = guard.stamp(now);
                    guard.reported(&feedback(south, false, 0), stamp, now).unwrap();
                    now = now.after(2 * DRAIN);
                }
            }
            let ways: Vec<Point> = guard.in_flight().collect();
            assert!(ways.contains(&west), "{checked} {interpolation:?}");
            assert!(
                guard.jog(at(9900, -1000).in_plane(), 600).is_err(),
                "{checked} {interpolation:?}: through the part"
            );
            // Reports farther on and on the way back show that the tool has reached the first target.
            let mut now = Time::ZERO.after(20 * DRAIN);
            for y in [2000, 6000, 5000, 4000, 3000, 2000] {
                let stamp = guard.stamp(now);
                guard.reported(&feedback(at(-1000, y), false, 0), stamp, now).unwrap();
                now = now.after(2 * DRAIN);
            }
            assert!(!guard.in_flight().any(|place| place == west), "{checked} {interpolation:?}");
        }
    }
}

/// A tool stops short of 200 targets, and turns a little each time. It is always ahead of its reported
/// position. The errors do not add up.
#[test]
fn errors_of_reports_do_not_add_up() {
    // An error of 4, rounded to the lattice, is less than the resolution of 5.
    const ERROR: f64 = 4.0;
    let mut guard = guard();
    let mut tool = (-6000.0, 0.0);
    guard.locate(at(-6000, 0).in_plane()).unwrap();
    let lattice = |(x, y): (f64, f64)| at(nearest_unit(x), nearest_unit(y));
    let mut now = Time::ZERO;
    for step in 0..200 {
        let (sin, cos) = (f64::from(step) * 0.2).sin_cos();
        let ahead = |from: (f64, f64), by: f64| (from.0 + cos * by, from.1 + sin * by);
        let goal = lattice(ahead(tool, 3000.0));
        guard.jog(goal.in_plane(), 600).unwrap();
        guard.acknowledged().unwrap();
        let goal = (f64::from(goal.x.units()), f64::from(goal.y.units()));
        let way = |t: f64| (tool.0 + (goal.0 - tool.0) * t, tool.1 + (goal.1 - tool.1) * t);
        for (t, rests) in [(0.02, false), (0.06, false), (0.08, true), (0.08, true)] {
            let seen = feedback(lattice(ahead(way(t), -ERROR)), rests, 0);
            now = now.after(core::time::Duration::from_millis(10));
            guard.reported(&seen, guard.stamp(now), now).unwrap();
        }
        tool = way(0.08);
        assert!(guard.in_position());
        let known = guard.confirmed().unwrap().point();
        assert!(
            !points_within(known, lattice(tool), guard.rules().resolution).is_clear(),
            "{known:?} {tool:?}"
        );
    }
}

/// A reset drops the queue of the controller without an alarm. If the tool is at rest short of the end of the
/// last motion, the guard hands out no further motion of the contour.
#[test]
fn contour_does_not_go_on_while_the_tool_is_at_rest_too_early() {
    let mut guard = guard();
    guard.locate(at(-310, 0).in_plane()).unwrap();
    let line = |from, to| ContourMotion::in_plane(Curve::Line(Segment { from, to }), 300);
    let (p, q, r) = (at(-310, 0), at(-310, 3000), at(-310, 6000));
    take_contour(&mut guard, vec![line(p, q), line(q, r)]).unwrap();
    guard.next_of_contour().unwrap();
    let unacknowledged = guard.stamp(Time::ZERO);
    guard.acknowledged().unwrap();
    let (stamp, moving) = (guard.stamp(Time::ZERO), feedback(at(-310, 1000), false, 0));
    let rests = feedback(at(-310, 1000), true, 0);
    // The query left before the acknowledgement, so this report is no evidence about the motion.
    guard.reported(&rests, unacknowledged, Time::ZERO).unwrap();
    guard.reported(&rests, stamp, Time::ZERO).unwrap();
    assert!(guard.awaits_reading() && guard.next_of_contour().is_none());
    guard.reported(&moving, stamp, Time::ZERO).unwrap();
    assert_eq!(guard.next_of_contour().unwrap().target(), r.in_plane());
    guard.acknowledged().unwrap();
    let (stamp, stopped) = (guard.stamp(Time::ZERO), at(-310, 4000));
    guard.reported(&feedback(stopped, true, 0), stamp, Time::ZERO).unwrap();
    let dropped = guard.reported(&feedback(stopped, true, 0), stamp, Time::ZERO);
    assert_eq!(dropped, Err(Refusal::Dropped(stopped)));
}

//! Tests of the guard's third axis: a plate with a pocket and a hole, a clamp, and a table.

use alloc::sync::Arc;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{
    Blocked, Curve, Height, HeightField, Length, Levels, Place, Point, Region, Ring, Segment,
};

use crate::{Time, *};

const MARGIN: i64 = 7;
const RESOLUTION: i64 = 3;

fn at(x: i64, y: i64, z: i64) -> Place {
    Point::from_units(x, y).unwrap().at_height(height(z))
}

fn height(units: i64) -> Height {
    Height::from_units(units).unwrap()
}

fn rectangle(x0: i64, y0: i64, x1: i64, y1: i64) -> Ring {
    let corner = |x, y| Point::from_units(x, y).unwrap();
    Ring::new(vec![corner(x0, y0), corner(x1, y0), corner(x1, y1), corner(x0, y1)]).unwrap()
}

/// The plate's top is at 0 and the table at −2000. The pocket is 500 deep, the hole goes through. The clamp is
/// 1000 high.
fn guard(checked: bool) -> Guard {
    let length = |units| Length::from_units(units).unwrap();
    let (plate, pocket) = (rectangle(0, 0, 20_000, 10_000), rectangle(1000, 1000, 9000, 9000));
    let field = HeightField {
        outlines: Region::new(vec![plate, pocket, rectangle(11_000, 1000, 19_000, 9000)]).unwrap(),
        tops: vec![Some(Height::ZERO), Some(height(-500)), None],
        around: None,
        zones: vec![(rectangle(-3000, 4000, 500, 6000), height(1000))],
        floor: Some(height(-2000)),
    };
    let levels = Arc::new(Levels::new(&field).unwrap());
    let corner = |c: i64| Point::from_units(c, c).unwrap();
    let rules = Rules {
        travel: Window::of(corner(-40_000)).including(corner(40_000)),
        jogging_clearance: length(300),
        finishing_clearance: length(290),
        resolution: length(5),
        shortest: length(4),
        interpolation: Interpolation::Linear,
        on_cancel: OnCancel::KeepsPath,
        contours: Interpolation::Linear,
        checked,
        heights: HeightRules {
            lowest: height(-2500),
            highest: height(5000),
            margin: length(MARGIN),
            resolution: length(RESOLUTION),
            shortest: length(4),
        },
    };
    Guard::new(Arc::clone(&levels), levels, rules)
}

fn rest(guard: &mut Guard, at: Place) -> Result<(), Refusal> {
    rest_after(guard, at, Time::ZERO)
}

fn rest_after(guard: &mut Guard, at: Place, now: Time) -> Result<(), Refusal> {
    let stamp = guard.stamp(now);
    let feedback = PositionFeedback { position: at, in_position: true, queued: Some(0), waiting: false };
    guard.reported(&feedback, stamp, now)
}

fn on_the_way(guard: &mut Guard, at: Place) -> Result<(), Refusal> {
    on_the_way_after(guard, at, Time::ZERO)
}

fn on_the_way_after(guard: &mut Guard, at: Place, now: Time) -> Result<(), Refusal> {
    let stamp = guard.stamp(now);
    let feedback = PositionFeedback { position: at, in_position: false, queued: Some(1), waiting: false };
    guard.reported(&feedback, stamp, now)
}

/// Jogs to the place and arrives there.
fn go(guard: &mut Guard, to: Place) {
    guard.jog(to, 600).unwrap();
    guard.acknowledged().unwrap();
    for _ in 0..2 {
        rest(guard, to).unwrap();
    }
    assert_eq!(guard.confirmed().map(FreePlace::place), Some(to));
    assert!(guard.in_position());
}

#[test]
fn tool_crosses_above_and_lowers_to_each_floor_and_no_deeper() {
    for (x, y, lowest) in [
        (5000, 5000, -500 + MARGIN),
        (15_000, 5000, -2000 + MARGIN),
        (-1000, 9000, -2000 + MARGIN),
        (10_000, 5000, MARGIN),
        (-1000, 5000, 1000 + MARGIN),
    ] {
        let mut guard = guard(true);
        guard.locate(at(-5000, -5000, 3000)).unwrap();
        go(&mut guard, at(x, y, 3000));
        let deeper = guard.jog(at(x, y, lowest - 1), 600);
        assert!(matches!(deeper, Err(Refusal::Blocked(_))), "{x} {y} {deeper:?}");
        go(&mut guard, at(x, y, lowest));
    }
}

#[test]
fn walls_are_walls_below_their_tops_only() {
    let mut guard = guard(true);
    guard.locate(at(15_000, 5000, 3000)).unwrap();
    go(&mut guard, at(15_000, 5000, -1000));
    assert!(matches!(guard.jog(at(5000, 5000, -1000), 600), Err(Refusal::Blocked(Blocked::ByEdge(_)))));
    // The motion rises, but the tool may still be deep when it crosses the wall.
    assert!(guard.jog(at(5000, 5000, 3000), 600).is_err());
    let rise = guard.rise(height(3000), 600).unwrap();
    assert_eq!(rise.target(), at(15_000, 5000, 3000));
    assert!(guard.jog(at(5000, 5000, 3000), 600).is_err(), "the rise is not confirmed");
    guard.acknowledged().unwrap();
    on_the_way(&mut guard, at(15_000, 5000, MARGIN - 1)).unwrap();
    assert!(guard.jog(at(5000, 5000, 3000), 600).is_err(), "not above the plate yet");
    on_the_way(&mut guard, at(15_000, 5000, MARGIN)).unwrap();
    assert!(guard.jog(at(5000, 5000, 3000), 600).is_ok());
}

/// Without a checksum, a damaged report may state a height that the tool has not reached.
#[test]
fn one_report_does_not_raise_the_tool_without_a_checksum() {
    let mut guard = guard(false);
    guard.locate(at(15_000, 5000, -1000)).unwrap();
    guard.rise(height(3000), 600).unwrap();
    guard.acknowledged().unwrap();
    on_the_way(&mut guard, at(15_000, 5000, 2000)).unwrap();
    assert_eq!(guard.lowest(), Some(height(-1000)));
    on_the_way(&mut guard, at(15_000, 5000, 2100)).unwrap();
    assert_eq!(guard.lowest(), Some(height(2000)));
}

#[test]
fn rising_is_permitted_where_every_jog_is_refused() {
    let mut guard = guard(true);
    // 100 from the wall: inside the jogging clearance.
    guard.locate(at(1100, 5000, -400)).unwrap();
    assert!(guard.is_inside_jogging_clearance());
    assert_eq!(guard.jog(at(1100, 5000, 100), 600), Err(Refusal::InsideJoggingClearance));
    assert_eq!(guard.retract(at(1200, 5000, -450), 600), Err(Refusal::LowersNearPart(height(-450))));
    assert_eq!(guard.rise(height(-400), 600), Err(Refusal::TooShort));
    assert_eq!(guard.rise(height(-450), 600), Err(Refusal::NoRise(height(-450))));
    assert_eq!(guard.rise(height(6000), 600), Err(Refusal::HeightLimit(height(6000))));
    guard.rise(height(3000), 600).unwrap();
    guard.acknowledged().unwrap();
    rest(&mut guard, at(1100, 5000, 3000)).unwrap();
    assert!(guard.in_position() && !guard.is_inside_jogging_clearance());
    go(&mut guard, at(5000, 5000, 3000));
}

#[test]
fn reported_height_off_the_certified_heights_is_refused() {
    for (reported, believed) in [(0, true), (-2 * RESOLUTION, true), (-2 * RESOLUTION - 1, false)] {
        let mut guard = guard(true);
        guard.locate(at(15_000, 5000, 1000)).unwrap();
        guard.jog(at(15_000, 5000, 0), 600).unwrap();
        assert_eq!(on_the_way(&mut guard, at(15_000, 5000, reported)).is_ok(), believed, "{reported}");
        assert_eq!(guard.lowest(), Some(Height::ZERO), "a report does not lower it");
    }
    let mut guard = guard(true);
    guard.locate(at(15_000, 5000, 1000)).unwrap();
    assert!(rest(&mut guard, at(15_000, 5000, 1000 + 2 * RESOLUTION + 1)).is_err());
}

fn begun(guard: &mut Guard, motions: &[(Place, Place)]) -> Result<(), Refusal> {
    let motion = |&(from, to): &(Place, Place)| ContourMotion {
        curve: Curve::Line(Segment { from: from.point, to: to.point }),
        heights: [from.height, to.height],
        feed_mm_min: 300,
    };
    guard.begin_contour(motions.iter().map(motion).collect())?;
    guard.certify_contour(usize::MAX).map(drop)
}

/// A ramp leads through the wall of the pocket. Its start is above the plate, its end is in the pocket.
#[test]
fn contours_are_certified_at_the_lowest_height_of_each_motion() {
    let ramp = |to| {
        let mut guard = guard(true);
        guard.locate(at(10_000, 5000, 100)).unwrap();
        begun(&mut guard, &[(at(10_000, 5000, 100), to), (to, at(5000, 5000, 3000))])
    };
    assert!(ramp(at(5000, 5000, MARGIN)).is_ok());
    assert!(matches!(ramp(at(5000, 5000, MARGIN - 1)), Err(Refusal::Gouge(_))));
    let mut guard = guard(true);
    let (above, floor) = (at(5000, 5000, 100), at(5000, 5000, -500 + MARGIN));
    let (aside, deeper) = (at(5000, 8000, -500 + MARGIN), at(5000, 8000, -500 + MARGIN - 1));
    guard.locate(above).unwrap();
    assert!(matches!(begun(&mut guard, &[(above, floor), (floor, deeper)]), Err(Refusal::Gouge(_))));
    let jump = [(above, floor), (aside, aside)];
    assert!(matches!(begun(&mut guard, &jump), Err(Refusal::Gouge(gouge)) if gouge.index == 1));
    let torn = [(above, floor), (at(5000, 5000, -400), aside)];
    assert!(matches!(begun(&mut guard, &torn), Err(Refusal::Gouge(gouge)) if gouge.index == 1));
    begun(&mut guard, &[(above, floor), (floor, aside), (aside, at(5000, 8000, 3000))]).unwrap();
    for place in [floor, aside, at(5000, 8000, 3000)] {
        assert_eq!(guard.next_of_contour().unwrap().target(), place);
        guard.acknowledged().unwrap();
        on_the_way(&mut guard, place).unwrap();
    }
    let lower = on_the_way(&mut guard, at(5000, 8000, -500 + MARGIN - RESOLUTION - 1));
    assert!(matches!(lower, Err(Refusal::OffCertified(_))));
    rest(&mut guard, at(5000, 8000, 3000)).unwrap();
    assert_eq!(guard.confirmed().map(FreePlace::place), Some(at(5000, 8000, 3000)));
}

/// A cancel that may leave the path may also let the tool sink.
#[test]
fn cancel_that_strays_must_be_clear_below() {
    for (z, admitted) in [(3000, true), (-500 + MARGIN, false)] {
        let mut guard = guard(true);
        guard.learn_of_cancels(OnCancel::MayStray, Some(1_000_000_000));
        guard.locate(at(5000, 5000, 3100)).unwrap();
        go(&mut guard, at(5000, 5000, z));
        guard.jog(at(5000, 5500, z), 1).unwrap();
        assert_eq!(guard.cancel().is_ok(), admitted, "{z}");
        assert_eq!(guard.may_have_strayed(), admitted);
        if admitted {
            guard.acknowledged().unwrap();
            for now in [Time::ZERO, Time::ZERO.after(PARSING)] {
                rest_after(&mut guard, at(5000, 5100, z - 200), now).unwrap();
            }
            assert_eq!(guard.confirmed().map(FreePlace::place), Some(at(5000, 5100, z - 200)));
        }
    }
}

/// After a cancel that may stray, a report must agree in its place and in its height.
#[test]
fn height_after_a_cancel_that_strays_must_be_near_the_set() {
    for (z, believed) in
        [(3000, true), (3000 + 2 * RESOLUTION, true), (3000 + 2 * RESOLUTION + 1, true), (20, false)]
    {
        let mut guard = guard(true);
        guard.learn_of_cancels(OnCancel::MayStray, Some(1_000_000_000));
        guard.locate(at(5000, 5000, 3000)).unwrap();
        guard.jog(at(5000, 5500, 3000), 1).unwrap();
        guard.acknowledged().unwrap();
        guard.cancel().unwrap();
        let seen = rest(&mut guard, at(5000, 5100, z));
        assert_eq!(seen.is_ok(), believed, "{z} {seen:?}");
    }
}

/// A line leaves the set when the tool is deeper than that line can bring it, by more than reports err.
#[test]
fn depth_shows_that_a_line_is_over() {
    const REACH: i64 = 4 * RESOLUTION + 2;
    for (deeper, left) in [(REACH, 2), (REACH + 1, 1)] {
        let mut guard = guard(true);
        guard.locate(at(15_000, 5000, 3000)).unwrap();
        for z in [2000, 1000] {
            guard.jog(at(15_000, 5000, z), 600).unwrap();
            guard.acknowledged().unwrap();
        }
        on_the_way(&mut guard, at(15_000, 5000, 2500)).unwrap();
        on_the_way_after(&mut guard, at(15_000, 5000, 2000 - deeper), Time::ZERO.after(2 * DRAIN)).unwrap();
        assert_eq!(guard.way_after(0).count(), 1 + left, "{deeper}");
    }
}

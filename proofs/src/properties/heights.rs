//! The guard's third axis: lowest height, rises, lowering, heights of contours and of reports.

use std::sync::{Arc, OnceLock};

use keepout_guard::{
    Certification, ContourMotion, Guard, HeightRules, Interpolation, OnCancel, PositionFeedback, Refusal,
    Rules, Time,
};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, Height, HeightField, Levels, Place, Point, Region, Ring, Segment, Triangle};

use super::{Xy, Xyz};
use crate::draw::Draw;
use crate::families::{at, length};
use crate::property::{passed_over, properties};
use crate::square::{height, place};

properties! {
    "heights", "executor/guard/src/";
    // Evidence for SR-13.
    jogs_are_clear_of_what_stands_above_the_lowest_height |d| {
        let targets: Vec<(Xyz, bool)> = (0..6).map(|_| (space(d), d.coin())).collect();
        jogs_are_clear_of_what_stands_above_the_lowest_height(space(d), &targets, d.coin())
    }
        => "after any jogs and rises, every triangle of the set's points, or the box around them, is clear of \
            everything above the lowest height of the set, less the height margin";
        random 8_000;
    jogs_are_refused_only_for_a_reason |d| {
        jogs_are_refused_only_for_a_reason([space(d), space(d), space(d)])
    }
        => "from rest, also after a jog that was refused, a jog is admitted exactly when the motion is clear of \
            everything above its lower end, less the height margin, and begins and ends beside it";
        random 40_000;
    rises_are_always_admitted |d| {
        let jogs: Vec<Xyz> = (0..3).map(|_| space(d)).collect();
        rises_are_always_admitted(space(d), &jogs, d.int(LOWEST, HIGHEST))
    }
        => "a rise is admitted from every place where the guard takes lines, also inside the jogging \
            clearance; a lowering is not admitted as a rise";
        random 40_000;
    // Evidence for SR-08.
    heights_rise_by_evidence_only |d| {
        let mut reports: Vec<i64> = (0..4).map(|_| d.int(0, 16)).collect();
        reports.sort_unstable();
        heights_rise_by_evidence_only(space(d), d.int(LOWEST, HIGHEST), &reports, d.coin())
    }
        => "while the tool rises, the lowest height of the set is at most the greatest reported height so far, \
            and without a checksum the greatest but one";
        random 40_000;
    // Evidence for SR-09.
    reported_heights_off_the_set_are_refused |d|
        reported_heights_off_the_set_are_refused(space(d), d.int(LOWEST, HIGHEST), d.int(LOWEST - 50, HIGHEST + 50))
        => "a report more than two resolutions above or below the heights of the set is refused, and a report \
            never lowers the lowest height";
        random 40_000;
    // Evidence for SR-12, SR-13.
    contours_are_certified_at_their_lowest_heights |d| {
        let path: Vec<Xyz> = (0..4).map(|_| space(d)).collect();
        contours_are_certified_at_their_lowest_heights(&path, d.one_of(8), [d.coin(), d.coin()]);
        // Down into the pocket, and to its wall, just above or below its top.
        let (x, z) = (500 + d.int(FINISHING - 2, CLEARANCE + 2), MARGIN + d.int(-3, 1));
        let path = [(-4000, -4000, 700), (2500, 3500, 700), (2500, 3500, z), (x, d.int(1000, 6000), z)];
        contours_are_certified_at_their_lowest_heights(&path, 0, [false; 2])
    }
        => "a contour is certified exactly when its motions join in height too, stay within the heights of \
            travel, and are clear of what stands above the lower end of each, less the height margin";
        random 20_000;
    // Evidence for SR-14.
    retract_moves_do_not_lead_down |d| {
        let from = (500 + d.int(FINISHING, CLEARANCE - 1), d.int(1000, 6000), d.int(POCKET + 20, 0));
        retract_moves_do_not_lead_down([from, (d.int(1000, 4000), d.int(1000, 6000), d.int(POCKET + 11, 10))])
    }
        => "from inside the jogging clearance, a retract move into the middle of the pocket is admitted exactly \
            when it does not lower the tool";
        random 20_000;
    // Evidence for SR-15.
    heights_beyond_the_travel_are_refused |d|
        heights_beyond_the_travel_are_refused(d.int(LOWEST - 300, HIGHEST + 300))
        => "no admitted jog or rise leads above or below the travel, or changes the height by less than the \
            controller resolves";
        random 20_000;
    // Evidence for SR-11.
    cancels_may_sink |d|
        cancels_may_sink([space(d), space(d)], d.int(0, 3))
        => "a cancel that may leave the path is admitted only if the hull is clear of what stands above the \
            lowest height, less the stopping distance and the height margin";
        random 20_000;
}

/// The motion whose number this is leads beyond the travel.
const BEYOND: usize = 7;
const CLEARANCE: i64 = 300;
/// A contour keeps this clearance and its chord error, 280 together: less than the jogging clearance.
const FINISHING: i64 = 270;
const RESOLUTION: i64 = 5;
const MARGIN: i64 = 9;
pub(super) const HEIGHT_RESOLUTION: i64 = 4;
pub(super) const LOWEST: i64 = -1500;
pub(super) const HIGHEST: i64 = 900;
const TABLE: i64 = -1200;
const CLAMP: i64 = 400;
const POCKET: i64 = -300;

/// A plate of 9000 × 7000 with its top at 0, a pocket, a through hole, a clamp over its edge, and a table.
fn levels() -> &'static Arc<Levels> {
    static LEVELS: OnceLock<Arc<Levels>> = OnceLock::new();
    LEVELS.get_or_init(|| {
        let field = HeightField {
            outlines: Region::new(vec![
                rectangle((0, 0), (9000, 7000)),
                rectangle((500, 500), (4500, 6500)),
                rectangle((5500, 1000), (8500, 6000)),
            ])
            .expect("they do not touch"),
            tops: vec![Some(Height::ZERO), Some(height(POCKET)), None],
            around: None,
            zones: vec![(rectangle((-1500, 3000), (200, 4000)), height(CLAMP))],
            floor: Some(height(TABLE)),
        };
        Arc::new(Levels::new(&field).expect("few tops"))
    })
}

fn rectangle((x0, y0): Xy, (x1, y1): Xy) -> Ring {
    Ring::new([(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(at).to_vec()).expect("a rectangle")
}

/// A place around the plate, often just at a height that the guard permits or refuses, or near a wall.
fn space<D: Draw>(d: &mut D) -> Xyz {
    let (x, y) = match d.one_of(5) {
        0 => (500 + CLEARANCE + d.int(-12, 12), d.int(700, 6300)),
        1 => (d.int(1000, 4000), d.int(1000, 6000)),
        2 => (d.int(6000, 8000), d.int(1500, 5500)),
        _ => (d.int(-4000, 13_000), d.int(-4000, 11_000)),
    };
    let z = match d.one_of(4) {
        0 => [0, CLAMP, POCKET, TABLE][d.one_of(4)] + MARGIN + d.int(-2, 2),
        1 => 700,
        _ => d.int(LOWEST, HIGHEST),
    };
    (x, y, z)
}

pub(super) fn guard(interpolation: Interpolation, checked: bool) -> Guard {
    let rules = Rules {
        travel: Window::of(at((-20_000, -20_000))).including(at((20_000, 20_000))),
        jogging_clearance: length(CLEARANCE),
        finishing_clearance: length(FINISHING),
        resolution: length(RESOLUTION),
        shortest: length(4),
        interpolation,
        on_cancel: OnCancel::KeepsPath,
        contours: Interpolation::Linear,
        checked,
        heights: HeightRules {
            lowest: height(LOWEST),
            highest: height(HIGHEST),
            margin: length(MARGIN),
            resolution: length(HEIGHT_RESOLUTION),
            shortest: length(4),
        },
    };
    Guard::new(Arc::clone(levels()), Arc::clone(levels()), rules)
}

/// Whether the hull of the points, or the box around them, keeps the clearance from everything above the height,
/// and is beside it.
fn clear_above(set: &[Point], lowest: i64, clearance: i64, apart: bool) -> bool {
    let part = levels().at(height(lowest));
    if apart {
        let window = set.iter().fold(Window::of(set[0]), |window, &p| window.including(p));
        return part.index().near_box(window, length(clearance)).is_none() && !part.holds(set[0]);
    }
    let pairs = set.iter().flat_map(|&a| set.iter().map(move |&b| (a, b)));
    let mut triangles = pairs.flat_map(|(a, b)| set.iter().map(move |&c| Triangle { corners: [a, b, c] }));
    triangles.all(|triangle| part.index().near_triangle(triangle, length(clearance)).is_none())
        && !part.holds(set[0])
}

fn units(height: Height) -> i64 {
    height.units().into()
}

fn jogs_are_clear_of_what_stands_above_the_lowest_height(start: Xyz, targets: &[(Xyz, bool)], apart: bool) {
    let interpolation = if apart { Interpolation::Independent } else { Interpolation::Linear };
    let mut guard = guard(interpolation, true);
    if guard.locate(place(start)).is_err() || guard.is_inside_jogging_clearance() {
        return passed_over();
    }
    let (mut lowest, mut admitted) = (start.2, false);
    for &(target, rises) in targets {
        let certified = if rises { guard.rise(height(target.2), 600) } else { guard.jog(place(target), 600) };
        if let Ok(certified) = certified {
            lowest = lowest.min(units(certified.target().height));
            admitted = true;
        }
        assert_eq!(guard.lowest().map(units), Some(lowest), "{start:?} {targets:?}");
        let set: Vec<Point> = guard.in_flight().collect();
        assert!(clear_above(&set, lowest - MARGIN, CLEARANCE, apart), "{start:?} {targets:?}");
    }
    if !admitted {
        passed_over();
    }
}

fn jogs_are_refused_only_for_a_reason([from, first, to]: [Xyz; 3]) {
    let mut guard = guard(Interpolation::Linear, true);
    if guard.locate(place(from)).is_err() || guard.is_inside_jogging_clearance() {
        return passed_over();
    }
    // A refused jog leaves the edge in the way behind, which another level may not have.
    let mut tried = guard.clone();
    if tried.jog(place(first), 600).is_err() {
        guard = tried;
    }
    let ends = [place(from).point, place(to).point];
    let far = from.0.abs_diff(to.0).max(from.1.abs_diff(to.1)) >= 4 || from.2.abs_diff(to.2) >= 4;
    let clear = clear_above(&ends, from.2.min(to.2) - MARGIN, CLEARANCE, false);
    assert_eq!(guard.jog(place(to), 600).is_ok(), clear && far, "{from:?} {first:?} {to:?}");
}

fn rises_are_always_admitted(start: Xyz, jogs: &[Xyz], to: i64) {
    let mut guard = guard(Interpolation::Linear, true);
    if guard.locate(place(start)).is_err() {
        return passed_over();
    }
    for &jog in jogs {
        let _ = guard.jog(place(jog), 600);
    }
    let end = units(guard.end().expect("it is known").height());
    match guard.rise(height(to), 600) {
        Ok(certified) => {
            assert!(to > end && units(certified.target().height) == to, "{start:?} {jogs:?} {to}")
        }
        Err(Refusal::NoRise(_)) => assert!(to <= end, "{start:?} {jogs:?} {to}"),
        Err(Refusal::TooShort) => assert!(to.abs_diff(end) < 4, "{start:?} {jogs:?} {to}"),
        Err(refusal) => panic!("{start:?} {jogs:?} {to}: {refusal}"),
    }
}

fn report(guard: &mut Guard, position: Place) -> Result<(), Refusal> {
    let stamp = guard.stamp(Time::ZERO);
    let feedback = PositionFeedback { position, in_position: false, queued: Some(1), waiting: false };
    guard.reported(&feedback, stamp, Time::ZERO)
}

fn heights_rise_by_evidence_only(start: Xyz, to: i64, reports: &[i64], checked: bool) {
    let mut guard = guard(Interpolation::Linear, checked);
    if guard.locate(place(start)).is_err() || guard.rise(height(to), 600).is_err() {
        return passed_over();
    }
    guard.acknowledged().expect("a rise was sent");
    let mut known = vec![start.2];
    for &share in reports {
        let z = start.2 + (to - start.2) * share / 16;
        report(&mut guard, place((start.0, start.1, z))).expect("it is on the way");
        known.push(z);
        let lowest = units(guard.lowest().expect("it is known"));
        let mut sorted = known.clone();
        sorted.sort_unstable();
        let most = if checked { sorted[sorted.len() - 1] } else { sorted[sorted.len() - 2] };
        assert!(lowest <= most, "{start:?} {to} {reports:?}: {lowest}");
    }
}

fn reported_heights_off_the_set_are_refused(start: Xyz, to: i64, reported: i64) {
    let mut guard = guard(Interpolation::Linear, true);
    let target = place((start.0, start.1, to));
    if guard.locate(place(start)).is_err() || guard.is_inside_jogging_clearance() {
        return passed_over();
    }
    if guard.jog(target, 600).is_err() {
        return passed_over();
    }
    let (low, high) = (start.2.min(to), start.2.max(to));
    let believed = (low - 2 * HEIGHT_RESOLUTION..=high + 2 * HEIGHT_RESOLUTION).contains(&reported);
    let answer = report(&mut guard, place((start.0, start.1, reported)));
    assert_eq!(answer.is_ok(), believed, "{start:?} {to} {reported}");
    assert!(units(guard.lowest().expect("it is known")) >= low, "{start:?} {to} {reported}");
}

fn contours_are_certified_at_their_lowest_heights(path: &[Xyz], torn: usize, [high, plunges]: [bool; 2]) {
    let mut guard = guard(Interpolation::Linear, true);
    let mut path: Vec<Xyz> = path.to_vec();
    let last = path.len() - 1;
    if plunges {
        (path[last].0, path[last].1) = (path[last - 1].0, path[last - 1].1);
    }
    if high {
        // A plunge leads down from there.
        let raised = path.iter_mut().take(if plunges { last } else { last + 1 });
        raised.for_each(|each| each.2 = each.2.max(CLAMP + MARGIN - 1));
    }
    let beyond = torn == BEYOND;
    if beyond {
        path[1].2 = HIGHEST + 1;
    }
    if guard.locate(place(path[0])).is_err() {
        return passed_over();
    }
    let mut motions: Vec<ContourMotion> = path
        .windows(2)
        .map(|pair| {
            let [from, to] = [place(pair[0]), place(pair[1])];
            let curve = Curve::Line(Segment { from: from.point, to: to.point });
            ContourMotion { curve, heights: [from.height, to.height], feed_mm_min: 300 }
        })
        .collect();
    if let Some(motion) = motions.get_mut(torn).filter(|_| torn > 0) {
        motion.heights[0] = height(units(motion.heights[0]) + 1);
    }
    let joined = torn == 0 || torn >= motions.len();
    let clear = |motion: &ContourMotion| {
        let part = levels().at(height(units(motion.lowest()) - MARGIN));
        certify_path(part, length(FINISHING), &[motion.curve]).is_ok()
    };
    let end = place(path[path.len() - 1]);
    let ends_clear =
        levels().at(height(units(end.height) - MARGIN)).free_point(end.point, length(CLEARANCE)).is_ok();
    let begins =
        levels().at(height(path[0].2 - MARGIN)).free_point(place(path[0]).point, length(FINISHING)).is_ok();
    let right = !beyond && joined && begins && ends_clear && motions.iter().all(clear);
    let begun = guard.begin_contour(motions).is_ok();
    let certified = begun && guard.certify_contour(usize::MAX) == Ok(Certification::Done);
    assert_eq!(certified, right, "{path:?} {torn}");
}

fn retract_moves_do_not_lead_down([from, to]: [Xyz; 2]) {
    let mut guard = guard(Interpolation::Linear, true);
    if guard.locate(place(from)).is_err() || !guard.is_inside_jogging_clearance() {
        return passed_over();
    }
    assert_eq!(guard.retract(place(to), 600).is_ok(), to.2 >= from.2, "{from:?} {to:?}");
}

fn heights_beyond_the_travel_are_refused(to: i64) {
    let mut guard = guard(Interpolation::Linear, true);
    guard.locate(place((-4000, -4000, 0))).expect("it is beside everything");
    let permitted = (LOWEST..=HIGHEST).contains(&to) && to - MARGIN >= TABLE && to.abs() >= 4;
    assert_eq!(guard.jog(place((-4000, -4000, to)), 600).is_ok(), permitted, "{to}");
    let mut guard = self::guard(Interpolation::Linear, true);
    guard.locate(place((-4000, -4000, 0))).expect("it is beside everything");
    assert_eq!(guard.rise(height(to), 600).is_ok(), (4..=HIGHEST).contains(&to), "{to}");
}

fn cancels_may_sink([from, to]: [Xyz; 2], speed: i64) {
    // 150 ms at full speed, and hardly any way to brake.
    let stray = ((speed * 100_000 + 59) / 60 * 150 + 999) / 1000 + i64::from(speed > 0);
    let mut guard = guard(Interpolation::Linear, true);
    guard.learn_of_cancels(OnCancel::MayStray, Some(1_000_000_000));
    if guard.locate(place(from)).is_err() || guard.is_inside_jogging_clearance() {
        return passed_over();
    }
    let feed = u32::try_from(speed).expect("it is small");
    if guard.jog(place(to), feed).is_err() || guard.cancel().is_err() {
        return passed_over();
    }
    let set: Vec<Point> = guard.in_flight().collect();
    let lowest = from.2.min(to.2) - stray + 1 - MARGIN;
    assert!(clear_above(&set, lowest, CLEARANCE + stray - 1, false), "{from:?} {to:?} {speed}");
    if speed > 0 {
        assert_eq!(guard.jog(place(from), feed).err(), Some(Refusal::InMotion));
    }
}

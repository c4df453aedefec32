//! The feel of jogging in figures: response, speed, walls, corners, release. The machine is the simulated
//! GRBL machine at 115200 baud, with 1 ms each way, 200 mm/s and 1000 mm/s². Each judgement reads a trace,
//! and must reject the same trace with a seeded fault.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::time::Duration;

use keepout_executor::session::{Going, NoEventLog, Sample};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;
use keepout_planner::request::PlanRequest;
use keepout_planner::units::point_from_mm;
use keepout_sim::operator::Script;
use keepout_sim::session::{SimRun, run_simulated};

/// An L of 90 × 70 mm with its inside corner at (30, 25).
const L: &str = "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\n\
                 LWPOLYLINE\n8\n0\n90\n6\n70\n1\n10\n0\n20\n0\n10\n90\n20\n0\n10\n90\n20\n25\n10\n30\n20\n\
                 25\n10\n30\n20\n70\n10\n0\n20\n70\n0\nENDSEC\n0\nEOF\n";
/// Jogging clearance, mm: tool radius, stock to leave and margin.
const REACH: f64 = 3.2115;
const SPEED: f64 = 200.0;
const ACCELERATION: f64 = 1000.0;

/// True tool positions: seconds since the script began, and mm.
type Trace = Vec<(f64, Mm2)>;
/// The verdict on a trace; an error states the defect.
type Judgement = Result<(), String>;

/// The trace of a script.
fn steered(start: Mm2, script: &str) -> Trace {
    steered_over(115_200, start, script)
}

/// The trace of a script over a line of this baud rate.
fn steered_over(baud: u32, start: Mm2, script: &str) -> Trace {
    let plan =
        PlanRequest::default().plan("l", L.as_bytes(), &MachineProfile::simulated(), &mut |_| {}).unwrap();
    let machine = MachineProfile { repeatability_mm: 0.0, ..MachineProfile::simulated() };
    // Without servo drives the tool is at its commanded position: the test measures jogging, not the drives.
    let run = SimRun {
        machine,
        baud,
        servo: None,
        start: Some(point_from_mm(start).unwrap()),
        limit: Duration::from_secs(60),
        ..SimRun::default()
    };
    let mut began = None;
    let operator = Box::new(Script::parse(script).unwrap());
    let result = run_simulated(
        PreparedPlan::new(plan),
        &run,
        operator,
        Box::new(NoEventLog),
        &mut |supervisor, _, now| {
            if began.is_none() && supervisor.phase().is_steered() {
                began = Some(now.elapsed().as_secs_f64());
            }
            Going::On
        },
    );
    let result = result.unwrap();
    assert_eq!(result.facts.deepest_mm, Some(0.0));
    // The script's clock starts with the first input after the start: within 10 ms.
    let began = began.unwrap();
    let place = |sample: &Sample| (sample.at.elapsed().as_secs_f64() - began, sample.position_mm.plane());
    result.samples.iter().map(place).collect()
}

/// The tool's position at a time. After a pause it is the last position of a motion.
fn at(places: &[(f64, Mm2)], t: f64) -> Mm2 {
    let after = places.partition_point(|place| place.0 <= t);
    let before = places[after.saturating_sub(1)];
    match places.get(after) {
        Some(next) if next.0 - before.0 < 0.1 => {
            let share = (t - before.0) / (next.0 - before.0).max(1e-9);
            before.1 + (next.1 - before.1) * share.clamp(0.0, 1.0)
        }
        _ => before.1,
    }
}

/// Mean speed over a span, mm/s.
fn speed(places: &[(f64, Mm2)], from: f64, to: f64) -> f64 {
    at(places, from).distance(at(places, to)) / (to - from)
}

fn expect(wanted: bool, otherwise: impl FnOnce() -> String) -> Judgement {
    if wanted { Ok(()) } else { Err(otherwise()) }
}

/// Half deflection in a direction, from 0.5 s to 1.5 s.
fn answers(places: &[(f64, Mm2)]) -> Judgement {
    let first =
        places.iter().find(|place| place.1.distance(places[0].1) > 0.01).map_or(f64::MAX, |place| place.0);
    expect((0.45..0.56).contains(&first), || format!("moves after {:.3} s", first - 0.5))?;
    let cruising = speed(places, 0.9, 1.4);
    expect((cruising - 0.5 * SPEED).abs() < 1.5, || format!("{cruising:.1} mm/s"))
}

#[test]
fn stick_to_motion_is_quick_and_the_set_feed_is_reached_in_every_direction() {
    for (x, y) in [(0.5, 0.0), (0.0, 0.5), (0.353_553_4, 0.353_553_4), (-0.4, 0.3)] {
        let places = steered(Mm2::new(120.0, 60.0), &format!("0 0 0\n0.5 {x} {y}\n1.5 0 0\n2.5 quit\n"));
        answers(&places).unwrap();
        noticed("moves after", answers(&late(&places, 0.15)));
        noticed("mm/s", answers(&slowed_from(&places, 0.6)));
    }
}

/// Half deflection, released at these times.
fn stops(runs: &[(f64, Trace)]) -> Judgement {
    let speed = 0.5 * SPEED;
    let braking = speed * speed / (2.0 * ACCELERATION);
    // The look-ahead adds this time: two queries, their pauses, and a jog.
    let allowed = braking + speed * 0.145;
    let went = runs.iter().map(|(let_go, places)| at(places, *let_go).distance(places[places.len() - 1].1));
    let went = went.fold(0.0, f64::max);
    expect(went < allowed, || format!("{went:.2} mm of {allowed:.2}"))
}

#[test]
fn released_stick_stops_within_the_look_ahead() {
    let run = |k: i32| {
        let let_go = 1.0 + 0.01 * f64::from(k);
        (let_go, steered(Mm2::new(120.0, 60.0), &format!("0 0.5 0\n{let_go} 0 0\n3 quit\n")))
    };
    let runs: Vec<(f64, Trace)> = (0..9).map(run).collect();
    stops(&runs).unwrap();
    let later = |(let_go, places): &(f64, Trace)| (*let_go, late(places, 0.06));
    noticed("mm of", stops(&runs.iter().map(later).collect::<Vec<_>>()));
}

/// Full speed down at the wall, from 90, and away from it at 2 s.
fn meets_the_wall(places: &[(f64, Mm2)]) -> Judgement {
    let wall = 25.0 + REACH;
    let rest = at(places, 1.9).y;
    expect((0.0..0.02).contains(&(rest - wall)), || format!("rests {:.4} mm off the wall", rest - wall))?;
    let least = places.iter().map(|place| place.1.y).fold(f64::MAX, f64::min);
    expect(least >= wall, || format!("overran the wall by {:.4} mm", wall - least))?;
    // The shortest possible time: acceleration to full speed and braking take 0.2 s each.
    let distance = 90.0 - wall;
    let best = distance / SPEED + SPEED / ACCELERATION;
    let arrived = places.iter().find(|place| place.1.y - wall < 0.05).map_or(f64::MAX, |place| place.0);
    expect(arrived < best + 0.06, || format!("arrived after {arrived:.3} s, {best:.3} at best"))?;
    // Away from the wall, motion is as free as elsewhere.
    let left = at(places, 2.5).y - rest;
    let best = 0.5 * SPEED - SPEED * SPEED / (2.0 * ACCELERATION);
    expect(left > best - SPEED * 0.04, || format!("left {left:.1} of {best:.1} mm after half a second"))
}

#[test]
fn full_speed_up_to_the_wall_and_away_from_it() {
    // Down at the top of the low arm, from 60 mm above.
    let places = steered(Mm2::new(60.0, 90.0), "0 0 -1\n2 0 1\n3 quit\n");
    meets_the_wall(&places).unwrap();
    let moved = |dy: f64| places.iter().map(|&(t, place)| (t, place + Mm2::new(0.0, dy))).collect::<Trace>();
    noticed("off the wall", meets_the_wall(&moved(-0.03)));
    noticed("off the wall", meets_the_wall(&moved(0.03)));
    // A guard that overruns and comes back.
    let mut overrun = places.clone();
    let deepest = overrun.iter().position(|place| place.1.y - 25.0 - REACH < 0.05).unwrap();
    overrun[deepest].1.y = 25.0 + REACH - 0.01;
    noticed("overran", meets_the_wall(&overrun));
    noticed("arrived", meets_the_wall(&slowed_from(&places, 0.1)));
    noticed("left", meets_the_wall(&slowed_from(&places, 2.0)));
}

/// Down at the wall at an angle, from above: along the wall by 0.5 s, toward the inside corner at x = 30.
fn slides(places: &[(f64, Mm2)]) -> Judgement {
    let (from, to) = (0.5, 0.75);
    let along = speed(places, from, to);
    let share = 0.4 * SPEED;
    let right = along > 0.9 * share && along < 1.5 * share;
    expect(right, || format!("{along:.1} mm/s, commanded {share:.1} along the wall"))?;
    let steps: Vec<Mm2> = (0..25).map(|k| at(places, from + f64::from(k) * 0.01)).collect();
    let moves = steps.windows(2).all(|pair| pair[0].x - pair[1].x > 0.2);
    expect(moves, || format!("it stuck: {steps:?}"))?;
    let off = steps.iter().map(|at| (at.y - 25.0 - REACH).abs()).fold(0.0, f64::max);
    expect(off < 0.05, || format!("it left the wall: {off}"))
}

#[test]
fn tool_slides_along_a_wall_without_sticking() {
    let places = steered(Mm2::new(95.0, 40.0), "0 -0.4 -0.4\n2.2 quit\n");
    slides(&places).unwrap();
    noticed("along the wall", slides(&slowed_from(&places, 0.5)));
    // The tool stops for 30 ms, and then catches up.
    let stood = at(&places, 0.6);
    let hold = |&(t, place): &(f64, Mm2)| (t, if (0.6..0.63).contains(&t) { stood } else { place });
    noticed("stuck", slides(&places.iter().map(hold).collect::<Trace>()));
    let lifted = |&(t, place): &(f64, Mm2)| (t, place + Mm2::new(0.0, if t > 0.7 { 0.1 } else { 0.0 }));
    noticed("left the wall", slides(&places.iter().map(lifted).collect::<Trace>()));
}

/// Pushed into the inside corner.
fn rests_in_the_corner(places: &[(f64, Mm2)]) -> Judgement {
    let corner = Mm2::new(30.0 + REACH, 25.0 + REACH);
    let rest = at(places, 2.0);
    let off = rest.distance(corner);
    expect(off < 0.05, || format!("{rest:?} is {off:.3} mm from the corner"))?;
    let mut late = places.iter().filter(|place| place.0 > 2.0 && place.0 < 3.9);
    expect(late.all(|place| place.1.distance(rest) < 0.02), || "it chatters".into())
}

#[test]
fn tool_comes_to_rest_in_an_inside_corner_without_chatter() {
    let places = steered(Mm2::new(60.0, 60.0), "0 -0.6 -0.6\n4 quit\n");
    rests_in_the_corner(&places).unwrap();
    let stuck: Trace = places.iter().copied().filter(|place| place.0 < 0.2).collect();
    noticed("from the corner", rests_in_the_corner(&stuck));
    let rest = at(&places, 2.0);
    let mut chatters = places.clone();
    chatters
        .extend((0..20).map(|k| (2.0 + 0.05 * f64::from(k), rest + Mm2::new(0.03 * f64::from(k % 2), 0.0))));
    chatters.sort_by(|a, b| a.0.total_cmp(&b.0));
    noticed("chatters", rests_in_the_corner(&chatters));
}

#[test]
fn tool_goes_around_an_outside_corner() {
    // Down along the right end of the low arm, pushing at it: past the corner, and on under the part.
    let places = steered(Mm2::new(110.0, 15.0), "0 -0.3 -0.3\n3 quit\n");
    let end = at(&places, 2.9);
    assert!(end.x < 80.0 && end.y < 0.0, "the tool ends at {end:?}");
}

#[test]
fn handwheels_move_the_tool_by_the_turned_distance() {
    let places = steered(
        Mm2::new(120.0, 60.0),
        "0 0 0\n0.2 turn 0.1 0\n0.3 turn 0.1 0\n0.4 turn 0 -1\n1.5 0 0\n2 quit\n",
    );
    let end = places.last().unwrap().1;
    assert!(end.distance(Mm2::new(120.2, 59.0)) < 0.004, "{end:?}");
}

/// Over a line slower than the hand, all turns count: the tool only arrives later.
#[test]
fn handwheel_turns_are_not_lost_over_a_slow_line() {
    let turns: String = (0..200).map(|k| format!("{:.3} turn 0.05 0\n", 0.2 + 0.01 * f64::from(k))).collect();
    let places = steered_over(9600, Mm2::new(100.0, 60.0), &format!("0 0 0\n{turns}4 0 0\n5 quit\n"));
    let end = places.last().unwrap().1;
    assert!(end.distance(Mm2::new(110.0, 60.0)) < 0.004, "{end:?}");
}

/// Requires that the judgement rejects a trace with a seeded fault, and names it by `words`.
fn noticed(words: &str, judgement: Judgement) {
    let reason = judgement.expect_err(words);
    assert!(reason.contains(words), "not for {words}, but for: {reason}");
}

/// The trace of a later response.
fn late(places: &[(f64, Mm2)], by: f64) -> Trace {
    places.iter().map(|&(t, place)| (if t > 0.0 { t + by } else { t }, place)).collect()
}

/// The trace at half speed from a moment on.
fn slowed_from(places: &[(f64, Mm2)], from: f64) -> Trace {
    places.iter().map(|&(t, place)| (if t > from { from + 2.0 * (t - from) } else { t }, place)).collect()
}

/// A start 4 mm from the end of the y travel, jogged at it at an angle.
fn slides_along_the_end_of_the_travel(places: &[(f64, Mm2)]) -> Judgement {
    let highest = places.iter().map(|place| place.1.y).fold(f64::MIN, f64::max);
    let rest = at(places, 1.4).y;
    expect(highest - rest < 0.001, || format!("came back {:.4} mm", highest - rest))?;
    let along = at(places, 1.4).x - at(places, 0.9).x;
    expect(along > 0.5 * 0.5 * SPEED * 0.9, || format!("went {along:.2} mm along the end of the travel"))
}

#[test]
fn the_end_of_the_travel_is_reached_and_slid_along() {
    let profile = MachineProfile::simulated();
    let plan = PlanRequest::default().plan("l", L.as_bytes(), &profile, &mut |_| {}).unwrap();
    let place = keepout_executor::session::place_on_table(&plan, &profile, None).unwrap();
    let (_, _, _, y1) = place.travel.corners();
    let end = keepout_planner::units::mm(y1);
    let places = steered(Mm2::new(0.0, end - 4.0), "0 0 0\n0.5 0.5 0.5\n1.5 0 0\n2.5 quit\n");
    slides_along_the_end_of_the_travel(&places).unwrap();
    let rest = end - at(&places, 1.4).y;
    assert!((0.0..0.02).contains(&rest), "rests {rest:.4} mm off the end of the travel");
    noticed("along the end", slides_along_the_end_of_the_travel(&slowed_from(&places, 0.6)));
}

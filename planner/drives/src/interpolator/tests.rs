use super::*;

fn flat(x: f64, y: f64) -> Mm3 {
    Mm3::new(x, y, 0.0)
}

fn motion() -> QueuedMotion {
    QueuedMotion::new(
        Drives { max_rate: 200.0, acceleration: 500.0, up: [10.0, 100.0], junction_deviation: 0.01 },
        flat(0.0, 0.0),
    )
}

#[test]
fn block_takes_the_time_of_a_trapezoidal_speed_profile() {
    let mut motion = motion();
    motion.push(flat(100.0, 0.0), 100.0, 0.001);
    let mut ticks = 0;
    while motion.queued() > 0 {
        motion.advance(0.0005, |_, _| {});
        ticks += 1;
    }
    assert!(motion.position() == flat(100.0, 0.0));
    // Acceleration 0.2 s, deceleration 0.2 s, and 80 mm at 100 mm/s between them.
    let seconds = f64::from(ticks) * 0.0005;
    assert!((seconds - 1.2).abs() < 0.002, "{seconds}");
}

/// Time steps of any length give the same corners and the same end, at the predicted time.
#[test]
fn large_and_small_time_steps_agree() {
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..300 {
        let mut whole = motion();
        for _ in 0..random.usize(1..6) {
            let to = flat(random.f64() * 40.0, random.f64() * 40.0);
            whole.push(to, 5.0 + random.f64() * 150.0, 0.001);
        }
        let mut fine = whole.clone();
        let (mut corners, mut seconds) = (Vec::new(), 0.0);
        while let Some(step) = whole.next_event() {
            seconds += step;
            whole.advance(step, |at, _| corners.push(at));
            whole.advance(1e-7, |at, _| corners.push(at));
            seconds += 1e-7;
        }
        let mut seen = Vec::new();
        for _ in 0..200 {
            fine.advance((seconds + 0.001) / 200.0, |at, _| seen.push(at));
        }
        assert_eq!(corners, seen);
        assert!(fine.queued() == 0 && whole.position() == fine.position());
    }
}

/// The queue runs low and the tool brakes. Then the next block and a stop arrive, in either order.
#[test]
fn stop_at_the_end_of_a_block_runs_away_on_firmware_with_the_defect() {
    let slopes = (1..200).map(|k| flat(22.0, f64::from(k) / 80.0));
    let next = slopes.clone().find(|&to| rounds_up(flat(20.0, 0.0), to, 80.0)).unwrap();
    assert!(
        slopes.clone().filter(|&to| rounds_up(flat(20.0, 0.0), to, 80.0)).count() < 60,
        "most slopes are harmless"
    );
    let run = |defect: bool, block_first: bool| {
        let mut motion = if defect { motion().with_runaway(80.0) } else { motion() };
        motion.push(flat(20.0, 0.0), 50.0, 0.001);
        while !motion.brakes_to_end() {
            motion.advance(1e-4, |_, _| {});
        }
        if block_first {
            motion.push(next, 50.0, 0.001);
            motion.advance(0.005, |_, _| {});
            motion.hold();
        } else {
            motion.hold();
            motion.advance(0.005, |_, _| {});
            motion.push(next, 50.0, 0.001);
        }
        for _ in 0..100_000 {
            motion.advance(1e-4, |_, _| {});
        }
        motion.position().x
    };
    for block_first in [false, true] {
        assert!((run(false, block_first) - 20.0).abs() < 0.3 && run(true, block_first) > 700.0);
    }
}

#[test]
fn cancel_stops_on_the_path_within_the_braking_distance() {
    let mut motion = motion();
    motion.push(flat(60.0, 80.0), 100.0, 0.001);
    for _ in 0..1000 {
        motion.advance(0.0005, |_, _| {});
    }
    let before = motion.position();
    motion.cancel();
    let mut outcome = StepOutcome::Going;
    for _ in 0..1000 {
        outcome = motion.advance(0.0005, |_, _| {});
        if outcome == StepOutcome::Flushed {
            break;
        }
    }
    let after = motion.position();
    assert_eq!(outcome, StepOutcome::Flushed);
    assert!((after.x * 80.0 - after.y * 60.0).abs() < 1e-9, "on the line");
    let travelled = before.distance(after);
    // The acceleration along the diagonal is 500 / 0.8 mm/s².
    assert!((travelled - 100.0 * 100.0 / (2.0 * 625.0)).abs() < 0.2, "{travelled}");
}

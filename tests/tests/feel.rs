//! Limits for the feel of jogging: first step, sliding along straight and curved walls, release.

use keepout_executor::dialect::DialectName;
use keepout_tests::feel::{self, AT_WALL_MM, MachineTable, ReleasePlace, WallShape, median_and_p99};

/// Angles of the straight wall, degrees.
const WALLS: [f64; 2] = [0.0, 17.0];
/// Delays of the line, ms each way.
const DELAYS_MS: [u64; 2] = [1, 50];
/// The default stock to leave plus the resolution of the position feedback, mm.
const STOCK_MM: f64 = 0.21;

#[test]
fn tool_slides_along_straight_wall_at_the_commanded_component() {
    for table in &MachineTable::ALL {
        for (delay, wall) in DELAYS_MS.into_iter().flat_map(|delay| WALLS.map(|wall| (delay, wall))) {
            for angle in [0.0, 15.0, 30.0, 45.0, 60.0, 75.0] {
                let slide = feel::straight(table, wall, angle, delay).unwrap();
                let case = format!("{}, {delay} ms, wall {wall}°, push {angle}°: {slide:?}", table.name);
                assert!(slide.length_mm > 20.0, "{case}");
                assert!(slide.share > 0.95 && slide.share < 1.02, "{case}");
                assert!(slide.dips_per_m < 5.0 && slide.stops == 0, "{case}");
                assert!(slide.height_mm < AT_WALL_MM, "{case}");
            }
        }
    }
}

#[test]
fn tool_does_not_stop_on_smooth_curve_and_stays_within_the_stock() {
    for table in &MachineTable::ALL {
        for (delay, shape) in
            DELAYS_MS.into_iter().flat_map(|delay| WallShape::CURVES.map(|shape| (delay, shape)))
        {
            let slide = feel::curved(table, shape, delay).unwrap();
            let case = format!("{}, {delay} ms, {shape:?}: {slide:?}", table.name);
            assert!(slide.length_mm > 10.0, "{case}");
            assert!(slide.stops == 0 && slide.height_mm < STOCK_MM, "{case}");
        }
    }
}

#[test]
fn first_step_comes_within_30_ms_and_the_latency_of_the_line() {
    for table in &MachineTable::ALL {
        for delay in DELAYS_MS {
            let waited = feel::first_steps(table, delay, 100).unwrap();
            assert_eq!(waited.len(), 100);
            let (median, p99) = median_and_p99(&waited);
            let latency_s = 0.001 * f64::from(u32::try_from(delay).unwrap());
            let case = format!("{}, {delay} ms: {median} s, {p99} s", table.name);
            assert!(median < 0.03 + latency_s && p99 < 0.05 + latency_s, "{case}");
        }
    }
}

/// Keepout sends no cancel here, and the tool goes on to the end of its look-ahead.
#[test]
fn tool_rests_at_the_end_of_a_short_look_ahead() {
    for table in &MachineTable::ALL {
        for (delay, allowed_s) in [(1, 0.2), (50, 0.45)] {
            for language in [DialectName::Grbl, DialectName::GrblHal] {
                let released = feel::release(table, language.clone(), delay, ReleasePlace::Sliding).unwrap();
                let braking_s = table.feed_mm_min / 60.0 / table.acceleration_mm_s2;
                let case = format!("{}, {delay} ms: {released:?}", table.name);
                assert!(released.seconds < braking_s + allowed_s, "{case}");
            }
        }
    }
}

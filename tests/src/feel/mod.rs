//! The feel of jogging in figures: sliding along walls, the first step after a push, the stop after a
//! release.
//!
//! The controllers are simulated, in virtual time, at 115200 baud. The figures come from the true tool
//! position, not from the reported one.

mod hand;
mod scene;
mod trace;

use std::time::Duration;

use hand::{Away, Follow, Hand, Pushes};
use keepout_executor::dialect::DialectName;
use keepout_planner::Mm2;
use scene::{BAR_END_MM, START_MM, Scene};
pub use scene::{MachineTable, ReleasePlace, WallShape};
pub use trace::median_and_p99;

/// Share of the commanded speed below which a slowdown counts as a dip.
pub const DIP: f64 = 0.4;
/// Largest height above the jogging clearance at which the tool is at the wall, mm.
pub const AT_WALL_MM: f64 = 0.05;
/// Push angle into curved walls, degrees.
pub const CURVE_PUSH: f64 = 45.0;

/// The figures of a slide along a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slide {
    /// Mean speed along the wall, as a share of the commanded component. On curved walls the component is
    /// that of [`CURVE_PUSH`].
    pub share: f64,
    /// Mean speed, mm/s.
    pub speed_mm_s: f64,
    /// Dips below [`DIP`] of the commanded component, or of the mean speed on curved walls, per metre.
    pub dips_per_m: f64,
    /// Height above the jogging clearance, 90th percentile, mm.
    pub height_mm: f64,
    /// Full stops.
    pub stops: usize,
    /// Length of the slide, mm.
    pub length_mm: f64,
}

/// Pushes the tool into a straight wall. The wall lies at the angle `wall`, and the push goes at `angle` into
/// it, both in degrees. The line delays by `delay_ms` each way.
///
/// Heights count once the tool is at the wall. Speeds count once the tool has reached its speed, or has had
/// time to accelerate from rest. Both count up to the place where the tool must brake for the end of the bar.
///
/// # Errors
/// The fault that ended the session.
pub fn straight(table: &MachineTable, wall: f64, angle: f64, delay_ms: u64) -> Result<Slide, String> {
    let shape = WallShape::Bar(wall);
    let scene = Scene::of(table, shape, DialectName::Grbl, delay_ms)?;
    let (sin, cos) = angle.to_radians().sin_cos();
    let gap_mm = if angle == 0.0 { 0.01 } else { (10.0 * angle.to_radians().tan()).clamp(0.5, 10.0) };
    let start = shape.start_mm(scene.limit_mm() + gap_mm);
    let commanded = table.speed_mm_s() * cos;
    let hand = Away {
        velocity: Mm2::new(cos, -sin).turned(wall.to_radians()),
        beyond: (Mm2::unit(wall.to_radians()), -START_MM),
        within_s: 30.0 + 100.0 / table.speed_mm_s(),
    };
    let trace = scene.trace(start, Hand::Away(hand))?;
    let arrived = trace.first(|at| scene.height_mm(at) < AT_WALL_MM).unwrap_or(0.0);
    let accelerated = arrived + commanded / table.acceleration_mm_s2 + 0.1;
    let settled = trace.first_speed_after(arrived, 0.95 * commanded).unwrap_or(accelerated).min(accelerated);
    let end_mm = BAR_END_MM - commanded * commanded / (2.0 * table.acceleration_mm_s2) - 0.4 * commanded;
    let end = trace.first(|at| at.turned(-wall.to_radians()).x > end_mm.min(-START_MM));
    Ok(trace.slide(&scene, (arrived, settled, end), commanded, |speed, _| speed))
}

/// Slides along a curved wall for 12 s, with a push at [`CURVE_PUSH`] into it.
///
/// # Errors
/// The fault that ended the session.
pub fn curved(table: &MachineTable, shape: WallShape, delay_ms: u64) -> Result<Slide, String> {
    let scene = Scene::of(table, shape, DialectName::Grbl, delay_ms)?;
    let start = shape.start_mm(scene.limit_mm() + 0.5);
    let commanded = table.speed_mm_s() * CURVE_PUSH.to_radians().cos();
    let hand = Follow { angle: CURVE_PUSH.to_radians(), within_s: 12.0 };
    let trace = scene.trace(start, Hand::Follow(hand))?;
    let arrived = trace.first(|at| scene.height_mm(at) < 4.0 * AT_WALL_MM).unwrap_or(0.0);
    let settled = arrived + commanded / table.acceleration_mm_s2 + 1.0;
    Ok(trace.slide(&scene, (settled, settled, None), commanded, |_, mean| mean))
}

/// Measures the time around an outside corner, s, with a push at 45° into the wall. It counts from 30 mm
/// before the end of the bar to beside its end.
///
/// # Errors
/// The fault that ended the session.
pub fn corner(table: &MachineTable, delay_ms: u64) -> Result<f64, String> {
    let shape = WallShape::Bar(0.0);
    let scene = Scene::of(table, shape, DialectName::Grbl, delay_ms)?;
    let Mm2 { y, .. } = shape.start_mm(scene.limit_mm() + 0.5);
    let part = std::f64::consts::FRAC_1_SQRT_2;
    let hand = Away { velocity: Mm2::new(part, -part), beyond: (Mm2::new(0.0, -1.0), 0.0), within_s: 60.0 };
    let trace = scene.trace(Mm2::new(BAR_END_MM - 60.0, y), Hand::Away(hand))?;
    let before = trace.first(|at| at.x > BAR_END_MM - 30.0).ok_or("the tool did not slide")?;
    let past = trace.first(|at| at.y < 0.0).ok_or("the tool did not pass the corner")?;
    Ok(past - before)
}

/// Measures the seconds from a push to the first step, ascending. The `count` pushes start from rest, at
/// irregular times.
///
/// # Errors
/// The fault that ended the session.
pub fn first_steps(table: &MachineTable, delay_ms: u64, count: usize) -> Result<Vec<f64>, String> {
    let scene = Scene::of(table, WallShape::Bar(0.0), DialectName::Grbl, delay_ms)?;
    let hand = Pushes::new(count, 0.6 + 4.0 * Duration::from_millis(delay_ms).as_secs_f64());
    let (trace, pushed) = scene.trace_of_pushes(Mm2::new(0.0, 60.0), hand)?;
    let mut waited: Vec<f64> =
        pushed.iter().filter_map(|&at| trace.first_step_after(at, table.acceleration_mm_s2)).collect();
    waited.sort_by(f64::total_cmp);
    Ok(waited)
}

/// The stop of the tool after a release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Release {
    /// Time from release to standstill, s.
    pub seconds: f64,
    /// Distance from release to standstill, mm.
    pub distance_mm: f64,
}

/// Releases the stick from full deflection at 45°, while the tool slides along a straight wall, or far from
/// any wall.
///
/// # Errors
/// The fault that ended the session.
pub fn release(
    table: &MachineTable,
    language: DialectName,
    delay_ms: u64,
    wall: ReleasePlace,
) -> Result<Release, String> {
    let shape = WallShape::Bar(0.0);
    let scene = Scene::of(table, shape, language, delay_ms)?;
    let part = std::f64::consts::FRAC_1_SQRT_2;
    let (gap_mm, direction) = match wall {
        ReleasePlace::Sliding => (2.0, Mm2::new(part, -part)),
        ReleasePlace::Far => (30.0, Mm2::new(part, part)),
    };
    let start = shape.start_mm(scene.limit_mm() + gap_mm);
    let held_s = (table.speed_mm_s() / table.acceleration_mm_s2 + 0.5).min(70.0 / table.speed_mm_s() + 0.5);
    let (trace, released) = scene.trace_of_pushes(start, Pushes::once(direction, held_s))?;
    released.first().map(|&at| trace.rest_after(at)).ok_or_else(|| "the stick was not released".into())
}

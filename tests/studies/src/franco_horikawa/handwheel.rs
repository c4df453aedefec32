//! The one-dimensional system of sections 2 and 3.1: a handwheel and a barrier.
//!
//! The pulses of the handwheel reach the motor only while the table is in front of the barrier. Behind it,
//! they are "released only if the operator tries to move the table backward".

use std::time::Duration;

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::Mm2;
use serde::{Deserialize, Serialize};

use super::attempt::{Attempt, Tally, seed_of};
use super::delays::Delays;
use super::modules::{STEP_S, follows};
use super::ours::Ours;
use super::parallel::{ProgressCallback, parallel};
use super::scenario::{MachinedProfile, StudyError};

/// Distance that the table moves per pulse, mm.
const PULSE_MM: f64 = 0.01;
/// Distance of the start from the barrier, mm. The wheel turns forward by twice this distance.
const RUN_UP_MM: f64 = 15.0;
/// Distance by which the wheel then turns back, mm.
const BACK_MM: f64 = 5.0;
/// Speeds of the wheel, mm/s of the table.
pub const SPEEDS_MM_S: [f64; 4] = [1.0, 5.0, 12.0, 18.0];
/// Tolerances of the paper's system, mm.
pub const TOLERANCES_MM: [f64; 3] = [1.0, 3.0, 5.0];

/// The paper's gate between handwheel and motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// Start of the prohibited region, mm.
    pub at_mm: f64,
    /// Width of the band in front of it, mm.
    pub tolerance_mm: f64,
}

impl Barrier {
    /// Whether a pulse passes while the table is at `table_mm`. In front of the band all pulses pass, within
    /// it only backward pulses.
    #[must_use]
    pub fn passes(&self, table_mm: f64, pulse_mm: f64) -> bool {
        pulse_mm < 0.0 || table_mm < self.at_mm - self.tolerance_mm
    }
}

/// A row of the one-dimensional system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WheelRow {
    /// The system: "paper" or "ours".
    pub system: String,
    /// Speed of the wheel, mm/s.
    pub speed_mm_s: f64,
    /// Tolerance T, mm.
    pub tolerance_mm: f64,
    /// Statistics of the attempts.
    pub found: Tally,
    /// Number of attempts in which the table followed the wheel back.
    pub released: u64,
}

/// Runs all rows: the wheel turns beyond the barrier and back.
///
/// # Errors
/// [`StudyError`] if a session can not run.
pub fn rows(
    tool_diameter_mm: f64,
    delays: Delays,
    (attempts, seed): (u64, u64),
    progress: &ProgressCallback<'_>,
) -> Result<Vec<WheelRow>, StudyError> {
    let mut settings: Vec<(f64, Option<f64>)> = Vec::new();
    for speed in SPEEDS_MM_S {
        settings.extend(TOLERANCES_MM.map(|tolerance| (speed, Some(tolerance))));
        settings.push((speed, None));
    }
    parallel(settings.len(), progress, |number| {
        let (speed_mm_s, tolerance_mm) = settings[number];
        let seeds = (0..attempts).map(|attempt| seed_of(seed, 10_000 + number as u64, attempt));
        let bar = MachinedProfile::bar();
        let (system, tolerance_mm, tried) = match tolerance_mm {
            Some(tolerance_mm) => {
                let tried = seeds.map(|seed| paper(speed_mm_s, tolerance_mm, delays, seed));
                ("paper", tolerance_mm, tried.collect::<Vec<_>>())
            }
            None => {
                let ours = Ours::new(&bar, tool_diameter_mm, 100.0)?;
                let tried = seeds.map(|seed| turned(&ours, speed_mm_s, seed));
                ("ours", ours.tolerance_mm(), tried.collect::<Result<Vec<_>, StudyError>>()?)
            }
        };
        let (found, released) = Tally::with_released(&tried);
        Ok(WheelRow { system: system.into(), speed_mm_s, tolerance_mm, found, released })
    })
}

/// One attempt with the paper's system. It reads the sensor once per round of the computation. The gate stays
/// unchanged until the next round.
fn paper(speed_mm_s: f64, tolerance_mm: f64, delays: Delays, seed: u64) -> (Attempt, bool) {
    let mut random = fastrand::Rng::with_seed(seed);
    let barrier = Barrier { at_mm: RUN_UP_MM, tolerance_mm };
    let follows = follows(delays.inertia_s);
    let (mut wheel, mut motor, mut table, mut view, mut farthest) = (0.0_f64, 0.0, 0.0, 0.0, 0.0_f64);
    let (mut owed, mut seconds, mut round_s) = (0.0, 0.0, random.f64() * delays.compute_s);
    let mut turning = Turning::Forward;
    let mut rest_s = 0.0;
    while turning != Turning::Last || rest_s < PAUSE_S {
        let turned = match turning {
            Turning::Forward => speed_mm_s * STEP_S,
            Turning::Back => -speed_mm_s * STEP_S,
            Turning::Rest | Turning::Last => 0.0,
        };
        rest_s = if turned == 0.0 { rest_s + STEP_S } else { 0.0 };
        turning = match turning {
            Turning::Forward if wheel >= 2.0 * RUN_UP_MM => Turning::Rest,
            Turning::Rest if rest_s >= PAUSE_S => Turning::Back,
            Turning::Back if wheel <= 2.0 * RUN_UP_MM - BACK_MM => Turning::Last,
            going => going,
        };
        wheel += turned;
        owed += turned;
        while f64::abs(owed) >= PULSE_MM {
            let pulse = PULSE_MM.copysign(owed);
            owed -= pulse;
            motor += if barrier.passes(view, pulse) { pulse } else { 0.0 };
        }
        table += follows * (motor - table);
        farthest = farthest.max(table);
        seconds += STEP_S;
        round_s -= STEP_S;
        if round_s <= 0.0 {
            view = table;
            round_s = delays.computation_s(&mut random);
        }
    }
    let beyond = farthest - barrier.at_mm;
    let path = vec![Mm2::ZERO, Mm2::new(farthest, 0.0), Mm2::new(table, 0.0)];
    let released = table < farthest - 0.8 * BACK_MM;
    (Attempt::at_a_barrier(beyond, seconds, path), released)
}

/// One attempt with Keepout. The pulses are handwheel inputs of the supervisor.
fn turned(ours: &Ours<'_>, speed_mm_s: f64, seed: u64) -> Result<(Attempt, bool), StudyError> {
    let mut random = fastrand::Rng::with_seed(seed);
    let start = Mm2::new(-ours.radius_mm() - RUN_UP_MM, 20.0 + 20.0 * random.f64());
    let wheel = Wheel { speed_mm_s, turned_mm: 0.0, rest_s: 0.0, phase: Turning::Forward, over: false };
    let attempt = ours.session(start, Box::new(wheel), (seed, Duration::from_millis(1)), None)?;
    let farthest = attempt.path.iter().map(|at| at.x).fold(f64::NEG_INFINITY, f64::max);
    let released = attempt.path.last().is_some_and(|last: &Mm2| last.x < farthest - 0.8 * BACK_MM);
    Ok((attempt, released))
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Turning {
    Forward,
    /// The operator pauses.
    Rest,
    Back,
    /// The operator waits until the table has followed.
    Last,
}

/// An operator who turns the x wheel far beyond the barrier, pauses, and turns it back.
struct Wheel {
    speed_mm_s: f64,
    turned_mm: f64,
    rest_s: f64,
    phase: Turning,
    over: bool,
}

/// Time between two inputs, s.
const INPUT_S: f64 = 0.01;
/// Duration of a pause, s.
const PAUSE_S: f64 = 1.0;

impl Operator for Wheel {
    fn input(&mut self, view: &OperatorView, _: Time) -> OperatorInput {
        if matches!(view.phase, Phase::Starting) {
            return OperatorInput::default();
        }
        let turn = self.speed_mm_s * INPUT_S;
        match self.phase {
            Turning::Forward | Turning::Back => {
                let all = if self.phase == Turning::Forward { 2.0 * RUN_UP_MM } else { BACK_MM };
                self.turned_mm += turn;
                let dx = if self.phase == Turning::Forward { turn } else { -turn };
                if self.turned_mm >= all {
                    self.phase = if self.phase == Turning::Forward { Turning::Rest } else { Turning::Last };
                    (self.turned_mm, self.rest_s) = (0.0, 0.0);
                }
                OperatorInput { turned_mm: Mm2::new(dx, 0.0), ..OperatorInput::default() }
            }
            Turning::Rest | Turning::Last => {
                self.rest_s += INPUT_S;
                if self.rest_s >= PAUSE_S && self.phase == Turning::Last {
                    self.over = true;
                }
                if self.rest_s >= PAUSE_S && self.phase == Turning::Rest {
                    self.phase = Turning::Back;
                }
                OperatorInput::default()
            }
        }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.over.then_some(OperatorCommand::Stop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn barrier_passes_pulses_in_front_of_the_band_and_backward_pulses() {
        let barrier = Barrier { at_mm: 20.0, tolerance_mm: 2.0 };
        for (table, pulse, passes) in [
            (0.0, 0.01, true),
            (17.99, 0.01, true),
            (18.0, 0.01, false),
            (25.0, 0.01, false),
            (18.0, -0.01, true),
            (25.0, -0.01, true),
        ] {
            assert_eq!(barrier.passes(table, pulse), passes, "{table} {pulse}");
        }
    }

    /// Pulses of one round still pass after the table enters the band. With a narrow T the table enters the
    /// region. With a wide T it stops before the barrier.
    #[test]
    fn table_stops_late_by_one_round_and_follows_the_wheel_back() {
        let delays =
            Delays { inertia_s: 0.0, ..super::super::scenario::Scenarios::built_in().unwrap().delays };
        for seed in 0..50 {
            let (narrow, released) = paper(12.0, 0.0, delays, seed);
            assert!(narrow.depth_mm > 0.0 && released, "{narrow:?}");
            let (wide, released) = paper(5.0, 5.0, delays, seed);
            assert!(wide.depth_mm == 0.0 && wide.closest_mm < 5.0 && released, "{wide:?}");
        }
    }
}

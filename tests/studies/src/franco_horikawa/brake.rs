//! The system of section 2: a table that a handle drives, a position sensor, and an electromagnetic brake.
//!
//! "As the table approaches the desired position, the control algorithm in the computer gradually activates the brake,
//! generating a braking force in the handle. The brake is fully activated and the handle locked, when the table reaches
//! to the desired position. The brake is released only if the operator tries to move the table backward."
//!
//! The paper gives no masses, forces or times. The values here are ours. We read the release as a sensor of the
//! handle's torque: a locked table does not move, so its position can not tell that the operator pulls.

use keepout_planner::Mm2;
use serde::{Deserialize, Serialize};

use super::attempt::{Attempt, Tally, seed_of};
use super::delays::Delays;
use super::modules::{STEP_S, follows};

/// Mass that the handle moves: the table, the work, and the screw's inertia as a mass, kg.
const MASS_KG: f64 = 40.0;
/// Friction of the guide, N.
const FRICTION_N: f64 = 15.0;
/// Force of the fully activated brake at the table, N.
const BRAKE_N: f64 = 600.0;
/// Time constant of the brake's force, s.
const BRAKE_S: f64 = 0.03;
/// Largest force of the hand at the table, N.
const HAND_N: f64 = 200.0;
/// Stiffness and damping of hand and arm, N/mm and N·s/mm.
const ARM: (f64, f64) = (20.0, 2.0);
/// Force of the hand that counts as an attempt to move the table backward, N.
const PULL_N: f64 = 5.0;
/// Distance of the start from the desired position, mm.
const RUN_UP_MM: f64 = 15.0;
/// Time for which the operator pushes on after the table should have arrived, s.
const PUSH_S: f64 = 2.0;
/// Time for which the operator pulls the table back, s.
const PULL_S: f64 = 2.0;
/// Speeds of the hand, mm/s of the table.
pub const SPEEDS_MM_S: [f64; 4] = [1.0, 5.0, 12.0, 18.0];
/// Distances before the desired position from which on the brake acts, mm.
pub const BANDS_MM: [f64; 3] = [1.0, 3.0, 5.0];
/// Mean time of a round of a fast computer, s.
const FAST_S: f64 = 0.01;

/// The words of the page.
pub(super) const SECTION: &str = "
## One dimension: the gradual brake

This is the system of section 2. The hand pushes the table at a speed, with up to 200 N, beyond the desired position,
and then pulls. The brake begins to act at the band before the desired position, and holds with 600 N there. Its force
follows within 30 ms. The table has 40 kg and 15 N of friction. The paper gives none of these values
(`tests/studies/src/franco_horikawa/brake.rs`). A round takes as long as in the delay model, or 10 ms. *Under-cutting*
is the distance of the stopped table from the desired position: it stops where brake and friction hold the whole force
of the hand. A brake that rises gradually ends the motion before the position, unless the hand is as strong as the full
brake.

";

/// A row of the system with the brake.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BrakeRow {
    /// Speed of the hand, mm/s.
    pub speed_mm_s: f64,
    /// Distance before the desired position from which on the brake acts, mm.
    pub band_mm: f64,
    /// Mean time of a round of the computation, s.
    pub round_s: f64,
    /// Statistics of the attempts.
    pub found: Tally,
    /// Number of attempts in which the table followed the hand back.
    pub released: u64,
}

/// The share of the brake's force that the computer asks for, from what it reads.
#[must_use]
pub fn activation(to_go_mm: f64, band_mm: f64, hand_n: f64) -> f64 {
    if hand_n < -PULL_N { 0.0 } else { (1.0 - to_go_mm / band_mm).clamp(0.0, 1.0) }
}

/// A hand that moves at a speed, and pulls the table along like a spring.
#[derive(Clone, Copy, Debug, Default)]
struct Hand {
    lead_mm: f64,
    speed_mm_s: f64,
}

impl Hand {
    /// The force at a table that moves at `table_mm_s`, N. The hand gets no farther ahead than its force allows.
    fn step(&mut self, wanted_mm_s: f64, table_mm_s: f64) -> f64 {
        if self.speed_mm_s != wanted_mm_s {
            *self = Self { lead_mm: 0.0, speed_mm_s: wanted_mm_s };
        }
        let (stiffness, damping) = ARM;
        let slower_mm_s = wanted_mm_s - table_mm_s;
        self.lead_mm = (self.lead_mm + slower_mm_s * STEP_S).clamp(-HAND_N / stiffness, HAND_N / stiffness);
        (stiffness * self.lead_mm + damping * slower_mm_s).clamp(-HAND_N, HAND_N)
    }
}

/// The table, its brake and its guide.
#[derive(Clone, Copy, Debug, Default)]
struct Braked {
    at_mm: f64,
    speed_mm_s: f64,
    brake_n: f64,
}

impl Braked {
    /// Advances by [`STEP_S`]. Friction and brake oppose the motion, and hold a table at rest against the hand.
    fn step(&mut self, hand_n: f64, activation: f64) {
        self.brake_n += (activation * BRAKE_N - self.brake_n) * follows(BRAKE_S);
        let held_n = FRICTION_N + self.brake_n;
        // N / kg · s is m/s.
        let gained = |force_n: f64| 1000.0 * force_n / MASS_KG * STEP_S;
        let free = self.speed_mm_s + gained(hand_n);
        let taken = gained(held_n);
        self.speed_mm_s = if free.abs() <= taken { 0.0 } else { free - taken.copysign(free) };
        self.at_mm += self.speed_mm_s * STEP_S;
    }
}

/// Runs all rows.
#[must_use]
pub fn rows(delays: Delays, (attempts, seed): (u64, u64)) -> Vec<BrakeRow> {
    let mut rows = Vec::new();
    for speed_mm_s in SPEEDS_MM_S {
        for band_mm in BANDS_MM {
            for round_s in [delays.compute_s, FAST_S] {
                let delays = Delays { compute_s: round_s, ..delays };
                let stream = 20_000 + rows.len() as u64;
                let seeds = (0..attempts).map(|attempt| seed_of(seed, stream, attempt));
                let tried: Vec<_> = seeds.map(|seed| attempt((speed_mm_s, band_mm), delays, seed)).collect();
                let (found, released) = Tally::with_released(&tried);
                rows.push(BrakeRow { speed_mm_s, band_mm, round_s, found, released });
            }
        }
    }
    rows
}

/// The operator pushes the table to the desired position and beyond, and pulls it back. Returns the attempt, and
/// whether the table followed back.
fn attempt((speed_mm_s, band_mm): (f64, f64), delays: Delays, seed: u64) -> (Attempt, bool) {
    let mut random = fastrand::Rng::with_seed(seed);
    let (mut table, mut hand) = (Braked::default(), Hand::default());
    let (mut asked, mut farthest) = (0.0, 0.0_f64);
    let (mut seconds, mut round_s) = (0.0, random.f64() * delays.compute_s);
    let push_s = 1.5 * RUN_UP_MM / speed_mm_s + PUSH_S;
    while seconds < push_s + PULL_S {
        let wanted = if seconds < push_s { speed_mm_s } else { -speed_mm_s };
        let hand_n = hand.step(wanted, table.speed_mm_s);
        table.step(hand_n, asked);
        farthest = farthest.max(table.at_mm);
        seconds += STEP_S;
        round_s -= STEP_S;
        if round_s <= 0.0 {
            asked = activation(RUN_UP_MM - table.at_mm, band_mm, hand_n);
            round_s = delays.computation_s(&mut random);
        }
    }
    let beyond = farthest - RUN_UP_MM;
    let released = table.at_mm < farthest - 0.3 * speed_mm_s * PULL_S;
    let path = vec![Mm2::ZERO, Mm2::new(farthest, 0.0), Mm2::new(table.at_mm, 0.0)];
    (Attempt::at_a_barrier(beyond, seconds, path), released)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brake_rises_over_the_band_and_releases_for_a_pull() {
        for (to_go, hand, share) in [
            (20.0, 50.0, 0.0),
            (4.0, 50.0, 0.0),
            (3.0, 50.0, 0.25),
            (0.0, 50.0, 1.0),
            (-1.0, 50.0, 1.0),
            (-1.0, -50.0, 0.0),
        ] {
            assert_eq!(activation(to_go, 4.0, hand), share, "{to_go} {hand}");
        }
    }

    /// A locked table holds against the whole force of the hand. A moving one stops in v² / 2a.
    #[test]
    fn full_brake_holds_and_stops() {
        let mut table = Braked { at_mm: 0.0, speed_mm_s: 0.0, brake_n: BRAKE_N };
        (0..100).for_each(|_| table.step(HAND_N, 1.0));
        assert_eq!(table.at_mm, 0.0);
        table.speed_mm_s = 18.0;
        (0..100).for_each(|_| table.step(0.0, 1.0));
        let stops_mm = 18.0_f64.powi(2) / (2.0 * 1000.0 * (BRAKE_N + FRICTION_N) / MASS_KG);
        assert!(table.speed_mm_s == 0.0 && (table.at_mm - stops_mm).abs() < 0.02, "{table:?} {stops_mm}");
    }

    /// The table goes with the hand until friction and brake hold the whole force of the hand. With the slow computer,
    /// a fast hand pushes it past the desired position.
    #[test]
    fn table_stops_where_the_brake_overcomes_the_hand() {
        let delays = super::super::scenario::Scenarios::built_in().unwrap().delays;
        let fast = Delays { compute_s: FAST_S, ..delays };
        let (quick, released) = attempt((1.0, 5.0), fast, 1);
        let held_mm = 5.0 * (1.0 - (HAND_N - FRICTION_N) / BRAKE_N);
        assert!(released && (quick.closest_mm - held_mm).abs() < 0.1, "{quick:?} {held_mm}");
        let late = (0..50)
            .map(|seed| attempt((18.0, 1.0), delays, seed).0)
            .filter(|each| each.depth_mm > 0.0)
            .count();
        assert!(late > 25, "{late} of 50");
    }
}

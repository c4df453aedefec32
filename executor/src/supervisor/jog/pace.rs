//! The look-ahead of jogs: distance of the targets ahead of the tool, and time between jogs.

use std::time::Duration;

use keepout_guard::DRAIN;

use super::super::polling::QUERY_PAUSE;
use super::JogContext;

/// Longest duration of a jog when the controller cannot join jogs, s.
const SINGLE_S: f64 = 1.0;
/// The same when jogs cannot be cancelled either, s. The tool does not follow the operator during this time.
const UNSTOPPABLE_S: f64 = 0.25;
/// Number of status queries that complete a target, with one that may be late.
const QUERIES: f64 = 4.0;
/// Number of targets in the in-flight set that the planner uses.
const TARGETS: f64 = 9.0;
/// Longest time between two jogs, s. Over a slower line, the next jog waits for status reports anyway.
const STEP_MAX_S: f64 = 0.3;

/// The look-ahead of jogs: far enough to brake, and to bridge the time until the next target can arrive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LookAhead {
    acceleration_mm_s2: f64,
    /// Time to bridge, s.
    horizon_s: f64,
    /// Time between two jogs, s.
    step_s: f64,
    /// Time that the in-flight set spans at low speed, s.
    span_s: f64,
}

impl LookAhead {
    /// The look-ahead of jogs at full deflection up to `speed_mm_s`. A target enters the in-flight set when
    /// it is sent. It leaves the set when status reports show that the tool reached it [`DRAIN`] before. The
    /// set holds a limited number of targets, so the time between two jogs is at least this time divided by
    /// that number.
    pub(super) fn of(context: &JogContext<'_>, speed_mm_s: f64) -> Self {
        let trip_s = context.round_trip.as_secs_f64();
        let pause_s = QUERY_PAUSE.as_secs_f64();
        // The known position is as old as a status query and the pause before it.
        let latency_s = (trip_s * 2.5 + 2.0 * pause_s).clamp(0.06, 2.5);
        let braking_s = speed_mm_s / (2.0 * context.limits.acceleration_mm_s2);
        let completing_s = DRAIN.as_secs_f64() + QUERIES * (trip_s + trip_s.max(pause_s));
        let step_s = ((braking_s + latency_s + completing_s) / TARGETS).min(STEP_MAX_S);
        let single_s = if context.abilities.cancels() { SINGLE_S } else { UNSTOPPABLE_S };
        let horizon_s = latency_s + step_s;
        let horizon_s = if context.abilities.queues { horizon_s } else { horizon_s.max(single_s) };
        Self {
            acceleration_mm_s2: context.limits.acceleration_mm_s2,
            horizon_s,
            step_s,
            span_s: completing_s + horizon_s,
        }
    }

    /// Time between two jogs.
    pub(super) fn step(&self) -> Duration {
        Duration::from_secs_f64(self.step_s)
    }

    /// Speed at which the in-flight set has this length, mm/s.
    pub(super) fn speed_of_set_mm_s(&self, length_mm: f64) -> f64 {
        length_mm / self.span_s
    }

    /// Speed at which a jog has this length, mm/s.
    pub(super) fn speed_of_steps_mm_s(&self, length_mm: f64) -> f64 {
        length_mm / self.step_s
    }

    /// The shortest jog worth sending at this speed, mm.
    pub(super) fn least_mm(&self, speed_mm_s: f64) -> f64 {
        speed_mm_s * self.step_s / 2.0
    }

    /// Look-ahead distance at this speed, mm: v²/2a + v·t.
    pub(super) fn distance_mm(&self, speed_mm_s: f64) -> f64 {
        speed_mm_s * speed_mm_s / (2.0 * self.acceleration_mm_s2) + speed_mm_s * self.horizon_s
    }

    /// Speed with this look-ahead distance, mm/s: the inverse of [`LookAhead::distance_mm`].
    pub(super) fn speed_mm_s(&self, distance_mm: f64) -> f64 {
        let (a, t) = (self.acceleration_mm_s2, self.horizon_s);
        // 2d / (t + √(t² + 2d/a)) keeps its digits for any a.
        2.0 * distance_mm / (t + (t * t + 2.0 * distance_mm / a).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_is_the_inverse_of_distance() {
        for acceleration_mm_s2 in [1.0, 500.0, f64::INFINITY] {
            let look = LookAhead { acceleration_mm_s2, horizon_s: 0.2, step_s: 0.09, span_s: 0.9 };
            for speed in [0.0, 1.0, 83.0, 200.0] {
                assert!((look.speed_mm_s(look.distance_mm(speed)) - speed).abs() < 1e-9);
            }
        }
    }
}

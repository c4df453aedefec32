//! An operator who jogs around the part from place to place, and then ends the session.

use std::time::Duration;

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::Mm2;

use super::arm::{Lag, Reaction};

/// Reaction time, in inputs: 0.25 s.
const REACTION: usize = 25;
/// Time before a place at which the operator slows down, s.
const SLOWS_S: f64 = 0.8;
/// Least speed of approach to a place, mm/s.
const LEAST_MM_S: f64 = 1.0;
/// Least deflection of the stick.
const LEAST_TILT: f64 = 0.04;
/// Fastest speed at which a person follows a line to a few millimetres by hand, mm/s: the steering law of
/// Accot and Zhai, with a seventh of a second for each width of 4 mm.
const CAREFUL_MM_S: f64 = 28.0;
/// Least approach that counts as progress, mm.
const PROGRESS_MM: f64 = 0.2;

/// Jogs from place to place at full stick, and slows down near each place. It skips a place that the tool
/// cannot reach.
#[derive(Clone, Debug)]
pub struct Rounds {
    places: Vec<Mm2>,
    speed_mm_s: f64,
    /// Distance at which a place counts as reached, mm.
    reach_mm: f64,
    patience: Duration,
    next: usize,
    nearest_mm: f64,
    since: Time,
    reaction: Reaction,
    hand: Lag,
}

impl Rounds {
    /// An operator for a tool with a top speed of `speed_mm_s`. A place counts as reached within `reach_mm`.
    /// The operator gives it up if the tool comes no nearer for `patience`.
    #[must_use]
    pub fn new(places: Vec<Mm2>, speed_mm_s: f64, reach_mm: f64, patience: Duration) -> Self {
        Self {
            places,
            speed_mm_s,
            reach_mm,
            patience,
            next: 0,
            nearest_mm: f64::INFINITY,
            since: Time::ZERO,
            reaction: Reaction::default(),
            hand: Lag::default(),
        }
    }

    fn go_on(&mut self, now: Time) {
        self.next += 1;
        self.nearest_mm = f64::INFINITY;
        self.since = now;
    }
}

impl Operator for Rounds {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        let Some(position) = view.position_mm.filter(|_| view.phase != Phase::Starting) else {
            self.since = now;
            return OperatorInput::default();
        };
        let Some(place) = self.places.get(self.next).copied() else { return OperatorInput::default() };
        let way = place - position;
        let far = way.length();
        if far < self.nearest_mm - PROGRESS_MM {
            (self.nearest_mm, self.since) = (far, now);
        }
        if far < self.reach_mm || now.since(self.since) > self.patience {
            self.go_on(now);
        }
        let seen = self.reaction.step(way, REACTION);
        let seen_far = seen.length().max(1e-9);
        let speed_mm_s = (seen_far / SLOWS_S).clamp(LEAST_MM_S, CAREFUL_MM_S);
        let deflection = (speed_mm_s / self.speed_mm_s).clamp(LEAST_TILT, 1.0);
        let velocity = self.hand.step(seen / seen_far * deflection);
        OperatorInput { velocity, ..OperatorInput::default() }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        (self.next >= self.places.len()).then_some(OperatorCommand::Stop)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::view;
    use super::*;

    /// The operator reaches one place after the other, gives up the unreachable one, and ends.
    #[test]
    fn rounds_visit_reachable_places_and_end() {
        let places = [(30.0, 0.0), (30.0, 40.0), (-60.0, 40.0)].map(Mm2::from);
        let mut rounds = Rounds::new(places.to_vec(), 20.0, 1.0, Duration::from_secs(2));
        let mut view = view(Phase::Manual);
        let (mut at, mut passed) = (Mm2::ZERO, [false; 3]);
        for tick in 0..4000_u64 {
            view.position_mm = Some(at);
            let input = rounds.input(&view, Time::from_micros(tick * 10_000));
            if rounds.command().is_some() {
                assert_eq!(passed, [true, true, false]);
                return;
            }
            // A wall at −20 mm.
            at += input.velocity * 0.2;
            at.x = at.x.max(-20.0);
            for (passed, &place) in passed.iter_mut().zip(&places) {
                *passed |= at.distance(place) < 1.5;
            }
        }
        panic!("the rounds do not end: at {at:?}");
    }
}

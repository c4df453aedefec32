//! Models of operators.

use std::f64::consts::TAU;

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorInput, Phase};
use keepout_guard::Time;

use super::arm::{DT, Lag, Reaction, Sticking, Tremor};

/// How a model behaves while it steers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelKind {
    /// Goes from place to place around the part, with reaction time, arm and tremor.
    Calm,
    /// Random directions and sudden steps.
    Random,
    /// Full deflection straight at the nearest wall, grazing, and letting go at the last moment.
    Wall,
    /// Full reversals, timed to the wall.
    Reversal,
    /// As calm, but quicker to react, and the hand trembles by a fifth of the throw at 8 to 12 Hz.
    Jittery,
    /// Goes from place to place with a stick that sticks: for seconds it holds its deflection, or falls to its stop,
    /// while the person wants something else.
    Stuck,
}

impl ModelKind {
    /// The names by which models are commanded for.
    pub const NAMES: [&'static str; 6] = ["calm", "random", "wall", "reversal", "jittery", "stuck"];

    /// The model of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "calm" => Self::Calm,
            "random" => Self::Random,
            "wall" => Self::Wall,
            "reversal" => Self::Reversal,
            "jittery" => Self::Jittery,
            "stuck" => Self::Stuck,
            _ => return None,
        })
    }
}

/// Reaction time of the calm operator, in inputs.
const REACTION: usize = 25;
/// Reaction time of the jittery operator, in inputs.
const QUICK_REACTION: usize = 20;
/// Strongest tremor of the jittery operator, share of the throw.
const TREMOR: f64 = 0.2;
/// In automatic mode the operator walks up to the part at this deflection.
const APPROACH: f64 = 0.25;
/// An automatic phase that has not begun to contour after this time is given up, s.
const TOUCH_WITHIN: f64 = 240.0;

/// A modelled operator: steers for a while, then touches the part and lets it be contoured, then quits.
#[derive(Clone, Debug)]
pub struct Model {
    kind: ModelKind,
    jog_s: f64,
    random: fastrand::Rng,
    began: Option<Time>,
    automatic_since: Option<Time>,
    goal: (f64, f64),
    until: f64,
    variant: f64,
    hand: Lag,
    drift: (f64, f64),
    reaction: Reaction,
    tremor: Tremor,
    sticking: Sticking,
}

impl Model {
    /// A model that steers for `jog_s` seconds from its first manual moment.
    #[must_use]
    pub fn new(kind: ModelKind, jog_s: f64, seed: u64) -> Self {
        Self {
            kind,
            jog_s,
            random: fastrand::Rng::with_seed(seed),
            began: None,
            automatic_since: None,
            goal: (0.0, 0.0),
            until: 0.0,
            variant: 0.0,
            hand: Lag::default(),
            drift: (0.0, 0.0),
            reaction: Reaction::default(),
            tremor: Tremor::default(),
            sticking: Sticking::default(),
        }
    }

    fn steer(&mut self, view: &OperatorView, t: f64) -> (f64, f64) {
        match self.kind {
            ModelKind::Calm => self.calm(view, t),
            ModelKind::Random => self.random(t),
            ModelKind::Wall => self.wall(view, t),
            ModelKind::Reversal => self.reversal(view, t),
            ModelKind::Jittery => self.jittery(view, t),
            ModelKind::Stuck => self.stuck(view, t),
        }
    }

    fn calm(&mut self, view: &OperatorView, t: f64) -> (f64, f64) {
        let Some((x, y)) = self.go_around(view, t, REACTION) else { return (0.0, 0.0) };
        let tremor = 0.002 * (TAU * 9.0 * t).sin();
        let remnant = 1.0 + 0.05 * (self.random.f64() - 0.5);
        (x * remnant + tremor, y * remnant - tremor)
    }

    fn jittery(&mut self, view: &OperatorView, t: f64) -> (f64, f64) {
        let (x, y) = self.go_around(view, t, QUICK_REACTION).unwrap_or((0.0, 0.0));
        let tremor = self.tremor.step(TREMOR, &mut self.random);
        (x + tremor.0, y + tremor.1)
    }

    fn stuck(&mut self, view: &OperatorView, t: f64) -> (f64, f64) {
        let wanted = self.go_around(view, t, REACTION).unwrap_or((0.0, 0.0));
        self.sticking.step(wanted, t, &mut self.random)
    }

    /// Where the arm has the stick on the way from place to place; none while the position is not known.
    fn go_around(&mut self, view: &OperatorView, t: f64, reaction: usize) -> Option<(f64, f64)> {
        let position = view.position_mm?;
        if t >= self.until {
            self.goal = self.place_around(view.part_box_mm);
            self.until = t + 2.0 + 4.0 * self.random.f64();
        }
        let error = (self.goal.0 - position.0, self.goal.1 - position.1);
        let (ex, ey) = self.reaction.step(error, reaction);
        let far = ex.hypot(ey).max(1e-9);
        // Full use of the stick (0.6) beyond 20 mm, less when near.
        let want = (far / 20.0).min(1.0) * 0.6;
        Some(self.hand.step((ex / far * want, ey / far * want)))
    }

    /// Somewhere in the box around the part, grown by a fifth: outside it, near it, or on it.
    fn place_around(&mut self, (x0, y0, x1, y1): (f64, f64, f64, f64)) -> (f64, f64) {
        let (w, h) = (x1 - x0, y1 - y0);
        (x0 + w * (1.4 * self.random.f64() - 0.2), y0 + h * (1.4 * self.random.f64() - 0.2))
    }

    /// Ornstein–Uhlenbeck, 0.15 s and 0.5 of full scale, with a sudden step now and then.
    fn random(&mut self, t: f64) -> (f64, f64) {
        let noise = |random: &mut fastrand::Rng| (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        let (decay, kick) = ((-DT / 0.15_f64).exp(), 0.5 * (1.0 - (-2.0 * DT / 0.15_f64).exp()).sqrt());
        self.drift.0 = self.drift.0 * decay + kick * noise(&mut self.random);
        self.drift.1 = self.drift.1 * decay + kick * noise(&mut self.random);
        if t >= self.until {
            self.until = t + 0.1 + 1.5 * self.random.f64();
            let phi = TAU * self.random.f64();
            self.goal = (phi.cos(), phi.sin());
        }
        (self.drift.0 + self.goal.0, self.drift.1 + self.goal.1)
    }

    /// At the wall with everything, by turns straight, grazing by 5°, along it, and letting go for 50 ms.
    fn wall(&mut self, view: &OperatorView, t: f64) -> (f64, f64) {
        let (Some(position), Some(wall)) = (view.position_mm, view.wall_mm) else { return (0.0, 0.0) };
        if t >= self.until {
            self.until = t + 0.3 + 1.7 * self.random.f64();
            let graze = 5.0_f64.to_radians();
            let variants = [0.0, 0.0, graze, -graze, 0.9, -0.9, 1.45, -1.45, f64::NAN];
            self.variant = variants[self.random.usize(0..variants.len())];
        }
        if self.variant.is_nan() && t + 0.05 > self.until {
            return (0.0, 0.0);
        }
        let turn = if self.variant.is_nan() { 0.0 } else { self.variant };
        toward(position, wall, turn)
    }

    fn reversal(&mut self, view: &OperatorView, t: f64) -> (f64, f64) {
        let (Some(position), Some(wall)) = (view.position_mm, view.wall_mm) else { return (0.0, 0.0) };
        if t >= self.until {
            self.until = t + 0.1 + 0.9 * self.random.f64();
            self.variant = if self.variant == 0.0 { std::f64::consts::PI } else { 0.0 };
            self.goal.0 = 2.4 * (self.random.f64() - 0.5);
        }
        toward(position, wall, self.variant + self.goal.0)
    }
}

/// The unit vector from one point toward another, turned by an angle.
pub fn toward(from: (f64, f64), to: (f64, f64), turn: f64) -> (f64, f64) {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx.hypot(dy).max(1e-9);
    let (x, y) = (dx / length, dy / length);
    (x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos())
}

impl Operator for Model {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        if view.phase == Phase::Starting {
            return OperatorInput::default();
        }
        let began = *self.began.get_or_insert(now);
        let t = now.since(began).as_secs_f64();
        if t < self.jog_s {
            return OperatorInput { velocity: self.steer(view, t), ..OperatorInput::default() };
        }
        let since = *self.automatic_since.get_or_insert(now);
        if view.contoured && view.phase.is_steered() {
            return OperatorInput::STOP;
        }
        if matches!(view.phase, Phase::Contouring | Phase::Touching) {
            return OperatorInput { automatic: true, ..OperatorInput::default() };
        }
        let waited = now.since(since).as_secs_f64();
        if waited > TOUCH_WITHIN {
            return OperatorInput::STOP;
        }
        let (Some(position), Some(wall)) = (view.position_mm, view.wall_mm) else {
            return OperatorInput::default();
        };
        // A tool that stands too near, as after a contour that was interrupted, is led away first.
        let turn = if view.phase == Phase::Escaping { std::f64::consts::PI } else { 0.0 };
        let (x, y) = toward(position, wall, turn);
        OperatorInput { velocity: (x * APPROACH, y * APPROACH), automatic: true, ..OperatorInput::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::tests::view;

    /// What a model inputs during a minute in which the tool follows it at up to 50 mm/s.
    fn minute(kind: ModelKind, seed: u64) -> Vec<(f64, f64)> {
        let mut model = Model::new(kind, 100.0, seed);
        let mut view = view(Phase::Manual);
        let mut at = (-20.0, 10.0);
        (0..6000)
            .map(|i| {
                view.position_mm = Some(at);
                let (x, y) = model.input(&view, Time::from_micros(i * 10_000)).velocity;
                at = (at.0 + 0.5 * x, at.1 + 0.5 * y);
                (x, y)
            })
            .collect()
    }

    #[test]
    fn a_seed_makes_the_model() {
        for name in ModelKind::NAMES {
            let kind = ModelKind::named(name).unwrap();
            let first = minute(kind, 7);
            assert_eq!(first, minute(kind, 7), "{name}");
            assert_ne!(first, minute(kind, 8), "{name}");
            assert!(first.iter().any(|(x, y)| x.hypot(*y) > 0.1), "{name}");
        }
    }

    #[test]
    fn the_jittery_hand_trembles_at_8_to_12_hertz_with_an_amplitude_that_matters() {
        let inputs = minute(ModelKind::Jittery, 1);
        // What is quicker than the arm: the difference to the mean of a tenth of a second around.
        let quick: Vec<f64> = inputs
            .windows(11)
            .map(|around| around[5].0 - around.iter().map(|input| input.0).sum::<f64>() / 11.0)
            .collect();
        let rises = quick.windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count();
        assert!((8 * 59..=12 * 61).contains(&rises), "{rises} periods in a minute");
        assert!(quick.iter().filter(|deflection| deflection.abs() > 0.05).count() > 2000);
    }

    #[test]
    fn the_stuck_stick_holds_for_seconds_and_sometimes_at_its_stop() {
        let inputs = minute(ModelKind::Stuck, 1);
        let mut longest = [0, 0];
        let mut same = 0;
        for pair in inputs.windows(2) {
            same = if pair[0] == pair[1] { same + 1 } else { 0 };
            let full = usize::from((pair[1].0.hypot(pair[1].1) - 1.0).abs() < 1e-9);
            longest[full] = longest[full].max(same);
        }
        assert!(longest[0] > 150 && longest[1] > 90, "{longest:?} wishes");
    }
}

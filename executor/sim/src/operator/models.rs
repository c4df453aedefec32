//! Models of operators.

use std::f64::consts::TAU;

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::{Box2, Mm2};

use super::arm::{DT, Lag, Reaction, Sticking, Tremor};
use super::climb::{Climb, to_contact};

/// The jogging behaviour of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelKind {
    /// Moves from place to place around the part, with reaction time, arm and tremor.
    Calm,
    /// Random directions and sudden steps.
    Random,
    /// Full deflection at the nearest wall: straight, grazing, along it, and released at the last moment.
    Wall,
    /// Full reversals, timed to the wall.
    Reversal,
    /// As calm, with a shorter reaction time, and a tremor of a fifth of the throw at 8 to 12 Hz.
    Jittery,
    /// Moves from place to place with a sticking stick: for seconds it holds its deflection, or falls to its
    /// stop, against the person's intention.
    Stuck,
}

impl ModelKind {
    /// The names of the models.
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
/// Deflection with which the operator approaches the part while the cycle is armed.
const APPROACH: f64 = 0.25;
/// Time limit from arming the cycle to the contour start, s. Then the model stops.
const TOUCH_WITHIN: f64 = 240.0;

/// A modelled operator: it jogs for some time, touches the part for a contact start, and stops after the
/// contour.
#[derive(Clone, Debug)]
pub struct Model {
    kind: ModelKind,
    jog_s: f64,
    random: fastrand::Rng,
    began: Option<Time>,
    armed_since: Option<Time>,
    over: bool,
    goal: Mm2,
    until: f64,
    variant: f64,
    hand: Lag,
    drift: Mm2,
    reaction: Reaction,
    tremor: Tremor,
    sticking: Sticking,
    climb: Climb,
    /// Whether the session has a third axis.
    climbs: bool,
    /// Whether the spindle runs, in the last view.
    spindle_runs: bool,
}

impl Model {
    /// A model that jogs for `jog_s` seconds after the start.
    #[must_use]
    pub fn new(kind: ModelKind, jog_s: f64, seed: u64) -> Self {
        Self {
            kind,
            jog_s,
            random: fastrand::Rng::with_seed(seed),
            began: None,
            armed_since: None,
            over: false,
            goal: Mm2::ZERO,
            until: 0.0,
            variant: 0.0,
            hand: Lag::default(),
            drift: Mm2::ZERO,
            reaction: Reaction::default(),
            tremor: Tremor::default(),
            sticking: Sticking::default(),
            climb: Climb::default(),
            climbs: false,
            spindle_runs: false,
        }
    }

    fn steer(&mut self, view: &OperatorView, t: f64) -> Mm2 {
        match self.kind {
            ModelKind::Calm => self.calm(view, t),
            ModelKind::Random => self.random(t),
            ModelKind::Wall => self.wall(view, t),
            ModelKind::Reversal => self.reversal(view, t),
            ModelKind::Jittery => self.jittery(view, t),
            ModelKind::Stuck => self.stuck(view, t),
        }
    }

    fn calm(&mut self, view: &OperatorView, t: f64) -> Mm2 {
        let Some(wanted) = self.go_around(view, t, REACTION) else { return Mm2::ZERO };
        let tremor = 0.002 * (TAU * 9.0 * t).sin();
        let remnant = 1.0 + 0.05 * (self.random.f64() - 0.5);
        wanted * remnant + Mm2::new(tremor, -tremor)
    }

    fn jittery(&mut self, view: &OperatorView, t: f64) -> Mm2 {
        let wanted = self.go_around(view, t, QUICK_REACTION).unwrap_or_default();
        wanted + self.tremor.step(TREMOR, &mut self.random)
    }

    fn stuck(&mut self, view: &OperatorView, t: f64) -> Mm2 {
        let wanted = self.go_around(view, t, REACTION).unwrap_or_default();
        self.sticking.step(wanted, t, &mut self.random)
    }

    /// The arm's stick deflection on the way from place to place; `None` while the position is unknown.
    fn go_around(&mut self, view: &OperatorView, t: f64, reaction: usize) -> Option<Mm2> {
        let position = view.position_mm?;
        if t >= self.until {
            self.goal = self.place_around(view.part_box);
            self.until = t + 2.0 + 4.0 * self.random.f64();
        }
        let error = self.reaction.step(self.goal - position, reaction);
        let far = error.length().max(1e-9);
        // Full use of the stick (0.6) beyond 20 mm, less at smaller distances.
        let want = (far / 20.0).min(1.0) * 0.6;
        Some(self.hand.step(error / far * want))
    }

    /// A random place in the box around the part, grown by a fifth: outside the part, near it, or on it.
    fn place_around(&mut self, part: Box2) -> Mm2 {
        let mut share = || 1.4 * self.random.f64() - 0.2;
        let (x, y) = (share(), share());
        part.low + Mm2::new(part.size().x * x, part.size().y * y)
    }

    /// An Ornstein–Uhlenbeck process, 0.15 s and 0.5 of full scale, with sudden steps.
    fn random(&mut self, t: f64) -> Mm2 {
        let noise = |random: &mut fastrand::Rng| (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        let (decay, kick) = ((-DT / 0.15_f64).exp(), 0.5 * (1.0 - (-2.0 * DT / 0.15_f64).exp()).sqrt());
        self.drift.x = self.drift.x * decay + kick * noise(&mut self.random);
        self.drift.y = self.drift.y * decay + kick * noise(&mut self.random);
        if t >= self.until {
            self.until = t + 0.1 + 1.5 * self.random.f64();
            self.goal = Mm2::unit(TAU * self.random.f64());
        }
        self.drift + self.goal
    }

    /// Full deflection at the wall: straight, grazing by 5°, along it, and released 50 ms before each change.
    fn wall(&mut self, view: &OperatorView, t: f64) -> Mm2 {
        let (Some(position), Some(wall)) = (view.position_mm, view.wall_mm) else { return Mm2::ZERO };
        if t >= self.until {
            self.until = t + 0.3 + 1.7 * self.random.f64();
            let graze = 5.0_f64.to_radians();
            let variants = [0.0, 0.0, graze, -graze, 0.9, -0.9, 1.45, -1.45, f64::NAN];
            self.variant = variants[self.random.usize(0..variants.len())];
        }
        if self.variant.is_nan() && t + 0.05 > self.until {
            return Mm2::ZERO;
        }
        let turn = if self.variant.is_nan() { 0.0 } else { self.variant };
        position.direction_to(wall).turned(turn)
    }

    fn reversal(&mut self, view: &OperatorView, t: f64) -> Mm2 {
        let (Some(position), Some(wall)) = (view.position_mm, view.wall_mm) else { return Mm2::ZERO };
        if t >= self.until {
            self.until = t + 0.1 + 0.9 * self.random.f64();
            self.variant = if self.variant == 0.0 { std::f64::consts::PI } else { 0.0 };
            self.goal.x = 2.4 * (self.random.f64() - 0.5);
        }
        position.direction_to(wall).turned(self.variant + self.goal.x)
    }
}

impl Operator for Model {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        if view.phase == Phase::Starting {
            return OperatorInput::default();
        }
        self.climbs = view.height_mm.is_some();
        self.spindle_runs = view.spindle_runs;
        let began = *self.began.get_or_insert(now);
        let t = now.since(began).as_secs_f64();
        if t < self.jog_s {
            let up = if view.height_mm.is_some() { self.climb.step(t, &mut self.random) } else { 0.0 };
            return OperatorInput { velocity: self.steer(view, t), up, ..OperatorInput::default() };
        }
        let since = *self.armed_since.get_or_insert(now);
        if matches!(view.phase, Phase::Contouring | Phase::Touching) {
            return OperatorInput { armed: true, ..OperatorInput::default() };
        }
        let waited = now.since(since).as_secs_f64();
        self.over = waited > TOUCH_WITHIN || view.contoured && view.phase.is_steered();
        if self.over {
            return OperatorInput::default();
        }
        if let Some(input) = to_contact(view) {
            return input;
        }
        let (Some(position), Some(wall)) = (view.position_mm, view.wall_mm) else {
            return OperatorInput::default();
        };
        // After an interrupted contour the tool stands inside the jogging clearance: the model leads it away
        // first.
        let turn = if view.phase == Phase::Retracting { std::f64::consts::PI } else { 0.0 };
        OperatorInput {
            velocity: position.direction_to(wall).turned(turn) * APPROACH,
            armed: true,
            ..OperatorInput::default()
        }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        if self.over {
            Some(OperatorCommand::Stop)
        } else {
            self.climbs.then(|| self.climb.command(self.spindle_runs)).flatten()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::tests::view;

    /// The inputs of a model during a minute. The tool follows them at up to 50 mm/s.
    fn minute(kind: ModelKind, seed: u64) -> Vec<Mm2> {
        let mut model = Model::new(kind, 100.0, seed);
        let mut view = view(Phase::Manual);
        let mut at = Mm2::new(-20.0, 10.0);
        (0..6000)
            .map(|i| {
                view.position_mm = Some(at);
                let velocity = model.input(&view, Time::from_micros(i * 10_000)).velocity;
                at += velocity * 0.5;
                velocity
            })
            .collect()
    }

    #[test]
    fn equal_seeds_give_equal_inputs() {
        for name in ModelKind::NAMES {
            let kind = ModelKind::named(name).unwrap();
            let first = minute(kind, 7);
            assert_eq!(first, minute(kind, 7), "{name}");
            assert_ne!(first, minute(kind, 8), "{name}");
            assert!(first.iter().any(|velocity| velocity.length() > 0.1), "{name}");
        }
    }

    #[test]
    fn jittery_model_has_a_strong_tremor_of_8_to_12_hertz() {
        let inputs = minute(ModelKind::Jittery, 1);
        // The part faster than the arm: the difference to the mean over 0.1 s.
        let quick: Vec<f64> = inputs
            .windows(11)
            .map(|around| around[5].x - around.iter().map(|input| input.x).sum::<f64>() / 11.0)
            .collect();
        let rises = quick.windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count();
        assert!((8 * 59..=12 * 61).contains(&rises), "{rises} periods in a minute");
        assert!(quick.iter().filter(|deflection| deflection.abs() > 0.05).count() > 2000);
    }

    #[test]
    fn stuck_model_holds_its_deflection_for_seconds_and_sometimes_at_the_stop() {
        let inputs = minute(ModelKind::Stuck, 1);
        let mut longest = [0, 0];
        let mut same = 0;
        for pair in inputs.windows(2) {
            same = if pair[0] == pair[1] { same + 1 } else { 0 };
            let full = usize::from((pair[1].length() - 1.0).abs() < 1e-9);
            longest[full] = longest[full].max(same);
        }
        assert!(longest[0] > 150 && longest[1] > 90, "{longest:?} inputs");
    }
}

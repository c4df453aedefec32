//! Models of operators.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::{Operator, Seen};
use crate::supervisor::{Phase, Wish};
use crate::time::Time;

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
}

impl ModelKind {
    /// The names by which models are asked for.
    pub const NAMES: [&'static str; 4] = ["calm", "random", "wall", "reversal"];

    /// The model of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "calm" => Self::Calm,
            "random" => Self::Random,
            "wall" => Self::Wall,
            "reversal" => Self::Reversal,
            _ => return None,
        })
    }
}

/// Between two wishes, s.
const DT: f64 = 0.01;
/// Reaction time of the calm operator, in wishes.
const REACTION: usize = 25;
/// In automatic mode the operator walks up to the part at this deflection.
const APPROACH: f64 = 0.25;
/// An automatic phase that has not begun to contour after this time is given up, s.
const TOUCH_WITHIN: f64 = 240.0;

/// A modelled operator: steers for a while, then touches the part and lets it be contoured, then quits.
#[derive(Clone, Debug)]
pub struct Model {
    kind: ModelKind,
    manual_s: f64,
    random: fastrand::Rng,
    began: Option<Time>,
    automatic_since: Option<Time>,
    goal: (f64, f64),
    until: f64,
    variant: f64,
    hand: Lag,
    drift: (f64, f64),
    delayed: VecDeque<(f64, f64)>,
}

/// The arm: a second-order lag, 10 rad/s, damping 0.7.
#[derive(Clone, Copy, Debug, Default)]
struct Lag {
    at: (f64, f64),
    rate: (f64, f64),
}

impl Lag {
    fn step(&mut self, to: (f64, f64)) -> (f64, f64) {
        const W: f64 = 10.0;
        let axis = |at: &mut f64, rate: &mut f64, to: f64| {
            *rate += (W * W * (to - *at) - 1.4 * W * *rate) * DT;
            *at += *rate * DT;
        };
        axis(&mut self.at.0, &mut self.rate.0, to.0);
        axis(&mut self.at.1, &mut self.rate.1, to.1);
        self.at
    }
}

impl Model {
    /// A model that steers for `manual_s` seconds from its first manual moment.
    #[must_use]
    pub fn new(kind: ModelKind, manual_s: f64, seed: u64) -> Self {
        Self {
            kind,
            manual_s,
            random: fastrand::Rng::with_seed(seed),
            began: None,
            automatic_since: None,
            goal: (0.0, 0.0),
            until: 0.0,
            variant: 0.0,
            hand: Lag::default(),
            drift: (0.0, 0.0),
            delayed: VecDeque::new(),
        }
    }

    fn steer(&mut self, seen: &Seen, t: f64) -> (f64, f64) {
        match self.kind {
            ModelKind::Calm => self.calm(seen, t),
            ModelKind::Random => self.random(t),
            ModelKind::Wall => self.wall(seen, t),
            ModelKind::Reversal => self.reversal(seen, t),
        }
    }

    fn calm(&mut self, seen: &Seen, t: f64) -> (f64, f64) {
        let Some(position) = seen.position_mm else { return (0.0, 0.0) };
        if t >= self.until {
            self.goal = self.place_around(seen.part_box_mm);
            self.until = t + 2.0 + 4.0 * self.random.f64();
        }
        self.delayed.push_back((self.goal.0 - position.0, self.goal.1 - position.1));
        let error = if self.delayed.len() > REACTION { self.delayed.pop_front() } else { None };
        let (ex, ey) = error.unwrap_or((0.0, 0.0));
        let far = ex.hypot(ey).max(1e-9);
        // Full use of the stick (0.6) beyond 20 mm, less when near.
        let want = (far / 20.0).min(1.0) * 0.6;
        let (x, y) = self.hand.step((ex / far * want, ey / far * want));
        let tremor = 0.002 * (TAU * 9.0 * t).sin();
        let remnant = 1.0 + 0.05 * (self.random.f64() - 0.5);
        (x * remnant + tremor, y * remnant - tremor)
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
    fn wall(&mut self, seen: &Seen, t: f64) -> (f64, f64) {
        let (Some(position), Some(wall)) = (seen.position_mm, seen.wall_mm) else { return (0.0, 0.0) };
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

    fn reversal(&mut self, seen: &Seen, t: f64) -> (f64, f64) {
        let (Some(position), Some(wall)) = (seen.position_mm, seen.wall_mm) else { return (0.0, 0.0) };
        if t >= self.until {
            self.until = t + 0.1 + 0.9 * self.random.f64();
            self.variant = if self.variant == 0.0 { std::f64::consts::PI } else { 0.0 };
            self.goal.0 = 2.4 * (self.random.f64() - 0.5);
        }
        toward(position, wall, self.variant + self.goal.0)
    }
}

/// The unit vector from one point toward another, turned by an angle.
fn toward(from: (f64, f64), to: (f64, f64), turn: f64) -> (f64, f64) {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx.hypot(dy).max(1e-9);
    let (x, y) = (dx / length, dy / length);
    (x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos())
}

impl Operator for Model {
    fn wish(&mut self, seen: &Seen, now: Time) -> Wish {
        if seen.phase == Phase::Starting {
            return Wish::default();
        }
        let began = *self.began.get_or_insert(now);
        let t = now.since(began).as_secs_f64();
        if t < self.manual_s {
            return Wish { direction: self.steer(seen, t), ..Wish::default() };
        }
        let since = *self.automatic_since.get_or_insert(now);
        if seen.contoured && seen.phase.is_steered() {
            return Wish::QUIT;
        }
        if matches!(seen.phase, Phase::Contouring | Phase::Touching) {
            return Wish { automatic: true, ..Wish::default() };
        }
        let waited = now.since(since).as_secs_f64();
        if waited > TOUCH_WITHIN {
            return Wish::QUIT;
        }
        let (Some(position), Some(wall)) = (seen.position_mm, seen.wall_mm) else { return Wish::default() };
        let (x, y) = toward(position, wall, 0.0);
        Wish { direction: (x * APPROACH, y * APPROACH), automatic: true, ..Wish::default() }
    }
}

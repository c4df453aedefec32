//! Hostile operators: models that try to drive the tool into the part.

use std::f64::consts::{PI, TAU};
use std::time::Duration;

use fastrand::Rng;
use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_sim::operator::{Climb, Model, ModelKind};

/// The style of a hostile operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// One of the simulator's operator models.
    Model(ModelKind),
    /// Chooses time and velocity by the motions in flight: around corners, back, or into the wall.
    Adversarial,
    /// Turns the handwheels into the wall.
    Wheels,
    /// Turns the handwheels as [`Style::Adversarial`] moves the stick. No cancel stops these motions.
    WheelsAround,
    /// Pushes for 1.5 s, and releases for 1.5 s.
    Stale,
}

impl Style {
    /// All styles.
    pub const ALL: [Self; 10] = [
        Self::Model(ModelKind::Calm),
        Self::Model(ModelKind::Jittery),
        Self::Model(ModelKind::Wall),
        Self::Model(ModelKind::Random),
        Self::Model(ModelKind::Stuck),
        Self::Model(ModelKind::Reversal),
        Self::Adversarial,
        Self::Wheels,
        Self::WheelsAround,
        Self::Stale,
    ];
}

/// A hostile operator. It jogs in its style, and gives operator commands at random.
pub struct Hostile {
    style: Style,
    model: Model,
    random: Rng,
    every: Duration,
    until: Time,
    turn: f64,
    automatic: bool,
    command: Option<OperatorCommand>,
    /// Command of this input, until the session takes it.
    given: Option<OperatorCommand>,
    climb: Climb,
    /// Whether the handwheel moves the third axis, and not the keys.
    winds: bool,
    /// Chance of a feed hold or cycle start, for each input.
    restless: f64,
}

/// Longer than any session, s.
const FOREVER_S: f64 = 1e6;

impl Hostile {
    /// Builds an operator of the style. If it is `automatic`, it arms the cycle from time to time.
    #[must_use]
    pub fn new(style: Style, automatic: bool, seed: u64) -> Self {
        let mut random = Rng::with_seed(seed);
        let kind = if let Style::Model(kind) = style { kind } else { ModelKind::Wall };
        Self {
            style,
            model: Model::new(kind, FOREVER_S, random.u64(..)),
            every: Duration::from_millis(random.u64(10..50)),
            until: Time::ZERO,
            turn: 0.0,
            automatic,
            command: None,
            given: None,
            climb: Climb::default(),
            winds: matches!(style, Style::Wheels | Style::WheelsAround),
            restless: [0.0, 0.0, 0.01, 0.1][random.usize(0..4)],
            random,
        }
    }

    fn velocity(&mut self, view: &OperatorView, now: Time) -> (Mm2, Mm2) {
        let still = Mm2::ZERO;
        match self.style {
            Style::Model(_) => (self.model.input(view, now).velocity, still),
            Style::Adversarial => (self.against(view, now), still),
            Style::Wheels => {
                let toward = self.toward(view, 0.0);
                let step = [0.01, 0.1, 1.0, 3.0][self.random.usize(0..4)];
                (still, toward * step)
            }
            Style::WheelsAround => {
                let direction = self.against(view, now);
                let step = [0.3, 1.0, 3.0, 9.0][self.random.usize(0..4)];
                (still, direction * step)
            }
            Style::Stale => {
                let phase = now.elapsed().as_secs_f64() % 3.0;
                (if phase < 1.5 { self.toward(view, self.turn) } else { still }, still)
            }
        }
    }

    /// A direction relative to the wall, seen from the end of the motions in flight. It changes at random
    /// times, often when all motions are acknowledged.
    fn against(&mut self, view: &OperatorView, now: Time) -> Mm2 {
        if now >= self.until || view.unacknowledged == 0 && self.random.u8(0..4) == 0 {
            self.until = now.after(Duration::from_millis(self.random.u64(20..800)));
            self.turn = match self.random.u8(0..6) {
                0 => 0.0,
                1 => PI / 2.0,
                2 => -PI / 2.0,
                3 => PI,
                4 => 0.05,
                _ => TAU * self.random.f64(),
            };
        }
        let (Some(end), Some(wall)) = (view.end_mm, view.wall_mm) else { return Mm2::ZERO };
        end.direction_to(wall).turned(self.turn)
    }

    fn toward(&mut self, view: &OperatorView, turn: f64) -> Mm2 {
        let (Some(position), Some(wall)) = (view.position_mm, view.wall_mm) else { return Mm2::ZERO };
        position.direction_to(wall).turned(turn)
    }

    fn commanded(&mut self, phase: Phase) -> Option<OperatorCommand> {
        if self.command.take().is_some() {
            return None;
        }
        let chance = self.random.f64();
        self.command = match phase {
            Phase::Faulted if chance < 0.05 => Some(OperatorCommand::Recover),
            Phase::Contouring if chance < self.restless => Some(OperatorCommand::FeedHold),
            Phase::Contouring if chance < 2.0 * self.restless => {
                Some(OperatorCommand::Feed { percent: self.random.u8(..) })
            }
            Phase::Holding if chance < 0.05 => Some(OperatorCommand::CycleStart),
            phase if phase.is_steered() && chance < self.restless => Some(OperatorCommand::CycleStart),
            _ => None,
        };
        self.command
    }
}

impl Operator for Hostile {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        if view.phase == Phase::Starting {
            return OperatorInput::default();
        }
        let (velocity, turned_mm) = self.velocity(view, now);
        // The operator arms the cycle for 8 s of every 16 s.
        let armed = self.automatic && now.micros() % 16_000_000 > 8_000_000;
        self.given = self.commanded(view.phase);
        let mut input = OperatorInput { velocity, turned_mm, armed, ..OperatorInput::default() };
        if view.height_mm.is_some() {
            let up = self.climb.step(now.elapsed().as_secs_f64(), &mut self.random);
            if self.winds {
                input.turned_up_mm = up * [0.01, 0.1, 1.0][self.random.usize(0..3)];
            } else {
                input.up = up;
            }
            let stops = view.spindle_runs && self.random.u16(0..2000) == 0;
            let climb = || self.climb.command(view.spindle_runs);
            let stop = stops.then_some(OperatorCommand::Spindle { runs: false });
            self.given = self.given.or(stop).or_else(climb);
        }
        input
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.given.take()
    }

    fn every(&self) -> Duration {
        self.every
    }
}

//! Operator models whose pushes give measurable motions.

use std::sync::{Arc, Mutex};

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput};
use keepout_guard::Time;
use keepout_planner::Mm2;

/// The pushes of an operator model.
pub(super) enum Hand {
    /// One constant velocity.
    Away(Away),
    /// A push along the nearest wall and into it.
    Follow(Follow),
    /// Separate pushes and releases.
    Pushes(Pushes),
}

/// A constant push until the tool is beyond a line, or the time is over.
pub(super) struct Away {
    pub(super) velocity: Mm2,
    /// The direction, and the distance from the origin along it, mm.
    pub(super) beyond: (Mm2, f64),
    pub(super) within_s: f64,
}

/// A push at an angle into the nearest wall, rad, with the wall on the right.
pub(super) struct Follow {
    pub(super) angle: f64,
    pub(super) within_s: f64,
}

/// Pushes with rests between them. It records the times.
pub(super) struct Pushes {
    plan: Vec<(f64, Mm2)>,
    next: usize,
    /// Times at which the pushes began. For a single push, the time at which it ended.
    pub(super) times: Arc<Mutex<Vec<f64>>>,
    keeps: Keeps,
    pushed: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Keeps {
    Pushes,
    Releases,
}

impl Pushes {
    /// `count` pushes of 0.2 s from rest. After each comes a rest of `rest_s` and up to 0.2 s more.
    pub(super) fn new(count: usize, rest_s: f64) -> Self {
        let directions = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)].map(Mm2::from);
        let mut random = fastrand::Rng::with_seed(4);
        let mut at = 1.0;
        let mut plan = Vec::new();
        for k in 0..count {
            plan.push((at, directions[k % 4]));
            plan.push((at + 0.2, Mm2::ZERO));
            at += 0.2 + rest_s + random.f64() * 0.2;
        }
        plan.push((at, Mm2::new(f64::NAN, 0.0)));
        Self { plan, next: 0, times: Arc::default(), keeps: Keeps::Pushes, pushed: false }
    }

    /// One push of `held_s`.
    pub(super) fn once(velocity: Mm2, held_s: f64) -> Self {
        let plan = vec![(0.5, velocity), (0.5 + held_s, Mm2::ZERO), (6.0 + held_s, Mm2::new(f64::NAN, 0.0))];
        Self { plan, next: 0, times: Arc::default(), keeps: Keeps::Releases, pushed: false }
    }

    /// The jog input. `None` after the last push.
    fn input(&mut self, seconds: f64, now: Time) -> Option<OperatorInput> {
        while self.plan.get(self.next).is_some_and(|step| step.0 <= seconds) {
            self.next += 1;
        }
        let velocity = self.next.checked_sub(1).map_or(Mm2::ZERO, |k| self.plan[k].1);
        if velocity.x.is_nan() {
            return None;
        }
        let pushed = velocity != Mm2::ZERO;
        if pushed != self.pushed && pushed == (self.keeps == Keeps::Pushes) {
            self.times.lock().expect("the session has one thread").push(now.elapsed().as_secs_f64());
        }
        self.pushed = pushed;
        Some(OperatorInput { velocity, ..OperatorInput::default() })
    }
}

/// An operator model whose time begins when jogging is first possible.
pub(super) struct Timed {
    pub(super) hand: Hand,
    pub(super) began: Option<Time>,
    pub(super) over: bool,
}

impl Operator for Timed {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        if !view.phase.is_steered() {
            return OperatorInput::default();
        }
        let seconds = now.since(*self.began.get_or_insert(now)).as_secs_f64();
        let jog = |velocity| OperatorInput { velocity, ..OperatorInput::default() };
        let input = match &mut self.hand {
            Hand::Away(away) => {
                let (along, limit) = away.beyond;
                let beyond = view.position_mm.is_some_and(|at| at.dot(along) > limit);
                (!beyond && seconds <= away.within_s).then(|| jog(away.velocity))
            }
            Hand::Follow(follow) => (seconds <= follow.within_s).then(|| jog(follow.velocity(view))),
            Hand::Pushes(pushes) => pushes.input(seconds, now),
        };
        self.over = input.is_none();
        input.unwrap_or_default()
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.over.then_some(OperatorCommand::Stop)
    }
}

impl Follow {
    fn velocity(&self, view: &OperatorView) -> Mm2 {
        let (Some(at), Some(wall)) = (view.position_mm, view.wall_mm) else { return Mm2::ZERO };
        let Mm2 { x, y } = wall - at;
        let (sin, cos) = self.angle.sin_cos();
        let length = x.hypot(y).max(1e-9);
        Mm2::new((x * sin - y * cos) / length, (y * sin + x * cos) / length)
    }
}

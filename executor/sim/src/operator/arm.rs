//! The path from a person's intention to the stick: arm, reaction time, tremor, and a sticking stick.

use keepout_planner::Mm2;
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Time between two inputs, s.
pub(super) const DT: f64 = 0.01;

/// The arm: a second-order lag, 10 rad/s, damping 0.7.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lag {
    at: Mm2,
    rate: Mm2,
}

impl Lag {
    pub(super) fn step(&mut self, to: Mm2) -> Mm2 {
        const W: f64 = 10.0;
        let axis = |at: &mut f64, rate: &mut f64, to: f64| {
            *rate += (W * W * (to - *at) - 1.4 * W * *rate) * DT;
            *at += *rate * DT;
        };
        axis(&mut self.at.x, &mut self.rate.x, to.x);
        axis(&mut self.at.y, &mut self.rate.y, to.y);
        self.at
    }
}

/// The reaction time: the operator acts on an earlier view.
#[derive(Clone, Debug, Default)]
pub(super) struct Reaction {
    seen: VecDeque<Mm2>,
}

impl Reaction {
    /// The view from `inputs` inputs ago; zero before that.
    pub(super) fn step(&mut self, seen: Mm2, inputs: usize) -> Mm2 {
        self.seen.push_back(seen);
        let due = if self.seen.len() > inputs { self.seen.pop_front() } else { None };
        due.unwrap_or_default()
    }
}

/// Tremor of 8 to 12 Hz, independent in each axis, with varying frequency and amplitude.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tremor {
    axes: [Wave; 2],
}

#[derive(Clone, Copy, Debug, Default)]
struct Wave {
    turn: f64,
    hertz: f64,
    strength: f64,
    left: f64,
}

impl Tremor {
    /// The deflection of one input, with an amplitude from half of `most` to `most`.
    pub(super) fn step(&mut self, most: f64, random: &mut fastrand::Rng) -> Mm2 {
        let [x, y] = self.axes.each_mut().map(|wave| wave.step(random) * most);
        Mm2::new(x, y)
    }
}

impl Wave {
    fn step(&mut self, random: &mut fastrand::Rng) -> f64 {
        self.left -= DT;
        if self.left <= 0.0 {
            self.left = 0.2 + 0.5 * random.f64();
            self.hertz = 8.0 + 4.0 * random.f64();
            self.strength = 0.5 + 0.5 * random.f64();
        }
        self.turn = (self.turn + self.hertz * DT).fract();
        self.strength * (TAU * self.turn).sin()
    }
}

/// A stick that sometimes holds its deflection for seconds, regardless of the hand. Sometimes it falls to its
/// stop.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sticking {
    held: Option<Mm2>,
    until: f64,
}

impl Sticking {
    /// The stick's deflection at `t` seconds, when the hand wants `wanted`.
    pub(super) fn step(&mut self, wanted: Mm2, t: f64, random: &mut fastrand::Rng) -> Mm2 {
        if t >= self.until {
            let free = self.held.is_some() || self.until == 0.0;
            self.until = t + if free { 1.0 + 3.0 * random.f64() } else { 1.0 + 4.0 * random.f64() };
            let full = random.u8(0..3) == 0;
            self.held = if free { None } else { Some(if full { at_its_stop(wanted) } else { wanted }) };
        }
        self.held.unwrap_or(wanted)
    }
}

fn at_its_stop(wanted: Mm2) -> Mm2 {
    let length = wanted.length();
    if length > 0.0 { wanted / length } else { Mm2::new(1.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tremor_has_8_to_12_hertz() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut tremor = Tremor::default();
        let waves: Vec<f64> = (0..6000).map(|_| tremor.step(0.2, &mut random).x).collect();
        let rises = waves.windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count();
        assert!((8 * 60..=12 * 60).contains(&rises), "{rises} periods in 60 s");
        assert!(waves.iter().all(|wave| wave.abs() <= 0.2) && waves.iter().any(|wave| wave.abs() > 0.15));
    }

    #[test]
    fn reaction_follows_the_view_after_the_reaction_time() {
        let mut reaction = Reaction::default();
        let answers: Vec<f64> = (1..=30).map(|i| reaction.step(Mm2::new(f64::from(i), 0.0), 20).x).collect();
        assert!(answers[..20].iter().all(|answer| *answer == 0.0));
        assert_eq!(answers[20..], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]);
    }
}

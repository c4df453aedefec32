//! Contouring model-predictive control with a disturbance observer: the most accurate controller here.
//!
//! It predicts the positions over a horizon and minimises three costs: their distances from the *path*, their
//! lags *along* the path behind the reference (with a smaller weight), and changes of the command. Commands
//! stay within the amplifier's limit.
//!
//! The costs are linearised at the point of the path nearest to each predicted position. The first pass uses
//! the plan of the previous sample, the second pass the new plan. Lags are measured along the path. At a
//! sharp corner they draw the tool to the tip and around it, never back. A Kalman observer of each axis
//! estimates position, speed and load.

use nalgebra::{SMatrix, SVector, Vector3};

use super::box_program::BoxProgram;
use super::observer::{Observer, Wander};
use super::{Belief, Controller};
use crate::Axes;
use crate::drive::{Drive, Held};
use crate::path::{Foot, left_of};
use crate::plant::MOST_DELAY;
use crate::reference::{ReferenceSample, ReferenceWindow};

/// Number of predicted samples.
pub const HORIZON: usize = 15;
/// Number of passes that search for the nearest points and solve the program.
const LOOKS: usize = 2;
/// Number of commands of both axes over the horizon.
const COMMANDS: usize = 2 * HORIZON;
/// Largest number of pieces of the path in the search.
const MOST_PIECES: usize = 2 * HORIZON + MOST_DELAY + 2;

/// Weights of the costs, relative to a weight of 1 for the distance from the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Weight of a small lag behind the reference along the path.
    pub lag: f64,
    /// Lag above which the weight falls in inverse proportion to the lag, pulses.
    pub bend: f64,
    /// Smallest weight of a large lag.
    pub least_lag: f64,
    /// Weight of the distance that a change of command causes in its first sample.
    pub effort: f64,
    /// Time in which a load is assumed to change by [`Belief::load_bits`], s.
    pub load_change_s: f64,
    /// Standard deviation of a measurement, pulses. With whole pulses it is at least 0.3.
    pub noise: f64,
}

/// Weights found by trial: on S1 to E3 with all sign patterns of the model error, on the budgets of the
/// built-in machines, and with a delay of one sample.
///
/// A smaller `effort` is more accurate, but oscillates with that delay. Only a limit or a jump of the feed
/// causes a large lag, and such a lag must not pull the tool off the path.
impl Default for Weights {
    fn default() -> Self {
        Self { lag: 0.3, bend: 0.5, least_lag: 0.003, effort: 2000.0, load_change_s: 0.004, noise: 0.05 }
    }
}

impl Weights {
    /// The weight of a lag of the size `lag`, pulses.
    fn lag_share(&self, lag: f64) -> f64 {
        (self.lag * self.bend / lag.abs()).clamp(self.least_lag, self.lag)
    }
}

/// Noise of the observer's model for these drives.
fn wander(belief: &Belief, weights: &Weights) -> Wander {
    // The rounding to whole pulses has a standard deviation of 1/√12 pulse, and the noise comes on top.
    let measurement = if belief.whole_numbers { weights.noise.max(0.3) } else { weights.noise };
    let load = belief.load_bits * (belief.period_s / weights.load_change_s).sqrt();
    Wander { speed: 1.0, load, measurement }
}

/// The contouring controller with its observers and its current plan.
#[derive(Clone, Debug)]
pub struct Contouring {
    weights: Weights,
    limit: Option<f64>,
    /// Commands that do not act yet because of the delay, oldest first. The first `delay` entries are in use.
    pending: [Axes; MOST_DELAY],
    delay: usize,
    observers: [Observer; 2],
    held: [Held; 2],
    /// Positions after 1, 2, … samples, for a command of one bit in the first sample.
    responses: [[f64; HORIZON]; 2],
    commands: SVector<f64, COMMANDS>,
    predicted: Option<[Axes; HORIZON]>,
    last: Axes,
    /// First piece that the plan has not passed yet.
    left: Option<usize>,
}

impl Contouring {
    /// The controller for a drive model, with the default weights.
    #[must_use]
    pub fn new(belief: &Belief) -> Self {
        Self::weighed(belief, Weights::default())
    }

    /// The controller for a drive model, with these weights.
    #[must_use]
    pub fn weighed(belief: &Belief, weights: Weights) -> Self {
        let observer = |drive: Drive| Observer::new(drive, belief.period_s, wander(belief, &weights));
        let held = belief.drives.map(|drive| drive.held(belief.period_s));
        Self {
            weights,
            limit: belief.limit,
            pending: [Axes::zeros(); MOST_DELAY],
            delay: belief.delay_samples.min(MOST_DELAY),
            observers: belief.drives.map(observer),
            held,
            responses: held.map(|held| response(&held)),
            commands: SVector::zeros(),
            predicted: None,
            last: Axes::zeros(),
            left: None,
        }
    }

    /// Predicted positions under the pending commands and then commands of zero.
    fn free(&self, known: &[Vector3<f64>; 2]) -> [Axes; HORIZON] {
        let mut states = *known;
        let mut go_on = |command: Axes| {
            for (axis, (state, held)) in states.iter_mut().zip(&self.held).enumerate() {
                let [position, speed, net] = [state[0], state[1], command[axis] - state[2]];
                state[0] = position + held.run * speed + held.b0 * net;
                state[1] = held.decay * speed + held.push * net;
            }
            Axes::new(states[0][0], states[1][0])
        };
        for &command in &self.pending[..self.delay] {
            go_on(command);
        }
        std::array::from_fn(|_| go_on(Axes::zeros()))
    }

    /// Appends `command` to the pending commands, and returns the command that acts in the next period.
    fn acting(&mut self, command: Axes) -> Axes {
        if self.delay == 0 {
            return command;
        }
        let first = self.pending[0];
        self.pending.copy_within(1..self.delay, 0);
        self.pending[self.delay - 1] = command;
        first
    }

    /// Number of samples from now to the predicted position `i`.
    #[expect(clippy::cast_possible_wrap, reason = "at most the horizon and the longest delay")]
    fn ahead(&self, i: usize) -> isize {
        (i + 1 + self.delay) as isize
    }

    /// Predicted positions under the planned commands.
    fn planned(&self, free: &[Axes; HORIZON]) -> [Axes; HORIZON] {
        std::array::from_fn(|i| {
            let mut position = free[i];
            for j in 0..=i {
                for axis in 0..2 {
                    position[axis] += self.responses[axis][i - j] * self.commands[axis * HORIZON + j];
                }
            }
            position
        })
    }

    /// The nearest points of the path to the planned positions. They never return to a piece that the plan
    /// has passed, and never advance to a piece that the reference has not reached.
    fn places(
        &mut self,
        window: &ReferenceWindow,
        pieces: &Pieces,
        planned: &[Axes; HORIZON],
    ) -> [Place; HORIZON] {
        let mut least = self.left.unwrap_or(window.ahead(0).number);
        let places = std::array::from_fn(|i| {
            let most = window.ahead(self.ahead(i)).number;
            let place = pieces.nearest(planned[i], least..=most.max(least));
            least = place.number;
            place
        });
        self.left = Some(places[0].number);
        places
    }

    /// The quadratic program: distances from the path and lags along it, both linearised at `places`, and
    /// changes of command.
    fn program(
        &self,
        window: &ReferenceWindow,
        free: &[Axes; HORIZON],
        places: &[Place; HORIZON],
    ) -> BoxProgram<COMMANDS> {
        let mut hessian = SMatrix::<f64, COMMANDS, COMMANDS>::zeros();
        let mut linear = SVector::<f64, COMMANDS>::zeros();
        for (i, place) in places.iter().enumerate() {
            let Place { point, normal, tangent, .. } = *place;
            let behind = window.ahead(self.ahead(i)).along - place.along;
            let share = self.weights.lag_share(behind - tangent.dot(&(place.expected - point)));
            let off = free[i] - point;
            let pull = normal * normal.dot(&off) + tangent * (share * (tangent.dot(&off) - behind));
            let weigh = |a: usize, b: usize| normal[a] * normal[b] + share * tangent[a] * tangent[b];
            let weights = [weigh(0, 0), weigh(0, 1), weigh(1, 1)];
            for j in 0..=i {
                let [gx, gy] = [self.responses[0][i - j], self.responses[1][i - j]];
                linear[j] += gx * pull.x;
                linear[HORIZON + j] += gy * pull.y;
                for k in 0..=i {
                    let [hx, hy] = [self.responses[0][i - k], self.responses[1][i - k]];
                    hessian[(k, j)] += weights[0] * gx * hx;
                    hessian[(HORIZON + k, HORIZON + j)] += weights[2] * gy * hy;
                    hessian[(HORIZON + k, j)] += weights[1] * gx * hy;
                }
            }
        }
        for j in 0..HORIZON {
            for k in 0..HORIZON {
                hessian[(j, HORIZON + k)] = hessian[(HORIZON + k, j)];
            }
        }
        self.weigh_changes(&mut hessian, &mut linear);
        BoxProgram { hessian, linear, limit: self.limit }
    }

    /// Adds the cost of changes of command.
    fn weigh_changes(
        &self,
        hessian: &mut SMatrix<f64, COMMANDS, COMMANDS>,
        linear: &mut SVector<f64, COMMANDS>,
    ) {
        for axis in 0..2 {
            let effort = self.weights.effort * self.held[axis].b0 * self.held[axis].b0;
            let first = axis * HORIZON;
            for j in first..first + HORIZON {
                hessian[(j, j)] += effort;
                if j > first {
                    hessian[(j - 1, j - 1)] += effort;
                    hessian[(j, j - 1)] -= effort;
                    hessian[(j - 1, j)] -= effort;
                }
            }
            linear[first] -= effort * self.last[axis];
        }
    }

    /// Moves the plan on by one sample, and repeats its last command.
    fn shift(&mut self) {
        for first in [0, HORIZON] {
            for j in first..first + HORIZON - 1 {
                self.commands[j] = self.commands[j + 1];
            }
        }
    }
}

impl Controller for Contouring {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let known = [self.observers[0].see(measured.x), self.observers[1].see(measured.y)];
        let free = self.free(&known);
        let pieces = Pieces::around(window);
        let mut planned = self.predicted.unwrap_or(std::array::from_fn(|i| window.position(self.ahead(i))));
        for _ in 0..LOOKS {
            let places = self.places(window, &pieces, &planned);
            if let Some(commands) = self.program(window, &free, &places).solved(&self.commands) {
                self.commands = commands;
            }
            planned = self.planned(&free);
        }
        let command = Axes::new(self.commands[0], self.commands[HORIZON]);
        self.last = command;
        let acting = self.acting(command);
        self.observers[0].go_on(acting.x);
        self.observers[1].go_on(acting.y);
        // In the next sample the plan starts one position later. Its last position is used twice.
        self.predicted = Some(std::array::from_fn(|i| planned[(i + 1).min(HORIZON - 1)]));
        self.shift();
        command
    }
}

/// Positions after 1, 2, … samples, for a command of one bit in the first sample.
fn response(held: &Held) -> [f64; HORIZON] {
    let (mut position, mut speed) = (held.b0, held.push);
    std::array::from_fn(|_| {
        let now = position;
        position += held.run * speed;
        speed *= held.decay;
        now
    })
}

/// The distance `along` the piece of `sample`. On a full circle, it is shifted by whole turns to the value
/// nearest to the reference.
fn around(sample: &ReferenceSample, along: f64) -> f64 {
    let length = sample.piece.length();
    let off = along - (sample.along - sample.begins);
    let turns = if sample.piece.is_closed() { (off / length).round() } else { 0.0 };
    along - turns * length
}

/// The nearest point of the path to a predicted position.
#[derive(Clone, Copy, Debug)]
struct Place {
    expected: Axes,
    point: Axes,
    /// Unit vector from the point to the predicted position, or across the path.
    normal: Axes,
    tangent: Axes,
    /// Distance from the start of the path, pulses.
    along: f64,
    number: usize,
}

/// The pieces of the path around the current sample of the reference.
struct Pieces {
    pieces: [Option<ReferenceSample>; MOST_PIECES],
    oldest: ReferenceSample,
}

impl Pieces {
    fn around(window: &ReferenceWindow) -> Self {
        let mut pieces = [None; MOST_PIECES];
        let (mut found, mut last) = (0, None);
        for i in 0..=2 * HORIZON + MOST_DELAY {
            #[expect(clippy::cast_possible_wrap, reason = "at most twice the horizon and the longest delay")]
            let sample = window.ahead(i as isize - HORIZON as isize);
            if last != Some(sample.number) && found < MOST_PIECES {
                pieces[found] = Some(*sample);
                (found, last) = (found + 1, Some(sample.number));
            }
        }
        #[expect(clippy::cast_possible_wrap, reason = "the horizon")]
        let oldest = *window.ahead(-(HORIZON as isize));
        Self { pieces, oldest }
    }

    /// The nearest point to `expected` on the pieces with these numbers. At equal distances, the later one.
    fn nearest(&self, expected: Axes, numbers: std::ops::RangeInclusive<usize>) -> Place {
        let allowed = self.pieces.iter().flatten().filter(|sample| numbers.contains(&sample.number));
        let feet = allowed.map(|sample| (sample, sample.piece.nearest(expected)));
        let distance_2 = |foot: &Foot| (foot.point - expected).norm_squared();
        let best =
            feet.reduce(|best, next| if distance_2(&next.1) <= distance_2(&best.1) { next } else { best });
        // A tool far behind may need a piece that is no longer in the list. Then use the oldest piece.
        let oldest = self.oldest;
        let (sample, Foot { point, tangent, .. }) = best.unwrap_or((&oldest, oldest.piece.nearest(expected)));
        let off = expected - point;
        // Past a corner, the normal points from the corner to the position.
        let beside = off.dot(&tangent).abs() <= 1e-3 * off.norm();
        let normal = if beside || off.norm() < 1e-3 { left_of(tangent) } else { off.normalize() };
        let along = sample.begins + around(sample, sample.piece.along(expected));
        Place { expected, point, normal, tangent, along, number: sample.number }
    }
}

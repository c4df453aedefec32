//! Contouring model-predictive control with a disturbance observer: the best controller here.
//!
//! Over a horizon it minimises the distances of the predicted positions from the *path* and, weighed far less, from the reference
//! on it, and changes of the command; commands keep to the amplifier's limit. Path and normal at each predicted position are those
//! where the prediction of the sample before passed. Positions, speeds and loads come from a Kalman observer of each axis.

use nalgebra::{SMatrix, SVector, Vector3};

use super::box_program::BoxProgram;
use super::observer::{Observer, Wander};
use super::{Belief, Controller};
use crate::servo::Axes;
use crate::servo::drive::{Drive, Held};
use crate::servo::path::{Foot, Piece, left_of};
use crate::servo::reference::Window;

/// Blocks of samples that are looked ahead.
pub const HORIZON: usize = 15;
/// How often path and normal are looked for again where the plan passes.
const LOOKS: usize = 2;
/// Commands of both axes over the horizon.
const COMMANDS: usize = 2 * HORIZON;
/// Pieces of the path that are looked at.
const MOST_PIECES: usize = 2 * HORIZON + 2;

/// What is weighed against what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Of an error along the path, beside 1 of the distance from it.
    pub lag: f64,
    /// Of the position that a change of command brings about in the first block.
    pub effort: f64,
}

/// Found by `keepout servo compare` over S1 to E3 with all sign patterns of model error: less effort is more accurate, and rings
/// with a sample of delay; less lag weight follows corners and saturated starts better, and is slower to catch up.
impl Default for Weights {
    fn default() -> Self {
        Self { lag: 0.003, effort: 1600.0 }
    }
}

/// What a drive's load and speed may do in a sample. In a time of 4/45 of its time constant (the paper's sample) a load that
/// comes up brings about 0.34 pulses.
fn wander(drive: Drive, belief: &Belief) -> Wander {
    // An encoder that counts whole pulses is off by 1/√12 of one.
    let measurement = if belief.whole_numbers { 0.3 } else { 0.05 };
    let time = drive.time_constant_s * 4.0 / 45.0;
    Wander { speed: 1.0, load: 0.34 / drive.held(time).b0 * belief.period_s / time, measurement }
}

/// The controller.
#[derive(Clone, Debug)]
pub struct Contouring {
    weights: Weights,
    limit: Option<f64>,
    observers: [Observer; 2],
    /// The drives over a block, in which the command is held, and its length in samples.
    blocks: [Held; 2],
    stride: isize,
    /// Positions brought about by a bit held for the first block, after 1, 2, … blocks.
    responses: [[f64; HORIZON]; 2],
    commands: SVector<f64, COMMANDS>,
    predicted: Option<[Axes; HORIZON]>,
    last: Axes,
}

/// The horizon in terms of the quicker drive's time constant: shorter ones diverge.
const HORIZON_PER_TIME_CONSTANT: f64 = 1.3;

impl Contouring {
    /// For drives that are believed in.
    #[must_use]
    pub fn new(belief: &Belief) -> Self {
        Self::weighed(belief, Weights::default())
    }

    /// The same with other weights.
    #[must_use]
    pub fn weighed(belief: &Belief, weights: Weights) -> Self {
        let observer = |drive: Drive| Observer::new(drive, belief.period_s, wander(drive, belief));
        let stride = stride(belief);
        #[expect(clippy::cast_precision_loss, reason = "a few samples")]
        let block_s = belief.period_s * stride as f64;
        let blocks = belief.drives.map(|drive| drive.held(block_s));
        Self {
            weights,
            limit: belief.limit,
            observers: belief.drives.map(observer),
            blocks,
            stride,
            responses: blocks.map(|held| response(&held)),
            commands: SVector::zeros(),
            predicted: None,
            last: Axes::zeros(),
        }
    }

    /// The end of block `i`, samples ahead.
    fn end(&self, i: usize) -> isize {
        (count(i) + 1) * self.stride
    }

    /// Where the tool will be under commands of zero.
    fn free(&self, known: &[Vector3<f64>; 2]) -> [Axes; HORIZON] {
        let mut states = *known;
        std::array::from_fn(|_| {
            for (state, held) in states.iter_mut().zip(&self.blocks) {
                let [position, speed, load] = [state[0], state[1], state[2]];
                state[0] = position + held.run * speed - held.b0 * load;
                state[1] = held.decay * speed - held.push * load;
            }
            Axes::new(states[0][0], states[1][0])
        })
    }

    /// Where it will be under the planned commands.
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

    /// The programme: distances from the tangents at `feet`, errors from the reference, changes of command.
    fn program(
        &self,
        window: &Window,
        free: &[Axes; HORIZON],
        feet: &[(Axes, Axes); HORIZON],
    ) -> BoxProgram<COMMANDS> {
        let mut hessian = SMatrix::<f64, COMMANDS, COMMANDS>::zeros();
        let mut linear = SVector::<f64, COMMANDS>::zeros();
        for i in 0..HORIZON {
            let (point, normal) = feet[i];
            let off = normal.dot(&(free[i] - point));
            let reference = window.position(self.end(i));
            let (along, share) = (left_of(normal), self.weights.lag);
            let pull = normal * off + along * (share * along.dot(&(free[i] - reference)));
            let weigh = |a: usize, b: usize| normal[a] * normal[b] + share * along[a] * along[b];
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
            let effort = self.weights.effort * self.blocks[axis].b0 * self.blocks[axis].b0;
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

    /// The plan a sample later, its last command once more.
    fn shift(&mut self) {
        for first in [0, HORIZON] {
            for j in first..first + HORIZON - 1 {
                self.commands[j] = self.commands[j + 1];
            }
        }
    }
}

impl Controller for Contouring {
    fn step(&mut self, window: &Window, measured: Axes) -> Axes {
        let known = [self.observers[0].see(measured.x), self.observers[1].see(measured.y)];
        let free = self.free(&known);
        let pieces = Pieces::around(window, self.stride);
        let mut planned = self.predicted.unwrap_or(std::array::from_fn(|i| window.position(self.end(i))));
        for _ in 0..LOOKS {
            let feet = planned.map(|point| pieces.normal_at(point));
            if let Some(commands) = self.program(window, &free, &feet).solved(&self.commands) {
                self.commands = commands;
            }
            planned = self.planned(&free);
        }
        let command = Axes::new(self.commands[0], self.commands[HORIZON]);
        self.last = command;
        self.observers[0].go_on(command.x);
        self.observers[1].go_on(command.y);
        if self.stride == 1 {
            // A sample later the first of these is now; the last is looked for where it is.
            planned = std::array::from_fn(|i| planned[(i + 1).min(HORIZON - 1)]);
            self.shift();
        }
        self.predicted = Some(planned);
        command
    }
}

/// Samples of a block: as few as make the horizon long enough.
#[expect(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "a small count")]
fn stride(belief: &Belief) -> isize {
    let quicker = belief.drives[0].time_constant_s.min(belief.drives[1].time_constant_s);
    let samples = quicker * HORIZON_PER_TIME_CONSTANT / belief.period_s;
    ((samples / HORIZON as f64).round() as isize).clamp(1, 100)
}

#[expect(clippy::cast_possible_wrap, reason = "at most the horizon")]
fn count(samples: usize) -> isize {
    samples as isize
}

/// Positions after 1, 2, … blocks of a bit held for the first.
fn response(held: &Held) -> [f64; HORIZON] {
    let (mut position, mut speed) = (held.b0, held.push);
    std::array::from_fn(|_| {
        let now = position;
        position += held.run * speed;
        speed *= held.decay;
        now
    })
}

/// The pieces of the path on which the reference is or will be, or just was.
struct Pieces {
    pieces: [Option<Piece>; MOST_PIECES],
}

impl Pieces {
    fn around(window: &Window, stride: isize) -> Self {
        let mut pieces = [None; MOST_PIECES];
        let (mut found, mut last) = (0, None);
        for i in 0..=2 * HORIZON {
            let sample = window.ahead((count(i) - count(HORIZON)) * stride);
            if last != Some(sample.number) && found < MOST_PIECES {
                pieces[found] = Some(sample.piece);
                (found, last) = (found + 1, Some(sample.number));
            }
        }
        Self { pieces }
    }

    /// The place of the path nearest to `point`, and the unit normal there; past a corner the way to it.
    fn normal_at(&self, point: Axes) -> (Axes, Axes) {
        let distance_2 = |foot: &Foot| (foot.point - point).norm_squared();
        let feet = self.pieces.iter().flatten().map(|piece| piece.nearest(point));
        let Some(foot) =
            feet.reduce(|best, foot| if distance_2(&foot) < distance_2(&best) { foot } else { best })
        else {
            return (point, Axes::zeros());
        };
        let off = point - foot.point;
        let along = off.dot(&foot.tangent).abs();
        let normal =
            if along > 1e-6 && along > 1e-3 * off.norm() { off.normalize() } else { left_of(foot.tangent) };
        (foot.point, normal)
    }
}

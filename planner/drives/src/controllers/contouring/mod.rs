//! Contouring model-predictive control with a disturbance observer.
//!
//! It predicts the positions over a horizon and minimises four costs: their distances from the *path*, their lags
//! *along* the path behind the reference (with a smaller weight), commands that neither path, friction nor load ask
//! for, and the changes of these. What comes after the horizon costs the value of the Riccati equation (`Tail`).
//! Commands stay within the amplifier's limit.
//!
//! The costs are linearised at the point of the path nearest to each predicted position. The first pass uses
//! the plan of the previous sample, the second pass the new plan. Lags are measured along the path. At a
//! sharp corner they draw the tool to the tip and around it, never back. A Kalman observer of each axis
//! estimates position, speed and load.

mod friction;
mod model;
mod places;
mod weights;

use nalgebra::{SMatrix, SVector, Vector3};

use super::box_program::BoxProgram;
use super::observer::Observer;
use super::{Belief, Controller};
use crate::Axes;
use crate::drive::{DriveMotion, HeldLate};
use crate::path::left_of;
use crate::plant::MOST_DELAY;
use crate::reference::ReferenceWindow;
use friction::FrictionAhead;
use model::{Prediction, Response, Tails};
use places::{Pieces, Place};
use weights::Efforts;
pub use weights::Weights;

/// Number of predicted samples.
pub const HORIZON: usize = 15;
/// Number of passes that search for the nearest points and solve the program.
const LOOKS: usize = 2;
/// Number of commands of both axes over the horizon.
const COMMANDS: usize = 2 * HORIZON;

/// The contouring controller with its observers and its current plan.
#[derive(Clone, Debug)]
pub struct Contouring {
    weights: Weights,
    belief: Belief,
    held: [HeldLate; 2],
    responses: [Response; 2],
    /// Costs of commands and of their changes, 1/bits².
    efforts: [Efforts; 2],
    tails: Tails,
    /// Commands that do not act yet because of the delay, oldest first. The first `delay` entries are in use.
    pending: [Axes; MOST_DELAY],
    delay: usize,
    /// The command that acts since the last sample, without the friction.
    acting: Axes,
    friction: FrictionAhead,
    observers: [Observer; 2],
    commands: SVector<f64, COMMANDS>,
    predicted: Option<[Axes; HORIZON]>,
    last: Axes,
    /// The command that the path asks for in the first sample of the plan before.
    asked: Option<Axes>,
    /// First piece that the plan has not passed yet.
    left: Option<usize>,
}

impl Contouring {
    /// The controller for a drive model, with these weights. `None` if there is no optimum.
    #[must_use]
    pub fn new(belief: &Belief, weights: Weights) -> Option<Self> {
        let period_s = belief.period_s;
        let held = belief.drives.map(|drive| drive.held_late(period_s, belief.delay_share));
        let mean = belief.drives.iter().map(|drive| drive.time_constant_s).sum::<f64>() / 2.0;
        let Efforts { command, change } = weights.efforts();
        Some(Self {
            weights,
            belief: *belief,
            held,
            responses: held.map(|held| Response::of(&held)),
            efforts: belief.drives.map(|drive| {
                let reach_2 = drive.held(period_s).b0.powi(2);
                Efforts { command: command * reach_2, change: change * reach_2 }
            }),
            tails: Tails::new(mean, period_s, &weights)?,
            pending: [Axes::zeros(); MOST_DELAY],
            delay: belief.delay_samples.min(MOST_DELAY),
            acting: Axes::zeros(),
            friction: FrictionAhead::at_rest(belief.friction),
            observers: std::array::from_fn(|axis| {
                Observer::new(held[axis], weights.random_steps(belief.drives[axis], period_s))
            }),
            commands: SVector::zeros(),
            predicted: None,
            last: Axes::zeros(),
            asked: None,
            left: None,
        })
    }

    /// Prediction under the pending commands and then commands of zero.
    fn free(&self, window: &ReferenceWindow, known: &[Vector3<f64>; 2]) -> Prediction {
        let mut motions = known.map(|state| DriveMotion { position: state[0], velocity: state[1] });
        let mut before = self.acting;
        let mut ahead = 0;
        let mut go_on = |command: Axes| {
            let load = load_at(window, known, ahead);
            let command = command - self.friction.at(ahead);
            for (axis, (motion, held)) in motions.iter_mut().zip(&self.held).enumerate() {
                *motion = held.after(*motion, [before[axis] - load[axis], command[axis] - load[axis]]);
            }
            before = command;
            ahead += 1;
            motions
        };
        for &command in &self.pending[..self.delay] {
            go_on(command);
        }
        let mut speed = Axes::zeros();
        let positions = std::array::from_fn(|_| {
            let [x, y] = go_on(Axes::zeros());
            speed = Axes::new(x.velocity, y.velocity);
            Axes::new(x.position, y.position)
        });
        Prediction { positions, speed }
    }

    /// Appends `command` to the pending commands, and returns the command that acts in the next period.
    fn next_acting(&mut self, command: Axes) -> Axes {
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
    fn planned(&self, free: &Prediction) -> [Axes; HORIZON] {
        std::array::from_fn(|i| {
            let mut position = free.positions[i];
            for j in 0..=i {
                for axis in 0..2 {
                    position[axis] +=
                        self.responses[axis].positions[i - j] * self.commands[axis * HORIZON + j];
                }
            }
            position
        })
    }

    /// Distance that the reference covers along the path in the sample after the predicted position `i`, pulses.
    fn step_at(&self, window: &ReferenceWindow, i: usize) -> f64 {
        let ahead = self.ahead(i);
        window.ahead(ahead + 1).along - window.ahead(ahead).along
    }

    /// The lag of a predicted position behind the reference, pulses.
    fn lag(&self, window: &ReferenceWindow, place: &Place, i: usize) -> f64 {
        window.ahead(self.ahead(i)).along - place.along - place.tangent.dot(&(place.expected - place.point))
    }

    /// The weight of that lag, relative to that of a small one.
    fn lag_share(&self, window: &ReferenceWindow, place: &Place, i: usize) -> f64 {
        Weights::lag_share(self.lag(window, place, i), self.step_at(window, i))
    }

    /// The motion of a tool that follows the path as the reference does, but is at `place` at the predicted position
    /// `i`: its velocity, and the command until then as a steady velocity, pulses/s.
    fn ideal(&self, window: &ReferenceWindow, place: &Place, i: usize) -> [Axes; 2] {
        let at = |by: isize| window.position(self.ahead(i) + by);
        let twice_s = 2.0 * self.belief.period_s;
        let [before, now] = [(at(0) - at(-2)) / twice_s, (at(1) - at(-1)) / twice_s];
        let command = |axis: usize| {
            let decay = self.held[axis].decay;
            (now[axis] - decay * before[axis]) / (1.0 - decay)
        };
        let from = window.ahead(self.ahead(i)).foot.tangent;
        [now, Axes::new(command(0), command(1))].map(|velocity| turned(velocity, from, place.tangent))
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

    /// The quadratic program: distances from the path and lags along it, both linearised at `places`, commands and
    /// their changes, and what comes after the horizon.
    fn program(
        &self,
        window: &ReferenceWindow,
        free: &Prediction,
        known: &[Vector3<f64>; 2],
        places: &[Place; HORIZON],
    ) -> BoxProgram<COMMANDS> {
        let mut hessian = SMatrix::<f64, COMMANDS, COMMANDS>::zeros();
        let mut linear = SVector::<f64, COMMANDS>::zeros();
        for (i, place) in places.iter().enumerate() {
            let Place { point, normal, tangent, .. } = *place;
            let behind = window.ahead(self.ahead(i)).along - place.along;
            let share = self.weights.lag * self.lag_share(window, place, i);
            let off = free.positions[i] - point;
            let pull = normal * normal.dot(&off) + tangent * (share * (tangent.dot(&off) - behind));
            let weigh = |a: usize, b: usize| normal[a] * normal[b] + share * tangent[a] * tangent[b];
            let weights = [weigh(0, 0), weigh(0, 1), weigh(1, 1)];
            let by_command = self.responses.each_ref().map(|response| response.until(i));
            for (j, (gx, gy)) in by_command[0].iter().zip(by_command[1]).enumerate() {
                linear[j] += gx * pull.x;
                linear[HORIZON + j] += gy * pull.y;
                let columns = hessian.as_mut_slice();
                let (x, rest) = columns[j * COMMANDS..].split_at_mut(HORIZON);
                add(x, by_command[0], weights[0] * gx);
                add(rest, by_command[1], weights[1] * gx);
                add(&mut columns[(HORIZON + j) * COMMANDS + HORIZON..], by_command[1], weights[2] * gy);
            }
        }
        for j in 0..HORIZON {
            for k in 0..HORIZON {
                hessian[(j, HORIZON + k)] = hessian[(HORIZON + k, j)];
            }
        }
        self.weigh_tail(window, free, known, &places[HORIZON - 1], &mut hessian, &mut linear);
        self.weigh_commands(window, known, places, &mut hessian, &mut linear);
        BoxProgram { hessian, linear, limit: self.belief.limit }
    }

    /// Adds the cost of what comes after the horizon.
    fn weigh_tail(
        &self,
        window: &ReferenceWindow,
        free: &Prediction,
        known: &[Vector3<f64>; 2],
        place: &Place,
        hessian: &mut SMatrix<f64, COMMANDS, COMMANDS>,
        linear: &mut SVector<f64, COMMANDS>,
    ) {
        let end = HORIZON - 1;
        let [velocity, command] = self.ideal(window, place, end);
        let gains = self.belief.drives.map(|drive| drive.gain);
        let load = load_at(window, known, self.ahead(end)) + self.friction.at(self.ahead(end));
        let load = Axes::new(gains[0] * load.x, gains[1] * load.y);
        let off = free.positions[end] - place.point;
        let behind = window.ahead(self.ahead(end)).along - place.along;
        let along = self.tails.along(self.lag_share(window, place, end));
        let directions = [(left_of(place.tangent), 0.0, &self.tails.across), (place.tangent, behind, along)];
        for (direction, target, tail) in directions {
            let state = Vector3::new(
                direction.dot(&off) - target,
                direction.dot(&(free.speed - velocity)),
                -direction.dot(&(command + load)),
            );
            let by_command = SMatrix::<f64, 3, COMMANDS>::from_fn(|row, column| {
                let (axis, j) = (column / HORIZON, column % HORIZON);
                let response = &self.responses[axis];
                direction[axis]
                    * match row {
                        0 => response.positions[end - j],
                        1 => response.speeds[end - j],
                        _ if j == end => gains[axis],
                        _ => 0.0,
                    }
            });
            let weighed = by_command.transpose() * tail.value;
            *hessian += weighed * by_command;
            *linear += weighed * state;
        }
    }

    /// The command that the path asks for until the predicted position `i`, bits.
    fn asked(&self, window: &ReferenceWindow, place: &Place, i: usize) -> Axes {
        let [_, command] = self.ideal(window, place, i);
        let [x, y] = self.belief.drives;
        let bits = Axes::new(command.x / x.gain, command.y / y.gain);
        // In its direction, as far as the amplifier goes.
        self.belief.limit.map_or(bits, |limit| bits * (limit / bits.amax()).min(1.0))
    }

    /// The command against friction and load some samples ahead, bits.
    fn against(&self, window: &ReferenceWindow, known: &[Vector3<f64>; 2], ahead: isize) -> Axes {
        self.friction.at(ahead) + load_at(window, known, ahead)
    }

    /// Adds the costs of commands that neither path, friction nor load ask for, and of their changes.
    fn weigh_commands(
        &self,
        window: &ReferenceWindow,
        known: &[Vector3<f64>; 2],
        places: &[Place; HORIZON],
        hessian: &mut SMatrix<f64, COMMANDS, COMMANDS>,
        linear: &mut SVector<f64, COMMANDS>,
    ) {
        // A command acts one sample before the position that it causes.
        let acts = |number: usize| self.ahead(number) - 1;
        let mut asked_before = self.asked.unwrap_or_default();
        let mut against_before = self.against(window, known, acts(0) - 1);
        for (number, place) in places.iter().enumerate() {
            let asked = self.asked(window, place, number);
            let against = self.against(window, known, acts(number));
            let share = (self.step_at(window, number) / self.lag(window, place, number).abs()).min(1.0);
            let wanted = (asked - asked_before) * share + against - against_before;
            for axis in 0..2 {
                let (Efforts { command, change }, j) = (self.efforts[axis], axis * HORIZON + number);
                hessian[(j, j)] += command + change;
                linear[j] -= command * (asked + against)[axis] + change * wanted[axis];
                if number == 0 {
                    linear[j] -= change * self.last[axis];
                } else {
                    hessian[(j - 1, j - 1)] += change;
                    hessian[(j, j - 1)] -= change;
                    hessian[(j - 1, j)] -= change;
                    linear[j - 1] += change * wanted[axis];
                }
            }
            (asked_before, against_before) = (asked, against);
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
        self.friction.go_on(window, self.belief.period_s);
        let known = [self.observers[0].see(measured.x), self.observers[1].see(measured.y)];
        let free = self.free(window, &known);
        let pieces = Pieces::around(window);
        let mut planned = self.predicted.unwrap_or(std::array::from_fn(|i| window.position(self.ahead(i))));
        let mut first = None;
        for _ in 0..LOOKS {
            let places = self.places(window, &pieces, &planned);
            if let Some(commands) = self.program(window, &free, &known, &places).solved(&self.commands) {
                self.commands = commands;
            }
            planned = self.planned(&free);
            first = Some(places[0]);
        }
        self.asked = first.map(|place| self.asked(window, &place, 0));
        let command = Axes::new(self.commands[0], self.commands[HORIZON]);
        self.last = command;
        self.acting = self.next_acting(command) - self.friction.at(0);
        self.observers[0].go_on(self.acting.x);
        self.observers[1].go_on(self.acting.y);
        let load = load_at(window, &known, 1);
        self.observers[0].load_is(load.x);
        self.observers[1].load_is(load.y);
        // In the next sample the plan starts one position later. Its last position is used twice.
        self.predicted = Some(std::array::from_fn(|i| planned[(i + 1).min(HORIZON - 1)]));
        self.shift();
        command
    }
}

/// The load some samples ahead, bits. A cutting force turns with the path (eqs. (2) to (4)), and so does the estimate.
fn load_at(window: &ReferenceWindow, known: &[Vector3<f64>; 2], ahead: isize) -> Axes {
    let [from, to] = [0, ahead].map(|ahead| window.ahead(ahead).foot.tangent);
    turned(Axes::new(known[0][2], known[1][2]), from, to)
}

/// Adds `by` times `factor`.
fn add(to: &mut [f64], by: &[f64], factor: f64) {
    for (to, by) in to.iter_mut().zip(by) {
        *to += by * factor;
    }
}

/// `vector`, turned as the path turns between these two tangents.
fn turned(vector: Axes, from: Axes, to: Axes) -> Axes {
    to * vector.dot(&from) + left_of(to) * vector.dot(&left_of(from))
}

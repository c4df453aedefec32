//! The guard's inductive invariant: *in every reachable state, every point where the tool can be lies in a
//! certified set, whatever is delayed, lost, repeated or cancelled*.
//!
//! The exploration runs the real guard with the model of the controller, breadth first. It visits every
//! state once, until it finds no new one. In each state it checks:
//!
//! - The hull of the in-flight set keeps the jogging clearance from everything that stands above its lowest
//!   height, less the height margin.
//! - Every target in the controller or in transit lies in the hull, and not below the lowest height.
//! - The tool lies in the hull, and not below the lowest height. Where reports have errors, it lies within three
//!   resolutions of the hull, and within one of that height.
//! - Every motion of the tool keeps the same clearance from what stands above it, without the margin.
//!
//! The hull is convex, so a tool in it that drives to targets in it stays in it. In a world without faults
//! the session must not end.
//!
//! The host sends whatever the guard allows, at any time. It has all the freedom of the supervisor, and
//! more.

mod checks;
mod states;

use std::collections::VecDeque;
use std::fmt::Debug;
use std::sync::Arc;

use keepout_guard::{
    Certification, ContourMotion, DRAIN, Guard, HeightRules, Interpolation, OnCancel, PositionFeedback,
    QueryStamp, Rules, State as GuardState, Time,
};
use keepout_kernel::{Curve, Levels, Segment};

use crate::controller::{MachineModel, MotionModel, RESOLUTION, Trouble};
use crate::families::length;
use crate::invariant::states::{Insertion, StateSet};
use crate::model::ControllerModel;
use crate::properties::Xyz;
use crate::square::{self, FINISHING, HEIGHT_MARGIN, MANUAL, height, place, plain_place};
use crate::wire::{HostMessage, Sent, StatusReport};

/// A world to explore: a machine, its faults, and the host's budget.
#[derive(Clone, Debug)]
pub struct World {
    /// Its name.
    pub name: &'static str,
    /// Start position of the tool.
    pub start: Xyz,
    /// Targets of the host's jogs.
    pub targets: &'static [Xyz],
    /// Heights of the host's rises.
    pub rises: &'static [i64],
    /// A contour that the host may run. Without points there is none.
    pub contour: &'static [Xyz],
    /// Largest numbers of motions, queries, cancels and halves of `DRAIN`.
    pub budget: [u8; 4],
    /// Largest number of open queries.
    pub open: usize,
    /// The faults.
    pub trouble: Trouble,
    /// The behaviour of the machine.
    pub drive: MotionModel,
    /// A checksum protects the line.
    pub checked: bool,
    /// Enlargement of the simplified outline that jogging asks, lattice units.
    pub simplified_by: i64,
}

/// A state: the guard, the controller model, and the host's variables.
#[derive(Clone, Debug)]
struct Node<M> {
    guard: Guard,
    plant: M,
    queries: VecDeque<QueryStamp>,
    now: u8,
    budget: [u8; 4],
    /// The session has ended. The host sends no more messages.
    ended: bool,
    /// The tool began inside the jogging clearance and has not left it yet.
    inside: bool,
}

#[derive(Hash)]
struct Key<'a, M>(GuardState, &'a M, &'a VecDeque<QueryStamp>, u8, [u8; 4], [bool; 2]);

/// An action of the host, or an event.
#[derive(Clone, Copy, Debug)]
enum Step<E> {
    Jog(Xyz),
    Rise(i64),
    Retract(Xyz),
    Contour,
    Next,
    Query,
    Cancel,
    Receives,
    Passes,
    Jumps,
    Happens(E),
}

/// The outcome of an exploration.
#[derive(Clone, Debug)]
pub struct Explored {
    /// States found.
    pub states: usize,
    /// Steps tried.
    pub steps: usize,
    /// Steps from the beginning to the farthest state.
    pub depth: usize,
    /// The exploration reached every state.
    pub complete: bool,
    /// The shortest sequence of steps to a state that violates the invariant.
    pub violation: Option<Vec<String>>,
}

impl World {
    /// The part of this world. A machine that climbs has a plate with a top.
    fn levels(&self, by: i64) -> Levels {
        if self.drive.climbs { square::plate(by) } else { square::square(by) }
    }

    fn heights(&self) -> HeightRules {
        if !self.drive.climbs {
            return HeightRules::TWO_AXES;
        }
        HeightRules {
            lowest: height(-1000),
            highest: height(1000),
            margin: length(HEIGHT_MARGIN),
            resolution: length(RESOLUTION),
            shortest: length(4),
        }
    }

    fn guard(&self, part: &Arc<Levels>) -> Guard {
        let interpolation = if self.drive.apart { Interpolation::Independent } else { Interpolation::Linear };
        let rules = Rules {
            on_cancel: if self.drive.strays { OnCancel::MayStray } else { OnCancel::KeepsPath },
            heights: self.heights(),
            ..square::rules(interpolation, self.checked)
        };
        let mut guard = Guard::new(Arc::clone(part), Arc::new(self.levels(self.simplified_by)), rules);
        guard.learn_of_cancels(guard.rules().on_cancel, Some(QUICK));
        guard.locate(place(self.start)).expect("the tool begins outside the part");
        guard
    }

    /// Explores all reachable states, up to `most` of them.
    #[must_use]
    pub fn explore(&self, most: usize) -> Explored {
        self.explore_with::<MachineModel>(most)
    }

    /// The same with a model of the controller.
    #[must_use]
    pub fn explore_with<M: ControllerModel>(&self, most: usize) -> Explored {
        let part = Arc::new(self.levels(0));
        let guard = self.guard(&part);
        let first = Node {
            inside: guard.is_inside_jogging_clearance(),
            guard,
            plant: M::at_rest(self.start, self.drive, self.trouble),
            queries: VecDeque::new(),
            now: 0,
            budget: self.budget,
            ended: false,
        };
        let mut known = StateSet::default();
        known.insert(&first.key(), most);
        let mut ways: Vec<(usize, Option<Step<M::Event>>)> = vec![(0, None)];
        let mut front = VecDeque::from([(0, 0, first)]);
        let mut explored = Explored { states: 1, steps: 0, depth: 0, complete: true, violation: None };
        let mut steps = Vec::new();
        while let Some((number, depth, node)) = front.pop_front() {
            explored.depth = depth;
            steps.clear();
            node.steps(self, &mut steps);
            for &step in &steps {
                let mut next = node.clone();
                let Some(way) = next.takes(self, step) else { continue };
                explored.steps += 1;
                let insertion = known.insert(&next.key(), most);
                let fault = next.fault_of_path(self, &part, &way);
                // The rest depends on the state alone.
                let fault = fault
                    .or_else(|| if insertion == Insertion::Before { None } else { next.fault(self, &part) });
                if let Some(fault) = fault {
                    let mut sequence = steps_to(&ways, number);
                    sequence.extend([format!("{step:?}"), fault]);
                    return Explored {
                        states: known.len(),
                        violation: Some(sequence),
                        complete: false,
                        ..explored
                    };
                }
                match insertion {
                    Insertion::Before => {}
                    Insertion::New => {
                        ways.push((number, Some(step)));
                        front.push_back((ways.len() - 1, depth + 1, next));
                    }
                    Insertion::BeyondLimit => explored.complete = false,
                }
            }
        }
        Explored { states: known.len(), ..explored }
    }
}

/// The steps to a state.
fn steps_to<E: Copy + Debug>(ways: &[(usize, Option<Step<E>>)], mut number: usize) -> Vec<String> {
    let mut sequence = Vec::new();
    while let (before, Some(step)) = ways[number] {
        sequence.push(format!("{step:?}"));
        number = before;
    }
    sequence.reverse();
    sequence
}

impl<M: ControllerModel> Node<M> {
    fn key(&self) -> Key<'_, M> {
        let Self { plant, queries, now, budget, ended, inside, .. } = self;
        Key(self.guard.state(), plant, queries, *now, *budget, [*ended, *inside])
    }

    fn time(&self) -> Time {
        Time::ZERO.after(DRAIN / 2 * self.now.into())
    }

    /// Appends all possible actions and events.
    fn steps(&self, world: &World, into: &mut Vec<Step<M::Event>>) {
        let [motions, queries, cancels, passes] = self.budget;
        if !self.ended {
            if motions > 0 {
                let inside = self.guard.is_inside_jogging_clearance();
                into.extend(
                    world.targets.iter().map(|&to| if inside { Step::Retract(to) } else { Step::Jog(to) }),
                );
                into.extend(world.rises.iter().map(|&height| Step::Rise(height)));
                if !world.contour.is_empty() && self.guard.contour_progress().is_none() {
                    into.push(Step::Contour);
                }
            }
            if self.guard.contour_progress().is_some() {
                into.push(Step::Next);
            }
            into.extend((queries > 0 && self.queries.len() < world.open).then_some(Step::Query));
            into.extend((cancels > 0).then_some(Step::Cancel));
            into.extend(self.plant.has_answer().then_some(Step::Receives));
            into.extend((passes > 0).then_some(Step::Passes));
            into.extend(self.plant.may_jump().then_some(Step::Jumps));
        }
        let mut happenings = Vec::new();
        self.plant.events(&mut happenings);
        into.extend(happenings.into_iter().map(Step::Happens));
    }

    /// Takes the step and returns the path of the tool. Returns `None` if the step is not possible.
    fn takes(&mut self, world: &World, step: Step<M::Event>) -> Option<Vec<Xyz>> {
        let here = vec![self.plant.tool()];
        match step {
            Step::Jog(to) => {
                self.guard.jog(place(to), world.feed()).ok()?;
                self.send(to);
            }
            Step::Rise(to) => {
                let certified = self.guard.rise(height(to), world.feed()).ok()?;
                self.send(plain_place(certified.target()));
            }
            Step::Retract(to) => {
                self.guard.retract(place(to), world.feed()).ok()?;
                self.send(to);
            }
            Step::Contour => {
                self.budget[0] -= 1;
                let motion = |pair: &[Xyz]| {
                    let [from, to] = [place(pair[0]), place(pair[1])];
                    ContourMotion {
                        curve: Curve::Line(Segment { from: from.point, to: to.point }),
                        heights: [from.height, to.height],
                        feed_mm_min: 300,
                    }
                };
                self.guard.begin_contour(world.contour.windows(2).map(motion).collect()).ok()?;
                let certified = self.guard.certify_contour(usize::MAX).ok()?;
                assert_eq!(certified, Certification::Done);
            }
            Step::Next => {
                let to = self.guard.next_of_contour()?.target();
                self.plant.send(Sent::Line(plain_place(to)));
            }
            Step::Query => {
                self.budget[1] -= 1;
                self.queries.push_back(self.guard.stamp(self.time()));
                self.plant.send(Sent::Query);
            }
            Step::Cancel => {
                self.budget[2] -= 1;
                if self.guard.contour_progress().is_none() {
                    self.guard.cancel().ok()?;
                }
                self.plant.send(Sent::Cancel);
            }
            Step::Receives => while self.receives() {},
            Step::Passes => {
                self.budget[3] -= 1;
                self.now += 1;
                if !self.plant.pass_half() {
                    return None;
                }
            }
            Step::Jumps => {
                self.plant.jump();
                self.now += 2;
            }
            Step::Happens(happening) => return Some(self.plant.apply(happening)),
        }
        Some(here)
    }

    fn send(&mut self, to: Xyz) {
        self.budget[0] -= 1;
        self.plant.send(Sent::Line(to));
    }

    /// Gives the next answer to the guard. Returns whether a copy of it follows at once.
    fn receives(&mut self) -> bool {
        match self.plant.next_answer() {
            None => false,
            Some(HostMessage::Accepted) => {
                self.ended |= self.guard.acknowledged().is_err();
                let guard = &self.guard;
                self.queries.retain(|stamp| !guard.is_outdated(stamp));
                false
            }
            Some(HostMessage::Refused) => {
                self.ended |= !self.guard.refused();
                false
            }
            Some(HostMessage::Report(report)) => {
                let StatusReport { place, in_position, queued, waiting, doubled } = report;
                if let Some(stamp) = self.queries.pop_front() {
                    let feedback = PositionFeedback {
                        position: square::place(place),
                        in_position,
                        queued: Some(queued),
                        waiting,
                    };
                    self.ended |= self.guard.reported(&feedback, stamp, self.time()).is_err();
                    self.inside &= !self.guard.in_position() || self.guard.is_inside_jogging_clearance();
                }
                doubled
            }
        }
    }
}

/// Deceleration that stops the tool almost at once, lattice units per s².
const QUICK: u64 = 1_000_000_000;

impl World {
    /// Feed of jogs, mm/min. If a cancel may leave the path, the feed is so low that the stopping distance
    /// is small beside the part.
    fn feed(&self) -> u32 {
        if self.drive.strays { 1 } else { 600 }
    }

    /// Largest distance of the tool from the set. A report errs by one resolution, and the guard accepts it
    /// up to two resolutions from the hull.
    fn off(&self) -> i64 {
        if self.drive.errs { 3 * RESOLUTION } else { 0 }
    }

    /// Smallest distance between tool and part. One unit covers the rounding of the set's points to whole
    /// units.
    fn kept(&self) -> i64 {
        let threshold = if self.contour.is_empty() { MANUAL } else { FINISHING - RESOLUTION };
        threshold - self.off() - 1
    }
}

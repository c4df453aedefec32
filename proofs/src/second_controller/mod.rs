//! A second model of the controller, the link and the tool, by another author, from the documentation of GRBL 1.1
//! and `docs/safety/`.
//!
//! ```text
//! link ──> receive buffer ──> line being parsed ──> planner ──> prepared blocks ──> tool
//! ```
//!
//! What it allows, besides delays of everything:
//!
//! - A full receive buffer drops bytes: the head of one line joins the tail of the next one.
//! - A query that arrives before the report to an earlier one gets no report of its own.
//! - A motion without a length is accepted and makes no block.
//! - The controller may call itself idle with blocks in the planner: programmed motions wait for a start, and a
//!   jog that is planned as the motion ends waits, too.
//! - The controller may ignore a cancel, as it does when such a jog runs as a programmed motion.

mod effects;
mod events;

use std::collections::VecDeque;

use crate::controller::{MotionModel, RESOLUTION, STRAY, Trouble};
use crate::model::ControllerModel;
use crate::properties::Xyz;
use crate::wire::{HostMessage, Sent, StatusReport};

/// Blocks of the planner.
const PLANNER: usize = 2;
/// Lines of the receive buffer.
const RECEIVE: usize = 2;
/// Blocks in the segment buffer.
const PREPARED: usize = 2;
/// Earlier reports that can return.
const REMEMBERED: usize = 2;

/// The state of the step generator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum StepState {
    Idle,
    Moves,
    /// Brakes because of a cancel. Then the planned jogs are discarded.
    Cancels,
    /// Brakes because of a hold.
    Brakes,
    /// Held at rest.
    Held,
}

/// A block of the planner, or one that has left it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct QueuedBlock {
    to: Xyz,
    /// Halves of `DRAIN` since it left.
    halves: u8,
    /// Places between its ends where the tool was.
    places: u8,
}

/// An event of the second model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SecondEvent {
    /// The first message on the link arrives.
    Arrives,
    /// It arrives, and a copy of it stays on the link.
    ArrivesTwice,
    /// It is lost.
    Lost,
    /// It changes places with the next one.
    Swaps,
    /// A cancel arrives, and has no effect.
    CancelIgnored,
    /// The program reads a line.
    Reads,
    /// The program rejects the line that it parses.
    Rejects,
    /// The line that it parses becomes a block.
    Plans,
    /// A cancel discarded the line that it parses.
    Discards,
    /// The planned motions start.
    Starts,
    /// A block leaves the planner.
    Leaves,
    /// The tool drives to a place before the end of its block: all axes, or one.
    DrivesHalf(Option<u8>),
    /// The tool drives to the end of its block: all axes, or one.
    DrivesOn(Option<u8>),
    /// The controller notices the end of the motion.
    Rests,
    /// The braking tool comes to rest, with this deviation.
    Stops(i64, i64, i64),
    /// A report leaves, with this error.
    Reports(i64, i64, i64),
    /// An earlier report leaves in its place.
    Repeats(usize),
    /// The first message to the host is lost.
    AnswerLost,
    /// It arrives twice.
    AnswerTwice,
    /// It changes places with the next one.
    AnswersSwap,
    /// A reset that nobody hears of.
    Resets,
    /// Somebody holds the machine.
    Holds,
    /// Somebody resumes.
    Resumes,
}

/// The second model of the controller, the link and the tool.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SecondController {
    drive: MotionModel,
    tool: Xyz,
    link: VecDeque<Sent>,
    answers: VecDeque<HostMessage>,
    trouble: Trouble,
    received: VecDeque<Xyz>,
    /// The head of a line whose other bytes found no room.
    torn: Option<Xyz>,
    parsed: Option<Xyz>,
    planned: VecDeque<QueuedBlock>,
    prepared: VecDeque<QueuedBlock>,
    state: StepState,
    /// A query waits for its report.
    asked: bool,
    earlier: VecDeque<StatusReport>,
    /// The line that is being parsed found the planner full.
    waited: bool,
    /// A cancel discarded the received lines, and can discard the line that is being parsed.
    flushed: bool,
}

/// Deviations of up to `reach` along each axis.
fn deviations(reach: i64, climbs: bool) -> impl Iterator<Item = (i64, i64, i64)> {
    let plane = [(0, 0, 0), (reach, 0, 0), (-reach, 0, 0), (0, reach, 0), (0, -reach, 0)];
    let height = [(0, 0, reach), (0, 0, -reach)];
    plane.into_iter().chain(height.into_iter().filter(move |_| climbs))
}

fn off((x, y, z): Xyz, (dx, dy, dz): (i64, i64, i64)) -> Xyz {
    (x + dx, y + dy, z + dz)
}

/// The place that takes one coordinate, or all, from `to`.
fn along(from: Xyz, to: Xyz, axis: Option<u8>) -> Xyz {
    match axis {
        None => to,
        Some(0) => (to.0, from.1, from.2),
        Some(1) => (from.0, to.1, from.2),
        Some(_) => (from.0, from.1, to.2),
    }
}

fn middle(a: Xyz, b: Xyz) -> Xyz {
    ((a.0 + b.0).div_euclid(2), (a.1 + b.1).div_euclid(2), (a.2 + b.2).div_euclid(2))
}

impl SecondController {
    /// Where the queue ends.
    fn end(&self) -> Xyz {
        self.planned.back().or(self.prepared.back()).map_or(self.tool, |block| block.to)
    }

    fn reads_lines(&self) -> bool {
        matches!(self.state, StepState::Idle | StepState::Moves)
    }

    fn report(&self, error: (i64, i64, i64)) -> StatusReport {
        StatusReport {
            place: off(self.tool, error),
            in_position: self.state == StepState::Idle,
            queued: self.planned.len(),
            waiting: !self.received.is_empty() || self.torn.is_some(),
            doubled: false,
        }
    }
}

impl ControllerModel for SecondController {
    type Event = SecondEvent;

    fn at_rest(tool: Xyz, drive: MotionModel, trouble: Trouble) -> Self {
        Self {
            drive,
            tool,
            link: VecDeque::new(),
            answers: VecDeque::new(),
            trouble,
            received: VecDeque::new(),
            torn: None,
            parsed: None,
            planned: VecDeque::new(),
            prepared: VecDeque::new(),
            state: StepState::Idle,
            asked: false,
            earlier: VecDeque::new(),
            flushed: false,
            waited: false,
        }
    }

    fn tool(&self) -> Xyz {
        self.tool
    }

    fn may_jump(&self) -> bool {
        self.trouble.jumps > 0
    }

    fn jump(&mut self) {
        self.trouble.jumps -= 1;
    }

    fn send(&mut self, message: Sent) {
        self.link.push_back(message);
    }

    fn has_answer(&self) -> bool {
        !self.answers.is_empty()
    }

    fn next_answer(&mut self) -> Option<HostMessage> {
        self.answers.pop_front()
    }

    fn all_targets(&self) -> Vec<Xyz> {
        let on_link = self.link.iter().filter_map(|sent| match sent {
            Sent::Line(to) => Some(*to),
            Sent::Query | Sent::Cancel => None,
        });
        let inside = self.received.iter().chain(&self.torn).chain(&self.parsed).copied();
        let blocks = self.planned.iter().chain(&self.prepared).map(|block| block.to);
        on_link.chain(inside).chain(blocks).collect()
    }

    fn events(&self, into: &mut Vec<SecondEvent>) {
        self.events_of_link(into);
        self.events_of_program(into);
        self.events_of_motion(into);
    }

    fn apply(&mut self, event: SecondEvent) -> Vec<Xyz> {
        match event {
            SecondEvent::Reads => {
                self.parsed = self.received.pop_front();
                self.waited = self.planned.len() >= PLANNER || !self.received.is_empty();
            }
            SecondEvent::Rejects => {
                self.trouble.refused -= 1;
                (self.parsed, self.flushed, self.waited) = (None, false, false);
                self.answers.push_back(HostMessage::Refused);
            }
            SecondEvent::Plans => self.plans(),
            SecondEvent::Discards => (self.parsed, self.flushed, self.waited) = (None, false, false),
            SecondEvent::Starts => self.state = StepState::Moves,
            SecondEvent::Leaves => {
                self.prepared.extend(self.planned.pop_front());
            }
            SecondEvent::DrivesHalf(axis) => {
                let place = self.next_place(axis, true).unwrap_or(self.tool);
                if let Some(block) = self.prepared.front_mut().or(self.planned.front_mut()) {
                    block.places += 1;
                }
                return self.drives(place);
            }
            SecondEvent::DrivesOn(axis) => {
                let place = self.next_place(axis, false).unwrap_or(self.tool);
                return self.drives(place);
            }
            SecondEvent::Rests => self.state = StepState::Idle,
            SecondEvent::Stops(dx, dy, dz) => return self.stops((dx, dy, dz)),
            SecondEvent::Reports(dx, dy, dz) => self.says_report(self.report((dx, dy, dz))),
            SecondEvent::Repeats(index) => {
                self.trouble.lies -= 1;
                if let Some(&report) = self.earlier.get(index) {
                    self.says_report(report);
                }
            }
            SecondEvent::Resets => {
                let trouble = Trouble { resets: self.trouble.resets - 1, ..self.trouble };
                let (link, answers) = (std::mem::take(&mut self.link), std::mem::take(&mut self.answers));
                *self = Self { link, answers, ..Self::at_rest(self.tool, self.drive, trouble) };
            }
            SecondEvent::Holds => {
                self.trouble.holds -= 1;
                self.state = if self.state == StepState::Moves { StepState::Brakes } else { StepState::Held };
            }
            SecondEvent::Resumes => {
                let blocks = self.planned.len() + self.prepared.len();
                self.state = if blocks > 0 { StepState::Moves } else { StepState::Idle };
            }
            of_link => self.apply_to_link(of_link),
        }
        vec![self.tool]
    }

    fn pass_half(&mut self) -> bool {
        // A line is parsed sooner, unless it waits for room.
        let parses = self.parsed.is_some() && !self.waited;
        if parses || matches!(self.state, StepState::Cancels | StepState::Brakes) {
            return false;
        }
        if self.state == StepState::Moves {
            if self.prepared.iter().any(|block| block.halves > 0) {
                return false;
            }
            self.prepared.iter_mut().for_each(|block| block.halves += 1);
        }
        true
    }
}

//! A model of a controller and of the link to it, over a tiny lattice. It is small enough to explore all
//! its states.
//!
//! The model holds messages in transit, a receive buffer, one line that was read and waits for room in the
//! planner, the planner's blocks, and blocks that have left the planner and are being executed.
//! [`MachineModel::moves`] lists the possible next events. They occur in any order and with any delay, with
//! one bound: the machine executes a block within `DRAIN` after it has left the planner.
//!
//! A cancel stops the tool anywhere between its position and its target, and discards planned blocks. It
//! does not discard a line that waits in the receive buffer or for room. Such a line runs from the place
//! where the tool stopped (GRBL issues 95, 423, 837).
//!
//! [`Trouble`] lists the faults of the link. The assumptions are those of docs/safety/assumptions.md:
//! answers arrive in the order of sending and are not invented. No line both repeats and loses messages, or
//! swaps twice. From time to time a report may be an old one. A report gives the tool's position to within
//! [`RESOLUTION`].

use std::collections::VecDeque;

use crate::properties::Xyz;
use crate::wire::{HostMessage, Sent, StatusReport};

/// Lines that the receive buffer holds. The next line is merged with the last one. GRBL's 127 bytes hold
/// two lines of 63 bytes.
pub const BUFFER: usize = 2;
/// Blocks that the planner holds.
const PLANNER: usize = 2;
/// Largest number of blocks that have left the planner and are not yet executed.
const STEPPER: usize = 2;

/// Largest distance between a report and the tool, lattice units.
pub const RESOLUTION: i64 = 4;
/// Largest distance that the tool moves after a cancel if it may leave its path, lattice units: 150 ms at 1
/// mm/min, with no time to brake. Each of two non-interpolated axes moves so far.
pub const STRAY: i64 = 250;
/// Rest positions after such a cancel, relative to the tool's position at the cancel. Those along two axes need
/// non-interpolated axes, and the last one needs a third axis.
const STRAYS: [Xyz; 10] = [
    (0, 0, 0),
    (STRAY, 0, 0),
    (-STRAY, 0, 0),
    (0, STRAY, 0),
    (0, -STRAY, 0),
    (STRAY, STRAY, 0),
    (STRAY, -STRAY, 0),
    (-STRAY, STRAY, 0),
    (-STRAY, -STRAY, 0),
    (0, 0, -STRAY),
];

/// Errors of a report, relative to the tool's position.
const ERRORS: [Xyz; 7] = [
    (0, 0, 0),
    (RESOLUTION, 0, 0),
    (-RESOLUTION, 0, 0),
    (0, RESOLUTION, 0),
    (0, -RESOLUTION, 0),
    (0, 0, RESOLUTION),
    (0, 0, -RESOLUTION),
];

/// How often each fault may occur in one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Trouble {
    /// Messages lost, in either direction.
    pub lost: u8,
    /// Messages that arrive twice, in either direction.
    pub doubled: u8,
    /// Messages that change places with the one before, in either direction.
    pub swapped: u8,
    /// Reports replaced by an earlier one.
    pub lies: u8,
    /// Lines that the controller rejects instead of planning them.
    pub refused: u8,
    /// Resets without a message: the controller discards all lines and blocks, and the tool stops.
    pub resets: u8,
    /// Feed holds by somebody else, who later commands cycle start.
    pub holds: u8,
    /// Jumps of the clock by `DRAIN`.
    pub jumps: u8,
}

/// How the machine moves, and how it handles a cancel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MotionModel {
    /// Non-interpolated axes: each axis moves by itself, in any order.
    pub apart: bool,
    /// A cancel also discards received lines (grblHAL).
    pub flushes: bool,
    /// A cancel stops the motion. True for jogs, false for contours.
    pub cancels: bool,
    /// A cancelled motion may leave its path before the tool is at rest, by at most [`STRAY`]. Non-interpolated axes
    /// leave it by that much each.
    pub strays: bool,
    /// Reports may be off by [`RESOLUTION`].
    pub errs: bool,
    /// Largest number of positions between two ends of motions where the tool can be found.
    pub halves: u8,
    /// A third axis: errors and strays go up and down, too.
    pub climbs: bool,
}

/// The controller, the link and the tool.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct MachineModel {
    /// The machine's behaviour.
    pub drive: MotionModel,
    /// Position of the tool.
    pub tool: Xyz,
    /// Number of positions between ends of motions since the last end.
    between: u8,
    /// Messages in transit to the controller.
    pub wire: VecDeque<Sent>,
    /// Received lines that the controller has not read.
    pub received: VecDeque<Xyz>,
    /// The line that was read and waits for room.
    pub read: Option<Xyz>,
    /// Planned blocks.
    pub planner: VecDeque<Xyz>,
    /// Blocks that have left the planner, each with its age in halves of `DRAIN`.
    pub stepper: VecDeque<(Xyz, u8)>,
    /// A feed hold: the machine neither moves nor reads lines.
    held: bool,
    /// The tool brakes after a cancel and may leave its path.
    straying: bool,
    /// Messages in transit to the host.
    pub answers: VecDeque<HostMessage>,
    /// Past reports. A false reply may repeat one.
    reported: Vec<StatusReport>,
    /// The faults that may still occur.
    pub trouble: Trouble,
}

/// An event in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Happening {
    /// The oldest message to the controller arrives. A report that it causes has this error.
    Arrives {
        /// Index of the error.
        error: u8,
    },
    /// The oldest message to the controller is lost.
    LostThere,
    /// The oldest message to the controller arrives twice.
    DoubledThere,
    /// The second-oldest message to the controller arrives first.
    SwappedThere,
    /// The next answer is lost.
    LostBack,
    /// The next answer arrives twice.
    DoubledBack,
    /// The next two answers change places.
    SwappedBack,
    /// An earlier report replaces the next answer.
    Lie {
        /// Index of the earlier report.
        report: u8,
    },
    /// The controller reads a line.
    Reads,
    /// The controller reads a line and rejects it.
    Refuses,
    /// A block leaves the planner.
    Fetches,
    /// The tool moves to the end of its motion. Non-interpolated axes move one after the other.
    Drives {
        /// The route: 0 straight, 1 x first, 2 y first, 3 z first, and then x.
        around: u8,
    },
    /// The tool moves to the middle of its motion, or to a corner of the motion's box.
    DrivesHalf {
        /// The route, as above.
        around: u8,
    },
    /// The tool comes to rest beside its path after a cancel.
    Strays {
        /// Index of the rest position.
        to: u8,
    },
    /// The controller resets without a message.
    Reset,
    /// Somebody else commands a feed hold.
    Holds,
    /// Somebody else commands cycle start.
    GoesOn,
}

impl MachineModel {
    /// A machine at rest.
    #[must_use]
    pub fn new(tool: Xyz, drive: MotionModel, trouble: Trouble) -> Self {
        Self {
            drive,
            tool,
            between: 0,
            wire: VecDeque::new(),
            received: VecDeque::new(),
            read: None,
            planner: VecDeque::new(),
            stepper: VecDeque::new(),
            held: false,
            straying: false,
            answers: VecDeque::new(),
            reported: Vec::new(),
            trouble,
        }
    }

    /// Whether the machine moves or has planned motions.
    fn in_motion(&self) -> bool {
        !self.planner.is_empty() || !self.stepper.is_empty() || self.straying
    }

    /// All targets in the controller and in transit to it.
    pub fn targets(&self) -> impl Iterator<Item = Xyz> + '_ {
        let on_wire = self.wire.iter().filter_map(|sent| match sent {
            Sent::Line(to) => Some(*to),
            _ => None,
        });
        let held = self.received.iter().chain(&self.read).chain(&self.planner).copied();
        on_wire.chain(held).chain(self.stepper.iter().map(|&(to, _)| to))
    }

    /// Appends the possible next events, without the host's actions and the passing of time.
    pub fn moves(&self, into: &mut Vec<Happening>) {
        let Trouble { lost, doubled, swapped, resets, holds, .. } = self.trouble;
        let mut may = |allowed: bool, happening| {
            if allowed {
                into.push(happening);
            }
        };
        let there = !self.wire.is_empty();
        let all = if self.drive.climbs { 7 } else { 5 };
        let errors = if self.drive.errs && self.wire.front() == Some(&Sent::Query) { all } else { 1 };
        (0..errors).for_each(|error| may(there, Happening::Arrives { error }));
        may(there && lost > 0, Happening::LostThere);
        may(there && doubled > 0, Happening::DoubledThere);
        may(self.wire.len() > 1 && swapped > 0 && self.wire[0] != self.wire[1], Happening::SwappedThere);
        let back = !self.answers.is_empty();
        may(back && lost > 0, Happening::LostBack);
        may(back && doubled > 0, Happening::DoubledBack);
        may(
            self.answers.len() > 1 && swapped > 0 && self.answers[0] != self.answers[1],
            Happening::SwappedBack,
        );
        if self.trouble.lies > 0
            && let Some(HostMessage::Report(next)) = self.answers.front()
        {
            for (old, report) in self.reported.iter().zip(0..) {
                may(old != next, Happening::Lie { report });
            }
        }
        may(self.held, Happening::GoesOn);
        may(!self.held && holds > 0 && self.in_motion(), Happening::Holds);
        if self.held {
            return;
        }
        if self.straying {
            for ((x, y, z), to) in STRAYS.into_iter().zip(0..) {
                let single = x == 0 || y == 0;
                may((self.drive.climbs || z == 0) && (self.drive.apart || single), Happening::Strays { to });
            }
            return;
        }
        let room = self.planner.len() < PLANNER;
        may(
            self.read.is_some() && room || self.read.is_none() && !self.received.is_empty(),
            Happening::Reads,
        );
        may(self.trouble.refused > 0 && self.read.is_none() && !self.received.is_empty(), Happening::Refuses);
        may(self.stepper.len() < STEPPER && !self.planner.is_empty(), Happening::Fetches);
        if let Some(&(to, _)) = self.stepper.front() {
            let (tool, climbs) = (self.tool, to.2 != self.tool.2);
            let moving = [to.0 != tool.0, to.1 != tool.1, climbs].into_iter().filter(|moves| *moves).count();
            let slanted = self.drive.apart && moving > 1;
            let routes = if climbs { 1..4 } else { 1..3 };
            for around in if slanted { routes } else { 0..1 } {
                may(true, Happening::Drives { around });
                may(self.between < self.drive.halves, Happening::DrivesHalf { around });
            }
        }
        may(
            resets > 0 && (self.in_motion() || self.read.is_some() || !self.received.is_empty()),
            Happening::Reset,
        );
    }

    /// Applies the event and returns the path of the tool.
    pub fn happens(&mut self, happening: Happening) -> Vec<Xyz> {
        let from = self.tool;
        match happening {
            Happening::Arrives { error } => self.arrives(ERRORS[usize::from(error)]),
            Happening::Reads => self.reads(),
            Happening::Fetches => {
                if let Some(block) = self.planner.pop_front() {
                    self.stepper.push_back((block, 0));
                }
            }
            Happening::Drives { around } => {
                let Some((to, _)) = self.stepper.pop_front() else { return vec![from] };
                (self.tool, self.between) = (to, 0);
                let (x, y, z) = ((to.0, from.1, from.2), (from.0, to.1, from.2), (from.0, from.1, to.2));
                let plane = (to.0, to.1, from.2);
                let corners = match around {
                    0 => vec![],
                    1 => vec![x, plane],
                    2 => vec![y, plane],
                    _ => vec![z, (to.0, from.1, to.2)],
                };
                return std::iter::once(from).chain(corners).chain([to]).collect();
            }
            Happening::DrivesHalf { around } => {
                let Some(&(to, _)) = self.stepper.front() else { return vec![from] };
                let half = ((from.0 + to.0) / 2, (from.1 + to.1) / 2, (from.2 + to.2) / 2);
                let corners = [half, (to.0, from.1, from.2), (from.0, to.1, from.2), (from.0, from.1, to.2)];
                self.tool = corners[usize::from(around)];
                self.between += 1;
            }
            Happening::Strays { to } => {
                let (dx, dy, dz) = STRAYS[usize::from(to)];
                (self.tool, self.straying) = ((from.0 + dx, from.1 + dy, from.2 + dz), false);
            }
            fault => self.suffers(fault),
        }
        vec![from, self.tool]
    }

    /// Applies a fault of the link or of the controller.
    fn suffers(&mut self, fault: Happening) {
        match fault {
            Happening::LostThere => {
                self.trouble.lost -= 1;
                self.wire.pop_front();
            }
            Happening::DoubledThere => {
                self.trouble.doubled -= 1;
                self.wire.insert(1, self.wire[0]);
                self.arrives((0, 0, 0));
            }
            Happening::SwappedThere => {
                self.trouble.swapped -= 1;
                self.wire.swap(0, 1);
                self.arrives((0, 0, 0));
            }
            Happening::LostBack => {
                self.trouble.lost -= 1;
                self.answers.pop_front();
            }
            Happening::DoubledBack => {
                self.trouble.doubled -= 1;
                let copy = self.answers[0];
                if let HostMessage::Report(first) = &mut self.answers[0] {
                    first.doubled = true;
                }
                self.answers.insert(1, copy);
            }
            Happening::SwappedBack => {
                self.trouble.swapped -= 1;
                self.answers.swap(0, 1);
            }
            Happening::Lie { report } => {
                self.trouble.lies -= 1;
                if let (Some(&old), Some(answer)) =
                    (self.reported.get(usize::from(report)), self.answers.front_mut())
                {
                    *answer = HostMessage::Report(old);
                }
            }
            Happening::Refuses => {
                self.trouble.refused -= 1;
                self.received.pop_front();
                self.answers.push_back(HostMessage::Refused);
            }
            Happening::Reset => {
                self.trouble.resets -= 1;
                self.discards_all();
            }
            Happening::Holds => {
                self.trouble.holds -= 1;
                self.held = true;
            }
            Happening::GoesOn => self.held = false,
            _ => {}
        }
    }

    fn discards_all(&mut self) {
        self.received.clear();
        self.read = None;
        self.planner.clear();
        self.stepper.clear();
        self.held = false;
    }

    fn arrives(&mut self, error: Xyz) {
        match self.wire.pop_front() {
            None => {}
            Some(Sent::Line(to)) if self.received.len() < BUFFER => self.received.push_back(to),
            // The head of one line and the tail of another.
            Some(Sent::Line(to)) => {
                if let Some(last) = self.received.back_mut() {
                    *last = (last.0, to.1, to.2);
                }
            }
            Some(Sent::Query) => {
                let report = StatusReport {
                    place: (self.tool.0 + error.0, self.tool.1 + error.1, self.tool.2 + error.2),
                    in_position: !self.in_motion() && !self.held,
                    queued: self.planner.len(),
                    waiting: !self.received.is_empty(),
                    doubled: false,
                };
                if self.trouble.lies > 0 && !self.reported.contains(&report) {
                    self.reported.push(report);
                }
                self.answers.push_back(HostMessage::Report(report));
            }
            Some(Sent::Cancel) if self.in_motion() && self.drive.cancels => {
                self.straying = self.drive.strays;
                self.planner.clear();
                self.stepper.clear();
                if self.drive.flushes {
                    self.received.clear();
                    self.read = None;
                }
            }
            Some(Sent::Cancel) => {}
        }
    }

    /// Plans and acknowledges a line if there is room. Otherwise the line waits. A line without motion
    /// makes no block.
    fn reads(&mut self) {
        let Some(to) = self.read.take().or_else(|| self.received.pop_front()) else { return };
        let end =
            self.planner.back().copied().or(self.stepper.back().map(|&(to, _)| to)).unwrap_or(self.tool);
        if to == end {
            self.answers.push_back(HostMessage::Accepted);
        } else if self.planner.len() < PLANNER {
            self.planner.push_back(to);
            self.answers.push_back(HostMessage::Accepted);
        } else {
            self.read = Some(to);
        }
    }

    /// Lets half of `DRAIN` pass. Returns `false` when a block is overdue, or when the tool has yet to come
    /// to rest after a cancel. During a feed hold the machine executes nothing, and blocks do not age.
    pub fn passes(&mut self) -> bool {
        if self.held {
            return true;
        }
        if self.straying {
            return false;
        }
        let due = self.stepper.iter().any(|&(_, age)| age >= 1);
        for (_, age) in &mut self.stepper {
            *age += 1;
        }
        !due
    }
}

//! A model of a controller and of the line to it, over a tiny lattice, small enough that all it can do is looked at.
//!
//! What it has: lines and queries on the way to it, a receive buffer, one line that was read and waits for room in the
//! planner, the planner's blocks, and blocks that have left the planner and are being executed. What it may do next is a list
//! ([`Plant::moves`]), in any order and as late as it likes, but for one bound: what has left the planner is executed within
//! `DRAIN`. A cancel stops the tool anywhere between where it is and where it was going, and forgets planned blocks; a line
//! that waits in the receive buffer or for room is not forgotten, and runs from wherever the tool stopped (GRBL issues 95,
//! 423, 837).
//!
//! What a line may do: see [`Trouble`]. The assumptions are those of docs/safety/assumptions.md: answers arrive in the order in which they
//! were sent and are not invented, no line both repeats and loses, or swaps twice, and one report in a while may be an old one.
//! A report says where the tool is to [`RESOLUTION`].

use std::collections::VecDeque;

use crate::properties::Xy;
use crate::wire::{Answer, Report, Sent};

/// Lines that the receive buffer holds: one more is mixed up with the last. Two of 63 bytes fit GRBL's 127.
pub const BUFFER: usize = 2;
/// Blocks that the planner holds.
const PLANNER: usize = 2;
/// Blocks that have left the planner and are not yet executed.
const STEPPER: usize = 2;

/// How far a report is from the tool at most, in units.
pub const RESOLUTION: i64 = 4;
/// How far the tool goes after a cancel at most where it may leave its path, in units: 150 ms at 1 mm/min, and no time to brake.
pub const STRAY: i64 = 250;
/// Where it comes to rest then, from where the cancel found it.
const STRAYS: [Xy; 5] = [(0, 0), (STRAY, 0), (-STRAY, 0), (0, STRAY), (0, -STRAY)];

/// Where a report finds the tool, from where it is.
const ERRORS: [Xy; 5] = [(0, 0), (RESOLUTION, 0), (-RESOLUTION, 0), (0, RESOLUTION), (0, -RESOLUTION)];

/// How often what can go wrong, in one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Trouble {
    /// Pieces lost, either way.
    pub lost: u8,
    /// Pieces that arrive twice, either way.
    pub doubled: u8,
    /// Pieces that change places with the one before, either way.
    pub swapped: u8,
    /// Reports replaced by an earlier one.
    pub lies: u8,
    /// Lines that are refused instead of being planned.
    pub refused: u8,
    /// Resets that nobody hears of: all that is held is forgotten, the tool stops.
    pub resets: u8,
    /// Holds that somebody else tells it, and then to go on.
    pub holds: u8,
    /// Jumps of the clock by `DRAIN`.
    pub jumps: u8,
}

/// How the machine drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Drive {
    /// Each axis by itself, in any order.
    pub apart: bool,
    /// A cancel also forgets what was received (grblHAL).
    pub flushes: bool,
    /// A cancel stops motions (jogs); contours know none.
    pub cancels: bool,
    /// A motion that is cancelled may leave its path, by [`STRAY`] at most, before the tool rests.
    pub strays: bool,
    /// Reports are off by the resolution, or not.
    pub errs: bool,
    /// How often it can be found between the ends of motions before it comes to the next end.
    pub halves: u8,
}

/// The controller, the line and the tool.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Plant {
    /// How it drives.
    pub drive: Drive,
    /// Where the tool is.
    pub tool: Xy,
    /// How often the tool was found where no motion began or ended, since one did.
    between: u8,
    /// On the way to it.
    pub wire: VecDeque<Sent>,
    /// Received and not read.
    pub received: VecDeque<Xy>,
    /// Read, waiting for room.
    pub read: Option<Xy>,
    /// Planned.
    pub planner: VecDeque<Xy>,
    /// Left the planner, so many half `DRAIN`s ago.
    pub stepper: VecDeque<(Xy, u8)>,
    /// It holds: nothing moves, and nothing is read.
    held: bool,
    /// It brakes after a cancel, and may leave its path.
    straying: bool,
    /// On the way back.
    pub answers: VecDeque<Answer>,
    /// The reports it has made, as far as a lie may repeat them.
    reported: Vec<Report>,
    /// What may still go wrong.
    pub trouble: Trouble,
}

/// Something that happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Happening {
    /// What was sent first arrives; a report that it asks for is off by so much.
    Arrives {
        /// Which of the errors.
        error: u8,
    },
    /// What was sent first is lost.
    LostThere,
    /// What was sent first arrives twice.
    DoubledThere,
    /// What was sent second arrives first.
    SwappedThere,
    /// The next answer is lost.
    LostBack,
    /// The next answer arrives twice.
    DoubledBack,
    /// The next two answers change places.
    SwappedBack,
    /// The next answer is replaced by an earlier one.
    Lie {
        /// Which.
        report: u8,
    },
    /// A line is read.
    Reads,
    /// A line is read and refused.
    Refuses,
    /// A block leaves the planner.
    Fetches,
    /// The tool drives to the end of its motion; where axes run apart, around by x first or by y first.
    Drives {
        /// The corner that it goes around by: 0 straight, 1 x first, 2 y first.
        around: u8,
    },
    /// The tool drives half of its motion, or to a corner of its box.
    DrivesHalf {
        /// As above.
        around: u8,
    },
    /// It comes to rest after a cancel, beside its path.
    Strays {
        /// Which of the places.
        to: u8,
    },
    /// It is reset, and nobody hears of it.
    Reset,
    /// Somebody else tells it to hold.
    Holds,
    /// Somebody else tells it to go on.
    GoesOn,
}

impl Plant {
    /// A machine at rest.
    #[must_use]
    pub fn new(tool: Xy, drive: Drive, trouble: Trouble) -> Self {
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

    /// Whether it moves, or is about to.
    fn in_motion(&self) -> bool {
        !self.planner.is_empty() || !self.stepper.is_empty() || self.straying
    }

    /// All targets that it holds, or that are on the way to it.
    pub fn targets(&self) -> impl Iterator<Item = Xy> + '_ {
        let on_wire = self.wire.iter().filter_map(|sent| match sent {
            Sent::Line(to) => Some(*to),
            _ => None,
        });
        let held = self.received.iter().chain(&self.read).chain(&self.planner).copied();
        on_wire.chain(held).chain(self.stepper.iter().map(|&(to, _)| to))
    }

    /// What may happen next, but for the host's doing and the passing of time.
    pub fn moves(&self, into: &mut Vec<Happening>) {
        let Trouble { lost, doubled, swapped, resets, holds, .. } = self.trouble;
        let mut may = |allowed: bool, happening| {
            if allowed {
                into.push(happening);
            }
        };
        let there = !self.wire.is_empty();
        let errors = if self.drive.errs && self.wire.front() == Some(&Sent::Query) { 5 } else { 1 };
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
            && let Some(Answer::Report(told)) = self.answers.front()
        {
            for (old, report) in self.reported.iter().zip(0..) {
                may(old != told, Happening::Lie { report });
            }
        }
        may(self.held, Happening::GoesOn);
        may(!self.held && holds > 0 && self.in_motion(), Happening::Holds);
        if self.held {
            return;
        }
        if self.straying {
            (0..5).for_each(|to| may(true, Happening::Strays { to }));
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
            let slanted = self.drive.apart && to.0 != self.tool.0 && to.1 != self.tool.1;
            for around in if slanted { 1..3 } else { 0..1 } {
                may(true, Happening::Drives { around });
                may(self.between < self.drive.halves, Happening::DrivesHalf { around });
            }
        }
        may(
            resets > 0 && (self.in_motion() || self.read.is_some() || !self.received.is_empty()),
            Happening::Reset,
        );
    }

    /// Lets it happen. Answers the way on which the tool moved.
    pub fn happens(&mut self, happening: Happening) -> Vec<Xy> {
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
                let corner = [None, Some((to.0, from.1)), Some((from.0, to.1))][usize::from(around)];
                return [Some(from), corner, Some(to)].into_iter().flatten().collect();
            }
            Happening::DrivesHalf { around } => {
                let Some(&(to, _)) = self.stepper.front() else { return vec![from] };
                let half = ((from.0 + to.0) / 2, (from.1 + to.1) / 2);
                self.tool = [half, (to.0, from.1), (from.0, to.1)][usize::from(around)];
                self.between += 1;
            }
            Happening::Strays { to } => {
                let (dx, dy) = STRAYS[usize::from(to)];
                (self.tool, self.straying) = ((from.0 + dx, from.1 + dy), false);
            }
            fault => self.suffers(fault),
        }
        vec![from, self.tool]
    }

    /// Something goes wrong on the line, or with the controller.
    fn suffers(&mut self, fault: Happening) {
        match fault {
            Happening::LostThere => {
                self.trouble.lost -= 1;
                self.wire.pop_front();
            }
            Happening::DoubledThere => {
                self.trouble.doubled -= 1;
                self.wire.insert(1, self.wire[0]);
                self.arrives((0, 0));
            }
            Happening::SwappedThere => {
                self.trouble.swapped -= 1;
                self.wire.swap(0, 1);
                self.arrives((0, 0));
            }
            Happening::LostBack => {
                self.trouble.lost -= 1;
                self.answers.pop_front();
            }
            Happening::DoubledBack => {
                self.trouble.doubled -= 1;
                let copy = self.answers[0];
                if let Answer::Report(first) = &mut self.answers[0] {
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
                    *answer = Answer::Report(old);
                }
            }
            Happening::Refuses => {
                self.trouble.refused -= 1;
                self.received.pop_front();
                self.answers.push_back(Answer::Refused);
            }
            Happening::Reset => {
                self.trouble.resets -= 1;
                self.forgets();
            }
            Happening::Holds => {
                self.trouble.holds -= 1;
                self.held = true;
            }
            Happening::GoesOn => self.held = false,
            _ => {}
        }
    }

    fn forgets(&mut self) {
        self.received.clear();
        self.read = None;
        self.planner.clear();
        self.stepper.clear();
        self.held = false;
    }

    fn arrives(&mut self, error: Xy) {
        match self.wire.pop_front() {
            None => {}
            Some(Sent::Line(to)) if self.received.len() < BUFFER => self.received.push_back(to),
            // The head of one line and the tail of another.
            Some(Sent::Line(to)) => {
                if let Some(last) = self.received.back_mut() {
                    *last = (last.0, to.1);
                }
            }
            Some(Sent::Query) => {
                let report = Report {
                    place: (self.tool.0 + error.0, self.tool.1 + error.1),
                    in_position: !self.in_motion() && !self.held,
                    queued: self.planner.len(),
                    waiting: !self.received.is_empty(),
                    doubled: false,
                };
                if self.trouble.lies > 0 && !self.reported.contains(&report) {
                    self.reported.push(report);
                }
                self.answers.push_back(Answer::Report(report));
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

    /// A line is planned and acknowledged when there is room, and waits otherwise. One that leads nowhere makes no block.
    fn reads(&mut self) {
        let Some(to) = self.read.take().or_else(|| self.received.pop_front()) else { return };
        let end =
            self.planner.back().copied().or(self.stepper.back().map(|&(to, _)| to)).unwrap_or(self.tool);
        if to == end {
            self.answers.push_back(Answer::Accepted);
        } else if self.planner.len() < PLANNER {
            self.planner.push_back(to);
            self.answers.push_back(Answer::Accepted);
        } else {
            self.read = Some(to);
        }
    }

    /// Half of `DRAIN` passes; `false` when something should have been executed before. A held machine executes nothing, and
    /// grows no older.
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

//! A controller that executes lines, with linear or non-interpolated motion.

use std::collections::VecDeque;

use crate::oracle::xy;
use keepout_executor::supervisor::{Abilities, Command, Limits, Mode, Reply, Report};
use keepout_guard::{Interpolation, Motion, OnCancel};
use keepout_kernel::curve::nearest_point;
use keepout_kernel::{Curve, Height, Place, Point, Vec2};
use keepout_proofs::properties::Xy;
use keepout_proofs::square::plain;

use crate::oracle;

/// Lines that the receive buffer holds. Further lines are lost.
const BUFFER: usize = 3;
/// Motions that the planner holds.
const PLANNED: usize = 15;
/// The last digit of a report, lattice units.
const DIGIT: i64 = 100;

/// The kind of controller.
#[derive(Clone, Copy)]
pub struct Make {
    /// Its abilities.
    pub abilities: Abilities,
    /// A jog replaces the current motion. Otherwise it follows it.
    pub replaces: bool,
    /// Non-interpolated axes move y first, and the third axis with it. Otherwise they move it with y, last.
    pub y_first: bool,
}

/// The tool's tip, lattice units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tip {
    /// In the plane.
    pub at: Xy,
    /// Its height.
    pub height: i64,
}

impl Tip {
    fn of(place: Place) -> Self {
        Self { at: plain(place.point), height: place.height.units().into() }
    }
}

/// Lines in transit, received and planned, and the tool.
pub struct Machine {
    make: Make,
    /// The tool.
    pub tool: Tip,
    /// The tool at the beginning of its motion, and the completed share of the motion.
    begun: (Tip, f64),
    /// Lines in transit to the controller.
    pub wire: VecDeque<Command>,
    received: VecDeque<Motion>,
    planner: VecDeque<Motion>,
    /// Answers in transit to the supervisor.
    pub answers: VecDeque<Reply>,
}

impl Machine {
    /// A machine at rest.
    pub fn new(make: Make, tool: Tip) -> Self {
        Self {
            make,
            tool,
            begun: (tool, 0.0),
            wire: VecDeque::new(),
            received: VecDeque::new(),
            planner: VecDeque::new(),
            answers: VecDeque::new(),
        }
    }

    /// Its abilities.
    pub fn abilities(&self) -> Abilities {
        self.make.abilities
    }

    /// Motions that may still be executed.
    pub fn under_way(&self) -> impl Iterator<Item = &Motion> {
        let sent = self.wire.iter().filter_map(|command| match command {
            Command::Move(certified) => Some(certified.motion()),
            _ => None,
        });
        self.planner.iter().chain(&self.received).chain(sent)
    }

    /// Whether the current motion belongs to a contour.
    pub fn is_contouring(&self) -> bool {
        matches!(self.planner.front(), Some(Motion::Contour { .. }))
    }

    /// Receives the next line.
    pub fn receives(&mut self) {
        let Some(command) = self.wire.pop_front() else { return };
        match command {
            Command::Query => {
                let report = self.report();
                self.answers.push_back(Reply::Report(report));
            }
            Command::Cancel(_) => {
                if self.make.abilities.on_cancel == OnCancel::MayStray {
                    self.received.clear();
                }
                if let Some(Motion::Jog { .. }) = self.planner.front() {
                    self.planner.clear();
                    self.begun = (self.tool, 0.0);
                }
            }
            Command::Abort => {
                self.received.clear();
                self.planner.clear();
                self.begun = (self.tool, 0.0);
                self.answers.push_back(Reply::Restarted);
            }
            Command::Prepare => {
                let limits = Limits::of(200.0, 1000.0);
                self.answers.push_back(Reply::Prepared(limits));
            }
            Command::EndHoming => {}
            Command::Home => self.answers.push_back(Reply::Homed),
            Command::Arm => self.answers.push_back(Reply::Armed),
            Command::Spindle { .. } => self.answers.push_back(Reply::SpindleSwitched),
            Command::Move(certified) if self.received.len() < BUFFER => {
                self.received.push_back(*certified.motion());
            }
            Command::Move(_) => {}
        }
        // Received lines are planned as long as there is room.
        while self.planner.len() < PLANNED {
            let Some(motion) = self.received.pop_front() else { break };
            if self.begins_elsewhere(&motion) {
                self.answers.push_back(Reply::Refused { code: 33, meaning: "", transient: false });
            } else {
                if self.make.replaces && matches!(motion, Motion::Jog { .. }) {
                    self.planner.clear();
                    self.begun = (self.tool, 0.0);
                }
                self.planner.push_back(motion);
                self.answers.push_back(Reply::Accepted);
            }
        }
    }

    /// Whether an arc does not begin at the end of the planned motions. A controller takes an arc by its
    /// radius, and rejects such an arc.
    fn begins_elsewhere(&self, motion: &Motion) -> bool {
        let Motion::Contour { curve: Curve::Arc(arc), .. } = motion else { return false };
        let end = self.planner.back().map_or(self.tool, target).at;
        let from = plain(arc.from());
        (from.0 - end.0).abs().max((from.1 - end.1).abs()) > 4 * DIGIT
    }

    fn report(&self) -> Report {
        let digit = |c: i64| (c + DIGIT / 2).div_euclid(DIGIT) * DIGIT;
        let mode = if self.planner.is_empty() { Mode::Idle } else { Mode::Moving };
        Report {
            mode,
            position: reported(digit(self.tool.at.0), digit(self.tool.at.1), digit(self.tool.height)),
            queued: self.make.abilities.queues.then_some(self.planner.len()),
            waiting: self.make.abilities.queues.then_some(!self.received.is_empty()),
        }
    }

    /// Executes a share of the current motion, at most its remainder. Returns the executed share.
    pub fn moves(&mut self, share: f64) -> Option<f64> {
        let motion = *self.planner.front()?;
        let (from, done) = self.begun;
        let most = self.corner(&motion).map_or(1.0, |corner| if done < corner { corner - done } else { 1.0 });
        // A part of an arc so short that its chord is the arc, to a unit or two.
        let most = if matches!(motion, Motion::Contour { curve: Curve::Arc(_), .. }) { 0.005 } else { most };
        let used = share.min(1.0 - done).min(most).max(0.0);
        let at = done + used;
        let driven = match motion {
            Motion::Jog { .. } => self.make.abilities.interpolation,
            Motion::Contour { .. } => self.make.abilities.contours,
        };
        self.tool = self.between(from, target(&motion), at, driven);
        if let Motion::Contour { curve: Curve::Arc(arc), .. } = motion
            && at < 1.0
        {
            let (centre, (angle, r)) = (xy(arc.centre()), oracle::polar(&arc, at));
            self.tool.at = nearest((centre.0 + r * angle.cos(), centre.1 + r * angle.sin()));
        }
        self.begun.1 = at;
        if at >= 1.0 {
            self.planner.pop_front();
            self.begun = (self.tool, 0.0);
        }
        Some(used.max(1e-3))
    }

    /// The share of the motion at which the second axis begins to move.
    fn corner(&self, motion: &Motion) -> Option<f64> {
        let Abilities { interpolation, contours, .. } = self.make.abilities;
        let interpolation = if matches!(motion, Motion::Jog { .. }) { interpolation } else { contours };
        (interpolation == Interpolation::Independent).then_some(0.5)
    }

    #[expect(clippy::cast_precision_loss, reason = "coordinates have 30 bits")]
    #[expect(clippy::cast_possible_truncation, reason = "between two heights")]
    fn between(&self, from: Tip, to: Tip, share: f64, interpolation: Interpolation) -> Tip {
        let real = |(x, y): Xy| (x as f64, y as f64);
        let (a, b) = (real(from.at), real(to.at));
        let (first, second) = ((2.0 * share).min(1.0), (2.0 * share - 1.0).max(0.0));
        let (x, y) = match (interpolation, self.make.y_first) {
            (Interpolation::Linear, _) => (share, share),
            (Interpolation::Independent, false) => (first, second),
            (Interpolation::Independent, true) => (second, first),
        };
        let climb = (to.height - from.height) as f64 * y;
        Tip {
            at: nearest((a.0 + (b.0 - a.0) * x, a.1 + (b.1 - a.1) * y)),
            height: from.height + climb.round() as i64,
        }
    }
}

/// The end of a motion.
fn target(motion: &Motion) -> Tip {
    Tip::of(match motion {
        Motion::Jog { to, .. } => *to,
        Motion::Contour { curve, heights, .. } => curve.to().at_height(heights[1]),
    })
}

fn reported(x: i64, y: i64, height: i64) -> Option<Place> {
    Some(Point::from_units(x, y).ok()?.at_height(Height::from_units(height).ok()?))
}

fn nearest((x, y): (f64, f64)) -> Xy {
    plain(nearest_point(Vec2::new(x, y)).expect("it is between places of the table"))
}

//! Motions along the third axis: by keys and handwheel, and the errands that the operator starts: raise the tool,
//! or cross to a contour.

use keepout_guard::Time;
use keepout_kernel::{Height, Point};
use keepout_planner::units::{length_up_from_mm, point_from_mm};

use super::Supervisor;
use super::event::Command;
use super::jog::{JogContext, JogPlanner, Lift};
use super::notice::Notice;

/// What the tool does by itself, step by step, until the operator moves a control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Errand {
    /// Rises to this height.
    Raise(Height),
    /// Rises, crosses to a point, and lowers to just above the stock.
    Cross {
        /// The point.
        to: Point,
        /// Height of the crossing.
        safe: Height,
        /// The part of the way that is under way.
        stage: Stage,
    },
}

/// The parts of a crossing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Rising,
    Crossing,
    Lowering,
}

/// Height above the stock where a crossing ends, mm.
const ABOVE_STOCK_MM: f64 = 1.0;
/// Height above the stock from which on the tool lowers slowly in an errand, as a share of full speed.
const LOWERING: f64 = 0.5;

impl Supervisor {
    /// Ends the errand under way.
    pub(super) fn end_errand(&mut self) {
        if self.operation.errand.take().is_some() {
            self.note(Notice::ErrandStopped);
        }
    }

    /// Begins to raise the tool: to the safe height, or from there to the end of travel.
    pub(super) fn begin_raise(&mut self) {
        let (Some(relief), Some(end)) = (&self.work.plan.plan.relief, self.guard.end()) else {
            self.note(Notice::NoRaise);
            return;
        };
        let highest = self.guard.rules().heights.highest;
        let safe = relief.safe.min(highest);
        self.operation.errand = Some(Errand::Raise(if end.height() < safe { safe } else { highest }));
    }

    /// Begins a crossing to a contour.
    pub(super) fn begin_crossing(&mut self, contour: usize) {
        let plan = &self.work.plan;
        let Some(relief) = &plan.plan.relief else {
            self.note(Notice::NoCrossing);
            return;
        };
        let safe = relief.safe.min(self.guard.rules().heights.highest);
        let Some(named) = plan.contour_numbered(contour) else {
            self.note(Notice::UnknownContour(contour));
            return;
        };
        let to = point_from_mm(named.name.middle_mm);
        let Some(to) = to.ok().filter(|&to| self.guard.rules().travel.holds(to)) else {
            self.note(Notice::BeyondTravel(contour));
            return;
        };
        self.note(Notice::Crossing(contour));
        self.operation.errand = Some(Errand::Cross { to, safe, stage: Stage::Rising });
    }

    /// Moves the tool along the third axis, if the operator or an errand asks for it. Returns whether one does.
    pub(super) fn lifts(&mut self, now: Time, commands: &mut Vec<Command>) -> bool {
        if self.work.plan.plan.relief.is_none() {
            return false;
        }
        let (up, errand) = (self.operation.input.up(now), self.operation.errand);
        let turned_up_mm = self.state.steering().map_or(0.0, |planner| planner.turned_up_mm());
        if up == 0.0 && turned_up_mm == 0.0 && errand.is_none() {
            return false;
        }
        let waits = (up < 0.0 || turned_up_mm < 0.0) && self.waits_for_spindle();
        let lowest = if self.operation.spindle.runs.is_none() { near_stock() } else { Height::LOWEST };
        let (state, mut context) = self.jogging(lowest, now, commands);
        let Some(planner) = state.steering() else { return false };
        if !planner.rests_in_plane(&mut context) {
            return true;
        }
        if waits || up != 0.0 {
            planner.forget_turns_up();
        }
        if waits {
            return true;
        }
        if up != 0.0 {
            planner.lift(up, &mut context);
        } else if turned_up_mm != 0.0 {
            planner.follow_turns_up(&mut context);
        } else if let Some(errand) = errand {
            self.operation.errand = errand.step(planner, &mut context);
        }
        true
    }

    /// Whether the operator has stated what the spindle does, or the session has two axes and the tool is lowered by
    /// hand.
    pub(super) fn spindle_is_stated(&mut self) -> bool {
        let stated = self.operation.spindle.runs.is_some() || !self.climbs();
        if !stated {
            self.note(Notice::SpindleBeforeContour);
        }
        stated
    }

    /// Whether the tool is at the top of the stock, and the operator has not stated what the spindle does.
    fn waits_for_spindle(&mut self) -> bool {
        let at_top = self.guard.end().is_some_and(|end| end.height() <= near_stock());
        let waits = at_top && self.operation.spindle.runs.is_none();
        if waits {
            self.note(Notice::SpindleAboveStock);
        }
        waits
    }
}

/// The height above the stock below which the spindle must be stated.
fn near_stock() -> Height {
    Height::ZERO.raised(length_up_from_mm(ABOVE_STOCK_MM).unwrap_or(keepout_kernel::Length::ZERO))
}

impl Errand {
    /// Takes one step. Returns the errand that is left.
    fn step(self, planner: &mut JogPlanner, context: &mut JogContext<'_>) -> Option<Self> {
        let speed_mm_s = context.lift_mm_s;
        let there = |height: Height, context: &JogContext<'_>| {
            context.guard.in_position() && context.guard.confirmed().is_some_and(|at| at.height() >= height)
        };
        match self {
            Self::Raise(to) => {
                let lift = planner.lift_to(to, speed_mm_s, context);
                (lift == Lift::Moves && !there(to, context)).then_some(self)
            }
            Self::Cross { to, safe, stage: Stage::Rising } => {
                let above = context.guard.end().is_some_and(|end| end.height() >= safe);
                if above && context.guard.in_position() {
                    return Some(Self::Cross { to, safe, stage: Stage::Crossing });
                }
                if !above {
                    planner.lift_to(safe, speed_mm_s, context);
                }
                Some(self)
            }
            Self::Cross { to, safe, stage: Stage::Crossing } => match planner.cross_to(to, context) {
                Lift::Moves => Some(self),
                Lift::Ends if context.guard.end().is_some_and(|end| end.point() == to) => {
                    Some(Self::Cross { to, safe, stage: Stage::Lowering })
                }
                Lift::Ends => None,
            },
            Self::Cross { stage: Stage::Lowering, .. } => {
                let lift = planner.lift_to(near_stock(), speed_mm_s * LOWERING, context);
                let lowered = context.guard.end().is_none_or(|end| end.height() <= near_stock());
                (lift == Lift::Moves && !(lowered && context.guard.in_position())).then_some(self)
            }
        }
    }
}

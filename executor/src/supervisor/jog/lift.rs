//! Jogs along the third axis, and the guided crossing: up, across, down.
//!
//! Each jog is short, so the tool stops soon after the operator releases the key, although some controllers take no
//! cancel. A rise needs no certificate. A lowering is certified like every jog.

use keepout_guard::FreePlace;
use keepout_kernel::{Height, Length, Point};
use keepout_planner::units::{length_up_from_mm, mm};

use super::{JogContext, JogPlanner, feed};

/// Longest duration of a jog along the axis, s.
const STEP_S: f64 = 0.2;
/// Shortest jog along the axis, mm.
const SHORTEST_MM: f64 = 0.02;
/// Turns of the handwheel below this are done, mm.
const LEAST_TURN_MM: f64 = 0.001;
/// Grid of heights, lattice units (1 µm).
const GRID: i64 = 100;
/// Halvings of a lowering that the guard refuses.
const HALVINGS: u32 = 16;
/// Longest jog of a guided crossing in the plane, mm.
const CROSSING_MM: f64 = 5.0;

/// What a step along the axis came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::supervisor) enum Lift {
    /// A jog was sent, or one is under way.
    Moves,
    /// The tool is there, or no jog leads nearer.
    Ends,
}

impl JogPlanner {
    /// Whether another jog along the axis can be sent now.
    fn can_lift(&self, context: &JogContext<'_>) -> bool {
        let guard = &context.guard;
        !self.resting
            && guard.unacknowledged() == 0
            && guard.takes_lines()
            && (context.abilities.queues || guard.in_position())
    }

    /// Cancels a jog in the plane, which may be long. Returns whether none is under way any more. A jog that cannot be
    /// cancelled is short.
    pub(in crate::supervisor) fn rests_in_plane(&mut self, context: &mut JogContext<'_>) -> bool {
        if context.guard.in_position() || !context.abilities.cancels() {
            self.heading = None;
        }
        if self.heading.is_some() {
            self.cancel(context);
        }
        self.heading.is_none()
    }

    /// Moves the tool at a share of the axis's speed: upward when it is positive.
    pub(in crate::supervisor) fn lift(&mut self, share: f64, context: &mut JogContext<'_>) -> Lift {
        let Some(end) = context.guard.end() else { return Lift::Ends };
        let speed_mm_s = share.abs().min(1.0) * context.lift_mm_s;
        let step_mm = (speed_mm_s * STEP_S).max(SHORTEST_MM).copysign(share);
        climbed(end.height(), step_mm).map_or(Lift::Ends, |to| self.lift_to(to, speed_mm_s, context))
    }

    /// Turns of the handwheel of the third axis that the tool has not followed yet, mm: up when positive.
    pub(in crate::supervisor) const fn turned_up_mm(&self) -> f64 {
        self.turned_up_mm
    }

    /// Forgets the turns of the handwheel of the third axis.
    pub(in crate::supervisor) const fn forget_turns_up(&mut self) {
        self.turned_up_mm = 0.0;
    }

    /// Follows the handwheel of the third axis.
    pub(in crate::supervisor) fn follow_turns_up(&mut self, context: &mut JogContext<'_>) {
        let height = |context: &JogContext<'_>| context.guard.end().map(FreePlace::height);
        let target = height(context).and_then(|from| Some((from, climbed(from, self.turned_up_mm)?)));
        let Some((from, to)) = target else { return self.forget_turns_up() };
        let sent = context.guard.sent();
        if self.lift_to(to, context.lift_mm_s, context) == Lift::Ends {
            return self.forget_turns_up();
        }
        if context.guard.sent() > sent {
            let at = height(context).unwrap_or(to);
            let left_mm = self.turned_up_mm - (mm(at.units()) - mm(from.units()));
            self.turned_up_mm = if left_mm.abs() < LEAST_TURN_MM { 0.0 } else { left_mm };
        }
    }

    /// Moves the tool toward a height, by one jog at most.
    pub(in crate::supervisor) fn lift_to(
        &mut self,
        to: Height,
        speed_mm_s: f64,
        context: &mut JogContext<'_>,
    ) -> Lift {
        let (Some(end), Some(confirmed)) = (context.guard.end(), context.guard.confirmed()) else {
            return Lift::Ends;
        };
        let gap = |a: Height, b: Height| (mm(a.units()) - mm(b.units())).abs();
        let step_mm = (speed_mm_s * STEP_S).max(SHORTEST_MM);
        if !self.can_lift(context) || gap(end.height(), confirmed.height()) > step_mm {
            return Lift::Moves;
        }
        let from = end.height();
        let rules = context.guard.rules().heights;
        // The tool is not lowered beyond a bound; it may already be below one that was set later.
        let lowest = rules.lowest.max(context.lowest).min(from);
        let to = to.clamp(lowest, rules.highest.max(lowest));
        let most = length_up_from_mm(step_mm).unwrap_or(Length::ZERO);
        let target = on_grid(to.clamp(from.lowered(most), from.raised(most)), to);
        let certified = match target.cmp(&from) {
            std::cmp::Ordering::Equal => None,
            std::cmp::Ordering::Greater => context.guard.rise(target, feed(speed_mm_s)).ok(),
            std::cmp::Ordering::Less => lowered(end.point(), [from, target], speed_mm_s, context),
        };
        let Some(certified) = certified else { return Lift::Ends };
        self.heading = None;
        context.send(certified);
        Lift::Moves
    }

    /// Moves the tool straight toward a point at its present height, by one jog at most.
    pub(in crate::supervisor) fn cross_to(&mut self, to: Point, context: &mut JogContext<'_>) -> Lift {
        let (Some(end), Some(confirmed)) = (context.guard.end(), context.guard.confirmed()) else {
            return Lift::Ends;
        };
        let ahead = super::length_mm(end.point().minus(confirmed.point()));
        if end.point() == to {
            return if context.guard.in_position() { Lift::Ends } else { Lift::Moves };
        }
        if !self.can_lift(context) || ahead > CROSSING_MM {
            return Lift::Moves;
        }
        let way = to.minus(end.point());
        let share = (CROSSING_MM / super::length_mm(way)).min(1.0);
        let step = super::part_of(way, share);
        let next =
            if share < 1.0 { end.point().translated(step).ok().and_then(super::on_grid) } else { Some(to) };
        let Some(next) = next else { return Lift::Ends };
        let speed_mm_s = context.limits.speed_mm_s / 2.0;
        let Ok(certified) = context.guard.jog(next.at_height(end.height()), feed(speed_mm_s)) else {
            return if context.guard.in_position() { Lift::Ends } else { Lift::Moves };
        };
        self.heading = None;
        context.send(certified);
        Lift::Moves
    }
}

/// The height that is `up_mm` above another, or below it for a negative distance.
fn climbed(height: Height, up_mm: f64) -> Option<Height> {
    let step = length_up_from_mm(up_mm.abs()).ok()?;
    Some(if up_mm > 0.0 { height.raised(step) } else { height.lowered(step) })
}

/// The lowest admitted jog straight down toward `target`. `None` when the guard admits none.
fn lowered(
    point: Point,
    [from, target]: [Height; 2],
    speed_mm_s: f64,
    context: &mut JogContext<'_>,
) -> Option<keepout_guard::Certified> {
    let admissions = context.guard.admissions();
    let units = |height: Height| i64::from(height.units());
    let admit = |height: Height| admissions.admit(point.at_height(height)).ok();
    if let Some(admission) = admit(target) {
        return Some(admissions.jog(admission, feed(speed_mm_s)));
    }
    // The admitted heights are those above some height, because what stands above a tip only grows downward.
    let (mut high, mut low, mut best) = (units(from), units(target), None);
    for _ in 0..HALVINGS {
        let middle = Height::from_units(i64::midpoint(high, low).div_euclid(GRID) * GRID).ok()?;
        match admit(middle).filter(|_| middle < from) {
            Some(admission) => (high, best) = (units(middle), Some(admission)),
            None => low = units(middle),
        }
    }
    let admission = best?;
    Some(admissions.jog(admission, feed(speed_mm_s)))
}

/// A height on the grid, or the wanted one where the jog ends there.
fn on_grid(height: Height, wanted: Height) -> Height {
    if height == wanted {
        return height;
    }
    Height::from_units(i64::from(height.units()).div_euclid(GRID) * GRID).unwrap_or(height)
}

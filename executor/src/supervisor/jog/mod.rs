//! The jog planner: from the operator's input to certified jogs.
//!
//! The planner only proposes targets. [`Guard::jog`] and [`Guard::retract`] decide.

mod lift;
mod pace;
mod search;
mod slide;
mod way;

use std::time::Duration;

use keepout_guard::{Certified, FreePlace, Guard, Interpolation, OnCancel, Time};
use keepout_kernel::clip::longest_prefix;
use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{FreePoint, Height, Point};
use keepout_planner::Mm2;
pub(super) use lift::Lift;
use pace::LookAhead;
pub use search::WallContact;
use search::{Proposal, Push, Search, on_grid, part_of, vector};
pub(super) use search::{length_mm, standing_off};
use way::Way;

use super::{Abilities, Command, Counts};

/// Limits of the machine for jogging.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Top speed along one axis, mm/s.
    pub speed_mm_s: f64,
    /// Acceleration of x and y, mm/s²: that of the slower one.
    pub acceleration_mm_s2: f64,
    /// Acceleration of the quicker axis, mm/s². Not finite when it is unknown. The jog planner uses only the
    /// other acceleration.
    pub quicker_mm_s2: f64,
}

impl Limits {
    /// The limits of a machine with the same acceleration on all axes.
    #[must_use]
    pub const fn of(speed_mm_s: f64, acceleration_mm_s2: f64) -> Self {
        Self { speed_mm_s, acceleration_mm_s2, quicker_mm_s2: acceleration_mm_s2 }
    }

    /// The limits of an unknown machine: infinite.
    pub const UNLIMITED: Self = Self::of(f64::INFINITY, f64::INFINITY);

    /// The lesser value of both limits in each field.
    #[must_use]
    pub fn least(self, other: Self) -> Self {
        Self {
            speed_mm_s: self.speed_mm_s.min(other.speed_mm_s),
            acceleration_mm_s2: self.acceleration_mm_s2.min(other.acceleration_mm_s2),
            quicker_mm_s2: self.quicker_mm_s2.min(other.quicker_mm_s2),
        }
    }
}

/// A jog input that turns by more than this (cosine) cancels the jogs in flight.
const TURNED: f64 = 0.7;
/// The same for a controller that takes no motions while it moves.
const TURNED_SINGLE: f64 = 0.995;
/// The planner does not cancel a motion in flight that is shorter than this, mm.
const SHORT_QUEUE_MM: f64 = 1.0;
/// Greatest distance of the handwheels ahead of the tool, mm.
const WHEEL_AHEAD_MM: f64 = 10.0;
/// Two directions count as equal within this (cosine): 0.8°.
const ALIKE: f64 = 0.9999;

/// The context of the jog planner in one step.
pub(super) struct JogContext<'a> {
    pub(super) guard: &'a mut Guard,
    pub(super) counts: &'a mut Counts,
    pub(super) commands: &'a mut Vec<Command>,
    pub(super) limits: Limits,
    /// Rapid rate of the third axis, mm/s.
    pub(super) lift_mm_s: f64,
    /// Height below which the tool is not lowered.
    pub(super) lowest: Height,
    pub(super) abilities: Abilities,
    pub(super) round_trip: Duration,
    pub(super) now: Time,
}

impl JogContext<'_> {
    fn send(&mut self, certified: Certified) {
        self.counts.jogs += 1;
        self.commands.push(Command::Move(certified));
    }
}

/// The memory of the jog planner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JogPlanner {
    /// Direction of the last jog's input.
    heading: Option<Mm2>,
    /// Lines sent and lines unacknowledged at the last request for a cancel.
    asked_to_cancel: Option<(u64, u64)>,
    /// The same at the last cancel that was sent.
    cancelled: Option<(u64, u64)>,
    /// No jog is sent until the tool is in position.
    resting: bool,
    /// The last jog that found no admissible target. An equal request is skipped.
    fruitless: Option<Fruitless>,
    /// Speed of the last jog.
    speed_mm_s: f64,
    /// Earliest time of the next jog. The in-flight set holds a limited number of targets.
    next_at: Time,
    /// Turns of the handwheels that the tool has not followed yet, mm.
    turned_mm: Mm2,
    /// Turns of the handwheel of the third axis that it has not followed yet, mm.
    turned_up_mm: f64,
}

/// A jog that found no admissible target.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fruitless {
    base: Point,
    confirmed: Option<Point>,
    /// Number of points of the in-flight set.
    set: usize,
    unit: Mm2,
}

impl Fruitless {
    fn is_alike(&self, other: &Self) -> bool {
        let same = (self.base, self.confirmed, self.set) == (other.base, other.confirmed, other.set);
        same && self.unit.dot(other.unit) > ALIKE
    }
}

/// Feed word for a speed, mm/min. It is at least 60, because slower steps would outlast
/// [`keepout_guard::DRAIN`].
pub(super) fn feed(speed_mm_s: f64) -> u32 {
    u32::try_from(nearest_unit((speed_mm_s * 60.0).floor())).unwrap_or(1).max(60)
}

impl JogPlanner {
    /// Takes note that the tool is in position.
    pub(super) fn settle(&mut self) {
        self.resting = false;
        self.asked_to_cancel = None;
        self.cancelled = None;
    }

    /// Sends no jog until the tool is in position.
    pub(super) fn wait_for_rest(&mut self) {
        self.resting = true;
    }

    /// Takes turns of the handwheels, mm.
    pub(super) fn turn(&mut self, Mm2 { x, y }: Mm2, up_mm: f64) {
        let sum = |a: f64, b: f64| {
            let sum = a + b;
            if sum.is_finite() { sum.clamp(-WHEEL_AHEAD_MM, WHEEL_AHEAD_MM) } else { a }
        };
        self.turned_mm = Mm2::new(sum(self.turned_mm.x, x), sum(self.turned_mm.y, y));
        self.turned_up_mm = sum(self.turned_up_mm, up_mm);
    }

    /// Sends the jog that the input requests, as far as the guard certifies it and it is not in flight
    /// already.
    pub(super) fn steer(&mut self, input: Option<Mm2>, context: &mut JogContext<'_>) -> WallContact {
        let Some(velocity) = input else { return self.turn_wheels(context) };
        self.turned_mm = Mm2::ZERO;
        if self.resting {
            return WallContact::Unknown;
        }
        let length = velocity.length();
        let unit = velocity / length;
        let mut ahead_mm = self.ahead_mm(context.guard);
        let single = !context.abilities.queues;
        let turned = if single { TURNED_SINGLE } else { TURNED };
        let turns = self.heading.is_some_and(|heading| heading.dot(unit) < turned);
        if turns && (ahead_mm > SHORT_QUEUE_MM || single) {
            self.cancel(context);
            ahead_mm = self.ahead_mm(context.guard);
        }
        let busy = context.guard.unacknowledged() > 0 || !context.guard.takes_lines();
        if self.resting || busy || single && !context.guard.in_position() {
            return WallContact::Unknown;
        }
        let speed_mm_s = length * context.limits.speed_mm_s;
        let look = LookAhead::of(context, speed_mm_s);
        let push = Push { unit, speed_mm_s, ahead_mm, ahead_mm_s: self.speed_mm_s, look };
        if context.now < self.next_at && !context.guard.in_position()
            || push.missing_mm(speed_mm_s) < look.least_mm(speed_mm_s)
        {
            return WallContact::Unknown;
        }
        let Some(base) = self.base(context) else { return WallContact::Unknown };
        let confirmed = context.guard.confirmed().map(FreePlace::point);
        let attempt =
            Fruitless { base: base.point(), confirmed, set: context.guard.in_flight().count(), unit };
        if self.fruitless.is_some_and(|before| before.is_alike(&attempt)) {
            context.counts.clipped += 1;
            return WallContact::Unknown;
        }
        let search = Search::new(context.guard);
        let (proposal, contact) = search.reach(base, &push);
        context.counts.clipped += u64::from(contact != WallContact::Free);
        self.fruitless = proposal.is_none().then_some(attempt);
        let Some(proposal) = proposal else { return contact };
        self.heading = Some(unit);
        self.speed_mm_s = proposal.speed_mm_s;
        self.next_at = context.now.after(look.step());
        let certified = search.send(proposal);
        context.send(certified);
        contact
    }

    /// Sends a retract move in the direction of the input. It comes nearer to no edge within the jogging
    /// clearance.
    pub(super) fn retract(&mut self, input: Option<Mm2>, context: &mut JogContext<'_>) {
        let Some(velocity) = input else {
            self.cancel(context);
            return;
        };
        if self.resting || !context.guard.in_position() || context.guard.unacknowledged() > 0 {
            return;
        }
        let Some(from) = context.guard.confirmed() else { return };
        let speed = (velocity.length() * context.limits.speed_mm_s).min(RETRACT_MM_S);
        let along = match context.abilities.interpolation {
            Interpolation::Linear => velocity,
            Interpolation::Independent if velocity.x.abs() > velocity.y.abs() => Mm2 { y: 0.0, ..velocity },
            Interpolation::Independent => Mm2 { x: 0.0, ..velocity },
        };
        let to = from.point().translated(vector(along, RETRACT_STEP_MM));
        let Ok(to) = to else { return };
        let admissions = context.guard.admissions();
        let mut best = None;
        longest_prefix(from.point(), to, |point| {
            let admission = on_grid(point)
                .and_then(|target| admissions.admit_retract(target.at_height(from.height())).ok());
            let admitted = admission.is_some();
            best = admission.or(best.take());
            admitted
        });
        let Some(admission) = best else { return };
        let certified = admissions.jog(admission, feed(speed));
        context.send(certified);
    }

    /// Follows the handwheels while the stick is centred, or cancels the jogs of the stick.
    fn turn_wheels(&mut self, context: &mut JogContext<'_>) -> WallContact {
        let step = vector(self.turned_mm, 1.0);
        let short = step.dx.abs().max(step.dy.abs()) < context.guard.rules().shortest.units();
        if short {
            if self.heading.is_some() {
                self.cancel(context);
            }
            return WallContact::Unknown;
        }
        if self.heading.is_some() {
            // The operator released the stick before turning the wheel: stop first.
            self.cancel(context);
            self.heading = if context.guard.in_position() { None } else { self.heading };
        }
        let busy = context.guard.unacknowledged() > 0
            || !context.guard.takes_lines()
            || !context.abilities.queues && !context.guard.in_position();
        if self.resting || busy || self.heading.is_some() {
            return WallContact::Unknown;
        }
        let Some(end) = context.guard.end() else { return WallContact::Unknown };
        self.turned_mm = Mm2::ZERO;
        let whole = end.point().translated(step).ok().and_then(on_grid);
        let search = Search::new(context.guard);
        let Some(admission) = search.prefix(end.free(), step, 0.0) else { return WallContact::Wall };
        let contact =
            if Some(admission.target().point) == whole { WallContact::Free } else { WallContact::Wall };
        let certified = search.send(Proposal { admission, speed_mm_s: context.limits.speed_mm_s });
        context.send(certified);
        contact
    }

    /// Cancels the jogs in flight, once for each count of lines sent and unacknowledged. A line that waited
    /// for room in the queue runs after a cancel, and needs another one.
    pub(super) fn cancel(&mut self, context: &mut JogContext<'_>) {
        let counts = (context.guard.sent(), context.guard.unacknowledged());
        // An unexamined controller may also drop lines that it has not read. It would never acknowledge them.
        let may_flush = context.guard.rules().on_cancel == OnCancel::MayStray && context.abilities.queues;
        let waits = may_flush && context.guard.unacknowledged() > 0;
        if context.guard.in_position() || self.asked_to_cancel == Some(counts) || waits {
            return;
        }
        self.asked_to_cancel = Some(counts);
        // If the guard refuses the cancel, the jogs run to their targets, a short way ahead.
        let Ok(certified) = context.guard.cancel() else { return };
        self.resting |= context.guard.may_have_strayed();
        self.cancelled = Some(counts);
        self.next_at = Time::ZERO;
        context.counts.cancels += 1;
        context.commands.push(Command::Cancel(certified));
    }

    /// Length of the path ahead of the tool, mm, along the targets that no cancel has dropped.
    fn ahead_mm(&self, guard: &Guard) -> f64 {
        let struck = self.cancelled.map_or(0, |(sent, _)| sent);
        let way = Way::of(guard, struck);
        way.points().windows(2).map(|pair| length_mm(pair[1].minus(pair[0]))).sum()
    }

    /// Start of the next motion: the last target, or after a cancel the expected place of the tool.
    fn base(&self, context: &JogContext<'_>) -> Option<FreePoint> {
        if self.cancelled.is_none_or(|(sent, _)| sent != context.guard.sent()) {
            return context.guard.end().map(FreePlace::free);
        }
        let confirmed = context.guard.confirmed()?;
        let speed = context.limits.speed_mm_s;
        let mut left = speed * speed / (2.0 * context.limits.acceleration_mm_s2)
            + speed * context.round_trip.as_secs_f64() / 2.0;
        let mut at = confirmed.point();
        for &next in Way::of(context.guard, 0).points().iter().skip(1) {
            let step = next.minus(at);
            let length = length_mm(step);
            let share = (left / length.max(1e-9)).min(1.0);
            at = at.translated(part_of(step, share)).ok()?;
            left -= length;
            if left <= 0.0 {
                break;
            }
        }
        context.guard.part().motion(confirmed.free(), at).ok().or(Some(confirmed.free()))
    }
}

/// Greatest speed of a retract move, mm/s.
const RETRACT_MM_S: f64 = 5.0;
/// Greatest length of a retract move, mm.
const RETRACT_STEP_MM: f64 = 2.0;

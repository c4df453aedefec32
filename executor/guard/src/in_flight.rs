//! TRUSTED. The in-flight set: every point where the tool may still be, and every target it may still execute.
//!
//! **Invariant:** the set's hull is clear of the part at the threshold of its points. For a controller that drives straight
//! ([`Interpolation::Linear`]) the hull is the convex hull; for one whose axes run apart ([`Interpolation::Independent`]) it is the smallest
//! box along the axes. Either way a motion from a point of the hull to a target in the set stays in the hull.
//!
//! **Where the tool is.** Let e be the resolution: a report is no farther than that from where the tool was commanded to be. It
//! is believed up to 2e from the hull, and the nearest point of the hull becomes the confirmed: no farther than 3e from the tool.
//! Motions to targets in the set begin there, and bring it no farther from the hull. At rest the report itself becomes the
//! confirmed, e from the tool, where that is free: so errors do not add up. The margin counts e; the rest comes from what steering
//! by hand keeps beyond it, which is 2e at least. Nearest points are rounded, by less than a unit each time: where distances
//! are compared a unit is added for each, and the margin has its term for the lattice.

use alloc::collections::VecDeque;
use core::cell::Cell;
use core::time::Duration;

use keepout_kernel::exact::segment::{Window, points_within};
use keepout_kernel::{Blocked, Edge, FreePoint, Length, Point, ProhibitedRegion, Segment, Vector};

use crate::hull::Hull;
use crate::{Refusal, Time};

/// How a controller drives to a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight.
    Linear,
    /// Each axis by itself: anywhere in the box between start and target.
    Independent,
}

/// What a status report says, as far as the guard is concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionFeedback {
    /// The reported position.
    pub position: Point,
    /// The controller says that it stands still and waits for commands.
    pub in_position: bool,
    /// Motions in the controller's queue; `None` when the report does not say.
    pub queued: Option<usize>,
    /// Whether it has received something that it has not acted on.
    pub waiting: bool,
}

/// How many lines had been sent and acknowledged when a query left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QueryStamp {
    pub(crate) sent: u64,
    pub(crate) acknowledged: u64,
    pub(crate) at: Time,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) number: u64,
    pub(crate) target: FreePoint,
}

/// Most lines in flight at once.
pub(crate) const LINES_MAX: usize = 12;
/// Reports that are remembered while lines wait to be retired.
const SEEN_MAX: usize = 64;
/// How far from the hull a report is believed, in resolutions: that of the report, and that of the one the confirmed came from.
pub(crate) const BELIEVED: i64 = 2;
/// A tool that has begun no later line is reported no farther than this from the places up to there, in resolutions.
pub(crate) const BEYOND: i64 = 4;
/// A block that has left the planner is executed within this time: six segments of 10 ms, or of a step each when that
/// is longer; at 1 mm/s and 20 steps/mm, 300 ms (GRBL's stepper buffer).
pub const DRAIN: Duration = Duration::from_millis(500);

/// The set. Allocates nothing after [`InFlight::new`].
#[derive(Clone, Debug)]
pub(crate) struct InFlight {
    pub(crate) interpolation: Interpolation,
    /// How far a reported position can be from the commanded one.
    pub(crate) resolution: Length,
    /// Reports are protected by a checksum: one is evidence. Otherwise two are needed, so that one that was damaged into a
    /// valid one does no harm.
    pub(crate) checked: bool,
    /// Where the tool was at the last report, and at the one before it when one report is no evidence.
    pub(crate) confirmed: Option<FreePoint>,
    pub(crate) before: Option<FreePoint>,
    pub(crate) lines: VecDeque<Line>,
    /// Lines up to this number had left the queue when the report at this time arrived; both ascending.
    pub(crate) left_queue: VecDeque<(u64, Time)>,
    /// What the last report said had left the queue.
    pub(crate) left_before: u64,
    /// Lines up to this number were executed when the last report was asked for.
    pub(crate) executed: u64,
    /// Lines of the set that were refused: they were never in the queue, as far as that answer went.
    pub(crate) refused: u64,
    pub(crate) rests_seen: u8,
    pub(crate) rested_at: Option<Point>,
    /// The highest feed of a line since the tool rested, mm/min.
    pub(crate) fastest: u32,
    /// Lines sent when a cancel was last sent since the tool rested.
    pub(crate) cancelled: Option<u64>,
    /// How far the tool may be beside the hull, since a cancel may have led it off its path; zero else.
    pub(crate) stray: Length,
    /// The edge that was last in the way: mostly it still is, and is asked first.
    in_the_way: Cell<Option<Edge>>,
}

impl InFlight {
    pub(crate) fn new(interpolation: Interpolation, resolution: Length, checked: bool) -> Self {
        Self {
            interpolation,
            resolution,
            checked,
            confirmed: None,
            before: None,
            lines: VecDeque::with_capacity(LINES_MAX),
            left_queue: VecDeque::with_capacity(SEEN_MAX),
            left_before: 0,
            executed: 0,
            refused: 0,
            rests_seen: 0,
            rested_at: None,
            fastest: 0,
            cancelled: None,
            stray: Length::ZERO,
            in_the_way: Cell::new(None),
        }
    }

    pub(crate) fn points(&self) -> impl Iterator<Item = FreePoint> + Clone + '_ {
        self.points_up_to(self.lines.len())
    }

    /// Where the tool was last seen and the targets of the first `count` lines.
    fn points_up_to(&self, count: usize) -> impl Iterator<Item = FreePoint> + Clone + '_ {
        let lines = self.lines.iter().take(count).map(|line| line.target);
        self.before.into_iter().chain(self.confirmed).chain(lines)
    }

    pub(crate) fn place(&mut self, confirmed: Option<FreePoint>) {
        self.confirmed = confirmed;
        self.before = None;
        self.lines.clear();
        self.left_queue.clear();
        self.left_before = 0;
        self.refused = 0;
        self.fastest = 0;
        self.cancelled = None;
        self.stray = Length::ZERO;
        self.moving();
    }

    /// A line was sent: what was seen at rest is no evidence any more.
    pub(crate) fn moving(&mut self) {
        self.rests_seen = 0;
        self.rested_at = None;
    }

    /// The convex hull of the set; `None` without points.
    pub(crate) fn hull(&self) -> Option<Hull> {
        Hull::of(self.points().map(FreePoint::point))
    }

    /// Certifies that the hull stays clear when `to` is taken into the set. `hull` is that of the set as it is.
    pub(crate) fn admit(
        &self,
        part: &ProhibitedRegion,
        hull: Option<&Hull>,
        confirmed: FreePoint,
        to: Point,
    ) -> Result<FreePoint, Refusal> {
        let outcome = match self.interpolation {
            Interpolation::Linear => self.admit_line(part, hull, confirmed, to),
            Interpolation::Independent => {
                let points = self.points().map(FreePoint::point);
                let window = points.fold(Window::of(to), Window::including);
                clear_box(part, confirmed, window).and_then(|()| part.motion(confirmed, to))
            }
        };
        if let Err(Blocked::ByEdge(edge)) = outcome {
            self.in_the_way.set(Some(edge));
        }
        outcome.map_err(Refusal::Blocked)
    }

    /// The new hull, that of the old one and the new target, is clear, all of it. The points carry one threshold: that of the
    /// confirmed.
    fn admit_line(
        &self,
        part: &ProhibitedRegion,
        hull: Option<&Hull>,
        confirmed: FreePoint,
        to: Point,
    ) -> Result<FreePoint, Blocked> {
        let threshold = confirmed.threshold();
        if let Some(other) = self.points().find(|free| free.threshold() != threshold) {
            return Err(Blocked::StartTooNear(other.point()));
        }
        let unknown = Blocked::StartTooNear(confirmed.point());
        let hull = hull.ok_or(unknown)?;
        // What was last in the way mostly still is: the ways from the old corners to the target lie in the new hull.
        let near = |edge: &Edge, from: Point| !edge.near_motion(Segment { from, to }, threshold).is_clear();
        let still = |edge: &Edge| hull.sides().any(|(from, _)| near(edge, from));
        if let Some(edge) = self.in_the_way.get().filter(still) {
            return Err(Blocked::ByEdge(edge));
        }
        let hull = hull.with(to).ok_or(unknown)?;
        part.polygon(confirmed, hull.polygon().ok_or(unknown)?, to)
    }

    /// The point of the hull nearest to the reported position, as a certified confirmed.
    fn snap(&self, part: &ProhibitedRegion, position: Point) -> Snap {
        let Some(foot) = self.nearest_in_set(position) else { return Snap::Off };
        let believed = self.resolutions(BELIEVED).saturating_plus(Length::small(1));
        if points_within(foot, position, believed).is_clear() {
            return Snap::Off;
        }
        // The foot may be rounded into the threshold: its neighbours are as good.
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| Vector { dx, dy }));
        let tries = core::iter::once(Vector { dx: 0, dy: 0 }).chain(around);
        let mut places = tries.filter_map(|step| foot.translated(step).ok());
        places.find_map(|place| self.reached(part, place)).map_or(Snap::Keep, Snap::At)
    }

    pub(crate) fn resolutions(&self, count: i64) -> Length {
        Length::from_units(i64::from(self.resolution.units()) * count).unwrap_or(self.resolution)
    }

    /// The place of the set nearest to `position`.
    pub(crate) fn nearest_in_set(&self, position: Point) -> Option<Point> {
        self.nearest(position, self.lines.len())
    }

    /// The place nearest to `position` in the hull of these.
    fn nearest(&self, position: Point, count: usize) -> Option<Point> {
        match self.interpolation {
            Interpolation::Linear => {
                let hull = Hull::of(self.points_up_to(count).map(FreePoint::point));
                hull.and_then(|hull| hull.nearest(position))
            }
            Interpolation::Independent => self.window(count).and_then(|window| nearest_in(window, position)),
        }
    }

    fn window(&self, count: usize) -> Option<Window> {
        self.points_up_to(count).map(|free| Window::of(free.point())).reduce(Window::union)
    }

    /// The place as a free point, when the way to it from one of the points is clear. One way is enough: which one the tool
    /// took was certified before. A confirmed that was rounded can have lost its way to a far target by a unit.
    pub(crate) fn reached(&self, part: &ProhibitedRegion, place: Point) -> Option<FreePoint> {
        self.points().find_map(|point| part.motion(point, place).ok())
    }

    /// Takes a report as evidence; `all` says whether all lines ever sent were acknowledged before the query left. Answers
    /// whether the tool is known to rest at the confirmed, with nothing else in the set.
    pub(crate) fn reported(
        &mut self,
        part: &ProhibitedRegion,
        feedback: &PositionFeedback,
        all: bool,
        acknowledged: u64,
        (asked, now): (Time, Time),
    ) -> Result<bool, Refusal> {
        let rests = feedback.rests() && all;
        if self.stray > Length::ZERO {
            return self.reported_after_cancel(part, feedback.position, rests);
        }
        let confirmed = match self.snap(part, feedback.position) {
            Snap::At(confirmed) => confirmed,
            Snap::Keep => return Ok(false),
            Snap::Off => return Err(Refusal::OffCertified(feedback.position)),
        };
        let passed = if rests { 0 } else { self.passed(feedback.position, asked) };
        self.before = self.confirmed.filter(|_| !self.checked);
        self.confirmed = Some(confirmed);
        if rests {
            return Ok(self.settle(part, feedback.position));
        }
        self.moving();
        self.lines.retain(|line| line.number > passed);
        self.take_count(feedback, acknowledged, now);
        Ok(false)
    }

    fn settle(&mut self, part: &ProhibitedRegion, position: Point) -> bool {
        let near = |other: Point| !points_within(other, position, self.resolution).is_clear();
        let arrived = self.lines.back().is_none_or(|line| near(line.target.point()));
        let again = self.rests_again(position);
        let enough = again || self.checked && arrived;
        if enough {
            self.before = None;
            self.lines.clear();
            self.left_queue.clear();
            self.refused = 0;
            self.fastest = 0;
            self.cancelled = None;
            self.confirmed = self.reached(part, position).or(self.confirmed);
        }
        enough
    }

    /// Counts a report at rest; whether the one before it was at rest at the same place, to the resolution.
    pub(crate) fn rests_again(&mut self, position: Point) -> bool {
        let near = |other: Point| !points_within(other, position, self.resolution).is_clear();
        let again = self.rested_at.is_some_and(near);
        self.rests_seen = if again { self.rests_seen.saturating_add(1) } else { 1 };
        self.rested_at = Some(position);
        self.rests_seen >= 2
    }

    /// The last of the lines that are executed: with `q` motions in the queue, all acknowledged lines but the last `q` have left
    /// it; those that had left it at a report that arrived [`DRAIN`] before this query left have ended. And, should the clock
    /// have jumped meanwhile, they stay until the tool is seen where it can not be before a later line was begun.
    fn passed(&mut self, position: Point, asked: Time) -> u64 {
        let before = self.executed;
        while let Some(&(number, arrived)) = self.left_queue.front()
            && asked >= arrived.after(DRAIN)
        {
            self.executed = number;
            self.left_queue.pop_front();
        }
        // Without a checksum the line stays until both places that are remembered were reported after it was executed.
        let certain = if self.checked { self.executed } else { before };
        let count = self.lines.iter().take_while(|line| line.number <= certain).count();
        let passed = (0..count).take_while(|&last| self.is_beyond(position, last + 1)).last();
        passed.map_or(0, |last| self.lines[last].number)
    }

    /// Whether the tool is where it can not be before a line behind the first `count` was begun.
    fn is_beyond(&self, position: Point, count: usize) -> bool {
        let reach = self.resolutions(BEYOND).saturating_plus(Length::small(2));
        let nearest = self.nearest(position, count);
        nearest.is_some_and(|place| points_within(place, position, reach).is_clear())
    }

    /// What a report says of the queue. A line that was refused, and yet is in the queue, is not one of those that left it.
    fn take_count(&mut self, feedback: &PositionFeedback, acknowledged: u64, now: Time) {
        let Some(queued) = feedback.queued else { return };
        let kept = u64::try_from(queued).unwrap_or(u64::MAX).saturating_add(self.refused);
        let left = acknowledged.saturating_sub(kept);
        let believed = if self.checked { left } else { left.min(self.left_before) };
        self.left_before = left;
        let news = self.left_queue.back().map_or(believed > 0, |&(known, _)| believed > known);
        if news && self.left_queue.len() < SEEN_MAX {
            self.left_queue.push_back((believed, now));
        }
    }
}

impl PositionFeedback {
    /// At rest, with nothing left to do.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.in_position && !self.waiting && self.queued.is_none_or(|queued| queued == 0)
    }
}

/// What becomes of the confirmed when a position is reported.
enum Snap {
    /// It is here.
    At(FreePoint),
    /// The position is in the set, but no clear lattice point was found for it: the confirmed stays where it was.
    Keep,
    /// The position is outside the set.
    Off,
}

fn nearest_in(window: Window, position: Point) -> Option<Point> {
    let (x0, y0, x1, y1) = window.corners();
    let (x, y) = (position.x.units().clamp(x0, x1), position.y.units().clamp(y0, y1));
    Point::from_units(x.into(), y.into()).ok()
}

/// Certifies that a box is clear, at the threshold of a free point in it: no edge comes near it, so all of it is on that
/// point's side.
pub(crate) fn clear_box(part: &ProhibitedRegion, from: FreePoint, window: Window) -> Result<(), Blocked> {
    if !window.holds(from.point()) {
        return Err(Blocked::StartTooNear(from.point()));
    }
    match part.index().near_box(window, from.threshold()) {
        Some(edge) => Err(Blocked::ByEdge(*edge)),
        None => Ok(()),
    }
}

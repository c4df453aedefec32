//! TRUSTED. The in-flight set: the confirmed position of the tool, and every target that the controller may
//! still execute. Implements SR-07, SR-08, SR-09, SR-13.
//!
//! **Invariant.** The hull of the set is clear of the part at the threshold of its points. For a controller
//! that drives straight ([`Interpolation::Linear`]) it is the convex hull. For one with non-interpolated axes
//! ([`Interpolation::Independent`]) it is the smallest box along the axes. In both cases a motion from a
//! point of the hull to a target in the set stays in the hull.
//!
//! **Height.** The tool is a cylinder from its tip upward. The set keeps the lowest height of its places, and
//! the hull is clear of everything that stands above that height, less the height margin. The tool moves from
//! a height to the height of a target, so it comes no lower (`lowest_height_suffices`). The lowest height
//! rises only when a place leaves the set by evidence. A rise needs no query: what is clear at a height is
//! clear above it (`levels_are_monotone`).
//!
//! **Position error.** Let e be the resolution: the greatest distance of a report from the commanded position
//! of the tool. The guard believes a report up to 2e from the hull. The nearest point of the hull becomes the
//! confirmed position, which is then at most 3e from the tool. The next motion begins at the tool and leads
//! to a target in the set, so it brings the tool no farther from the hull. At rest, the report itself becomes
//! the confirmed position if it is free. It is at most e from the tool, so errors do not add up.
//!
//! The margin M covers e. The distance that jogs keep beyond M covers the other 2e, because it is at least
//! 2e. A report changes the confirmed height only upward from the lowest height. So the tip is never more than
//! the resolution of heights below the lowest height, and the height margin holds this term. Rounding to the
//! lattice moves a nearest point by less than a unit. Each comparison of distances adds a
//! unit for each rounding, and the margin has a term for the lattice.

use alloc::collections::VecDeque;
use core::cell::Cell;
use core::time::Duration;

use keepout_kernel::exact::segment::{Window, points_within};
use keepout_kernel::{
    Blocked, Edge, FreePoint, Height, Length, Levels, Place, Point, ProhibitedRegion, Segment, Vector,
};

use crate::evidence::Evidence;
use crate::hull::Hull;
use crate::rest::Rest;
use crate::{FreePlace, HeightRules, Interpolation, Refusal, Rules, Time, clear_box};

#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) number: u64,
    pub(crate) target: FreePlace,
}

/// Greatest number of lines in flight.
pub(crate) const LINES_MAX: usize = 12;
/// Greatest number of reports kept while lines wait for their completion.
const SEEN_MAX: usize = 64;
/// Greatest distance from the hull at which the guard believes a report, in resolutions. One is for this
/// report, and one for the report that gave the confirmed position.
pub(crate) const BELIEVED: i64 = 2;
/// Greatest distance of a report from the hull of the first lines while the tool has begun no later line, in
/// resolutions.
pub(crate) const BEYOND: i64 = 4;
/// Time within which the controller executes a block that has left its planner queue.
///
/// GRBL's stepper buffer holds six segments. A segment lasts 10 ms, or one step when a step takes longer. At
/// 1 mm/s and 20 steps/mm the six segments last 300 ms.
pub const DRAIN: Duration = Duration::from_millis(500);

/// The in-flight set. It allocates no memory after [`InFlight::new`].
#[derive(Clone, Debug)]
pub(crate) struct InFlight {
    pub(crate) interpolation: Interpolation,
    /// Greatest distance of a reported position from the commanded position.
    pub(crate) resolution: Length,
    /// Whether a checksum protects reports. One report is then evidence. Without a checksum the guard needs
    /// two, because damage can turn a report into another valid report.
    pub(crate) checked: bool,
    /// The rules of the third axis.
    pub(crate) heights: HeightRules,
    /// The confirmed position: where the tool was at the last report. `None` while the position is unknown.
    pub(crate) confirmed: Option<FreePlace>,
    /// The confirmed position before that one. `None` with a checksum, because one report is then evidence.
    pub(crate) before: Option<FreePlace>,
    pub(crate) lines: VecDeque<Line>,
    /// Lines up to this number had left the queue when a report arrived at this time. Both ascend.
    pub(crate) left_queue: VecDeque<(u64, Time)>,
    /// Lines up to this number had left the queue by the last report.
    pub(crate) left_before: u64,
    /// Lines up to this number were executed when the query of the last report left.
    pub(crate) executed: u64,
    /// Number of rejected lines since the tool was last in position. A duplicate of one may still arrive and
    /// be accepted.
    pub(crate) refused: u64,
    /// The last report at rest. `None` after a motion.
    pub(crate) rest: Option<Rest>,
    /// Highest feed of a line since the tool was last in position, mm/min.
    pub(crate) fastest: u32,
    /// Number of lines sent when the last cancel left. `None` without a cancel since the tool was last in
    /// position.
    pub(crate) cancelled: Option<u64>,
    /// Greatest distance of the tool from the hull after a cancel that may have led it off its path.
    /// Otherwise zero.
    pub(crate) stray: Length,
    /// The edge that blocked the last refused target, and its level. The guard checks it first, because it
    /// mostly blocks again.
    in_the_way: Cell<Option<(Edge, u16)>>,
}

impl InFlight {
    pub(crate) fn new(rules: &Rules) -> Self {
        Self {
            interpolation: rules.interpolation,
            resolution: rules.resolution,
            checked: rules.checked,
            heights: rules.heights,
            confirmed: None,
            before: None,
            lines: VecDeque::with_capacity(LINES_MAX),
            left_queue: VecDeque::with_capacity(SEEN_MAX),
            left_before: 0,
            executed: 0,
            refused: 0,
            rest: None,
            fastest: 0,
            cancelled: None,
            stray: Length::ZERO,
            in_the_way: Cell::new(None),
        }
    }

    pub(crate) fn places(&self) -> impl Iterator<Item = FreePlace> + Clone + '_ {
        self.places_up_to(self.lines.len())
    }

    /// The confirmed positions and the targets of the first `count` lines.
    pub(crate) fn places_up_to(&self, count: usize) -> impl Iterator<Item = FreePlace> + Clone + '_ {
        let lines = self.lines.iter().take(count).map(|line| line.target);
        self.before.into_iter().chain(self.confirmed).chain(lines)
    }

    /// The lowest height of the set. `None` while the position is unknown.
    pub(crate) fn lowest(&self) -> Option<Height> {
        self.places().map(FreePlace::height).min()
    }

    /// The prohibited region for a set whose lowest height is `lowest`.
    pub(crate) fn region<'a>(&self, levels: &'a Levels, lowest: Height) -> &'a ProhibitedRegion {
        levels.at(self.heights.certified_for(lowest))
    }

    /// The prohibited region of the present set.
    pub(crate) fn present<'a>(&self, levels: &'a Levels) -> &'a ProhibitedRegion {
        self.region(levels, self.lowest().unwrap_or(Height::LOWEST))
    }

    pub(crate) fn place(&mut self, confirmed: Option<FreePlace>) {
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

    /// Drops the reports at rest. They are no evidence after a new line or a report in motion.
    pub(crate) fn moving(&mut self) {
        self.rest = None;
    }

    /// The convex hull of the set. `None` without points, and when [`Hull::of`] fails.
    pub(crate) fn hull(&self) -> Option<Hull> {
        Hull::of(self.places().map(FreePlace::point))
    }

    /// Certifies that the hull of the set and `to` is clear of what stands above the lowest height of both.
    /// `hull` is the hull of the present set.
    pub(crate) fn admit(
        &self,
        levels: &Levels,
        hull: Option<&Hull>,
        confirmed: FreePlace,
        to: Place,
    ) -> Result<FreePlace, Refusal> {
        let lowest = self.lowest().map_or(to.height, |lowest| lowest.min(to.height));
        let part = self.region(levels, lowest);
        let start = at_level(part, confirmed.free).map_err(Refusal::Blocked)?;
        let outcome = match self.interpolation {
            Interpolation::Linear => self.admit_line(part, hull, start, to.point),
            Interpolation::Independent => {
                let points = self.places().map(FreePlace::point);
                let window = points.fold(Window::of(to.point), Window::including);
                clear_box(part, start, window).and_then(|()| part.motion(start, to.point))
            }
        };
        if let Err(Blocked::ByEdge(edge)) = outcome {
            self.in_the_way.set(Some((edge, part.level())));
        }
        let free = outcome.map_err(Refusal::Blocked)?;
        Ok(FreePlace { free, height: to.height })
    }

    /// The last target at a greater height. It needs no query: the set stays the same but for its heights, and
    /// its lowest height does not fall.
    pub(crate) fn admit_rise(&self, confirmed: FreePlace, height: Height) -> Result<FreePlace, Refusal> {
        let end = self.lines.back().map_or(confirmed, |line| line.target);
        if height <= end.height { Err(Refusal::NoRise(height)) } else { Ok(FreePlace { height, ..end }) }
    }

    /// Certifies the hull of the old hull and the new target, all of it. The points of the set must have one
    /// threshold: that of the confirmed position.
    fn admit_line(
        &self,
        part: &ProhibitedRegion,
        hull: Option<&Hull>,
        start: FreePoint,
        to: Point,
    ) -> Result<FreePoint, Blocked> {
        let threshold = start.threshold();
        if let Some(other) = self.places().find(|place| place.threshold() != threshold) {
            return Err(Blocked::StartTooNear(other.point()));
        }
        let unknown = Blocked::StartTooNear(start.point());
        let hull = hull.ok_or(unknown)?;
        // The last blocking edge mostly blocks again. The motions from the old corners to the target lie in
        // the new hull, so an edge near one of them blocks the hull. An edge of another level may be none of
        // this level.
        let near = |edge: &Edge, from: Point| !edge.near_motion(Segment { from, to }, threshold).is_clear();
        let still = |edge: &Edge| hull.sides().any(|(from, _)| near(edge, from));
        let known = self.in_the_way.get().filter(|&(_, level)| level == part.level());
        if let Some(edge) = known.map(|(edge, _)| edge).filter(still) {
            return Err(Blocked::ByEdge(edge));
        }
        let hull = hull.with(to).ok_or(unknown)?;
        part.polygon(start, hull.polygon().ok_or(unknown)?, to)
    }

    /// The point of the hull nearest to the reported position, certified as the new confirmed position.
    fn snap(&self, part: &ProhibitedRegion, position: Place) -> Snap {
        let Some(foot) = self.nearest_in_set(position.point) else { return Snap::Off };
        let believed = self.resolutions(BELIEVED).saturating_plus(Length::small(1));
        if points_within(foot, position.point, believed).is_clear() {
            return Snap::Off;
        }
        let beyond = self.height_beyond(position.height, self.lines.len());
        if beyond > i64::from(self.heights.resolution.units()) * BELIEVED {
            return Snap::Off;
        }
        let height = self.confirmed_height(position.height);
        // Rounding can put the foot inside the threshold. A neighbour on the lattice then serves as well.
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| Vector { dx, dy }));
        let tries = core::iter::once(Vector { dx: 0, dy: 0 }).chain(around);
        let mut places = tries.filter_map(|step| foot.translated(step).ok());
        let free = places.find_map(|place| self.reached(part, place));
        free.map_or(Snap::Keep, |free| Snap::At(FreePlace { free, height }))
    }

    /// The height that a report confirms: the reported one, but not below the lowest height of the set.
    pub(crate) fn confirmed_height(&self, reported: Height) -> Height {
        self.lowest().map_or(reported, |lowest| lowest.max(reported))
    }

    /// Distance of the height from the heights of the confirmed positions and the first `count` targets,
    /// lattice units. Zero between them.
    fn height_beyond(&self, height: Height, count: usize) -> i64 {
        let heights = || self.places_up_to(count).map(|place| i64::from(place.height.units()));
        let height = i64::from(height.units());
        let below = heights().min().map_or(0, |lowest| lowest - height);
        below.max(heights().max().map_or(0, |highest| height - highest)).max(0)
    }

    pub(crate) fn resolutions(&self, count: i64) -> Length {
        Length::from_units(i64::from(self.resolution.units()) * count).unwrap_or(self.resolution)
    }

    /// Takes a report as evidence. `all` states whether the controller acknowledged every line before the
    /// query left.
    ///
    /// Returns whether the tool is certainly at rest at the confirmed position. The set then holds only that
    /// position.
    pub(crate) fn reported(&mut self, levels: &Levels, evidence: &Evidence<'_>) -> Result<bool, Refusal> {
        let feedback = evidence.feedback;
        if self.stray > Length::ZERO {
            return self.reported_after_cancel(levels, evidence);
        }
        let part = self.present(levels);
        let confirmed = match self.snap(part, feedback.position) {
            Snap::At(confirmed) => confirmed,
            Snap::Keep => return Ok(false),
            Snap::Off => return Err(Refusal::OffCertified(feedback.position.point)),
        };
        let rests = evidence.rests();
        let passed = if rests { 0 } else { self.passed(feedback.position, evidence.asked) };
        self.before = self.confirmed.filter(|_| !self.checked);
        self.confirmed = Some(confirmed);
        if rests {
            return Ok(self.settle(part, evidence));
        }
        self.moving();
        self.lines.retain(|line| line.number > passed);
        self.take_count(evidence);
        Ok(false)
    }

    /// Number of the last completed line, or zero.
    ///
    /// With `q` motions in the queue, all acknowledged lines but the last `q` have left it. A line is
    /// executed if it had left the queue at a report that arrived [`DRAIN`] before this query left. The clock
    /// may have jumped in that time. So the line stays until the tool is reported where it can be only after
    /// a later line has begun.
    fn passed(&mut self, position: Place, asked: Time) -> u64 {
        let before = self.executed;
        while let Some(&(number, arrived)) = self.left_queue.front()
            && asked >= arrived.after(DRAIN)
        {
            self.executed = number;
            self.left_queue.pop_front();
        }
        // Without a checksum, the line stays until both confirmed positions were reported after its
        // execution.
        let certain = if self.checked { self.executed } else { before };
        let count = self.lines.iter().take_while(|line| line.number <= certain).count();
        let passed = (0..count).take_while(|&last| self.is_beyond(position, last + 1)).last();
        passed.map_or(0, |last| self.lines[last].number)
    }

    /// Whether the tool is where it can be only after a line behind the first `count` has begun.
    fn is_beyond(&self, position: Place, count: usize) -> bool {
        let reach = self.resolutions(BEYOND).saturating_plus(Length::small(2));
        let nearest = self.nearest(position.point, count);
        let aside = nearest.is_some_and(|place| points_within(place, position.point, reach).is_clear());
        let height_reach = i64::from(self.heights.resolution.units()) * BEYOND + 2;
        aside || self.height_beyond(position.height, count) > height_reach
    }

    /// Takes the queue length from a report. A rejected line does not count as one that left the queue,
    /// because its duplicate may be in the queue.
    fn take_count(&mut self, evidence: &Evidence<'_>) {
        let Some(queued) = evidence.feedback.queued else { return };
        let kept = u64::try_from(queued).unwrap_or(u64::MAX).saturating_add(self.refused);
        let left = evidence.acknowledged.saturating_sub(kept);
        let believed = if self.checked { left } else { left.min(self.left_before) };
        self.left_before = left;
        let news = self.left_queue.back().map_or(believed > 0, |&(known, _)| believed > known);
        if news && self.left_queue.len() < SEEN_MAX {
            self.left_queue.push_back((believed, evidence.now));
        }
    }
}

/// The effect of a report on the confirmed position.
enum Snap {
    /// The confirmed position moves to this place.
    At(FreePlace),
    /// The confirmed position stays. The reported position is near enough to the hull, but no lattice point
    /// there is clear.
    Keep,
    /// The reported position is too far from the hull.
    Off,
}

/// The free point as one of this region. A certificate of a higher level does not hold here, so the
/// region certifies the point again.
pub(crate) fn at_level(part: &ProhibitedRegion, from: FreePoint) -> Result<FreePoint, Blocked> {
    if from.level() < part.level() { part.free_point(from.point(), from.threshold()) } else { Ok(from) }
}

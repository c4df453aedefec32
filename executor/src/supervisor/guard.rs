//! TRUSTED. The guard: the in-flight set, and the only maker of [`Certified`] motions.
//!
//! **In-flight set.** The tail (where the tool was last known to be) and the target of every line that may still be
//! executed. **Invariant:** its convex hull is clear of the part at the manual threshold. A new target `t` is admitted
//! only if for every two points `a`, `b` of the set the triangle `a b t` is clear. Every point of the new hull lies in
//! the old hull or on a segment from `t` to its boundary, and the boundary consists of segments `a b`: so the new hull
//! is clear, and the invariant holds again.
//!
//! **Why that is enough.** A straight motion from a point of a convex set to a target in the set stays in the set.
//! Lines lost, repeated, reordered, cancelled half-way and planned from wherever the tool stopped are such motions,
//! however long each takes. So nothing here depends on latency.
//!
//! **Leaving the set.** A target leaves only by evidence, see [`Guard::reported`].
//!
//! **Contouring** is different: its motions run along the part, and hulls would cut through it. There each motion
//! begins where the one before it ended, and is sent only after the one before it was acknowledged, so none can be
//! skipped.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_kernel::exact::segment::{Window, distance_2, points_within};
use keepout_kernel::offset::{Gouge, certify_path};
use keepout_kernel::{Blocked, Curve, FreePoint, Length, Point, ProhibitedRegion, Segment, Triangle, Vector};
use thiserror::Error;

use crate::time::Time;

/// A motion that the guard has certified. Only the guard makes one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certified {
    motion: Motion,
}

/// A motion of the tool centre, in drawing coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Straight from wherever the tool is; can be cancelled.
    Jog {
        /// The target.
        to: Point,
        /// Feed, mm/min.
        feed_mm_min: u32,
    },
    /// The next motion of a contour.
    Contour {
        /// The line or arc, beginning where the one before ended.
        curve: Curve,
        /// Feed, mm/min.
        feed_mm_min: u32,
    },
}

impl Certified {
    /// The motion.
    #[must_use]
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Where it ends.
    #[must_use]
    pub fn target(&self) -> Point {
        match &self.motion {
            Motion::Jog { to, .. } => *to,
            Motion::Contour { curve, .. } => curve.to(),
        }
    }
}

/// Why the guard refuses.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Refusal {
    /// The part is in the way.
    #[error("{0}")]
    Blocked(Blocked),
    /// A motion of a contour comes too near the part.
    #[error("{0}")]
    Gouge(Gouge),
    /// The target is beyond the machine's travel.
    #[error("{} is beyond the machine's travel", keepout_planner::units::place(*.0))]
    BeyondStroke(Point),
    /// Where the tool is, is not known.
    #[error("where the tool is, is not known")]
    PositionUnknown,
    /// The tool is moving, or may be about to.
    #[error("motions are still under way")]
    InMotion,
    /// More targets in flight than are tracked.
    #[error("too many motions are under way")]
    Full,
    /// The motion is no longer than a step or two of the controller.
    #[error("the motion is shorter than the controller resolves")]
    TooShort,
    /// An arc so short that a controller can take it for a full circle.
    #[error("an arc at {} is too short for the controller to tell from a full circle", keepout_planner::units::place(*.0))]
    ArcTooShort(Point),
    /// An acknowledgement that belongs to no line.
    #[error("the controller acknowledged a line that was not sent")]
    UnexpectedAcknowledgement,
    /// The reported position lies outside everything that was certified.
    #[error("the tool is reported at {}, where nothing was sent to", keepout_planner::units::place(*.0))]
    OffCertified(Point),
}

/// What a status report says, as far as the guard is concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sighting {
    /// The reported position.
    pub position: Point,
    /// The controller says that it stands still and waits for commands.
    pub at_rest: bool,
    /// Blocks in the controller's planner; `None` when the report does not say.
    pub queued: Option<usize>,
}

/// How many lines had been sent and acknowledged when a query left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    sent: u64,
    acknowledged: u64,
    at: Time,
}

#[derive(Clone, Copy, Debug)]
struct Line {
    number: u64,
    target: FreePoint,
}

#[derive(Clone, Debug)]
struct Contour {
    curves: Vec<(Curve, u32)>,
    /// Motions handed out.
    sent: usize,
    /// The first motion on which the tool can still be.
    first: usize,
    /// The point at the end, already certified at the manual threshold.
    end: FreePoint,
}

/// Most lines in flight at once.
const LINES_MAX: usize = 8;
/// A block that has left the planner is executed within this time: six segments of 10 ms, or of a step each when that
/// is longer; at 1 mm/s and 20 steps/mm, 300 ms (GRBL's stepper buffer).
pub const DRAIN: Duration = Duration::from_millis(500);

/// The guard; see the module's documentation for what it promises.
#[derive(Debug)]
pub struct Guard {
    part: ProhibitedRegion,
    stroke: Window,
    manual: Length,
    finishing: Length,
    /// How far a reported position can be from the commanded one.
    resolution: Length,
    /// A jog shorter than this on both axes might be no block to the controller, and spoil the counting of blocks.
    shortest: Length,
    tail: Option<FreePoint>,
    lines: VecDeque<Line>,
    sent: u64,
    acknowledged: u64,
    /// Lines up to this number had left the planner when the report at this time arrived; both ascending.
    left_planner: VecDeque<(u64, Time)>,
    rests_seen: u8,
    contour: Option<Contour>,
    /// The planted fault of the test build: the set is the last reported position, and nothing else.
    #[cfg(test)]
    pub(crate) forget_in_flight: bool,
}

impl Guard {
    /// A guard for `part`: manual motions keep `manual`, contours keep `finishing`, targets stay inside `stroke`.
    /// `resolution` is how far a report can be from the commanded position, `shortest` is at least two steps.
    #[must_use]
    pub fn new(
        part: ProhibitedRegion,
        stroke: Window,
        manual: Length,
        finishing: Length,
        resolution: Length,
        shortest: Length,
    ) -> Self {
        Self {
            part,
            stroke,
            manual,
            finishing,
            resolution,
            shortest,
            tail: None,
            lines: VecDeque::new(),
            sent: 0,
            acknowledged: 0,
            left_planner: VecDeque::new(),
            rests_seen: 0,
            contour: None,
            #[cfg(test)]
            forget_in_flight: false,
        }
    }

    /// The part.
    #[must_use]
    pub fn part(&self) -> &ProhibitedRegion {
        &self.part
    }

    /// Forgets where the tool is: nothing is admitted until [`Guard::locate`].
    pub fn forget(&mut self) {
        self.tail = None;
        self.lines.clear();
        self.contour = None;
        self.left_planner.clear();
        self.rests_seen = 0;
        self.acknowledged = self.sent;
    }

    /// Takes the position of a machine that stands still with nothing under way, after connecting or homing.
    ///
    /// # Errors
    /// [`Refusal::Blocked`] when the tool stands in the prohibited region, [`Refusal::InMotion`] with lines in flight.
    pub fn locate(&mut self, position: Point) -> Result<(), Refusal> {
        if !self.lines.is_empty() || self.contour.is_some() {
            return Err(Refusal::InMotion);
        }
        self.tail = Some(self.part.free_point(position, self.manual).map_err(Refusal::Blocked)?);
        Ok(())
    }

    /// Where the tool is or will be once all lines are executed.
    #[must_use]
    pub fn end(&self) -> Option<FreePoint> {
        if let Some(contour) = &self.contour {
            return Some(contour.end);
        }
        self.lines.back().map(|line| line.target).or(self.tail)
    }

    /// Where the tool was last known to be, and the targets in flight, in order.
    pub fn in_flight(&self) -> impl Iterator<Item = Point> + '_ {
        self.tail.iter().map(|tail| tail.point()).chain(self.lines.iter().map(|line| line.target.point()))
    }

    /// Lines sent and not acknowledged.
    #[must_use]
    pub fn unacknowledged(&self) -> u64 {
        self.sent - self.acknowledged
    }

    /// Whether the tool stands still at a known place with nothing under way.
    #[must_use]
    pub fn settled(&self) -> bool {
        self.tail.is_some() && self.lines.is_empty() && self.contour.is_none()
    }

    /// Whether a jog to `to` would be admitted.
    ///
    /// # Errors
    /// [`Refusal`] saying why not.
    pub fn admits(&self, to: Point) -> Result<FreePoint, Refusal> {
        if self.contour.is_some() {
            return Err(Refusal::InMotion);
        }
        let tail = self.tail.ok_or(Refusal::PositionUnknown)?;
        if !self.stroke.holds(to) {
            return Err(Refusal::BeyondStroke(to));
        }
        if self.lines.len() >= LINES_MAX {
            return Err(Refusal::Full);
        }
        let way = to.minus(self.lines.back().map_or(tail, |line| line.target).point());
        if way.dx.abs().max(way.dy.abs()) < self.shortest.units() {
            return Err(Refusal::TooShort);
        }
        let mut admitted = self.part.motion(tail, to).map_err(Refusal::Blocked)?;
        let points: Vec<FreePoint> =
            std::iter::once(tail).chain(self.lines.iter().map(|line| line.target)).collect();
        for (i, &a) in points.iter().enumerate() {
            for &b in &points[i + 1..] {
                admitted = self.part.fan(a, b, to).map_err(Refusal::Blocked)?;
            }
        }
        Ok(admitted)
    }

    /// Certifies a jog to `to` and counts it as sent.
    ///
    /// # Errors
    /// [`Refusal`] saying why it may not be sent.
    pub fn jog(&mut self, to: Point, feed_mm_min: u32) -> Result<Certified, Refusal> {
        let target = self.admits(to)?;
        self.count_sent(target);
        Ok(Certified { motion: Motion::Jog { to, feed_mm_min } })
    }

    fn count_sent(&mut self, target: FreePoint) {
        self.sent += 1;
        self.rests_seen = 0;
        #[cfg(test)]
        if self.forget_in_flight {
            return;
        }
        self.lines.push_back(Line { number: self.sent, target });
    }

    /// Certifies a whole contour, which begins and ends at manual clearance, and takes it up.
    ///
    /// # Errors
    /// [`Refusal`] naming the motion that is not clear; nothing is taken up then.
    pub fn take_contour(&mut self, curves: Vec<(Curve, u32)>) -> Result<(), Refusal> {
        if !self.settled() {
            return Err(Refusal::InMotion);
        }
        let tail = self.tail.ok_or(Refusal::PositionUnknown)?;
        let path: Vec<Curve> = curves.iter().map(|&(curve, _)| curve).collect();
        let (Some(first), Some(last)) = (path.first(), path.last()) else {
            return Err(Refusal::PositionUnknown);
        };
        if first.from() != tail.point() {
            return Err(Refusal::OffCertified(first.from()));
        }
        if let Some(beyond) = self.beyond_stroke(&path) {
            return Err(Refusal::BeyondStroke(beyond));
        }
        if let Some(arc) = path.iter().find(|curve| is_arc_too_short(curve)) {
            return Err(Refusal::ArcTooShort(arc.from()));
        }
        certify_path(&self.part, self.finishing, &path).map_err(Refusal::Gouge)?;
        let end = self.part.free_point(last.to(), self.manual).map_err(Refusal::Blocked)?;
        self.contour = Some(Contour { curves, sent: 0, first: 0, end });
        Ok(())
    }

    fn beyond_stroke(&self, path: &[Curve]) -> Option<Point> {
        let slack = Length::small(200);
        path.iter().find_map(|curve| match curve.chord_points(slack) {
            Ok(points) => points.into_iter().find(|&point| !self.stroke.holds(point)),
            Err(_) => Some(curve.from()),
        })
    }

    /// The next motion of the contour, once the one before is acknowledged; counts it as sent.
    pub fn next_of_contour(&mut self) -> Option<Certified> {
        if self.unacknowledged() > 0 {
            return None;
        }
        let contour = self.contour.as_mut()?;
        let &(curve, feed_mm_min) = contour.curves.get(contour.sent)?;
        contour.sent += 1;
        self.sent += 1;
        self.rests_seen = 0;
        Some(Certified { motion: Motion::Contour { curve, feed_mm_min } })
    }

    /// Motions of the contour sent, and in all.
    #[must_use]
    pub fn contour_progress(&self) -> Option<(usize, usize)> {
        self.contour.as_ref().map(|contour| (contour.sent, contour.curves.len()))
    }

    /// Counts an acknowledgement of the oldest line.
    ///
    /// # Errors
    /// [`Refusal::UnexpectedAcknowledgement`] when none is outstanding.
    pub fn acknowledged(&mut self) -> Result<(), Refusal> {
        if self.unacknowledged() == 0 {
            return Err(Refusal::UnexpectedAcknowledgement);
        }
        self.acknowledged += 1;
        Ok(())
    }

    /// Takes back the only unacknowledged jog: the controller refused it, and will not execute it. Answers whether
    /// there was one.
    pub fn refused(&mut self) -> bool {
        if self.unacknowledged() != 1
            || self.contour.is_some()
            || self.lines.back().map(|line| line.number) != Some(self.sent)
        {
            return false;
        }
        self.lines.pop_back();
        self.sent -= 1;
        true
    }

    /// Whether the query of this stamp left before the newest acknowledged line: its answer can not be still to come.
    #[must_use]
    pub fn is_outdated(&self, stamp: &Stamp) -> bool {
        stamp.sent < self.acknowledged
    }

    /// The stamp of a query that leaves now.
    #[must_use]
    pub fn stamp(&self, now: Time) -> Stamp {
        Stamp { sent: self.sent, acknowledged: self.acknowledged, at: now }
    }

    /// Takes a report as evidence. `stamp` is that of the query it answers, or of an earlier one.
    ///
    /// *Settling:* the controller rests with an empty planner, every line ever sent was acknowledged before the query
    /// left, and either the tool is at the last target or two such reports agree. Then only the tail remains.
    ///
    /// *Retiring:* with `q` blocks in the planner, all acknowledged lines but the last `q` have left it. Lines that
    /// had left it at a report that arrived [`DRAIN`] before this query left are executed, and leave the set.
    ///
    /// # Errors
    /// [`Refusal::OffCertified`] when the position is outside the certified set by more than the resolution.
    pub fn reported(&mut self, sighting: &Sighting, stamp: Stamp, now: Time) -> Result<(), Refusal> {
        if self.contour.is_some() {
            return self.reported_in_contour(sighting, stamp);
        }
        if self.tail.is_none() {
            return Ok(());
        }
        #[cfg(test)]
        if self.forget_in_flight {
            self.tail = self.part.free_point(sighting.position, self.manual).ok().or(self.tail);
            return Ok(());
        }
        match self.snap(sighting.position) {
            Snap::At(tail) => self.tail = Some(tail),
            Snap::Keep => return Ok(()),
            Snap::Off => return Err(Refusal::OffCertified(sighting.position)),
        }
        if self.rests(sighting, stamp) {
            self.rests_seen = self.rests_seen.saturating_add(1);
            let last = self.lines.back().map(|line| line.target.point());
            let arrived =
                last.is_none_or(|last| !points_within(last, sighting.position, self.resolution).is_clear());
            if arrived || self.rests_seen >= 2 {
                self.lines.clear();
                self.left_planner.clear();
            }
            return Ok(());
        }
        self.rests_seen = 0;
        while let Some(&(number, arrived)) = self.left_planner.front()
            && stamp.at >= arrived.after(DRAIN)
        {
            self.lines.retain(|line| line.number > number);
            self.left_planner.pop_front();
        }
        if let Some(queued) = sighting.queued {
            let left = self.acknowledged.saturating_sub(u64::try_from(queued).unwrap_or(u64::MAX));
            if self.left_planner.back().is_none_or(|&(known, _)| left > known) {
                self.left_planner.push_back((left, now));
            }
        }
        Ok(())
    }

    fn rests(&self, sighting: &Sighting, stamp: Stamp) -> bool {
        // A line that was refused and taken back may still be counted in the stamp as sent.
        let all_acknowledged = stamp.sent >= self.sent && stamp.acknowledged == self.sent;
        sighting.at_rest && sighting.queued.is_none_or(|queued| queued == 0) && all_acknowledged
    }

    /// The point of the set's hull nearest to the reported position, as a certified tail. Where the tool was commanded
    /// to be lies in the hull, and projection onto a convex set brings nothing farther away: the tail is no farther
    /// from there than the report is.
    fn snap(&self, position: Point) -> Snap {
        let points: Vec<FreePoint> =
            self.tail.into_iter().chain(self.lines.iter().map(|line| line.target)).collect();
        let here = Segment { from: position, to: position };
        let holds = |corners| !Triangle { corners }.near_segment(here, Length::ZERO).is_clear();
        let mut nearest: Option<(i64, [FreePoint; 2], Point)> = None;
        for (i, &a) in points.iter().enumerate() {
            for (j, &b) in points.iter().enumerate().skip(i) {
                if points.iter().skip(j).any(|c| holds([a.point(), b.point(), c.point()])) {
                    return self.reached(&points, position).map_or(Snap::Keep, Snap::At);
                }
                let Some(foot) = project(position, Segment { from: a.point(), to: b.point() }) else {
                    continue;
                };
                let away_2 = distance_2(foot, position);
                if nearest.is_none_or(|(least_2, ..)| away_2 < least_2) {
                    nearest = Some((away_2, [a, b], foot));
                }
            }
        }
        let Some((_, ends, foot)) = nearest else { return Snap::Off };
        if points_within(foot, position, self.resolution).is_clear() {
            return Snap::Off;
        }
        // The foot is rounded, and may be rounded into the threshold: its neighbours are as good.
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| Vector { dx, dy }));
        let tries = std::iter::once(Vector { dx: 0, dy: 0 }).chain(around);
        let mut places = tries.filter_map(|step| foot.translated(step).ok());
        places.find_map(|place| self.reached(&ends, place)).map_or(Snap::Keep, Snap::At)
    }

    /// The place as a free point, when the way to it from one of the points is clear. One way is enough: which one the tool
    /// took was certified before. A tail that was rounded can have lost its way to a far target by a unit.
    fn reached(&self, from: &[FreePoint], place: Point) -> Option<FreePoint> {
        from.iter().find_map(|&point| self.part.motion(point, place).ok())
    }

    fn reported_in_contour(&mut self, sighting: &Sighting, stamp: Stamp) -> Result<(), Refusal> {
        let rests = self.rests(sighting, stamp);
        let resolution = self.resolution;
        let Some(contour) = self.contour.as_mut() else { return Ok(()) };
        let on = (contour.first..contour.sent.max(contour.first + 1).min(contour.curves.len()))
            .find(|&k| lies_on(sighting.position, &contour.curves[k].0, resolution));
        contour.first = on.ok_or(Refusal::OffCertified(sighting.position))?;
        let done = contour.sent == contour.curves.len();
        let arrived = !points_within(contour.end.point(), sighting.position, resolution).is_clear();
        if rests && done && arrived {
            self.tail = Some(contour.end);
            self.contour = None;
        }
        Ok(())
    }
}

/// Whether the ends of an arc are so near that a controller computing in 32-bit floats can mistake its sweep for a full
/// turn: GRBL adds one when the angle comes out below 5e-7.
fn is_arc_too_short(curve: &Curve) -> bool {
    let Curve::Arc(arc) = curve else { return false };
    let least = keepout_kernel::offset::shortest_arc(arc.radius());
    !points_within(arc.from(), arc.to(), least).is_clear()
}

/// What becomes of the tail when a position is reported.
enum Snap {
    /// It is here.
    At(FreePoint),
    /// The position is in the set, but no clear lattice point was found for it: the tail stays where it was.
    Keep,
    /// The position is outside the set.
    Off,
}

/// The lattice point nearest to the foot of the perpendicular from `p` on the segment, or the nearer end.
fn project(p: Point, segment: Segment) -> Option<Point> {
    let (d, w) = (segment.to.minus(segment.from), p.minus(segment.from));
    let product = |a: i32, b: i32| i128::from(a) * i128::from(b);
    let length_2 = product(d.dx, d.dx) + product(d.dy, d.dy);
    if length_2 == 0 {
        return Some(segment.from);
    }
    let along = (product(w.dx, d.dx) + product(w.dy, d.dy)).clamp(0, length_2);
    let part = |span: i32| {
        let twice = 2 * i128::from(span) * along + length_2;
        i64::try_from(twice.div_euclid(2 * length_2)).ok()
    };
    let (x, y) = (i64::from(segment.from.x.units()), i64::from(segment.from.y.units()));
    Point::from_units(x + part(d.dx)?, y + part(d.dy)?).ok()
}

/// Whether `p` lies on the curve, to `tolerance`; arcs are taken as chords within 2 µm.
fn lies_on(p: Point, curve: &Curve, tolerance: Length) -> bool {
    let slack = Length::small(200);
    let reach = tolerance.saturating_plus(slack).saturating_plus(slack);
    let points = curve.chord_points(slack).unwrap_or_default();
    points.windows(2).any(|pair| !Segment { from: pair[0], to: pair[1] }.near_point(p, reach).is_clear())
}

#[cfg(test)]
mod tests {
    use super::*;
    use keepout_kernel::{Region, Ring, Side};

    fn at(x: i64, y: i64) -> Point {
        Point::from_units(x, y).unwrap()
    }

    /// An L, in lattice units, and a guard that keeps 300 units from it.
    fn guard() -> Guard {
        let corners = [(0, 0), (9000, 0), (9000, 2500), (3000, 2500), (3000, 7000), (0, 7000)];
        let ring = Ring::new(corners.iter().map(|&(x, y)| at(x, y)).collect()).unwrap();
        let part = ProhibitedRegion::new(Region::new(vec![ring]).unwrap(), Side::Outside).unwrap();
        let stroke = Window::of(at(-20_000, -20_000)).including(at(20_000, 20_000));
        let length = |units| Length::from_units(units).unwrap();
        Guard::new(part, stroke, length(300), length(290), length(5), length(4))
    }

    /// The adversary executes lines in any order, any number of times, each only as far as it likes.
    #[test]
    fn no_execution_of_admitted_lines_comes_near_the_part() {
        let mut random = fastrand::Rng::with_seed(11);
        let (mut admitted, mut refused) = (0_u32, 0_u32);
        for _ in 0..400 {
            let mut guard = guard();
            guard.locate(at(-3000, random.i64(-3000..10_000))).unwrap();
            let mut tool = guard.end().unwrap().point();
            for _ in 0..6 {
                let target = at(random.i64(-4000..14_000), random.i64(-4000..11_000));
                match guard.jog(target, 600) {
                    Ok(_) => admitted += 1,
                    Err(_) => refused += 1,
                }
                let targets: Vec<Point> = guard.in_flight().collect();
                for _ in 0..12 {
                    let to = targets[random.usize(0..targets.len())];
                    let share = random.i64(0..=16);
                    let d = to.minus(tool);
                    let part = |d: i32| i64::from(d) * share / 16;
                    let next =
                        at(i64::from(tool.x.units()) + part(d.dx), i64::from(tool.y.units()) + part(d.dy));
                    // Rounding to the lattice moves the tool by a unit and more with every step.
                    let threshold = Length::from_units(300 - 12).unwrap();
                    let motion = Segment { from: tool, to: next };
                    guard.part().edges_clear(motion, threshold).unwrap();
                    tool = if random.bool() { next } else { to };
                    if tool == to {
                        guard.part().edges_clear(Segment { from: next, to }, threshold).unwrap();
                    }
                }
            }
        }
        assert!(admitted > 400 && refused > 400, "{admitted} admitted, {refused} refused");
    }

    #[test]
    fn without_a_position_nothing_is_admitted() {
        let mut guard = guard();
        assert_eq!(guard.jog(at(-1000, 0), 600), Err(Refusal::PositionUnknown));
        assert!(matches!(guard.locate(at(100, 100)), Err(Refusal::Blocked(_))));
        guard.locate(at(-1000, 0)).unwrap();
        assert_eq!(guard.jog(at(-30_000, 0), 600), Err(Refusal::BeyondStroke(at(-30_000, 0))));
        assert_eq!(guard.jog(at(-1003, -3), 600), Err(Refusal::TooShort));
        guard.jog(at(-1000, 900), 600).unwrap();
        assert!(guard.refused() && !guard.refused() && guard.settled(), "a refused jog is taken back");
        guard.jog(at(-1000, 900), 600).unwrap();
        assert_eq!(guard.locate(at(-1000, 0)), Err(Refusal::InMotion));
        guard.forget();
        assert_eq!(guard.jog(at(-1000, 0), 600), Err(Refusal::PositionUnknown));
    }

    fn sighting(position: Point, at_rest: bool, queued: usize) -> Sighting {
        Sighting { position, at_rest, queued: Some(queued) }
    }

    const MS: u64 = 1000;

    #[test]
    fn targets_leave_only_by_evidence() {
        let mut guard = guard();
        let time = |ms: u64| Time::from_micros(ms * MS);
        guard.locate(at(-1000, 0)).unwrap();
        let before = guard.stamp(time(0));
        guard.jog(at(-1000, 2000), 600).unwrap();
        // Reports at rest that were asked for before the line, or before its acknowledgement, prove nothing.
        for _ in 0..3 {
            guard.reported(&sighting(at(-1000, 0), true, 0), before, time(50)).unwrap();
            assert_eq!(guard.in_flight().count(), 2);
            let unacknowledged = guard.stamp(time(50));
            guard.reported(&sighting(at(-1000, 0), true, 0), unacknowledged, time(60)).unwrap();
            assert_eq!(guard.in_flight().count(), 2);
        }
        guard.acknowledged().unwrap();
        assert_eq!(guard.acknowledged(), Err(Refusal::UnexpectedAcknowledgement));
        guard.jog(at(-1000, 4000), 600).unwrap();
        guard.acknowledged().unwrap();
        // The first block has left the planner; it is executed for sure only after the drain time.
        let stamp = guard.stamp(time(100));
        guard.reported(&sighting(at(-1000, 1500), false, 1), stamp, time(120)).unwrap();
        assert_eq!(guard.in_flight().count(), 3);
        let stamp = guard.stamp(time(200));
        guard.reported(&sighting(at(-1000, 2100), false, 1), stamp, time(220)).unwrap();
        assert_eq!(guard.in_flight().count(), 3, "too early");
        let stamp = guard.stamp(time(700));
        guard.reported(&sighting(at(-1000, 2500), false, 1), stamp, time(720)).unwrap();
        assert_eq!(guard.in_flight().collect::<Vec<_>>(), [at(-1000, 2500), at(-1000, 4000)]);
        // At rest short of the target: once may be a report between two motions, twice is a stop.
        let stamp = guard.stamp(time(800));
        guard.reported(&sighting(at(-1000, 3000), true, 0), stamp, time(820)).unwrap();
        assert!(!guard.settled());
        let stamp = guard.stamp(time(900));
        guard.reported(&sighting(at(-1000, 3000), true, 0), stamp, time(920)).unwrap();
        assert!(guard.settled());
    }

    #[test]
    fn position_off_the_certified_set_is_refused() {
        let mut guard = guard();
        guard.locate(at(-1000, 0)).unwrap();
        guard.jog(at(-1000, 2000), 600).unwrap();
        let stamp = guard.stamp(Time::ZERO);
        assert!(guard.reported(&sighting(at(-1004, 500), false, 1), stamp, Time::ZERO).is_ok());
        let off = at(-1010, 500);
        assert_eq!(
            guard.reported(&sighting(off, false, 1), stamp, Time::ZERO),
            Err(Refusal::OffCertified(off))
        );
    }

    #[test]
    fn contour_is_certified_whole_and_handed_out_one_by_one() {
        let mut guard = guard();
        guard.locate(at(-310, 0)).unwrap();
        let line = |a, b| (Curve::Line(Segment { from: a, to: b }), 300);
        let (p, q, r) = (at(-310, 0), at(-301, 3000), at(-310, 6000));
        let gouge = vec![line(p, at(-280, 3000)), line(at(-280, 3000), r)];
        assert!(matches!(guard.take_contour(gouge), Err(Refusal::Gouge(gouge)) if gouge.index == 0));
        let jump = vec![line(q, r)];
        assert_eq!(guard.take_contour(jump), Err(Refusal::OffCertified(q)));
        guard.take_contour(vec![line(p, q), line(q, r)]).unwrap();
        assert_eq!(guard.next_of_contour().unwrap().target(), q);
        assert_eq!(guard.next_of_contour(), None, "not before the acknowledgement");
        assert_eq!(guard.jog(p, 600), Err(Refusal::InMotion));
        guard.acknowledged().unwrap();
        assert_eq!(guard.next_of_contour().unwrap().target(), r);
        guard.acknowledged().unwrap();
        let stamp = guard.stamp(Time::ZERO);
        guard.reported(&sighting(r, true, 0), stamp, Time::ZERO).unwrap();
        assert!(guard.settled());
        assert_eq!(guard.end().unwrap().point(), r);
    }

    /// The tail was rounded, and lost its straight way to the last target by a unit, as happens in sliding contact. At
    /// rest at the target the set must become the target all the same, or the tool could never move again.
    #[test]
    fn rest_at_a_target_is_settled_whatever_the_tail_sees() {
        let mut guard = guard();
        let time = Time::from_micros(MS);
        guard.locate(at(-301, -500)).unwrap();
        guard.jog(at(-301, 7200), 600).unwrap();
        guard.acknowledged().unwrap();
        // Rounded toward the wall, beyond the corner's reach: free, but the way along the wall is blocked.
        guard.tail = Some(guard.part().free_point(at(-280, -120), Length::from_units(300).unwrap()).unwrap());
        let tail = guard.tail.unwrap();
        assert!(guard.part().motion(tail, at(-301, 7200)).is_err());
        for _ in 0..2 {
            let stamp = guard.stamp(time);
            guard.reported(&sighting(at(-304, 7198), true, 0), stamp, time).unwrap();
        }
        assert!(guard.settled());
        guard.jog(at(-900, 7200), 600).unwrap();
    }
}

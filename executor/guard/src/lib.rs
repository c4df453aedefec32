//! TRUSTED. The guard: the in-flight set, and the only maker of [`Certified`] motions.
//!
//! A new target is admitted only if the hull of the in-flight set (`in_flight.rs`) with it stays clear of the part at the jogging_clearance
//! threshold. Straight motions from a point of a convex set to a target in the set stay in the set: lines lost, repeated,
//! reordered, cancelled half-way and planned from wherever the tool stopped are such motions, however long each takes. So
//! nothing here depends on latency. A target leaves the set only by evidence, see [`Guard::reported`].
//!
//! **Contouring** is different: its motions run along the part, and hulls would cut through it. There each motion
//! begins where the one before it ended, and is sent only after the one before it was acknowledged and a query that left
//! behind it was answered (acknowledgements can come twice), so none can be skipped. The whole path is certified before the first is
//! sent. A contour is never held or cancelled.
//!
//! **Reading:** a controller whose receive buffer is full drops bytes, and takes the head of one line and the confirmed of another
//! for a third. So no line is sent before it has read the one before for certain, whatever was acknowledged: one line of at most
//! 63 bytes fits the smallest buffer, GRBL's 127, even when it arrives twice. The dialect refuses to write a longer one.
//!
//! **Escaping:** a tool that stands nearer than the jogging_clearance threshold, but not in the part, is admitted single motions on
//! which it comes nearer to no edge within that threshold.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

extern crate alloc;

mod admission;
mod cancel;
mod contour;
mod hull;
mod in_flight;
mod motion;
mod open_space;
mod state;
#[cfg(test)]
mod tests;
mod time;

use alloc::sync::Arc;

pub use admission::{Admission, Admissions};
pub use cancel::OnCancel;
pub use contour::Certification;
use contour::Contour;
pub use hull::Hull;
pub use in_flight::{DRAIN, Interpolation, PositionFeedback, QueryStamp};
use in_flight::{InFlight, LINES_MAX, Line};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{FreePoint, Length, Point, ProhibitedRegion};
pub use motion::{Certified, CertifiedCancel, Motion, Refusal};
pub use open_space::guard_in_open_space;
pub use state::State;
pub use time::Time;

/// What a guard keeps to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Where the tool's centre may go: the machine's travel.
    pub travel: Window,
    /// Threshold of motions by hand.
    pub jogging_clearance: Length,
    /// Threshold of contours, as they are sent.
    pub finishing_clearance: Length,
    /// How far a reported position can be from the commanded one.
    pub resolution: Length,
    /// A jog shorter than this on both axes might be no motion to the controller, and spoil the counting of its queue: at
    /// least two steps.
    pub shortest: Length,
    /// How the controller drives to a jog's target, wherever the jog is cancelled.
    pub interpolation: Interpolation,
    /// What a cancel does.
    pub on_cancel: OnCancel,
    /// How it drives the motions of a contour: they are never cancelled, so this may be straighter.
    pub contours: Interpolation,
    /// Whether a checksum protects the line both ways.
    pub checked: bool,
}

/// The guard; see the module's documentation for what it promises. A copy serves exploration: two copies at one controller
/// promise nothing.
#[derive(Clone, Debug)]
pub struct Guard {
    exact: Arc<ProhibitedRegion>,
    /// The part with fewer edges, and a little larger: what is clear of it is clear of the part.
    simplified: Arc<ProhibitedRegion>,
    rules: Rules,
    set: InFlight,
    sent: u64,
    acknowledged: u64,
    /// Lines up to this number have left the controller's receive buffer.
    read: u64,
    /// Least deceleration of the axes, lattice units per s².
    deceleration: Option<u64>,
    contour: Option<Contour>,
}

impl Guard {
    /// A guard for `part`. `simplified` is the part itself, or [simplified](ProhibitedRegion::simplified): steering by
    /// hand is certified against it, contours and ways out against the part.
    #[must_use]
    pub fn new(part: Arc<ProhibitedRegion>, simplified: Arc<ProhibitedRegion>, rules: Rules) -> Self {
        Self {
            exact: part,
            simplified,
            set: InFlight::new(rules.interpolation, rules.resolution, rules.checked),
            rules,
            sent: 0,
            acknowledged: 0,
            read: 0,
            deceleration: None,
            contour: None,
        }
    }

    /// The part as steering by hand sees it.
    #[must_use]
    pub fn part(&self) -> &ProhibitedRegion {
        &self.simplified
    }

    /// What it keeps to.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// Forgets where the tool is: nothing is admitted until [`Guard::locate`].
    pub fn forget(&mut self) {
        self.set.place(None);
        self.contour = None;
        (self.acknowledged, self.read) = (self.sent, self.sent);
    }

    /// Takes the position of a machine that stands still with nothing under way, after connecting or homing. Nearer than the
    /// jogging_clearance threshold only [`Guard::retract`] and [`Guard::begin_contour`] lead on.
    ///
    /// # Errors
    /// [`Refusal::Blocked`] when the tool stands in the part itself, [`Refusal::InMotion`] with lines in flight.
    pub fn locate(&mut self, position: Point) -> Result<(), Refusal> {
        if !self.set.lines.is_empty() || self.contour.is_some() {
            return Err(Refusal::InMotion);
        }
        let place = self.free_place(position)?;
        self.set.place(Some(place));
        Ok(())
    }

    /// The point as free at the jogging_clearance threshold, or else at whatever distance the part is.
    fn free_place(&self, position: Point) -> Result<FreePoint, Refusal> {
        self.simplified.free_point(position, self.rules.jogging_clearance).or_else(|blocked| {
            let clearance = self.exact.clearance(position).ok_or(Refusal::Blocked(blocked))?;
            let below = Length::from_units(i64::from(self.rules.jogging_clearance.units()) - 1)
                .unwrap_or(Length::ZERO);
            self.exact.free_point(position, clearance.min(below)).map_err(Refusal::Blocked)
        })
    }

    /// Where the tool is or will be once all lines are executed.
    #[must_use]
    pub fn end(&self) -> Option<FreePoint> {
        if let Some(contour) = &self.contour {
            return Some(contour.end());
        }
        self.set.lines.back().map(|line| line.target).or(self.set.confirmed)
    }

    /// Where the tool was last known to be.
    #[must_use]
    pub fn confirmed(&self) -> Option<FreePoint> {
        self.set.confirmed
    }

    /// The in-flight set: where the tool was last known to be, and the targets in flight, in order.
    pub fn in_flight(&self) -> impl Iterator<Item = Point> + '_ {
        self.set.points().map(FreePoint::point)
    }

    /// Where the tool was last known to be, and the targets in flight of lines sent after the one of this number, in order.
    pub fn way_after(&self, number: u64) -> impl Iterator<Item = Point> + '_ {
        let lines = self.set.lines.iter().filter(move |line| line.number > number);
        self.set.confirmed.into_iter().chain(lines.map(|line| line.target)).map(FreePoint::point)
    }

    /// Lines sent, ever.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.sent
    }

    /// Lines sent and not acknowledged.
    #[must_use]
    pub fn unacknowledged(&self) -> u64 {
        self.sent - self.acknowledged
    }

    /// Lines sent that may still be in the controller's receive buffer. A checksum over each line keeps that from being mixed
    /// up.
    fn unread(&self) -> u64 {
        if self.rules.checked { 0 } else { self.sent - self.read }
    }

    /// Whether another line could be sent now.
    #[must_use]
    pub fn takes_lines(&self) -> bool {
        self.set.lines.len() < LINES_MAX && self.unread() == 0
    }

    /// Whether the next line waits for nothing but the answer to a query.
    #[must_use]
    pub fn awaits_reading(&self) -> bool {
        self.unacknowledged() == 0 && (self.unread() > 0 || self.has_stopped_early())
    }

    /// Whether the tool stands still at a known place with nothing under way.
    #[must_use]
    pub fn in_position(&self) -> bool {
        self.set.confirmed.is_some()
            && self.set.before.is_none()
            && self.set.lines.is_empty()
            && self.contour.is_none()
    }

    /// Whether the tool stands nearer to the part than the jogging_clearance threshold.
    #[must_use]
    pub fn is_inside_jogging_clearance(&self) -> bool {
        self.set.confirmed.is_some_and(|confirmed| confirmed.threshold() < self.rules.jogging_clearance)
    }

    /// Holds the guard for questions about jogs, and for the jog that follows.
    #[must_use]
    pub fn admissions(&mut self) -> Admissions<'_> {
        Admissions::of(self)
    }

    /// The confirmed position, when the guard can consider a motion to `to`.
    fn ready(&self, to: Point) -> Result<FreePoint, Refusal> {
        if self.contour.is_some() || self.set.stray > Length::ZERO {
            return Err(Refusal::InMotion);
        }
        let confirmed = self.set.confirmed.ok_or(Refusal::PositionUnknown)?;
        if !self.rules.travel.holds(to) {
            return Err(Refusal::SoftLimit(to));
        }
        if !self.takes_lines() {
            return Err(Refusal::Full);
        }
        let way = to.minus(self.set.lines.back().map_or(confirmed, |line| line.target).point());
        let short = way.dx.abs().max(way.dy.abs()) < self.rules.shortest.units();
        if short { Err(Refusal::TooShort) } else { Ok(confirmed) }
    }

    /// Certifies a jog to `to` and counts it as sent.
    ///
    /// # Errors
    /// [`Refusal`] saying why it may not be sent.
    pub fn jog(&mut self, to: Point, feed_mm_min: u32) -> Result<Certified, Refusal> {
        let admissions = self.admissions();
        let admission = admissions.admit(to)?;
        Ok(admissions.jog(admission, feed_mm_min))
    }

    /// Certifies a retract move to `to` and counts it as sent.
    ///
    /// # Errors
    /// [`Refusal`] saying why it may not be sent.
    pub fn retract(&mut self, to: Point, feed_mm_min: u32) -> Result<Certified, Refusal> {
        let admissions = self.admissions();
        let admission = admissions.admit_retract(to)?;
        Ok(admissions.jog(admission, feed_mm_min))
    }

    fn send_jog(&mut self, target: FreePoint, feed_mm_min: u32) -> Certified {
        self.sent += 1;
        self.set.moving();
        self.set.fastest = self.set.fastest.max(feed_mm_min);
        let line = Line { number: self.sent, target };
        self.set.lines.push_back(line);
        Certified { motion: Motion::Jog { to: target.point(), feed_mm_min } }
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

    /// Takes the answer that the only unacknowledged jog was refused, and answers whether there was one. Its target stays in the
    /// set until the controller rests: a line that arrives twice may be refused once.
    pub fn refused(&mut self) -> bool {
        if self.unacknowledged() != 1
            || self.contour.is_some()
            || self.set.lines.back().map(|line| line.number) != Some(self.sent)
        {
            return false;
        }
        self.acknowledged = self.sent;
        self.set.refused += 1;
        true
    }

    /// Whether the query of this stamp left before the newest acknowledged line: its answer can not be still to come.
    #[must_use]
    pub fn is_outdated(&self, stamp: &QueryStamp) -> bool {
        stamp.sent < self.acknowledged
    }

    /// The stamp of a query that leaves now.
    #[must_use]
    pub fn stamp(&self, now: Time) -> QueryStamp {
        QueryStamp { sent: self.sent, acknowledged: self.acknowledged, at: now }
    }

    /// Takes a report as evidence. `stamp` is that of the query it answers, or of an earlier one.
    ///
    /// *Reading:* nothing waits in the receive buffer: lines that left before the query have been read.
    ///
    /// *Settling:* the controller rests with an empty queue, every line ever sent was acknowledged before the query left,
    /// and two such reports agree (one at the last target, over a line with a checksum). Then only the confirmed remains.
    ///
    /// *Retiring:* with `q` motions in the queue, all acknowledged lines but the last `q` have left it. Lines that
    /// had left it at a report that arrived [`DRAIN`] before this query left are executed, and leave the set.
    ///
    /// # Errors
    /// [`Refusal::OffCertified`] when the position is outside the certified set by more than the resolution.
    pub fn reported(
        &mut self,
        feedback: &PositionFeedback,
        stamp: QueryStamp,
        now: Time,
    ) -> Result<(), Refusal> {
        let all = self.all_acknowledged(stamp);
        if !feedback.waiting {
            self.read = self.read.max(stamp.sent);
        }
        if self.contour.is_some() {
            return self.reported_in_contour(feedback, all);
        }
        if self.set.confirmed.is_none() {
            return Ok(());
        }
        let part = if self.is_inside_jogging_clearance() { &*self.exact } else { &*self.simplified };
        let in_position = self.set.reported(part, feedback, all, self.acknowledged, (stamp.at, now))?;
        if in_position
            && self.is_inside_jogging_clearance()
            && let Some(confirmed) = self.set.confirmed
        {
            self.set.confirmed = Some(self.free_place(confirmed.point()).unwrap_or(confirmed));
        }
        Ok(())
    }

    /// Whether every line ever sent was acknowledged before the query left.
    fn all_acknowledged(&self, stamp: QueryStamp) -> bool {
        stamp.acknowledged == self.sent
    }
}

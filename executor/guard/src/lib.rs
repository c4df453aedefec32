//! TRUSTED. The guard: it keeps the in-flight set, and it alone makes [`Certified`] motions.
//!
//! Implements SR-07, SR-08, SR-09, SR-10, SR-11, SR-14, SR-15.
//!
//! **Jogging.** The in-flight set holds the confirmed position of the tool and every target that the
//! controller may still execute (`in_flight.rs`). The guard admits a new target only if the hull of the set
//! and the target is clear of the part at the jogging clearance. The hull is convex: a straight motion from a
//! point of the hull to a target in it stays in the hull. Lines can be lost, repeated or reordered, and a
//! cancel can stop a jog half-way (`cancel.rs`). The next motion still begins in the hull and leads to a
//! target in it, however long each motion takes. So this argument does not depend on latency. A target leaves
//! the set only by evidence: see [`Guard::reported`].
//!
//! **Contouring.** A contour runs along the part, and the hull of its motions would cut into the part. So
//! each motion begins where the motion before it ended. The guard certifies the whole contour before it hands
//! out the first motion. It hands out the next motion only after the controller has acknowledged the motion
//! before it. Without a checksum, an acknowledgement can arrive twice. The guard then also waits for the
//! answer to a query that left after that motion. So the controller skips no motion. A contour is never held
//! or cancelled.
//!
//! **Reading.** A controller drops bytes when its receive buffer is full. It then takes the head of one line
//! and the tail of another for a third line. So, without a checksum, the guard waits until the controller has
//! read each line before it hands out the next one. An acknowledgement alone does not prove that the line was
//! read. The smallest buffer is GRBL's: 127 bytes. It holds a line of at most 63 bytes, even if the line
//! arrives twice. The dialect refuses to write a longer line.
//!
//! **Height.** Every certificate holds for a tool whose tip is at the lowest height of the in-flight set, less
//! the height margin: the prohibited region of that height is the union of everything that stands above it.
//! Lowering is certified like any motion. Rising is always permitted. The lowest height rises by evidence only.
//! The tool is a cylinder from its tip upward: shank and holder are outside this claim. A machine with two
//! axes has one level, and its tool stands at height zero.
//!
//! **Retracting.** When the tool is inside the jogging clearance but not in the part, the guard admits single
//! retract moves. On a retract move the tool comes nearer to no edge within the jogging clearance.
//!
//! A guard of a square of 10 mm. A jog along its side is certified, a jog through it is refused:
//!
//! ```
//! use std::sync::Arc;
//!
//! use keepout_guard::{Guard, HeightRules, Interpolation, OnCancel, Refusal, Rules};
//! use keepout_kernel::exact::lattice::UNITS_PER_MM;
//! use keepout_kernel::exact::segment::Window;
//! use keepout_kernel::{Length, Levels, Point, ProhibitedRegion, Region, Ring, Side};
//!
//! let mm = i64::from(UNITS_PER_MM);
//! let at = |x, y| Point::from_units(x * mm, y * mm).unwrap();
//! let length = |units| Length::from_units(units).unwrap();
//! let square = Ring::new(vec![at(0, 0), at(10, 0), at(10, 10), at(0, 10)]).unwrap();
//! let outline = Region::new(vec![square]).unwrap();
//! let part = Arc::new(ProhibitedRegion::new(outline, Side::Outside).unwrap());
//! let part = Arc::new(Levels::flat(part));
//! let rules = Rules {
//!     travel: Window::of(at(-50, -50)).including(at(50, 50)),
//!     jogging_clearance: length(4 * mm),
//!     finishing_clearance: length(3 * mm),
//!     resolution: length(mm / 200),
//!     shortest: length(mm / 100),
//!     interpolation: Interpolation::Linear,
//!     on_cancel: OnCancel::KeepsPath,
//!     contours: Interpolation::Linear,
//!     checked: true,
//!     heights: HeightRules::TWO_AXES,
//! };
//! let mut guard = Guard::new(Arc::clone(&part), part, rules);
//! guard.locate(at(-5, 5).in_plane()).unwrap();
//! assert!(guard.jog(at(-5, 20).in_plane(), 600).is_ok());
//! assert!(matches!(guard.jog(at(15, 5).in_plane(), 600), Err(Refusal::Blocked(_))));
//! ```
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

extern crate alloc;

mod admission;
mod cancel;
mod contour;
mod evidence;
#[cfg(test)]
mod height_tests;
mod hull;
mod in_flight;
mod motion;
mod nearest;
mod open_space;
mod place;
mod queries;
mod rest;
mod rules;
mod state;
#[cfg(test)]
mod tests;
mod time;

use alloc::sync::Arc;

pub use admission::{Admission, Admissions};
pub use cancel::OnCancel;
use contour::Contour;
pub use contour::{Certification, ContourMotion};
use evidence::Evidence;
pub use evidence::{PositionFeedback, QueryStamp};
pub use hull::Hull;
pub use in_flight::DRAIN;
use in_flight::{InFlight, LINES_MAX, Line};
use keepout_kernel::{Height, Length, Levels, Place};
pub use motion::{Certified, CertifiedCancel, FeedOverride, Motion, Refusal};
use nearest::clear_box;
pub use open_space::guard_in_open_space;
pub use place::FreePlace;
pub use rest::PARSING;
pub use rules::{HeightRules, Interpolation, Rules};
pub use state::State;
pub use time::Time;

/// The guard of one controller. The documentation of this crate states its guarantees.
///
/// The guarantees hold only if one guard commands the controller. A copy is for state exploration only.
#[derive(Clone, Debug)]
pub struct Guard {
    exact: Arc<Levels>,
    /// Simplified outlines: fewer edges, and a little larger. A motion that is clear of them is clear of the
    /// part.
    simplified: Arc<Levels>,
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
    /// A guard for `part`. `simplified` is the part or its [simplified outlines](Levels::simplified).
    ///
    /// The guard certifies jogs against `simplified`. It certifies contours and retract moves against `part`.
    #[must_use]
    pub fn new(part: Arc<Levels>, simplified: Arc<Levels>, rules: Rules) -> Self {
        Self {
            exact: part,
            simplified,
            set: InFlight::new(&rules),
            rules,
            sent: 0,
            acknowledged: 0,
            read: 0,
            deceleration: None,
            contour: None,
        }
    }

    /// Forgets the position of the tool. The guard then admits no motion until [`Guard::locate`] succeeds.
    pub fn forget(&mut self) {
        self.set.place(None);
        self.contour = None;
        (self.acknowledged, self.read) = (self.sent, self.sent);
    }

    /// Takes the position of a machine at rest with an empty queue, after connecting or homing.
    ///
    /// Inside the jogging clearance, only [`Guard::retract`] and [`Guard::begin_contour`] then lead to a
    /// motion.
    ///
    /// # Errors
    /// [`Refusal::Blocked`] when the tool is in the part, [`Refusal::InMotion`] with lines in flight or a
    /// contour.
    pub fn locate(&mut self, position: Place) -> Result<(), Refusal> {
        if !self.set.lines.is_empty() || self.contour.is_some() {
            return Err(Refusal::InMotion);
        }
        let place = self.free_place(position)?;
        self.set.place(Some(place));
        Ok(())
    }

    /// The point as a free point at the jogging clearance. A point nearer to the part gets its own distance
    /// from the part as the threshold.
    fn free_place(&self, position: Place) -> Result<FreePlace, Refusal> {
        let Place { point, height } = position;
        let tip = self.rules.heights.certified_for(height);
        let (simplified, exact) = (self.simplified.at(tip), self.exact.at(tip));
        let free = simplified.free_point(point, self.rules.jogging_clearance).or_else(|blocked| {
            let clearance = exact.clearance(point).ok_or(Refusal::Blocked(blocked))?;
            let below = Length::from_units(i64::from(self.rules.jogging_clearance.units()) - 1)
                .unwrap_or(Length::ZERO);
            exact.free_point(point, clearance.min(below)).map_err(Refusal::Blocked)
        });
        Ok(FreePlace { free: free?, height })
    }

    /// Number of lines that the controller's receive buffer may still hold. It is zero with a checksum,
    /// because the checksum keeps the controller from mixing two lines.
    fn unread(&self) -> u64 {
        if self.rules.checked { 0 } else { self.sent - self.read }
    }

    /// Whether the guard can hand out another line now.
    #[must_use]
    pub fn takes_lines(&self) -> bool {
        self.set.lines.len() < LINES_MAX && self.unread() == 0
    }

    /// Whether the next line waits only for the answer to a query.
    #[must_use]
    pub fn awaits_reading(&self) -> bool {
        self.unacknowledged() == 0 && (self.unread() > 0 || self.has_stopped_early())
    }

    /// Whether the tool is at rest at a known position, with no line in flight and no contour.
    #[must_use]
    pub fn in_position(&self) -> bool {
        self.set.confirmed.is_some()
            && self.set.before.is_none()
            && self.set.lines.is_empty()
            && self.contour.is_none()
    }

    /// Whether the confirmed position is inside the jogging clearance.
    #[must_use]
    pub fn is_inside_jogging_clearance(&self) -> bool {
        self.set.confirmed.is_some_and(|confirmed| confirmed.threshold() < self.rules.jogging_clearance)
    }

    /// Borrows the guard to try targets of a jog, and to send the jog.
    #[must_use]
    pub fn admissions(&mut self) -> Admissions<'_> {
        Admissions::of(self)
    }

    /// The confirmed position, if the guard can consider a jog to `to`.
    fn ready(&self, to: Place) -> Result<FreePlace, Refusal> {
        if self.contour.is_some() || self.set.stray > Length::ZERO {
            return Err(Refusal::InMotion);
        }
        let confirmed = self.set.confirmed.ok_or(Refusal::PositionUnknown)?;
        if !self.rules.travel.holds(to.point) {
            return Err(Refusal::SoftLimit(to.point));
        }
        if !self.rules.heights.permit(to.height) {
            return Err(Refusal::HeightLimit(to.height));
        }
        if !self.takes_lines() {
            return Err(Refusal::Full);
        }
        let from = self.set.lines.back().map_or(confirmed, |line| line.target).place();
        let way = to.point.minus(from.point);
        let short = way.dx.abs().max(way.dy.abs()) < self.rules.shortest.units();
        let climb = i64::from(to.height.units()) - i64::from(from.height.units());
        if short && (climb == 0 || climb.abs() < i64::from(self.rules.heights.shortest.units())) {
            Err(Refusal::TooShort)
        } else {
            Ok(confirmed)
        }
    }

    /// Certifies a jog to `to` and counts it as sent.
    ///
    /// # Errors
    /// [`Refusal`] with the reason. The jog must not be sent.
    pub fn jog(&mut self, to: Place, feed_mm_min: u32) -> Result<Certified, Refusal> {
        let admissions = self.admissions();
        let admission = admissions.admit(to)?;
        Ok(admissions.jog(admission, feed_mm_min))
    }

    /// Certifies a retract move to `to` and counts it as sent.
    ///
    /// # Errors
    /// [`Refusal`] with the reason. The retract move must not be sent.
    pub fn retract(&mut self, to: Place, feed_mm_min: u32) -> Result<Certified, Refusal> {
        let admissions = self.admissions();
        let admission = admissions.admit_retract(to)?;
        Ok(admissions.jog(admission, feed_mm_min))
    }

    /// Certifies a rise to `height` and counts it as sent.
    ///
    /// # Errors
    /// [`Refusal`] with the reason. The rise must not be sent.
    pub fn rise(&mut self, height: Height, feed_mm_min: u32) -> Result<Certified, Refusal> {
        let admissions = self.admissions();
        let admission = admissions.admit_rise(height)?;
        Ok(admissions.jog(admission, feed_mm_min))
    }

    fn send_jog(&mut self, target: FreePlace, feed_mm_min: u32) -> Certified {
        self.sent += 1;
        self.set.moving();
        self.set.fastest = self.set.fastest.max(feed_mm_min);
        let line = Line { number: self.sent, target };
        self.set.lines.push_back(line);
        Certified { motion: Motion::Jog { to: target.place(), feed_mm_min } }
    }

    /// Counts an acknowledgement of the oldest line.
    ///
    /// # Errors
    /// [`Refusal::UnexpectedAcknowledgement`] when no line is unacknowledged.
    pub fn acknowledged(&mut self) -> Result<(), Refusal> {
        if self.unacknowledged() == 0 {
            return Err(Refusal::UnexpectedAcknowledgement);
        }
        self.acknowledged += 1;
        Ok(())
    }

    /// Takes the reply that the controller rejected the only unacknowledged jog. Returns whether there was
    /// one.
    ///
    /// The target stays in the set. If the line arrived twice, the controller can reject one copy and accept
    /// the other.
    pub fn refused(&mut self) -> bool {
        // The set has no motion of a contour.
        if self.unacknowledged() != 1 || self.set.lines.back().map(|line| line.number) != Some(self.sent) {
            return false;
        }
        self.acknowledged = self.sent;
        self.set.refused += 1;
        true
    }

    /// Takes a report as evidence. `stamp` belongs to the query that the report answers, or to an earlier
    /// query.
    ///
    /// *Read lines.* When no input waits in the controller, it has read all lines that left before the query.
    ///
    /// *In position.* The controller is at rest with an empty queue, and it acknowledged every line before
    /// the query left. Two such reports must agree. With a checksum, one report at the last target is enough.
    /// Then only the confirmed position remains in the set.
    ///
    /// *Completed lines.* With `q` motions in the queue, all acknowledged lines but the last `q` have left
    /// it. A line is executed if it had left the queue at a report that arrived [`DRAIN`] before this query
    /// left. It leaves the set when the tool is also reported where it can be only after a later line has
    /// begun.
    ///
    /// # Errors
    /// [`Refusal::OffCertified`] when the position is too far from every certified motion. The bound is twice
    /// the resolution for jogs, and once for contours. `in_flight.rs`, `cancel.rs` and `contour.rs` state
    /// additions for rounding, stopping and chords. [`Refusal::Dropped`] when the tool stopped short of the
    /// end of a contour motion.
    pub fn reported(
        &mut self,
        feedback: &PositionFeedback,
        stamp: QueryStamp,
        now: Time,
    ) -> Result<(), Refusal> {
        let evidence = Evidence {
            feedback,
            all_acknowledged: self.all_acknowledged(stamp),
            acknowledged: self.acknowledged,
            asked: stamp.at,
            now,
        };
        if !feedback.waiting {
            self.read = self.read.max(stamp.sent);
        }
        if self.contour.is_some() {
            return self.reported_in_contour(&evidence);
        }
        if self.set.confirmed.is_none() {
            return Ok(());
        }
        let levels = if self.is_inside_jogging_clearance() { &*self.exact } else { &*self.simplified };
        let in_position = self.set.reported(levels, &evidence)?;
        if in_position
            && self.is_inside_jogging_clearance()
            && let Some(confirmed) = self.set.confirmed
        {
            self.set.confirmed = Some(self.free_place(confirmed.place()).unwrap_or(confirmed));
        }
        Ok(())
    }

    /// Whether the controller acknowledged every line before the query left.
    fn all_acknowledged(&self, stamp: QueryStamp) -> bool {
        stamp.acknowledged == self.sent
    }
}

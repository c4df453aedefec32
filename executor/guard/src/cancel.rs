//! TRUSTED. Cancels: a cancel is certified like a motion.
//!
//! Three arguments hold a cancelled jog away from the part. What is known of the controller decides which one applies.
//!
//! *Path-keeping.* The controller brakes along the path that it has planned, so the tool stays in the hull of the in-flight set.
//! A cancel needs no certificate of its own. A described controller does so when its file says so.
//!
//! *Not path-keeping.* The controller may leave its path while it brakes. The tool stops within its stopping distance of where
//! the cancel reached it, in any direction. A cancel is admitted only if the hull, grown by that distance, is clear. The set keeps
//! the growth until the tool rests, and admits no jog before. A cancel that is refused is not sent: the jogs run to their
//! certified targets, which are a short way ahead. This is assumed of described controllers, unless their file says otherwise.
//!
//! *No cancel.* A cancel is never sent, and the operator's release stops the tool by the short look-ahead. GRBL and grblHAL need
//! this argument. A stop that ends exactly where a block ends can make both send 65,535 steps that nobody ordered, so no stopping
//! distance holds. Besides, grblHAL's fast hold drives beside the path (`docs/safety/controllers.md`).
//!
//! A cancel is refused after another until the tool was seen at rest, or a line that was sent after the other was acknowledged:
//! one firmware was seen to hang on a second cancel just after the first had stopped it.

use keepout_kernel::exact::segment::{Window, points_within};
use keepout_kernel::{FreePoint, Length, Point, ProhibitedRegion};

use crate::in_flight::{BELIEVED, InFlight, clear_box};
use crate::motion::CertifiedCancel;
use crate::{Guard, Interpolation, Refusal};

/// What the tool does when a jog under way is cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnCancel {
    /// Nothing: jogs can not be cancelled and run to their targets.
    NotOffered,
    /// It stops on its certified path; where axes are not interpolated, in the certified box.
    KeepsPath,
    /// It stops within its stopping distance, in any direction.
    MayStray,
}

/// Lattice units per second in one mm/min, as a fraction: 100,000 units per mm, 60 s per minute.
const UNITS_PER_S: (u128, u128) = (100_000, 60);
/// Time for which a controller may go on at full speed before it brakes, in ms: what its stepper buffer holds (grblHAL prepares
/// segments for 100 ms at most), and half as much again.
const BUFFERED_MS: u128 = 150;
/// Rounding of the places that the distance is measured between, lattice units.
const ROUNDING: i64 = 4;

/// How far a tool at `feed_mm_min` goes on after a cancel: v·t + v²/2a, rounded up, with v in units/s, t what is buffered and a
/// the least deceleration in units/s². `None` when that is beyond the lattice.
pub(crate) fn stopping_distance(feed_mm_min: u32, deceleration: u64) -> Option<Length> {
    let (numerator, denominator) = UNITS_PER_S;
    let speed = (u128::from(feed_mm_min) * numerator).div_ceil(denominator);
    let buffered = (speed * BUFFERED_MS).div_ceil(1000);
    let braking = (speed * speed).div_ceil(2 * u128::from(deceleration).max(1));
    i64::try_from(buffered + braking).ok().and_then(|units| Length::from_units(units).ok())
}

impl Guard {
    /// Takes what is known of the controller: what a cancel does, and the least deceleration of its axes in lattice units per s².
    pub fn learn_of_cancels(&mut self, on_cancel: OnCancel, deceleration: Option<u64>) {
        self.rules.on_cancel = on_cancel;
        self.deceleration = deceleration;
    }

    /// What a cancel is taken to do.
    #[must_use]
    pub fn on_cancel(&self) -> OnCancel {
        self.rules.on_cancel
    }

    /// Whether a cancel may have led the tool off its path: no jog is admitted before it rests.
    #[must_use]
    pub fn may_have_strayed(&self) -> bool {
        self.set.stray > Length::ZERO
    }

    /// Certifies a cancel of the jogs in flight.
    ///
    /// # Errors
    /// [`Refusal`] saying why it may not be sent; the jogs then run to their targets.
    pub fn cancel(&mut self) -> Result<CertifiedCancel, Refusal> {
        if self.contour.is_some() {
            return Err(Refusal::InMotion);
        }
        if self.set.confirmed.is_none() {
            return Err(Refusal::PositionUnknown);
        }
        if self.set.cancelled.is_some_and(|sent| self.acknowledged <= sent) {
            return Err(Refusal::Cancelled);
        }
        let certified = self.certify_cancel()?;
        self.set.cancelled = Some(self.sent);
        Ok(certified)
    }

    fn certify_cancel(&mut self) -> Result<CertifiedCancel, Refusal> {
        match self.rules.on_cancel {
            OnCancel::NotOffered => Err(Refusal::NoCancel),
            OnCancel::KeepsPath => Ok(CertifiedCancel::new()),
            OnCancel::MayStray => self.cancel_that_strays(),
        }
    }

    fn cancel_that_strays(&mut self) -> Result<CertifiedCancel, Refusal> {
        if self.is_inside_jogging_clearance() {
            return Err(Refusal::InsideJoggingClearance);
        }
        let deceleration = self.deceleration.ok_or(Refusal::StoppingUnknown)?;
        let distance = stopping_distance(self.set.fastest, deceleration).ok_or(Refusal::StoppingUnknown)?;
        let stray = self.set.stray.plus(distance).map_err(|_| Refusal::StoppingUnknown)?;
        self.set.admit_stray(&self.simplified, stray)?;
        self.set.stray = stray;
        Ok(CertifiedCancel::new())
    }
}

impl InFlight {
    /// Certifies that the hull of the set, or its box, stays clear when the tool may leave it by `stray`. Reports are believed
    /// to twice the resolution beyond that, so as much more is clear.
    fn admit_stray(&self, part: &ProhibitedRegion, stray: Length) -> Result<(), Refusal> {
        let confirmed = self.confirmed.ok_or(Refusal::PositionUnknown)?;
        let reach = self.believed(stray).saturating_plus(confirmed.threshold());
        let place = part.free_point(confirmed.point(), reach).map_err(Refusal::Blocked)?;
        let clear = match self.interpolation {
            Interpolation::Linear => {
                let hull = self.hull().ok_or(Refusal::PositionUnknown)?;
                let polygon = hull.polygon().ok_or(Refusal::PositionUnknown)?;
                part.polygon(place, polygon, place.point()).map(drop)
            }
            Interpolation::Independent => {
                let window = self.points().map(|free| Window::of(free.point())).reduce(Window::union);
                clear_box(part, place, window.ok_or(Refusal::PositionUnknown)?)
            }
        };
        clear.map_err(Refusal::Blocked)
    }

    /// How far from the hull a report is believed when the tool may have left it by `stray`.
    fn believed(&self, stray: Length) -> Length {
        let rounding = Length::from_units(ROUNDING).unwrap_or(Length::ZERO);
        self.resolutions(BELIEVED).saturating_plus(rounding).saturating_plus(stray)
    }

    /// Takes a report after a cancel that may have strayed. The set stays as it is until two reports at rest agree; then the tool
    /// is where it is reported. Answers whether it rests there.
    pub(crate) fn reported_after_cancel(
        &mut self,
        part: &ProhibitedRegion,
        position: Point,
        rests: bool,
    ) -> Result<bool, Refusal> {
        let off = Refusal::OffCertified(position);
        let foot = self.nearest_in_set(position).ok_or(off)?;
        if points_within(foot, position, self.believed(self.stray)).is_clear() {
            return Err(off);
        }
        if !rests {
            self.moving();
            return Ok(false);
        }
        if !self.rests_again(position) {
            return Ok(false);
        }
        let place: FreePoint = self.reached(part, position).ok_or(off)?;
        self.place(Some(place));
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stopping_distance_is_rounded_up() {
        // 6000 mm/min is 100 mm/s: 15 mm in 150 ms, and 10 mm of braking at 500 mm/s².
        assert_eq!(stopping_distance(6000, 50_000_000), Length::from_units(2_500_000).ok());
        // 1 mm/min is 1666.7 units/s.
        assert_eq!(stopping_distance(1, 1_000_000_000), Length::from_units(251 + 1).ok());
        assert_eq!(stopping_distance(u32::MAX, 1), None);
        assert_eq!(stopping_distance(0, 0), Some(Length::ZERO));
    }
}

//! TRUSTED. Cancels: the guard certifies a cancel like a motion.
//!
//! Implements SR-11.
//!
//! Three arguments keep a cancelled jog away from the part. The known properties of the controller decide
//! which one applies.
//!
//! *Path-keeping.* The controller brakes along the path that it has planned, so the tool stays in the hull of
//! the in-flight set. A cancel needs no certificate of its own. A described controller counts as path-keeping
//! if its file states so.
//!
//! *Not path-keeping.* The controller may leave its path while it brakes. The tool stops within its stopping
//! distance of where the cancel reached it, in any direction, also downward. If the axes are not interpolated,
//! the feed is the top speed of each axis. Each axis then stops within that distance, and the tool within √2
//! times that distance in the plane. The guard admits a cancel only if
//! the hull, grown by that distance, is clear of what stands above the lowest height less that distance. The set
//! keeps the growth, and the guard admits no jog, until the tool is at rest. A refused cancel is not sent: the
//! jogs run to their certified targets, a short way ahead. A described controller belongs here unless its file
//! states otherwise.
//!
//! *No cancel.* A cancel is never sent. When the operator releases the stick, the tool stops soon, because
//! the look-ahead is short. GRBL and grblHAL need this argument. A stop that ends exactly at the end of a
//! block can make both output 65,535 uncommanded steps, so no stopping distance holds. Also, the fast hold of
//! grblHAL leaves the path (`docs/safety/controllers.md`).
//!
//! After a cancel, the guard refuses a second one until the tool is in position. It also accepts a second one
//! when the controller has acknowledged a line that was sent after the first. One firmware hung on a second
//! cancel just after the first had stopped it.

use keepout_kernel::exact::segment::{Window, points_within};
use keepout_kernel::{Height, Length, Levels};

use crate::evidence::Evidence;
use crate::in_flight::{BELIEVED, InFlight};
use crate::motion::CertifiedCancel;
use crate::{FreePlace, Guard, Interpolation, Refusal, clear_box};

/// Behaviour of the tool when a jog is cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnCancel {
    /// No cancel is sent: jogs run to their targets.
    NotOffered,
    /// The tool stops on its certified path, or in the certified box with non-interpolated axes.
    KeepsPath,
    /// The tool stops within its stopping distance, in any direction.
    MayStray,
}

/// Lattice units per second in one mm/min, as a fraction: 100,000 units per mm, 60 s per minute.
const UNITS_PER_S: (u128, u128) = (100_000, 60);
/// Greatest time at full speed before the controller brakes, ms. It is 1.5 times the longest stepper buffer:
/// grblHAL prepares segments for at most 100 ms.
const BUFFERED_MS: u128 = 150;
/// Rounding of the two points between which a distance is measured, lattice units.
const ROUNDING: i64 = 4;

/// Stopping distance of a tool at `feed_mm_min` after a cancel: v·t + v²/2a, rounded up. Here v is in
/// units/s, t is the buffered time, and a is the least deceleration in units/s². With non-interpolated axes, two
/// axes at that feed stop within √2 times as much in the plane. `None` when the distance exceeds the lattice.
fn stopping_distance(feed_mm_min: u32, deceleration: u64, interpolation: Interpolation) -> Option<Length> {
    let (numerator, denominator) = UNITS_PER_S;
    let speed = (u128::from(feed_mm_min) * numerator).div_ceil(denominator);
    let buffered = (speed * BUFFERED_MS).div_ceil(1000);
    let braking = (speed * speed).div_ceil(2 * u128::from(deceleration).max(1));
    let along = buffered + braking;
    let distance = match interpolation {
        Interpolation::Linear => along,
        // 99/70 is above √2: 99² = 2·70² + 1.
        Interpolation::Independent => (along * 99).div_ceil(70),
    };
    i64::try_from(distance).ok().and_then(|units| Length::from_units(units).ok())
}

impl Guard {
    /// Takes the known properties of the controller: the behaviour on a cancel, and the least deceleration of
    /// its axes in lattice units per s².
    pub fn learn_of_cancels(&mut self, on_cancel: OnCancel, deceleration: Option<u64>) {
        self.rules.on_cancel = on_cancel;
        self.deceleration = deceleration;
    }

    /// The assumed behaviour of the tool on a cancel.
    #[must_use]
    pub fn on_cancel(&self) -> OnCancel {
        self.rules.on_cancel
    }

    /// Whether a cancel may have led the tool off its path. The guard then admits no jog until the tool is at
    /// rest.
    #[must_use]
    pub fn may_have_strayed(&self) -> bool {
        self.set.stray > Length::ZERO
    }

    /// Certifies a cancel of the jogs in flight.
    ///
    /// # Errors
    /// [`Refusal`] with the reason. The cancel must not be sent, and the jogs run to their targets.
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
        let distance = stopping_distance(self.set.fastest, deceleration, self.set.interpolation)
            .ok_or(Refusal::StoppingUnknown)?;
        let stray = self.set.stray.plus(distance).map_err(|_| Refusal::StoppingUnknown)?;
        self.set.admit_stray(&self.simplified, stray)?;
        self.set.stray = stray;
        Ok(CertifiedCancel::new())
    }
}

impl InFlight {
    /// Certifies that the hull or box of the set is clear for a tool that may be up to `stray` outside it.
    /// The guard believes reports up to twice the resolution beyond that, so the certificate includes this
    /// distance.
    fn admit_stray(&self, levels: &Levels, stray: Length) -> Result<(), Refusal> {
        let confirmed = self.confirmed.ok_or(Refusal::PositionUnknown)?;
        let part = self.region(levels, self.lowest_after(stray)?);
        let reach = self.believed(stray).saturating_plus(confirmed.threshold());
        let place = part.free_point(confirmed.point(), reach).map_err(Refusal::Blocked)?;
        let clear = match self.interpolation {
            Interpolation::Linear => {
                let hull = self.hull().ok_or(Refusal::PositionUnknown)?;
                let polygon = hull.polygon().ok_or(Refusal::PositionUnknown)?;
                part.polygon(place, polygon, place.point()).map(drop)
            }
            Interpolation::Independent => {
                let window = self.places().map(|place| Window::of(place.point())).reduce(Window::union);
                clear_box(part, place, window.ok_or(Refusal::PositionUnknown)?)
            }
        };
        clear.map_err(Refusal::Blocked)
    }

    /// The lowest height of a tip that may be up to `stray` below the set.
    fn lowest_after(&self, stray: Length) -> Result<Height, Refusal> {
        Ok(self.lowest().ok_or(Refusal::PositionUnknown)?.lowered(stray))
    }

    /// Greatest distance from the hull at which the guard believes a report, if the tool may be up to `stray`
    /// outside.
    fn believed(&self, stray: Length) -> Length {
        let rounding = Length::from_units(ROUNDING).unwrap_or(Length::ZERO);
        self.resolutions(BELIEVED).saturating_plus(rounding).saturating_plus(stray)
    }

    /// Takes a report after a cancel that may have led the tool off its path. The set stays unchanged until
    /// two reports at rest agree. Then it holds only the reported position. Returns whether the tool is at
    /// rest there.
    pub(crate) fn reported_after_cancel(
        &mut self,
        levels: &Levels,
        evidence: &Evidence<'_>,
    ) -> Result<bool, Refusal> {
        let position = evidence.feedback.position;
        let off = Refusal::OffCertified(position.point);
        let foot = self.nearest_in_set(position.point).ok_or(off)?;
        let lowest = self.lowest_after(self.stray)?;
        let height = lowest.max(position.height);
        if points_within(foot, position.point, self.believed(self.stray)).is_clear()
            || !self.heights.agree(position.height, height, BELIEVED)
        {
            return Err(off);
        }
        if !evidence.rests() {
            self.moving();
            return Ok(false);
        }
        if !self.rests_again(evidence) {
            return Ok(false);
        }
        // The set may be certified at a higher level only, so this level is queried again.
        let confirmed = self.confirmed.ok_or(off)?;
        let part = self.region(levels, height);
        let free = match self.reached(part, position.point) {
            Some(free) => free,
            None => part.free_point(position.point, confirmed.threshold()).map_err(|_| off)?,
        };
        self.place(Some(FreePlace { free, height }));
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stopping_distance_is_rounded_up() {
        use Interpolation::{Independent, Linear};
        // 6000 mm/min is 100 mm/s: 15 mm in 150 ms, and 10 mm of braking at 500 mm/s².
        assert_eq!(stopping_distance(6000, 50_000_000, Linear), Length::from_units(2_500_000).ok());
        assert_eq!(stopping_distance(6000, 50_000_000, Independent), Length::from_units(3_535_715).ok());
        // 1 mm/min is 1666.7 units/s.
        assert_eq!(stopping_distance(1, 1_000_000_000, Linear), Length::from_units(251 + 1).ok());
        for interpolation in [Linear, Independent] {
            assert_eq!(stopping_distance(u32::MAX, 1, interpolation), None);
            assert_eq!(stopping_distance(0, 0, interpolation), Some(Length::ZERO));
        }
    }

    // Evidence for SR-11.
    /// Two axes that each stop within the distance of one axis stop within the certified one.
    #[test]
    fn stopping_distance_of_two_axes_covers_both() {
        for feed in 0..20_000 {
            let of = |interpolation| stopping_distance(feed, 100_000_000, interpolation).unwrap().units();
            let [one, both] = [Interpolation::Linear, Interpolation::Independent].map(of).map(i64::from);
            assert!(both * both >= 2 * one * one, "{feed} mm/min: {one} and {both} units");
        }
    }
}

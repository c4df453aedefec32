//! TRUSTED. Admissions: the guard certifies a jog once, and sends it as certified.
//!
//! Implements SR-07, SR-14.
//!
//! [`Admissions`] borrows the guard exclusively. So the in-flight set cannot change between the certification
//! of a target and its jog. An [`Admission`] cannot outlive it: the compiler rejects a stale one. The guard
//! builds the hull of the in-flight set once for all targets that are tried.

use core::marker::PhantomData;

use keepout_kernel::{Height, Place};

use crate::hull::Hull;
use crate::{Certified, FreePlace, Guard, Interpolation, Refusal};

/// A target that the guard has admitted. [`Admissions::jog`] consumes it.
#[derive(Debug)]
pub struct Admission<'a> {
    target: FreePlace,
    /// Makes `'a` invariant, so that the admission belongs to its own [`Admissions`].
    of: PhantomData<&'a mut &'a ()>,
}

impl Admission<'_> {
    /// The target.
    #[must_use]
    pub fn target(&self) -> Place {
        self.target.place()
    }
}

/// Exclusive access to the guard, to try targets of a jog and then send it.
#[derive(Debug)]
pub struct Admissions<'a> {
    guard: &'a mut Guard,
    hull: Option<Hull>,
}

impl<'a> Admissions<'a> {
    pub(crate) fn of(guard: &'a mut Guard) -> Self {
        let linear = guard.rules.interpolation == Interpolation::Linear;
        let hull = if linear { guard.set.hull() } else { None };
        Self { guard, hull }
    }

    /// The guard.
    #[must_use]
    pub fn guard(&self) -> &Guard {
        self.guard
    }

    /// Certifies a jog to `to`: the hull of the in-flight set and `to` is clear of everything above the lowest
    /// height of both.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    pub fn admit(&self, to: Place) -> Result<Admission<'a>, Refusal> {
        let guard = &*self.guard;
        let confirmed = guard.ready(to)?;
        if guard.is_inside_jogging_clearance() {
            return Err(Refusal::InsideJoggingClearance);
        }
        let target = guard.set.admit(&guard.simplified, self.hull.as_ref(), confirmed, to)?;
        Ok(Admission { target, of: PhantomData })
    }

    /// Certifies a rise to `height`, straight up from the last target. It is always permitted: what is clear at
    /// a height is clear above it. This holds inside the jogging clearance, too.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    pub fn admit_rise(&self, height: Height) -> Result<Admission<'a>, Refusal> {
        let guard = &*self.guard;
        let end = guard.end().ok_or(Refusal::PositionUnknown)?;
        let confirmed = guard.ready(end.point().at_height(height))?;
        let target = guard.set.admit_rise(confirmed, height)?;
        Ok(Admission { target, of: PhantomData })
    }

    /// Certifies a retract move to `to`. It begins at rest, does not lower the tool, and comes nearer to no edge
    /// within the jogging clearance.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    pub fn admit_retract(&self, to: Place) -> Result<Admission<'a>, Refusal> {
        let guard = &*self.guard;
        let confirmed = guard.ready(to)?;
        if !guard.is_inside_jogging_clearance() {
            return Err(Refusal::ClearOfPart);
        }
        if !guard.in_position() {
            return Err(Refusal::InMotion);
        }
        if to.height < confirmed.height {
            return Err(Refusal::LowersNearPart(to.height));
        }
        let way = to.point.minus(confirmed.point());
        if guard.rules.interpolation == Interpolation::Independent && way.dx != 0 && way.dy != 0 {
            return Err(Refusal::Slanted(confirmed.point()));
        }
        let within = guard.rules.jogging_clearance;
        let part = guard.set.present(&guard.exact);
        let free = part.retract(confirmed.free, to.point, within).map_err(Refusal::Blocked)?;
        Ok(Admission { target: FreePlace { free, height: to.height }, of: PhantomData })
    }

    /// Counts an admitted jog or retract move as sent.
    #[must_use]
    pub fn jog(self, admission: Admission<'a>, feed_mm_min: u32) -> Certified {
        self.guard.send_jog(admission.target, feed_mm_min)
    }
}

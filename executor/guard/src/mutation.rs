//! The guard with a part taken out: only in builds that test whether somebody notices.

use keepout_kernel::Length;

use crate::{Guard, MotionShape, Sighting};

/// Parts of the guard that a test build can take out, one at a time, to see that somebody notices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mutation {
    /// Nothing is taken out.
    #[default]
    None,
    /// The set is the last reported position alone.
    ForgetInFlight,
    /// The fans are left out: only the motion from the last target is asked.
    NoFans,
    /// Lines leave the set as soon as a report says that they have left the queue.
    RetireAtOnce,
    /// One report at rest settles, whenever it was asked for.
    SettleAtOnce,
    /// Any reported position is believed.
    BelieveAnyPosition,
    /// Contours are not certified.
    UncertifiedContour,
    /// A contour goes on without waiting for acknowledgements.
    ContourUnacknowledged,
    /// Lines go out as they are acknowledged, whatever the controller has read.
    AheadOfReading,
    /// An escape may lead anywhere.
    EscapeAnywhere,
    /// Axes that run apart are taken to drive straight.
    StraightAnyway,
    /// A cancel is taken to keep the path, whatever the controller does.
    UncertifiedCancel,
    /// The margin and allowance are forgotten: the threshold is the tool's radius less 20 µm.
    NoMargin,
}

impl Mutation {
    /// Every part that can be taken out.
    pub const ALL: [Self; 12] = [
        Self::ForgetInFlight,
        Self::NoFans,
        Self::RetireAtOnce,
        Self::SettleAtOnce,
        Self::BelieveAnyPosition,
        Self::UncertifiedContour,
        Self::ContourUnacknowledged,
        Self::AheadOfReading,
        Self::EscapeAnywhere,
        Self::StraightAnyway,
        Self::UncertifiedCancel,
        Self::NoMargin,
    ];
}

impl Guard {
    /// Takes out a part of the guard, for a test that must notice.
    pub fn mutate(&mut self, mutation: Mutation) {
        self.mutation = mutation;
        match mutation {
            Mutation::StraightAnyway => {
                self.rules.shape = MotionShape::Line;
                self.rules.contours = MotionShape::Line;
                self.set.shape = MotionShape::Line;
            }
            Mutation::NoMargin => {
                let less =
                    |length: Length| Length::from_units(i64::from(length.units()) * 9 / 10).unwrap_or(length);
                self.rules.manual = less(self.rules.finishing);
                self.rules.finishing = less(self.rules.finishing);
            }
            _ => {}
        }
    }

    /// Whether a mutation has dealt with the report.
    pub(crate) fn mutate_report(&mut self, sighting: &Sighting) -> bool {
        let place = self.free_place(sighting.position).ok();
        match self.mutation {
            Mutation::ForgetInFlight => self.set.tail = place.or(self.set.tail),
            Mutation::BelieveAnyPosition if place.is_some() => {
                self.set.tail = place;
                self.set.before = None;
                if sighting.rests() {
                    self.set.lines.clear();
                }
            }
            Mutation::SettleAtOnce if sighting.at_rest => {
                self.set.place(place.or(self.set.tail));
            }
            _ => return false,
        }
        true
    }

    /// Lets lines leave the set too soon.
    pub(crate) fn mutate_retiring(&mut self, sighting: &Sighting) {
        if self.mutation == Mutation::RetireAtOnce {
            let queued = u64::try_from(sighting.queued.unwrap_or(0)).unwrap_or(u64::MAX);
            let left = self.acknowledged.saturating_sub(queued);
            self.set.lines.retain(|line| line.number > left);
        }
    }
}

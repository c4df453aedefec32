//! The guard with a part taken out: only in builds that test whether somebody notices.

use keepout_kernel::Length;

use crate::{Guard, Interpolation, PositionFeedback};

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
    /// An retract may lead anywhere.
    EscapeAnywhere,
    /// Axes that run apart are taken to drive straight.
    StraightAnyway,
    /// A cancel is taken to keep the path, whatever the controller does.
    UncertifiedCancel,
    /// The margin and stock_to_leave are forgotten: the threshold is the tool's radius less 20 µm.
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
                self.rules.interpolation = Interpolation::Linear;
                self.rules.contours = Interpolation::Linear;
                self.set.interpolation = Interpolation::Linear;
            }
            Mutation::NoMargin => {
                let less =
                    |length: Length| Length::from_units(i64::from(length.units()) * 9 / 10).unwrap_or(length);
                self.rules.jogging_clearance = less(self.rules.finishing_clearance);
                self.rules.finishing_clearance = less(self.rules.finishing_clearance);
            }
            _ => {}
        }
    }

    /// Whether a mutation has dealt with the report.
    pub(crate) fn mutate_report(&mut self, feedback: &PositionFeedback) -> bool {
        let place = self.free_place(feedback.position).ok();
        match self.mutation {
            Mutation::ForgetInFlight => self.set.confirmed = place.or(self.set.confirmed),
            Mutation::BelieveAnyPosition if place.is_some() => {
                self.set.confirmed = place;
                self.set.before = None;
                if feedback.rests() {
                    self.set.lines.clear();
                }
            }
            Mutation::SettleAtOnce if feedback.in_position => {
                self.set.place(place.or(self.set.confirmed));
            }
            _ => return false,
        }
        true
    }

    /// Lets lines leave the set too soon.
    pub(crate) fn mutate_retiring(&mut self, feedback: &PositionFeedback) {
        if self.mutation == Mutation::RetireAtOnce {
            let queued = u64::try_from(feedback.queued.unwrap_or(0)).unwrap_or(u64::MAX);
            let left = self.acknowledged.saturating_sub(queued);
            self.set.lines.retain(|line| line.number > left);
        }
    }
}

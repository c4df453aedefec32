//! What the guard knows: the in-flight set, its heights, and the lines.
//!
//! Implements SR-05, SR-07, SR-10, SR-12, SR-13.

use keepout_kernel::{Height, Point, ProhibitedRegion};

use crate::{FreePlace, Guard, Rules};

impl Guard {
    /// The part for jogs at the lowest height of the in-flight set: the simplified outline.
    #[must_use]
    pub fn part(&self) -> &ProhibitedRegion {
        self.set.present(&self.simplified)
    }

    /// The part for jogs that lead to `height`: the simplified outline at the lower of that height and the
    /// lowest height of the in-flight set.
    #[must_use]
    pub fn part_for(&self, height: Height) -> &ProhibitedRegion {
        self.set.region(&self.simplified, self.lowest().map_or(height, |lowest| lowest.min(height)))
    }

    /// The lowest height of the in-flight set. `None` while the position is unknown.
    #[must_use]
    pub fn lowest(&self) -> Option<Height> {
        self.set.lowest()
    }

    /// The rules of this guard.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// The last certified target: the end of the certified motions of the contour, or the target of the last
    /// jog. It is the confirmed position when neither is in flight.
    #[must_use]
    pub fn end(&self) -> Option<FreePlace> {
        if let Some(contour) = &self.contour {
            return Some(contour.end());
        }
        self.set.lines.back().map(|line| line.target).or(self.set.confirmed)
    }

    /// The confirmed position of the tool. `None` while the position is unknown.
    #[must_use]
    pub fn confirmed(&self) -> Option<FreePlace> {
        self.set.confirmed
    }

    /// The in-flight set: the confirmed position, then the targets in flight, in order. Without a checksum,
    /// the confirmed position before it can come first.
    pub fn in_flight(&self) -> impl Iterator<Item = Point> + '_ {
        self.set.places().map(FreePlace::point)
    }

    /// The confirmed position, then the targets in flight of the lines after line `number`, in order.
    pub fn way_after(&self, number: u64) -> impl Iterator<Item = Point> + '_ {
        let lines = self.set.lines.iter().filter(move |line| line.number > number);
        self.set.confirmed.into_iter().chain(lines.map(|line| line.target)).map(FreePlace::point)
    }

    /// Number of lines sent since the guard was made.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.sent
    }

    /// Number of lines sent and not acknowledged.
    #[must_use]
    pub fn unacknowledged(&self) -> u64 {
        self.sent - self.acknowledged
    }
}

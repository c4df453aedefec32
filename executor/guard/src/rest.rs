//! TRUSTED. Rest: the reports that show that the controller has nothing left to do.
//!
//! Implements SR-08.
//!
//! One report can fall between two motions, or be damaged to another valid report. So the guard needs two that agree,
//! or one with a checksum at the last target.
//!
//! A line may arrive twice. Both copies arrive before every query that left later. If the first copy was executed,
//! the second one leads nowhere. If it was rejected, or if a cancel ended its motion, the second copy still moves the
//! tool. While the controller parses it, the copy is in no buffer, and a report at rest does not show it. Two reports
//! would not show it either, if the controller answered both in that time. So after a rejection or a cancel, the
//! query of the second report leaves later than a controller parses a line, counted from the arrival of the first.

use core::time::Duration;

use keepout_kernel::exact::segment::points_within;
use keepout_kernel::{Place, ProhibitedRegion};

use crate::evidence::Evidence;
use crate::in_flight::InFlight;
use crate::{FreePlace, Time};

/// Time within which the controller parses a line. GRBL needs 1 ms to 5 ms.
pub const PARSING: Duration = Duration::from_millis(50);

/// A report at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Rest {
    position: Place,
    /// When the first report at rest arrived, of those in a row that agree.
    since: Time,
}

impl InFlight {
    /// Takes a report at rest of a controller that has answered every line. Returns whether the tool is certainly at
    /// rest. The set then holds only the confirmed position.
    pub(crate) fn settle(&mut self, part: &ProhibitedRegion, evidence: &Evidence<'_>) -> bool {
        let position = evidence.feedback.position;
        let arrived = self.lines.back().is_none_or(|line| self.agrees(line.target.place(), position));
        let again = self.rests_again(evidence);
        let enough = again || self.checked && arrived;
        if enough {
            let height = self.confirmed_height(position.height);
            self.before = None;
            self.lines.clear();
            self.left_queue.clear();
            self.refused = 0;
            self.fastest = 0;
            self.cancelled = None;
            let free = self.reached(part, position.point);
            let known = |known: FreePlace| FreePlace { free: free.unwrap_or(known.free), height };
            self.confirmed = self.confirmed.map(known);
        }
        enough
    }

    /// Whether two places are the same to the resolution.
    fn agrees(&self, one: Place, other: Place) -> bool {
        !points_within(one.point, other.point, self.resolution).is_clear()
            && self.heights.agree(one.height, other.height, 1)
    }

    /// Takes a report at rest. Returns whether an earlier report was at rest at the same place, to the resolution,
    /// with no other report between. After a rejected line or a cancel, the query must also have left later than
    /// [`PARSING`] after the first of these reports arrived. The line may have been repeated, and the copy is in no
    /// buffer while the controller parses it.
    pub(crate) fn rests_again(&mut self, evidence: &Evidence<'_>) -> bool {
        let position = evidence.feedback.position;
        let since = self.rest.filter(|rest| self.agrees(rest.position, position)).map(|rest| rest.since);
        self.rest = Some(Rest { position, since: since.unwrap_or(evidence.now) });
        let at_once = self.refused == 0 && self.cancelled.is_none();
        since.is_some_and(|since| at_once || evidence.asked >= since.after(PARSING))
    }
}

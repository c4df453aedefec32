//! The state of the guard as one value, for state exploration. This file makes no [`super::Certified`].

use alloc::vec::Vec;

use keepout_kernel::{FreePoint, Length, Point};

use crate::contour::ContourCounts;
use crate::{Guard, Time};

/// All changing parts of a guard, except the edge that it checks first. That edge only makes a refusal
/// faster.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct State {
    confirmed: Option<(Point, i32)>,
    before: Option<(Point, i32)>,
    lines: Vec<(u64, Point)>,
    left_queue: Vec<(u64, Time)>,
    left: [u64; 3],
    rests: (u8, Option<Point>),
    cancelled: (Option<u64>, u32, i32),
    counts: [u64; 3],
    contour: Option<(ContourCounts, Point)>,
}

impl Guard {
    /// Greatest distance of the tool from the hull after a cancel.
    #[must_use]
    pub fn stray(&self) -> Length {
        self.set.stray
    }

    /// The state of the guard.
    #[must_use]
    pub fn state(&self) -> State {
        let set = &self.set;
        let place = |free: FreePoint| (free.point(), free.threshold().units());
        State {
            confirmed: set.confirmed.map(place),
            before: set.before.map(place),
            lines: set.lines.iter().map(|line| (line.number, line.target.point())).collect(),
            left_queue: set.left_queue.iter().copied().collect(),
            left: [set.left_before, set.executed, set.refused],
            rests: (set.rests_seen, set.rested_at),
            cancelled: (set.cancelled, set.fastest, set.stray.units()),
            counts: [self.sent, self.acknowledged, self.read],
            contour: self.contour.as_ref().map(|contour| (contour.counts(), contour.end().point())),
        }
    }
}

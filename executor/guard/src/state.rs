//! The state of the guard as one value, for state exploration. This file makes no [`super::Certified`].

use alloc::vec::Vec;

use keepout_kernel::{Length, Place};

use crate::contour::ContourCounts;
use crate::rest::Rest;
use crate::{FreePlace, Guard, Time};

/// All changing parts of a guard, except the edge that it checks first. That edge only makes a refusal
/// faster.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct State {
    confirmed: Option<(Place, i32, u16)>,
    before: Option<(Place, i32, u16)>,
    lines: Vec<(u64, Place)>,
    left_queue: Vec<(u64, Time)>,
    left: [u64; 3],
    rest: Option<Rest>,
    cancelled: (Option<u64>, u32, i32),
    counts: [u64; 3],
    contour: Option<(ContourCounts, Place)>,
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
        let place = |free: FreePlace| (free.place(), free.threshold().units(), free.free().level());
        State {
            confirmed: set.confirmed.map(place),
            before: set.before.map(place),
            lines: set.lines.iter().map(|line| (line.number, line.target.place())).collect(),
            left_queue: set.left_queue.iter().copied().collect(),
            left: [set.left_before, set.executed, set.refused],
            rest: set.rest,
            cancelled: (set.cancelled, set.fastest, set.stray.units()),
            counts: [self.sent, self.acknowledged, self.read],
            contour: self.contour.as_ref().map(|contour| (contour.counts(), contour.end().place())),
        }
    }
}

//! The edges near the last tool position, for queries about points close to it.

use core::ops::ControlFlow;

use super::check::CheckedIndex;
use super::nearest::{Nearest, distance_2};
use crate::curve::{round_up, xy};
use crate::exact::lattice::{Length, Point};
use crate::exact::segment::{Window, points_within};

/// Most edges in a list.
const CAPACITY: usize = 64;
/// Reach of a list beyond the nearest edge, in lattice units: initial, smallest, largest.
const BEYOND: (i64, i64, i64) = (50_000, 5_000, 1_000_000);
/// Queries that go straight to the index after a list did not fit. The number doubles with each failure in a
/// row, up to this many times.
const REST: (u32, u32) = (16, 8);
/// Most edges tested for one list.
const LOOKED_AT: usize = 512;

/// Every edge within a reach of an anchor point. By exact tests the list is complete for a point and a
/// threshold when the anchor is at most reach − threshold away.
///
/// Queries about nearby points cost a pass over a few edges. After a jump the list is built anew. Where too
/// many edges are near for a useful list, queries go to the index.
#[derive(Clone, Debug)]
pub struct NearList {
    anchor: Point,
    /// No unlisted edge is within this (plus its chord error) of the anchor. `None` when the list is not
    /// complete.
    reach: Option<Length>,
    edges: [u32; CAPACITY],
    count: usize,
    beyond: i64,
    last: Option<usize>,
    failures: u32,
    resting: u32,
}

impl Default for NearList {
    fn default() -> Self {
        Self::new()
    }
}

impl NearList {
    /// An empty list.
    #[must_use]
    pub fn new() -> Self {
        Self {
            anchor: Point::ORIGIN,
            reach: None,
            edges: [0; CAPACITY],
            count: 0,
            beyond: BEYOND.0,
            last: None,
            failures: 0,
            resting: 0,
        }
    }

    /// The chord nearest to `point`, as in [`CheckedIndex::nearest`]. Only a proposal.
    pub fn nearest(&mut self, index: &CheckedIndex, point: Point) -> Option<Nearest> {
        if self.reach.is_some()
            && let Some(best) = self.best(index, point)
            && let Ok(within) = Length::from_units(round_up(best.distance()))
            && self.covers(point, within)
        {
            self.last = Some(best.edge);
            return Some(best);
        }
        let nearest = index.nearest(point, self.last)?;
        self.last = Some(nearest.edge);
        self.refill(index, point, nearest.distance());
        Some(nearest)
    }

    /// Whether no edge is within `threshold` of `point`. The answer is always exact.
    pub fn is_clear(&mut self, index: &CheckedIndex, point: Point, threshold: Length) -> bool {
        if !self.covers(point, threshold) {
            self.refill(index, point, f64::from(threshold.units()));
            if !self.covers(point, threshold) {
                return index.near_point(point, threshold).is_none();
            }
        }
        let near = self.listed(index).find(|(_, edge)| !edge.near_point(point, threshold).is_clear());
        near.is_none()
    }

    /// Whether every unlisted edge is farther than `threshold` from `point`: the anchor is at most
    /// `reach − threshold` away.
    fn covers(&self, point: Point, threshold: Length) -> bool {
        let over = self.reach.map(|reach| i64::from(reach.units()) - i64::from(threshold.units()));
        over.and_then(|over| Length::from_units(over).ok())
            .is_some_and(|over| !points_within(self.anchor, point, over).is_clear())
    }

    fn listed<'a>(&'a self, index: &'a CheckedIndex) -> impl Iterator<Item = (usize, &'a super::Edge)> + 'a {
        self.edges[..self.count].iter().filter_map(|&number| {
            let number = number as usize;
            index.edges().get(number).map(|edge| (number, edge))
        })
    }

    #[inline]
    fn best(&self, index: &CheckedIndex, point: Point) -> Option<Nearest> {
        let at = xy(point);
        let mut best: Option<Nearest> = None;
        for (edge, listed) in self.listed(index) {
            let distance_2 = distance_2(at, listed.chord);
            if best.is_none_or(|best| distance_2 < best.distance_2) {
                best = Some(Nearest { edge, distance_2 });
            }
        }
        best
    }

    fn refill(&mut self, index: &CheckedIndex, point: Point, distance: f64) {
        self.reach = None;
        if self.resting > 0 {
            self.resting -= 1;
            return;
        }
        let distance = round_up(distance);
        let Ok(reach) = Length::from_units(distance.saturating_add(self.beyond)) else { return };
        (self.anchor, self.count) = (point, 0);
        let mut looked_at = 0;
        let complete = index.visit(Window::of(point).grown(reach), |number, edge| {
            looked_at += 1;
            if looked_at > LOOKED_AT {
                return ControlFlow::Break(());
            }
            if edge.near_point(point, reach).is_clear() {
                return ControlFlow::Continue(());
            }
            let (Some(slot), Ok(number)) = (self.edges.get_mut(self.count), u32::try_from(number)) else {
                return ControlFlow::Break(());
            };
            *slot = number;
            self.count += 1;
            ControlFlow::Continue(())
        });
        if complete.is_continue() {
            self.reach = Some(reach);
            self.failures = 0;
            if self.count < CAPACITY / 4 {
                self.beyond = (self.beyond * 2).min(BEYOND.2);
            }
        } else {
            self.beyond = (self.beyond / 2).max(BEYOND.1);
            self.resting = REST.0 << self.failures;
            self.failures = (self.failures + 1).min(REST.1);
        }
    }
}

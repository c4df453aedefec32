//! The nearest chord, in `f64`. A proposal: safety queries use exact thresholds only.

#![expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "bounds are relaxed by more than f32 rounding; the rest proposes"
)]

use super::Edge;
use super::check::{CheckedIndex, LANES, LEAF, Node};
use crate::curve::round_down;
use crate::exact::lattice::{Length, Point};
use crate::exact::segment::{Segment, Window};
use crate::vec2::Vec2;

/// The chord nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Its number in [`CheckedIndex::edges`].
    pub edge: usize,
    /// The square of its distance, in square lattice units.
    pub distance_2: f64,
}

impl Nearest {
    /// The distance in lattice units.
    #[must_use]
    pub fn distance(&self) -> f64 {
        libm::sqrt(self.distance_2)
    }
}

/// A factor below 1 that lowers a bound in `f32` by more than its few roundings of 2^-24.
const F32_SHARE: f32 = 1.0 - 1.0 / 1_048_576.0;
/// Bound on the rounding of a difference of two coordinates in `f32`. A coordinate below 2^30 is off by at
/// most 32 units.
const F32_OFF: f32 = 192.0;

impl CheckedIndex {
    /// The chord nearest to `point`. Returns `None` without edges, or when `hint` is not an edge number. A
    /// `hint`, such as the answer for a near point, saves time. It does not change the distance found.
    #[must_use]
    pub fn nearest(&self, point: Point, hint: Option<usize>) -> Option<Nearest> {
        let start = hint.unwrap_or(0);
        let (at, first) = (Vec2::from(point), self.edges().get(start)?);
        let best = Nearest { edge: start, distance_2: distance_2(at, first.chord) };
        let mut search = Search { index: self, at, best };
        search.descend(self.levels().len().checked_sub(1)?, 0);
        Some(search.best)
    }

    /// A certified lower bound on the distance from `point` to the true curves, within two units of that
    /// distance. Returns `None` for a point on a curve.
    ///
    /// `point` is certified clear at this threshold. It is the largest threshold that the search for the
    /// nearest chord finds.
    #[must_use]
    pub fn clearance(&self, point: Point) -> Option<Length> {
        let mut reach = f64::from(crate::exact::lattice::COORD_MAX);
        // Chord errors differ: a chord farther away can belong to a nearer true curve.
        let mut hint = None;
        for _ in 0..4 {
            let nearest = self.nearest(point, hint)?;
            reach = reach.min(least_distance(point, self.edges().get(nearest.edge)?));
            let below = (round_down(reach) - 1).max(0);
            let threshold = Length::from_units(below).ok()?;
            match self.near_point(point, threshold) {
                None => return Some(threshold),
                Some(edge) => {
                    reach = reach.min(least_distance(point, edge)) - 1.0;
                    hint = Some(nearest.edge);
                }
            }
        }
        // Many different chord errors: halve the interval instead.
        let (mut low, mut high) = (-1_i64, round_down(reach.max(0.0)));
        while high - low > 1 {
            let middle = i64::midpoint(low, high);
            match Length::from_units(middle) {
                Ok(threshold) if self.near_point(point, threshold).is_none() => low = middle,
                _ => high = middle,
            }
        }
        Length::from_units(low).ok()
    }
}

struct Search<'a> {
    index: &'a CheckedIndex,
    at: Vec2,
    best: Nearest,
}

impl Search<'_> {
    /// Enters the boxes of a node that are nearer than the best edge so far, nearest box first.
    fn descend(&mut self, level: usize, number: usize) {
        let Some(node) = self.index.levels()[level].get(number) else { return };
        let (bounds, mut lanes) = self.bounds(node);
        while lanes != 0 {
            let (mut least, mut chosen) = (f32::INFINITY, 0);
            let mut rest = lanes;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                if bounds[lane] < least {
                    (least, chosen) = (bounds[lane], lane);
                }
            }
            if f64::from(least) >= self.best.distance_2 {
                return;
            }
            lanes &= !(1 << chosen);
            let child = number * LANES + chosen;
            match level.checked_sub(1) {
                Some(level) => self.descend(level, child),
                None => self.leaf(child),
            }
        }
    }

    /// Lower bounds on the squared distances to the boxes of a node, and the lanes that can be nearer than
    /// the best edge.
    #[inline(always)]
    fn bounds(&self, node: &Node) -> ([f32; LANES], u8) {
        let (x, y) = (self.at.x as f32, self.at.y as f32);
        let [min_x, min_y, max_x, max_y] = node.corners();
        let gap = |low: i32, high: i32, c: f32| (low as f32 - c).max(c - high as f32).max(F32_OFF) - F32_OFF;
        let within = (self.best.distance_2 as f32) * (2.0 - F32_SHARE);
        let mut bounds = [0.0_f32; LANES];
        let mut nearer = [false; LANES];
        for lane in 0..LANES {
            let (dx, dy) = (gap(min_x[lane], max_x[lane], x), gap(min_y[lane], max_y[lane], y));
            bounds[lane] = (dx * dx + dy * dy) * F32_SHARE;
            nearer[lane] = bounds[lane] < within;
        }
        let lanes = nearer.into_iter().rev().fold(0, |lanes, nearer| (lanes << 1) | u8::from(nearer));
        (bounds, lanes)
    }

    #[inline(always)]
    fn leaf(&mut self, block: usize) {
        let edges = self.index.edges().get(block * LEAF..).unwrap_or(&[]);
        for (lane, edge) in edges.iter().take(LEAF).enumerate() {
            let found = distance_2(self.at, edge.chord);
            if found < self.best.distance_2 {
                self.best = Nearest { edge: block * LEAF + lane, distance_2: found };
            }
        }
    }
}

impl CheckedIndex {
    /// Whether exact tests confirm `nearest`: its edge is at the stated distance, and no edge is nearer by
    /// more than a unit.
    #[must_use]
    pub fn confirms(&self, point: Point, nearest: Nearest) -> bool {
        let Some(edge) = self.edges().get(nearest.edge) else { return false };
        let length = |units: i64| Length::from_units(units);
        let distance = round_down(nearest.distance());
        let reached = length(distance + 1).is_ok_and(|reach| !edge.chord.near_point(point, reach).is_clear());
        // `Edge::near_point` would add the chord error. This test is about chords only.
        let nearer = length(distance - 1).is_ok_and(|within| {
            let window = Window::of(point).grown(within);
            self.first(window, |edge| edge.chord.near_point(point, within)).is_some()
        });
        reached && !nearer
    }
}

/// The square of the distance from a point to a chord.
#[inline(always)]
#[must_use]
pub fn distance_2(point: Vec2, chord: Segment) -> f64 {
    let (a, b) = (Vec2::from(chord.from), Vec2::from(chord.to));
    let (along, w) = (b - a, point - a);
    let share = (w.dot(along) / along.dot(along).max(1.0)).clamp(0.0, 1.0);
    let off = w - along * share;
    off.dot(off)
}

/// A lower bound on the distance from a point to the true curve of an edge.
pub(crate) fn least_distance(point: Point, edge: &Edge) -> f64 {
    libm::sqrt(distance_2(Vec2::from(point), edge.chord)) - f64::from(edge.chord_error.units())
}

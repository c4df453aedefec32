//! The nearest chord, in `f64`. A proposal: safety asks thresholds only.

#![expect(
    clippy::cast_precision_loss,
    reason = "bounds are relaxed by more than f32 rounding; the rest proposes"
)]

use super::Edge;
use super::check::{CheckedIndex, LANES, Node};
use crate::exact::lattice::{Length, Point};
use crate::exact::segment::Segment;

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

/// Levels of an index: it has at most 2^30 edges.
const LEVELS: usize = 11;
/// Bounds in `f32` carry three roundings of 2^-24 and one of a conversion: less than this share.
const F32_SHARE: f32 = 1.0 - 1.0 / 1_048_576.0;

impl CheckedIndex {
    /// The chord nearest to `point`; `None` without edges. A `hint`, such as the answer for a point near by, saves time
    /// and does not change the distance found.
    #[must_use]
    pub fn nearest(&self, point: Point, hint: Option<usize>) -> Option<Nearest> {
        let start = hint.unwrap_or(0);
        let (at, first) = (xy(point), self.edges().get(start)?);
        let mut best = Nearest { edge: start, distance_2: distance_2(at, first.chord) };
        let levels = self.levels();
        let mut path = [Step { node: 0, lanes: 0, bounds: [0.0; LANES] }; LEVELS];
        let top = levels.len().checked_sub(1)?;
        let mut level = top;
        path[level].enter(&levels[level][0], 0, point, best.distance_2);
        loop {
            let Some(child) = path[level].next(best.distance_2) else {
                if level == top {
                    return Some(best);
                }
                level += 1;
                continue;
            };
            if level > 0 {
                if let Some(node) = levels[level - 1].get(child) {
                    level -= 1;
                    path[level].enter(node, child, point, best.distance_2);
                }
                continue;
            }
            let block = self.edges().get(child * LANES..).unwrap_or(&[]);
            for (lane, edge) in block.iter().take(LANES).enumerate() {
                let found = distance_2(at, edge.chord);
                if found < best.distance_2 {
                    best = Nearest { edge: child * LANES + lane, distance_2: found };
                }
            }
        }
    }

    /// A threshold at which `point` is certified clear, as large as the search for the nearest chord finds it: a
    /// certified lower bound on the distance to the true curves, within two units of it. `None` on a curve.
    #[must_use]
    pub fn clearance(&self, point: Point) -> Option<Length> {
        let mut reach = f64::from(crate::exact::lattice::COORD_MAX);
        // Slacks differ: an edge farther away may be nearer when its slack is taken off.
        let mut hint = None;
        for _ in 0..4 {
            let nearest = self.nearest(point, hint)?;
            let slack = self.edges().get(nearest.edge).map_or(0, |edge| edge.slack.units());
            reach = reach.min(nearest.distance() - f64::from(slack));
            let below = (crate::curve::round_down(reach) - 1).max(0);
            let threshold = Length::from_units(below).ok()?;
            match self.near_point(point, threshold) {
                None => return Some(threshold),
                Some(edge) => {
                    let blocking = libm::sqrt(distance_2(xy(point), edge.chord));
                    reach = reach.min(blocking - f64::from(edge.slack.units())) - 1.0;
                    hint = Some(nearest.edge);
                }
            }
        }
        // Many slacks: halve the interval instead.
        let (mut low, mut high) = (-1_i64, crate::curve::round_down(reach.max(0.0)));
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

/// A node on the way down: the lanes still to be entered, and the squares of the least distances to their boxes.
#[derive(Clone, Copy)]
struct Step {
    node: usize,
    lanes: u8,
    bounds: [f32; LANES],
}

impl Step {
    #[inline(always)]
    fn enter(&mut self, node: &Node, number: usize, point: Point, within_2: f64) {
        let (x, y) = (point.x.units(), point.y.units());
        let [min_x, min_y, max_x, max_y] = node.corners();
        let gap = |low: i32, high: i32, c: i32| low.wrapping_sub(c).max(c.wrapping_sub(high)).max(0) as f32;
        let mut bounds = [0.0_f32; LANES];
        for lane in 0..LANES {
            let (dx, dy) = (gap(min_x[lane], max_x[lane], x), gap(min_y[lane], max_y[lane], y));
            bounds[lane] = (dx * dx + dy * dy) * F32_SHARE;
        }
        let mut lanes = 0;
        for (lane, &bound) in bounds.iter().enumerate() {
            lanes |= u8::from(f64::from(bound) < within_2) << lane;
        }
        *self = Self { node: number, lanes, bounds };
    }

    /// The box with the least bound that is not yet entered, if that is below `within_2`.
    #[inline(always)]
    fn next(&mut self, within_2: f64) -> Option<usize> {
        let (mut least, mut chosen) = (f32::INFINITY, None);
        let mut rest = self.lanes;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            if self.bounds[lane] < least {
                (least, chosen) = (self.bounds[lane], Some(lane));
            }
        }
        let lane = chosen.filter(|_| f64::from(least) < within_2)?;
        self.lanes &= !(1 << lane);
        Some(self.node * LANES + lane)
    }
}

pub(crate) fn xy(point: Point) -> (f64, f64) {
    (f64::from(point.x.units()), f64::from(point.y.units()))
}

/// The square of the distance from a point to a chord.
#[inline(always)]
pub(crate) fn distance_2((x, y): (f64, f64), chord: Segment) -> f64 {
    let (a, b) = (xy(chord.from), xy(chord.to));
    let (dx, dy, wx, wy) = (b.0 - a.0, b.1 - a.1, x - a.0, y - a.1);
    let length_2 = dx * dx + dy * dy;
    let t = ((wx * dx + wy * dy) / length_2.max(1.0)).clamp(0.0, 1.0);
    let (ox, oy) = (wx - t * dx, wy - t * dy);
    ox * ox + oy * oy
}

/// The distance of an edge's true curve from a point, at least.
pub(crate) fn least_distance(point: Point, edge: &Edge) -> f64 {
    libm::sqrt(distance_2(xy(point), edge.chord)) - f64::from(edge.slack.units())
}

//! Drops contours that are drawn twice, not quite in the same place. The ring between them is as thin as the
//! joining tolerance, so it is not a wall of the part.
//!
//! Implements SR-27.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::{CheckedIndex, Edge, build};
use keepout_kernel::{Length, Point, Segment, Vec2};

use super::{Chained, JOIN_MM, Problem, Repair};
use crate::profile::{ProfileLoop, corners};
use crate::units::length_up_from_mm;

/// Chord-error bound of the chords that replace arcs (1 µm).
const CHORD_ERROR: Length = Length::small(100);

/// Drops every contour that repeats a kept contour.
///
/// One contour repeats another if each stays within reach of the other over its whole length, and both
/// enclose the same area. The reach is `join_mm`, but at most [`JOIN_MM`], plus the chord errors of both
/// contours (2 µm). So a wider ring is a wall of the part, even if `join_mm` is larger.
///
/// The first of two such contours is kept. A contour is compared with kept contours only: in a row of near
/// contours, a dropped contour does not cause the next to be dropped.
pub(super) fn drop_contours(chained: &mut Chained, join_mm: f64) {
    let Ok(reach) = length_up_from_mm(join_mm.clamp(0.0, JOIN_MM)) else { return };
    let reach = reach.saturating_plus(CHORD_ERROR).saturating_plus(CHORD_ERROR);
    let loops = &chained.profile.loops;
    let mut gone = vec![false; loops.len()];
    // The boxes of the kept contours, ordered by their left sides.
    let mut kept: BTreeMap<(i32, usize), Window> = BTreeMap::new();
    for (i, each) in loops.iter().enumerate() {
        let Some(own) = box_of(each) else { continue };
        let left = own.corners().0;
        let beside =
            (left.saturating_sub(reach.units()), 0)..=(left.saturating_add(reach.units()), usize::MAX);
        let doubled = |(&(_, j), &other): (&(i32, usize), &Window)| {
            alike(own, other, reach) && stay_near(each, &loops[j], reach)
        };
        gone[i] = kept.range(beside).any(doubled);
        if !gone[i] {
            kept.insert((left, i), own);
            continue;
        }
        let at = each.edges.first().map_or(Point::ORIGIN, |edge| edge.curve.from());
        let length: f64 = each.edges.iter().map(|edge| edge.curve.length()).sum();
        let length_mm = length / f64::from(keepout_kernel::UNITS_PER_MM);
        chained.repairs.push(Repair::DuplicateDropped { at, length_mm });
    }
    let mut index = 0;
    let mut stays = |_: &_| {
        index += 1;
        !gone[index - 1]
    };
    chained.profile.loops.retain(&mut stays);
    index = 0;
    chained.layers.retain(|_| {
        index += 1;
        !gone[index - 1]
    });
}

/// Drops every open chain that stays within reach of the closed contours over its whole length: a side that is drawn
/// twice, not quite in the same place. Its problems go with it. A chain that is not longer than the reach stays.
pub(super) fn drop_chains(chained: &mut Chained, join_mm: f64) {
    let Ok(reach) = length_up_from_mm(join_mm.clamp(0.0, JOIN_MM)) else { return };
    let reach = reach.saturating_plus(CHORD_ERROR).saturating_plus(CHORD_ERROR);
    if chained.open.is_empty() {
        return;
    }
    let edges = chained.profile.loops.iter().flat_map(|each| {
        let corners = corners(each.curves(), CHORD_ERROR);
        let next: Vec<Point> = corners.iter().cycle().skip(1).take(corners.len()).copied().collect();
        corners
            .into_iter()
            .zip(next)
            .map(|(from, to)| Edge { chord: Segment { from, to }, chord_error: Length::ZERO })
    });
    let Ok(index) = build::build(edges.collect()) else { return };
    let near = Near { index: &index, reach };
    let (mut dropped, mut ends) = (Vec::new(), Vec::new());
    for (number, chain) in chained.open.iter().enumerate() {
        let mut points = corners(chain.curves.iter(), CHORD_ERROR);
        points.extend(chain.curves.last().map(keepout_kernel::Curve::to));
        let stays = points.windows(2).all(|pair| near.stays(Segment { from: pair[0], to: pair[1] }));
        if !points.is_empty() && near.has(points.iter().copied()) && stays {
            let length: f64 = chain.curves.iter().map(keepout_kernel::Curve::length).sum();
            let length_mm = length / f64::from(keepout_kernel::UNITS_PER_MM);
            chained.repairs.push(Repair::DuplicateDropped { at: points[0], length_mm });
            ends.extend([points.first(), points.last()].into_iter().flatten().copied());
            dropped.push(number);
        }
    }
    let mut number = 0;
    chained.open.retain(|_| {
        number += 1;
        !dropped.contains(&(number - 1))
    });
    let of_dropped = |problem: &Problem| {
        matches!(problem, Problem::Open { .. } | Problem::Tee { .. }) && ends.contains(&problem.at())
    };
    chained.problems.retain(|problem| !of_dropped(problem));
}

fn box_of(each: &ProfileLoop) -> Option<Window> {
    corners(each.curves(), CHORD_ERROR).into_iter().map(Window::of).reduce(Window::union)
}

/// Whether the boxes differ by at most `reach` on each side.
fn alike(one: Window, other: Window, reach: Length) -> bool {
    let ((a, b, c, d), (e, f, g, h)) = (one.corners(), other.corners());
    [(a, e), (b, f), (c, g), (d, h)].into_iter().all(|(p, q)| p.abs_diff(q) <= reach.units().unsigned_abs())
}

fn stay_near(one: &ProfileLoop, other: &ProfileLoop, reach: Length) -> bool {
    let (one, other) = (corners(one.curves(), CHORD_ERROR), corners(other.curves(), CHORD_ERROR));
    enclose_the_same(&one, &other, reach) && all_near(&one, &other, reach) && all_near(&other, &one, reach)
}

/// Whether two contours enclose the same area, up to a strip along the longer one.
///
/// A thin C-shaped contour is near a circle over its whole length, but encloses another area.
fn enclose_the_same(one: &[Point], other: &[Point], reach: Length) -> bool {
    let ends = |corners: &[Point]| {
        let to = corners.iter().cycle().skip(1).copied();
        corners.iter().copied().zip(to).map(|(p, q)| (Vec2::from(p), Vec2::from(q))).collect::<Vec<_>>()
    };
    let (one, other) = (ends(one), ends(other));
    let area = |ends: &[(Vec2, Vec2)]| ends.iter().map(|(p, q)| p.cross(*q)).sum::<f64>().abs() / 2.0;
    let length = |ends: &[(Vec2, Vec2)]| ends.iter().map(|(p, q)| p.distance(*q)).sum::<f64>();
    let strip = 2.0 * f64::from(reach.units()) * length(&one).max(length(&other));
    (area(&one) - area(&other)).abs() <= strip
}

/// Whether one contour stays within `reach` of the other over its whole length.
fn all_near(corners: &[Point], other: &[Point], reach: Length) -> bool {
    let ends = other.iter().zip(other.iter().cycle().skip(1));
    let edges = ends.map(|(&from, &to)| Edge { chord: Segment { from, to }, chord_error: Length::ZERO });
    let Ok(index) = build::build(edges.collect()) else { return false };
    let near = Near { index: &index, reach };
    let stretches = corners.iter().zip(corners.iter().cycle().skip(1));
    near.has(corners.iter().copied())
        && stretches.into_iter().all(|(&from, &to)| near.stays(Segment { from, to }))
}

/// A contour's edges, and the largest distance from them that counts as near.
struct Near<'a> {
    index: &'a CheckedIndex,
    reach: Length,
}

impl Near<'_> {
    fn has(&self, points: impl IntoIterator<Item = Point>) -> bool {
        points.into_iter().all(|point| self.shares_edge(point, point))
    }

    /// Whether a stretch stays within reach, if both its ends are within reach.
    ///
    /// It does if both ends are within reach of the same edge, because the distance from a segment is convex.
    /// Any other stretch is halved, down to the length of the chord-error bound.
    fn stays(&self, stretch: Segment) -> bool {
        let Segment { from, to } = stretch;
        let d = to.minus(from);
        if self.shares_edge(from, to) || d.dx.abs().max(d.dy.abs()) <= CHORD_ERROR.units() {
            return true;
        }
        let mean = |a: i32, b: i32| (i64::from(a) + i64::from(b)) / 2;
        let middle =
            Point::from_units(mean(from.x.units(), to.x.units()), mean(from.y.units(), to.y.units()));
        let Ok(middle) = middle else { return false };
        self.has([middle])
            && self.stays(Segment { from, to: middle })
            && self.stays(Segment { from: middle, to })
    }

    /// Whether both points are within reach of the same edge.
    fn shares_edge(&self, one: Point, other: Point) -> bool {
        self.index
            .visit(Window::of(one).grown(self.reach), |_, edge| {
                if [one, other].iter().any(|&point| edge.chord.near_point(point, self.reach).is_clear()) {
                    ControlFlow::Continue(())
                } else {
                    ControlFlow::Break(())
                }
            })
            .is_break()
    }
}

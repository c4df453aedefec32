//! Contours drawn twice, not quite in the same place: a ring as thin as the joining tolerance is nobody's part.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::{CheckedIndex, Edge, build};
use keepout_kernel::{Length, Point, Segment};

use super::{Chained, Repair};
use crate::profile::{ProfileLoop, corners};
use crate::units::length_up_from_mm;

/// Chords stand for arcs within this, lattice units (1 µm).
const COARSE: Length = Length::small(100);

/// Leaves out every contour that stays within `join_mm` of one that is kept, all round and the other way as well. Of two the one
/// before is kept, but for one that was left out itself: contours side by side do not take each other's place in a row.
pub(super) fn drop_contours(chained: &mut Chained, join_mm: f64) {
    let Ok(reach) = length_up_from_mm(join_mm.max(0.0)) else { return };
    let reach = reach.saturating_plus(COARSE).saturating_plus(COARSE);
    let loops = &chained.profile.loops;
    let mut gone = vec![false; loops.len()];
    // Those that are kept, by their left sides.
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

fn box_of(each: &ProfileLoop) -> Option<Window> {
    corners(each.curves(), COARSE).into_iter().map(Window::of).reduce(Window::union)
}

/// Whether the boxes differ by no more than the reach on any side.
fn alike(one: Window, other: Window, reach: Length) -> bool {
    let ((a, b, c, d), (e, f, g, h)) = (one.corners(), other.corners());
    [(a, e), (b, f), (c, g), (d, h)].into_iter().all(|(p, q)| p.abs_diff(q) <= reach.units().unsigned_abs())
}

fn stay_near(one: &ProfileLoop, other: &ProfileLoop, reach: Length) -> bool {
    let (one, other) = (corners(one.curves(), COARSE), corners(other.curves(), COARSE));
    all_near(&one, &other, reach) && all_near(&other, &one, reach)
}

/// Whether every corner, and the middle between each two, is within reach of the other contour.
fn all_near(corners: &[Point], other: &[Point], reach: Length) -> bool {
    let ends = other.iter().zip(other.iter().cycle().skip(1));
    let edges = ends.map(|(&from, &to)| Edge { chord: Segment { from, to }, slack: Length::ZERO });
    let Ok(index) = build::build(edges.collect()) else { return false };
    let middle = |p: Point, q: Point| {
        let mean = |a: i32, b: i32| (i64::from(a) + i64::from(b)) / 2;
        Point::from_units(mean(p.x.units(), q.x.units()), mean(p.y.units(), q.y.units())).unwrap_or(p)
    };
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    pairs.into_iter().all(|(&p, &q)| is_near(&index, p, reach) && is_near(&index, middle(p, q), reach))
}

fn is_near(index: &CheckedIndex, point: Point, reach: Length) -> bool {
    index
        .visit(Window::of(point).grown(reach), |_, edge| {
            if edge.chord.near_point(point, reach).is_clear() {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        })
        .is_break()
}

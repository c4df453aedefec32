//! Ways through clear space: a grid search whose every step the kernel certifies.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{FreePoint, Point, ProhibitedRegion};

use crate::units::{point_from_mm, point_mm};

/// Grid cells along the longer side of the searched box, from coarse to fine.
const CELLS: [f64; 3] = [48.0, 128.0, 320.0];

type Node = (i32, i32);

/// Straight motions from `from` to `to` inside `within`, each certified at the threshold of `from`; the points that
/// follow `from`, last of them `to`. `None` when the finest grid finds none.
#[must_use]
pub fn route(part: &ProhibitedRegion, from: FreePoint, to: Point, within: Window) -> Option<Vec<Point>> {
    if part.motion(from, to).is_ok() {
        return Some(vec![to]);
    }
    let found = CELLS.iter().find_map(|&cells| search(part, from, to, within, cells))?;
    Some(shortened(part, from, &found))
}

struct Grid {
    origin: (f64, f64),
    cell: f64,
    within: Window,
}

impl Grid {
    fn point(&self, (i, j): Node) -> Option<Point> {
        let at = (self.origin.0 + f64::from(i) * self.cell, self.origin.1 + f64::from(j) * self.cell);
        point_from_mm(at).ok().filter(|&point| self.within.holds(point))
    }

    fn steps_to(&self, (i, j): Node, goal: (f64, f64)) -> f64 {
        let (x, y) = (self.origin.0 + f64::from(i) * self.cell, self.origin.1 + f64::from(j) * self.cell);
        (x - goal.0).hypot(y - goal.1) / self.cell
    }
}

/// A* over the grid around `from`; every edge that is followed was certified.
fn search(
    part: &ProhibitedRegion,
    from: FreePoint,
    to: Point,
    within: Window,
    cells: f64,
) -> Option<Vec<Point>> {
    let (x0, y0, x1, y1) = within.corners();
    let span = f64::from(x1.saturating_sub(x0)).max(f64::from(y1.saturating_sub(y0)));
    let cell = span / cells / f64::from(keepout_kernel::UNITS_PER_MM);
    let grid = Grid { origin: point_mm(from.point()), cell, within };
    let goal = point_mm(to);
    let mut reached: BTreeMap<Node, (Node, FreePoint, f64)> = BTreeMap::new();
    reached.insert((0, 0), ((0, 0), from, 0.0));
    let mut open = BinaryHeap::new();
    open.push((Reverse(rank(0.0, grid.steps_to((0, 0), goal))), (0, 0)));
    let mut closed = std::collections::BTreeSet::new();
    while let Some((_, node)) = open.pop() {
        if !closed.insert(node) {
            continue;
        }
        let &(_, free, cost) = reached.get(&node)?;
        if grid.steps_to(node, goal) < 3.0 && part.motion(free, to).is_ok() {
            return Some(walk_back(&reached, node, to));
        }
        for (di, dj) in (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (di, dj))) {
            let next = (node.0 + di, node.1 + dj);
            let cost = cost + f64::from(di).hypot(f64::from(dj));
            let known = reached.get(&next).is_some_and(|&(_, _, known)| known <= cost + 1e-9);
            if known || closed.contains(&next) {
                continue;
            }
            if let Some(free) = grid.point(next).and_then(|point| part.motion(free, point).ok()) {
                reached.insert(next, (node, free, cost));
                open.push((Reverse(rank(cost, grid.steps_to(next, goal))), next));
            }
        }
    }
    None
}

/// Order of visiting: cost so far and the straight rest, in thousandths of a cell.
fn rank(cost: f64, rest: f64) -> i64 {
    keepout_kernel::curve::nearest_unit((cost + rest) * 1000.0)
}

fn walk_back(reached: &BTreeMap<Node, (Node, FreePoint, f64)>, last: Node, to: Point) -> Vec<Point> {
    let mut points = vec![to];
    let mut node = last;
    while let Some(&(before, free, _)) = reached.get(&node) {
        if before == node {
            break;
        }
        points.push(free.point());
        node = before;
    }
    points.reverse();
    points
}

/// Leaves out every point that a certified straight motion can skip.
fn shortened(part: &ProhibitedRegion, from: FreePoint, points: &[Point]) -> Vec<Point> {
    let mut kept = Vec::new();
    let mut here = from;
    let mut next = 0;
    while next < points.len() {
        let farthest =
            (next..points.len()).rev().find_map(|k| part.motion(here, points[k]).ok().map(|free| (k, free)));
        let Some((k, free)) = farthest else { return points.to_vec() };
        kept.push(points[k]);
        (here, next) = (free, k + 1);
    }
    kept
}

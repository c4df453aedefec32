//! Link moves: a grid search in which the kernel certifies every step.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::SQRT_2;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{FreePoint, Point, ProhibitedRegion};

use crate::units::{point_from_mm, point_mm};

/// Numbers of grid cells along the longer side of the searched box, from coarse to fine.
const CELLS: [f64; 3] = [48.0, 128.0, 320.0];

type Node = (i32, i32);

/// Straight motions from `from` to `to` inside `within`, each certified at the clearance of `from`. The
/// result holds the points after `from`; the last one is `to`. `None` when the search fails on every
/// grid.
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

/// Steps from a node, with the length of each in cells.
const STEPS: [(Node, f64); 8] = [
    ((-1, -1), SQRT_2),
    ((-1, 0), 1.0),
    ((-1, 1), SQRT_2),
    ((0, -1), 1.0),
    ((0, 1), 1.0),
    ((1, -1), SQRT_2),
    ((1, 0), 1.0),
    ((1, 1), SQRT_2),
];

/// A node that the search reached.
#[derive(Clone, Copy)]
struct Reached {
    free: FreePoint,
    /// Length of the path to it, in cells.
    cost: f64,
    before: Node,
    /// The search has expanded it.
    closed: bool,
}

/// State of every node of a grid.
struct Field {
    low: Node,
    columns: i32,
    nodes: Vec<Option<Reached>>,
}

impl Field {
    /// An empty field over the grid in its window.
    fn new(grid: &Grid) -> Self {
        let (x0, y0, x1, y1) = grid.within.corners();
        let unit_mm = f64::from(keepout_kernel::UNITS_PER_MM);
        let index = |c: i32, origin: f64| {
            let steps = ((f64::from(c) / unit_mm - origin) / grid.cell).floor();
            i32::try_from(keepout_kernel::curve::nearest_unit(steps)).unwrap_or(0)
        };
        let low = (index(x0, grid.origin.0) - 1, index(y0, grid.origin.1) - 1);
        let high = (index(x1, grid.origin.0) + 2, index(y1, grid.origin.1) + 2);
        let (columns, lines) = (high.0 - low.0 + 1, high.1 - low.1 + 1);
        let count = usize::try_from(i64::from(columns.max(0)) * i64::from(lines.max(0))).unwrap_or(0);
        Self { low, columns, nodes: vec![None; count] }
    }

    /// State of a node; `None` for a node beyond the grid.
    fn at(&mut self, (i, j): Node) -> Option<&mut Option<Reached>> {
        let (column, line) = (i.checked_sub(self.low.0)?, j.checked_sub(self.low.1)?);
        let inside = (0..self.columns).contains(&column) && line >= 0;
        let index = i64::from(line) * i64::from(self.columns) + i64::from(column);
        self.nodes.get_mut(usize::try_from(index).ok().filter(|_| inside)?)
    }

    fn reached(&mut self, node: Node) -> Option<&mut Reached> {
        self.at(node)?.as_mut()
    }

    fn walk_back(&mut self, last: Node, to: Point) -> Vec<Point> {
        let mut points = vec![to];
        let mut node = last;
        while let Some(&mut Reached { before, free, .. }) = self.reached(node).filter(|at| at.before != node)
        {
            points.push(free.point());
            node = before;
        }
        points.reverse();
        points
    }
}

/// A* over the grid around `from`. It follows only certified edges.
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
    let mut field = Field::new(&grid);
    *field.at((0, 0))? = Some(Reached { free: from, cost: 0.0, before: (0, 0), closed: false });
    let mut open = BinaryHeap::new();
    open.push((Reverse(rank(0.0, grid.steps_to((0, 0), goal))), (0, 0)));
    while let Some((_, node)) = open.pop() {
        let here = field.reached(node)?;
        if std::mem::replace(&mut here.closed, true) {
            continue;
        }
        let Reached { free, cost, .. } = *here;
        if grid.steps_to(node, goal) < 3.0 && part.motion(free, to).is_ok() {
            return Some(field.walk_back(node, to));
        }
        for ((di, dj), length) in STEPS {
            let next = (node.0 + di, node.1 + dj);
            let cost = cost + length;
            let Some(known) = field.at(next) else { continue };
            if known.is_some_and(|known| known.closed || known.cost <= cost + 1e-9) {
                continue;
            }
            if let Some(free) = grid.point(next).and_then(|point| part.motion(free, point).ok()) {
                *known = Some(Reached { free, cost, before: node, closed: false });
                open.push((Reverse(rank(cost, grid.steps_to(next, goal))), next));
            }
        }
    }
    None
}

/// Priority of a node: the cost so far and the straight distance to the goal, in thousandths of a cell.
fn rank(cost: f64, rest: f64) -> i64 {
    keepout_kernel::curve::nearest_unit((cost + rest) * 1000.0)
}

/// Removes every point that a certified straight motion can skip.
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

//! Walk over the mesh: the triangle that holds a point, and the edge nearest to it.
//!
//! Implements SR-03.

use keepout_kernel::Vec2;
use keepout_kernel::exact::lattice::Point;
use keepout_kernel::exact::predicate::Orientation;
use keepout_kernel::exact::segment::{Segment, orientation};
use keepout_kernel::index::CheckedIndex;
use keepout_kernel::index::nearest::{Nearest, distance_2};

use super::{Mesh, NONE};

/// State of a walk. A walk allocates only while its queue grows.
#[derive(Clone, Debug)]
pub struct Walk {
    last: usize,
    /// For each triangle, the last search that entered it.
    entered: Vec<u32>,
    search: u32,
    queue: Vec<u32>,
}

impl Walk {
    pub(super) fn over(mesh: &Mesh) -> Self {
        Self { last: 0, entered: vec![0; mesh.triangles.len()], search: 0, queue: Vec::new() }
    }

    /// The triangle that holds `point`, found by a walk from the last one; `None` outside the frame.
    ///
    /// From each triangle the walk crosses a side that has the point strictly on its other side. In a
    /// constrained triangulation such a walk could go in circles. The side that is tried first therefore
    /// changes with every step. After more steps than triangles, a search through all triangles follows.
    pub fn locate(&mut self, mesh: &Mesh, point: Point) -> Option<usize> {
        let mut at = self.last.min(mesh.triangles.len().checked_sub(1)?);
        for step in 0..=mesh.triangles.len() {
            let triangle = &mesh.triangles[at];
            let beyond = (0..3).map(|k| (k + step) % 3).find(|&side| !mesh.has_on_left(at, side, point));
            let Some(side) = beyond else {
                self.last = at;
                return Some(at);
            };
            if triangle.across[side] == NONE {
                return None;
            }
            at = triangle.across[side] as usize;
        }
        (0..mesh.triangles.len()).find(|&at| (0..3).all(|side| mesh.has_on_left(at, side, point)))
    }

    /// The connected component between walls that holds `point`; 0 is the one at the frame. A point on a
    /// wall belongs to one of the two sides. `None` outside the frame.
    pub fn component(&mut self, mesh: &Mesh, point: Point) -> Option<usize> {
        self.locate(mesh, point).map(|at| mesh.triangles[at].component as usize)
    }

    /// The edge nearest to `point`. The search goes outward from the triangle that holds it, through
    /// sides that are not walls and are nearer than the nearest edge so far. `None` outside the frame or
    /// without edges.
    pub fn nearest(&mut self, mesh: &Mesh, index: &CheckedIndex, point: Point) -> Option<Nearest> {
        let start = self.locate(mesh, point)?;
        let at = Vec2::from(point);
        self.search = self.search.wrapping_add(1);
        if self.search == 0 {
            self.entered.fill(0);
            self.search = 1;
        }
        self.queue.clear();
        self.queue.push(u32::try_from(start).ok()?);
        self.entered[start] = self.search;
        let mut best: Option<Nearest> = None;
        let take = |edge: u32, found: f64, best: &mut Option<Nearest>| {
            if best.is_none_or(|best| found < best.distance_2) {
                *best = Some(Nearest { edge: edge as usize, distance_2: found });
            }
        };
        let mut next = 0;
        while let Some(&number) = self.queue.get(next) {
            next += 1;
            let triangle = &mesh.triangles[number as usize];
            for side in 0..3 {
                let (corner, wall) = (triangle.corners[side], triangle.walls[side]);
                // An edge can end at a corner without being a side.
                let end = mesh.ends[corner as usize];
                if end != NONE {
                    let off = Vec2::from(mesh.points[corner as usize]) - at;
                    take(end, off.dot(off), &mut best);
                }
                if wall != NONE {
                    take(wall, distance_2(at, index.edges()[wall as usize].chord), &mut best);
                    continue;
                }
                let across = triangle.across[side];
                if across == NONE || self.entered[across as usize] == self.search {
                    continue;
                }
                let side = mesh.side(number as usize, side);
                if best.is_none_or(|best| distance_2(at, side) < best.distance_2) {
                    self.entered[across as usize] = self.search;
                    self.queue.push(across);
                }
            }
        }
        best
    }

    /// Number of triangles that the last search for a nearest edge entered.
    #[must_use]
    pub fn entered(&self) -> usize {
        self.queue.len()
    }
}

impl Mesh {
    pub(super) fn side(&self, triangle: usize, side: usize) -> Segment {
        let corners = self.triangles[triangle].corners;
        let corner = |k: usize| self.points[corners[k % 3] as usize];
        Segment { from: corner(side), to: corner(side + 1) }
    }

    fn has_on_left(&self, triangle: usize, side: usize, point: Point) -> bool {
        let side = self.side(triangle, side);
        orientation(side.from, side.to, point) != Orientation::Right
    }
}

//! The Delaunay mesh over the profile: which triangle holds a point, which edges are near, which channels
//! are wide enough, and which disc fits. It only proposes.
//!
//! Link moves run through [`ChannelSearch`] and [`taut`], in [`crate::route`]. The message that a tool fits
//! nowhere names the tool of [`Mesh::largest_disc`].
//!
//! `spade` builds the constrained Delaunay triangulation of the chords in a frame. This module flattens
//! it into arrays along a space-filling curve. [`CheckedIndex::confirms`] checks each nearest edge that
//! the mesh proposes.
//!
//! ```
//! use keepout_kernel::index::build::build;
//! use keepout_planner::mesh::Mesh;
//! use keepout_kernel::{Edge, Length, Point, Segment};
//! use keepout_kernel::exact::segment::Window;
//!
//! let at = |x, y| Point::from_units(x, y).unwrap();
//! let corners = [at(0, 0), at(900, 0), at(450, 900)];
//! let side = |i: usize| Segment { from: corners[i], to: corners[(i + 1) % 3] };
//! let edges = (0..3).map(|i| Edge { chord: side(i), chord_error: Length::ZERO }).collect();
//! let index = build(edges).unwrap();
//! let mesh = Mesh::build(&index, Window::from_corners(-5000, -5000, 5000, 5000), false).unwrap();
//! let mut walk = mesh.walk();
//! let nearest = walk.nearest(&mesh, &index, at(450, -200)).unwrap();
//! assert_eq!((nearest.edge, nearest.distance()), (0, 200.0));
//! assert!(index.confirms(at(450, -200), nearest));
//! assert_eq!(mesh.components(), 2);
//! ```

mod build;
mod channel;
mod disc;
mod taut;
mod walk;

use std::fmt;

pub use channel::{ChannelSearch, Portal};
pub use disc::{Disc, largest_tool_mm};
use keepout_kernel::exact::lattice::Point;
use keepout_kernel::index::CheckedIndex;
pub use taut::taut;
pub use walk::Walk;

/// Marker for a missing triangle or edge.
const NONE: u32 = u32::MAX;

/// Constrained Delaunay triangulation of the chords of an index and the corners of a frame.
///
/// Side `k` of a triangle runs from its corner `k` to the next. The triangle is on its left.
#[derive(Clone, Debug)]
pub struct Mesh {
    points: Vec<Point>,
    /// For each point, the number of an edge that ends there, or [`NONE`].
    ends: Vec<u32>,
    triangles: Vec<Triangle>,
    components: u32,
    added: usize,
    left_out: usize,
    chord_error: f64,
}

#[derive(Clone, Copy, Debug)]
struct Triangle {
    corners: [u32; 3],
    /// The triangle across each side.
    across: [u32; 3],
    /// The profile edge on each side.
    walls: [u32; 3],
    component: u32,
}

/// Reason why there is no mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshError {
    /// The frame does not hold the profile with a unit to spare, or leaves the lattice.
    Frame,
    /// More than 2^30 points.
    TooManyPoints {
        /// Number of points.
        count: usize,
    },
    /// The triangulation refused a point. It accepts every lattice point.
    Refused,
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame => write!(f, "the mesh's frame does not hold the profile, or leaves the lattice"),
            Self::TooManyPoints { count } => write!(f, "{count} points are more than a mesh can hold"),
            Self::Refused => write!(f, "the triangulation refused a point"),
        }
    }
}

impl std::error::Error for MeshError {}

impl Mesh {
    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// Number of lattice points that were added to avoid needle triangles.
    #[must_use]
    pub fn added(&self) -> usize {
        self.added
    }

    /// Number of edges that are not sides of the mesh, because they cross or overlap others.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.left_out
    }

    /// The largest chord error of an edge, lattice units.
    #[must_use]
    pub fn chord_error(&self) -> f64 {
        self.chord_error
    }

    /// Number of connected components into which the profile divides the frame.
    #[must_use]
    pub fn components(&self) -> usize {
        self.components as usize
    }

    /// A walk over the mesh, for queries about many points.
    #[must_use]
    pub fn walk(&self) -> Walk {
        Walk::over(self)
    }

    /// The edges that share an end with edge `number`, found through the triangles around its ends;
    /// ascending.
    #[must_use]
    pub fn neighbours(&self, index: &CheckedIndex, number: usize) -> Vec<usize> {
        let Some(edge) = index.edges().get(number) else { return vec![] };
        let mut found = Vec::new();
        let mut walk = self.walk();
        for end in [edge.chord.from, edge.chord.to] {
            let Some(triangle) = walk.locate(self, end) else { continue };
            self.around(end, triangle, &mut found);
        }
        found.sort_unstable();
        found.dedup();
        found.retain(|&other| other != number);
        found
    }

    /// Collects the edges that end at `point`, a corner of the triangle.
    fn around(&self, point: Point, start: usize, found: &mut Vec<usize>) {
        let mut stack = vec![start];
        let mut seen = vec![start];
        while let Some(number) = stack.pop() {
            let triangle = &self.triangles[number];
            for side in 0..3 {
                let ends = [triangle.corners[side], triangle.corners[(side + 1) % 3]];
                if !ends.iter().any(|&end| self.points[end as usize] == point) {
                    continue;
                }
                if triangle.walls[side] != NONE {
                    found.push(triangle.walls[side] as usize);
                }
                let next = triangle.across[side] as usize;
                if next < self.triangles.len() && !seen.contains(&next) {
                    seen.push(next);
                    stack.push(next);
                }
            }
        }
    }
}

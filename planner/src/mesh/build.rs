//! Construction of the mesh: points along a space-filling curve, then the chords in the order of the
//! profile, then flat arrays.
//!
//! Implements SR-03.
//!
//! `spade`'s bulk load of points and constraints together is slow on round outlines. Single insertion of
//! points along a Morton curve, each beside the one before, takes near-linear time. So does the insertion
//! of constraints in ring order.

use keepout_kernel::exact::lattice::{COORD_MAX, Point};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::CheckedIndex;
use keepout_kernel::{ProhibitedRegion, Vec2};
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::{Mesh, MeshError, NONE, Triangle};

/// Number of points up to which a square is not divided further.
const CROWD: usize = 3;
/// Size of the smallest squares (2^n lattice units, 0.1 mm).
const LEAST: u32 = 13;

/// A vertex of the triangulation: a lattice point and its number in the mesh.
struct Vertex {
    point: Point,
    number: u32,
}

impl HasPosition for Vertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        let Vec2 { x, y } = Vec2::from(self.point);
        Point2::new(x, y)
    }
}

type Triangulated = ConstrainedDelaunayTriangulation<Vertex>;

impl Mesh {
    /// The mesh over all edges of a part and its keep-out zones, in the largest frame.
    ///
    /// # Errors
    /// [`MeshError::Frame`] when the part reaches the limit of the lattice.
    pub fn of(part: &ProhibitedRegion) -> Result<Self, MeshError> {
        let frame = Window::from_corners(-COORD_MAX, -COORD_MAX, COORD_MAX, COORD_MAX);
        Self::build(part.index(), frame, false)
    }

    /// The mesh over the chords of `index` in `frame`, which is the machine's travel or larger. With
    /// `refined` it adds a lattice point in each square of a quadtree that is clear of the profile. The
    /// triangles are then near the local feature size. Chords that cross others are left out and counted.
    ///
    /// # Errors
    /// [`MeshError::Frame`] when the frame does not hold the profile.
    pub fn build(index: &CheckedIndex, frame: Window, refined: bool) -> Result<Self, MeshError> {
        let mut points = points_of(index, frame)?;
        let needed = points.len();
        if refined {
            let (min_x, min_y, max_x, max_y) = frame.corners();
            let side = max_x.abs_diff(min_x).max(max_y.abs_diff(min_y)).next_power_of_two();
            let mut added = Added { index, frame, hint: None, points: Vec::new() };
            added.divide(&points, (i64::from(min_x), i64::from(min_y)), side.trailing_zeros());
            points.extend(added.points);
            points.sort_unstable_by_key(|&point| morton(point));
            points.dedup();
        }
        if points.len() > 1 << 30 {
            return Err(MeshError::TooManyPoints { count: points.len() });
        }
        let added = points.len() - needed;
        let (triangulated, handles) = insert(&points)?;
        let mut mesh = Self {
            ends: vec![NONE; points.len()],
            points,
            triangles: Vec::new(),
            components: 0,
            added,
            left_out: 0,
            chord_error: 0.0,
        };
        mesh.constrain(index, triangulated, &handles);
        mesh.number_components();
        Ok(mesh)
    }

    /// Adds the chords and flattens the triangulation.
    fn constrain(
        &mut self,
        index: &CheckedIndex,
        mut triangulated: Triangulated,
        handles: &[FixedVertexHandle],
    ) {
        let mut owners: Vec<u32> = Vec::new();
        let number = |points: &[Point], point: Point| {
            points.binary_search_by_key(&morton(point), |&other| morton(other)).ok()
        };
        for (edge, owner) in index.edges().iter().zip(0_u32..) {
            self.chord_error = self.chord_error.max(f64::from(edge.chord_error.units()));
            let (Some(from), Some(to)) =
                (number(&self.points, edge.chord.from), number(&self.points, edge.chord.to))
            else {
                continue;
            };
            (self.ends[from], self.ends[to]) = (owner, owner);
            if from == to {
                continue;
            }
            let sides = triangulated.try_add_constraint(handles[from], handles[to]);
            self.left_out += usize::from(sides.is_empty());
            for side in sides {
                let side = side.as_undirected().index();
                if owners.len() <= side {
                    owners.resize(side + 1, NONE);
                }
                owners[side] = owner;
            }
        }
        self.flatten(&triangulated, &owners);
    }

    fn flatten(&mut self, triangulated: &Triangulated, owners: &[u32]) {
        let mut order: Vec<(u64, usize)> = Vec::with_capacity(triangulated.num_inner_faces());
        for face in triangulated.inner_faces() {
            let centre = face.vertices().map(|vertex| vertex.data().point);
            let key = centre.iter().map(|&corner| morton(corner)).min().unwrap_or(0);
            order.push((key, face.fix().index()));
        }
        order.sort_unstable();
        let mut numbers = vec![NONE; triangulated.num_all_faces()];
        for (&(_, face), number) in order.iter().zip(0_u32..) {
            numbers[face] = number;
        }
        self.triangles =
            vec![
                Triangle { corners: [NONE; 3], across: [NONE; 3], walls: [NONE; 3], component: NONE };
                order.len()
            ];
        for face in triangulated.inner_faces() {
            let triangle = &mut self.triangles[numbers[face.fix().index()] as usize];
            for (side, edge) in face.adjacent_edges().iter().enumerate() {
                triangle.corners[side] = edge.from().data().number;
                triangle.across[side] = numbers[edge.rev().face().fix().index()];
                triangle.walls[side] =
                    owners.get(edge.as_undirected().fix().index()).copied().unwrap_or(NONE);
            }
        }
    }

    /// Numbers the connected components between walls; the one at the frame is 0.
    fn number_components(&mut self) {
        let at_frame = self.triangles.iter().position(|triangle| triangle.across.contains(&NONE));
        let starts = at_frame.into_iter().chain(0..self.triangles.len());
        let mut stack = Vec::new();
        for start in starts {
            if self.triangles[start].component != NONE {
                continue;
            }
            self.triangles[start].component = self.components;
            stack.push(start);
            while let Some(number) = stack.pop() {
                let Triangle { across, walls, .. } = self.triangles[number];
                for (next, wall) in across.into_iter().zip(walls) {
                    if next != NONE && wall == NONE && self.triangles[next as usize].component == NONE {
                        self.triangles[next as usize].component = self.components;
                        stack.push(next as usize);
                    }
                }
            }
            self.components += 1;
        }
    }
}

/// Distinct ends of all chords and the frame's corners, along a Morton curve.
fn points_of(index: &CheckedIndex, frame: Window) -> Result<Vec<Point>, MeshError> {
    let (min_x, min_y, max_x, max_y) = frame.corners();
    let mut points = Vec::with_capacity(index.edges().len() + 4);
    for (x, y) in [(min_x, min_y), (max_x, min_y), (max_x, max_y), (min_x, max_y)] {
        points.push(Point::from_units(x.into(), y.into()).map_err(|_| MeshError::Frame)?);
    }
    for edge in index.edges() {
        let (x0, y0, x1, y1) = edge.chord.bounds().corners();
        if !(min_x < x0 && min_y < y0 && x1 < max_x && y1 < max_y) {
            return Err(MeshError::Frame);
        }
        points.extend([edge.chord.from, edge.chord.to]);
    }
    points.sort_unstable_by_key(|&point| morton(point));
    points.dedup();
    Ok(points)
}

/// Inserts points along the curve. The search for each starts at the one before.
fn insert(points: &[Point]) -> Result<(Triangulated, Vec<FixedVertexHandle>), MeshError> {
    let mut triangulated = Triangulated::new();
    let mut handles: Vec<FixedVertexHandle> = Vec::with_capacity(points.len());
    for (&point, number) in points.iter().zip(0_u32..) {
        let vertex = Vertex { point, number };
        let inserted = match handles.last() {
            Some(&hint) => triangulated.insert_with_hint(vertex, hint),
            None => triangulated.insert(vertex),
        };
        handles.push(inserted.map_err(|_| MeshError::Refused)?);
    }
    Ok((triangulated, handles))
}

/// Points in the middle of squares that are clear of the profile.
struct Added<'a> {
    index: &'a CheckedIndex,
    frame: Window,
    hint: Option<usize>,
    points: Vec<Point>,
}

impl Added<'_> {
    /// Divides the square at `low` with side 2^`log_2`. It holds `points`, which are sorted along the
    /// curve.
    fn divide(&mut self, points: &[Point], low: (i64, i64), log_2: u32) {
        let side = 1_i64 << log_2;
        if points.len() > CROWD && log_2 > LEAST {
            let half = side / 2;
            for (x, y) in [(0, 0), (half, 0), (0, half), (half, half)] {
                let corner = (low.0 + x, low.1 + y);
                let within = |point: &Point| {
                    let (px, py) = (i64::from(point.x.units()), i64::from(point.y.units()));
                    (corner.0..corner.0 + half).contains(&px) && (corner.1..corner.1 + half).contains(&py)
                };
                let part: Vec<Point> = points.iter().copied().filter(within).collect();
                self.divide(&part, corner, log_2 - 1);
            }
            return;
        }
        let Ok(middle) = Point::from_units(low.0 + side / 2, low.1 + side / 2) else { return };
        let Some(nearest) = self.index.nearest(middle, self.hint) else { return };
        self.hint = Some(nearest.edge);
        let clear = i64::from(u32::MAX).min(side / 2);
        let clear = f64::from(u32::try_from(clear).unwrap_or(u32::MAX));
        if self.frame.holds(middle) && nearest.distance_2 >= clear * clear {
            self.points.push(middle);
        }
    }
}

/// Position of a point on a Morton curve over the lattice: the bits of its coordinates, interleaved.
fn morton(point: Point) -> u64 {
    let spread = |c: i32| {
        let mut bits = u64::from(c.wrapping_add(COORD_MAX).cast_unsigned());
        for (shift, mask) in [
            (16, 0x0000_FFFF_0000_FFFF_u64),
            (8, 0x00FF_00FF_00FF_00FF),
            (4, 0x0F0F_0F0F_0F0F_0F0F),
            (2, 0x3333_3333_3333_3333),
            (1, 0x5555_5555_5555_5555),
        ] {
            bits = (bits | (bits << shift)) & mask;
        }
        bits
    };
    spread(point.x.units()) | (spread(point.y.units()) << 1)
}

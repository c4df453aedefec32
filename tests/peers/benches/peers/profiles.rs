//! Profiles of any size in a field of 400 × 350 mm.

use std::f64::consts::TAU;

use keepout_kernel::Vec2;
use keepout_kernel::{Edge, Length, Point, Segment, UNITS_PER_MM};

/// Lattice units in a millimetre.
pub const MM: f64 = UNITS_PER_MM as f64;

/// A family of profiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileFamily {
    /// A radial random polygon. Vertex `k` of N is at the angle 2πk/N, at a random share of 0.55 to 1 of an
    /// ellipse with semi-axes of 195 and 170 mm. Its triangles are needles.
    Star,
    /// A band that winds through the field in rows: dense and even. Its edges are half as long as the rows are
    /// apart. Each vertex is moved at random by up to a twelfth of the row distance.
    Maze,
    /// Eight-sided studs of 4 mm, 12 mm apart. More edges give a larger field with the same density.
    Studs,
}

impl ProfileFamily {
    pub const ALL: [Self; 3] = [Self::Star, Self::Maze, Self::Studs];

    pub fn name(self) -> &'static str {
        match self {
            Self::Star => "star",
            Self::Maze => "maze",
            Self::Studs => "studs",
        }
    }

    /// Closed rings of about `count` edges in all, counter-clockwise, as their vertices.
    pub fn rings(self, count: usize) -> Vec<Vec<Point>> {
        match self {
            Self::Star => vec![star(count)],
            Self::Maze => vec![maze(count)],
            Self::Studs => studs(count),
        }
    }

    /// The size of the field, mm.
    pub fn field(self, count: usize) -> (f64, f64) {
        match self {
            Self::Star | Self::Maze => (400.0, 350.0),
            Self::Studs => {
                let side = PITCH * stud_rows(count) as f64;
                (side, side)
            }
        }
    }
}

/// The distance between studs, mm.
const PITCH: f64 = 12.0;

fn stud_rows(count: usize) -> usize {
    ((count as f64 / 8.0).sqrt().round() as usize).max(2)
}

fn studs(count: usize) -> Vec<Vec<Point>> {
    let rows = stud_rows(count);
    let place = |k: usize| PITCH * (k as f64 + 0.5 - rows as f64 / 2.0);
    let stud = |column: usize, row: usize| {
        let corner = |k: u32| {
            let phi = TAU * (f64::from(k) + 0.5) / 8.0;
            at(place(column) + 2.0 * phi.cos(), place(row) + 2.0 * phi.sin())
        };
        (0..8).map(corner).collect()
    };
    (0..rows).flat_map(|row| (0..rows).map(move |column| stud(column, row))).collect()
}

fn star(count: usize) -> Vec<Point> {
    let mut random = fastrand::Rng::with_seed(1);
    let vertex = |k: usize| {
        let phi = TAU * k as f64 / count as f64;
        let share = 0.55 + 0.45 * random.f64();
        at(195.0 * share * phi.cos(), 170.0 * share * phi.sin())
    };
    (0..count).map(vertex).collect()
}

fn maze(count: usize) -> Vec<Point> {
    let mut random = fastrand::Rng::with_seed(2);
    // There and back along `rows` rows: 2 · rows · 400 mm of edge, half a row's distance long.
    let rows = ((count as f64 * 350.0 / 1600.0).sqrt().round() as usize).max(2);
    let pitch = 350.0 / rows as f64;
    let per_side = ((count as f64 / (2.0 * rows as f64)).round() as usize).max(2);
    let quarter = pitch / 4.0;
    let step = (400.0 - pitch) / per_side as f64;
    let mut wobble = || (random.f64() - 0.5) * (quarter.min(step) / 1.5);
    let mut right_hand = Vec::new();
    let mut left_hand = Vec::new();
    for row in 0..rows {
        let y = -175.0 + pitch * (row as f64 + 0.5);
        let sign = if row % 2 == 0 { 1.0 } else { -1.0 };
        // Seen along the row, the inner side of a turn is shorter by the width of the band.
        let short = 2.0 * quarter;
        let entry = |inner: bool| -200.0 + if inner && row > 0 { short } else { 0.0 };
        let exit = |inner: bool| 200.0 - if inner && row + 1 < rows { short } else { 0.0 };
        let mut side = |from: f64, to: f64, across: f64, points: &mut Vec<Point>| {
            for k in 0..per_side {
                let along = from + (to - from) * k as f64 / (per_side - 1) as f64;
                points.push(at(sign * along + wobble(), y + across + wobble()));
            }
        };
        // Turns alternate. In even rows the right side enters on the inside of the last turn and leaves on
        // the outside of the next one. In odd rows it is the reverse.
        let (right_inner_at_entry, right_inner_at_exit) = (row % 2 == 0, row % 2 == 1);
        side(entry(right_inner_at_entry), exit(right_inner_at_exit), -sign * quarter, &mut right_hand);
        side(entry(!right_inner_at_entry), exit(!right_inner_at_exit), sign * quarter, &mut left_hand);
    }
    left_hand.reverse();
    right_hand.extend(left_hand);
    right_hand
}

/// The lattice point nearest to (`x`, `y`), mm.
pub fn at(x: f64, y: f64) -> Point {
    keepout_kernel::curve::nearest_point(Vec2::new(x * MM, y * MM)).expect("profiles lie in the field")
}

/// The edges of the closed polygons, with a chord-error bound of zero.
pub fn edges(rings: &[Vec<Point>]) -> Vec<Edge> {
    let of = |ring: &Vec<Point>| -> Vec<Edge> {
        let next = ring.iter().cycle().skip(1);
        let edge = |(&from, &to)| Edge { chord: Segment { from, to }, chord_error: Length::ZERO };
        ring.iter().zip(next).map(edge).collect()
    };
    rings.iter().flat_map(of).collect()
}

/// Coordinates of a point, mm.
pub fn mm(point: Point) -> (f64, f64) {
    (f64::from(point.x.units()) / MM, f64::from(point.y.units()) / MM)
}

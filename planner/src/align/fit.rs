//! Least-squares fit of a rigid motion to probe points.

use super::ProbePoint;
use super::part::{PartEdges, StraightEdge};

/// A probe point and the geometry that was touched.
#[derive(Clone, Copy, Debug)]
pub(super) enum Observation {
    /// The tool's centre is on a point of the drawing.
    Point(ProbePoint),
    /// The tool's disc touches a straight edge.
    Edge { touch: ProbePoint, edge: StraightEdge, radius_mm: f64 },
}

impl Observation {
    pub fn edge(&self) -> Option<(ProbePoint, StraightEdge)> {
        match *self {
            Self::Point(_) => None,
            Self::Edge { touch, edge, .. } => Some((touch, edge)),
        }
    }
}

/// Steps of the search. From a start within some degrees it converges in three.
const STEPS: usize = 20;
/// Least determinant of the normal equations, in mm. They are scaled by the part's size.
const DETERMINANT: f64 = 1e-9;

/// An equation: the error in mm, and its slopes over the rotation (times half the size of the part) and
/// over the position.
struct Row {
    off: f64,
    slope: [f64; 3],
}

type Matrix = [[f64; 3]; 3];

/// A rigid motion: it turns the drawing about `middle`, and moves `middle` to `place`.
pub(super) struct Fit {
    /// The rotation, rad.
    pub rotation: f64,
    place: (f64, f64),
    middle: (f64, f64),
    half_mm: f64,
    turns: bool,
}

impl Fit {
    /// The motion with the smallest squared error. `start` is an estimate of the rotation, rad. Without
    /// it the motion has no rotation. `None` when the observations do not determine the motion.
    pub fn of(observations: &[Observation], start: Option<f64>, part: &PartEdges) -> Option<Self> {
        let mut fit = Self {
            rotation: start.unwrap_or(0.0),
            place: (0.0, 0.0),
            middle: part.middle_mm(),
            half_mm: part.size_mm() / 2.0,
            turns: start.is_some(),
        };
        for _ in 0..STEPS {
            let rows = observations.iter().flat_map(|each| fit.rows(each));
            let rows: Vec<Row> = rows.collect();
            let inverse = fit.inverse(&rows)?;
            let slope = |i: usize| rows.iter().map(|row| row.slope[i] * row.off).sum::<f64>();
            let step = times(&inverse, [slope(0), slope(1), slope(2)]);
            fit.rotation -= step[0] / fit.half_mm;
            fit.place = (fit.place.0 - step[1], fit.place.1 - step[2]);
        }
        (fit.rotation.is_finite() && fit.place.0.is_finite() && fit.place.1.is_finite()).then_some(fit)
    }

    fn turned(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let (sin, cos) = self.rotation.sin_cos();
        (x * cos - y * sin, x * sin + y * cos)
    }

    /// Vector from the middle to a point of the drawing, turned.
    fn arm(&self, p: (f64, f64)) -> (f64, f64) {
        self.turned((p.0 - self.middle.0, p.1 - self.middle.1))
    }

    fn rows(&self, observation: &Observation) -> Vec<Row> {
        let scaled = |slope: f64| if self.turns { slope / self.half_mm } else { 0.0 };
        match *observation {
            Observation::Point(ProbePoint { drawing_mm, machine_mm }) => {
                let (x, y) = self.arm(drawing_mm);
                let off = (self.place.0 + x - machine_mm.0, self.place.1 + y - machine_mm.1);
                vec![
                    Row { off: off.0, slope: [scaled(-y), 1.0, 0.0] },
                    Row { off: off.1, slope: [scaled(x), 0.0, 1.0] },
                ]
            }
            Observation::Edge { touch, edge, radius_mm } => {
                let ((x, y), (nx, ny)) = (self.arm(edge.from_mm), self.turned(edge.outward));
                let (dx, dy) = (touch.machine_mm.0 - self.place.0 - x, touch.machine_mm.1 - self.place.1 - y);
                let off = nx * dx + ny * dy - radius_mm;
                // The normal and the edge's own point both turn with the part.
                let turning = (-ny * dx + nx * dy) - (-nx * y + ny * x);
                vec![Row { off, slope: [scaled(turning), -nx, -ny] }]
            }
        }
    }

    /// Inverse of the normal equations.
    fn inverse(&self, rows: &[Row]) -> Option<Matrix> {
        let entry = |i: usize, j: usize| rows.iter().map(|row| row.slope[i] * row.slope[j]).sum::<f64>();
        let mut normal = [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)));
        if !self.turns {
            normal[0][0] = 1.0;
        }
        inverse(&normal)
    }

    /// Distance of a probe point from its fitted position, mm.
    pub fn residual_mm(&self, observation: &Observation) -> f64 {
        self.rows(observation).iter().map(|row| row.off * row.off).sum::<f64>().sqrt()
    }

    /// Drawing coordinates of a machine point, mm.
    pub fn drawing_mm(&self, machine_mm: (f64, f64)) -> (f64, f64) {
        let (dx, dy) = (machine_mm.0 - self.place.0, machine_mm.1 - self.place.1);
        let (sin, cos) = self.rotation.sin_cos();
        (dx * cos + dy * sin + self.middle.0, dy * cos - dx * sin + self.middle.1)
    }

    /// Machine coordinates of the drawing's origin after a turn by `rotation`, mm.
    pub fn origin(&self, rotation: f64) -> (f64, f64) {
        let ((sin, cos), (x, y)) = (rotation.sin_cos(), self.middle);
        (self.place.0 - (x * cos - y * sin), self.place.1 - (x * sin + y * cos))
    }

    /// Largest error of a place in the part's box, and the corner where it occurs. Each probe point may
    /// be wrong by `error_mm` in any direction.
    ///
    /// The estimate is of first order, and the errors add up. The error is convex in the place, so a
    /// corner has the largest one.
    pub fn uncertainty(
        &self,
        observations: &[Observation],
        error_mm: f64,
        part: &PartEdges,
    ) -> (f64, (f64, f64)) {
        let rows: Vec<Vec<Row>> = observations.iter().map(|each| self.rows(each)).collect();
        let all: Vec<Row> = observations.iter().flat_map(|each| self.rows(each)).collect();
        let Some(inverse) = self.inverse(&all) else { return (f64::INFINITY, part.middle_mm()) };
        let off_at = |corner: (f64, f64)| {
            let (x, y) = self.arm(corner);
            let moved = |row: &Row| {
                let [turn, dx, dy] = times(&inverse, row.slope);
                let turn = if self.turns { turn / self.half_mm } else { 0.0 };
                (dx - turn * y, dy + turn * x)
            };
            let gain = |rows: &Vec<Row>| match &rows[..] {
                [only] => moved(only).0.hypot(moved(only).1),
                [first, second, ..] => norm(moved(first), moved(second)),
                [] => 0.0,
            };
            error_mm * rows.iter().map(gain).sum::<f64>()
        };
        let corners = part.corners_mm().map(|corner| (off_at(corner), corner));
        corners.into_iter().fold((0.0, part.middle_mm()), |a, b| if b.0 > a.0 { b } else { a })
    }
}

/// Spectral norm of the matrix with these columns.
fn norm(a: (f64, f64), b: (f64, f64)) -> f64 {
    let sum = a.0 * a.0 + a.1 * a.1 + b.0 * b.0 + b.1 * b.1;
    let determinant = a.0 * b.1 - a.1 * b.0;
    let root = (sum * sum - 4.0 * determinant * determinant).max(0.0).sqrt();
    f64::midpoint(sum, root).sqrt()
}

fn times(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2])
}

fn inverse(m: &Matrix) -> Option<Matrix> {
    let minor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = [0, 1, 2].map(|j| m[0][j] * minor(0, j)).iter().sum();
    (determinant.abs() > DETERMINANT).then(|| [0, 1, 2].map(|i| [0, 1, 2].map(|j| minor(j, i) / determinant)))
}

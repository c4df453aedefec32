//! Least-squares fit of a rigid motion to probe points.

use super::ProbePoint;
use super::part::{PartEdges, StraightEdge};
use crate::Mm2;

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
    place: Mm2,
    middle: Mm2,
    half_mm: f64,
    turns: bool,
}

impl Fit {
    /// The motion with the smallest squared error. `start` is an estimate of the rotation, rad. Without
    /// it the motion has no rotation. `None` when the observations do not determine the motion.
    pub fn of(observations: &[Observation], start: Option<f64>, part: &PartEdges) -> Option<Self> {
        let mut fit = Self {
            rotation: start.unwrap_or(0.0),
            place: Mm2::ZERO,
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
            fit.place = fit.place - Mm2::new(step[1], step[2]);
        }
        (fit.rotation.is_finite() && fit.place.is_finite()).then_some(fit)
    }

    /// Vector from the middle to a point of the drawing, turned.
    fn arm(&self, p: Mm2) -> Mm2 {
        (p - self.middle).turned(self.rotation)
    }

    fn rows(&self, observation: &Observation) -> Vec<Row> {
        let scaled = |slope: f64| if self.turns { slope / self.half_mm } else { 0.0 };
        match *observation {
            Observation::Point(ProbePoint { drawing_mm, machine_mm }) => {
                let arm = self.arm(drawing_mm);
                let off = self.place + arm - machine_mm;
                vec![
                    Row { off: off.x, slope: [scaled(-arm.y), 1.0, 0.0] },
                    Row { off: off.y, slope: [scaled(arm.x), 0.0, 1.0] },
                ]
            }
            Observation::Edge { touch, edge, radius_mm } => {
                let (arm, normal) = (self.arm(edge.from_mm), edge.outward.turned(self.rotation));
                let from_edge = touch.machine_mm - self.place - arm;
                let off = normal.dot(from_edge) - radius_mm;
                // The normal and the edge's own point both turn with the part.
                let turning = normal.cross(from_edge) - arm.cross(normal);
                vec![Row { off, slope: [scaled(turning), -normal.x, -normal.y] }]
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
    pub fn drawing_mm(&self, machine_mm: Mm2) -> Mm2 {
        (machine_mm - self.place).turned(-self.rotation) + self.middle
    }

    /// Machine coordinates of the drawing's origin after a turn by `rotation`, mm.
    pub fn origin(&self, rotation: f64) -> Mm2 {
        self.place - self.middle.turned(rotation)
    }

    /// Largest error of a place in the part's box, and the corner where it occurs. Each probe point may
    /// be wrong by `error_mm` in any direction.
    ///
    /// The estimate is of first order, and the errors add up. The error is convex in the place, so a
    /// corner has the largest one.
    pub fn uncertainty(&self, observations: &[Observation], error_mm: f64, part: &PartEdges) -> (f64, Mm2) {
        let rows: Vec<Vec<Row>> = observations.iter().map(|each| self.rows(each)).collect();
        let all: Vec<Row> = observations.iter().flat_map(|each| self.rows(each)).collect();
        let Some(inverse) = self.inverse(&all) else { return (f64::INFINITY, part.middle_mm()) };
        let off_at = |corner: Mm2| {
            let Mm2 { x, y } = self.arm(corner);
            let moved = |row: &Row| {
                let [turn, dx, dy] = times(&inverse, row.slope);
                let turn = if self.turns { turn / self.half_mm } else { 0.0 };
                Mm2::new(dx - turn * y, dy + turn * x)
            };
            let gain = |rows: &Vec<Row>| match &rows[..] {
                [only] => moved(only).length(),
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
fn norm(a: Mm2, b: Mm2) -> f64 {
    let (sum, determinant) = (a.dot(a) + b.dot(b), a.cross(b));
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

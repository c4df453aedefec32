//! The three invasion checks of section 5.2: a matrix of points, the sum of angles, the distance to classified segments.

use thiserror::Error;

use super::{PointMm, cross, dot, length, segments, vector};

/// Most points that a matrix holds.
const POINTS_MAX: f64 = 16_000_000.0;
/// A sum of angles counts as 360° from this much below: three arctangents round by less than 1e-12° together.
const ROUNDING_DEG: f64 = 1e-9;

/// Why no matrix of points is made.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum MatrixError {
    /// The separation is no length, or the points would be too many.
    #[error(
        "points {spacing_mm} mm apart can not be laid along this profile: it needs a finite profile, a separation above zero and at most {POINTS_MAX} points. Give a larger separation."
    )]
    Spacing {
        /// The separation asked for, mm.
        spacing_mm: f64,
    },
}

/// The first method: points P(j) along the profile's segments, their separation E.
///
/// Between two points the profile is not there: with a tolerance below E/2 a tool passes across it unnoticed. A query costs
/// a distance for each point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointMatrix {
    points: Vec<PointMm>,
}

impl PointMatrix {
    /// The points of `profile`, from each corner `spacing_mm` apart along the segment that begins there.
    ///
    /// # Errors
    /// [`MatrixError`] when the separation is no length above zero, or makes more than 16 million points.
    pub fn new(profile: &[PointMm], spacing_mm: f64) -> Result<Self, MatrixError> {
        let count: f64 = segments(profile).map(|(a, b)| length(vector(a, b)) / spacing_mm + 1.0).sum();
        if !(spacing_mm.is_finite() && spacing_mm > 0.0 && count.is_finite() && count <= POINTS_MAX) {
            return Err(MatrixError::Spacing { spacing_mm });
        }
        let points = segments(profile).flat_map(|(a, b)| points_along(a, b, spacing_mm)).collect();
        Ok(Self { points })
    }

    /// The number of points, which is the number of distances that a query takes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The distance from `p` to the nearest point of the matrix, mm; infinite when there is none.
    #[must_use]
    pub fn distance_mm(&self, p: PointMm) -> f64 {
        self.points.iter().map(|&point| length(vector(p, point))).fold(f64::INFINITY, f64::min)
    }

    /// Whether a tool at `p` invades: it is within the tolerance T of a point, eq. (1).
    #[must_use]
    pub fn invades(&self, p: PointMm, tolerance_mm: f64) -> bool {
        self.distance_mm(p) <= tolerance_mm
    }
}

/// The points of a segment, from `a` on and without `b`; none of a segment of no length.
fn points_along(a: PointMm, b: PointMm, spacing_mm: f64) -> impl Iterator<Item = PointMm> {
    let (along, whole) = (vector(a, b), length(vector(a, b)));
    let distances = (0_u32..).map(move |j| f64::from(j) * spacing_mm).take_while(move |s| *s < whole);
    distances.map(move |s| (a.0 + along.0 * s / whole, a.1 + along.1 * s / whole))
}

/// The second method: the sum β + Φ + δ of the angles that the triangle's sides subtend at `p`, in degrees.
///
/// 360° inside, less outside. At a corner two of the angles do not exist and count as zero.
#[must_use]
pub fn angle_sum_deg(p: PointMm, triangle: [PointMm; 3]) -> f64 {
    let subtended = |(a, b)| {
        let (u, v) = (vector(p, a), vector(p, b));
        cross(u, v).abs().atan2(dot(u, v)).to_degrees()
    };
    segments(&triangle).map(subtended).sum()
}

/// Whether `p` is external to the triangle: its sum of angles is below 360°, by more than 1e-9° for rounding.
#[must_use]
pub fn is_external(p: PointMm, triangle: [PointMm; 3]) -> bool {
    angle_sum_deg(p, triangle) < 360.0 - ROUNDING_DEG
}

/// Whether a tool outside of a part invades it at `p` by the sum of angles, as the paper uses it on a polygon.
///
/// Of the segments whose x interval or y interval holds `p` the nearest by eq. (2) is taken, with the corner that follows
/// it as P3. The paper says no more than that; it is right where the part near the segment is that triangle, hence for
/// triangles. There is no tolerance: only a tool that is in the part already is noticed.
#[must_use]
pub fn angle_sum_invades(profile: &[PointMm], p: PointMm) -> bool {
    let nearest = Intervals::new(profile, Classified::ByXOrY).nearest(p);
    nearest.is_some_and(|(segment, _)| {
        let corner = |i: usize| profile[(segment + i) % profile.len()];
        !is_external(p, [corner(0), corner(1), corner(2)])
    })
}

/// Which interval of a segment has to hold the tool for its distance to be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Classified {
    /// Its x interval: the third method as it is written, "only in the interval of x coordinates where Pf belongs".
    ByX,
    /// Its x interval or its y interval: as the paper introduces the intervals ("Xp1-Xp2, …, Yp1-Yp2, …").
    ByXOrY,
}

/// A segment of the profile, and which it is in the route.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    index: usize,
    from: PointMm,
    to: PointMm,
}

impl Segment {
    fn least_x(&self) -> f64 {
        self.from.0.min(self.to.0)
    }

    fn x_holds(&self, p: PointMm) -> bool {
        self.least_x() <= p.0 && p.0 <= self.from.0.max(self.to.0)
    }

    fn y_holds(&self, p: PointMm) -> bool {
        self.from.1.min(self.to.1) <= p.1 && p.1 <= self.from.1.max(self.to.1)
    }

    /// Eq. (2): the distance to the infinite line through the segment, mm.
    fn line_distance_mm(&self, p: PointMm) -> f64 {
        let along = vector(self.from, self.to);
        (cross(vector(self.from, p), along) / length(along)).abs()
    }
}

/// The third method, which the paper's machine ran: segments by their intervals, and the distance of eq. (2).
///
/// The distance has no sign and is that to a line without ends. Beyond a corner no interval holds the tool; by x alone a
/// vertical segment's holds it nowhere but on its line.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    /// In the order of their least x.
    segments: Vec<Segment>,
    classified: Classified,
}

impl Intervals {
    /// The segments of `profile`, sorted by their x intervals. Those of no length are left out.
    #[must_use]
    pub fn new(profile: &[PointMm], classified: Classified) -> Self {
        let mut sorted: Vec<Segment> = segments(profile)
            .enumerate()
            .map(|(index, (from, to))| Segment { index, from, to })
            .filter(|segment| segment.from != segment.to)
            .collect();
        sorted.sort_by(|one, other| one.least_x().total_cmp(&other.least_x()));
        Self { segments: sorted, classified }
    }

    /// The nearest of the segments whose interval holds `p`, by its place in the route, and the distance of eq. (2) in mm.
    #[must_use]
    pub fn nearest(&self, p: PointMm) -> Option<(usize, f64)> {
        let distances = self.candidates(p).map(|segment| (segment.index, segment.line_distance_mm(p)));
        distances.min_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// Whether a tool at `p` invades: a segment whose interval holds it is within the tolerance T by eq. (2).
    #[must_use]
    pub fn invades(&self, p: PointMm, tolerance_mm: f64) -> bool {
        self.nearest(p).is_some_and(|(_, distance_mm)| distance_mm <= tolerance_mm)
    }

    fn candidates(&self, p: PointMm) -> impl Iterator<Item = &Segment> {
        let end = match self.classified {
            Classified::ByX => self.segments.partition_point(|segment| segment.least_x() <= p.0),
            Classified::ByXOrY => self.segments.len(),
        };
        let by_y = self.classified == Classified::ByXOrY;
        self.segments.iter().take(end).filter(move |segment| segment.x_holds(p) || by_y && segment.y_holds(p))
    }
}

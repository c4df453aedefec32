//! The three invasion checks of section 5.2: a matrix of points, the sum of angles, the distance to
//! classified segments.

use thiserror::Error;

use super::segments;
use keepout_planner::Mm2;

/// Largest number of points of a matrix.
const POINTS_MAX: f64 = 16_000_000.0;
/// Largest amount by which a sum of angles may be below 360° and count as 360°. Three arctangents round by
/// less than 1e-12° together.
const ROUNDING_DEG: f64 = 1e-9;

/// Reasons for which a matrix of points can not be made.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum MatrixError {
    /// The separation is not positive and finite, the profile is not finite, or the number of points is too
    /// large.
    #[error(
        "a separation of {spacing_mm} mm does not fit this profile: the profile must be finite, the \
         separation above zero, and the number of points at most {POINTS_MAX}. Give a larger separation."
    )]
    Spacing {
        /// The requested separation, mm.
        spacing_mm: f64,
    },
}

/// The first method: points P(j) along the segments of the profile, with the separation E.
///
/// The check does not see the profile between two points. With a tolerance below E/2, a tool crosses it
/// undetected. A query computes the distance to every point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointMatrix {
    points: Vec<Mm2>,
}

impl PointMatrix {
    /// The points of `profile`: along each segment from its first corner, `spacing_mm` apart.
    ///
    /// # Errors
    /// [`MatrixError`] if the separation is not above zero, or gives more than 16 million points.
    pub fn new(profile: &[Mm2], spacing_mm: f64) -> Result<Self, MatrixError> {
        let count: f64 = segments(profile).map(|(a, b)| a.distance(b) / spacing_mm + 1.0).sum();
        if !(spacing_mm.is_finite() && spacing_mm > 0.0 && count.is_finite() && count <= POINTS_MAX) {
            return Err(MatrixError::Spacing { spacing_mm });
        }
        let points = segments(profile).flat_map(|(a, b)| points_along(a, b, spacing_mm)).collect();
        Ok(Self { points })
    }

    /// Number of points. A query computes this many distances.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// The points.
    #[must_use]
    pub fn points(&self) -> &[Mm2] {
        &self.points
    }

    /// Whether the matrix has no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Distance from `p` to the nearest point of the matrix, mm. Infinite for an empty matrix.
    #[must_use]
    pub fn distance_mm(&self, p: Mm2) -> f64 {
        self.points.iter().map(|&point| p.distance(point)).fold(f64::INFINITY, f64::min)
    }

    /// Whether a tool at `p` invades, by eq. (1): its distance to a point is at most the tolerance T.
    #[must_use]
    pub fn invades(&self, p: Mm2, tolerance_mm: f64) -> bool {
        self.distance_mm(p) <= tolerance_mm
    }
}

/// The points of a segment, with `a` and without `b`. A segment without length has no points.
fn points_along(a: Mm2, b: Mm2, spacing_mm: f64) -> impl Iterator<Item = Mm2> {
    let (along, whole) = (b - a, a.distance(b));
    let distances = (0_u32..).map(move |j| f64::from(j) * spacing_mm).take_while(move |s| *s < whole);
    distances.map(move |s| a + along * s / whole)
}

/// The second method: the sum β + Φ + δ of the angles that the triangle's sides subtend at `p`, in degrees.
///
/// It is 360° inside the triangle and less outside. At a corner two of the angles do not exist and count as
/// zero.
#[must_use]
pub fn angle_sum_deg(p: Mm2, triangle: [Mm2; 3]) -> f64 {
    let subtended = |(a, b): (Mm2, Mm2)| {
        let (u, v) = (a - p, b - p);
        u.cross(v).abs().atan2(u.dot(v)).to_degrees()
    };
    segments(&triangle).map(subtended).sum()
}

/// Whether `p` is external to the triangle: the sum of angles is below 360° by more than 1e-9°, the rounding
/// tolerance.
#[must_use]
pub fn is_external(p: Mm2, triangle: [Mm2; 3]) -> bool {
    angle_sum_deg(p, triangle) < 360.0 - ROUNDING_DEG
}

/// Whether a tool at `p` invades a polygonal part from outside, by the sum of angles.
///
/// The paper selects the segments with `p` in their x interval or y interval, and takes the nearest one by
/// eq. (2). P3 is the corner after it. The paper states no more. The check is correct if the part near the
/// segment is this triangle, so it is correct for triangles. It has no tolerance, so it detects a tool only
/// inside the part.
#[must_use]
pub fn angle_sum_invades(profile: &[Mm2], p: Mm2) -> bool {
    let nearest = Intervals::new(profile, Classified::ByXOrY).nearest(p);
    nearest.is_some_and(|(segment, _)| {
        let corner = |i: usize| profile[(segment + i) % profile.len()];
        !is_external(p, [corner(0), corner(1), corner(2)])
    })
}

/// Interval of a segment that must contain the tool before the check computes the distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Classified {
    /// The x interval. This is the text of the third method: "only in the interval of x coordinates where Pf
    /// belongs".
    ByX,
    /// The x interval or the y interval. The paper introduces the intervals in this way ("Xp1-Xp2, …,
    /// Yp1-Yp2, …").
    ByXOrY,
}

/// A segment of the profile, with its number in the route.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    index: usize,
    from: Mm2,
    to: Mm2,
}

impl Segment {
    fn least_x(&self) -> f64 {
        self.from.x.min(self.to.x)
    }

    fn x_holds(&self, p: Mm2) -> bool {
        self.least_x() <= p.x && p.x <= self.from.x.max(self.to.x)
    }

    fn y_holds(&self, p: Mm2) -> bool {
        self.from.y.min(self.to.y) <= p.y && p.y <= self.from.y.max(self.to.y)
    }

    /// Distance to the infinite line through the segment, eq. (2), mm.
    fn line_distance_mm(&self, p: Mm2) -> f64 {
        let along = self.to - self.from;
        ((p - self.from).cross(along) / along.length()).abs()
    }
}

/// The third method, which the paper's machine used: segments selected by intervals, and the distance of eq.
/// (2).
///
/// The distance has no sign, and its line has no ends. Past a corner no interval contains the tool. With x
/// intervals alone, the interval of a vertical segment contains the tool only on its line.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    /// Segments in the order of their smallest x.
    segments: Vec<Segment>,
    classified: Classified,
}

impl Intervals {
    /// The segments of `profile`, sorted by their x intervals. Segments without length are dropped.
    #[must_use]
    pub fn new(profile: &[Mm2], classified: Classified) -> Self {
        let mut sorted: Vec<Segment> = segments(profile)
            .enumerate()
            .map(|(index, (from, to))| Segment { index, from, to })
            .filter(|segment| segment.from != segment.to)
            .collect();
        sorted.sort_by(|one, other| one.least_x().total_cmp(&other.least_x()));
        Self { segments: sorted, classified }
    }

    /// The nearest segment with `p` in its interval: its number in the route, and the distance of eq. (2) in
    /// mm.
    #[must_use]
    pub fn nearest(&self, p: Mm2) -> Option<(usize, f64)> {
        self.selected(p).min_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// The segments with `p` in their interval: the number of each in the route, and the distance of eq. (2) in mm.
    pub fn selected(&self, p: Mm2) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.candidates(p).map(move |segment| (segment.index, segment.line_distance_mm(p)))
    }

    /// Whether a tool at `p` invades: the nearest segment with `p` in its interval is within the tolerance T
    /// by eq. (2).
    #[must_use]
    pub fn invades(&self, p: Mm2, tolerance_mm: f64) -> bool {
        self.nearest(p).is_some_and(|(_, distance_mm)| distance_mm <= tolerance_mm)
    }

    fn candidates(&self, p: Mm2) -> impl Iterator<Item = &Segment> {
        let end = match self.classified {
            Classified::ByX => self.segments.partition_point(|segment| segment.least_x() <= p.x),
            Classified::ByXOrY => self.segments.len(),
        };
        let by_y = self.classified == Classified::ByXOrY;
        self.segments.iter().take(end).filter(move |segment| segment.x_holds(p) || by_y && segment.y_holds(p))
    }
}

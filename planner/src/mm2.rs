//! Points, vectors and boxes in millimetres.

use std::fmt;
use std::ops::AddAssign;

use keepout_kernel::Vec2;
use serde::{Deserialize, Serialize};

/// A point or a vector in the plane: x and y in millimetres. A velocity is in mm/s; a direction has no unit.
///
/// It displays as `(12.340, -5.000) mm`. Files hold it as `[x, y]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "(f64, f64)", into = "(f64, f64)")]
pub struct Mm2 {
    /// Along the x axis.
    pub x: f64,
    /// Along the y axis.
    pub y: f64,
}

keepout_kernel::plane_vector!(Mm2);

impl Mm2 {
    /// The vector of length 1 at `angle` radians from the x axis.
    #[must_use]
    pub fn unit(angle: f64) -> Self {
        Self::new(angle.cos(), angle.sin())
    }

    /// The length of the vector.
    #[must_use]
    pub fn length(self) -> f64 {
        self.x.hypot(self.y)
    }

    /// The angle of the vector from the x axis, radians, in [−π, π].
    #[must_use]
    pub fn angle(self) -> f64 {
        self.y.atan2(self.x)
    }

    /// The direction to another point, of length 1. It is shorter if the points are less than 1e-9 mm apart.
    #[must_use]
    pub fn direction_to(self, other: Self) -> Self {
        (other - self) / self.distance(other).max(1e-9)
    }

    /// The vector turned by `angle` radians, counter-clockwise.
    #[must_use]
    pub fn turned(self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self::new(self.x * cos - self.y * sin, self.x * sin + self.y * cos)
    }

    /// The smaller x and the smaller y of two points.
    #[must_use]
    pub fn min(self, other: Self) -> Self {
        Self::new(self.x.min(other.x), self.y.min(other.y))
    }

    /// The larger x and the larger y of two points.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self::new(self.x.max(other.x), self.y.max(other.y))
    }

    /// Whether both coordinates are finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }

    /// The distance to the polyline through `path`; infinite for an empty path.
    #[must_use]
    pub fn distance_to_path(self, path: &[Self]) -> f64 {
        let ends = path.first().map_or(f64::INFINITY, |&only| self.distance(only));
        path.windows(2).map(|pair| self.distance(self.nearest_on(pair[0], pair[1]))).fold(ends, f64::min)
    }
}

/// A box whose sides are parallel to the axes, mm. Files hold it as `[min x, min y, max x, max y]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(into = "[f64; 4]")]
pub struct Box2 {
    /// The corner with the least x and y.
    pub low: Mm2,
    /// The corner with the largest x and y.
    pub high: Mm2,
}

impl Box2 {
    /// The smallest box around some points. `None` without points.
    #[must_use]
    pub fn around(points: impl IntoIterator<Item = Mm2>) -> Option<Self> {
        points.into_iter().map(|point| Self { low: point, high: point }).reduce(Self::union)
    }

    /// The smallest box around two boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The box, larger by `by` mm on all sides.
    #[must_use]
    pub fn grown(self, by: f64) -> Self {
        let by = Mm2::new(by, by);
        Self { low: self.low - by, high: self.high + by }
    }

    /// Its width and height.
    #[must_use]
    pub fn size(self) -> Mm2 {
        self.high - self.low
    }

    /// The larger of width and height, mm.
    #[must_use]
    pub fn longer_side(self) -> f64 {
        self.size().x.max(self.size().y)
    }

    /// The place in its middle.
    #[must_use]
    pub fn middle(self) -> Mm2 {
        self.low.midpoint(self.high)
    }

    /// Whether a place is within the box, or on its boundary.
    #[must_use]
    pub fn holds(self, place: Mm2) -> bool {
        (self.low.x..=self.high.x).contains(&place.x) && (self.low.y..=self.high.y).contains(&place.y)
    }
}

impl From<Box2> for [f64; 4] {
    fn from(Box2 { low, high }: Box2) -> Self {
        [low.x, low.y, high.x, high.y]
    }
}

impl From<(f64, f64)> for Mm2 {
    fn from((x, y): (f64, f64)) -> Self {
        Self { x, y }
    }
}

/// From numbers that are in millimetres, such as those of an [`ArcView`](keepout_kernel::ArcView) in mm.
impl From<Vec2> for Mm2 {
    fn from(Vec2 { x, y }: Vec2) -> Self {
        Self { x, y }
    }
}

impl From<Mm2> for Vec2 {
    fn from(Mm2 { x, y }: Mm2) -> Self {
        Self { x, y }
    }
}

impl From<Mm2> for (f64, f64) {
    fn from(Mm2 { x, y }: Mm2) -> Self {
        (x, y)
    }
}

impl AddAssign for Mm2 {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl fmt::Display for Mm2 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Adding zero to a rounded number drops the sign of a negative zero.
        let rounded = |value: f64| (value * 1e3).round() / 1e3 + 0.0;
        write!(f, "({:.3}, {:.3}) mm", rounded(self.x), rounded(self.y))
    }
}

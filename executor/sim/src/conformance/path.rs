//! Points and distances in the plane, in millimetres.

use serde::{Deserialize, Serialize};

/// A point in the plane, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mm2 {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
}

impl Mm2 {
    /// The point with these coordinates.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// The point moved by `by`.
    #[must_use]
    pub fn plus(self, by: Self) -> Self {
        Self { x: self.x + by.x, y: self.y + by.y }
    }

    /// The point at `length` from this one, in a direction given in radians.
    #[must_use]
    pub fn toward(self, direction: f64, length: f64) -> Self {
        self.plus(Self { x: length * direction.cos(), y: length * direction.sin() })
    }

    /// The distance to another point.
    #[must_use]
    pub fn distance(self, other: Self) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }

    /// The distance to the polyline through `path`; infinite for an empty path.
    #[must_use]
    pub fn distance_to_path(self, path: &[Self]) -> f64 {
        let ends = path.iter().map(|&end| self.distance(end)).fold(f64::INFINITY, f64::min);
        path.windows(2).map(|pair| self.distance_to_segment(pair[0], pair[1])).fold(ends, f64::min)
    }

    fn distance_to_segment(self, a: Self, b: Self) -> f64 {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let length_2 = dx * dx + dy * dy;
        if length_2 <= 0.0 {
            return self.distance(a);
        }
        let share = (((self.x - a.x) * dx + (self.y - a.y) * dy) / length_2).clamp(0.0, 1.0);
        self.distance(Self { x: a.x + share * dx, y: a.y + share * dy })
    }
}

//! Two coordinates in `f64`, for proposals. Nothing here is trusted.

use crate::curve::hypot;
use crate::exact::lattice::{Point, Vector};

/// Implements what a point or vector with the fields `x` and `y` in `f64` has in every unit. The type adds
/// `length`.
#[macro_export]
macro_rules! plane_vector {
    ($name:ident) => {
        impl $name {
            /// The origin, and the zero vector.
            pub const ZERO: Self = Self::new(0.0, 0.0);

            /// The point or vector with these coordinates.
            #[must_use]
            pub const fn new(x: f64, y: f64) -> Self {
                Self { x, y }
            }

            /// The distance to another point.
            #[must_use]
            pub fn distance(self, other: Self) -> f64 {
                (self - other).length()
            }

            /// The scalar product.
            #[must_use]
            pub fn dot(self, other: Self) -> f64 {
                self.x * other.x + self.y * other.y
            }

            /// Twice the signed area between two vectors: positive if `other` is to the left.
            #[must_use]
            pub fn cross(self, other: Self) -> f64 {
                self.x * other.y - self.y * other.x
            }

            /// The vector turned by 90° counter-clockwise.
            #[must_use]
            pub fn left(self) -> Self {
                Self::new(-self.y, self.x)
            }

            /// The point in the middle between two points.
            #[must_use]
            pub fn midpoint(self, other: Self) -> Self {
                Self::new(f64::midpoint(self.x, other.x), f64::midpoint(self.y, other.y))
            }

            /// The point of the segment from `a` to `b` that is nearest to this one.
            #[must_use]
            pub fn nearest_on(self, a: Self, b: Self) -> Self {
                let along = b - a;
                let length_2 = along.dot(along);
                let share =
                    if length_2 > 0.0 { ((self - a).dot(along) / length_2).clamp(0.0, 1.0) } else { 0.0 };
                a + along * share
            }
        }

        impl core::ops::Add for $name {
            type Output = Self;

            fn add(self, other: Self) -> Self {
                Self::new(self.x + other.x, self.y + other.y)
            }
        }

        impl core::ops::Sub for $name {
            type Output = Self;

            fn sub(self, other: Self) -> Self {
                Self::new(self.x - other.x, self.y - other.y)
            }
        }

        impl core::ops::Mul<f64> for $name {
            type Output = Self;

            fn mul(self, factor: f64) -> Self {
                Self::new(self.x * factor, self.y * factor)
            }
        }

        impl core::ops::Div<f64> for $name {
            type Output = Self;

            fn div(self, by: f64) -> Self {
                Self::new(self.x / by, self.y / by)
            }
        }

        impl core::ops::Neg for $name {
            type Output = Self;

            fn neg(self) -> Self {
                Self::new(-self.x, -self.y)
            }
        }
    };
}

/// A point or a vector in `f64`, in lattice units unless stated otherwise. Use it for proposals and for
/// display only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec2 {
    /// Along the x axis.
    pub x: f64,
    /// Along the y axis.
    pub y: f64,
}

plane_vector!(Vec2);

impl Vec2 {
    /// The length of the vector.
    #[must_use]
    pub fn length(self) -> f64 {
        hypot(self.x, self.y)
    }

    /// The vector of length 1 in the same direction. Zero for the zero vector.
    #[must_use]
    pub fn unit(self) -> Self {
        let length = self.length();
        if length > 0.0 { self / length } else { Self::ZERO }
    }

    /// The vector turned by 90° clockwise.
    #[must_use]
    pub fn right(self) -> Self {
        Self::new(self.y, -self.x)
    }
}

/// The conversion is exact.
impl From<Point> for Vec2 {
    fn from(point: Point) -> Self {
        Self::new(f64::from(point.x.units()), f64::from(point.y.units()))
    }
}

/// The conversion is exact.
impl From<Vector> for Vec2 {
    fn from(vector: Vector) -> Self {
        Self::new(f64::from(vector.dx), f64::from(vector.dy))
    }
}

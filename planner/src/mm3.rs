//! Points and vectors in space, in millimetres.

use std::ops::{Add, AddAssign, Div, Mul, Sub};

use crate::Mm2;

/// A point or a vector in space: x, y and z in millimetres. A velocity is in mm/s; a direction has no unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mm3 {
    /// Along the x axis.
    pub x: f64,
    /// Along the y axis.
    pub y: f64,
    /// Upward, along the tool.
    pub z: f64,
}

impl Mm3 {
    /// The zero vector.
    pub const ZERO: Self = Self::new(0.0, 0.0, 0.0);

    /// A point or a vector.
    #[must_use]
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    /// The point of the plane below it.
    #[must_use]
    pub const fn plane(self) -> Mm2 {
        Mm2::new(self.x, self.y)
    }

    /// The length of the vector.
    #[must_use]
    pub fn length(self) -> f64 {
        self.x.hypot(self.y).hypot(self.z)
    }

    /// The distance to another point.
    #[must_use]
    pub fn distance(self, other: Self) -> f64 {
        (self - other).length()
    }

    /// Scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
}

impl Mm2 {
    /// The point of space above or below it.
    #[must_use]
    pub const fn at_height(self, z: f64) -> Mm3 {
        Mm3::new(self.x, self.y, z)
    }
}

impl Add for Mm3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl AddAssign for Mm3 {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Mm3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f64> for Mm3 {
    type Output = Self;
    fn mul(self, by: f64) -> Self {
        Self::new(self.x * by, self.y * by, self.z * by)
    }
}

impl Div<f64> for Mm3 {
    type Output = Self;
    fn div(self, by: f64) -> Self {
        Self::new(self.x / by, self.y / by, self.z / by)
    }
}

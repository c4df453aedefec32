//! Coordinates, points, vectors and lengths on the integer lattice.
//!
//! Implements SR-01.

use core::fmt;

use super::width::COORD_BITS;

/// Lattice units in one millimetre: the unit is 10 nm.
pub const UNITS_PER_MM: i32 = 100_000;

/// Largest magnitude of a coordinate or length in lattice units: 2^29, which is 5.37 m.
pub const COORD_MAX: i32 = 1 << COORD_BITS;

/// A value outside the lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LatticeError {
    /// The offending value in lattice units.
    pub units: i64,
    /// The smallest accepted value, in lattice units.
    pub least: i32,
}

impl fmt::Display for LatticeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.units == i64::MAX {
            return write!(f, "a coordinate or length is not a number, or lies beyond ±5.37 m");
        }
        write!(
            f,
            "{} lattice units of 10 nm are outside the range {} to {COORD_MAX} (5.37 m)",
            self.units, self.least
        )
    }
}

impl core::error::Error for LatticeError {}

fn bounded(units: i64, least: i32) -> Result<i32, LatticeError> {
    match i32::try_from(units) {
        Ok(value) if (least..=COORD_MAX).contains(&value) => Ok(value),
        _ => Err(LatticeError { units, least }),
    }
}

/// One coordinate in lattice units, `|c| ≤ 2^29`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Coord(i32);

impl Coord {
    /// Checks that `units` lies on the lattice.
    ///
    /// # Errors
    /// [`LatticeError`] when `|units| > 2^29`.
    pub fn from_units(units: i64) -> Result<Self, LatticeError> {
        bounded(units, -COORD_MAX).map(Self)
    }

    /// The coordinate in lattice units.
    #[must_use]
    pub const fn units(self) -> i32 {
        self.0
    }
}

/// A point of the lattice, in units of 10 nm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Point {
    /// Abscissa.
    pub x: Coord,
    /// Ordinate.
    pub y: Coord,
}

impl Point {
    /// The origin.
    pub const ORIGIN: Self = Self { x: Coord(0), y: Coord(0) };

    /// Checks that both coordinates, in lattice units, lie on the lattice.
    ///
    /// # Errors
    /// [`LatticeError`] for the first coordinate whose magnitude exceeds 2^29.
    pub fn from_units(x: i64, y: i64) -> Result<Self, LatticeError> {
        Ok(Self { x: Coord::from_units(x)?, y: Coord::from_units(y)? })
    }

    /// The point moved by `vector`.
    ///
    /// # Errors
    /// [`LatticeError`] when the result leaves the lattice.
    pub fn translated(self, vector: Vector) -> Result<Self, LatticeError> {
        let moved = |c: Coord, d: i32| i64::from(c.0).saturating_add(i64::from(d));
        Self::from_units(moved(self.x, vector.dx), moved(self.y, vector.dy))
    }

    /// The vector from `origin` to this point; each component fits 31 bits.
    #[must_use]
    pub fn minus(self, origin: Self) -> Vector {
        // |a − b| ≤ 2^30, asserted in `width`, so these never saturate.
        Vector { dx: self.x.0.saturating_sub(origin.x.0), dy: self.y.0.saturating_sub(origin.y.0) }
    }
}

/// In millimetres, for messages: `(12.340, -5.000) mm`.
impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {}) mm", Micrometres(self.x.0), Micrometres(self.y.0))
    }
}

/// A height in lattice units, upward, `|h| ≤ 2^29`. Height zero, the default, is the top of the part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Height(i32);

impl Height {
    /// Height zero: the top of the part.
    pub const ZERO: Self = Self(0);

    /// The lowest height of the lattice.
    pub const LOWEST: Self = Self(-COORD_MAX);

    /// The greatest height of the lattice.
    pub const HIGHEST: Self = Self(COORD_MAX);

    /// Checks that `units` lies on the lattice.
    ///
    /// # Errors
    /// [`LatticeError`] when `|units| > 2^29`.
    pub fn from_units(units: i64) -> Result<Self, LatticeError> {
        bounded(units, -COORD_MAX).map(Self)
    }

    /// The height in lattice units.
    #[must_use]
    pub const fn units(self) -> i32 {
        self.0
    }

    /// The height lower by `by`, but not below the lattice.
    #[must_use]
    pub fn lowered(self, by: Length) -> Self {
        Self(self.0.saturating_sub(by.0).max(-COORD_MAX))
    }

    /// The height higher by `by`, but not above the lattice.
    #[must_use]
    pub fn raised(self, by: Length) -> Self {
        Self(self.0.saturating_add(by.0).min(COORD_MAX))
    }
}

/// In millimetres, for messages: `-5.000 mm`.
impl fmt::Display for Height {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} mm", Micrometres(self.0))
    }
}

/// Where the tip of the tool is: a point of the plane and a height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place {
    /// The point of the plane: the tool's axis.
    pub point: Point,
    /// The height of the tip.
    pub height: Height,
}

impl Point {
    /// The place above or below this point at `height`.
    #[must_use]
    pub const fn at_height(self, height: Height) -> Place {
        Place { point: self, height }
    }

    /// The place at height zero: where a tool stands on a machine with two axes.
    #[must_use]
    pub const fn in_plane(self) -> Place {
        self.at_height(Height::ZERO)
    }
}

/// In millimetres, for messages: `(12.340, -5.000, 2.000) mm`.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (x, y) = (Micrometres(self.point.x.0), Micrometres(self.point.y.0));
        write!(f, "({x}, {y}, {}) mm", Micrometres(self.height.0))
    }
}

/// Lattice units as mm with three decimals.
struct Micrometres(i32);

impl fmt::Display for Micrometres {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded = self.0.unsigned_abs().saturating_add(50) / 100;
        let sign = if self.0 < 0 && rounded > 0 { "-" } else { "" };
        write!(f, "{sign}{}.{:03}", rounded / 1000, rounded % 1000)
    }
}

/// The difference of two points, in lattice units; `|component| ≤ 2^30`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Vector {
    /// Component along x.
    pub dx: i32,
    /// Component along y.
    pub dy: i32,
}

/// A length in lattice units, `0 ≤ l ≤ 2^29`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Length(i32);

impl Length {
    /// The length zero.
    pub const ZERO: Self = Self(0);

    /// Checks that `units` is a length of the lattice.
    ///
    /// # Errors
    /// [`LatticeError`] when `units` is negative or exceeds 2^29.
    pub fn from_units(units: i64) -> Result<Self, LatticeError> {
        bounded(units, 0).map(Self)
    }

    /// A length of at most 2.55 µm, for constants: every `u8` is on the lattice.
    #[must_use]
    #[expect(clippy::as_conversions, reason = "`From` is not const; u8 to i32 loses nothing")]
    pub const fn small(units: u8) -> Self {
        Self(units as i32)
    }

    /// A length of `count` millimetres, for constants. The largest is 255 mm.
    #[must_use]
    #[expect(clippy::as_conversions, reason = "`From` is not const; u8 to i32 loses nothing")]
    pub const fn whole_mm(count: u8) -> Self {
        Self((count as i32).saturating_mul(UNITS_PER_MM))
    }

    /// The length in lattice units.
    #[must_use]
    pub const fn units(self) -> i32 {
        self.0
    }

    /// The sum of two lengths.
    ///
    /// # Errors
    /// [`LatticeError`] when the sum exceeds 2^29.
    pub fn plus(self, other: Self) -> Result<Self, LatticeError> {
        Self::from_units(i64::from(self.0).saturating_add(i64::from(other.0)))
    }

    /// The sum of two lengths, limited to the largest length. Use [`Length::plus`] for a threshold: it
    /// reports the overflow.
    #[must_use]
    pub fn saturating_plus(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0).min(COORD_MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_inclusive_and_named_in_the_error() {
        let limit = i64::from(COORD_MAX);
        assert!(Coord::from_units(limit).is_ok() && Coord::from_units(-limit).is_ok());
        assert_eq!(Coord::from_units(limit + 1), Err(LatticeError { units: limit + 1, least: -COORD_MAX }));
        assert!(Length::from_units(-1).is_err());
        assert!(Coord::from_units(i64::MIN).is_err());
    }

    #[test]
    fn points_are_shown_in_millimetres() {
        let shown = |x, y| alloc::format!("{}", Point::from_units(x, y).unwrap());
        assert_eq!(shown(1_234_049, -500_050), "(12.340, -5.001) mm");
        assert_eq!(shown(-49, 0), "(0.000, 0.000) mm");
        let place = Point::ORIGIN.at_height(Height::from_units(-150_000).unwrap());
        assert_eq!(alloc::format!("{place}, {}", place.height), "(0.000, 0.000, -1.500) mm, -1.500 mm");
    }

    #[test]
    fn heights_stay_on_the_lattice() {
        let long = Length::from_units(i64::from(COORD_MAX)).unwrap();
        assert_eq!(Height::LOWEST.lowered(Length::small(1)), Height::LOWEST);
        assert_eq!(Height::HIGHEST.raised(long), Height::HIGHEST);
        assert_eq!(Height::HIGHEST.lowered(long), Height::ZERO);
        assert!(Height::from_units(i64::from(COORD_MAX) + 1).is_err());
        assert!(Height::ZERO > Height::ZERO.lowered(Length::small(1)));
    }

    #[test]
    fn saturating_sum_stops_at_the_largest_length() {
        let long = Length::from_units(i64::from(COORD_MAX)).unwrap();
        assert_eq!(long.saturating_plus(long), long);
        assert!(long.plus(Length::from_units(1).unwrap()).is_err());
    }
}

//! The `f64` door: millimetres to lattice units and back.

use keepout_kernel::curve::{nearest_point, nearest_unit};
use keepout_kernel::{LatticeError, Length, Point, UNITS_PER_MM};

/// Millimetres of a coordinate or length given in lattice units.
#[must_use]
pub fn mm(units: i32) -> f64 {
    f64::from(units) / f64::from(UNITS_PER_MM)
}

/// `(x, y)` of a point in millimetres.
#[must_use]
pub fn point_mm(point: Point) -> (f64, f64) {
    (mm(point.x.units()), mm(point.y.units()))
}

/// The lattice point nearest to `(x, y)` millimetres.
///
/// # Errors
/// [`LatticeError`] when a coordinate is not finite or beyond ±5.37 m.
pub fn point_from_mm((x, y): (f64, f64)) -> Result<Point, LatticeError> {
    nearest_point(x * f64::from(UNITS_PER_MM), y * f64::from(UNITS_PER_MM))
}

/// A length in millimetres rounded *up* to the lattice: thresholds only ever grow.
///
/// # Errors
/// [`LatticeError`] when it is negative, not finite or beyond 5.37 m.
pub fn length_up_from_mm(value_mm: f64) -> Result<Length, LatticeError> {
    let units = value_mm * f64::from(UNITS_PER_MM);
    // A decimal such as 0.1 mm is no binary fraction: what is within 1e-6 of a unit counts as that unit.
    let up = (units - 1e-6).ceil();
    Length::from_units(if up.is_finite() { nearest_unit(up) } else { i64::MAX })
}

/// A point for messages, in millimetres: `(12.340, −5.000)`.
#[must_use]
pub fn place(point: Point) -> String {
    let (x, y) = point_mm(point);
    format!("({x:.3}, {y:.3}) mm")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_round_up_and_decimals_stay() {
        assert_eq!(length_up_from_mm(0.1).unwrap().units(), 10_000);
        assert_eq!(length_up_from_mm(0.100_001_2).unwrap().units(), 10_001);
        assert_eq!(length_up_from_mm(3.0).unwrap().units(), 300_000);
        for bad in [f64::NAN, -1.0, f64::INFINITY, 1e300] {
            assert!(length_up_from_mm(bad).is_err(), "{bad}");
        }
    }
}

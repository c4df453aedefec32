//! Conversions between millimetres in `f64` and lattice units.
//!
//! Implements SR-16.

use crate::{Box2, Mm2, Mm3};
use keepout_kernel::curve::{nearest_point, nearest_unit};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{
    Arc, ArcView, Curve, Height, LatticeError, Length, Place, Point, UNITS_PER_MM, Vec2, Vector,
};

/// Converts a coordinate or length in lattice units to millimetres.
#[must_use]
pub fn mm(units: i32) -> f64 {
    f64::from(units) / f64::from(UNITS_PER_MM)
}

/// `(x, y)` of a point in millimetres.
#[must_use]
pub fn point_mm(point: Point) -> Mm2 {
    Mm2::new(mm(point.x.units()), mm(point.y.units()))
}

/// A vector in millimetres.
#[must_use]
pub fn vector_mm(vector: Vector) -> Mm2 {
    Mm2::new(mm(vector.dx), mm(vector.dy))
}

/// A box in millimetres.
#[must_use]
pub fn window_mm(window: Window) -> Box2 {
    let (x0, y0, x1, y1) = window.corners();
    Box2 { low: Mm2::new(mm(x0), mm(y0)), high: Mm2::new(mm(x1), mm(y1)) }
}

/// The view of an exact arc, in millimetres.
#[must_use]
pub fn arc_mm(arc: &Arc) -> ArcView {
    ArcView::of(arc).in_unit(f64::from(UNITS_PER_MM))
}

/// The lattice point nearest to `(x, y)` millimetres.
///
/// # Errors
/// [`LatticeError`] if a coordinate is not finite or beyond ±5.37 m.
pub fn point_from_mm(place: Mm2) -> Result<Point, LatticeError> {
    nearest_point(in_units(place))
}

/// A place in millimetres, in lattice units.
fn in_units(Mm2 { x, y }: Mm2) -> Vec2 {
    Vec2::new(x * f64::from(UNITS_PER_MM), y * f64::from(UNITS_PER_MM))
}

/// The lattice point near a place in millimetres that divides a curve ([`Curve::dividing_point`]).
///
/// # Errors
/// As [`point_from_mm`].
pub fn dividing_point(curve: &Curve, place: Mm2) -> Result<Point, LatticeError> {
    curve.dividing_point(in_units(place))
}

/// A height nearest to `z` millimetres.
///
/// # Errors
/// [`LatticeError`] if it is not finite or beyond ±5.37 m.
pub fn height_from_mm(z: f64) -> Result<Height, LatticeError> {
    Height::from_units(nearest_point(Vec2::new(0.0, z * f64::from(UNITS_PER_MM)))?.y.units().into())
}

/// The place nearest to a point of space in millimetres.
///
/// # Errors
/// [`LatticeError`] if a coordinate is not finite or beyond ±5.37 m.
pub fn place_from_mm(at: Mm3) -> Result<Place, LatticeError> {
    Ok(point_from_mm(at.plane())?.at_height(height_from_mm(at.z)?))
}

/// A place in millimetres.
#[must_use]
pub fn place_mm(place: Place) -> Mm3 {
    point_mm(place.point).at_height(mm(place.height.units()))
}

/// A length in millimetres, rounded *up* to the lattice: rounding never makes a clearance smaller.
///
/// # Errors
/// [`LatticeError`] if it is negative, not finite or beyond 5.37 m.
pub fn length_up_from_mm(value_mm: f64) -> Result<Length, LatticeError> {
    let units = value_mm * f64::from(UNITS_PER_MM);
    // A decimal such as 0.1 mm has no exact binary fraction, so a value within 1e-6 of a unit counts as that
    // unit.
    let up = (units - 1e-6).ceil();
    Length::from_units(if up.is_finite() { nearest_unit(up) } else { i64::MAX })
}

/// The point at the share `t` in [0, 1] of a curve's length, mm, and the unit vector of travel there.
#[must_use]
pub fn along_mm(curve: &Curve, t: f64) -> (Mm2, Mm2) {
    let (a, b) = (point_mm(curve.from()), point_mm(curve.to()));
    match curve {
        Curve::Line(_) => {
            let along = b - a;
            (a + along * t, along / along.length().max(f64::MIN_POSITIVE))
        }
        Curve::Arc(arc) => {
            let arc = arc_mm(arc);
            (arc.at(t).into(), arc.direction(t).into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Evidence for SR-16.
    #[test]
    fn lengths_are_rounded_up_and_decimals_stay_exact() {
        assert_eq!(length_up_from_mm(0.1).unwrap().units(), 10_000);
        assert_eq!(length_up_from_mm(0.100_001_2).unwrap().units(), 10_001);
        assert_eq!(length_up_from_mm(3.0).unwrap().units(), 300_000);
        for bad in [f64::NAN, -1.0, f64::INFINITY, 1e300] {
            assert!(length_up_from_mm(bad).is_err(), "{bad}");
        }
    }
}

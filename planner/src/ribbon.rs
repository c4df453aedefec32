//! Outlines that are drawn as strokes with width: two contours, one within the other, at a constant distance.
//!
//! Implements SR-27.
//!
//! Some programs plot a line of width w as the boundary of its ink. The material would then be a ribbon as thin as
//! the ink, and the part itself would be air.

use crate::nesting::Nesting;
use crate::select::ContourPolygon;

/// Largest width of a stroke, mm.
const WIDTH_MAX_MM: f64 = 0.31;
/// Largest width of a stroke, as a share of the shorter side of its outer contour.
const SHARE_MAX: f64 = 0.1;
/// Accepted difference of the widths on the four sides, as a share of the width.
const EVEN: f64 = 0.05;
/// The same in mm, for rounded coordinates.
const ROUNDED_MM: f64 = 0.002;

/// Two contours that bound a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ribbon {
    /// Index of the outer contour.
    pub outer: usize,
    /// Index of the inner contour.
    pub inner: usize,
    /// Width of the stroke, mm.
    pub width_mm: f64,
}

/// The strokes among contours.
#[must_use]
pub fn ribbons(outlines: &[ContourPolygon], nesting: &Nesting) -> Vec<Ribbon> {
    let pair = |inner: usize| {
        let outer = nesting.parents[inner].filter(|&outer| nesting.depths[outer].is_multiple_of(2))?;
        let width_mm = width_mm(&outlines[outer], &outlines[inner])?;
        Some(Ribbon { outer, inner, width_mm })
    };
    (0..outlines.len()).filter_map(pair).collect()
}

/// The width of the stroke between two contours, if it is even and thin.
fn width_mm(outer: &ContourPolygon, inner: &ContourPolygon) -> Option<f64> {
    let (low, high) = (inner.bounds.low - outer.bounds.low, outer.bounds.high - inner.bounds.high);
    let sides = [low.x, low.y, high.x, high.y];
    let width = sides.iter().sum::<f64>() / 4.0;
    let tolerance = EVEN * width + ROUNDED_MM;
    let even = sides.iter().all(|side| (side - width).abs() <= tolerance);
    let size = outer.bounds.size();
    let thin = width > 0.0 && width <= WIDTH_MAX_MM && width <= SHARE_MAX * size.x.min(size.y);
    let ink_mm2 = outer.area_mm2 - inner.area_mm2;
    let length = f64::midpoint(outer.length_mm(), inner.length_mm());
    let full = (ink_mm2 - width * length).abs() <= (EVEN * width + ROUNDED_MM) * length;
    (even && thin && full).then_some(width)
}

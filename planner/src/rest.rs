//! The rest material: the stock beside the profile that the tool's disc cannot reach.
//!
//! The disc cuts one contour for each loop of the toolpath ([`CutContour`]). The winding number of these contours
//! is 1 in the part and in the rest material, 0 where one place of the path cuts, and negative where several
//! places cut. So the part with its rest material is where the winding number is positive.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::simplify::SimplifyShape;
use i_overlay::float::single::SingleFloatOverlay;
use keepout_kernel::offset::{CutContour, OffsetLoop, Outline};
use keepout_kernel::{Side, UNITS_PER_MM};

use crate::{Box2, Mm2};

/// Closed polygons, mm. Each begins with its outer contour; its holes follow.
pub(crate) type Polygons = Vec<Vec<Vec<[f64; 2]>>>;

/// Distance of the polygons from the contours, for the area of overlaps, lattice units (10 nm). The area apart from
/// overlaps is that of the true arcs.
const SAGITTA: f64 = 1.0;
/// Number of corners above which the polygons become coarser.
const CORNERS_MAX: usize = 400_000;

/// Area of the rest material beside a profile without keep-out zones, mm².
///
/// The signed area of the cut contours counts stock that several places of the path cut more than once. The area
/// of the polygons with and without these overlaps gives the correction.
pub(crate) fn area_mm2(profile: &[Outline], loops: &[OffsetLoop], side: Side) -> f64 {
    let cut: f64 = loops.iter().map(|each| each.cut.double_area()).sum();
    let part: f64 = profile.iter().map(|outline| CutContour::of(outline).double_area()).sum();
    let unit_2 = f64::from(UNITS_PER_MM) * f64::from(UNITS_PER_MM);
    let rest_mm2 = (cut - part) / 2.0 / unit_2 + overlaps_mm2(loops, side);
    rest_mm2.max(0.0)
}

/// Area that the signed area of the cut contours counts too often, mm².
fn overlaps_mm2(loops: &[OffsetLoop], side: Side) -> f64 {
    // Only arcs of the disc overlap. A contour of the profile alone does not.
    if !loops.iter().any(|each| each.cut.has_disc_arcs()) {
        return 0.0;
    }
    let mut sagitta = SAGITTA;
    let corners = |sagitta| loops.iter().map(|each| each.cut.corner_count(sagitta)).sum::<usize>();
    while sagitta < 1000.0 * SAGITTA && corners(sagitta) > CORNERS_MAX {
        sagitta *= 4.0;
    }
    let contours = contours(loops.iter().map(|each| &each.cut), sagitta, side);
    let signed: f64 = contours.iter().map(|contour| area(contour)).sum();
    let positive = contours.simplify_shape(FillRule::Positive);
    positive.iter().flatten().map(|contour| area(contour)).sum::<f64>() - signed
}

/// The rest material as polygons within `tolerance_mm` of its contours.
pub(crate) fn polygons(profile: &[Outline], loops: &[OffsetLoop], side: Side, tolerance_mm: f64) -> Polygons {
    let sagitta = (tolerance_mm * f64::from(UNITS_PER_MM)).max(1.0);
    let closed =
        contours(loops.iter().map(|each| &each.cut), sagitta, side).simplify_shape(FillRule::Positive);
    let part: Vec<CutContour> = profile.iter().map(CutContour::of).collect();
    let part = contours(part.iter(), sagitta, side).simplify_shape(FillRule::Positive);
    closed.overlay(&part, OverlayRule::Difference, FillRule::NonZero)
}

/// The polygons of contours, mm. For a part around its profile, a frame far outside joins them.
fn contours<'a>(cut: impl Iterator<Item = &'a CutContour>, sagitta: f64, side: Side) -> Vec<Vec<[f64; 2]>> {
    let unit = f64::from(UNITS_PER_MM);
    let mut contours: Vec<Vec<[f64; 2]>> = cut
        .map(|contour| contour.corners(sagitta).into_iter().map(|at| [at.x / unit, at.y / unit]).collect())
        .collect();
    if side == Side::Inside {
        let corners = contours.iter().flatten().map(|&[x, y]| Mm2::new(x, y));
        let Box2 { low, high } = Box2::around(corners).unwrap_or_default().grown(1.0);
        contours.push(vec![[low.x, low.y], [high.x, low.y], [high.x, high.y], [low.x, high.y]]);
    }
    contours
}

/// Signed area of a polygon, positive for a counter-clockwise one.
fn area(contour: &[[f64; 2]]) -> f64 {
    let next = contour.iter().cycle().skip(1);
    contour.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>() / 2.0
}

#[cfg(test)]
mod tests {
    use keepout_kernel::offset::propose;
    use keepout_kernel::{Arc, Curve, Point, Turn};

    use super::*;

    fn circle(x_mm: f64, radius: i64) -> Outline {
        let at = |dx: i64| {
            let x = keepout_kernel::curve::nearest_unit(x_mm * 1e5);
            Point::from_units(x + dx, 0).unwrap()
        };
        let half = |from, to| Curve::Arc(Arc::new(at(from), at(to), at(0), Turn::CounterClockwise).unwrap());
        Outline { curves: vec![half(radius, -radius), half(-radius, radius)], free_on_left: false }
    }

    /// The smallest case of the findings: the discs between two posts overlap.
    #[test]
    fn overlapping_discs_are_counted_once() {
        let posts = [circle(0.0, 130_000), circle(7.4246, 130_000)];
        let offset = propose(&posts, 300_000.0);
        let area = area_mm2(&posts, &offset.loops, Side::Outside);
        // The closed form: the kite of four centres, less two sectors of the tool and two of each post, plus the
        // lens of the discs.
        let (r, t, half) = (1.3_f64, 3.0_f64, 7.4246 / 2.0);
        let y = ((r + t).powi(2) - half * half).sqrt();
        let at_post = (y / half).atan();
        let kite = 2.0 * half * y;
        let sectors = 2.0 * at_post * r * r + (std::f64::consts::PI - 2.0 * at_post) * t * t;
        let lens = 2.0 * (t * t * (y / t).acos() - y * (t * t - y * y).sqrt());
        let wanted = kite - sectors + lens;
        assert!((area - wanted).abs() < 2e-4, "{area} is not {wanted}");
    }

    #[test]
    fn hole_that_the_tool_does_not_enter_is_rest_material() {
        let corner = |x: i64, y: i64| Point::from_units(x * 100_000, y * 100_000).unwrap();
        let corners = [corner(-20, -20), corner(20, -20), corner(20, 20), corner(-20, 20)];
        let next = corners.iter().cycle().skip(1);
        let line = |(&from, &to)| Curve::Line(keepout_kernel::Segment { from, to });
        let plate = Outline { curves: corners.iter().zip(next).map(line).collect(), free_on_left: false };
        let profile = [plate, Outline { free_on_left: true, ..circle(0.0, 250_000) }];
        let offset = propose(&profile, 300_000.0);
        let area = area_mm2(&profile, &offset.loops, Side::Outside);
        let wanted = std::f64::consts::PI * 2.5 * 2.5;
        assert!((area - wanted).abs() < 1e-6, "{area} is not {wanted}");
    }
}

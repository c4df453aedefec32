//! The shapes of outlines, before faults.

use std::f64::consts::{PI, TAU};

use arbitrary::{Arbitrary, Result, Unstructured};

use super::number;

/// Largest number of corners of an outline.
const CORNERS_MAX: usize = 24;

/// The shape of an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutlineShape {
    /// Corners around a centre, at any distance.
    Star,
    /// Corners anywhere.
    Free,
    /// A rectangle with round corners.
    Rounded,
    /// A rectangle with slots from above.
    Comb,
    /// Arcs all around.
    Blob,
    /// A circle.
    Circle,
    /// An ellipse.
    Ellipse,
    /// A spline through control points around a centre.
    Spline,
}

impl OutlineShape {
    const ALL: [Self; 8] = [
        Self::Star,
        Self::Free,
        Self::Rounded,
        Self::Comb,
        Self::Blob,
        Self::Circle,
        Self::Ellipse,
        Self::Spline,
    ];
}

/// A corner, and the bulge of the edge that begins there: the tangent of a quarter of the angle that the
/// edge turns through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// x and y.
    pub at: (f64, f64),
    /// The bulge.
    pub bulge: f64,
}

/// A closed outline.
#[derive(Clone, Debug, PartialEq)]
pub enum SketchOutline {
    /// Edges from corner to corner, and back to the first.
    Corners(Vec<Corner>),
    /// A circle or ellipse: centre, half axis, ratio of the other half axis, and parameters of beginning
    /// and end.
    Round {
        /// The centre.
        centre: (f64, f64),
        /// The half axis from it.
        axis: (f64, f64),
        /// Length of the other half axis divided by this one.
        ratio: f64,
        /// Begin and end, radians.
        range: (f64, f64),
        /// It is written as a circle or arc.
        circle: bool,
    },
    /// A clamped spline: degree, knots, control points with weights.
    Spline {
        /// The degree.
        degree: u8,
        /// The knots.
        knots: Vec<f64>,
        /// The control points.
        points: Vec<(f64, f64)>,
        /// Their weights. A plain spline has no weights.
        weights: Vec<f64>,
    },
}

impl<'a> Arbitrary<'a> for SketchOutline {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        let shape = *u.choose(&OutlineShape::ALL)?;
        let centre = if u.int_in_range(0..=3_u8)? == 0 { (number(u)?, number(u)?) } else { (0.0, 0.0) };
        let size = *u.choose(&[40.0, 40.0, 10.0, 100.0, 0.05, 1.0, 1200.0, 5000.0])?;
        let frame = Frame { centre, half: size / 2.0 };
        match shape {
            OutlineShape::Star => frame.star(u),
            OutlineShape::Free => frame.free(u),
            OutlineShape::Rounded => frame.rounded(u),
            OutlineShape::Comb => frame.comb(u),
            OutlineShape::Blob => frame.blob(u),
            OutlineShape::Circle | OutlineShape::Ellipse => frame.round(shape == OutlineShape::Circle, u),
            OutlineShape::Spline => spline(u, centre, frame.half),
        }
    }
}

/// The centre of an outline, and half its size.
#[derive(Clone, Copy)]
struct Frame {
    centre: (f64, f64),
    half: f64,
}

impl Frame {
    fn corner(self, x: f64, y: f64, bulge: f64) -> Corner {
        Corner { at: (self.centre.0 + x, self.centre.1 + y), bulge }
    }

    fn star(self, u: &mut Unstructured<'_>) -> Result<SketchOutline> {
        let count = u.int_in_range(3..=CORNERS_MAX)?;
        let each = |k| {
            let (x, y) = on_circle(k, count, self.half * share(u)?);
            Ok(self.corner(x, y, 0.0))
        };
        Ok(SketchOutline::Corners((0..count).map(each).collect::<Result<_>>()?))
    }

    fn free(self, u: &mut Unstructured<'_>) -> Result<SketchOutline> {
        let count = u.int_in_range(2..=CORNERS_MAX / 2)?;
        let each = |_| Ok(self.corner(number(u)?, number(u)?, 0.0));
        Ok(SketchOutline::Corners((0..count).map(each).collect::<Result<_>>()?))
    }

    fn rounded(self, u: &mut Unstructured<'_>) -> Result<SketchOutline> {
        let h = self.half;
        let r = h * share(u)? * 0.9;
        let bulge = (PI / 8.0).tan() * if bool::arbitrary(u)? { 1.0 } else { -1.0 };
        let (i, sides) = (h - r, [0.0, bulge].into_iter().cycle());
        let places = [(-i, -h), (i, -h), (h, -i), (h, i), (i, h), (-i, h), (-h, i), (-h, -i)];
        Ok(SketchOutline::Corners(
            places.into_iter().zip(sides).map(|((x, y), b)| self.corner(x, y, b)).collect(),
        ))
    }

    fn comb(self, u: &mut Unstructured<'_>) -> Result<SketchOutline> {
        let h = self.half;
        let (slots, wide, deep) = (u.int_in_range(1..=4_u8)?, share(u)?, 2.0 * h * share(u)?);
        let bulge = *u.choose(&[0.0, 1.0, -1.0, 0.3])?;
        let pitch = 2.0 * h / f64::from(slots);
        let mut corners: Vec<Corner> =
            [(-h, -h), (h, -h), (h, h)].into_iter().map(|(x, y)| self.corner(x, y, 0.0)).collect();
        for k in (0..slots).rev() {
            let (middle, half) = (pitch * (f64::from(k) + 0.5) - h, pitch * wide / 2.0);
            let (a, b, floor) = (middle + half, middle - half, h - deep);
            let slot = [(a, h, 0.0), (a, floor, -bulge), (b, floor, 0.0), (b, h, 0.0)];
            corners.extend(slot.into_iter().map(|(x, y, bulge)| self.corner(x, y, bulge)));
        }
        corners.push(self.corner(-h, h, 0.0));
        Ok(SketchOutline::Corners(corners))
    }

    fn blob(self, u: &mut Unstructured<'_>) -> Result<SketchOutline> {
        let count = u.int_in_range(2..=CORNERS_MAX / 2)?;
        let each = |k| {
            let (x, y) = on_circle(k, count, self.half * (0.6 + 0.4 * share(u)?));
            Ok(self.corner(x, y, share(u)? - 0.4))
        };
        Ok(SketchOutline::Corners((0..count).map(each).collect::<Result<_>>()?))
    }

    fn round(self, circle: bool, u: &mut Unstructured<'_>) -> Result<SketchOutline> {
        let ratio = if circle { 1.0 } else { *u.choose(&[0.5, 0.9, 1.0, 0.01, 1e-6, 2.0, 0.0])? };
        let part = u.int_in_range(0..=7_u8)? == 0;
        let range = if part { (number(u)?, number(u)?) } else { (0.0, TAU) };
        let (sine, cosine) = (TAU * share(u)?).sin_cos();
        let axis = if circle { (self.half, 0.0) } else { (self.half * cosine, self.half * sine) };
        Ok(SketchOutline::Round { centre: self.centre, axis, ratio, range, circle })
    }
}

/// A share in (0, 1].
fn share(u: &mut Unstructured<'_>) -> Result<f64> {
    Ok((f64::from(u8::arbitrary(u)?) + 1.0) / 256.0)
}

#[expect(clippy::cast_precision_loss, reason = "few corners")]
fn on_circle(k: usize, count: usize, r: f64) -> (f64, f64) {
    let angle = TAU * k as f64 / count as f64;
    (r * angle.cos(), r * angle.sin())
}

/// A clamped spline that ends where it began. Some of its inner knots are repeated.
fn spline(u: &mut Unstructured<'_>, centre: (f64, f64), h: f64) -> Result<SketchOutline> {
    let degree = *u.choose(&[3_u8, 2, 3, 1, 4, 5, 9])?;
    let count = usize::from(degree) + 1 + u.int_in_range(1..=7_usize)?;
    let mut points = (0..count - 1)
        .map(|k| {
            let (x, y) = on_circle(k, count - 1, h * (0.3 + 0.7 * share(u)?));
            Ok((centre.0 + x, centre.1 + y))
        })
        .collect::<Result<Vec<_>>>()?;
    points.push(points[0]);
    let mut knots = vec![0.0; usize::from(degree) + 1];
    let mut last = 0.0;
    for _ in 0..count - usize::from(degree) - 1 {
        last += *u.choose(&[1.0, 1.0, 0.25, 0.0, 1e-9])?;
        knots.push(last);
    }
    knots.extend(vec![last + 1.0; usize::from(degree) + 1]);
    let rational = u.int_in_range(0..=3_u8)? == 0;
    let weights = if rational {
        (0..count).map(|_| Ok(*u.choose(&[1.0, 0.5, 2.0, 100.0, 1e-3, 1e6])?)).collect::<Result<_>>()?
    } else {
        vec![]
    };
    Ok(SketchOutline::Spline { degree, knots, points, weights })
}

//! The placement of an entity's own coordinates in the drawing: an affine map of space, then a projection
//! onto the xy plane.
//!
//! Implements SR-27.

use std::f64::consts::{PI, TAU};

use keepout_kernel::ArcView;
use keepout_kernel::curve::half_circle_parts;

use super::RawCurve;
use super::entity::{Insert, Vec3};
use crate::Mm2;

/// An affine map, stored as the images of the three axes and of the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    axes: [Vec3; 3],
    origin: Vec3,
}

/// Tolerance, relative to their length, within which the axes of an arc's image are equal and perpendicular.
const ROUND: f64 = 1e-9;
/// Smallest height of an arc above its chord, mm (half a lattice unit). The chord replaces a flatter arc.
const FLAT_MM: f64 = 5e-6;

impl Placement {
    /// The map that only scales, to millimetres.
    #[must_use]
    pub fn scaled(scale: f64) -> Self {
        Self { axes: [[scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale]], origin: [0.0; 3] }
    }

    /// This map, followed by a rotation about z and an offset: from the drawing to the machine.
    #[must_use]
    pub fn placed(self, degrees: f64, Mm2 { x, y }: Mm2) -> Self {
        let turn = Self { axes: turned(degrees), origin: [x, y, 0.0] };
        turn.of(self)
    }

    /// This map after `first`.
    #[must_use]
    pub fn of(&self, first: Self) -> Self {
        Self { axes: first.axes.map(|axis| self.vector(axis)), origin: self.point(first.origin) }
    }

    /// The image of a point.
    #[must_use]
    pub fn point(&self, p: Vec3) -> Vec3 {
        add(self.vector(p), self.origin)
    }

    /// The image of a vector.
    #[must_use]
    pub fn vector(&self, v: Vec3) -> Vec3 {
        let [x, y, z] = self.axes;
        [0, 1, 2].map(|i| x[i] * v[0] + y[i] * v[1] + z[i] * v[2])
    }

    /// The image of a point, projected onto the xy plane.
    #[must_use]
    pub fn seen(&self, p: Vec3) -> Mm2 {
        let [x, y, _] = self.point(p);
        Mm2::new(x, y)
    }

    fn seen_vector(&self, v: Vec3) -> Mm2 {
        let [x, y, _] = self.vector(v);
        Mm2::new(x, y)
    }

    /// The map from the plane with this normal, by the arbitrary axis algorithm of the DXF reference.
    #[must_use]
    pub fn in_plane(&self, normal: Vec3) -> Self {
        match unit(normal) {
            None | Some([0.0, 0.0, 1.0]) => *self,
            Some(z) => {
                let near_z = z[0].abs() < 1.0 / 64.0 && z[1].abs() < 1.0 / 64.0;
                let helper = if near_z { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
                let x = unit(cross(helper, z)).unwrap_or([1.0, 0.0, 0.0]);
                self.of(Self { axes: [x, cross(z, x), z], origin: [0.0; 3] })
            }
        }
    }

    /// The map of a block's coordinates, for one place of the insert's array.
    #[must_use]
    pub fn inserted(&self, insert: &Insert, normal: Vec3, base: Vec3, (column, row): (f64, f64)) -> Self {
        let turn = Self { axes: turned(insert.rotation), origin: insert.at };
        let step =
            Self { origin: [column * insert.spacing.0, row * insert.spacing.1, 0.0], ..Self::scaled(1.0) };
        let [sx, sy, sz] = insert.scale;
        let scale = Self { axes: [[sx, 0.0, 0.0], [0.0, sy, 0.0], [0.0, 0.0, sz]], origin: [0.0; 3] };
        let to_base = Self { origin: base.map(|c| -c), ..Self::scaled(1.0) };
        self.in_plane(normal).of(turn).of(step).of(scale).of(to_base)
    }

    /// Adds the image of the elliptic arc `centre + cos t · a + sin t · b`, for t from `start` over `sweep`.
    /// The result is a circular arc if the image is one, and lines if the arc's plane is vertical.
    pub fn arc(&self, centre: Vec3, (a, b): (Vec3, Vec3), start: f64, sweep: f64, out: &mut Vec<RawCurve>) {
        let (c, a, b) = (self.seen(centre), self.seen_vector(a), self.seen_vector(b));
        let at = |t: f64| c + a * t.cos() + b * t.sin();
        let whole = sweep.abs() >= TAU;
        let from = at(start);
        let to = if whole { from } else { at(start + sweep) };
        let (la, lb) = (a.length(), b.length());
        let larger = la.max(lb);
        let det = a.cross(b);
        if (la - lb).abs() <= ROUND * larger && a.dot(b).abs() <= ROUND * larger * larger {
            let sign = if det < 0.0 { -1.0 } else { 1.0 };
            let start = a.y.atan2(a.x) + sign * start;
            let arc = ArcView { centre: c.into(), radius: la, start, sweep: sign * sweep };
            out.push(RawCurve::Arc { arc, from, to });
        } else if det.abs() <= ROUND * larger * larger {
            // The plane is vertical: the image runs there and back along a line.
            let parts = f64::from(half_circle_parts(sweep.abs()));
            let mut k = 0.0;
            while k < parts {
                let ends = (at(start + sweep * k / parts), at(start + sweep * (k + 1.0) / parts));
                out.push(RawCurve::Line { from: ends.0, to: ends.1 });
                k += 1.0;
            }
        } else {
            elliptic_beziers(&at, c, (start, sweep), PI / 2.0, out);
        }
    }
}

/// Adds rational quadratic pieces of an angle of at most `longest`.
///
/// The middle control point is the intersection of the end tangents. Its weight is the cosine of half the
/// piece's angle (Piegl & Tiller, The NURBS Book, §7.3).
pub(super) fn elliptic_beziers(
    at: &dyn Fn(f64) -> Mm2,
    centre: Mm2,
    (start, sweep): (f64, f64),
    longest: f64,
    out: &mut Vec<RawCurve>,
) {
    let whole = sweep.abs() >= TAU;
    let parts = (sweep.abs() / longest - 1e-9).ceil().max(1.0);
    let step = sweep / parts;
    let weight = (step / 2.0).cos();
    let first = at(start);
    let (mut k, mut from) = (0.0, first);
    while k < parts {
        let t = start + step * k;
        let last = k + 1.0 >= parts;
        let to = if last && whole { first } else { at(t + step) };
        let middle = centre + (at(t + step / 2.0) - centre) / weight;
        out.push(RawCurve::bezier(vec![from, middle, to], vec![1.0, weight, 1.0]));
        from = to;
        k += 1.0;
    }
}

/// Adds the arc from `from` to `to` with `bulge` = tan(sweep / 4), in the plane that `placement` maps. A flat
/// arc becomes its chord.
pub fn bulge(placement: &Placement, from: Vec3, to: Vec3, bulge: f64, out: &mut Vec<RawCurve>) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let chord = dx.hypot(dy);
    let seen = (placement.seen(from), placement.seen(to));
    let size = seen.0.distance(seen.1);
    // Distance of the projected arc's middle from its chord: uneven scales can stretch it more than the
    // chord.
    let height = placement.seen_vector([-dy * bulge / 2.0, dx * bulge / 2.0, 0.0]);
    let bend = (bulge.abs() * size / 2.0).max(height.length());
    if bulge == 0.0 || chord == 0.0 || bend < FLAT_MM {
        if seen.0 != seen.1 {
            out.push(RawCurve::Line { from: seen.0, to: seen.1 });
        }
        return;
    }
    // Distance from the chord's midpoint to the centre, positive to the left of the chord: chord·(1 − b²) /
    // 4b.
    let to_centre = (1.0 - bulge * bulge) / (4.0 * bulge);
    let centre = [
        f64::midpoint(from[0], to[0]) - dy * to_centre,
        f64::midpoint(from[1], to[1]) + dx * to_centre,
        from[2],
    ];
    let radius = chord * (1.0 + bulge * bulge) / (4.0 * bulge.abs());
    let start = (from[1] - centre[1]).atan2(from[0] - centre[0]);
    let first = out.len();
    placement.arc(centre, ([radius, 0.0, 0.0], [0.0, radius, 0.0]), start, 4.0 * bulge.atan(), out);
    // Curves meet exactly at the vertices.
    if let Some(curve) = out.get_mut(first) {
        curve.set_from(seen.0);
    }
    if let Some(curve) = out[first..].last_mut() {
        curve.set_to(seen.1);
    }
}

fn turned(degrees: f64) -> [Vec3; 3] {
    // Quarter turns are exact.
    let (sin, cos) = match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => other.to_radians().sin_cos(),
    };
    [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]
}

fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn unit(v: Vec3) -> Option<Vec3> {
    // Scaled first, because the squares of very large or very small numbers overflow or vanish.
    let largest = v.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    let v = v.map(|c| c / largest);
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length.is_finite() && length > 0.0).then(|| v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use keepout_kernel::Vec2;

    const FLAT: Placement =
        Placement { axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: [0.0; 3] };

    fn bulged(from: Vec3, to: Vec3, b: f64) -> RawCurve {
        let mut out = Vec::new();
        bulge(&FLAT, from, to, b, &mut out);
        out.remove(0)
    }

    #[test]
    fn bulge_of_a_semicircle() {
        let RawCurve::Arc { arc, .. } = bulged([0.0; 3], [10.0, 0.0, 0.0], 1.0) else {
            panic!("a bulge of one is an arc")
        };
        let centre = arc.centre;
        assert!((centre.x - 5.0).abs() < 1e-12 && centre.y.abs() < 1e-12 && (arc.radius - 5.0).abs() < 1e-12);
        assert!((arc.sweep - PI).abs() < 1e-12);
    }

    #[test]
    fn quarter_bulge_bends_to_the_right_of_the_chord() {
        // A positive bulge is counter-clockwise: the arc from (0,0) to (1,1) about (0,1).
        let RawCurve::Arc { arc, .. } = bulged([0.0; 3], [1.0, 1.0, 0.0], (PI / 8.0).tan()) else {
            panic!("an arc")
        };
        assert!((arc.centre.x).abs() < 1e-12 && (arc.centre.y - 1.0).abs() < 1e-12, "{arc:?}");
    }

    #[test]
    fn arc_stretched_by_an_uneven_scale_is_not_flat() {
        let narrow =
            Placement { axes: [[1e-4, 0.0, 0.0], [0.0, 1e3, 0.0], [0.0, 0.0, 1.0]], origin: [0.0; 3] };
        let mut out = Vec::new();
        bulge(&narrow, [0.0; 3], [1.0, 0.0, 0.0], 1e-3, &mut out);
        let [RawCurve::Bezier(one), ..] = &out[..] else { panic!("half a millimetre high: {out:?}") };
        let highest = [0.2, 0.5, 0.8, 1.0].map(|t| one.at(t).y.abs()).into_iter().fold(0.0, f64::max);
        assert!((highest - 0.5).abs() < 1e-3, "{highest}");
    }

    #[test]
    fn downward_normal_mirrors_in_x() {
        let placement = FLAT.in_plane([0.0, 0.0, -1.0]);
        assert_eq!(placement.seen([3.0, 2.0, 0.0]), Mm2::new(-3.0, 2.0));
        let mut out = Vec::new();
        placement.arc([5.0, 0.0, 0.0], ([2.0, 0.0, 0.0], [0.0, 2.0, 0.0]), 0.0, PI / 2.0, &mut out);
        let RawCurve::Arc { arc, from, to } = out[0] else { panic!("an arc") };
        assert_eq!(arc.centre, Vec2::new(-5.0, 0.0));
        assert!((from.x + 7.0).abs() < 1e-12 && (to.y - 2.0).abs() < 1e-12 && arc.sweep < 0.0);
    }

    #[test]
    fn uneven_scale_turns_a_circle_into_pieces_on_its_ellipse() {
        let uneven =
            Placement { axes: [[2.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: [1.0, 2.0, 0.0] };
        let mut out = Vec::new();
        uneven.arc([0.0; 3], ([3.0, 0.0, 0.0], [0.0, 3.0, 0.0]), 0.3, TAU, &mut out);
        assert_eq!(out.len(), 4);
        for curve in &out {
            let RawCurve::Bezier(bezier) = curve else { panic!("{curve:?}") };
            for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
                let Mm2 { x, y } = bezier.at(t);
                // Back through the map onto the circle of radius 3.
                let v = y - 2.0;
                let u = (x - 1.0 - 0.5 * v) / 2.0;
                assert!((u.hypot(v) - 3.0).abs() < 1e-12, "{t}: {u} {v}");
            }
        }
    }
}

//! The mathematical definitions, in exact rational arithmetic on big integers.

use num_bigint::BigInt;

/// A point with big-integer coordinates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Big {
    /// Abscissa.
    pub x: BigInt,
    /// Ordinate.
    pub y: BigInt,
}

impl Big {
    /// The point `(x, y)`.
    #[must_use]
    pub fn new(x: i64, y: i64) -> Self {
        Self { x: x.into(), y: y.into() }
    }

    fn minus(&self, other: &Self) -> Self {
        Self { x: &self.x - &other.x, y: &self.y - &other.y }
    }

    fn dot(&self, other: &Self) -> BigInt {
        &self.x * &other.x + &self.y * &other.y
    }

    fn cross(&self, other: &Self) -> BigInt {
        &self.x * &other.y - &self.y * &other.x
    }
}

fn zero() -> BigInt {
    BigInt::from(0)
}

/// The sign of the signed area of the triangle `a b c`, as −1, 0 or 1, by the shoelace formula.
#[must_use]
pub fn area_sign(a: &Big, b: &Big, c: &Big) -> i8 {
    let area = &a.x * &b.y - &b.x * &a.y + &b.x * &c.y - &c.x * &b.y + &c.x * &a.y - &a.x * &c.y;
    i8::from(area > zero()) - i8::from(area < zero())
}

/// Whether the least of `|p − a − t(b − a)|²` over `t` in [0, 1] is at most `r²`: the quadratic is minimised at its
/// vertex, moved into [0, 1], and its value there compared as a fraction.
#[must_use]
pub fn point_segment_within(p: &Big, a: &Big, b: &Big, r: i64) -> bool {
    let (d, w) = (b.minus(a), p.minus(a));
    let denominator = d.dot(&d);
    if denominator == zero() {
        return w.dot(&w) <= BigInt::from(r) * r;
    }
    let t = w.dot(&d).clamp(zero(), denominator.clone());
    let off = Big { x: &w.x * &denominator - &d.x * &t, y: &w.y * &denominator - &d.y * &t };
    off.dot(&off) <= BigInt::from(r) * r * &denominator * &denominator
}

/// Whether the least of `|a + s(b − a) − c − t(d − c)|²` over the unit square is at most `r²`. The function is convex:
/// its minimum is the zero of the difference, when that lies in the square, or lies on the square's boundary, whose
/// four sides are point–segment problems.
#[must_use]
pub fn segment_segment_within(a: &Big, b: &Big, c: &Big, d: &Big, r: i64) -> bool {
    let (u, v, w) = (b.minus(a), d.minus(c), c.minus(a));
    let m = u.cross(&v);
    if m != zero() {
        // s = (w × v) / m and t = (w × u) / m, compared with 0 and 1 after clearing the denominator's sign.
        let sign = if m < zero() { BigInt::from(-1) } else { BigInt::from(1) };
        let (s, t, m) = (w.cross(&v) * &sign, w.cross(&u) * &sign, &m * &sign);
        let unit = zero()..=m;
        if unit.contains(&s) && unit.contains(&t) {
            return true;
        }
    }
    point_segment_within(a, c, d, r)
        || point_segment_within(b, c, d, r)
        || point_segment_within(c, a, b, r)
        || point_segment_within(d, a, b, r)
}

/// Whether `p` is a convex combination of `a`, `b`, `c`, by barycentric coordinates; degenerate triangles are their
/// sides.
#[must_use]
pub fn in_triangle(p: &Big, a: &Big, b: &Big, c: &Big) -> bool {
    let whole = b.minus(a).cross(&c.minus(a));
    if whole == zero() {
        return [(a, b), (b, c), (c, a)].into_iter().any(|(q, r)| point_segment_within(p, q, r, 0));
    }
    let part = |q: &Big, r: &Big| q.minus(p).cross(&r.minus(p)) * &whole >= zero();
    part(a, b) && part(b, c) && part(c, a)
}

/// Whether the filled triangle and the segment come within `r`.
#[must_use]
pub fn triangle_segment_within(corners: [&Big; 3], d: &Big, e: &Big, r: i64) -> bool {
    let [a, b, c] = corners;
    in_triangle(d, a, b, c)
        || in_triangle(e, a, b, c)
        || [(a, b), (b, c), (c, a)].into_iter().any(|(p, q)| segment_segment_within(p, q, d, e, r))
}

/// Whether `p` is strictly inside the polygon, by the winding number summed over quadrants' worth of signed crossings
/// of both rays from `p`; `None` for a point on the polygon.
#[must_use]
pub fn inside_polygon(p: &Big, polygon: &[Big]) -> Option<bool> {
    let mut winding = 0;
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        if point_segment_within(p, a, b, 0) {
            return None;
        }
        // A crossing of the ray toward −x: the mirror image of the kernel's ray.
        let side = area_sign(a, b, p);
        if a.y <= p.y && b.y > p.y && side < 0 {
            winding += 1;
        } else if b.y <= p.y && a.y > p.y && side > 0 {
            winding -= 1;
        }
    }
    Some(winding % 2 != 0)
}

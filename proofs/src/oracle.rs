//! The mathematical definitions in exact rational arithmetic: on big integers, or on plain integers where
//! inputs are small.

use std::ops::{Add, Mul, Sub};

/// Whole numbers of any size.
pub use num_bigint::BigInt as Wide;

/// Whole numbers that do not overflow in their use: big integers anywhere, `i64` for coordinates up to 16,
/// `i128` for coordinates up to 2^13.
pub trait Whole:
    Clone + Ord + From<i64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
}

impl Whole for i64 {}
impl Whole for i128 {}
impl Whole for Wide {}

/// A point with coordinates of some kind of whole numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WholePoint<N> {
    /// Abscissa.
    pub x: N,
    /// Ordinate.
    pub y: N,
}

/// A point with big-integer coordinates.
pub type Big = WholePoint<Wide>;

impl<N: Whole> WholePoint<N> {
    /// The point `(x, y)`.
    #[must_use]
    pub fn new(x: i64, y: i64) -> Self {
        Self { x: x.into(), y: y.into() }
    }

    fn minus(&self, other: &Self) -> Self {
        Self { x: self.x.clone() - other.x.clone(), y: self.y.clone() - other.y.clone() }
    }

    fn dot(&self, other: &Self) -> N {
        self.x.clone() * other.x.clone() + self.y.clone() * other.y.clone()
    }

    fn cross(&self, other: &Self) -> N {
        self.x.clone() * other.y.clone() - self.y.clone() * other.x.clone()
    }

    /// `k` times this less `l` times the other.
    fn combined(&self, k: &N, other: &Self, l: &N) -> Self {
        Self {
            x: self.x.clone() * k.clone() - other.x.clone() * l.clone(),
            y: self.y.clone() * k.clone() - other.y.clone() * l.clone(),
        }
    }
}

fn zero<N: Whole>() -> N {
    N::from(0)
}

fn times<N: Whole>(a: &N, b: &N) -> N {
    a.clone() * b.clone()
}

/// The sign of the signed area of the triangle `a b c`, as −1, 0 or 1, by the shoelace formula.
#[must_use]
pub fn area_sign<N: Whole>(a: &WholePoint<N>, b: &WholePoint<N>, c: &WholePoint<N>) -> i8 {
    let area = a.cross(b) + b.cross(c) + c.cross(a);
    i8::from(area > zero()) - i8::from(area < zero())
}

/// Whether the least of `|p − a − t(b − a)|²` over `t` in [0, 1] is at most `r²`. The quadratic is least at
/// its vertex, clamped to [0, 1]. The value there is compared as a fraction.
#[must_use]
pub fn point_segment_within<N: Whole>(
    p: &WholePoint<N>,
    a: &WholePoint<N>,
    b: &WholePoint<N>,
    r: i64,
) -> bool {
    let (d, w) = (b.minus(a), p.minus(a));
    let denominator = d.dot(&d);
    if denominator == zero() {
        return w.dot(&w) <= N::from(r) * N::from(r);
    }
    let t = w.dot(&d).clamp(zero(), denominator.clone());
    let off = w.combined(&denominator, &d, &t);
    off.dot(&off) <= times(&(denominator.clone() * N::from(r)), &(denominator * N::from(r)))
}

/// Whether the least of `|a + s(b − a) − c − t(d − c)|²` over the unit square is at most `r²`. The function
/// is convex. Its minimum is the zero of the difference if that lies in the square. Otherwise the minimum
/// lies on the square's boundary, whose four sides are point–segment problems.
#[must_use]
pub fn segment_segment_within<N: Whole>(
    a: &WholePoint<N>,
    b: &WholePoint<N>,
    c: &WholePoint<N>,
    d: &WholePoint<N>,
    r: i64,
) -> bool {
    let (u, v, w) = (b.minus(a), d.minus(c), c.minus(a));
    let m = u.cross(&v);
    if m != zero() {
        // s = (w × v) / m and t = (w × u) / m, compared with 0 and 1 after clearing the denominator's sign.
        let sign = N::from(if m < zero() { -1 } else { 1 });
        let (s, t, m) = (w.cross(&v) * sign.clone(), w.cross(&u) * sign.clone(), m * sign);
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

/// Whether `p` is a convex combination of `a`, `b`, `c`, by barycentric coordinates. A degenerate triangle
/// is the union of its sides.
#[must_use]
pub fn in_triangle<N: Whole>(
    p: &WholePoint<N>,
    a: &WholePoint<N>,
    b: &WholePoint<N>,
    c: &WholePoint<N>,
) -> bool {
    let whole = b.minus(a).cross(&c.minus(a));
    if whole == zero() {
        return [(a, b), (b, c), (c, a)].into_iter().any(|(q, r)| point_segment_within(p, q, r, 0));
    }
    let part = |q: &WholePoint<N>, r: &WholePoint<N>| q.minus(p).cross(&r.minus(p)) * whole.clone() >= zero();
    part(a, b) && part(b, c) && part(c, a)
}

/// Whether the filled triangle and the segment come within `r`.
#[must_use]
pub fn triangle_segment_within<N: Whole>(
    corners: [&WholePoint<N>; 3],
    d: &WholePoint<N>,
    e: &WholePoint<N>,
    r: i64,
) -> bool {
    let [a, b, c] = corners;
    in_triangle(d, a, b, c)
        || in_triangle(e, a, b, c)
        || [(a, b), (b, c), (c, a)].into_iter().any(|(p, q)| segment_segment_within(p, q, d, e, r))
}

/// Whether `p` is strictly inside the polygon: the winding number, summed over signed crossings of the ray
/// toward −x, is odd. `None` for a point on the polygon.
#[must_use]
pub fn inside_polygon<N: Whole>(p: &WholePoint<N>, polygon: &[WholePoint<N>]) -> Option<bool> {
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

/// The square of the distance from `p` to the segment `a b`, as a fraction with a positive denominator.
#[must_use]
pub fn point_segment_distance_2<N: Whole>(p: &WholePoint<N>, a: &WholePoint<N>, b: &WholePoint<N>) -> (N, N) {
    let (d, w) = (b.minus(a), p.minus(a));
    let denominator = d.dot(&d);
    if denominator == zero() {
        return (w.dot(&w), N::from(1));
    }
    let t = w.dot(&d).clamp(zero(), denominator.clone());
    let off = w.combined(&denominator, &d, &t);
    (off.dot(&off), times(&denominator, &denominator))
}

/// Whether no point of the motion `p q` is nearer to the segment `a b` than `p` is. The distance to a
/// convex set is convex along a line, so this means that the distance never falls. It falls if the motion
/// meets `a b` away from `p`, or if `q` is nearer than `p` or an end of `a b` is that near to the motion.
/// Otherwise the least distance is at `p`.
#[must_use]
pub fn never_nearer<N: Whole>(
    p: &WholePoint<N>,
    q: &WholePoint<N>,
    a: &WholePoint<N>,
    b: &WholePoint<N>,
) -> bool {
    let start = point_segment_distance_2(p, a, b);
    if start.0 == zero() {
        return true;
    }
    if segment_segment_within(p, q, a, b, 0) {
        return false;
    }
    let others = [
        point_segment_distance_2(q, a, b),
        point_segment_distance_2(a, p, q),
        point_segment_distance_2(b, p, q),
    ];
    others.iter().all(|other| times(&other.0, &start.1) >= times(&start.0, &other.1))
}

/// Whether the closed box and the segment come within `r`. The box is two triangles.
#[must_use]
pub fn box_segment_within<N: Whole>(
    low: &WholePoint<N>,
    high: &WholePoint<N>,
    a: &WholePoint<N>,
    b: &WholePoint<N>,
    r: i64,
) -> bool {
    let right = WholePoint { x: high.x.clone(), y: low.y.clone() };
    let left = WholePoint { x: low.x.clone(), y: high.y.clone() };
    triangle_segment_within([low, &right, high], a, b, r)
        || triangle_segment_within([low, high, &left], a, b, r)
}

/// Fast answers in `f64`. `None` means uncertain: use the exact definition. Coordinates are below 2^30. The
/// error of a distance through the nearest point is then far below a thousandth of a unit, and the error of
/// a square is a few units of its last place.
pub mod quick {
    /// A point or vector.
    pub type Xy = (f64, f64);

    const SURE: f64 = 1e-2;

    fn decide(distance: f64, r: f64) -> Option<bool> {
        ((distance - r).abs() > SURE + r * 1e-9).then_some(distance < r)
    }

    /// The distance from a point to a segment.
    #[must_use]
    pub fn point_segment(p: Xy, a: Xy, b: Xy) -> f64 {
        let (d, w) = ((b.0 - a.0, b.1 - a.1), (p.0 - a.0, p.1 - a.1));
        let length_2 = d.0 * d.0 + d.1 * d.1;
        let t = if length_2 > 0.0 { ((w.0 * d.0 + w.1 * d.1) / length_2).clamp(0.0, 1.0) } else { 0.0 };
        (w.0 - t * d.0).hypot(w.1 - t * d.1)
    }

    /// Whether the point and the segment come within `r`.
    #[must_use]
    pub fn point_segment_within(p: Xy, a: Xy, b: Xy, r: f64) -> Option<bool> {
        decide(point_segment(p, a, b), r)
    }

    /// Twice the signed area of `a b c`; `None` when rounding could have changed its sign. Differences
    /// below 2^26 multiply exactly.
    fn turn(a: Xy, b: Xy, c: Xy) -> Option<f64> {
        let (u, v) = ((b.0 - a.0, b.1 - a.1), (c.0 - a.0, c.1 - a.1));
        let area = u.0 * v.1 - u.1 * v.0;
        let exact = [u.0, u.1, v.0, v.1].iter().all(|d| d.abs() < 67_108_864.0);
        (exact || area.abs() > 4096.0).then_some(area)
    }

    /// Whether the segments cross at a point interior to both.
    fn crosses(a: Xy, b: Xy, c: Xy, d: Xy) -> Option<bool> {
        Some(turn(a, b, c)? * turn(a, b, d)? < 0.0 && turn(c, d, a)? * turn(c, d, b)? < 0.0)
    }

    /// The distance between two segments.
    fn segment_segment(a: Xy, b: Xy, c: Xy, d: Xy) -> Option<f64> {
        let ends =
            [point_segment(a, c, d), point_segment(b, c, d), point_segment(c, a, b), point_segment(d, a, b)];
        Some(if crosses(a, b, c, d)? { 0.0 } else { ends.into_iter().fold(f64::INFINITY, f64::min) })
    }

    /// Whether the two segments come within `r`.
    #[must_use]
    pub fn segment_segment_within(a: Xy, b: Xy, c: Xy, d: Xy, r: f64) -> Option<bool> {
        decide(segment_segment(a, b, c, d)?, r)
    }

    /// Whether no point of the motion `p q` is nearer to the segment than `p`.
    #[must_use]
    pub fn never_nearer(p: Xy, q: Xy, a: Xy, b: Xy) -> Option<bool> {
        let start = point_segment(p, a, b);
        let others = [point_segment(q, a, b), point_segment(a, p, q), point_segment(b, p, q)];
        let least = if crosses(p, q, a, b)? { 0.0 } else { others.into_iter().fold(f64::INFINITY, f64::min) };
        ((least - start).abs() > SURE + start * 1e-9).then_some(least > start)
    }

    /// Whether the filled triangle and the segment come within `r`.
    #[must_use]
    pub fn triangle_segment_within([a, b, c]: [Xy; 3], d: Xy, e: Xy, r: f64) -> Option<bool> {
        let sides = [turn(a, b, d)?, turn(b, c, d)?, turn(c, a, d)?];
        if sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0) {
            return Some(true);
        }
        let mut any = false;
        for (p, q) in [(a, b), (b, c), (c, a)] {
            any |= segment_segment_within(p, q, d, e, r)?;
        }
        Some(any)
    }
}

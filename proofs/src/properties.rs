//! The properties. Each asserts; engines choose the inputs.

use keepout_kernel::exact::predicate::{
    Orientation, Site, box_point, box_segment, crosses_properly, orientation, point_point, point_segment,
    recedes, segment_segment, strictly_inside, triangle_segment,
};
use keepout_kernel::exact::width::Lattice;

use crate::oracle::{self, Big};

/// Coordinates of a point as plain numbers.
pub type Xy = (i64, i64);

/// Makes points at a width from plain numbers.
pub trait FromPlain: Lattice {
    /// The linear value of a plain number that fits.
    fn linear(value: i64) -> Self::Linear;

    /// The site of a plain point.
    fn site((x, y): Xy) -> Site<Self> {
        Site { x: Self::linear(x), y: Self::linear(y) }
    }
}

impl FromPlain for keepout_kernel::exact::width::Product {
    fn linear(value: i64) -> i32 {
        i32::try_from(value).expect("engines choose coordinates within 2^29")
    }
}

impl FromPlain for keepout_kernel::exact::width::Narrow {
    fn linear(value: i64) -> i8 {
        i8::try_from(value).expect("engines choose coordinates within 32")
    }
}

fn big((x, y): Xy) -> Big {
    Big::new(x, y)
}

/// Orientation is the sign of the area, changes sign with a swap and none with a rotation.
///
/// # Panics
/// When the property does not hold.
pub fn orientation_is_the_sign_of_the_area<L: FromPlain>(a: Xy, b: Xy, c: Xy) {
    let of = |p, q, r| orientation::<L>(L::site(p), L::site(q), L::site(r));
    let sign = match of(a, b, c) {
        Orientation::Left => 1,
        Orientation::On => 0,
        Orientation::Right => -1,
    };
    assert_eq!(sign, oracle::area_sign(&big(a), &big(b), &big(c)), "{a:?} {b:?} {c:?}");
    assert_eq!(of(a, b, c), of(b, c, a), "cyclic");
    let swapped = match of(b, a, c) {
        Orientation::Left => Orientation::Right,
        Orientation::On => Orientation::On,
        Orientation::Right => Orientation::Left,
    };
    assert_eq!(of(a, b, c), swapped, "antisymmetric");
}

/// Point–segment: near exactly when some point of the segment is within r.
///
/// # Panics
/// When the property does not hold.
pub fn point_segment_is_exact<L: FromPlain>(p: Xy, a: Xy, b: Xy, r: i64) {
    let near = !point_segment::<L>(L::site(p), L::site(a), L::site(b), L::linear(r)).is_clear();
    assert_eq!(near, oracle::point_segment_within(&big(p), &big(a), &big(b), r), "{p:?} {a:?} {b:?} {r}");
    if a == b {
        assert_eq!(near, !point_point::<L>(L::site(p), L::site(a), L::linear(r)).is_clear());
    }
}

/// Segment–segment: near exactly when some two points are within r; the same from both sides.
///
/// # Panics
/// When the property does not hold.
pub fn segment_segment_is_exact<L: FromPlain>(a: Xy, b: Xy, c: Xy, d: Xy, r: i64) {
    let of =
        |p, q, s, t| !segment_segment::<L>([p, q].map(L::site), [s, t].map(L::site), L::linear(r)).is_clear();
    let near = of(a, b, c, d);
    let truth = oracle::segment_segment_within(&big(a), &big(b), &big(c), &big(d), r);
    assert_eq!(near, truth, "{a:?} {b:?} {c:?} {d:?} {r}");
    assert_eq!(near, of(d, c, b, a), "symmetric");
    if crosses_properly::<L>(L::site(a), L::site(b), L::site(c), L::site(d)) {
        assert!(near, "crossing segments touch");
    }
}

/// Triangle–segment: near exactly when some point of the filled triangle is within r of the segment.
///
/// # Panics
/// When the property does not hold.
pub fn triangle_segment_is_exact<L: FromPlain>(corners: [Xy; 3], d: Xy, e: Xy, r: i64) {
    let near = !triangle_segment::<L>(corners.map(L::site), [d, e].map(L::site), L::linear(r)).is_clear();
    let [a, b, c] = corners.map(big);
    let truth = oracle::triangle_segment_within([&a, &b, &c], &big(d), &big(e), r);
    assert_eq!(near, truth, "{corners:?} {d:?} {e:?} {r}");
    if strictly_inside::<L>(L::site(d), L::site(corners[0]), L::site(corners[1]), L::site(corners[2])) {
        assert!(oracle::in_triangle(&big(d), &a, &b, &c), "{corners:?} {d:?}");
    }
}

/// A fan covers every motion from the old motion to the new target: what is near a chord of it is near the fan.
///
/// # Panics
/// When the property does not hold.
pub fn fan_covers_every_retargeted_motion<L: FromPlain>(
    corners: [Xy; 3],
    share: (i64, i64),
    d: Xy,
    e: Xy,
    r: i64,
) {
    let [(ax, ay), (bx, by), target] = corners;
    let (k, n) = share;
    // A lattice point of the side a b, when there is one at k / n.
    let (dx, dy) = ((bx - ax) * k, (by - ay) * k);
    if dx % n != 0 || dy % n != 0 {
        return;
    }
    let from = (ax + dx / n, ay + dy / n);
    let near = |sites: [Xy; 2]| {
        !segment_segment::<L>([sites[0], sites[1]].map(L::site), [d, e].map(L::site), L::linear(r)).is_clear()
    };
    if near([from, target]) {
        let fan = triangle_segment::<L>(corners.map(L::site), [d, e].map(L::site), L::linear(r));
        assert!(!fan.is_clear(), "{corners:?} {from:?} {d:?} {e:?} {r}");
    }
}

/// A motion recedes from a segment exactly when no point of it is nearer than its start.
///
/// # Panics
/// When the property does not hold.
pub fn receding_never_comes_nearer<L: FromPlain>(p: Xy, q: Xy, a: Xy, b: Xy) {
    let answer = recedes::<L>(L::site(p), L::site(q), L::site(a), L::site(b));
    assert_eq!(answer, oracle::never_nearer(&big(p), &big(q), &big(a), &big(b)), "{p:?} {q:?} {a:?} {b:?}");
    assert_eq!(answer, recedes::<L>(L::site(p), L::site(q), L::site(b), L::site(a)), "either way round");
}

/// Box–segment and box–point: near exactly when some point of the filled box is within r.
///
/// # Panics
/// When the property does not hold.
pub fn box_segment_is_exact<L: FromPlain>(p: Xy, q: Xy, a: Xy, b: Xy, r: i64) {
    let (low, high) = ((p.0.min(q.0), p.1.min(q.1)), (p.0.max(q.0), p.1.max(q.1)));
    let near =
        !box_segment::<L>(L::site(low), L::site(high), L::site(a), L::site(b), L::linear(r)).is_clear();
    let truth = oracle::box_segment_within(&big(low), &big(high), &big(a), &big(b), r);
    assert_eq!(near, truth, "{low:?} {high:?} {a:?} {b:?} {r}");
    let point = !box_point::<L>(L::site(low), L::site(high), L::site(a), L::linear(r)).is_clear();
    assert_eq!(point, oracle::box_segment_within(&big(low), &big(high), &big(a), &big(a), r), "{a:?} {r}");
}

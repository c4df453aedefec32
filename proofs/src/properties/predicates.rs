//! The predicates, generic over the width, against their definitions.

use keepout_kernel::exact::predicate::{
    Orientation, beyond, box_point, box_segment, convex_holds, convex_segment, crosses_properly, orientation,
    point_point, point_segment, ray_crosses, retract, segment_segment, strictly_inside, triangle_segment,
};

use super::{FromPlain, Xy, exact};
use crate::oracle::{self, Wide};
use crate::property::{passed_over, properties};

properties! {
    "predicates", "kernel/src/exact/predicate.rs";
    // Evidence for SR-01.
    orientation_is_the_sign_of_the_area |d|
        orientation_is_the_sign_of_the_area::<D::Width>(d.point(), d.point(), d.point())
        => "orientation is the sign of the area; a swap changes the sign, a rotation does not";
        every 5 random 300_000;
    point_point_is_exact |d| {
        let (p, q) = (d.point(), d.point());
        point_point_is_exact::<D::Width>(p, q, d.threshold(p, q))
    }
        => "point–point: near exactly when the distance is r or less";
        every 6 random 200_000;
    point_segment_is_exact |d| {
        let (p, a) = (d.point(), d.point());
        point_segment_is_exact::<D::Width>(p, a, d.point(), d.threshold(p, a))
    }
        => "point–segment: near exactly when some point of the segment is within r";
        every 4 random 200_000;
    segment_segment_is_exact |d| {
        let (a, c) = (d.point(), d.point());
        segment_segment_is_exact::<D::Width>(a, d.point(), c, d.point(), d.threshold(a, c))
    }
        => "segment–segment: near exactly when a point of one is within r of a point of the other; the \
            order of the segments does not matter";
        every 3 random 200_000;
    triangle_segment_is_exact |d| {
        let (a, e) = (d.point(), d.point());
        triangle_segment_is_exact::<D::Width>([a, d.point(), d.point()], e, d.point(), d.threshold(a, e))
    }
        => "triangle–segment: near exactly when some point of the filled triangle is within r of the \
            segment";
        every 2 random 200_000;
    convex_segment_is_exact |d| {
        let (a, e) = (d.point(), d.point());
        convex_segment_is_exact::<D::Width>(
            [a, d.point(), d.point(), d.point()],
            e,
            d.point(),
            d.threshold(a, e),
        )
    }
        => "polygon–segment: near exactly when some triangle of its corners is; the polygon holds a point \
            exactly when some triangle does";
        every 1 random 200_000;
    beyond_is_exact |d| {
        let (a, p) = (d.point(), d.point());
        beyond_is_exact::<D::Width>([a, d.point()], [p, d.point()], d.threshold(a, p))
    }
        => "beyond a line: every point is right of the line, and farther than r from it";
        every 2 random 200_000;
    strictly_inside_is_inside_and_on_no_side |d|
        strictly_inside_is_inside_and_on_no_side::<D::Width>(d.point(), [d.point(), d.point(), d.point()])
        => "strictly inside a triangle: inside by the definition, and on no side";
        every 3 random 100_000;
    crossing_properly_is_one_point_inside_both |d|
        crossing_properly_is_one_point_inside_both::<D::Width>(d.point(), d.point(), d.point(), d.point())
        => "segments cross properly exactly when they share a point and no end of one is on the other";
        every 3 random 200_000;
    swept_triangle_covers_every_retargeted_motion |d|
        swept_triangle_covers_every_retargeted_motion::<D::Width>(
            [d.point(), d.point(), d.point()],
            (d.int(0, 4), 4),
            d.point(),
            d.point(),
            d.radius(),
        )
        => "a segment near a motion from any point of the old motion to the new target is near the swept \
            triangle";
        every 1 random 100_000;
    // Evidence for SR-14.
    retracting_never_comes_nearer |d|
        retracting_never_comes_nearer::<D::Width>(d.point(), d.point(), d.point(), d.point())
        => "a motion retracts exactly when no point of it is nearer than its start";
        every 3 random 200_000;
    // Evidence for SR-01.
    box_segment_is_exact |d| {
        let (p, a) = (d.point(), d.point());
        box_segment_is_exact::<D::Width>(p, d.point(), a, d.point(), d.threshold(p, a))
    }
        => "box–segment and box–point: near exactly when some point of the filled box is within r";
        every 2 random 100_000;
    parity_of_a_triangle_is_its_inside |d|
        parity_of_a_triangle_is_its_inside::<D::Width>(d.point(), [d.point(), d.point(), d.point()])
        => "the ray crosses an odd number of a triangle's sides exactly when the point is inside";
        every 3 random 100_000;
    a_unit_more_covers_rounding_by_a_unit |d|
        a_unit_more_covers_rounding_by_a_unit::<D::Width>(
            [d.point(), d.point(), d.point()],
            d.int(0, 80),
            [d.point(), d.point()],
            d.radius(),
        )
        => "points, motions and swept triangles that are clear at r + 2 stay clear at r when each corner \
            moves by a unit in x and in y";
        random 200_000;
}

/// Orientation is the sign of the area. A swap changes the sign, a rotation does not.
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
    assert_eq!(sign, oracle::area_sign(&exact::<L>(a), &exact::<L>(b), &exact::<L>(c)), "{a:?} {b:?} {c:?}");
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
    assert_eq!(
        near,
        oracle::point_segment_within(&exact::<L>(p), &exact::<L>(a), &exact::<L>(b), r),
        "{p:?} {a:?} {b:?} {r}"
    );
    if a == b {
        assert_eq!(near, !point_point::<L>(L::site(p), L::site(a), L::linear(r)).is_clear());
    }
}

/// Segment–segment: near exactly when a point of one is within r of a point of the other. The order of the
/// segments does not matter.
///
/// # Panics
/// When the property does not hold.
pub fn segment_segment_is_exact<L: FromPlain>(a: Xy, b: Xy, c: Xy, d: Xy, r: i64) {
    let of =
        |p, q, s, t| !segment_segment::<L>([p, q].map(L::site), [s, t].map(L::site), L::linear(r)).is_clear();
    let near = of(a, b, c, d);
    let truth =
        oracle::segment_segment_within(&exact::<L>(a), &exact::<L>(b), &exact::<L>(c), &exact::<L>(d), r);
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
    let [a, b, c] = corners.map(exact::<L>);
    let truth = oracle::triangle_segment_within([&a, &b, &c], &exact::<L>(d), &exact::<L>(e), r);
    assert_eq!(near, truth, "{corners:?} {d:?} {e:?} {r}");
    if strictly_inside::<L>(L::site(d), L::site(corners[0]), L::site(corners[1]), L::site(corners[2])) {
        assert!(oracle::in_triangle(&exact::<L>(d), &a, &b, &c), "{corners:?} {d:?}");
    }
}

/// Polygon–segment: near exactly when some triangle of its corners is. The polygon holds a point exactly
/// when some triangle does.
///
/// # Panics
/// When the property does not hold.
pub fn convex_segment_is_exact<L: FromPlain>(points: [Xy; 4], d: Xy, e: Xy, r: i64) {
    let corners = hull(points.to_vec());
    let sites: Vec<_> = corners.iter().map(|&corner| L::site(corner)).collect();
    let near = !convex_segment::<L>(sites.iter().copied(), [d, e].map(L::site), L::linear(r)).is_clear();
    let of = points.map(exact::<L>);
    let (big_d, big_e) = (exact::<L>(d), exact::<L>(e));
    let triangles = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]].map(|at| at.map(|k| &of[k]));
    let truth = triangles.iter().any(|&corners| oracle::triangle_segment_within(corners, &big_d, &big_e, r));
    assert_eq!(near, truth, "{points:?} {d:?} {e:?} {r}");
    let holds = convex_holds::<L>(sites.into_iter(), L::site(d));
    let inside = triangles.iter().any(|&corners| oracle::triangle_segment_within(corners, &big_d, &big_d, 0));
    assert_eq!(holds, inside, "{points:?} {d:?}");
}

/// The corners of the hull, counter-clockwise, without those on straight sides.
pub(super) fn hull(mut points: Vec<Xy>) -> Vec<Xy> {
    points.sort_unstable();
    points.dedup();
    let left = |(ax, ay): Xy, (bx, by): Xy, (cx, cy): Xy| {
        let wide = i128::from;
        wide(bx - ax) * wide(cy - ay) > wide(by - ay) * wide(cx - ax)
    };
    let chain = |points: &mut dyn Iterator<Item = Xy>| {
        let mut chain: Vec<Xy> = Vec::new();
        for point in points {
            while chain.len() >= 2 && !left(chain[chain.len() - 2], chain[chain.len() - 1], point) {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    if points.len() < 2 {
        return points;
    }
    let mut corners = chain(&mut points.iter().copied());
    corners.extend(chain(&mut points.iter().rev().copied()));
    corners
}

/// Beyond a line: right of the line, and farther than r from it.
///
/// # Panics
/// When the property does not hold.
pub fn beyond_is_exact<L: FromPlain>([a, b]: [Xy; 2], points: [Xy; 2], r: i64) {
    let off = |(x, y): Xy| {
        let wide = i128::from;
        wide(b.0 - a.0) * wide(y - a.1) - wide(b.1 - a.1) * wide(x - a.0)
    };
    let length_2 = i128::from(b.0 - a.0).pow(2) + i128::from(b.1 - a.1).pow(2);
    // |off| > r · |b − a|: both sides squared.
    let far = |p: Xy| {
        let (off, reach) = (Wide::from(off(p)), Wide::from(length_2) * Wide::from(r) * Wide::from(r));
        off < Wide::from(0) && &off * &off > reach
    };
    let says = |points: &[Xy]| {
        beyond::<L>([a, b].map(L::site), points.iter().map(|&point| L::site(point)), L::linear(r))
    };
    assert_eq!(says(&points), points.into_iter().all(far), "{a:?} {b:?} {points:?} {r}");
    assert_eq!(says(&points[..1]), far(points[0]), "{a:?} {b:?} {points:?} {r}");
    assert!(!says(&[]));
}

/// A swept triangle covers every motion from the old motion to the new target: a segment near such a motion
/// is near the triangle.
///
/// # Panics
/// When the property does not hold.
pub fn swept_triangle_covers_every_retargeted_motion<L: FromPlain>(
    corners: [Xy; 3],
    share: (i64, i64),
    d: Xy,
    e: Xy,
    r: i64,
) {
    let [(ax, ay), (bx, by), target] = corners;
    let (k, n) = share;
    // The lattice point of the side a b at k / n, if there is one.
    let (dx, dy) = ((bx - ax) * k, (by - ay) * k);
    if dx % n != 0 || dy % n != 0 {
        return passed_over();
    }
    let from = (ax + dx / n, ay + dy / n);
    let near = |sites: [Xy; 2]| {
        !segment_segment::<L>(sites.map(L::site), [d, e].map(L::site), L::linear(r)).is_clear()
    };
    if near([from, target]) {
        let swept = triangle_segment::<L>(corners.map(L::site), [d, e].map(L::site), L::linear(r));
        assert!(!swept.is_clear(), "{corners:?} {from:?} {d:?} {e:?} {r}");
    }
}

/// A motion retracts from a segment exactly when no point of it is nearer than its start.
///
/// # Panics
/// When the property does not hold.
pub fn retracting_never_comes_nearer<L: FromPlain>(p: Xy, q: Xy, a: Xy, b: Xy) {
    let answer = retract::<L>(L::site(p), L::site(q), L::site(a), L::site(b));
    assert_eq!(
        answer,
        oracle::never_nearer(&exact::<L>(p), &exact::<L>(q), &exact::<L>(a), &exact::<L>(b)),
        "{p:?} {q:?} {a:?} {b:?}"
    );
    assert_eq!(answer, retract::<L>(L::site(p), L::site(q), L::site(b), L::site(a)), "either way round");
}

/// Box–segment and box–point: near exactly when some point of the filled box is within r.
///
/// # Panics
/// When the property does not hold.
pub fn box_segment_is_exact<L: FromPlain>(p: Xy, q: Xy, a: Xy, b: Xy, r: i64) {
    let (low, high) = ((p.0.min(q.0), p.1.min(q.1)), (p.0.max(q.0), p.1.max(q.1)));
    let near =
        !box_segment::<L>(L::site(low), L::site(high), L::site(a), L::site(b), L::linear(r)).is_clear();
    let truth =
        oracle::box_segment_within(&exact::<L>(low), &exact::<L>(high), &exact::<L>(a), &exact::<L>(b), r);
    assert_eq!(near, truth, "{low:?} {high:?} {a:?} {b:?} {r}");
    let point = !box_point::<L>(L::site(low), L::site(high), L::site(a), L::linear(r)).is_clear();
    assert_eq!(
        point,
        oracle::box_segment_within(&exact::<L>(low), &exact::<L>(high), &exact::<L>(a), &exact::<L>(a), r),
        "{a:?} {r}"
    );
}

/// Point–point: near exactly when the distance is r or less.
///
/// # Panics
/// When the property does not hold.
pub fn point_point_is_exact<L: FromPlain>(p: Xy, q: Xy, r: i64) {
    let near = !point_point::<L>(L::site(p), L::site(q), L::linear(r)).is_clear();
    let (dx, dy) = (i128::from(p.0 - q.0), i128::from(p.1 - q.1));
    assert_eq!(near, dx * dx + dy * dy <= i128::from(r) * i128::from(r), "{p:?} {q:?} {r}");
}

/// Strictly inside a triangle: inside by the definition, and on no side.
///
/// # Panics
/// When the property does not hold.
pub fn strictly_inside_is_inside_and_on_no_side<L: FromPlain>(p: Xy, corners: [Xy; 3]) {
    let [a, b, c] = corners.map(L::site);
    let answer = strictly_inside::<L>(L::site(p), a, b, c);
    let (at, [a, b, c]) = (exact::<L>(p), corners.map(exact::<L>));
    let on_side =
        [(&a, &b), (&b, &c), (&c, &a)].into_iter().any(|(q, r)| oracle::point_segment_within(&at, q, r, 0));
    assert_eq!(answer, oracle::in_triangle(&at, &a, &b, &c) && !on_side, "{p:?} {corners:?}");
}

/// Segments cross properly exactly when they share a point and no end of one is on the other.
///
/// # Panics
/// When the property does not hold.
pub fn crossing_properly_is_one_point_inside_both<L: FromPlain>(a: Xy, b: Xy, c: Xy, d: Xy) {
    let answer = crosses_properly::<L>(L::site(a), L::site(b), L::site(c), L::site(d));
    let [p, q, s, t] = [a, b, c, d].map(exact::<L>);
    let meet = oracle::segment_segment_within(&p, &q, &s, &t, 0);
    let on = |p, a, b| oracle::point_segment_within(p, a, b, 0);
    let by_an_end = on(&p, &s, &t) || on(&q, &s, &t) || on(&s, &p, &q) || on(&t, &p, &q);
    assert_eq!(answer, meet && !by_an_end, "{a:?} {b:?} {c:?} {d:?}");
}

/// The ray crosses an odd number of a triangle's sides exactly when the point is inside.
///
/// # Panics
/// When the property does not hold.
pub fn parity_of_a_triangle_is_its_inside<L: FromPlain>(p: Xy, corners: [Xy; 3]) {
    let (at, [a, b, c]) = (exact::<L>(p), corners.map(exact::<L>));
    let sides = [(&a, &b), (&b, &c), (&c, &a)];
    if sides.into_iter().any(|(q, r)| oracle::point_segment_within(&at, q, r, 0)) {
        return passed_over();
    }
    let crossed = |i: usize| ray_crosses::<L>(L::site(p), L::site(corners[i]), L::site(corners[(i + 1) % 3]));
    let odd = crossed(0) ^ crossed(1) ^ crossed(2);
    assert_eq!(odd, oracle::in_triangle(&at, &a, &b, &c), "{p:?} {corners:?}");
}

/// Points, motions and swept triangles that are clear at r + 2 stay clear at r when each corner moves by a
/// unit in x and in y, which is less than 1.5. The four base-3 digits of `steps` choose the moves.
///
/// # Panics
/// When the property does not hold.
pub fn a_unit_more_covers_rounding_by_a_unit<L: FromPlain>(
    corners: [Xy; 3],
    steps: i64,
    edge: [Xy; 2],
    r: i64,
) {
    let step = |k: i64| (steps / 3_i64.pow(u32::try_from(k).unwrap_or(0)) % 3) - 1;
    let limit = i64::from(keepout_kernel::exact::lattice::COORD_MAX);
    let moved =
        |(x, y): Xy, k: i64| ((x + step(k)).clamp(-limit, limit), (y + step(k + 1)).clamp(-limit, limit));
    let [a, b, c] = corners;
    let (d, e, more, less) =
        (L::site(edge[0]), L::site(edge[1]), L::linear((r + 2).min(limit)), L::linear(r));
    if r + 2 > limit {
        return passed_over();
    }
    let ([a2, b2, c2], site) = ([moved(a, 0), moved(b, 2), moved(c, 1)], L::site);
    if point_segment::<L>(site(a), d, e, more).is_clear() {
        assert!(point_segment::<L>(site(a2), d, e, less).is_clear(), "{corners:?} {steps} {edge:?} {r}");
    }
    if segment_segment::<L>([a, b].map(site), [d, e], more).is_clear() {
        assert!(
            segment_segment::<L>([a2, b2].map(site), [d, e], less).is_clear(),
            "{corners:?} {steps} {edge:?} {r}"
        );
    }
    if triangle_segment::<L>(corners.map(site), [d, e], more).is_clear() {
        let swept = triangle_segment::<L>([a2, b2, c2].map(site), [d, e], less);
        assert!(swept.is_clear(), "{corners:?} {steps} {edge:?} {r}");
    }
}

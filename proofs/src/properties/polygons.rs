//! Polygons with as many corners as the guard keeps.

use std::iter::repeat_n;

use keepout_kernel::Point;
use keepout_kernel::exact::convex::Convex;
use keepout_kernel::exact::predicate::{convex_holds, convex_segment};
use keepout_kernel::exact::width::Product;

use super::predicates::hull;
use super::{FromPlain, Xy, exact};
use crate::draw::Draw;
use crate::families::at;
use crate::oracle;
use crate::property::{passed_over, properties};

properties! {
    "predicates: polygons", "kernel/src/exact/predicate.rs, convex.rs";
    // Evidence for SR-01.
    polygons_of_many_corners_are_exact |d| {
        let radius = d.int(0, 50);
        let points: Vec<Xy> = (0..14).map(|_| on_a_circle(d, radius)).collect();
        polygons_of_many_corners_are_exact(points, (d.int(-90, 90), d.int(-90, 90)), d.int(-30, 30), d.int(0, 30))
    }
        => "polygon–segment and point in polygon, for up to fourteen corners: near exactly when some triangle of \
            its first corner and a side is";
        random 20_000;
    polygons_are_checked_at_every_side |d| {
        let points: Vec<Xy> = (0..14).map(|_| on_a_circle(d, 50)).collect();
        polygons_are_checked_at_every_side(points, d.one_of(14), (d.int(-50, 50), d.int(-50, 50)))
    }
        => "a polygon is accepted exactly when every corner is left of every side or on it";
        random 20_000;
}

/// Corners of a hull, of which one is exchanged for another point, against every corner and every side.
fn polygons_are_checked_at_every_side(points: Vec<Xy>, index: usize, other: Xy) {
    let mut corners = hull(points);
    let of = corners.len();
    if of < 3 {
        return passed_over();
    }
    corners[index % of] = other;
    let left = |[a, b]: [Xy; 2], c: Xy| (b.0 - a.0) * (c.1 - a.1) >= (b.1 - a.1) * (c.0 - a.0);
    let convex = (0..of).all(|k| corners.iter().all(|&c| left([corners[k], corners[(k + 1) % of]], c)));
    let lattice: Vec<Point> = corners.iter().copied().map(at).collect();
    assert_eq!(Convex::check(&lattice).is_some(), convex, "{corners:?}");
}

/// A point on a circle, to a unit.
fn on_a_circle<D: Draw>(d: &mut D, radius: i64) -> Xy {
    let x = d.int(-radius, radius);
    let y = (radius * radius - x * x).isqrt();
    (x, if d.coin() { y } else { -y })
}

/// At the width that ships. The truth is the fan of triangles from the first corner. Where the points leave fewer
/// than three corners, the last corner stands for those that lack.
fn polygons_of_many_corners_are_exact(points: Vec<Xy>, d: Xy, along: i64, r: i64) {
    let corners = hull(points);
    let Some((&first, &last)) = corners.first().zip(corners.last()) else { return passed_over() };
    let lacking = 3_usize.saturating_sub(corners.len());
    let rest: Vec<Xy> = corners[1..].iter().copied().chain(repeat_n(last, lacking)).collect();
    let e = (d.0 + along, d.1 - along / 2);
    let of = exact::<Product>;
    let [big_d, big_e] = [of(d), of(e)];
    let fan = || rest.windows(2).map(|pair| [of(first), of(pair[0]), of(pair[1])]);
    let within = |corners: [_; 3], far: &_, r: i64| {
        oracle::triangle_segment_within(corners.each_ref(), &big_d, far, r)
    };
    let sites = || corners.iter().map(|&corner| Product::site(corner)).collect::<Vec<_>>().into_iter();
    let near = !convex_segment::<Product>(sites(), [d, e].map(Product::site), Product::linear(r)).is_clear();
    assert_eq!(near, fan().any(|triangle| within(triangle, &big_e, r)), "{corners:?} {d:?} {e:?} {r}");
    let holds = convex_holds::<Product>(sites(), Product::site(d));
    assert_eq!(holds, fan().any(|triangle| within(triangle, &big_d, 0)), "{corners:?} {d:?}");
}

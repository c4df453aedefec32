//! Levels: what stands above the tip, and that a certificate holds at its height and above.

use keepout_kernel::{
    Arc, Blocked, Convex, FreePoint, Height, HeightField, Length, Levels, LevelsError, Point,
    ProhibitedRegion, Region, Ring, Turn,
};

use super::Xy;
use crate::draw::Draw;
use crate::families::{at, length};
use crate::oracle::{self, Big};
use crate::property::{passed_over, properties};

properties! {
    "levels", "kernel/src/levels.rs, clear.rs, exact/region.rs";
    // Evidence for SR-06.
    levels_hold_what_stands_above_the_tip |d|
        if let Some(field) = field(d) {
            levels_hold_what_stands_above_the_tip(&field, d.point(), tip(d))
        } else {
            passed_over()
        }
        => "a point is in the prohibited region of a height exactly when the innermost face around it, a \
            keep-out zone around it, or the table has a top above that height";
        random 40_000;
    levels_are_monotone |d|
        if let Some(field) = field(d) {
            let heights = [tip(d), tip(d)];
            levels_are_monotone(&field, heights, [d.point(), d.point(), d.point()], d.radius() / 8)
        } else {
            passed_over()
        }
        => "a point, motion, swept triangle, polygon, arc or retract move that is clear at a height is clear \
            at every greater height";
        random 40_000;
    certificates_do_not_hold_below_their_level |d|
        if let Some(field) = field(d) {
            let heights = [tip(d), tip(d)];
            certificates_do_not_hold_below_their_level(&field, heights, d.point(), d.radius() / 8)
        } else {
            passed_over()
        }
        => "no query of a level accepts a start that is certified at a higher level only";
        random 40_000;
    levels_fall_from_top_to_top |d|
        if let Some(field) = field(d) {
            levels_fall_from_top_to_top(&field)
        } else {
            passed_over()
        }
        => "the tops fall, each occurs once, none is below the table, and the region changes only at a top";
        random 20_000;
    levels_of_copies_share_their_outlines |d|
        if let Some(field) = field(d) {
            levels_of_copies_share_their_outlines(&field)
        } else {
            passed_over()
        }
        => "every outline of a level is the same memory as that outline of the height field";
        random 5_000;
}

/// Up to five outlines, many of them nested, with tops of a few heights, and sometimes a clamp and a table.
fn field<D: Draw>(d: &mut D) -> Option<HeightField> {
    let mut rings: Vec<Ring> = Vec::new();
    let mut corners = [d.point(), d.point()];
    for _ in 0..5 {
        let [(x0, y0), (x1, y1)] = corners;
        let ring = match d.one_of(3) {
            0 => Ring::new([(x0, y0), (x1, y0), (x1, y1)].map(at).to_vec()),
            _ => Ring::new([(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(at).to_vec()),
        };
        let kept = rings.len();
        rings.extend(ring);
        if rings.is_empty() || Region::new(rings.clone()).is_err() {
            rings.truncate(kept);
        }
        let inward = |a: i64, b: i64| a + (b - a) / 8;
        corners = match d.one_of(4) {
            0 => [d.point(), d.point()],
            _ => [(inward(x0, x1), inward(y0, y1)), (inward(x1, x0), inward(y1, y0))],
        };
    }
    let outlines = Region::new(rings).ok()?;
    let tops = outlines.rings().iter().map(|_| top(d)).collect();
    let zones = if d.one_of(3) == 0 { Ring::new((0..3).map(|_| at(d.point())).collect()).ok() } else { None };
    let zones = zones.into_iter().map(|ring| (ring, height(d.int(-3, 6)))).collect();
    let around = if d.one_of(4) == 0 { top(d) } else { None };
    let floor = (d.one_of(3) == 0).then(|| height(d.int(-6, -2)));
    Some(HeightField { outlines, tops, around, zones, floor })
}

fn top<D: Draw>(d: &mut D) -> Option<Height> {
    (d.one_of(4) > 0).then(|| height(d.int(-4, 2)))
}

fn height(units: i64) -> Height {
    Height::from_units(units).expect("it is small")
}

/// A height at or near a top.
fn tip<D: Draw>(d: &mut D) -> Height {
    height(d.int(-8, 7))
}

fn levels(field: &HeightField) -> Levels {
    Levels::new(field).expect("few edges and small heights")
}

fn inside(ring: &Ring, p: Xy) -> Option<bool> {
    let big = |point: &Point| Big::new(point.x.units().into(), point.y.units().into());
    oracle::inside_polygon(&Big::new(p.0, p.1), &ring.vertices().iter().map(big).collect::<Vec<_>>())
}

/// Whether something stands above the tip at this point, by the definition; `None` on an outline.
fn stands(field: &HeightField, p: Xy, tip: Height) -> Option<bool> {
    let rings = field.outlines.rings();
    // The innermost of the outlines around the point has the most outlines around its own vertices.
    let mut innermost: Option<(usize, Option<Height>)> = None;
    for (ring, top) in rings.iter().zip(&field.tops) {
        if inside(ring, p)? {
            let vertex = ring.vertices()[0];
            let nested = rings.iter().filter(|other| *other != ring);
            let own = (vertex.x.units().into(), vertex.y.units().into());
            let depth = nested.map(|other| usize::from(inside(other, own) == Some(true))).sum();
            if innermost.is_none_or(|(known, _)| known < depth) {
                innermost = Some((depth, *top));
            }
        }
    }
    let face = innermost.map_or(field.around, |(_, top)| top);
    let mut above = face.is_some_and(|top| top > tip) || field.floor.is_some_and(|floor| floor > tip);
    for (ring, top) in &field.zones {
        above |= inside(ring, p)? && *top > tip;
    }
    Some(above)
}

fn levels_hold_what_stands_above_the_tip(field: &HeightField, p: Xy, tip: Height) {
    let Some(truth) = stands(field, p, tip) else { return passed_over() };
    assert_eq!(levels(field).at(tip).holds(at(p)), truth, "{field:?} {p:?} {tip:?}");
}

/// Everything that a region can certify from a free point: motion, swept triangle, polygon, arc, retract move.
fn certified(part: &ProhibitedRegion, from: FreePoint, [b, c]: [Point; 2]) -> [bool; 5] {
    let a = from.point();
    let triangle = part.motion(from, b).and_then(|second| part.swept_triangle(from, second, c));
    let corners = [a, b, c];
    let polygon = Convex::check(&corners).is_some_and(|polygon| part.polygon(from, polygon, c).is_ok());
    let arc = quarter(a, b).is_some_and(|arc| part.arc(from, &arc).is_ok());
    let retract = part.retract(from, b, from.threshold()).is_ok();
    [part.motion(from, b).is_ok(), triangle.is_ok(), polygon, arc, retract]
}

/// A quarter turn from `a` around `centre`.
fn quarter(a: Point, centre: Point) -> Option<Arc> {
    let r = a.minus(centre);
    let to = Point::from_units(
        i64::from(centre.x.units()) - i64::from(r.dy),
        i64::from(centre.y.units()) + i64::from(r.dx),
    );
    Arc::new(a, to.ok()?, centre, Turn::CounterClockwise).ok()
}

fn levels_are_monotone(field: &HeightField, [one, other]: [Height; 2], [a, b, c]: [Xy; 3], r: i64) {
    let levels = levels(field);
    let (low, high) = (one.min(other), one.max(other));
    let [deep, above] = [low, high].map(|tip| levels.at(tip));
    let Ok(from) = deep.free_point(at(a), length(r)) else { return passed_over() };
    let case = || format!("{field:?} {low:?} {high:?} {a:?} {b:?} {c:?} {r}");
    assert!(above.free_point(at(a), length(r)).is_ok(), "{}", case());
    let there = [at(b), at(c)];
    let (below, here) = (certified(deep, from, there), certified(above, from, there));
    assert!(below.iter().zip(here).all(|(&below, here)| !below || here), "{below:?} {here:?} {}", case());
}

fn certificates_do_not_hold_below_their_level(field: &HeightField, heights: [Height; 2], a: Xy, r: i64) {
    let exact = levels(field);
    let number = |tip: Height| exact.at(tip).level();
    let [one, other] = heights;
    let tips = if number(one) < number(other) { [one, other] } else { [other, one] };
    let numbers = tips.map(number);
    if numbers[0] == numbers[1] || exact.at(tips[0]).free_point(at(a), length(r)).is_err() {
        return passed_over();
    }
    let simplified = exact.simplified(Length::ZERO).expect("the same edges");
    for levels in [&exact, &simplified] {
        let [high, low] = tips.map(|tip| levels.at(tip));
        assert_eq!([high, low].map(|part| part.level()), numbers, "{field:?} {heights:?}");
        let from = high.free_point(at(a), length(r)).expect("simplified by nothing it is as free");
        assert_eq!(from.level(), high.level());
        let beside = Point::from_units(a.0 + 1, a.1).unwrap_or(at(a));
        assert_eq!(certified(low, from, [beside, at(a)]), [false; 5], "{field:?} {heights:?} {a:?} {r}");
        assert_eq!(low.motion(from, at(a)), Err(Blocked::StartTooNear(at(a))));
    }
}

fn levels_fall_from_top_to_top(field: &HeightField) {
    let levels = levels(field);
    let tops: Vec<Height> = levels.tops().collect();
    assert!(tops.windows(2).all(|pair| pair[0] > pair[1]), "{tops:?}");
    assert!(field.floor.is_none_or(|floor| tops.last() == Some(&floor)), "{tops:?}");
    let bounds = |tip: Height| levels.at(tip).level();
    for (number, top) in (1..).zip(&tops) {
        assert_eq!(bounds(top.lowered(length(1))), number, "just below a top");
        assert_eq!(bounds(*top), number - 1, "at a top");
    }
    assert_eq!(levels.regions().count(), tops.len() + 1);
    let short = HeightField { tops: Vec::new(), ..field.clone() };
    assert_eq!(Levels::new(&short).err(), Some(LevelsError::Tops { count: 0 }));
}

fn levels_of_copies_share_their_outlines(field: &HeightField) {
    let levels = levels(field);
    let of_field: Vec<*const Point> =
        field.outlines.rings().iter().map(|ring| ring.vertices().as_ptr()).collect();
    for part in levels.regions() {
        let shared = |ring: &Ring| of_field.contains(&ring.vertices().as_ptr());
        assert!(part.region().rings().iter().all(shared), "{field:?}");
    }
}

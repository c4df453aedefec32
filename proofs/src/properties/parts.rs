//! The prohibited region: free points, motions, swept triangles, retract moves, clipping, probes, and the
//! simplified outline.

use keepout_kernel::clip::longest_prefix;
use keepout_kernel::exact::ring::Piece;
use keepout_kernel::exact::segment::distance_2;
use keepout_kernel::{
    Edge, FreePoint, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, Triangle, Vector,
};

use super::Xy;
use crate::draw::Draw;
use crate::families::{at, length};
use crate::oracle::{self, Big, Wide};
use crate::property::{passed_over, properties};

properties! {
    "parts", "kernel/src/clear.rs, clip.rs, simplify.rs";
    // Evidence for SR-04.
    free_points_are_clear_and_on_the_free_side |d|
        if let Some(part) = part(d) {
            free_points_are_clear_and_on_the_free_side(&part, d.point(), d.radius())
        } else {
            passed_over()
        }
        => "a point is free exactly when it is farther than the threshold from every edge, on the free \
            side and in no keep-out zone";
        random 40_000;
    clear_motions_and_swept_triangles_stay_free |d|
        if let Some(part) = part(d) {
            clear_motions_and_swept_triangles_stay_free(
                &part,
                [d.point(), d.point(), d.point()],
                d.radius() / 4,
                [d.int(0, 16), d.int(0, 16)],
            )
        } else {
            passed_over()
        }
        => "every point of an accepted motion or swept triangle from free points is free, at the same \
            threshold";
        random 40_000;
    // Evidence for SR-14.
    retract_moves_come_nearer_to_nothing |d|
        if let Some(part) = part(d) {
            retract_moves_come_nearer_to_nothing(&part, [d.point(), d.point()], d.radius(), d.int(0, 16))
        } else {
            passed_over()
        }
        => "a retract move stays on the free side, and no edge within the threshold of one of its points \
            is nearer there than at its start";
        random 40_000;
    // Evidence for SR-07.
    clipped_motions_are_clear_prefixes |d|
        if let Some(part) = part(d) {
            let cells = d.coin();
            clipped_motions_are_clear_prefixes(part, [d.point(), d.point()], d.radius() / 4, cells)
        } else {
            passed_over()
        }
        => "a clipped motion is clear, ends within a unit of the requested motion, and is the requested \
            motion where that is clear";
        random 20_000;
    prefixes_were_accepted |d| prefixes_were_accepted(d.point(), d.point(), d.int(0, 1 << 20))
        => "the end of the longest prefix is the start or an accepted point; it is the target if the \
            target is accepted";
        random 20_000;
    slides_keep_away_from_the_wall |d|
        if let Some(part) = part(d) {
            slides_keep_away_from_the_wall(&part, d.point(), d.radius(), d.point(), d.int(0, 12))
        } else {
            passed_over()
        }
        => "the part of a jog input along a wall does not lead into the wall, and is no longer than the \
            input";
        random 20_000;
    // Evidence for SR-03.
    prepared_parts_answer_as_their_index |d|
        if let Some(part) = part(d) {
            let way: Vec<Xy> = (0..6).map(|_| d.point()).collect();
            prepared_parts_answer_as_their_index(part, &way, d.radius() / 4, 1 << d.one_of(10))
        } else {
            passed_over()
        }
        => "a part prepared for a threshold answers as its index does, for points and for motions";
        random 10_000;
    clearance_is_below_the_distance |d|
        if let Some(part) = part(d) {
            clearance_is_below_the_distance(&part, d.point())
        } else {
            passed_over()
        }
        => "clearance is a lower bound on the distance to every edge, within three units";
        random 20_000;
    // Evidence for SR-05.
    what_is_clear_of_the_simplified_outline_is_clear_of_the_part |d|
        if let Some(part) = wavy(d) {
            let tolerance = d.int(0, 30);
            what_is_clear_of_the_simplified_outline_is_clear_of_the_part(
                &part,
                tolerance,
                [beside(d, &part), beside(d, &part), beside(d, &part)],
                d.int(0, 60),
            )
        }
        => "points, motions and swept triangles that are free of the simplified outline are free of the \
            part at the same threshold; clear points have the same side in both";
        random 30_000;
    simplified_chords_cover_their_runs |d|
        if let Some(part) = wavy(d) {
            simplified_chords_cover_their_runs(&part, d.int(0, 30))
        }
        => "every edge of the part, with its chord-error bound, lies within the bound of one chord of the \
            simplified outline; the chord runs from vertex to vertex";
        random 30_000;
}

/// A triangle or quadrangle with either side prohibited, sometimes with a keep-out zone.
fn part<D: Draw>(d: &mut D) -> Option<ProhibitedRegion> {
    let count = 3 + d.one_of(2);
    let ring = Ring::new((0..count).map(|_| at(d.point())).collect()).ok()?;
    let side = if d.coin() { Side::Outside } else { Side::Inside };
    let zones = if d.one_of(4) == 0 { Ring::new((0..3).map(|_| at(d.point())).collect()).ok() } else { None };
    ProhibitedRegion::with_zones(Region::new(vec![ring]).ok()?, side, zones.into_iter().collect()).ok()
}

/// The greatest chord error of an edge of [`wavy`].
const EDGE_ERROR: i64 = 6;

/// A ring with long runs that are nearly straight and can be simplified, sometimes with a keep-out zone. Half of them
/// have edges with chord errors of up to [`EDGE_ERROR`].
fn wavy<D: Draw>(d: &mut D) -> Option<ProhibitedRegion> {
    let (sides, each) = (3 + d.one_of(3), 3 + d.one_of(7));
    let wave = d.int(0, 25);
    let corners: Vec<Xy> = (0..sides).map(|_| (d.int(-2000, 2000), d.int(-2000, 2000))).collect();
    let mut vertices = Vec::new();
    for k in 0..sides {
        let (a, b) = (corners[k], corners[(k + 1) % sides]);
        for step in 0..i64::try_from(each).ok()? {
            let along = |from: i64, to: i64| from + (to - from) * step / i64::try_from(each).unwrap_or(1);
            vertices.push(at((along(a.0, b.0) + d.int(-wave, wave), along(a.1, b.1) + d.int(-wave, wave))));
        }
    }
    let side = if d.coin() { Side::Outside } else { Side::Inside };
    let corners = |d: &mut D| (0..3).map(|_| at((d.int(-2000, 2000), d.int(-2000, 2000)))).collect();
    let zones = if d.one_of(4) == 0 { Ring::new(corners(d)).ok() } else { None };
    let errors = if d.coin() { EDGE_ERROR } else { 0 };
    let round = vertices.iter().zip(vertices.iter().cycle().skip(1));
    let line =
        |(&from, &to)| Piece::Line { segment: Segment { from, to }, chord_error: length(d.int(0, errors)) };
    let ring = Ring::from_pieces(&round.map(line).collect::<Vec<_>>()).ok()?;
    let region = Region::new(vec![ring]).ok()?;
    ProhibitedRegion::with_zones(region, side, zones.into_iter().collect()).ok()
}

/// A point beside some vertex of the part.
fn beside<D: Draw>(d: &mut D, part: &ProhibitedRegion) -> Xy {
    let from = part.edges()[d.one_of(part.edges().len())].chord.from;
    let reach = 1 << d.one_of(9);
    (i64::from(from.x.units()) + d.int(-reach, reach), i64::from(from.y.units()) + d.int(-reach, reach))
}

fn clear_of_all(part: &ProhibitedRegion, p: Xy, r: i64) -> bool {
    let big = |point: Point| Big::new(point.x.units().into(), point.y.units().into());
    part.edges().iter().all(|edge| {
        let reach = r + i64::from(edge.chord_error.units());
        !oracle::point_segment_within(&Big::new(p.0, p.1), &big(edge.chord.from), &big(edge.chord.to), reach)
    })
}

/// Whether the point is on the part's side of the profile or in a keep-out zone, by the definition; `None`
/// on an outline.
fn held(part: &ProhibitedRegion, p: Xy) -> Option<bool> {
    let big = |point: &Point| Big::new(point.x.units().into(), point.y.units().into());
    let within = |ring: &Ring| {
        oracle::inside_polygon(&Big::new(p.0, p.1), &ring.vertices().iter().map(big).collect::<Vec<_>>())
    };
    let mut odd = false;
    for ring in part.region().rings() {
        odd ^= within(ring)?;
    }
    let mut zoned = false;
    for zone in part.zones() {
        zoned |= within(zone)?;
    }
    Some(zoned || odd == (part.side() == Side::Outside))
}

fn free_points_are_clear_and_on_the_free_side(part: &ProhibitedRegion, p: Xy, r: i64) {
    let free = part.free_point(at(p), length(r));
    let truth = clear_of_all(part, p, r) && held(part, p) == Some(false);
    assert_eq!(free.is_ok(), truth, "{part:?} {p:?} {r} {free:?}");
    if let Ok(free) = free {
        assert!(free.point() == at(p) && free.threshold() == length(r) && !part.holds(at(p)));
    }
}

/// A place in the triangle, rounded down to the lattice, and whether it is exact.
fn place([a, b, c]: [Xy; 3], [s, t]: [i64; 2]) -> (Xy, bool) {
    let of = |a: i64, b: i64, c: i64| 256 * a + 16 * s * (b - a) + s * t * (c - b);
    let (x, y) = (of(a.0, b.0, c.0), of(a.1, b.1, c.1));
    ((x.div_euclid(256), y.div_euclid(256)), x % 256 == 0 && y % 256 == 0)
}

fn clear_motions_and_swept_triangles_stay_free(
    part: &ProhibitedRegion,
    corners: [Xy; 3],
    r: i64,
    shares: [i64; 2],
) {
    let [a, b, c] = corners;
    let t = length(r);
    let Ok(first) = part.free_point(at(a), t) else { return passed_over() };
    let free = |p: Xy, r: i64| clear_of_all(part, p, r.max(0)) && held(part, p) == Some(false);
    let Ok(second) = part.motion(first, at(b)) else { return passed_over() };
    let case = || format!("{part:?} {corners:?} {r} {shares:?}");
    assert!(second.point() == at(b) && second.threshold() == t && free(b, r), "{}", case());
    // Rounding moves the place by less than 1.5 units.
    let (on_way, exact) = place([a, b, b], [shares[0], 0]);
    assert!(r < 2 && !exact || free(on_way, if exact { r } else { r - 2 }), "{}", case());
    let Ok(third) = part.swept_triangle(first, second, at(c)) else { return };
    assert!(third.point() == at(c) && third.threshold() == t && free(c, r), "{}", case());
    let (inside, exact) = place(corners, shares);
    assert!(r < 2 && !exact || free(inside, if exact { r } else { r - 2 }), "{}", case());
    let lower = first.lowered(length(r / 2)).expect("lower");
    assert!(r < 2 || part.swept_triangle(lower, second, at(c)).is_err(), "thresholds differ");
}

fn squares(edge: &Edge, p: Point) -> (Wide, Wide) {
    let big = |point: Point| Big::new(point.x.units().into(), point.y.units().into());
    oracle::point_segment_distance_2(&big(p), &big(edge.chord.from), &big(edge.chord.to))
}

fn retract_moves_come_nearer_to_nothing(part: &ProhibitedRegion, [p, q]: [Xy; 2], r: i64, share: i64) {
    let Some(clearance) = part.clearance(at(p)) else { return passed_over() };
    let Ok(from) = part.free_point(at(p), clearance.min(length(r))) else { return passed_over() };
    let Ok(end) = part.retract(from, at(q), length(r)) else { return passed_over() };
    assert!(end.point() == at(q) && end.threshold() == from.threshold());
    let (on_way, exact) = place([p, q, q], [share, 0]);
    for place in [Some(q), exact.then_some(on_way)].into_iter().flatten() {
        assert_eq!(held(part, place), Some(false), "{part:?} {p:?} {q:?} {r}");
        for edge in part.edges() {
            let ((d0, n0), (d1, n1)) = (squares(edge, at(p)), squares(edge, at(place)));
            let reach = Wide::from(r + i64::from(edge.chord_error.units()));
            let within = d1 <= &reach * &reach * &n1;
            assert!(
                !within || d1 * &n0 >= d0 * &n1,
                "{part:?} {p:?} {q:?} {r}: nearer to {edge:?} at {place:?}"
            );
        }
    }
}

fn clipped_motions_are_clear_prefixes(mut part: ProhibitedRegion, [p, q]: [Xy; 2], r: i64, cells: bool) {
    let t = length(r);
    if cells {
        let _ = part.prepare(t);
    }
    let Ok(from) = part.free_point(at(p), t) else { return passed_over() };
    let end = part.clip(from, at(q));
    let motion = Segment { from: at(p), to: end.point() };
    assert!(part.index().near_motion(motion, t).is_none() || end == from, "{part:?} {p:?} {q:?} {r}");
    assert!(part.free_point(end.point(), t).is_ok(), "{part:?} {p:?} {q:?} {r}");
    let input = Segment { from: at(p), to: at(q) };
    assert!(
        !input.near_point(end.point(), Length::small(1)).is_clear(),
        "beside the requested motion: {p:?} {q:?} {end:?}"
    );
    if part.motion(from, at(q)).is_ok() {
        assert_eq!(end.point(), at(q), "the requested motion is clear");
    }
}

fn prefixes_were_accepted(p: Xy, q: Xy, limit: i64) {
    let (from, to) = (at(p), at(q));
    let mut accepted: Vec<Point> = vec![from];
    let end = longest_prefix(from, to, |point| {
        let yes = distance_2(from, point) <= limit * limit;
        if yes {
            accepted.push(point);
        }
        yes
    });
    assert!(accepted.contains(&end), "{p:?} {q:?} {limit}");
    assert_eq!(end == to, distance_2(from, to) <= limit * limit || from == to, "{p:?} {q:?} {limit}");
}

fn slides_keep_away_from_the_wall(part: &ProhibitedRegion, p: Xy, r: i64, input: Xy, turn: i64) {
    let Ok(from) = part.free_point(at(p), length(r / 4)) else { return passed_over() };
    let Some(wall) = part.wall(from, length(r)) else { return passed_over() };
    let clamp = |c: i64| i32::try_from(c).unwrap_or(0);
    let input = Vector { dx: clamp(input.0), dy: clamp(input.1) };
    let Some(slid) = wall.slide(input, u32::try_from(turn).unwrap_or(1).max(1)) else { return passed_over() };
    let square = |v: Vector| i128::from(v.dx).pow(2) + i128::from(v.dy).pow(2);
    assert!(square(slid) <= square(input), "{input:?} {slid:?}");
    let backward = Vector { dx: -slid.dx, dy: -slid.dy };
    let long = slid.dx.abs().max(slid.dy.abs()) > 1 << 14;
    assert!(!long || wall.is_left_by(slid) || !wall.is_left_by(backward), "{input:?} {slid:?}");
}

fn prepared_parts_answer_as_their_index(mut part: ProhibitedRegion, way: &[Xy], r: i64, closer: i64) {
    let t = length(r);
    let _ = part.prepare(t);
    let mut before = way[0];
    for &p in way {
        let p = (before.0 + (p.0 - before.0) / closer, before.1 + (p.1 - before.1) / closer);
        let motion = Segment { from: at(before), to: at(p) };
        let (point_near, motion_near) =
            (part.index().near_point(at(p), t), part.index().near_motion(motion, t));
        let context = || format!("{part:?} {way:?} {r} {closer}");
        assert_eq!(part.motion_clear(motion, t).is_clear(), motion_near.is_none(), "{}", context());
        assert_eq!(part.point_clear(at(p), t).is_clear(), point_near.is_none(), "{}", context());
        if let Ok(free) = part.free_point(at(before), t) {
            assert_eq!(part.motion(free, at(p)).is_ok(), motion_near.is_none(), "{}", context());
        }
        before = p;
    }
}

fn clearance_is_below_the_distance(part: &ProhibitedRegion, p: Xy) {
    let Some(clearance) = part.clearance(at(p)) else {
        assert!(!clear_of_all(part, p, 0), "{part:?} {p:?}");
        return;
    };
    let c = i64::from(clearance.units());
    let limit = i64::from(keepout_kernel::exact::lattice::COORD_MAX);
    assert!(clear_of_all(part, p, c), "{part:?} {p:?} {c}");
    assert!(c >= limit - 3 || !clear_of_all(part, p, c + 3), "{part:?} {p:?} {c}");
}

fn what_is_clear_of_the_simplified_outline_is_clear_of_the_part(
    part: &ProhibitedRegion,
    tolerance: i64,
    corners: [Xy; 3],
    r: i64,
) {
    let simplified = part.simplified(length(tolerance)).expect("fewer edges");
    assert!(simplified.edges().len() <= part.edges().len());
    let (t, [a, b, c]) = (length(r), corners.map(at));
    let case = || format!("{part:?} by {tolerance}: {corners:?} at {r}");
    for (point, p) in [(a, corners[0]), (b, corners[1]), (c, corners[2])] {
        if simplified.free_point(point, t).is_ok() {
            assert!(clear_of_all(part, p, r) && held(part, p) == Some(false), "{}", case());
        }
        if simplified.point_clear(point, t).is_clear() {
            assert!(part.point_clear(point, t).is_clear(), "{}", case());
            assert_eq!(simplified.holds(point), part.holds(point), "sides: {}", case());
        }
    }
    let (motion, swept) = (Segment { from: a, to: b }, Triangle { corners: [a, b, c] });
    if simplified.motion_clear(motion, t).is_clear() {
        assert!(part.motion_clear(motion, t).is_clear(), "{}", case());
    }
    if simplified.index().near_triangle(swept, t).is_none() {
        assert!(part.index().near_triangle(swept, t).is_none(), "{}", case());
    }
    // The simplified outline adds "near" answers only within twice the tolerance, and the chord errors of neighbours.
    let wide = length(r + 2 * tolerance + EDGE_ERROR);
    if part.point_clear(a, wide).is_clear() {
        assert!(simplified.point_clear(a, t).is_clear(), "{}", case());
    }
    // At tolerance zero, edges with one chord error become one only where they are one straight line.
    if part.edges().iter().all(|edge| edge.chord_error == Length::ZERO) {
        let exact: Result<FreePoint, _> =
            part.simplified(length(0)).expect("the same edges").free_point(a, t);
        assert_eq!(exact.is_ok(), part.free_point(a, t).is_ok(), "tolerance zero: {}", case());
    }
}

fn simplified_chords_cover_their_runs(part: &ProhibitedRegion, tolerance: i64) {
    let simplified = part.simplified(length(tolerance)).expect("fewer edges");
    let mut covered = 0;
    for edge in simplified.edges() {
        loop {
            let fine = &part.edges()[covered];
            let reach = length(i64::from(edge.chord_error.units()) - i64::from(fine.chord_error.units()));
            assert!(!edge.chord.near_point(fine.chord.from, reach).is_clear(), "{part:?} {edge:?} {fine:?}");
            assert!(!edge.chord.near_point(fine.chord.to, reach).is_clear(), "{part:?} {edge:?} {fine:?}");
            covered += 1;
            if fine.chord.to == edge.chord.to {
                break;
            }
        }
    }
    assert_eq!(covered, part.edges().len(), "{part:?} {tolerance}");
    let rings = part.region().rings().len() + part.zones().len();
    let ends = simplified.edges().iter().zip(simplified.edges().iter().cycle().skip(1));
    assert!(rings != 1 || ends.into_iter().all(|(one, next)| one.chord.to == next.chord.from));
}

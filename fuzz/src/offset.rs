//! Offsets and their certificates, compared with points computed in `f64`.

use crate::oracle::xy;
use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_kernel::offset::{OffsetLoop, Outline, RESOLUTION, certify_complete, certify_path, propose};
use keepout_kernel::{Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, Turn, Vec2};

use crate::oracle::{PATH_CLEARANCE, distance, places, winds};

/// Tool distances begin here, at 0.2 mm. Certification must accept the offset of a plain outline at such a
/// distance.
const PLAIN_MIN: u32 = 20_000;
/// Largest number of loops to try on the other side.
const OTHER_MAX: usize = 2;
/// A unit or two of rounding in `f64`.
const ROUNDING: f64 = 3.0;

/// Reads an outline of lines and arcs, and a distance, from any bytes. Certification refuses a proposed or
/// modified path, or the path keeps its distance. It notices when a loop is left out. A plain outline has a
/// path that it accepts.
///
/// # Panics
/// When certification accepts a path that does not keep its distance or leaves out a loop, or refuses the
/// path around a plain outline.
pub fn offset(bytes: &[u8]) {
    let _ = offset_of(&mut Unstructured::new(bytes));
}

fn offset_of(u: &mut Unstructured<'_>) -> Result<()> {
    let curves = outline(u)?;
    let free_on_left = bool::arbitrary(u)?;
    let d = u.int_in_range(1_000..=600_000_u32)?;
    let curves = if d.is_multiple_of(4) { around(&curves).unwrap_or(curves) } else { curves };
    let chord_error = Length::small(10);
    let pieces: std::result::Result<Vec<_>, _> =
        curves.iter().map(|curve| curve.piece(chord_error, Length::ZERO)).collect();
    let Some(ring) = pieces.ok().and_then(|pieces| Ring::from_pieces(&pieces).ok()) else { return Ok(()) };
    let left = ring.double_area() > 0;
    let side = if left == free_on_left { Side::Inside } else { Side::Outside };
    let Ok(region) = Region::new(vec![ring]) else { return Ok(()) };
    let Ok(part) = ProhibitedRegion::new(region, side) else { return Ok(()) };
    let outlines = [Outline { curves, free_on_left }];
    let (threshold, centre) =
        (Length::from_units(d.into()).unwrap_or(Length::ZERO), f64::from(d) + PATH_CLEARANCE);
    let plain = d >= PLAIN_MIN
        && is_plain(&outlines[0].curves)
        && (side == Side::Outside || reaches(&outlines[0].curves, centre));
    let proposed = propose(&outlines, centre);
    if !proposed.loose_ends.is_empty() {
        assert!(!plain, "loose ends: {outlines:?} {centre}");
        return Ok(());
    }
    // A path for the other side lies on the part's side.
    let other = [Outline { free_on_left: !free_on_left, ..outlines[0].clone() }];
    for each in propose(&other, centre).loops.iter().take(OTHER_MAX) {
        if let Ok(Some(_)) = certify_path(&part, threshold, &each.curves) {
            keeps(&each.curves, &outlines[0], side, d.into());
        }
    }
    let mut believed = Vec::new();
    for (number, each) in proposed.loops.iter().enumerate() {
        if let Ok(Some(_)) = certify_path(&part, threshold, &each.curves) {
            keeps(&each.curves, &outlines[0], side, d.into());
            believed.push(number);
        }
    }
    let whole = certify_complete(&part, &outlines, centre, Length::small(20), curves_of(&proposed.loops));
    let all = believed.len() == proposed.loops.len() && believed.len() == 1;
    assert!(
        !plain || all && whole.is_ok(),
        "{whole:?}: a plain outline has an offset: {outlines:?} {centre}"
    );
    // A loop on the part's side was refused, and completeness does not need it.
    if whole.is_ok() && !believed.is_empty() {
        let mut left = proposed.loops.clone();
        let gone = left.remove(*u.choose(&believed)?);
        misses(&part, &outlines, centre, &left, &gone);
    }
    for _ in 0..u.int_in_range(0..=3_u8)? {
        let Some(each) = proposed.loops.first() else { break };
        let mut changed = each.curves.clone();
        change(&mut changed, u)?;
        if let Ok(Some(_)) = certify_path(&part, threshold, &changed) {
            keeps(&changed, &outlines[0], side, d.into());
        }
    }
    Ok(())
}

/// Whether the outline is a convex polygon with long edges and a clear turn at each corner. Its offset is
/// beyond doubt.
fn is_plain(curves: &[Curve]) -> bool {
    let ways: Vec<(f64, f64)> = curves.iter().map(|curve| way(xy(curve.from()), xy(curve.to()))).collect();
    let turns = ways.iter().zip(ways.iter().cycle().skip(1)).all(|(a, b)| {
        let lengths = a.0.hypot(a.1) * b.0.hypot(b.1);
        (a.0 * b.1 - a.1 * b.0) > 0.01 * lengths
    });
    let long = ways.iter().all(|way| way.0.hypot(way.1) > 10.0 * RESOLUTION);
    turns && long && curves.iter().all(|curve| matches!(curve, Curve::Line(_)))
}

/// The polygon whose corners lie in the directions of the outline's corners, on the circle through the
/// farthest one.
fn around(curves: &[Curve]) -> Option<Vec<Curve>> {
    let places: Vec<(f64, f64)> = curves.iter().map(|curve| xy(curve.from())).collect();
    let r = places.iter().map(|place| place.0.hypot(place.1)).fold(0.0, f64::max);
    let corner = |place: &(f64, f64)| {
        let share = r / place.0.hypot(place.1).max(1.0);
        keepout_kernel::curve::nearest_point(Vec2::new(place.0 * share, place.1 * share)).ok()
    };
    let corners: Vec<Point> = places.iter().map(corner).collect::<Option<_>>()?;
    let next = corners.iter().cycle().skip(1);
    Some(corners.iter().zip(next).map(|(&from, &to)| Curve::Line(Segment { from, to })).collect())
}

/// Whether the distance leaves room around the origin, which the outline surrounds.
fn reaches(curves: &[Curve], d: f64) -> bool {
    distance((0.0, 0.0), curves.iter()) > 1.1 * d + 10.0 * RESOLUTION
}

fn way(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (b.0 - a.0, b.1 - a.1)
}

/// Checks an accepted path: it has no jump, is on the free side, and keeps its distance. Points of the path
/// are measured from the outline, and the outline's corners from the path.
fn keeps(path: &[Curve], outline: &Outline, side: Side, threshold: f64) {
    let walls = &outline.curves;
    let ends = path.iter().zip(path.iter().skip(1)).all(|(one, next)| one.to() == next.from());
    assert!(ends, "the path has a jump");
    for curve in path {
        for place in places(curve).into_iter().chain([xy(curve.from())]) {
            let inside = winds(walls.iter(), place);
            assert_eq!(inside, side == Side::Inside, "{curve:?} is in the part at {place:?}, of {walls:?}");
            let left = distance(place, walls.iter());
            assert!(
                left > threshold - ROUNDING,
                "{curve:?} comes to {left} at {place:?}, not {threshold}, of {walls:?}"
            );
        }
    }
    for corner in walls.iter().map(|wall| xy(wall.from())) {
        let left = distance(corner, path.iter());
        assert!(
            left > threshold - ROUNDING,
            "the path comes to {left} of {corner:?}, not {threshold}: {path:?}"
        );
    }
}

/// Checks that a complete path is not complete without one of its loops.
fn misses(part: &ProhibitedRegion, outlines: &[Outline], d: f64, left: &[OffsetLoop], gone: &OffsetLoop) {
    let length: f64 = gone.curves.iter().map(Curve::length).sum();
    // Certification may miss a loop that lies beside another, or that is shorter than the resolution.
    let beside = |place| distance(place, curves_of(left)) < 10.0 * RESOLUTION;
    let alone = gone.curves.iter().flat_map(places).all(|place| !beside(place));
    let noticed = certify_complete(part, outlines, d, Length::small(20), curves_of(left)).is_err();
    assert!(
        noticed || !alone || length < 10.0 * RESOLUTION,
        "a loop of {length} is not missed: {outlines:?} {d}"
    );
}

fn curves_of(loops: &[OffsetLoop]) -> impl Iterator<Item = &Curve> {
    loops.iter().flat_map(|each| &each.curves)
}

/// Removes, moves, reverses, straightens or bends a curve.
fn change(path: &mut Vec<Curve>, u: &mut Unstructured<'_>) -> Result<()> {
    let k = u.choose_index(path.len())?;
    let by = (i64::from(i16::arbitrary(u)?), i64::from(i8::arbitrary(u)?));
    let moved = |p: Point| {
        let (x, y) = (i64::from(p.x.units()) + by.0, i64::from(p.y.units()) + by.1);
        Point::from_units(x, y).unwrap_or(p)
    };
    match u.int_in_range(0..=4_u8)? {
        0 if path.len() > 1 => drop(path.remove(k)),
        1 => path[k] = Curve::Line(Segment { from: path[k].from(), to: path[k].to() }),
        2 => path[k] = path[k].reversed().unwrap_or(path[k]),
        3 => {
            let bulge = f64::from(i8::arbitrary(u)?) / 100.0;
            if let Some(other) = bent(path[k].from(), path[k].to(), bulge) {
                path[k] = other;
            }
        }
        _ => {
            // Moves a corner, and straightens both curves that meet there.
            let next = (k + 1) % path.len();
            let corner = moved(path[k].to());
            let (from, to) = (path[k].from(), path[next].to());
            path[k] = Curve::Line(Segment { from, to: corner });
            path[next] = Curve::Line(Segment { from: if next == k { from } else { corner }, to });
        }
    }
    Ok(())
}

/// A closed chain of lines and arcs around the origin, with a size of millimetres to decimetres.
fn outline(u: &mut Unstructured<'_>) -> Result<Vec<Curve>> {
    let count = u.int_in_range(2..=16_usize)?;
    let size = 10_f64.powi(i32::from(u.int_in_range(4..=7_u8)?));
    let mut corners = Vec::with_capacity(count);
    for k in 0..count {
        let radius = size * (0.05 + f64::from(u8::arbitrary(u)?) / 256.0);
        #[expect(clippy::cast_precision_loss, reason = "few corners")]
        let (sine, cosine) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
        let corner = keepout_kernel::curve::nearest_point(Vec2::new(radius * cosine, radius * sine));
        corners.push(corner.map_err(|_| arbitrary::Error::IncorrectFormat)?);
    }
    let mut curves = Vec::with_capacity(count);
    for (k, &from) in corners.iter().enumerate() {
        let to = corners[(k + 1) % count];
        let bulge = f64::from(i8::arbitrary(u)?) / 100.0;
        let line = Curve::Line(Segment { from, to });
        curves.push(if bulge.abs() < 0.3 { line } else { bent(from, to, bulge).unwrap_or(line) });
    }
    Ok(curves)
}

/// The arc of that bulge; `None` if it is nearly straight.
pub fn bent(from: Point, to: Point, bulge: f64) -> Option<Curve> {
    if bulge.abs() < 0.01 {
        return None;
    }
    let (a, b) = (Vec2::from(from), Vec2::from(to));
    let off = (1.0 - bulge * bulge) / (4.0 * bulge);
    let centre = a.midpoint(b) + (b - a).left() * off;
    let turn = if bulge > 0.0 { Turn::CounterClockwise } else { Turn::Clockwise };
    keepout_kernel::curve::fit_arc(from, to, centre, turn).ok().map(Curve::Arc)
}

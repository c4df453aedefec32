//! Parts, motions and swept triangles, compared with big integers.

use crate::oracle::xy;
use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_kernel::curve::nearest_unit;
use keepout_kernel::exact::convex::Convex;
use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::ring::{Piece, RingError};
use keepout_kernel::{Curve, Point, ProhibitedRegion, Region, Ring, Side};
use keepout_proofs::families::{at, length};
use keepout_proofs::oracle::{Big, inside_polygon, never_nearer};
use keepout_proofs::properties::Xy;
use keepout_proofs::soak::{point_within, segments_within, triangle_within};
use keepout_proofs::square::plain;

use crate::field::{Field, segment};
use crate::import::check_message;
use crate::offset::bent;
use crate::oracle::{places, to_chord};

/// Reads a part and motions beside it from any bytes. Point, motion, swept triangle and clip must agree
/// with big integers over all edges.
///
/// # Panics
/// When an answer differs.
pub fn clear(bytes: &[u8]) {
    let _ = clear_of(&mut Unstructured::new(bytes));
}

fn clear_of(u: &mut Unstructured<'_>) -> Result<()> {
    let field = Field::arbitrary(u)?;
    let corners = field.ring(u)?;
    let side = if bool::arbitrary(u)? { Side::Outside } else { Side::Inside };
    let mut polygons = vec![corners.iter().copied().map(clamped).collect::<Vec<Xy>>()];
    if bool::arbitrary(u)? {
        polygons.push(field.ring(u)?.into_iter().map(clamped).collect());
    }
    let plain = |polygon: Vec<Xy>| polygon.into_iter().map(|p| (p, 0)).collect();
    let mut drawn = Drawn { outlines: polygons.into_iter().map(plain).collect(), zones: Vec::new(), side };
    let Some(mut part) = drawn.part() else { return Ok(()) };
    let threshold = field.radius(u)?;
    prepare(&mut part, threshold, u)?;
    let truth = Truth::of(&drawn);
    let mut asked = Vec::new();
    for _ in 0..u.int_in_range(1..=4_u8)? {
        let places =
            [field.beside(&corners, u)?, field.beside(&corners, u)?, field.beside(&corners, u)?].map(clamped);
        ask(&part, &truth, places, threshold);
        asked.push(places);
    }
    ask(&part, &truth, drawn.corners_around(), threshold);
    // The same again with keep-out zones, and with edges whose curves leave their chords.
    for (_, chord_error) in drawn.outlines.iter_mut().flatten() {
        *chord_error = chord_error_of(u)?;
    }
    for _ in 0..u.int_in_range(0..=2_u8)? {
        let zone = field.ring(u)?.into_iter().map(clamped);
        drawn.zones.push(zone.map(|p| Ok((p, chord_error_of(u)?))).collect::<Result<_>>()?);
    }
    let Some(mut part) = drawn.part() else { return Ok(()) };
    let threshold = threshold.min(i64::from(COORD_MAX) - CHORD_ERROR_MAX);
    prepare(&mut part, threshold, u)?;
    let truth = Truth::of(&drawn);
    for places in asked.into_iter().chain([drawn.corners_around()]) {
        ask(&part, &truth, places, threshold);
        let more = More {
            corner: clamped(field.beside(&corners, u)?),
            higher: threshold + i64::from(u16::arbitrary(u)?),
            bulge: f64::from(i8::arbitrary(u)?) / 100.0,
        };
        ask_more(&part, &truth, places, threshold, &more);
        ask_simplified(&part, &truth, places, threshold, (more.higher - threshold) / 64);
    }
    Ok(())
}

/// Prepares the cells for the threshold in one of eight cases, because it takes long.
fn prepare(part: &mut ProhibitedRegion, threshold: i64, u: &mut Unstructured<'_>) -> Result<()> {
    if u.int_in_range(0..=7_u8)? == 7 {
        let _ = part.prepare(length(threshold));
    }
    Ok(())
}

/// Largest chord-error bound, lattice units.
const CHORD_ERROR_MAX: i64 = 1 << 17;

fn chord_error_of(u: &mut Unstructured<'_>) -> Result<i64> {
    Ok(match u.int_in_range(0..=3_u8)? {
        0 => i64::from(u16::arbitrary(u)?),
        1 => i64::from(u8::arbitrary(u)?),
        _ => 0,
    })
}

/// The point clamped to the lattice, as [`at`] does.
fn clamped(p: Xy) -> Xy {
    plain(at(p))
}

/// Corners, each with the chord-error bound of the edge that begins there.
type Loop = Vec<(Xy, i64)>;

/// A part as it was drawn, independent of the kernel.
struct Drawn {
    outlines: Vec<Loop>,
    zones: Vec<Loop>,
    side: Side,
}

impl Drawn {
    /// Corners of a triangle around all of the part, as far as the lattice allows.
    fn corners_around(&self) -> [Xy; 3] {
        let corners = || self.outlines.iter().chain(&self.zones).flatten().map(|&(p, _)| p);
        let ends = |of: fn(&Xy) -> i64| {
            let most = corners().map(|p| of(&p)).max().unwrap_or(0);
            (corners().map(|p| of(&p)).min().unwrap_or(0), most)
        };
        let ((x0, x1), (y0, y1)) = (ends(|p| p.0), ends(|p| p.1));
        let off = x1 - x0 + y1 - y0;
        [(x0 - off, y0 - off), (x1 + off, y0 - off), (i64::midpoint(x0, x1), y1 + 2 * off)].map(clamped)
    }

    /// The kernel's region. A drawing that is not a region gives an error with a text.
    fn part(&self) -> Option<ProhibitedRegion> {
        let rings =
            |loops: &[Loop]| match loops.iter().map(ring_of).collect::<std::result::Result<Vec<_>, _>>() {
                Ok(rings) => Some(rings),
                Err(error) => {
                    check_message(&error.to_string());
                    None
                }
            };
        let region = match Region::new(rings(&self.outlines)?) {
            Ok(region) => region,
            Err(error) => {
                check_message(&error.to_string());
                return None;
            }
        };
        ProhibitedRegion::with_zones(region, self.side, rings(&self.zones)?).ok()
    }
}

fn ring_of(each: &Loop) -> std::result::Result<Ring, RingError> {
    let pieces = edges_of(each).map(|((a, b), chord_error)| Piece::Line {
        segment: segment(a, b),
        chord_error: length(chord_error),
    });
    Ring::from_pieces(&pieces.collect::<Vec<_>>())
}

fn edges_of(each: &Loop) -> impl Iterator<Item = ((Xy, Xy), i64)> + '_ {
    each.iter().zip(each.iter().cycle().skip(1)).map(|(&(a, chord_error), &(b, _))| ((a, b), chord_error))
}

/// The part for queries in big integers.
#[derive(Debug)]
struct Truth {
    walls: Vec<((Xy, Xy), i64)>,
    polygons: Vec<Vec<Big>>,
    zones: Vec<Vec<Big>>,
    side: Side,
}

impl Truth {
    fn of(drawn: &Drawn) -> Self {
        let places = |each: &Loop| each.iter().map(|&((x, y), _)| Big::new(x, y)).collect();
        Self {
            walls: drawn.outlines.iter().chain(&drawn.zones).flat_map(edges_of).collect(),
            polygons: drawn.outlines.iter().map(places).collect(),
            zones: drawn.zones.iter().map(places).collect(),
            side: drawn.side,
        }
    }

    /// Whether the tool may be at a point that is on no wall.
    fn is_free(&self, (x, y): Xy) -> bool {
        let at = Big::new(x, y);
        let around = |polygon: &&Vec<Big>| inside_polygon(&at, polygon) == Some(true);
        let within = self.polygons.iter().filter(around).count() % 2 == 1;
        within == (self.side == Side::Inside) && !self.zones.iter().any(|zone| around(&zone))
    }

    fn near_point(&self, p: Xy, r: i64) -> bool {
        self.walls.iter().any(|&((a, b), chord_error)| point_within(p, a, b, r + chord_error))
    }

    /// The least distance of points on the curve from the walls, less the walls' chord-error bounds.
    #[expect(clippy::cast_precision_loss, reason = "chord errors have 17 bits")]
    fn kept_by(&self, curve: &Curve) -> f64 {
        let left = |place| {
            let off = |&((a, b), chord_error): &((Xy, Xy), i64)| {
                to_chord(place, (xy(at(a)), xy(at(b)))) - chord_error as f64
            };
            self.walls.iter().map(off).fold(f64::INFINITY, f64::min)
        };
        places(curve).into_iter().map(left).fold(f64::INFINITY, f64::min)
    }

    fn near_motion(&self, p: Xy, q: Xy, r: i64) -> bool {
        self.walls.iter().any(|&((a, b), chord_error)| segments_within(p, q, a, b, r + chord_error))
    }

    fn near_triangle(&self, corners: [Xy; 3], r: i64) -> bool {
        self.walls.iter().any(|&((a, b), chord_error)| triangle_within(corners, a, b, r + chord_error))
    }

    /// Whether the motion comes within `r` of a wall, and nearer to that wall than at its start.
    fn approaches(&self, p: Xy, q: Xy, r: i64) -> bool {
        let big = |(x, y): Xy| Big::new(x, y);
        self.walls.iter().any(|&((a, b), chord_error)| {
            segments_within(p, q, a, b, r + chord_error) && !never_nearer(&big(p), &big(q), &big(a), &big(b))
        })
    }
}

fn ask(part: &ProhibitedRegion, truth: &Truth, [p, q, s]: [Xy; 3], r: i64) {
    let case = || format!("{p:?} {q:?} {s:?} within {r} of {truth:?}");
    let t = length(r);
    assert_eq!(part.point_clear(at(p), t).is_clear(), !truth.near_point(p, r), "point {}", case());
    assert_eq!(
        part.motion_clear(segment(p, q), t).is_clear(),
        !truth.near_motion(p, q, r),
        "motion {}",
        case()
    );
    let start = part.free_point(at(p), t);
    let is_free = !truth.near_point(p, r) && truth.is_free(p);
    assert_eq!(start.is_ok(), is_free, "free point {}", case());
    let Ok(start) = start else { return };
    let motion = part.motion(start, at(q));
    assert_eq!(motion.is_ok(), !truth.near_motion(p, q, r), "motion from a free point {}", case());
    if let Ok(end) = motion {
        let swept = part.swept_triangle(start, end, at(s)).is_ok();
        assert_eq!(swept, !truth.near_triangle([p, q, s], r), "swept triangle {}", case());
    }
    let clipped = plain(part.clip(start, at(q)).point());
    assert!(!truth.near_motion(p, clipped, r), "clipped at {clipped:?}, {}", case());
    let whole = truth.near_motion(p, q, r) || clipped == q;
    assert!(whole, "clipped at {clipped:?} although clear, {}", case());
    if let Some(clearance) = part.clearance(at(p)) {
        let c = i64::from(clearance.units());
        assert!(!truth.near_point(p, c), "clearance {c}, {}", case());
    }
}

/// Lattice units above the rounding error.
const MORE: i64 = 5;

/// Inputs of the further queries.
#[derive(Debug)]
struct More {
    /// One more corner of a polygon.
    corner: Xy,
    /// The threshold of a retract move.
    higher: i64,
    /// The bulge of an arc.
    bulge: f64,
}

/// Filled polygons, retract moves and arcs from a free point.
fn ask_more(part: &ProhibitedRegion, truth: &Truth, [p, q, s]: [Xy; 3], r: i64, more: &More) {
    let case = || format!("{p:?} {q:?} {s:?} within {r}, {more:?} of {truth:?}");
    let holds = part.holds(at(p));
    let on_wall = truth.walls.iter().any(|&((a, b), _)| point_within(p, a, b, 0));
    assert_eq!(holds, on_wall || !truth.is_free(p), "holds {}", case());
    let Ok(start) = part.free_point(at(p), length(r)) else { return };
    let o = more.corner;
    for corners in [vec![p, q], vec![p, q, s], vec![p, s, q], vec![p, q, s, o], vec![p, o, s, q]] {
        let points: Vec<Point> = corners.iter().map(|&corner| at(corner)).collect();
        let Some(polygon) = Convex::check(&points) else { continue };
        // The triangles from its first corner cover all of it.
        let triangles = corners[1..].windows(2).map(|pair| [p, pair[0], pair[1]]);
        let near = truth.near_motion(p, corners[1], r)
            || triangles.into_iter().any(|each| truth.near_triangle(each, r));
        let end = part.polygon(start, polygon, at(q));
        assert_eq!(end.is_ok(), !near, "polygon {corners:?}, {}", case());
    }
    let retract_move = part.retract(start, at(q), length(more.higher));
    assert_eq!(retract_move.is_ok(), !truth.approaches(p, q, more.higher), "retract move {}", case());
    let Some(curve) = bent(at(p), at(q), more.bulge) else { return };
    let Curve::Arc(arc) = &curve else { return };
    let kept = truth.kept_by(&curve);
    // At the query's threshold, and at more than the arc keeps.
    for asked in [r, nearest_unit(kept).saturating_add(MORE).max(0)] {
        let start = i64::from(COORD_MAX) - CHORD_ERROR_MAX >= asked;
        let start = start.then(|| part.free_point(at(p), length(asked)).ok()).flatten();
        let keeps = start.is_some_and(|start| part.arc(start, arc).is_ok());
        // An arc's ends are on its circle to a unit or two.
        let least = f64::from(length(asked).units()) - 3.0;
        assert!(!keeps || kept > least, "{arc:?} comes to {kept}, not {asked}, {}", case());
    }
}

/// Points, motions and swept triangles that are free of the simplified outline are free of the part.
fn ask_simplified(part: &ProhibitedRegion, truth: &Truth, [p, q, s]: [Xy; 3], r: i64, tolerance: i64) {
    let case = || format!("{p:?} {q:?} {s:?} within {r} of {truth:?}, simplified by {tolerance}");
    let simplified = part.simplified(length(tolerance)).expect("fewer edges");
    let Ok(start) = simplified.free_point(at(p), length(r)) else { return };
    assert!(!truth.near_point(p, r) && truth.is_free(p), "free point {}", case());
    let Ok(end) = simplified.motion(start, at(q)) else { return };
    assert!(!truth.near_motion(p, q, r), "motion {}", case());
    let swept = simplified.swept_triangle(start, end, at(s));
    assert!(swept.is_err() || !truth.near_triangle([p, q, s], r), "swept triangle {}", case());
}

//! Joins curves end to end into closed loops on the lattice, and says what it had to repair.

use std::collections::BTreeMap;

use keepout_kernel::curve::{fit_arc, half_circle_parts};
use keepout_kernel::{Curve, Length, Point, Segment, Turn, UNITS_PER_MM};

use super::{DrawingError, DrawnCurve, Origin, RawCurve};
use crate::profile::{CHORD_SLACK, Profile, ProfileEdge, ProfileLoop};
use crate::units::{mm, place, point_from_mm, point_mm};

/// Gaps up to this are closed, in millimetres, unless the caller says otherwise.
pub const JOIN_MM: f64 = 0.01;

/// Gaps up to this, in lattice units (0.1 µm), are rounding and not worth a word.
const ROUNDING: f64 = 10.0;

/// An arc of larger radius (mm) is carried as chords: its centre would leave the lattice.
const RADIUS_MAX_MM: f64 = 2000.0;

/// Something that was changed in the drawing to make contours of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Repair {
    /// Two ends were moved together.
    GapClosed {
        /// Where, after the repair.
        at: Point,
        /// How far apart the ends were.
        gap_mm: f64,
    },
    /// A curve no longer than the joining tolerance was left out.
    TinyDropped {
        /// Where it began.
        at: Point,
        /// Its length.
        length_mm: f64,
    },
    /// A curve that repeats another was left out.
    DuplicateDropped {
        /// Where it began.
        at: Point,
    },
}

impl std::fmt::Display for Repair {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::GapClosed { at, gap_mm } => write!(f, "gap of {gap_mm:.5} mm closed at {}", place(*at)),
            Self::TinyDropped { at, length_mm } => {
                write!(f, "piece of {length_mm:.5} mm left out at {}", place(*at))
            }
            Self::DuplicateDropped { at } => write!(f, "doubled curve left out at {}", place(*at)),
        }
    }
}

/// Closed loops and what was repaired on the way.
#[derive(Clone, Debug)]
pub struct Chained {
    /// The loops.
    pub profile: Profile,
    /// The repairs, in no particular order.
    pub repairs: Vec<Repair>,
}

/// A curve on its way to the lattice: its ends may still move.
#[derive(Clone, Copy, Debug)]
struct Piece<'a> {
    from: Point,
    to: Point,
    /// Centre in lattice units, and direction; `None` for a line.
    arc: Option<((f64, f64), Turn)>,
    slack: Length,
    origin: &'a Origin,
}

/// Joins the curves into closed loops; ends up to `join_mm` apart are moved together, and listed.
///
/// # Errors
/// [`DrawingError::Open`] and [`DrawingError::Branch`] with the place, [`DrawingError::OffLattice`] with the entity.
pub fn chain(curves: &[DrawnCurve], join_mm: f64) -> Result<Chained, DrawingError> {
    let mut repairs = Vec::new();
    let mut pieces = Vec::new();
    for drawn in curves {
        let start = pieces.len();
        lattice_pieces(drawn, &mut pieces)?;
        let length_mm = |piece: &Piece<'_>| distance(piece.from, piece.to) / f64::from(UNITS_PER_MM);
        if let [only] = pieces[start..]
            && only.arc.is_none()
            && length_mm(&only) <= join_mm
        {
            if length_mm(&only) > 0.0 {
                repairs.push(Repair::TinyDropped { at: only.from, length_mm: length_mm(&only) });
            }
            pieces.truncate(start);
        }
    }
    drop_duplicates(&mut pieces, &mut repairs);
    let joints = join(&mut pieces, join_mm, &mut repairs)?;
    let loops = follow(&pieces, &joints)?;
    Ok(Chained { profile: Profile { loops }, repairs })
}

fn lattice_pieces<'a>(drawn: &'a DrawnCurve, pieces: &mut Vec<Piece<'a>>) -> Result<(), DrawingError> {
    let origin = &drawn.origin;
    let on_lattice = |p| {
        point_from_mm(p)
            .map_err(|source| DrawingError::OffLattice { origin: Box::new(origin.clone()), source })
    };
    let mut push = |from: (f64, f64), to: (f64, f64), arc: Option<((f64, f64), Turn)>, slack: Length| {
        let (from, to) = (on_lattice(from)?, on_lattice(to)?);
        if from != to || arc.is_none() {
            pieces.push(Piece { from, to, arc, slack, origin });
        }
        Ok::<(), DrawingError>(())
    };
    match drawn.curve {
        RawCurve::Line { from, to } => push(from, to, None, Length::ZERO),
        RawCurve::Arc { centre, radius, from, to, start, sweep } => {
            let at = |t: f64| match t {
                0.0 => from,
                1.0 => to,
                _ => {
                    let phi = start + sweep * t;
                    (centre.0 + radius * phi.cos(), centre.1 + radius * phi.sin())
                }
            };
            let scale = f64::from(UNITS_PER_MM);
            let centre_units = (centre.0 * scale, centre.1 * scale);
            let turn = if sweep > 0.0 { Turn::Left } else { Turn::Right };
            let flat = radius > RADIUS_MAX_MM || on_lattice(centre).is_err();
            let (parts, arc, slack) = if flat {
                (chords_needed(radius, sweep), None, CHORD_SLACK)
            } else {
                (f64::from(half_circle_parts(sweep.abs())), Some((centre_units, turn)), Length::ZERO)
            };
            let mut k = 0.0;
            while k < parts {
                push(at(k / parts), at((k + 1.0) / parts), arc, slack)?;
                k += 1.0;
            }
            Ok(())
        }
    }
}

/// Chords of a flat arc whose sagitta, with a unit of rounding on either side, stays within [`CHORD_SLACK`].
fn chords_needed(radius_mm: f64, sweep: f64) -> f64 {
    let sagitta_mm = mm(CHORD_SLACK.units()) * 0.7;
    let step = (8.0 * sagitta_mm / radius_mm).sqrt();
    (sweep.abs() / step).ceil().max(1.0)
}

fn drop_duplicates(pieces: &mut Vec<Piece<'_>>, repairs: &mut Vec<Repair>) {
    let mut seen = std::collections::BTreeSet::new();
    pieces.retain(|piece| {
        // The same arc drawn the other way has its ends and its turn swapped.
        let forwards = piece.from < piece.to;
        let ends = if forwards { (piece.from, piece.to) } else { (piece.to, piece.from) };
        let bend = piece.arc.map(|((x, y), turn)| {
            let round = |c: f64| keepout_kernel::curve::nearest_unit(c);
            (round(x), round(y), (turn == Turn::Left) == forwards)
        });
        let new = seen.insert((ends, bend));
        if !new {
            repairs.push(Repair::DuplicateDropped { at: piece.from });
        }
        new
    });
}

/// One end of a piece.
type End = (usize, bool);

fn end_point(pieces: &[Piece<'_>], (index, at_end): End) -> Point {
    if at_end { pieces[index].to } else { pieces[index].from }
}

/// Pairs the ends, moves both of a pair to one point, and answers with the partner of each end.
fn join(
    pieces: &mut [Piece<'_>],
    join_mm: f64,
    repairs: &mut Vec<Repair>,
) -> Result<BTreeMap<End, End>, DrawingError> {
    let reach = join_mm.max(0.0) * f64::from(UNITS_PER_MM);
    let reach = reach.max(ROUNDING);
    let ends: Vec<End> = (0..pieces.len()).flat_map(|i| [(i, false), (i, true)]).collect();
    let points: Vec<Point> = ends.iter().map(|&end| end_point(pieces, end)).collect();
    let groups = groups_within(&points, reach);
    let mut partners = BTreeMap::new();
    let loose: Vec<usize> = groups.iter().filter(|group| group.len() == 1).map(|group| group[0]).collect();
    if let Some((&first, others)) = loose.split_first() {
        let gap = |&i: &usize| distance(points[first], points[i]) / f64::from(UNITS_PER_MM);
        let gap_mm = others.iter().map(gap).min_by(f64::total_cmp);
        let origin = Box::new(pieces[ends[first].0].origin.clone());
        return Err(DrawingError::Open { origin, at: points[first], gap_mm });
    }
    for group in groups {
        let (a, b, at) = (group[0], group[1], points[group[0]]);
        if group.len() > 2 {
            let origin = Box::new(pieces[ends[a].0].origin.clone());
            return Err(DrawingError::Branch { origin, at, count: group.len() });
        }
        let gap = distance(points[a], points[b]);
        let (p, q) = (point_mm(points[a]), point_mm(points[b]));
        let middle = point_from_mm((f64::midpoint(p.0, q.0), f64::midpoint(p.1, q.1))).unwrap_or(points[a]);
        for end in [ends[a], ends[b]] {
            let piece = &mut pieces[end.0];
            if end.1 { piece.to = middle } else { piece.from = middle }
        }
        if gap > ROUNDING {
            repairs.push(Repair::GapClosed { at: middle, gap_mm: gap / f64::from(UNITS_PER_MM) });
        }
        partners.insert(ends[a], ends[b]);
        partners.insert(ends[b], ends[a]);
    }
    Ok(partners)
}

/// Groups of points that are linked by steps of at most `reach` lattice units.
fn groups_within(points: &[Point], reach: f64) -> Vec<Vec<usize>> {
    let cell = |c: i32| (f64::from(c) / reach).floor();
    let key = |p: &Point| {
        (
            keepout_kernel::curve::nearest_unit(cell(p.x.units())),
            keepout_kernel::curve::nearest_unit(cell(p.y.units())),
        )
    };
    let mut cells: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
    for (i, point) in points.iter().enumerate() {
        cells.entry(key(point)).or_default().push(i);
    }
    let mut grouped = vec![false; points.len()];
    let mut groups = Vec::new();
    for first in 0..points.len() {
        if grouped[first] {
            continue;
        }
        grouped[first] = true;
        let mut group = vec![first];
        let mut next = 0;
        while let Some(&i) = group.get(next) {
            next += 1;
            let (x, y) = key(&points[i]);
            for near in (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y))) {
                for &j in cells.get(&near).map_or(&[][..], Vec::as_slice) {
                    if !grouped[j] && distance(points[i], points[j]) <= reach {
                        grouped[j] = true;
                        group.push(j);
                    }
                }
            }
        }
        groups.push(group);
    }
    groups
}

fn distance(p: Point, q: Point) -> f64 {
    let d = p.minus(q);
    f64::from(d.dx).hypot(f64::from(d.dy))
}

/// Runs through the joined pieces, loop by loop.
fn follow(pieces: &[Piece<'_>], partners: &BTreeMap<End, End>) -> Result<Vec<ProfileLoop>, DrawingError> {
    let mut used = vec![false; pieces.len()];
    let mut loops = Vec::new();
    for first in 0..pieces.len() {
        let mut edges = Vec::new();
        let mut entry: End = (first, false);
        while !used[entry.0] {
            used[entry.0] = true;
            edges.extend(edge_of(&pieces[entry.0], entry.1)?);
            let exit = (entry.0, !entry.1);
            entry = partners.get(&exit).copied().unwrap_or(entry);
        }
        if !edges.is_empty() {
            loops.push(ProfileLoop { edges });
        }
    }
    Ok(loops)
}

/// The piece as an edge run from its entry, its arc fitted through the ends where they are now.
fn edge_of(piece: &Piece<'_>, backwards: bool) -> Result<Option<ProfileEdge>, DrawingError> {
    let (from, to) = if backwards { (piece.to, piece.from) } else { (piece.from, piece.to) };
    if from == to {
        return Ok(None);
    }
    let Some((centre, turn)) = piece.arc else {
        return Ok(Some(ProfileEdge { curve: Curve::Line(Segment { from, to }), slack: piece.slack }));
    };
    let turn = if backwards { turn.reversed() } else { turn };
    match fit_arc(from, to, onto_bisector(centre, from, to), turn) {
        Ok(arc) => Ok(Some(ProfileEdge { curve: Curve::Arc(arc), slack: Length::ZERO })),
        Err(_) => Err(DrawingError::BadEntity {
            origin: Box::new(piece.origin.clone()),
            problem: "its arc has a radius below 1 µm, or its ends do not lie on one circle",
        }),
    }
}

/// The point on the perpendicular bisector of the ends that is nearest to `centre`.
fn onto_bisector(centre: (f64, f64), from: Point, to: Point) -> (f64, f64) {
    let xy = |p: Point| (f64::from(p.x.units()), f64::from(p.y.units()));
    let (a, b) = (xy(from), xy(to));
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mx, my) = (f64::midpoint(a.0, b.0), f64::midpoint(a.1, b.1));
    let off = ((centre.0 - mx) * dx + (centre.1 - my) * dy) / (dx * dx + dy * dy);
    (centre.0 - dx * off, centre.1 - dy * off)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(curve: RawCurve) -> DrawnCurve {
        DrawnCurve { curve, origin: Origin { kind: "LINE", handle: 0, number: 1, layer: "0".into() } }
    }

    fn line(from: (f64, f64), to: (f64, f64)) -> DrawnCurve {
        drawn(RawCurve::Line { from, to })
    }

    #[test]
    fn shuffled_and_turned_lines_make_one_loop() {
        let square = [
            line((0.0, 0.0), (10.0, 0.0)),
            line((0.0, 10.0), (10.0, 10.0)),
            line((0.0, 10.0), (0.0, 0.0)),
            line((10.0, 0.0), (10.0, 10.0)),
        ];
        let chained = chain(&square, JOIN_MM).unwrap();
        assert_eq!((chained.profile.loops.len(), chained.profile.loops[0].edges.len()), (1, 4));
        assert!(chained.repairs.is_empty());
    }

    #[test]
    fn small_gap_is_closed_and_reported_and_a_wide_one_is_an_error() {
        let triangle = |gap: f64| {
            [line((0.0, 0.0), (10.0, 0.0)), line((10.0, gap), (5.0, 8.0)), line((5.0, 8.0), (0.0, 0.0))]
        };
        let chained = chain(&triangle(0.004), JOIN_MM).unwrap();
        assert!(
            matches!(chained.repairs[..], [Repair::GapClosed { gap_mm, .. }] if (gap_mm - 0.004).abs() < 1e-9)
        );
        let error = chain(&triangle(0.25), JOIN_MM).unwrap_err();
        assert!(
            matches!(error, DrawingError::Open { gap_mm: Some(gap), .. } if (gap - 0.25).abs() < 1e-9),
            "{error}"
        );
        assert!(chain(&triangle(0.25), 0.3).is_ok());
    }

    #[test]
    fn duplicates_tiny_pieces_and_branches() {
        let mut curves = vec![
            line((0.0, 0.0), (10.0, 0.0)),
            line((10.0, 0.0), (5.0, 8.0)),
            line((5.0, 8.0), (0.0, 0.0)),
            line((0.0, 0.0), (5.0, 8.0)),
            line((5.0, 8.0), (5.0, 8.005)),
        ];
        let chained = chain(&curves, JOIN_MM).unwrap();
        assert_eq!(chained.repairs.len(), 2, "{:?}", chained.repairs);
        // A second triangle that shares a corner: four ends meet there.
        curves.push(line((5.0, 8.0), (20.0, 20.0)));
        curves.push(line((20.0, 20.0), (30.0, 0.0)));
        curves.push(line((30.0, 0.0), (5.0, 8.0)));
        assert!(matches!(chain(&curves, JOIN_MM), Err(DrawingError::Branch { count: 4, .. })));
    }
}

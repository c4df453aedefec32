//! Follows joined pieces: the edges of contours and of open chains.

use std::ops::RangeInclusive;

use keepout_kernel::arc_view::onto_bisector;
use keepout_kernel::curve::fit_arc;
use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::{Curve, Length, Point, Segment, UNITS_PER_MM, Vec2};

use super::chain::{Bend, Chained, End, OpenChain, Piece};
use super::fit::chain_along;
use super::join::Joiner;
use super::{DrawingError, Origin, Repair};
use crate::profile::{ProfileEdge, ProfileLoop, SourceCurve};

/// Permitted bounds on the distance between a spline or ellipse and the edges that replace it.
pub(super) const BOUNDS: RangeInclusive<Length> = Length::small(10)..=Length::whole_mm(1);

/// Follows the joined pieces. Closed loops go to the profile, all other chains to `open`.
pub(super) fn follow(
    joiner: &Joiner,
    bound: Length,
    origins: &[Origin],
    chained: &mut Chained,
) -> Result<(), DrawingError> {
    let pieces = &joiner.pieces;
    let mut used = vec![false; pieces.len()];
    // First the open chains, from their loose ends. All remaining pieces belong to closed loops.
    for start in joiner.loose() {
        if used[start.0] {
            continue;
        }
        let ends = ends_along(pieces, start, &mut used);
        let curves =
            edges_along(pieces, &ends, bound, origins)?.edges.iter().map(|edge| edge.curve).collect();
        let origin = origins[pieces[start.0].origin as usize].clone();
        chained.open.push(OpenChain { curves, origin });
    }
    for first in 0..pieces.len() {
        if used[first] {
            continue;
        }
        let ends = ends_along(pieces, (first, 0), &mut used);
        let each = contour(pieces, &ends, bound, origins)?;
        if each.is_flat() {
            let line = each.edges[0].curve;
            let length_mm = line.length() / f64::from(UNITS_PER_MM);
            chained.repairs.push(Repair::ThereAndBack { at: line.from(), length_mm });
        } else if !each.edges.is_empty() {
            chained.layers.push(origins[pieces[first].origin as usize].layer.clone());
            chained.profile.loops.push(each);
        }
    }
    Ok(())
}

/// The ends at which a chain enters its pieces, the first one at `entry`.
fn ends_along(pieces: &[Piece], mut entry: End, used: &mut [bool]) -> Vec<End> {
    let mut ends = Vec::new();
    while !used[entry.0] {
        used[entry.0] = true;
        ends.push(entry);
        let Some(next) = pieces[entry.0].joined[1 - entry.1] else { break };
        entry = next;
    }
    ends
}

/// The edges of a closed chain. A curve that is smaller than the bound may become a line there and back, which
/// encloses no area. Then a finer bound is taken.
fn contour(
    pieces: &[Piece],
    ends: &[End],
    mut bound: Length,
    origins: &[Origin],
) -> Result<ProfileLoop, DrawingError> {
    loop {
        let each = edges_along(pieces, ends, bound, origins)?;
        let least = *BOUNDS.start();
        if !each.is_flat() || each.sources.is_empty() || bound <= least {
            return Ok(each);
        }
        bound = Length::from_units(i64::from(bound.units()) / 8).map_or(least, |finer| finer.max(least));
    }
}

/// The edges of a chain.
fn edges_along(
    pieces: &[Piece],
    ends: &[End],
    bound: Length,
    origins: &[Origin],
) -> Result<ProfileLoop, DrawingError> {
    let mut each = ProfileLoop::default();
    for &(piece, end) in ends {
        edges_of(&pieces[piece], end == 1, bound, origins, &mut each)?;
    }
    Ok(each)
}

/// Adds the edges of a piece in the direction of travel, fitted to its ends after the repairs.
fn edges_of(
    piece: &Piece,
    backwards: bool,
    bound: Length,
    origins: &[Origin],
    out: &mut ProfileLoop,
) -> Result<(), DrawingError> {
    let bad = |problem| {
        let origin = Box::new(origins[piece.origin as usize].clone());
        Err(DrawingError::BadEntity { origin, problem })
    };
    let (from, to) = if backwards { (piece.to, piece.from) } else { (piece.from, piece.to) };
    let exact = |curve| ProfileEdge { curve, chord_error: Length::ZERO };
    match &piece.bend {
        Bend::Free(curve) => {
            let Some(curve) = ending_at(curve, backwards, from, to) else {
                return bad("its control points make no curve");
            };
            let Ok(chain) = chain_along(&curve, bound) else {
                return bad("no lines and arcs follow it within --curve-mm");
            };
            let first = out.edges.len();
            out.edges.extend(chain.into_iter().map(|curve| ProfileEdge { curve, chord_error: bound }));
            out.sources.push(SourceCurve { curve, first, end: out.edges.len() });
        }
        _ if from == to => {}
        Bend::Straight => out.edges.push(exact(Curve::Line(Segment { from, to }))),
        Bend::Round(centre, turn, drawn) => {
            let turn = if backwards { turn.reversed() } else { *turn };
            let Ok(arc) = fit_arc(from, to, onto_bisector(*centre, Vec2::from(from), Vec2::from(to)), turn)
            else {
                return bad("its arc has a radius below 1 µm, or its ends do not lie on one circle");
            };
            // If a repair moved the ends past each other, the arc would cover the rest of the circle.
            let way = piece.to.minus(piece.from);
            let along = [(way.dx, drawn.dx), (way.dy, drawn.dy)].map(|(a, b)| i64::from(a) * i64::from(b));
            if along[0] + along[1] <= 0 {
                return bad("closing gaps within --join-mm moved its ends past each other");
            }
            out.edges.push(exact(Curve::Arc(arc)));
        }
    }
    Ok(())
}

/// The curve in the direction of travel, with its ends moved to `from` and `to`.
fn ending_at(curve: &Bezier, backwards: bool, from: Point, to: Point) -> Option<Bezier> {
    let (mut control, mut weights) = (curve.control().to_vec(), curve.weights().to_vec());
    if backwards {
        control.reverse();
        weights.reverse();
    }
    *control.first_mut()? = from;
    *control.last_mut()? = to;
    Bezier::new(control, weights).ok()
}

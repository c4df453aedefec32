//! Proposes offset loops: every edge's and corner's offset shape, less what other edges cover, joined end to end.

use alloc::collections::BTreeMap;
use alloc::vec;
use alloc::vec::Vec;

use libm::{atan2, floor, sqrt};

use super::certify::shortest_arc;
use super::plane::{Shape, Xy, cross, dot, minus, norm, plus, right_of};
use crate::curve::{self, Curve};
use crate::exact::arc::Turn;
use crate::exact::segment::Segment;

/// A closed chain of curves with the free side on its right.
#[derive(Clone, Debug)]
pub struct Outline {
    /// The curves in order, each beginning where the one before ends.
    pub curves: Vec<Curve>,
    /// Whether the free side is on the left instead, so that the chain is to be run through backwards.
    pub free_on_left: bool,
}

/// A closed loop of the offset, in path order: the part is on the left of its direction.
#[derive(Clone, Debug)]
pub struct OffsetLoop {
    /// Lines and arcs, each beginning where the one before ends, the last ending where the first begins.
    pub curves: Vec<Curve>,
    /// Indices of the outlines that the loop touches, ascending.
    pub outlines: Vec<usize>,
}

/// A proposed offset.
#[derive(Clone, Debug, Default)]
pub struct Offset {
    /// The loops.
    pub loops: Vec<OffsetLoop>,
    /// Length of profile that the disc touches, in lattice units.
    pub touched_length: f64,
    /// Length of the profile, in lattice units.
    pub profile_length: f64,
    /// Area that the disc can not reach and the profile does not enclose, in square lattice units.
    pub residual_area: f64,
    /// Ends that found no continuation, in lattice units. Not empty means that the proposal is not to be used.
    pub loose_ends: Vec<(f64, f64)>,
}

/// A point nearer than `d` by more than this (lattice units) is covered.
const COVER: f64 = 1e-4;
/// Ends nearer than this (lattice units, 0.3 µm) belong to one joint, at least; see [`joint_width`].
const JOINT: f64 = 30.0;

/// How far apart the ends of two shapes can be that belong to one joint. At a concave joint of a small angle θ both
/// shapes overhang by `dθ/2` and dip below `d` by no more than `dθ²/4`; when that is less than [`COVER`] both overhangs
/// are kept, and their ends are `dθ < 2·√(d·COVER)` apart.
fn joint_width(d: f64) -> f64 {
    JOINT.max(6.0 * sqrt(d * COVER))
}

/// Where an offset shape comes from.
#[derive(Clone, Copy, Debug)]
struct Source {
    outline: usize,
    /// The edge it runs beside, or `None` for a corner.
    edge: Option<Shape>,
}

struct Kept {
    shape: Shape,
    source: Source,
    touched: Option<Shape>,
}

/// Proposes the set at distance `d` (lattice units) from the outlines, on their free side.
#[must_use]
pub fn propose(outlines: &[Outline], d: f64) -> Offset {
    let chains: Vec<Vec<Shape>> = outlines.iter().map(oriented).collect();
    let edges: Vec<Shape> = chains.iter().flatten().copied().collect();
    let candidates: Vec<(Shape, Source)> =
        chains.iter().enumerate().flat_map(|(outline, chain)| offsets_of(outline, chain, d)).collect();
    let edge_grid = Grid::new(&edges, d);
    let shapes: Vec<Shape> = candidates.iter().map(|candidate| candidate.0).collect();
    let shape_grid = Grid::new(&shapes, d);
    let mut kept = Vec::new();
    for (index, &(shape, source)) in candidates.iter().enumerate() {
        let cuts = cuts_of(index, &shape, &shapes, &shape_grid);
        keep_uncovered(&shape, source, &cuts, &edges, &edge_grid, d, &mut kept);
    }
    let profile_length = edges.iter().map(Shape::length).sum();
    let touched_length = kept.iter().filter_map(|piece| piece.touched).map(|edge| edge.length()).sum();
    let part_area: f64 = chains.iter().flatten().map(|edge| edge.double_area((0.0, 0.0)) / 2.0).sum();
    let mut offset = Offset { touched_length, profile_length, ..Offset::default() };
    stitch(&kept, d, part_area, &mut offset);
    offset
}

fn oriented(outline: &Outline) -> Vec<Shape> {
    let shapes = outline.curves.iter().map(Shape::of);
    if outline.free_on_left { shapes.rev().map(Shape::reversed).collect() } else { shapes.collect() }
}

/// The offset shapes of a chain: one beside each edge, and an arc around each corner that is convex to the tool.
fn offsets_of(outline: usize, chain: &[Shape], d: f64) -> Vec<(Shape, Source)> {
    let mut shapes = Vec::new();
    for (i, edge) in chain.iter().enumerate() {
        if let Some(shape) = edge.offset_right(d) {
            shapes.push((shape, Source { outline, edge: Some(*edge) }));
        }
        let next = &chain[(i + 1) % chain.len()];
        let (incoming, outgoing) = (edge.direction(1.0), next.direction(0.0));
        let turned = atan2(cross(incoming, outgoing), dot(incoming, outgoing));
        if turned * d > 1.0 {
            let normal = right_of(incoming);
            let start = atan2(normal.1, normal.0);
            let corner = Shape::Arc { centre: edge.at(1.0), radius: d, start, sweep: turned };
            shapes.push((corner, Source { outline, edge: None }));
        }
    }
    shapes
}

/// Parameters at which other offset shapes meet this one, with 0 and 1, ascending.
fn cuts_of(index: usize, shape: &Shape, shapes: &[Shape], grid: &Grid) -> Vec<f64> {
    let mut cuts = vec![0.0, 1.0];
    grid.near(shape.bounds(), JOINT, |other| {
        if other != index {
            cuts.extend(shape.meetings(&shapes[other], JOINT).into_iter().flatten());
        }
    });
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// Keeps the runs of the shape between cuts whose middle no edge covers.
fn keep_uncovered(
    shape: &Shape,
    source: Source,
    cuts: &[f64],
    edges: &[Shape],
    grid: &Grid,
    d: f64,
    kept: &mut Vec<Kept>,
) {
    let mut run: Option<(f64, f64)> = None;
    for pair in cuts.windows(2) {
        let (t0, t1) = (pair[0], pair[1]);
        if (t1 - t0) * shape.length() < 1e-4 {
            continue;
        }
        let middle = shape.at(f64::midpoint(t0, t1));
        let mut covered = false;
        grid.near((middle.0, middle.1, middle.0, middle.1), d, |edge| {
            covered = covered || edges[edge].distance(middle) < d - COVER;
        });
        run = match (run, covered) {
            (Some((start, _)), false) => Some((start, t1)),
            (None, false) => Some((t0, t1)),
            (ended, true) => {
                push_run(shape, source, ended, kept);
                None
            }
        };
    }
    push_run(shape, source, run, kept);
}

fn push_run(shape: &Shape, source: Source, run: Option<(f64, f64)>, kept: &mut Vec<Kept>) {
    if let Some((t0, t1)) = run {
        let piece = shape.part(t0, t1);
        if piece.length() > 1.0 {
            kept.push(Kept { shape: piece, source, touched: source.edge.map(|edge| edge.part(t0, t1)) });
        }
    }
}

/// Joins kept pieces end to beginning into loops and adds their areas.
fn stitch(kept: &[Kept], d: f64, part_area: f64, offset: &mut Offset) {
    let starts: Vec<Shape> =
        kept.iter().map(|piece| Shape::Line { from: piece.shape.at(0.0), to: piece.shape.at(0.0) }).collect();
    let joint = joint_width(d);
    let grid = Grid::new(&starts, joint * 4.0);
    let mut used = vec![false; kept.len()];
    let mut cut_area = 0.0;
    for first in 0..kept.len() {
        if used[first] {
            continue;
        }
        let mut chain = vec![first];
        used[first] = true;
        let begin = kept[first].shape.at(0.0);
        let closed = loop {
            let end = kept[chain[chain.len() - 1]].shape.at(1.0);
            match continuation(kept, &grid, &used, end, (chain.len() > 1).then_some(begin), joint) {
                Next::Piece(next) => {
                    used[next] = true;
                    chain.push(next);
                }
                Next::Close => break true,
                Next::Nothing => {
                    offset.loose_ends.push(end);
                    break false;
                }
            }
        };
        if closed {
            cut_area += cut_area_of(kept, &chain, d);
            push_loop(kept, &chain, offset);
        }
    }
    offset.residual_area = (cut_area - part_area).abs();
}

enum Next {
    Piece(usize),
    Close,
    Nothing,
}

/// What follows at `end`: the nearest unused beginning within a joint, or the loop's own beginning when that is nearer.
fn continuation(kept: &[Kept], grid: &Grid, used: &[bool], end: Xy, begin: Option<Xy>, joint: f64) -> Next {
    let mut best = (joint, Next::Nothing);
    grid.near((end.0, end.1, end.0, end.1), joint, |candidate| {
        let gap = norm(minus(kept[candidate].shape.at(0.0), end));
        if !used[candidate] && gap < best.0 {
            best = (gap, Next::Piece(candidate));
        }
    });
    match begin.map(|begin| norm(minus(begin, end))) {
        Some(gap) if gap <= best.0 => Next::Close,
        _ => best.1,
    }
}

/// The area on the left of the contour that the disc cuts when its centre runs along the chain: touched profile, and
/// an arc about every joint at which the path turns toward the free side.
fn cut_area_of(kept: &[Kept], chain: &[usize], d: f64) -> f64 {
    let mut contour: Vec<Shape> = Vec::new();
    for (k, &index) in chain.iter().enumerate() {
        contour.extend(kept[index].touched);
        let next = &kept[chain[(k + 1) % chain.len()]].shape;
        let joint = kept[index].shape.at(1.0);
        let (incoming, outgoing) = (kept[index].shape.direction(1.0), next.direction(0.0));
        let turned = atan2(cross(incoming, outgoing), dot(incoming, outgoing));
        if turned < 0.0 {
            let toward_part = right_of(incoming);
            let start = atan2(-toward_part.1, -toward_part.0);
            contour.push(Shape::Arc { centre: joint, radius: d, start, sweep: turned });
        }
    }
    let origin = contour.first().map_or((0.0, 0.0), |shape| shape.at(0.0));
    contour.iter().map(|shape| shape.double_area(origin) / 2.0).sum()
}

/// Rounds a chain to the lattice: joints to points, arcs fitted through them, a line where no arc fits.
fn push_loop(kept: &[Kept], chain: &[usize], offset: &mut Offset) {
    let joint = |k: usize| {
        let (before, after) = (&kept[chain[k % chain.len()]], &kept[chain[(k + 1) % chain.len()]]);
        let middle = plus(before.shape.at(1.0), minus(after.shape.at(0.0), before.shape.at(1.0)), 0.5);
        curve::nearest_point(middle.0, middle.1)
    };
    let mut curves = Vec::new();
    let mut outlines: Vec<usize> = Vec::new();
    for (k, &index) in chain.iter().enumerate() {
        let (Ok(from), Ok(to)) = (joint(k + chain.len() - 1), joint(k)) else {
            offset.loose_ends.push(kept[index].shape.at(1.0));
            return;
        };
        outlines.push(kept[index].source.outline);
        if from == to {
            continue;
        }
        let line = Curve::Line(Segment { from, to });
        curves.push(match kept[index].shape {
            Shape::Line { .. } => line,
            Shape::Arc { centre, sweep, .. } => {
                let turn = if sweep > 0.0 { Turn::Left } else { Turn::Right };
                match curve::fit_arc(from, to, centre, turn) {
                    Ok(arc) if line.length() > f64::from(shortest_arc(arc.radius()).units()) => {
                        Curve::Arc(arc)
                    }
                    Ok(_) => line,
                    Err(_) if line.length() < JOINT => line,
                    Err(_) => {
                        offset.loose_ends.push(kept[index].shape.at(1.0));
                        return;
                    }
                }
            }
        });
    }
    outlines.sort_unstable();
    outlines.dedup();
    if curves.len() > 1 {
        offset.loops.push(OffsetLoop { curves, outlines });
    }
}

/// Shapes by the cells that their boxes touch.
struct Grid {
    cell: f64,
    cells: BTreeMap<(i64, i64), Vec<usize>>,
    boxes: Vec<(f64, f64, f64, f64)>,
}

/// A shape may touch at most this many cells along one axis.
const CELLS: f64 = 1024.0;

impl Grid {
    fn new(shapes: &[Shape], reach: f64) -> Self {
        let boxes: Vec<_> = shapes.iter().map(Shape::bounds).collect();
        let span = boxes.iter().fold(0.0_f64, |span, b| span.max(b.2 - b.0).max(b.3 - b.1));
        let cell = reach.max(span / CELLS).max(1.0);
        let mut grid = Self { cell, cells: BTreeMap::new(), boxes };
        for index in 0..grid.boxes.len() {
            for key in grid.keys(grid.boxes[index], 0.0) {
                grid.cells.entry(key).or_default().push(index);
            }
        }
        grid
    }

    fn keys(&self, b: (f64, f64, f64, f64), grown: f64) -> impl Iterator<Item = (i64, i64)> + use<> {
        let index = |c: f64| curve::nearest_unit(floor(c / self.cell));
        let (x0, y0) = (index(b.0 - grown), index(b.1 - grown));
        let (x1, y1) = (index(b.2 + grown), index(b.3 + grown));
        (x0..=x1).flat_map(move |x| (y0..=y1).map(move |y| (x, y)))
    }

    /// Calls `visit` once for each shape whose box comes within `reach` of the box `b`.
    fn near(&self, b: (f64, f64, f64, f64), reach: f64, mut visit: impl FnMut(usize)) {
        let mut seen = Vec::new();
        for key in self.keys(b, reach) {
            for &index in self.cells.get(&key).map_or(&[][..], Vec::as_slice) {
                let o = self.boxes[index];
                let meets =
                    o.0 <= b.2 + reach && b.0 <= o.2 + reach && o.1 <= b.3 + reach && b.1 <= o.3 + reach;
                if meets {
                    seen.push(index);
                }
            }
        }
        seen.sort_unstable();
        seen.dedup();
        seen.into_iter().for_each(&mut visit);
    }
}

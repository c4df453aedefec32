//! Joins uncovered pieces of offset shapes into loops, and rounds the loops to the lattice.

use alloc::vec;
use alloc::vec::Vec;

use core::f64::consts::{PI, TAU};

use libm::{atan2, sqrt};

use super::plane::PlaneCurve;
use super::propose::{COVER, CutContour, Offset, OffsetLoop};
use crate::arc_view::ArcView;
use crate::curve::{self, Curve};
use crate::exact::segment::Segment;
use crate::vec2::Vec2;

/// Smallest width of a joint: nearer ends belong together (lattice units, 0.3 µm). See [`joint_width`].
const JOINT: f64 = 30.0;

/// The greatest distance between the ends of two shapes at one joint. At a concave joint of a small angle θ
/// both shapes overhang by `dθ/2` and dip below `d` by at most `dθ²/4`. If that is less than [`COVER`], both
/// overhangs stay, and their ends are `dθ < 2·√(d·COVER)` apart.
fn joint_width(d: f64) -> f64 {
    JOINT.max(6.0 * sqrt(d * COVER))
}

/// Greatest distance over which remaining ends are joined, nearest first (lattice units, 20 µm). Two shapes
/// can leave each other's cover this far apart where an arc is nearly tangent to its neighbour and its ends
/// are rounded. The certificates decide whether the path may run between them.
const WIDE_JOINT: f64 = 2_000.0;

/// A joint that turns to the left by more than half a circle without this is a dead end, radians.
const DEAD_END: f64 = 0.01;

/// A piece of an offset shape that no edge covers.
pub struct Kept {
    pub shape: PlaneCurve,
    /// The part of the profile that the disc touches from this piece. `None` at a corner.
    pub touched: Option<PlaneCurve>,
}

/// Joins uncovered pieces end to start into loops.
pub fn stitch(kept: &[Kept], d: f64, offset: &mut Offset) {
    let joint = joint_width(d);
    let starts = Starts::of(kept.iter().map(|piece| piece.shape.at(0.0)), joint);
    let mut used = vec![false; kept.len()];
    let mut open: Vec<Vec<usize>> = Vec::new();
    for first in 0..kept.len() {
        if used[first] {
            continue;
        }
        let mut chain = vec![first];
        used[first] = true;
        let begin = kept[first].shape.at(0.0);
        let closed = loop {
            let end = kept[chain[chain.len() - 1]].shape.at(1.0);
            match continuation(&starts, &used, end, (chain.len() > 1).then_some(begin), joint) {
                Next::Piece(next) => {
                    used[next] = true;
                    chain.push(next);
                }
                Next::Close => break true,
                Next::Nothing => break false,
            }
        };
        if closed {
            push_loop(kept, &chain, d, offset);
        } else {
            open.push(chain);
        }
    }
    for chain in close_wide(kept, open, offset) {
        push_loop(kept, &chain, d, offset);
    }
}

enum Next {
    Piece(usize),
    Close,
    Nothing,
}

/// Joins open chains end to start up to [`WIDE_JOINT`], nearest first. Records the remaining ends as loose.
fn close_wide(kept: &[Kept], mut open: Vec<Vec<usize>>, offset: &mut Offset) -> Vec<Vec<usize>> {
    let begin = |chain: &Vec<usize>| chain.first().map(|&first| kept[first].shape.at(0.0));
    let end = |chain: &Vec<usize>| chain.last().map(|&last| kept[last].shape.at(1.0));
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    let starts = Starts::of(open.iter().filter_map(begin), WIDE_JOINT);
    for (i, chain) in open.iter().enumerate() {
        let Some(end) = end(chain) else { continue };
        starts.near(end, |j, start| {
            let gap = start.distance(end);
            if gap <= WIDE_JOINT {
                pairs.push((gap, i, j));
            }
        });
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut next, mut taken) = (vec![usize::MAX; open.len()], vec![false; open.len()]);
    for (_, i, j) in pairs {
        if next[i] == usize::MAX && !taken[j] {
            (next[i], taken[j]) = (j, true);
        }
    }
    let mut closed = Vec::new();
    // First the chains without a predecessor. The rest form loops.
    let (after, first): (Vec<usize>, Vec<usize>) = (0..open.len()).partition(|&i| taken[i]);
    for first in first.into_iter().chain(after) {
        let (mut chain, mut at) = (Vec::new(), first);
        while at != usize::MAX && begin(&open[at]).is_some() {
            chain.append(&mut open[at]);
            at = next[at];
        }
        match at {
            _ if chain.is_empty() => {}
            usize::MAX => offset.loose_ends.extend(end(&chain)),
            _ => closed.push(chain),
        }
    }
    closed
}

/// The continuation at `end`: the nearest unused start within a joint, or the loop's own start if that is
/// nearer.
fn continuation(starts: &Starts, used: &[bool], end: Vec2, begin: Option<Vec2>, joint: f64) -> Next {
    let mut best = (joint, Next::Nothing);
    starts.near(end, |candidate, start| {
        let gap = start.distance(end);
        if !used[candidate] && gap < best.0 {
            best = (gap, Next::Piece(candidate));
        }
    });
    match begin.map(|begin| begin.distance(end)) {
        Some(gap) if gap <= best.0 => Next::Close,
        _ => best.1,
    }
}

/// The contour that the disc cuts while its centre runs along a chain. It consists of the touched profile, and
/// of an arc around every joint at which the path turns toward the free side.
fn cut_contour(kept: &[Kept], chain: &[usize], d: f64) -> CutContour {
    let mut curves: Vec<PlaneCurve> = Vec::new();
    let mut disc_arcs = 0;
    for (k, &index) in chain.iter().enumerate() {
        curves.extend(kept[index].touched);
        let next = &kept[chain[(k + 1) % chain.len()]].shape;
        let joint = kept[index].shape.at(1.0);
        let (incoming, outgoing) = (kept[index].shape.direction(1.0), next.direction(0.0));
        let turned = atan2(incoming.cross(outgoing), incoming.dot(outgoing));
        // At a dead end the path turns back, always on the free side.
        let turned = if turned > PI - DEAD_END { turned - TAU } else { turned };
        // A turn by rounding leaves no arc.
        if turned * d < -1.0 {
            disc_arcs += 1;
            let toward_part = incoming.right();
            let start = atan2(-toward_part.y, -toward_part.x);
            curves.push(PlaneCurve::Arc(ArcView { centre: joint, radius: d, start, sweep: turned }));
        }
    }
    CutContour::new(curves, disc_arcs)
}

/// Rounds a chain to the lattice: joints become points, with arcs fitted through them. A line replaces an arc
/// that is too short. A longer arc that fits no lattice centre leaves a loose end.
fn push_loop(kept: &[Kept], chain: &[usize], d: f64, offset: &mut Offset) {
    let joint = |k: usize| {
        let (before, after) = (&kept[chain[k % chain.len()]], &kept[chain[(k + 1) % chain.len()]]);
        let (end, start) = (before.shape.at(1.0), after.shape.at(0.0));
        curve::nearest_point(end + (start - end) * 0.5)
    };
    let mut curves = Vec::new();
    for (k, &index) in chain.iter().enumerate() {
        let (Ok(from), Ok(to)) = (joint(k + chain.len() - 1), joint(k)) else {
            offset.loose_ends.push(kept[index].shape.at(1.0));
            return;
        };
        if from == to {
            continue;
        }
        let line = Curve::Line(Segment { from, to });
        curves.push(match kept[index].shape {
            PlaneCurve::Line { .. } => line,
            PlaneCurve::Arc(arc) => match Curve::fitted(from, to, arc.centre, arc.turn()) {
                Ok(curve) => curve,
                Err(_) if line.length() < JOINT => line,
                Err(_) => {
                    offset.loose_ends.push(kept[index].shape.at(1.0));
                    return;
                }
            },
        });
    }
    if curves.len() > 1 {
        offset.loops.push(OffsetLoop { curves, cut: cut_contour(kept, chain, d) });
    }
}

/// The starts of the pieces, in cells as wide as a joint.
struct Starts {
    width: f64,
    /// Column and row of the cell, number of the piece, its start; ascending.
    cells: Vec<((i64, i64), usize, Vec2)>,
}

impl Starts {
    fn of(starts: impl Iterator<Item = Vec2>, width: f64) -> Self {
        let mut cells: Vec<_> =
            starts.enumerate().map(|(number, at)| (cell(at, width), number, at)).collect();
        cells.sort_unstable_by_key(|&(cell, number, _)| (cell, number));
        Self { width, cells }
    }

    /// Calls `visit` with every piece that starts within a width of `at`. It may pass other pieces too.
    fn near(&self, at: Vec2, mut visit: impl FnMut(usize, Vec2)) {
        let (column, row) = cell(at, self.width);
        for column in column - 1..=column + 1 {
            let first = self.cells.partition_point(|&(cell, ..)| cell < (column, row - 1));
            let near = self.cells[first..].iter().take_while(|&&(cell, ..)| cell <= (column, row + 1));
            near.for_each(|&(_, number, start)| visit(number, start));
        }
    }
}

fn cell(Vec2 { x, y }: Vec2, width: f64) -> (i64, i64) {
    (curve::round_down(x / width), curve::round_down(y / width))
}

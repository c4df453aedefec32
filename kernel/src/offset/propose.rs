//! Proposes offset loops. Each edge and each convex corner has an offset shape. A cutter removes the parts of
//! a shape that other edges cover. `stitch` joins the remaining pieces end to end.
//!
//! Implements SR-20.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use libm::ceil;

use super::plane::PlaneCurve;
use super::stitch::{Kept, stitch};
use super::track::{StraightWall, Track};
use crate::curve::{self, Curve};
use crate::exact::lattice::{COORD_MAX, Length};
use crate::exact::segment::{Segment, Window};
use crate::index::check::{CheckedIndex, Node, Search};
use crate::index::{Edge, build};
use crate::vec2::Vec2;

/// A closed chain of curves, with its free side.
#[derive(Clone, Debug)]
pub struct Outline {
    /// The curves in order. Each begins where the one before it ends.
    pub curves: Vec<Curve>,
    /// Whether the free side is on the left. Otherwise it is on the right. [`propose`] traverses a chain with
    /// the free side on the left backwards.
    pub free_on_left: bool,
}

impl Outline {
    /// The curves in the direction that has the free side on the right.
    pub(super) fn shapes(&self) -> Vec<PlaneCurve> {
        let shapes = self.curves.iter().map(PlaneCurve::of);
        if self.free_on_left { shapes.rev().map(PlaneCurve::reversed).collect() } else { shapes.collect() }
    }
}

/// A closed loop of the offset, in path order. The part is on the left of its direction.
#[derive(Clone, Debug)]
pub struct OffsetLoop {
    /// Lines and arcs. Each begins where the one before it ends, and the last ends where the first begins.
    pub curves: Vec<Curve>,
    /// The contour that the disc cuts on the part's side.
    pub cut: CutContour,
}

/// The contour that a disc cuts while its centre runs along a loop: the touched profile, and arcs of the disc
/// where it does not reach the profile. The part is on the left. The contour can cross itself and others, where
/// discs at distant places of a path overlap.
#[derive(Clone, Debug)]
pub struct CutContour {
    curves: Vec<PlaneCurve>,
    /// Number of its arcs that the disc leaves, and the profile does not have.
    disc_arcs: usize,
}

impl CutContour {
    pub(super) fn new(curves: Vec<PlaneCurve>, disc_arcs: usize) -> Self {
        Self { curves, disc_arcs }
    }

    /// Whether it has arcs of the disc, where rest material stays.
    #[must_use]
    pub fn has_disc_arcs(&self) -> bool {
        self.disc_arcs > 0
    }

    /// The contour of the curves of an outline, with the free side on its right.
    #[must_use]
    pub fn of(outline: &Outline) -> Self {
        Self { curves: outline.shapes(), disc_arcs: 0 }
    }

    /// Twice its signed area, in square lattice units: the integral of its winding number.
    #[must_use]
    pub fn double_area(&self) -> f64 {
        let origin = self.curves.first().map_or(Vec2::ZERO, |shape| shape.at(0.0));
        let next = self.curves.iter().cycle().skip(1);
        let areas = self.curves.iter().zip(next).map(|(shape, next)| {
            // The next curve may begin a little beside the end of this one.
            shape.double_area(origin) + (shape.at(1.0) - origin).cross(next.at(0.0) - origin)
        });
        areas.sum()
    }

    /// The number of [`CutContour::corners`].
    #[must_use]
    pub fn corner_count(&self, sagitta: f64) -> usize {
        let count =
            |curve| usize::try_from(curve::round_up(chord_count(curve, sagitta))).unwrap_or(usize::MAX);
        self.curves.iter().map(count).fold(self.curves.len(), usize::saturating_add)
    }

    /// The corners of a polygon along the contour. Its chords leave the arcs by at most `sagitta` lattice units.
    #[must_use]
    pub fn corners(&self, sagitta: f64) -> Vec<Vec2> {
        let mut corners = Vec::with_capacity(self.corner_count(sagitta));
        for curve in &self.curves {
            let count = chord_count(curve, sagitta);
            let mut k = 0.0;
            while k < count {
                corners.push(curve.at(k / count));
                k += 1.0;
            }
            corners.push(curve.at(1.0));
        }
        corners
    }
}

/// The number of equal chords of a curve with this sagitta.
fn chord_count(curve: &PlaneCurve, sagitta: f64) -> f64 {
    match curve {
        PlaneCurve::Line { .. } => 1.0,
        PlaneCurve::Arc(arc) => ceil(arc.length() / arc.chord_length(sagitta)).max(1.0),
    }
}

/// A proposed offset.
#[derive(Clone, Debug, Default)]
pub struct Offset {
    /// The loops.
    pub loops: Vec<OffsetLoop>,
    /// Ends without a continuation, in lattice units. It has an entry at the origin if an edge lies off the
    /// lattice. Do not use the proposal unless this is empty.
    pub loose_ends: Vec<Vec2>,
}

/// An edge covers the points that are nearer to it than `d − COVER` (lattice units).
pub(super) const COVER: f64 = 1e-4;
/// Subtraction drops remaining intervals of at most this length (lattice units). Joints bridge the gaps.
const LEAST: f64 = 0.5;
/// Number of neighbours on each side along the chain. The cutter subtracts them before it searches the index.
/// They cover most of the covered parts.
const NEIGHBOURS: usize = 4;
/// Most edges that the first search of the index tests. If more are near, the nearest ones come next.
const FEW: usize = 48;
/// Most nearest edges that the cutter subtracts before the full search of the index.
const NEAREST: usize = 12;

/// Proposes the loops at distance `d` (lattice units) from the outlines, on their free side.
///
/// Each edge has a shape at distance `d` beside it. Each corner that is convex to the tool has an arc around
/// it. The cutter removes the parts of a shape that lie within `d` of another edge. `stitch` joins the
/// remaining pieces end to end.
#[must_use]
pub fn propose(outlines: &[Outline], d: f64) -> Offset {
    let mut edges: Vec<PlaneCurve> = Vec::new();
    let mut chains: Vec<(usize, usize)> = Vec::new();
    for outline in outlines {
        let first = edges.len();
        edges.extend(outline.shapes());
        chains.push((first, edges.len()));
    }
    let mut offset = Offset::default();
    let Some(index) = EdgeIndex::of(&edges) else {
        offset.loose_ends.push(Vec2::ZERO);
        return offset;
    };
    let mut cutter =
        Cutter { edges: &edges, index: &index, d, open: Vec::new(), spare: Vec::new(), hint: None };
    let mut kept = Vec::new();
    for chain in chains {
        cutter.cut_chain(chain, &mut kept);
    }
    stitch(&kept, d, &mut offset);
    offset
}

/// The edges in an index. A curved edge is stored as chords. Their chord error is the
/// sagitta and an allowance for rounding.
struct EdgeIndex {
    index: CheckedIndex,
    /// The edge of each chord in the index.
    owners: Vec<u32>,
    walls: Vec<Option<StraightWall>>,
}

impl EdgeIndex {
    fn of(edges: &[PlaneCurve]) -> Option<Self> {
        let mut chords = Vec::with_capacity(edges.len());
        let mut owners = Vec::with_capacity(edges.len());
        for (owner, edge) in edges.iter().enumerate() {
            push_chords(edge, &mut chords)?;
            owners.resize(chords.len(), u32::try_from(owner).ok()?);
        }
        let index = build::build(chords).ok()?;
        Some(Self { index, owners, walls: edges.iter().map(StraightWall::of).collect() })
    }
}

/// Appends the chords of an edge. Each chord error bounds the distance between the chord and its part of the
/// edge. Returns `None` if a point lies off the lattice.
fn push_chords(edge: &PlaneCurve, chords: &mut Vec<Edge>) -> Option<()> {
    let point = |t: f64| curve::nearest_point(edge.at(t)).ok();
    let (count, sagitta) = match *edge {
        PlaneCurve::Line { .. } => (1.0, 0.0),
        PlaneCurve::Arc(arc) => {
            let count = ceil(arc.sweep.abs() * 4.0).max(1.0);
            (count, arc.sagitta(count))
        }
    };
    let chord_error = Length::from_units(curve::round_up(sagitta) + 2).ok()?;
    let mut k = 0.0;
    while k < count {
        chords.push(Edge {
            chord: Segment { from: point(k / count)?, to: point((k + 1.0) / count)? },
            chord_error,
        });
        k += 1.0;
    }
    Some(())
}

/// Removes the covered parts of shapes.
struct Cutter<'a> {
    edges: &'a [PlaneCurve],
    index: &'a EdgeIndex,
    d: f64,
    /// Intervals of the current track that no edge has covered so far, ascending.
    open: Vec<(f64, f64)>,
    spare: Vec<(f64, f64)>,
    hint: Option<usize>,
}

impl Cutter<'_> {
    /// Collects the uncovered pieces of a chain's offset shapes: one shape beside each edge, and one around
    /// each corner convex to the tool.
    fn cut_chain(&mut self, (first, end): (usize, usize), kept: &mut Vec<Kept>) {
        for i in first..end {
            let edge = self.edges[i];
            let next = if i + 1 == end { first } else { i + 1 };
            if let Some(shape) = edge.offset_right(self.d) {
                self.cut(&shape, (first, end), (i, i));
                self.keep(&shape, Some(edge), kept);
            }
            if let Some(corner) = edge.corner_right(&self.edges[next], self.d) {
                self.cut(&corner, (first, end), (i, next));
                self.keep(&corner, None, kept);
            }
        }
    }

    /// Leaves the uncovered intervals of the shape in `open`. The shape belongs to the edges `own` of a
    /// chain.
    fn cut(&mut self, shape: &PlaneCurve, (first, end): (usize, usize), own: (usize, usize)) {
        let track = Track::of(shape);
        self.open.clear();
        self.open.push((0.0, track.end()));
        let count = end - first;
        for step in 1..=NEIGHBOURS.min(count - 1) {
            let before = first + (own.0 - first + count - step) % count;
            let after = first + (own.1 - first + step) % count;
            for neighbour in [before, after] {
                self.subtract(&track, neighbour);
                if self.open.is_empty() {
                    return;
                }
            }
        }
        if self.search(track, FEW) || self.open.is_empty() {
            return;
        }
        // Many edges are near. Subtract the nearest ones before the full search.
        for _ in 0..NEAREST {
            let Some(&(p, q)) = self.open.first() else { return };
            let Ok(middle) = curve::nearest_point(track.at(f64::midpoint(p, q))) else { break };
            self.hint = self.index.index.nearest(middle, self.hint).map(|nearest| nearest.edge);
            let owner = self.hint.and_then(|hint| self.index.owners.get(hint));
            if !owner.is_some_and(|&owner| self.subtract(&track, owner as usize)) {
                break;
            }
        }
        self.search(track, usize::MAX);
    }

    /// Subtracts the edges that cover the track. Tests at most `at_most` edges. Returns `false` if the search
    /// stopped early: at this limit, or because no interval is open.
    fn search(&mut self, track: Track, at_most: usize) -> bool {
        let index = &self.index.index;
        let window = self.window(&track);
        index.search(&mut Cover { window, track, cutter: self, last: u32::MAX, left: at_most }).is_continue()
    }

    /// Subtracts the part that the edge covers. Returns whether the edge covered part of an open interval.
    fn subtract(&mut self, track: &Track, edge: usize) -> bool {
        let r = self.d - COVER;
        let (open, spare) = (&mut self.open, &mut self.spare);
        let mut cut = false;
        let covered = |low: f64, high: f64| {
            if !open.iter().any(|&(a, b)| a < high && low < b) {
                return;
            }
            cut = true;
            spare.clear();
            for &(a, b) in open.iter() {
                if b <= low || high <= a {
                    spare.push((a, b));
                    continue;
                }
                let parts = [(a, low), (high, b)].into_iter();
                spare.extend(parts.filter(|&(p, q)| p < q && track.length_between(p, q) > LEAST));
            }
            core::mem::swap(open, spare);
        };
        match self.index.walls.get(edge) {
            Some(Some(wall)) => track.covered_by_wall(wall, r, covered),
            _ => track.covered_by(&self.edges[edge], r, covered),
        }
        cut
    }

    /// A box that meets every edge that can cover an open interval of the track. Empty if no interval is
    /// open.
    fn window(&self, track: &Track) -> Window {
        let (Some(first), Some(last)) = (self.open.first(), self.open.last()) else {
            return Window::from_corners(1, 1, 0, 0);
        };
        let (x0, y0, x1, y1) = track.bounds(first.0, last.1);
        let limit = f64::from(COORD_MAX) * 2.0;
        let unit = |c: f64| c.clamp(-limit, limit);
        let down = |c: f64| i32::try_from(curve::round_down(unit(c))).unwrap_or(i32::MIN);
        let up = |c: f64| i32::try_from(curve::round_up(unit(c))).unwrap_or(i32::MAX);
        let r = self.d + 1.0;
        Window::from_corners(down(x0 - r), down(y0 - r), up(x1 + r), up(y1 + r))
    }

    fn keep(&self, shape: &PlaneCurve, edge: Option<PlaneCurve>, kept: &mut Vec<Kept>) {
        let track = Track::of(shape);
        for &(p, q) in &self.open {
            let (from, to) = (track.share(p), track.share(q));
            let piece = shape.part(from, to);
            if piece.length() > 1.0 {
                kept.push(Kept { shape: piece, touched: edge.map(|edge| edge.part(from, to)) });
            }
        }
    }
}

/// A search for the edges that cover the open intervals of a track.
struct Cover<'a, 'b> {
    window: Window,
    track: Track,
    cutter: &'a mut Cutter<'b>,
    last: u32,
    left: usize,
}

impl Search for Cover<'_, '_> {
    #[inline(always)]
    fn enter(&mut self, node: &Node) -> u8 {
        node.meeting(self.window)
    }

    #[inline(always)]
    fn edge(&mut self, index: usize, edge: &Edge) -> ControlFlow<()> {
        let Some(&owner) = self.cutter.index.owners.get(index) else { return ControlFlow::Continue(()) };
        if owner == self.last || !edge.bounds().meets(self.window) {
            return ControlFlow::Continue(());
        }
        self.last = owner;
        if self.left == 0 {
            return ControlFlow::Break(());
        }
        self.left -= 1;
        if self.cutter.subtract(&self.track, owner as usize) {
            if self.cutter.open.is_empty() {
                return ControlFlow::Break(());
            }
            self.window = self.cutter.window(&self.track);
        }
        ControlFlow::Continue(())
    }
}

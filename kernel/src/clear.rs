//! Clear queries: is a point, a motion or a fan farther from the part than the threshold?
//!
//! A [`FreePoint`] is a point already known to be clear and on the free side. A motion or fan that starts at free
//! points and comes nearer to no edge than the threshold can not have changed sides, so only edges are asked: the
//! induction is carried by the type.

use alloc::vec::Vec;
use core::fmt;
use core::ops::ControlFlow;

use crate::exact::arc::Arc;
use crate::exact::convex::Convex;
use crate::exact::lattice::{Length, Point};
use crate::exact::predicate::Proximity;
use crate::exact::region::{Location, Region};
use crate::exact::ring::Ring;
use crate::exact::segment::{Segment, Triangle, Window};
use crate::exact::swept_arc::SweptArc;
use crate::index::cells::Answer;
use crate::index::{CellFault, Cells, CheckedIndex, Edge, IndexFault, build, subdivide};

/// Which side of the profile the tool works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// External machining: the part is inside the profile, the tool stays outside.
    Outside,
    /// Internal machining: the part is outside the profile, the tool stays inside.
    Inside,
}

/// A point that was found clear of a region at a threshold, on its free side.
///
/// Use it only with the [`ProhibitedRegion`] that made it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FreePoint {
    point: Point,
    threshold: Length,
}

impl FreePoint {
    /// The point.
    #[must_use]
    pub fn point(self) -> Point {
        self.point
    }

    /// The threshold at which it is clear.
    #[must_use]
    pub fn threshold(self) -> Length {
        self.threshold
    }

    /// The same point, claimed at a threshold that is not higher.
    #[must_use]
    pub fn lowered(self, threshold: Length) -> Option<Self> {
        (threshold <= self.threshold).then_some(Self { threshold, ..self })
    }

    /// The end of a motion from here that was found clear at this threshold: the caller vouches for that.
    pub(crate) fn moved(self, point: Point) -> Self {
        Self { point, ..self }
    }
}

/// Why a query is answered "no".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocked {
    /// An edge of the part is at the threshold or nearer.
    ByEdge(Edge),
    /// The point is on the part's side of the profile.
    OnPartSide(Point),
    /// The starting point was certified at a lower threshold only.
    StartTooNear(Point),
}

impl fmt::Display for Blocked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ByEdge(edge) => {
                write!(f, "too near the edge from {} to {}", edge.chord.from, edge.chord.to)
            }
            Self::OnPartSide(at) => write!(f, "{at} is inside the part"),
            Self::StartTooNear(at) => write!(f, "the start {at} is nearer than the threshold"),
        }
    }
}

impl core::error::Error for Blocked {}

/// The part, seen from the tool: a region, the side of it that is prohibited, and the queries.
///
/// Distances are to the true curves: each edge is asked with the threshold plus its chord_error. No query allocates.
#[derive(Clone, Debug)]
pub struct ProhibitedRegion {
    region: Region,
    zones: Vec<Ring>,
    /// The edges of each zone.
    fences: Vec<CheckedIndex>,
    index: CheckedIndex,
    cells: Vec<Cells>,
    side: Side,
}

impl ProhibitedRegion {
    /// The part bounded by `region`, to be machined from `side`; builds and checks the clearance index.
    ///
    /// # Errors
    /// [`IndexFault::TooManyEdges`] above 2^30 edges.
    pub fn new(region: Region, side: Side) -> Result<Self, IndexFault> {
        Self::with_zones(region, side, Vec::new())
    }

    /// As [`ProhibitedRegion::new`], with zones that are prohibited too, each all that is within its ring: clamps, a vice.
    /// Zones may lie on the part and on each other.
    ///
    /// # Errors
    /// [`IndexFault::TooManyEdges`] above 2^30 edges.
    pub fn with_zones(region: Region, side: Side, zones: Vec<Ring>) -> Result<Self, IndexFault> {
        let mut edges = build::edges_of(&region);
        edges.extend(build::edges_of_rings(&zones));
        let index = build::build(edges)?;
        let fences =
            zones.iter().map(|zone| build::build(build::edges_of_rings(core::slice::from_ref(zone))));
        let fences = fences.collect::<Result<_, _>>()?;
        Ok(Self { region, zones, fences, index, cells: Vec::new(), side })
    }

    /// The same part asked by another index over edges that cover its own.
    pub(crate) fn with_index(&self, index: CheckedIndex) -> Self {
        Self {
            region: self.region.clone(),
            zones: self.zones.clone(),
            fences: self.fences.clone(),
            index,
            cells: Vec::new(),
            side: self.side,
        }
    }

    /// Builds and checks cells for `threshold`, so that points and short motions are answered faster at exactly that
    /// threshold. Answers stay the same.
    ///
    /// # Errors
    /// [`CellFault::Whole`] when what is near the part at that threshold does not fit the lattice.
    pub fn prepare(&mut self, threshold: Length) -> Result<(), CellFault> {
        if self.cells_for(threshold).is_none() {
            self.cells.push(subdivide::build(&self.index, threshold, None)?);
        }
        Ok(())
    }

    /// The cells made for `threshold`, if any.
    #[must_use]
    #[inline]
    pub fn cells_for(&self, threshold: Length) -> Option<&Cells> {
        self.cells.iter().find(|cells| cells.threshold() == threshold)
    }

    /// The region.
    #[must_use]
    pub fn region(&self) -> &Region {
        &self.region
    }

    /// The zones that are prohibited besides the part.
    #[must_use]
    pub fn zones(&self) -> &[Ring] {
        &self.zones
    }

    /// The clearance index.
    #[must_use]
    pub fn index(&self) -> &CheckedIndex {
        &self.index
    }

    /// The side the tool works on.
    #[must_use]
    pub fn side(&self) -> Side {
        self.side
    }

    /// The edges with their slacks.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        self.index.edges()
    }

    /// Whether `point` is on the part's side of the profile, in a zone, or on the outline of either.
    ///
    /// A ray from a point outside all zones crosses the outline of each an even number of times: the number of its crossings
    /// with all edges is odd when that with the profile is.
    #[must_use]
    pub fn holds(&self, point: Point) -> bool {
        if self.fences.iter().any(|fence| fence.locate(point) != Location::Outside) {
            return true;
        }
        match (self.index.locate(point), self.side) {
            (Location::Boundary, _) => true,
            (Location::Inside, side) => side == Side::Outside,
            (Location::Outside, side) => side == Side::Inside,
        }
    }

    /// Whether every edge is farther than `threshold` from `point`, whichever side it is on.
    #[must_use]
    #[inline]
    pub fn point_clear(&self, point: Point, threshold: Length) -> Proximity {
        match self.cells_for(threshold).map_or(Answer::Unknown, |cells| cells.point(&self.index, point)) {
            Answer::Clear => Proximity::Clear,
            Answer::Near(_) => Proximity::Near,
            Answer::Unknown => Proximity::near_if(self.index.near_point(point, threshold).is_some()),
        }
    }

    /// Whether every edge is farther than `threshold` from the whole motion, whichever side it is on.
    #[must_use]
    #[inline]
    pub fn motion_clear(&self, motion: Segment, threshold: Length) -> Proximity {
        Proximity::near_if(self.edges_clear(motion, threshold).is_err())
    }

    /// Certifies that `point` is farther than `threshold` from the part and outside it.
    ///
    /// # Errors
    /// [`Blocked`] by the first edge found, or because the point is on the part's side.
    pub fn free_point(&self, point: Point, threshold: Length) -> Result<FreePoint, Blocked> {
        if let Some(edge) = self.index.near_point(point, threshold) {
            return Err(Blocked::ByEdge(*edge));
        }
        if self.holds(point) { Err(Blocked::OnPartSide(point)) } else { Ok(FreePoint { point, threshold }) }
    }

    /// Certifies that the straight motion from a free point to `to` stays clear at that point's threshold.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way.
    #[inline]
    pub fn motion(&self, from: FreePoint, to: Point) -> Result<FreePoint, Blocked> {
        self.edges_clear(Segment { from: from.point, to }, from.threshold)?;
        Ok(FreePoint { point: to, threshold: from.threshold })
    }

    /// Certifies that the curve of an arc that begins at a free point stays clear at that point's threshold.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way, or not proven to be out of it.
    pub fn arc(&self, from: FreePoint, arc: &Arc) -> Result<FreePoint, Blocked> {
        let threshold = from.threshold;
        let Some(swept) = SweptArc::of(arc).filter(|_| arc.from() == from.point) else {
            return Err(Blocked::StartTooNear(from.point));
        };
        let mut near = None;
        let _ = self.index.visit(swept.bounds().grown(threshold), |_, edge| {
            let reach = threshold.plus(edge.chord_error);
            if reach.is_ok_and(|reach| swept.near_chord(edge.chord, reach).is_clear()) {
                return ControlFlow::Continue(());
            }
            near = Some(*edge);
            ControlFlow::Break(())
        });
        let end = FreePoint { point: arc.to(), threshold };
        near.map_or(Ok(end), |edge| Err(Blocked::ByEdge(edge)))
    }

    /// Certifies the fan from the in-flight motion `a b` to the new target `to`: the whole filled triangle is clear.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way; [`Blocked::StartTooNear`] when the ends carry different thresholds.
    pub fn fan(&self, a: FreePoint, b: FreePoint, to: Point) -> Result<FreePoint, Blocked> {
        if a.threshold != b.threshold {
            return Err(Blocked::StartTooNear(if a.threshold < b.threshold { a.point } else { b.point }));
        }
        if a.point == b.point {
            return self.motion(a, to);
        }
        let fan = Triangle { corners: [a.point, b.point, to] };
        match self.index.near_fan(fan, a.threshold) {
            Some(edge) => Err(Blocked::ByEdge(*edge)),
            None => Ok(FreePoint { point: to, threshold: a.threshold }),
        }
    }

    /// Certifies that the whole filled polygon, which holds the free point `from` and `to`, is clear at that point's threshold. As
    /// the straight way between the two lies in it, `to` is on the free side too.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way; [`Blocked::StartTooNear`] when the polygon does not hold both points.
    pub fn polygon(&self, from: FreePoint, polygon: Convex<'_>, to: Point) -> Result<FreePoint, Blocked> {
        if !polygon.holds(from.point) || !polygon.holds(to) {
            return Err(Blocked::StartTooNear(from.point));
        }
        match self.index.near_convex(polygon, from.threshold) {
            Some(edge) => Err(Blocked::ByEdge(*edge)),
            None => Ok(FreePoint { point: to, threshold: from.threshold }),
        }
    }

    /// Certifies a way out: from a point that is clear only at a lower threshold, the straight motion to `to` comes
    /// nearer to no edge that is, or comes, within `threshold`. What the tool does not touch it does not touch on the way.
    ///
    /// The distance to a chord never falls on such a motion, so it crosses none and ends on the free side; the answer is a
    /// free point at the threshold of `from`.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge that the motion approaches.
    pub fn retract(&self, from: FreePoint, to: Point, threshold: Length) -> Result<FreePoint, Blocked> {
        match self.index.approached(Segment { from: from.point, to }, threshold.max(from.threshold)) {
            Some(edge) => Err(Blocked::ByEdge(*edge)),
            None => Ok(FreePoint { point: to, threshold: from.threshold }),
        }
    }

    /// A certified lower bound on the distance of `point` to the part's edges, within two units of it; `None` when the
    /// point is on an edge or within its chord_error.
    #[must_use]
    pub fn clearance(&self, point: Point) -> Option<Length> {
        self.index.clearance(point)
    }

    /// Whether every edge is farther than `threshold` from the whole motion, whichever side it is on.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way.
    #[inline]
    pub fn edges_clear(&self, motion: Segment, threshold: Length) -> Result<(), Blocked> {
        let known =
            self.cells_for(threshold).map_or(Answer::Unknown, |cells| cells.motion(&self.index, motion));
        let by_index = || self.index.near_motion(motion, threshold);
        let near = match known {
            Answer::Clear => None,
            Answer::Near(number) => {
                let named = usize::try_from(number).ok().and_then(|number| self.edges().get(number));
                named.or_else(by_index)
            }
            Answer::Unknown => by_index(),
        };
        near.map_or(Ok(()), |edge| Err(Blocked::ByEdge(*edge)))
    }

    /// The edges that can come within `threshold` of `window`.
    pub fn edges_near(&self, window: Window, threshold: Length, mut visit: impl FnMut(&Edge)) {
        let _ = self.index.visit(window.grown(threshold), |_, edge| {
            visit(edge);
            ControlFlow::Continue(())
        });
    }
}

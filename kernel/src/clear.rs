//! Clear queries: whether a point, a motion or a swept triangle is farther from the part than a threshold.
//!
//! Implements SR-02, SR-04, SR-06, SR-14.
//!
//! A [`FreePoint`] is a point that is certified clear and on the free side. Take a motion or swept triangle
//! that starts at free points and keeps farther than the threshold from every edge. It cannot change sides.
//! So these queries test only edges, and the type carries the induction.

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

/// The side of the profile on which the tool works.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// External machining: the part is inside the profile and the tool stays outside.
    Outside,
    /// Internal machining: the part is outside the profile and the tool stays inside.
    Inside,
}

/// A point that is certified clear of a region at a threshold, on its free side.
///
/// Use it only with the [`ProhibitedRegion`] that made it, or with the levels above that region: what is clear
/// of a level is clear of every level above it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FreePoint {
    point: Point,
    threshold: Length,
    level: u16,
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

    /// The level at which it is clear, counted from the top: [`ProhibitedRegion::level`].
    #[must_use]
    pub fn level(self) -> u16 {
        self.level
    }

    /// The same point at a threshold that is not higher; `None` for a higher one.
    #[must_use]
    pub fn lowered(self, threshold: Length) -> Option<Self> {
        (threshold <= self.threshold).then_some(Self { threshold, ..self })
    }
}

/// Why a query fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocked {
    /// An edge of the part or of a keep-out zone is at the threshold or nearer.
    ByEdge(Edge),
    /// The point is on the part's side of the profile, or in a keep-out zone.
    OnPartSide(Point),
    /// The start has no certificate for this query. It may be certified at another threshold or a higher
    /// level, or it is not the start of the arc or inside the polygon.
    StartTooNear(Point),
}

impl fmt::Display for Blocked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ByEdge(edge) => {
                write!(f, "too near the edge from {} to {}", edge.chord.from, edge.chord.to)
            }
            Self::OnPartSide(at) => write!(f, "{at} is inside the part"),
            Self::StartTooNear(at) => write!(f, "the start {at} is not certified at this clearance"),
        }
    }
}

impl core::error::Error for Blocked {}

/// The prohibited region: a region, its prohibited side, keep-out zones, and the queries.
///
/// Distances refer to the true curves: each query adds the chord error of an edge to the threshold. No query
/// allocates.
#[derive(Clone, Debug)]
pub struct ProhibitedRegion {
    region: Region,
    zones: Vec<Ring>,
    /// The edges of each keep-out zone.
    fences: Vec<CheckedIndex>,
    index: CheckedIndex,
    cells: Vec<Cells>,
    side: Side,
    /// Its number among levels, counted from the top.
    level: u16,
}

impl ProhibitedRegion {
    /// The part bounded by `region`, machined from `side`. Builds and checks the clearance index.
    ///
    /// # Errors
    /// [`IndexFault::TooManyEdges`] above 2^30 edges.
    pub fn new(region: Region, side: Side) -> Result<Self, IndexFault> {
        Self::with_zones(region, side, Vec::new())
    }

    /// As [`ProhibitedRegion::new`], with keep-out zones such as clamps or a vice. Everything inside the ring
    /// of a zone is prohibited. Zones may overlap the part and each other.
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
        Ok(Self { region, zones, fences, index, cells: Vec::new(), side, level: 0 })
    }

    /// The same region as the level of this number.
    pub(crate) fn numbered(self, level: u16) -> Self {
        Self { level, ..self }
    }

    /// The same part with another index, whose edges cover the edges of this one.
    pub(crate) fn with_index(&self, index: CheckedIndex) -> Self {
        Self {
            region: self.region.clone(),
            zones: self.zones.clone(),
            fences: self.fences.clone(),
            index,
            cells: Vec::new(),
            side: self.side,
            level: self.level,
        }
    }

    /// Builds and checks cells for `threshold`. Queries about points and short motions at exactly that
    /// threshold become faster. Answers stay the same.
    ///
    /// # Errors
    /// [`CellFault::Whole`] when the edges, grown by the threshold, are too wide for the cells.
    pub fn prepare(&mut self, threshold: Length) -> Result<(), CellFault> {
        if self.cells_for(threshold).is_none() {
            self.cells.push(subdivide::build(&self.index, threshold, None)?);
        }
        Ok(())
    }

    /// The cells for `threshold`, if [`ProhibitedRegion::prepare`] has built them.
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

    /// The keep-out zones.
    #[must_use]
    pub fn zones(&self) -> &[Ring] {
        &self.zones
    }

    /// The clearance index.
    #[must_use]
    pub fn index(&self) -> &CheckedIndex {
        &self.index
    }

    /// The side on which the tool works.
    #[must_use]
    pub fn side(&self) -> Side {
        self.side
    }

    /// Its number among [`Levels`](crate::Levels), counted from the top. A region alone is number 0.
    #[must_use]
    pub fn level(&self) -> u16 {
        self.level
    }

    /// The edges of the part and of the keep-out zones, with their chord errors.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        self.index.edges()
    }

    /// Whether `point` is on the part's side of the profile, in a keep-out zone, or on the outline of either.
    ///
    /// A ray from a point outside all zones crosses the outline of each zone an even number of times. So its
    /// number of crossings with all edges is odd exactly when its number of crossings with the profile is
    /// odd.
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

    /// Whether every edge is farther than `threshold` from `point`. The side does not matter.
    #[must_use]
    #[inline]
    pub fn point_clear(&self, point: Point, threshold: Length) -> Proximity {
        match self.cells_for(threshold).map_or(Answer::Unknown, |cells| cells.point(&self.index, point)) {
            Answer::Clear => Proximity::Clear,
            Answer::Near(_) => Proximity::Near,
            Answer::Unknown => Proximity::near_if(self.index.near_point(point, threshold).is_some()),
        }
    }

    /// Whether every edge is farther than `threshold` from the whole motion. The side does not matter.
    #[must_use]
    #[inline]
    pub fn motion_clear(&self, motion: Segment, threshold: Length) -> Proximity {
        Proximity::near_if(self.edges_clear(motion, threshold).is_err())
    }

    /// Certifies that `point` is farther than `threshold` from the part and outside it.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with the first edge found, or [`Blocked::OnPartSide`].
    pub fn free_point(&self, point: Point, threshold: Length) -> Result<FreePoint, Blocked> {
        if let Some(edge) = self.index.near_point(point, threshold) {
            return Err(Blocked::ByEdge(*edge));
        }
        if self.holds(point) { Err(Blocked::OnPartSide(point)) } else { Ok(self.free(point, threshold)) }
    }

    fn free(&self, point: Point, threshold: Length) -> FreePoint {
        FreePoint { point, threshold, level: self.level }
    }

    /// The certificate of a free point, if it is one of this level or of a level below.
    #[inline]
    fn certified(&self, from: FreePoint) -> Result<FreePoint, Blocked> {
        if from.level < self.level { Err(Blocked::StartTooNear(from.point)) } else { Ok(from) }
    }

    /// Certifies that the straight motion from a free point to `to` stays clear at that point's threshold.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way.
    #[inline]
    pub fn motion(&self, from: FreePoint, to: Point) -> Result<FreePoint, Blocked> {
        let from = self.certified(from)?;
        self.edges_clear(Segment { from: from.point, to }, from.threshold)?;
        Ok(self.free(to, from.threshold))
    }

    /// Certifies that the curve of an arc that begins at a free point stays clear at that point's threshold.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way, or with one that the test cannot prove clear.
    /// [`Blocked::StartTooNear`] when the arc does not begin at the free point, or is too small to be cut
    /// into pieces.
    pub fn arc(&self, from: FreePoint, arc: &Arc) -> Result<FreePoint, Blocked> {
        let threshold = self.certified(from)?.threshold;
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
        near.map_or(Ok(self.free(arc.to(), threshold)), |edge| Err(Blocked::ByEdge(edge)))
    }

    /// Certifies the triangle that the tool can sweep when a machine on the motion `a b` takes the new target
    /// `to`. The whole filled triangle is clear.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way. [`Blocked::StartTooNear`] when the two ends have
    /// different thresholds.
    pub fn swept_triangle(&self, a: FreePoint, b: FreePoint, to: Point) -> Result<FreePoint, Blocked> {
        if a.threshold != b.threshold {
            return Err(Blocked::StartTooNear(if a.threshold < b.threshold { a.point } else { b.point }));
        }
        let (a, b) = (self.certified(a)?, self.certified(b)?);
        if a.point == b.point {
            return self.motion(a, to);
        }
        let triangle = Triangle { corners: [a.point, b.point, to] };
        match self.index.near_triangle(triangle, a.threshold) {
            Some(edge) => Err(Blocked::ByEdge(*edge)),
            None => Ok(self.free(to, a.threshold)),
        }
    }

    /// Certifies that the whole filled polygon is clear at the threshold of `from`. The polygon holds the
    /// free point `from` and the point `to`. So it holds the straight motion between them, and `to` is on the
    /// free side too.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way. [`Blocked::StartTooNear`] when the polygon does not hold
    /// both points.
    pub fn polygon(&self, from: FreePoint, polygon: Convex<'_>, to: Point) -> Result<FreePoint, Blocked> {
        let from = self.certified(from)?;
        if !polygon.holds(from.point) || !polygon.holds(to) {
            return Err(Blocked::StartTooNear(from.point));
        }
        match self.index.near_convex(polygon, from.threshold) {
            Some(edge) => Err(Blocked::ByEdge(*edge)),
            None => Ok(self.free(to, from.threshold)),
        }
    }

    /// Certifies a retract move: a straight motion to `to` from a point that is clear only at a lower
    /// threshold. Each edge within `threshold` of the motion must not come nearer during the motion.
    ///
    /// The distance to such a chord never falls, so the motion crosses no chord and ends on the free side. If
    /// the tool does not touch the part at the start, it does not touch it on the motion. The answer is a
    /// free point at the threshold of `from`.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge that the motion approaches.
    pub fn retract(&self, from: FreePoint, to: Point, threshold: Length) -> Result<FreePoint, Blocked> {
        let from = self.certified(from)?;
        match self.index.approached(Segment { from: from.point, to }, threshold.max(from.threshold)) {
            Some(edge) => Err(Blocked::ByEdge(*edge)),
            None => Ok(self.free(to, from.threshold)),
        }
    }

    /// A certified lower bound on the distance of `point` to the part's edges, within two units of it.
    /// Returns `None` when the point is on an edge or within its chord error.
    #[must_use]
    pub fn clearance(&self, point: Point) -> Option<Length> {
        self.index.clearance(point)
    }

    /// Checks that every edge is farther than `threshold` from the whole motion. The side does not matter.
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

    /// Calls `visit` with every edge that can come within `threshold` of `window`. It may pass other edges
    /// too.
    pub fn edges_near(&self, window: Window, threshold: Length, mut visit: impl FnMut(&Edge)) {
        let _ = self.index.visit(window.grown(threshold), |_, edge| {
            visit(edge);
            ControlFlow::Continue(())
        });
    }
}

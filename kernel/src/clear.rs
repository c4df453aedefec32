//! Clear queries: is a point, a motion or a fan farther from the part than the threshold?
//!
//! A [`FreePoint`] is a point already known to be clear and on the free side. A motion or fan that starts at free
//! points and comes nearer to no edge than the threshold can not have changed sides, so only edges are asked: the
//! induction is carried by the type.

use core::fmt;
use core::ops::ControlFlow;

use crate::exact::lattice::{Length, Point};
use crate::exact::region::{Location, Region};
use crate::exact::segment::{Segment, Triangle, Window};
use crate::index::{Edge, EdgeRuns, EdgeSource};

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
        let mm = |units: i32| f64::from(units) / f64::from(crate::UNITS_PER_MM);
        match self {
            Self::ByEdge(edge) => {
                let (a, b) = (edge.chord.from, edge.chord.to);
                write!(
                    f,
                    "too near the edge from ({:.3}, {:.3}) to ({:.3}, {:.3}) mm",
                    mm(a.x.units()),
                    mm(a.y.units()),
                    mm(b.x.units()),
                    mm(b.y.units())
                )
            }
            Self::OnPartSide(at) => {
                write!(f, "({:.3}, {:.3}) mm is inside the part", mm(at.x.units()), mm(at.y.units()))
            }
            Self::StartTooNear(at) => {
                write!(
                    f,
                    "the start ({:.3}, {:.3}) mm is nearer than the threshold",
                    mm(at.x.units()),
                    mm(at.y.units())
                )
            }
        }
    }
}

impl core::error::Error for Blocked {}

/// The part, seen from the tool: a region, the side of it that is prohibited, and the queries.
///
/// Distances are to the true curves: each edge is asked with the threshold plus its slack.
#[derive(Clone, Debug)]
pub struct ProhibitedRegion {
    region: Region,
    edges: EdgeRuns,
    side: Side,
}

impl ProhibitedRegion {
    /// The part bounded by `region`, to be machined from `side`.
    #[must_use]
    pub fn new(region: Region, side: Side) -> Self {
        let edges = EdgeRuns::of(&region);
        Self { region, edges, side }
    }

    /// The region.
    #[must_use]
    pub fn region(&self) -> &Region {
        &self.region
    }

    /// The side the tool works on.
    #[must_use]
    pub fn side(&self) -> Side {
        self.side
    }

    /// The edges with their slacks.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        self.edges.edges()
    }

    /// Whether `point` is on the part's side of the profile, or on the profile.
    #[must_use]
    pub fn holds(&self, point: Point) -> bool {
        match (self.region.locate(point), self.side) {
            (Location::Boundary, _) => true,
            (Location::Inside, side) => side == Side::Outside,
            (Location::Outside, side) => side == Side::Inside,
        }
    }

    /// Certifies that `point` is farther than `threshold` from the part and outside it.
    ///
    /// # Errors
    /// [`Blocked`] by the first edge found, or because the point is on the part's side.
    pub fn free_point(&self, point: Point, threshold: Length) -> Result<FreePoint, Blocked> {
        self.ask(Window::of(point), threshold, |edge, r| edge.chord.near_point(point, r).is_clear())?;
        if self.holds(point) { Err(Blocked::OnPartSide(point)) } else { Ok(FreePoint { point, threshold }) }
    }

    /// Certifies that the straight motion from a free point to `to` stays clear at that point's threshold.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way.
    pub fn motion(&self, from: FreePoint, to: Point) -> Result<FreePoint, Blocked> {
        self.edges_clear(Segment { from: from.point, to }, from.threshold)?;
        Ok(FreePoint { point: to, threshold: from.threshold })
    }

    /// Certifies the fan from the in-flight motion `a b` to the new target `to`: the whole filled triangle is clear.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way; [`Blocked::StartTooNear`] when the ends carry different thresholds.
    pub fn fan(&self, a: FreePoint, b: FreePoint, to: Point) -> Result<FreePoint, Blocked> {
        if a.threshold != b.threshold {
            return Err(Blocked::StartTooNear(if a.threshold < b.threshold { a.point } else { b.point }));
        }
        let fan = Triangle { corners: [a.point, b.point, to] };
        self.ask(fan.bounds(), a.threshold, |edge, r| fan.near_segment(edge.chord, r).is_clear())?;
        Ok(FreePoint { point: to, threshold: a.threshold })
    }

    /// Whether every edge is farther than `threshold` from the whole motion, whichever side it is on.
    ///
    /// # Errors
    /// [`Blocked::ByEdge`] with an edge in the way.
    pub fn edges_clear(&self, motion: Segment, threshold: Length) -> Result<(), Blocked> {
        self.ask(motion.bounds(), threshold, |edge, r| motion.near_segment(edge.chord, r).is_clear())
    }

    /// The edges that can come within `threshold` of `window`.
    pub fn edges_near(&self, window: Window, threshold: Length, mut visit: impl FnMut(&Edge)) {
        let _ = self.edges.visit(window.grown(threshold), &mut |edge| {
            visit(edge);
            ControlFlow::Continue(())
        });
    }

    fn ask(
        &self,
        bounds: Window,
        threshold: Length,
        clear: impl Fn(&Edge, Length) -> bool,
    ) -> Result<(), Blocked> {
        let mut blocked = None;
        let _ = self.edges.visit(bounds.grown(threshold), &mut |edge| {
            if clear(edge, threshold.saturating_plus(edge.slack)) {
                ControlFlow::Continue(())
            } else {
                blocked = Some(Blocked::ByEdge(*edge));
                ControlFlow::Break(())
            }
        });
        blocked.map_or(Ok(()), Err)
    }
}

//! Geometry of a part for the alignment: its straight edges and its box.

use keepout_kernel::{Curve, UNITS_PER_MM};

use super::AlignmentError;
use crate::profile::{MachinedSide, Profile, ProfileError};
use crate::select::ContourPolygon;
use crate::units::point_mm;
use crate::{Box2, Mm2};

/// Straight edge of the part, drawing coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightEdge {
    /// First end.
    pub from_mm: Mm2,
    /// Second end.
    pub to_mm: Mm2,
    /// Unit normal, away from the part.
    pub outward: Mm2,
}

/// Straight edges of a part, and the box around it.
#[derive(Clone, Debug, PartialEq)]
pub struct PartEdges {
    edges: Vec<StraightEdge>,
    bounds: Box2,
}

/// Least length of an edge for probing, mm.
const EDGE_MIN_MM: f64 = 0.5;
/// Largest offset between two edges that count as one line for probing, mm.
const ONE_LINE_MM: f64 = 0.001;
/// The nearest edge is unambiguous when every other edge is this many times farther from the given place,
/// and farther by [`APART_MM`].
const CLEARLY: f64 = 2.0;
/// See [`CLEARLY`], mm.
const APART_MM: f64 = 0.1;

impl PartEdges {
    /// The part that a profile bounds, as the drawing shows it.
    ///
    /// # Errors
    /// [`ProfileError`] when the profile bounds no part.
    pub fn of(profile: &Profile, side: MachinedSide) -> Result<Self, ProfileError> {
        let region = profile.part(side, &Profile::default())?;
        let lines = |outline: &keepout_kernel::offset::Outline| {
            let free_on_left = outline.free_on_left;
            let straight = |curve: &Curve| StraightEdge::of(curve, free_on_left);
            outline.curves.iter().filter_map(straight).collect::<Vec<_>>()
        };
        let edges = profile.outlines(&region).iter().flat_map(lines).collect();
        let boxes = profile.loops.iter().map(|each| ContourPolygon::of(each).bounds);
        Ok(Self { edges, bounds: boxes.reduce(Box2::union).unwrap_or_default() })
    }

    /// Diagonal of its box, mm.
    #[must_use]
    pub fn size_mm(&self) -> f64 {
        self.bounds.size().length()
    }

    /// Middle of its box, mm.
    #[must_use]
    pub fn middle_mm(&self) -> Mm2 {
        self.bounds.middle()
    }

    /// Corners of its box, mm.
    #[must_use]
    pub fn corners_mm(&self) -> [Mm2; 4] {
        let Box2 { low, high } = self.bounds;
        [low, Mm2::new(high.x, low.y), high, Mm2::new(low.x, high.y)]
    }

    /// The straight edge to which a place near it refers.
    pub(super) fn edge_near(&self, near: Mm2) -> Result<StraightEdge, AlignmentError> {
        let by_distance =
            |a: &&StraightEdge, b: &&StraightEdge| a.distance(near).total_cmp(&b.distance(near));
        let nearest = self.edges.iter().min_by(by_distance).ok_or(AlignmentError::NoEdge { near })?;
        let distance = nearest.distance(near);
        if !(distance.is_finite() && distance <= self.size_mm()) {
            return Err(AlignmentError::NoEdge { near });
        }
        let others = self.edges.iter().filter(|edge| !edge.is_along(nearest));
        let next = others.map(|edge| edge.distance(near)).fold(f64::INFINITY, f64::min);
        if next < CLEARLY * distance || next - distance < APART_MM {
            return Err(AlignmentError::WhichEdge { near });
        }
        Ok(*nearest)
    }
}

impl StraightEdge {
    fn of(curve: &Curve, free_on_left: bool) -> Option<Self> {
        let Curve::Line(segment) = curve else { return None };
        let length_mm = curve.length() / f64::from(UNITS_PER_MM);
        let (from_mm, to_mm) = (point_mm(segment.from), point_mm(segment.to));
        let direction = (to_mm - from_mm) / length_mm;
        let outward = if free_on_left { direction.left() } else { -direction.left() };
        (length_mm >= EDGE_MIN_MM).then_some(Self { from_mm, to_mm, outward })
    }

    fn distance(&self, p: Mm2) -> f64 {
        p.distance(p.nearest_on(self.from_mm, self.to_mm))
    }

    fn length(&self) -> f64 {
        self.from_mm.distance(self.to_mm)
    }

    /// Position of a place along the edge, mm from the first end.
    pub(super) fn along(&self, p: Mm2) -> f64 {
        (p - self.from_mm).dot(self.to_mm - self.from_mm) / self.length()
    }

    /// The point on the edge's line that is nearest to `p`, mm.
    pub(super) fn foot(&self, p: Mm2) -> Mm2 {
        let off = self.off_line(p);
        p - self.outward * off
    }

    fn off_line(&self, p: Mm2) -> f64 {
        (p - self.from_mm).dot(self.outward)
    }

    /// Whether the other edge is on the same line, with the part on the same side.
    pub(super) fn is_along(&self, other: &Self) -> bool {
        let same_side = self.outward.dot(other.outward) > 0.0;
        let on_line = |p| self.off_line(p).abs() <= ONE_LINE_MM;
        same_side && on_line(other.from_mm) && on_line(other.to_mm)
    }

    /// Distance of a place beyond the edge's nearer end, mm; negative between the ends.
    pub(super) fn beyond(&self, p: Mm2) -> f64 {
        let along = self.along(p);
        (-along).max(along - self.length())
    }
}

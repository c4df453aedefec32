//! The certificate "coverage": every stretch of the true offset has a loop beside it.
//!
//! Implements SR-20.
//!
//! **Claim.** Take a point at distance d from the profile, on the free side. It has a nearest profile point,
//! and it lies on the offset shape of that point's edge or corner. So a walk along all offset shapes meets
//! every such point. An edge covers a stretch when it comes nearer than d to all of it, by exact tests. No
//! point of a covered stretch is at distance d, and no point on the part's side counts. Elsewhere a loop must
//! be within [`BESIDE`], again by an exact test.
//!
//! The walk adds up the length that is neither covered nor beside a loop, until a loop is beside it again.
//! One stretch can consist of pieces of many shapes, with covered lengths between them. A total above
//! [`RESOLUTION`] is a missing piece.

use alloc::vec::Vec;
use core::fmt;

use super::plane::PlaneCurve;
use super::propose::Outline;
use super::track::{StraightWall, Track};
use crate::clear::ProhibitedRegion;
use crate::curve::{Curve, nearest_point, round_down};
use crate::exact::lattice::{COORD_MAX, Length, Point};
use crate::exact::segment::Segment;
use crate::index::{CheckedIndex, Edge, build};
use crate::vec2::Vec2;

/// A loop is beside a place when one of its chords is this near, in lattice units (1 µm).
pub const BESIDE: u16 = 100;
/// The path is within this distance of every place between two places beside it, in lattice units (1.8 µm).
/// It is the sum of [`BESIDE`], the chord error of the loops' chords, half a step or an arc's sagitta, and
/// rounding.
pub const COVERAGE: f64 = 180.0;
/// The greatest length without a loop beside it that the certificate permits, in lattice units (20 µm). It is
/// the total of all stretches between two places beside a loop.
pub const RESOLUTION: f64 = 2_000.0;
/// Rounding of a place, of a distance, and of a sagitta together, in lattice units.
const ROUNDING: f64 = 4.0;
/// Chord error of the loops' chords, in lattice units.
const CHORD_ERROR: u8 = 25;
/// Largest sagitta of an arc between two tested places, in lattice units.
const SAGITTA: f64 = 25.0;
/// Most chords of a path.
const CHORDS_MAX: usize = 16_000_000;
/// Shortest step of the walk, in lattice units (1 µm).
const LEAST_STEP: f64 = 100.0;

/// A stretch of the true offset without a loop beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Missing {
    /// A place on it.
    pub at: Point,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |units: i32| f64::from(units) / f64::from(crate::UNITS_PER_MM);
        let (x, y) = (mm(self.at.x.units()), mm(self.at.y.units()));
        write!(f, "no loop follows the offset near ({x:.3}, {y:.3}) mm")
    }
}

impl core::error::Error for Missing {}

/// Certifies that the path covers the set at distance `d` (lattice units) from the outlines, on their free
/// side. Every stretch longer than [`RESOLUTION`] must have a curve of the path within [`BESIDE`]. `part` is
/// the part inside the outlines. Its chords follow their arcs within `arc_chord_error`.
///
/// # Errors
/// [`Missing`] with a place of the first stretch without a loop. It names the origin when the path has no
/// valid chords.
pub fn certify_complete<'a>(
    part: &ProhibitedRegion,
    outlines: &[Outline],
    d: f64,
    arc_chord_error: Length,
    path: impl Iterator<Item = &'a Curve>,
) -> Result<(), Missing> {
    let Some(beside) = index_of(path) else { return Err(Missing { at: Point::ORIGIN }) };
    let mut walk =
        Walk { part, beside, d, nearest: None, loop_edge: None, arc_chord_error, unaccounted: 0.0 };
    for outline in outlines {
        let edges = outline.shapes();
        // A stretch can run over the start of the outline, so a second round follows it to its end.
        for round in 0..2 {
            for (edge, next) in edges.iter().zip(edges.iter().cycle().skip(1)) {
                if round > 0 && walk.unaccounted == 0.0 {
                    break;
                }
                if let Some(shape) = edge.offset_right(d) {
                    walk.along(&shape)?;
                }
                if let Some(corner) = edge.corner_right(next, d) {
                    walk.along(&corner)?;
                }
            }
        }
    }
    Ok(())
}

/// The loops' chords in an index. Returns `None` when an arc of a loop has no valid chords, or above
/// [`CHORDS_MAX`].
fn index_of<'a>(path: impl Iterator<Item = &'a Curve>) -> Option<CheckedIndex> {
    let chord_error = Length::small(CHORD_ERROR);
    let mut chords = Vec::new();
    for curve in path {
        let points = curve.chord_points(chord_error).ok().filter(|_| chords.len() < CHORDS_MAX)?;
        let ends = points.iter().zip(points.iter().skip(1));
        chords
            .extend(ends.map(|(&from, &to)| Edge { chord: Segment { from, to }, chord_error: Length::ZERO }));
    }
    build::build(chords).ok()
}

struct Walk<'a> {
    part: &'a ProhibitedRegion,
    beside: CheckedIndex,
    d: f64,
    nearest: Option<usize>,
    loop_edge: Option<usize>,
    /// Chord-error bound of the outlines' arcs in `part`.
    arc_chord_error: Length,
    /// The length since the last place beside a loop that is neither covered nor beside one.
    unaccounted: f64,
}

impl Walk<'_> {
    fn along(&mut self, shape: &PlaneCurve) -> Result<(), Missing> {
        let length = shape.length();
        let mut walked = 0.0;
        while walked <= length {
            // The tool cannot be off the lattice.
            let Some(place) = nearest_on(shape, walked) else {
                walked += beyond_lattice(shape, walked).max(LEAST_STEP);
                continue;
            };
            // Most places are beside a loop, often beside the chord of the place before.
            if let Some(step) = self.step_beside_loop(place, shape, walked) {
                self.unaccounted = 0.0;
                walked += step.max(1.0);
                continue;
            }
            if let Some(step) = self.cover(place, shape, walked) {
                walked += step.max(1.0);
                continue;
            }
            match self.beyond_wall(place) {
                Some(step) => walked += step.max(1.0),
                None => {
                    self.unaccounted += LEAST_STEP.min(length - walked).max(1.0);
                    walked += LEAST_STEP;
                    if self.unaccounted >= RESOLUTION {
                        return Err(Missing { at: place });
                    }
                }
            }
        }
        Ok(())
    }

    /// The length from the place on over which an edge covers the shape, by exact tests. It tries the edge
    /// that covered the last place, then the nearest edge.
    fn cover(&mut self, place: Point, shape: &PlaneCurve, walked: f64) -> Option<f64> {
        if let Some(step) = self.nearest.and_then(|last| self.covered_by(last, place, shape, walked)) {
            return Some(step);
        }
        let nearest = self.part.index().nearest(place, self.nearest)?;
        self.nearest = Some(nearest.edge);
        self.covered_by(nearest.edge, place, shape, walked)
    }

    /// The length from the place on over which the edge covers the shape.
    ///
    /// The points within a radius of a chord form a convex set. So a straight shape is covered between two
    /// covered places. An arc is covered too when its sagitta between them is below a unit, because the
    /// radius is reduced by [`ROUNDING`].
    fn covered_by(&self, edge: usize, place: Point, shape: &PlaneCurve, walked: f64) -> Option<f64> {
        let edge = self.part.edges().get(edge)?;
        // The outline lies within this of the chord. The distance from the outline to the drawn curve does
        // not count here.
        let chord_error = edge.chord_error.min(self.arc_chord_error);
        let radius = round_down(self.d - ROUNDING) - i64::from(chord_error.units());
        let radius = Length::from_units(radius).ok()?;
        let covers = |place: Point| !edge.chord.near_point(place, radius).is_clear();
        if !covers(place) {
            return None;
        }
        let rest = shape.length() - walked;
        let covered_at = |step: f64| nearest_on(shape, walked + step).is_some_and(covers);
        let farthest = match *shape {
            PlaneCurve::Line { .. } => rest,
            PlaneCurve::Arc(arc) => rest.min(arc.chord_length(1.0)),
        };
        // For a line, calculate where it leaves the cover and test that place. Otherwise double the step.
        let exit = exit(shape, edge.chord, radius) - walked - 1.0;
        if exit > LEAST_STEP && covered_at(exit.min(farthest)) {
            return Some(exit.min(farthest));
        }
        let (mut step, mut tried) = (0.0, LEAST_STEP.min(farthest));
        while tried > step && covered_at(tried) {
            step = tried;
            tried = (2.0 * tried).min(farthest);
        }
        (step >= 1.0 || step >= rest).then_some(step.max(1.0))
    }

    /// The length that the walk may skip at a place on the part's side. By an exact test no edge is within
    /// this length, so everything within it is on the same side.
    ///
    /// A free space narrower than [`ROUNDING`] lets shapes pass through its far wall.
    fn beyond_wall(&self, place: Point) -> Option<f64> {
        if !self.part.holds(place) {
            return None;
        }
        let clear = self.part.clearance(place)?;
        let step = f64::from(clear.units()) - 2.0;
        (step > LEAST_STEP).then_some(step)
    }

    /// A chord of a loop beside the place: that of the last place, the next one, or the nearest.
    fn chord_beside(&mut self, place: Point, near: Length) -> Option<Segment> {
        let chord = |edge: usize| {
            let chord = self.beside.edges().get(edge)?.chord;
            (!chord.near_point(place, near).is_clear()).then_some(chord)
        };
        // The loop may run along the shape in either direction.
        let last =
            self.loop_edge.into_iter().flat_map(|last| [last.wrapping_add(1), last, last.wrapping_sub(1)]);
        if let Some((edge, chord)) = last.filter_map(|edge| Some((edge, chord(edge)?))).next() {
            self.loop_edge = Some(edge);
            return Some(chord);
        }
        let nearest =
            self.beside.nearest(place, self.loop_edge.filter(|&edge| edge < self.beside.edges().len()))?;
        self.loop_edge = Some(nearest.edge);
        chord(nearest.edge)
    }

    /// The length that the walk may skip beside a loop. It reaches to the end of the loop's chord, or less on
    /// an arc, if that place is beside the chord too: the points near a chord form a convex set. Otherwise it
    /// is one short step.
    fn step_beside_loop(&mut self, place: Point, shape: &PlaneCurve, walked: f64) -> Option<f64> {
        let near = Length::from_units(i64::from(BESIDE)).ok()?;
        let chord = self.chord_beside(place, near)?;
        let length = shape.length();
        let direction = shape.direction(walked / length.max(f64::MIN_POSITIVE));
        let here = Vec2::from(place);
        let ahead = |end: Point| (Vec2::from(end) - here).dot(direction);
        // A line stays beside the chord between two places beside it. An arc leaves its own chord by at most
        // [`SAGITTA`].
        let bound = match *shape {
            PlaneCurve::Line { .. } => length,
            PlaneCurve::Arc(arc) => arc.chord_length(SAGITTA),
        };
        let far = ahead(chord.from).max(ahead(chord.to)).min(length - walked).min(bound);
        let stays_beside = |step: f64| {
            nearest_on(shape, walked + step).is_some_and(|end| !chord.near_point(end, near).is_clear())
        };
        Some(if far > LEAST_STEP && stays_beside(far) { far } else { LEAST_STEP })
    }
}

/// The lattice point nearest to the place at this length along the shape.
fn nearest_on(shape: &PlaneCurve, walked: f64) -> Option<Point> {
    nearest_point(shape.at(walked / shape.length().max(f64::MIN_POSITIVE))).ok()
}

/// The distance from a place off the lattice back to the lattice, along its largest coordinate.
fn beyond_lattice(shape: &PlaneCurve, walked: f64) -> f64 {
    let Vec2 { x, y } = shape.at(walked / shape.length().max(f64::MIN_POSITIVE));
    x.abs().max(y.abs()) - f64::from(COORD_MAX)
}

/// The length along a straight shape at which it leaves the capsule of this radius around the chord. It is 0
/// for other shapes.
fn exit(shape: &PlaneCurve, chord: Segment, radius: Length) -> f64 {
    let track = Track::of(shape);
    let wall = StraightWall::of(&PlaneCurve::Line { from: Vec2::from(chord.from), to: Vec2::from(chord.to) });
    let (Track::Straight { .. }, Some(wall)) = (track, wall) else { return 0.0 };
    let mut exit = 0.0;
    track.covered_by_wall(&wall, f64::from(radius.units()), |_, high| exit = high);
    exit
}

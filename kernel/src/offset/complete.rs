//! The certificate "none missing": every stretch of the true offset has a loop beside it.
//!
//! **Claim.** A point at distance d from the profile, on the free side, has a nearest profile point: it lies on the offset
//! shape of that point's edge or corner. So it is enough to walk along all offset shapes. Where an edge covers a
//! stretch, that is, comes nearer than d to all of it by exact tests, no point of the stretch is at distance d; nor where
//! it is on the part's side. Elsewhere a loop must be within [`BESIDE`], again by an exact test. What is neither covered nor
//! beside a loop is counted, until a loop is beside the walk again: a stretch may be made of pieces of many shapes, with what
//! is covered between them. More than [`RESOLUTION`] is a missing piece.

use alloc::vec::Vec;
use core::fmt;

use super::plane::Shape;
use super::propose::Outline;
use super::track::{Track, Wall};
use crate::clear::ProhibitedRegion;
use crate::curve::{Curve, nearest_point, round_down, xy};
use crate::exact::lattice::{COORD_MAX, Length, Point};
use crate::exact::segment::Segment;
use crate::index::{CheckedIndex, Edge, build};

/// A loop is beside a place when one of its chords is this near, in lattice units (1 µm).
pub const BESIDE: u16 = 100;
/// The path is within this of every place between two that were found beside it, in lattice units (1.8 µm): [`BESIDE`], the
/// chord_error of the chords, half a step or what an arc leaves between two places, and rounding.
pub const COVERAGE: f64 = 180.0;
/// The greatest length without a loop beside it that goes unnoticed, in lattice units (20 µm): all stretches together that are
/// walked between two places beside a loop.
pub const RESOLUTION: f64 = 2_000.0;
/// Rounding of a place, of a distance, and of a sagitta, in lattice units, together.
const ROUNDING: f64 = 4.0;
/// Slack of the loops' chords, lattice units.
const CHORD_SLACK: u8 = 25;
/// What an arc leaves its own chord by between two places, lattice units.
const SAGITTA: f64 = 25.0;
/// Chords of a path that are held.
const CHORDS_MAX: usize = 16_000_000;
/// Steps are tried at least this long, lattice units (1 µm).
const LEAST_STEP: f64 = 100.0;

/// A stretch of the true offset that no loop is beside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Missing {
    /// A place on it.
    pub at: Point,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |units: i32| f64::from(units) / f64::from(crate::UNITS_PER_MM);
        let (x, y) = (mm(self.at.x.units()), mm(self.at.y.units()));
        write!(f, "a piece of the offset near ({x:.3}, {y:.3}) mm is in no loop")
    }
}

impl core::error::Error for Missing {}

/// Certifies that every stretch longer than [`RESOLUTION`] of the set at distance `d` (lattice units) from the outlines,
/// on their free side, has a curve of the path within [`BESIDE`]. `part` is the part that the outlines bound, its arcs followed
/// by chords within `chord_slack`.
///
/// # Errors
/// [`Missing`] with a place of the first stretch that has none.
pub fn certify_complete<'a>(
    part: &ProhibitedRegion,
    outlines: &[Outline],
    d: f64,
    chord_slack: Length,
    path: impl Iterator<Item = &'a Curve>,
) -> Result<(), Missing> {
    let Some(beside) = index_of(path) else { return Err(Missing { at: Point::ORIGIN }) };
    let mut walk = Walk { part, beside, d, nearest: None, loop_edge: None, chord_slack, unaccounted: 0.0 };
    for outline in outlines {
        let edges = outline.shapes();
        // A stretch can run over the place where the outline begins: it is followed on a second round.
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

/// The loops' chords, behind boxes; `None` when a loop's arc can not be turned into chords.
fn index_of<'a>(path: impl Iterator<Item = &'a Curve>) -> Option<CheckedIndex> {
    let chord_error = Length::small(CHORD_SLACK);
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
    /// Bound on how far arcs of the outlines leave their chords in `part`.
    chord_slack: Length,
    /// The length neither covered nor beside a loop since the last place that was beside one.
    unaccounted: f64,
}

impl Walk<'_> {
    fn along(&mut self, shape: &Shape) -> Result<(), Missing> {
        let length = shape.length();
        let mut walked = 0.0;
        while walked <= length {
            // Off the lattice no tool can be.
            let Some(place) = nearest_on(shape, walked) else {
                walked += beyond_lattice(shape, walked).max(LEAST_STEP);
                continue;
            };
            if let Some(step) = self.cover(place, shape, walked) {
                walked += step.max(1.0);
                continue;
            }
            if let Some(step) = self.step_beside_loop(place, shape, walked) {
                self.unaccounted = 0.0;
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

    /// How far along the shape from the place an edge covers it, by exact tests: the edge that covered the last place, or
    /// else the nearest.
    fn cover(&mut self, place: Point, shape: &Shape, walked: f64) -> Option<f64> {
        if let Some(step) = self.nearest.and_then(|last| self.covered_by(last, place, shape, walked)) {
            return Some(step);
        }
        let nearest = self.part.index().nearest(place, self.nearest)?;
        self.nearest = Some(nearest.edge);
        self.covered_by(nearest.edge, place, shape, walked)
    }

    /// How far the edge covers the shape from the place on.
    ///
    /// What is within a radius of a chord is convex: a straight shape is covered between two covered places, and so is an arc
    /// whose sagitta between them is below a unit, with [`ROUNDING`] to spare.
    fn covered_by(&self, edge: usize, place: Point, shape: &Shape, walked: f64) -> Option<f64> {
        let edge = self.part.edges().get(edge)?;
        // The edge is within that of the chord; what the edge stands for is no matter here.
        let chord_error = edge.chord_error.min(self.chord_slack);
        let radius = round_down(self.d - ROUNDING) - i64::from(chord_error.units());
        let radius = Length::from_units(radius).ok()?;
        let covers = |place: Point| !edge.chord.near_point(place, radius).is_clear();
        if !covers(place) {
            return None;
        }
        let rest = shape.length() - walked;
        let covered_at = |step: f64| nearest_on(shape, walked + step).is_some_and(covers);
        let farthest = match *shape {
            Shape::Line { .. } => rest,
            Shape::Arc { radius, .. } => rest.min(libm::sqrt(8.0 * radius)),
        };
        // Where a line leaves the cover is computed, and tried; else steps are doubled.
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

    /// How far the walk may go on where it is on the part's side: as far as no edge is near, by an exact test, everything is
    /// on that side. A free space narrower than [`ROUNDING`] lets shapes through its far wall.
    fn beyond_wall(&self, place: Point) -> Option<f64> {
        if !self.part.holds(place) {
            return None;
        }
        let clear = self.part.clearance(place)?;
        let step = f64::from(clear.units()) - 2.0;
        (step > LEAST_STEP).then_some(step)
    }

    /// How far the walk may go on beside a loop: to the end of the loop's chord, or a shorter way on an arc, when that place is
    /// beside the chord too (what is near a chord is convex); else a small step.
    fn step_beside_loop(&mut self, place: Point, shape: &Shape, walked: f64) -> Option<f64> {
        let near = Length::from_units(i64::from(BESIDE)).ok()?;
        let nearest = self.beside.nearest(place, self.loop_edge)?;
        self.loop_edge = Some(nearest.edge);
        let chord = self.beside.edges().get(nearest.edge)?.chord;
        if chord.near_point(place, near).is_clear() {
            return None;
        }
        let length = shape.length();
        let direction = shape.direction(walked / length.max(f64::MIN_POSITIVE));
        let here = xy(place);
        let ahead = |end: Point| {
            let (x, y) = xy(end);
            (x - here.0) * direction.0 + (y - here.1) * direction.1
        };
        // Between two places beside the chord a line is; an arc leaves its own chord by less than the sagitta.
        let bound = match *shape {
            Shape::Line { .. } => length,
            Shape::Arc { radius, .. } => libm::sqrt(8.0 * SAGITTA * radius),
        };
        let far = ahead(chord.from).max(ahead(chord.to)).min(length - walked).min(bound);
        let stays_beside = |step: f64| {
            nearest_on(shape, walked + step).is_some_and(|end| !chord.near_point(end, near).is_clear())
        };
        Some(if far > LEAST_STEP && stays_beside(far) { far } else { LEAST_STEP })
    }
}

/// The lattice point nearest to the place so far along the shape.
fn nearest_on(shape: &Shape, walked: f64) -> Option<Point> {
    let (x, y) = shape.at(walked / shape.length().max(f64::MIN_POSITIVE));
    nearest_point(x, y).ok()
}

/// How far a place off the lattice is beyond it.
fn beyond_lattice(shape: &Shape, walked: f64) -> f64 {
    let (x, y) = shape.at(walked / shape.length().max(f64::MIN_POSITIVE));
    x.abs().max(y.abs()) - f64::from(COORD_MAX)
}

/// How far along a straight shape it leaves what is within the radius of the chord; 0 for other shapes.
fn exit(shape: &Shape, chord: Segment, radius: Length) -> f64 {
    let track = Track::of(shape);
    let wall = Wall::of(&Shape::Line { from: xy(chord.from), to: xy(chord.to) });
    let (Track::Straight { .. }, Some(wall)) = (track, wall) else { return 0.0 };
    let mut exit = 0.0;
    track.covered_by_wall(&wall, f64::from(radius.units()), |_, high| exit = high);
    exit
}

//! The finishing path: the tool-centre path that contours the profile, and what the tool can not reach.

use keepout_kernel::curve::nearest_point;
use keepout_kernel::exact::predicate::ray_crosses;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::exact::width::Product;
use keepout_kernel::offset::{
    self, COVERAGE, Gouge, Missing, Offset, Outline, RESOLUTION, certify_complete, certify_path,
};
use keepout_kernel::{Curve, Length, Point, ProhibitedRegion, UNITS_PER_MM};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::profile::{ARC_CHORD_SLACK, Profile, corners};
use crate::units::{along_mm, nearest_on_mm, point_from_mm, point_mm};

/// Added to R + M for the path's own rounding and chords, lattice units (0.6 µm): two chord slacks of the profile, two
/// of the path, and the rounding of joints and centres.
pub const PATH_CLEARANCE: u8 = 60;

/// A closed loop of the finishing path, the part on the left of its direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinishingLoop {
    /// Its motions.
    #[serde(with = "crate::stored::many")]
    pub curves: Vec<Curve>,
    /// The connected piece of free space that it lies in: 0 is the unbounded one.
    pub component: usize,
}

/// The finishing path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinishingPath {
    /// Its loops.
    pub loops: Vec<FinishingLoop>,
    /// Length of profile that the tool can not touch, mm.
    pub residual_length_mm: f64,
    /// Area that the tool can not clear, mm²; `None` among zones, where it is not worked out.
    pub residual_area_mm2: Option<f64>,
    /// Length of the whole profile, mm.
    pub profile_length_mm: f64,
}

/// Why there is no finishing path.
#[derive(Debug, Error, PartialEq)]
pub enum FinishError {
    /// The tool fits nowhere.
    #[error(
        "a tool of {diameter_mm:.3} mm diameter fits nowhere on this side of the profile. Take a smaller tool, or the other --side."
    )]
    ToolFitsNowhere {
        /// The tool's diameter, mm.
        diameter_mm: f64,
    },
    /// The proposed path could not be closed.
    #[error(
        "no closed path was found near {at}: {count} loose ends. This is a limit of the path search, not of the drawing: a tool diameter changed by a hundredth often helps."
    )]
    LooseEnds {
        /// Near the first loose end.
        at: Point,
        /// How many there are.
        count: usize,
    },
}

/// Why a finishing path is not believed.
#[derive(Debug, Error, PartialEq)]
pub enum PathRefusal {
    /// A motion comes too near the part.
    #[error("loop {number}: {gouge}")]
    Gouge {
        /// The loop, from 1.
        number: usize,
        /// The motion.
        gouge: Gouge,
    },
    /// A loop does not close, or has no motion.
    #[error("loop {number} does not close")]
    OpenLoop {
        /// The loop, from 1.
        number: usize,
    },
    /// A motion of a loop is not beside the part: it would cut where nothing is to be finished.
    #[error("loop {number}: the motion near {at} is not beside the part")]
    Elsewhere {
        /// The loop, from 1.
        number: usize,
        /// Its place.
        at: Point,
    },
    /// A loop has the part on its right: the tool would cut the other way round than the plan says.
    #[error("loop {number} goes the wrong way round")]
    WrongWay {
        /// The loop, from 1.
        number: usize,
    },
    /// A loop is said to be in a piece of free space that it is not in: it would not be cut from there.
    #[error("loop {number} is in the free space {found}, not in {said}")]
    WrongSpace {
        /// The loop, from 1.
        number: usize,
        /// The piece of free space that it is in, as [`FinishingLoop::component`].
        found: usize,
        /// The one that it is said to be in.
        said: usize,
    },
    /// A stretch of the profile that the tool can touch has no path beside it.
    #[error("{0}")]
    Incomplete(Missing),
    /// What the path is said to leave can not be: of a contour of this length.
    #[error(
        "a residual of {residual_mm} of {said_mm} mm{} is said, of a contour of {length_mm:.3} mm: make the plan again from the drawing",
        area_mm2.map_or(String::new(), |area| format!(" and {area} mm²"))
    )]
    Residual {
        /// What is said to be left, mm.
        residual_mm: f64,
        /// Length of contour that is said, mm.
        said_mm: f64,
        /// Area that is said to be left, mm².
        area_mm2: Option<f64>,
        /// The contour's length, mm.
        length_mm: f64,
    },
}

/// Proposes the path at distance `d` ([`centre_distance`], lattice units) from the outlines that bound free space
/// ([`crate::profile::free_outlines`]).
///
/// # Errors
/// [`FinishError`] when the tool fits nowhere, or the search leaves loose ends.
pub fn propose(
    outlines: &[Outline],
    part: &ProhibitedRegion,
    d: f64,
    diameter_mm: f64,
) -> Result<FinishingPath, FinishError> {
    let offset =
        if part.zones().is_empty() { offset::propose(outlines, d) } else { among_zones(outlines, part, d) };
    if let Some(&(x, y)) = offset.loose_ends.first() {
        let at = nearest_point(x, y).unwrap_or(Point::ORIGIN);
        return Err(FinishError::LooseEnds { at, count: offset.loose_ends.len() });
    }
    if offset.loops.is_empty() {
        return Err(FinishError::ToolFitsNowhere { diameter_mm });
    }
    Ok(path_of(offset))
}

/// The distance of the path from the profile for a threshold, lattice units: what the true curves may leave the profile's
/// edges by, and [`PATH_CLEARANCE`], are added.
#[must_use]
pub fn centre_distance(profile: &Profile, zones: &Profile, threshold: Length) -> f64 {
    let chord_error = profile.chord_error().max(zones.chord_error());
    f64::from(threshold.units()) + f64::from(PATH_CLEARANCE) + f64::from(chord_error.units())
}

/// The offset where zones may lie on the part: outlines are offset to both sides, so that all loops close, and loops within
/// the part or a zone are left out again. How much of the profile is touched is counted on what is left; the area of the
/// residual is not known here.
fn among_zones(outlines: &[Outline], part: &ProhibitedRegion, d: f64) -> Offset {
    let profile_loops = part.region().rings().len();
    let other = |outline: &Outline| Outline { free_on_left: !outline.free_on_left, ..outline.clone() };
    let length = |outline: &Outline| outline.curves.iter().map(Curve::length).sum::<f64>();
    let profile_length = outlines[..profile_loops].iter().map(length).sum();
    let both: Vec<Outline> = outlines.iter().cloned().chain(outlines.iter().map(other)).collect();
    let mut offset = offset::propose(&both, d);
    offset.loops.retain(|each| each.curves.first().is_some_and(|curve| !part.holds(curve.from())));
    let touched = offset.loops.iter().flat_map(|each| &each.outlines);
    let touched_length =
        touched.filter(|(outline, _)| *outline < profile_loops).map(|(_, length)| length).sum();
    Offset { profile_length, touched_length, residual_area: f64::NAN, ..offset }
}

fn path_of(offset: Offset) -> FinishingPath {
    let unit = f64::from(UNITS_PER_MM);
    let components = components(offset.loops.iter().map(|each| &each.curves[..]));
    let loops = offset.loops.into_iter().zip(components);
    FinishingPath {
        loops: loops.map(|(each, component)| FinishingLoop { curves: each.curves, component }).collect(),
        residual_length_mm: (offset.profile_length - offset.touched_length).max(0.0) / unit,
        residual_area_mm2: Some(offset.residual_area / (unit * unit)).filter(|area| area.is_finite()),
        profile_length_mm: offset.profile_length / unit,
    }
}

/// The piece of free space that each loop lies in, numbered like [`FinishingLoop::component`].
fn components<'a>(loops: impl Iterator<Item = &'a [Curve]>) -> Vec<usize> {
    let outlines: Vec<LoopOutline> = loops.map(LoopOutline::new).collect();
    let component = |(i, own): (usize, &LoopOutline)| {
        if own.is_room() { i + 1 } else { component_at(&outlines, own.points[0], Some(i)) }
    };
    outlines.iter().enumerate().map(component).collect()
}

/// Share of a loop's length that may have the part on the right: in a slot no wider than the tool both walls are as near.
const OTHER_WAY: f64 = 0.75;

/// Most places of a motion that are asked whether they are beside the part, and its beginning.
const PLACES_MAX: u32 = 16;

/// Checks that every motion is at the distance `d` (lattice units) beside the part, up to what may be missing from the path, and
/// that the part is on the left: at its beginning and at places not farther than `d` apart, or at [`PLACES_MAX`] of a motion that
/// is longer. That no motion is nearer anywhere is asked elsewhere, and exactly.
fn runs_beside(
    number: usize,
    each: &FinishingLoop,
    part: &ProhibitedRegion,
    d: f64,
) -> Result<(), PathRefusal> {
    let (mut hint, mut length, mut other_way) = (None, 0.0, 0.0);
    for curve in &each.curves {
        let count = (curve.length() / d).ceil().clamp(1.0, f64::from(PLACES_MAX));
        let share = curve.length() / count;
        let beginning = (curve.from(), None);
        let places = (0..PLACES_MAX).map(|i| (f64::from(i) + 0.5) / count).take_while(|t| *t < 1.0);
        let places = places.map(|t| {
            let (place, direction) = along_mm(curve, t);
            (point_from_mm(place).unwrap_or(curve.from()), Some((place, direction)))
        });
        for (at, travel) in std::iter::once(beginning).chain(places) {
            let elsewhere = PathRefusal::Elsewhere { number, at };
            let Some(nearest) = part.index().nearest(at, hint) else { return Err(elsewhere) };
            hint = Some(nearest.edge);
            let edge = part.edges()[nearest.edge];
            if nearest.distance() > d + RESOLUTION + COVERAGE + f64::from(edge.chord_error.units()) {
                return Err(elsewhere);
            }
            let Some((place, (dx, dy))) = travel else { continue };
            let wall = nearest_on_mm(place, point_mm(edge.chord.from), point_mm(edge.chord.to));
            let on_left = dx * (wall.1 - place.1) - dy * (wall.0 - place.0) > 0.0;
            length += share;
            other_way += if on_left { 0.0 } else { share };
        }
    }
    if other_way > OTHER_WAY * length { Err(PathRefusal::WrongWay { number }) } else { Ok(()) }
}

impl FinishingPath {
    /// What the tool leaves, in words.
    #[must_use]
    pub fn residual(&self) -> String {
        let area =
            self.residual_area_mm2.map_or("area not worked out".into(), |area| format!("{area:.3} mm²"));
        format!("{:.3} of {:.1} mm contour, {area}", self.residual_length_mm, self.profile_length_mm)
    }

    /// Certifies that no motion comes within `threshold` of the part, that every loop closes, runs beside the part, the right way
    /// round, and in the free space that is said, and that no stretch of the true offset of the outlines at distance `d` is
    /// missing; answers with the number of motions.
    ///
    /// # Errors
    /// [`PathRefusal`] for the first claim that does not hold.
    pub fn certify(
        &self,
        outlines: &[Outline],
        part: &ProhibitedRegion,
        (threshold, d): (Length, f64),
    ) -> Result<usize, PathRefusal> {
        let mut motions = 0;
        for (index, each) in self.loops.iter().enumerate() {
            let number = index + 1;
            let end = certify_path(part, threshold, &each.curves)
                .map_err(|gouge| PathRefusal::Gouge { number, gouge })?;
            let end = end.map(keepout_kernel::FreePoint::point);
            if end.is_none() || end != each.curves.first().map(Curve::from) {
                return Err(PathRefusal::OpenLoop { number });
            }
            motions += each.curves.len();
        }
        let curves = self.loops.iter().flat_map(|each| &each.curves);
        certify_complete(part, outlines, d, ARC_CHORD_SLACK, curves).map_err(PathRefusal::Incomplete)?;
        for (number, each) in (1..).zip(&self.loops) {
            runs_beside(number, each, part, d)?;
        }
        let found = components(self.loops.iter().map(|each| &each.curves[..]));
        for (number, (each, found)) in (1..).zip(self.loops.iter().zip(found)) {
            if each.component != found {
                return Err(PathRefusal::WrongSpace { number, found, said: each.component });
            }
        }
        self.residual_can_be(&outlines[..part.region().rings().len()])?;
        Ok(motions)
    }

    /// Checks that the figures of the residual are such figures, and the contour's length its length. How much of it the tool
    /// leaves is the planner's word: it follows from the outlines, not from the path.
    fn residual_can_be(&self, profile: &[Outline]) -> Result<(), PathRefusal> {
        let length: f64 = profile.iter().flat_map(|outline| &outline.curves).map(Curve::length).sum();
        let length_mm = length / f64::from(UNITS_PER_MM);
        let (residual_mm, said_mm) = (self.residual_length_mm, self.profile_length_mm);
        let is_length = (said_mm - length_mm).abs() <= 1e-6 * length_mm;
        let is_left = (0.0..=said_mm).contains(&residual_mm);
        let area_mm2 = self.residual_area_mm2;
        let is_area = area_mm2.is_none_or(|area| (0.0..f64::INFINITY).contains(&area));
        if is_length && is_left && is_area {
            return Ok(());
        }
        Err(PathRefusal::Residual { residual_mm, said_mm, area_mm2, length_mm })
    }

    /// The connected piece of free space that `point` lies in, numbered like [`FinishingLoop::component`]. The point
    /// is expected to be clear of the part.
    #[must_use]
    pub fn component_of(&self, point: Point) -> usize {
        self.free_spaces().component_of(point)
    }

    /// The connected pieces of free space, to ask about many points.
    #[must_use]
    pub fn free_spaces(&self) -> FreeSpaces {
        FreeSpaces { outlines: self.loops.iter().map(|each| LoopOutline::new(&each.curves)).collect() }
    }

    /// The length of all loops, mm.
    #[must_use]
    pub fn length_mm(&self) -> f64 {
        let curves = self.loops.iter().flat_map(|each| &each.curves);
        curves.map(Curve::length).sum::<f64>() / f64::from(UNITS_PER_MM)
    }
}

/// The connected pieces of free space, bounded by the finishing loops.
pub struct FreeSpaces {
    outlines: Vec<LoopOutline>,
}

impl FreeSpaces {
    /// As [`FinishingPath::component_of`].
    #[must_use]
    pub fn component_of(&self, point: Point) -> usize {
        component_at(&self.outlines, point, None)
    }
}

/// A loop as a polygon good enough to tell what lies within.
struct LoopOutline {
    points: Vec<Point>,
    bounds: Window,
    double_area: f64,
}

impl LoopOutline {
    fn new(curves: &[Curve]) -> Self {
        let points = corners(curves.iter(), Length::small(200));
        let xy = |p: Point| (f64::from(p.x.units()), f64::from(p.y.units()));
        let edges = points.iter().zip(points.iter().cycle().skip(1));
        let double_area = edges.map(|(&a, &b)| xy(a).0 * xy(b).1 - xy(a).1 * xy(b).0).sum();
        let bounds = points.iter().map(|&point| Window::of(point)).reduce(Window::union);
        Self { bounds: bounds.unwrap_or(Window::of(Point::ORIGIN)), points, double_area }
    }

    /// Whether the free space is within the loop: the part is on its left and it runs clockwise.
    fn is_room(&self) -> bool {
        self.double_area < 0.0
    }

    fn holds(&self, point: Point) -> bool {
        if !self.bounds.holds(point) {
            return false;
        }
        let edges = self.points.iter().zip(self.points.iter().cycle().skip(1));
        edges.filter(|&(&a, &b)| ray_crosses::<Product>(point.into(), a.into(), b.into())).count() % 2 == 1
    }
}

/// The smallest room around `point`, by its number from 1; 0 when no room holds it.
fn component_at(outlines: &[LoopOutline], point: Point, except: Option<usize>) -> usize {
    outlines
        .iter()
        .enumerate()
        .filter(|&(i, outline)| Some(i) != except && outline.is_room() && outline.holds(point))
        .min_by(|(_, a), (_, b)| a.double_area.abs().total_cmp(&b.double_area.abs()))
        .map_or(0, |(i, _)| i + 1)
}

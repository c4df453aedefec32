//! The finishing toolpath along the profile, and the rest material: the stock that the tool cannot reach.
//!
//! Implements SR-16, SR-20.

use keepout_kernel::curve::nearest_point;
use keepout_kernel::exact::predicate::ray_crosses;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::exact::width::Product;
use keepout_kernel::offset::{
    self, COVERAGE, Offset, OffsetLoop, Outline, RESOLUTION, certify_complete, certify_path,
};
use keepout_kernel::{Curve, Length, Point, ProhibitedRegion, UNITS_PER_MM};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use crate::finish_error::{FinishError, PathRefusal};
use crate::mesh::largest_tool_mm;
use crate::profile::{ARC_CHORD_ERROR, Profile, corners};
use crate::reach::reaches;
use crate::rest;
use crate::units::{along_mm, point_from_mm, point_mm};

/// Distance that is added to R + M, lattice units (60 units are 0.6 µm). It covers two chord-error bounds
/// of the profile, two of the toolpath, and the rounding of joints and centres.
pub const PATH_CLEARANCE: u8 = 60;

/// Closed loop of the finishing toolpath, with the part on the left of its direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinishingLoop {
    /// Its motions.
    #[serde(with = "crate::stored::many")]
    pub curves: Vec<Curve>,
    /// Number of the connected free space that it lies in. 0 is the unbounded one; any other is the
    /// number, from 1, of the loop that encloses it.
    pub component: usize,
}

/// Finishing toolpath: all loops, and the rest material that they leave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FinishingPath {
    /// Its loops.
    pub loops: Vec<FinishingLoop>,
    /// Length of profile at which the tool leaves rest material ([`crate::reach`]), mm.
    pub residual_length_mm: f64,
    /// Area of the rest material, mm². `None` with keep-out zones: the planner does not compute it then.
    pub residual_area_mm2: Option<f64>,
    /// Length of the whole profile, mm.
    pub profile_length_mm: f64,
}

/// Proposes the finishing toolpath at distance `d` ([`centre_distance`], lattice units) from the outlines
/// that bound free space ([`crate::profile::free_outlines`]).
///
/// # Errors
/// [`FinishError`] when the tool fits nowhere, or when the search leaves loose ends.
pub fn propose(
    outlines: &[Outline],
    part: &ProhibitedRegion,
    d: f64,
    diameter_mm: f64,
) -> Result<FinishingPath, FinishError> {
    let offset = offset_among(outlines, part, d);
    if let Some(&end) = offset.loose_ends.first() {
        let at = nearest_point(end).unwrap_or(Point::ORIGIN);
        return Err(FinishError::LooseEnds { at, count: offset.loose_ends.len() });
    }
    if offset.loops.is_empty() {
        let largest_mm = largest_tool_mm(part, d / f64::from(UNITS_PER_MM) - diameter_mm / 2.0);
        return Err(FinishError::ToolFitsNowhere { diameter_mm, largest_mm });
    }
    Ok(path_of(outlines, part, &offset, d))
}

/// The offset at distance `d` (lattice units) from the outlines that bound free space.
pub(crate) fn offset_among(outlines: &[Outline], part: &ProhibitedRegion, d: f64) -> Offset {
    if part.zones().is_empty() { offset::propose(outlines, d) } else { among_zones(outlines, part, d) }
}

/// Distance of the toolpath from the profile for the clearance `threshold`, lattice units: the clearance,
/// [`PATH_CLEARANCE`], and the largest chord error of profile and zones.
#[must_use]
pub fn centre_distance(profile: &Profile, zones: &Profile, threshold: Length) -> f64 {
    let chord_error = profile.chord_error().max(zones.chord_error());
    f64::from(threshold.units()) + f64::from(PATH_CLEARANCE) + f64::from(chord_error.units())
}

/// Proposes the offset when keep-out zones may overlap the part. It offsets the outlines to both sides,
/// so all loops close. It then drops the loops inside the part or a zone.
fn among_zones(outlines: &[Outline], part: &ProhibitedRegion, d: f64) -> Offset {
    let other = |outline: &Outline| Outline { free_on_left: !outline.free_on_left, ..outline.clone() };
    let both: Vec<Outline> = outlines.iter().cloned().chain(outlines.iter().map(other)).collect();
    let mut offset = offset::propose(&both, d);
    offset.loops.retain(|each| each.curves.first().is_some_and(|curve| !part.holds(curve.from())));
    offset
}

fn path_of(outlines: &[Outline], part: &ProhibitedRegion, offset: &Offset, d: f64) -> FinishingPath {
    let profile = &outlines[..part.region().rings().len()];
    let residual_area_mm2 =
        part.zones().is_empty().then(|| rest::area_mm2(profile, &offset.loops, part.side()));
    let components = components(offset.loops.iter().map(|each| &each.curves[..]));
    let each =
        |(each, component): (&OffsetLoop, usize)| FinishingLoop { curves: each.curves.clone(), component };
    let loops: Vec<FinishingLoop> = offset.loops.iter().zip(components).map(each).collect();
    let reaches = reaches(profile, &loops, d);
    FinishingPath {
        residual_length_mm: reaches.iter().map(|reach| reach.left_mm).sum(),
        profile_length_mm: reaches.iter().map(|reach| reach.length_mm).sum(),
        residual_area_mm2,
        loops,
    }
}

/// Number of the free space in which each loop lies, as [`FinishingLoop::component`].
fn components<'a>(loops: impl Iterator<Item = &'a [Curve]>) -> Vec<usize> {
    let outlines: Vec<LoopOutline> = loops.map(LoopOutline::new).collect();
    let component = |(i, own): (usize, &LoopOutline)| {
        if own.encloses_free_space() { i + 1 } else { component_at(&outlines, own.points[0], Some(i)) }
    };
    outlines.iter().enumerate().map(component).collect()
}

/// Largest share of a loop's length that may have the part on its right. In a slot no wider than the
/// tool, both walls are equally near.
const OTHER_WAY: f64 = 0.75;

/// Largest number of places of a motion at which [`runs_beside`] looks, besides the start.
const PLACES_MAX: u32 = 16;

/// Checks that a loop runs beside the part, and that the part is on its left.
///
/// Every motion stays within `d` + [`RESOLUTION`] + [`COVERAGE`] (lattice units) and the chord error of
/// the nearest edge. The check looks at the start of each motion and at places at most `d` apart. A
/// longer motion has [`PLACES_MAX`] places.
///
/// The places after the start also give the side. The part may be on the right of at most [`OTHER_WAY`]
/// of the length. [`certify_path`] proves the least distance separately and exactly.
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
            let Some((place, direction)) = travel else { continue };
            let wall = place.nearest_on(point_mm(edge.chord.from), point_mm(edge.chord.to));
            let on_left = direction.cross(wall - place) > 0.0;
            length += share;
            other_way += if on_left { 0.0 } else { share };
        }
    }
    if other_way > OTHER_WAY * length { Err(PathRefusal::WrongWay { number }) } else { Ok(()) }
}

impl FinishingPath {
    /// Text with the length and the area of the rest material.
    #[must_use]
    pub fn residual(&self) -> String {
        let area = self.residual_area_mm2.map_or("area unknown".into(), |area| format!("{area:.3} mm²"));
        format!("{:.3} of {:.1} mm contour, {area}", self.residual_length_mm, self.profile_length_mm)
    }

    /// Certifies the toolpath, and returns the number of its motions. `threshold` is the clearance, and
    /// `d` the distance of the toolpath in lattice units. The certificate has these parts:
    ///
    /// - No motion comes within `threshold` of the part, and every loop closes.
    /// - No stretch of the true offset of the outlines at `d` is missing from the toolpath.
    /// - Every loop runs beside the part, in the right direction, in the free space that it states.
    /// - The figures of the rest material are possible.
    ///
    /// # Errors
    /// [`PathRefusal`] for the first check that fails.
    pub fn certify(
        &self,
        outlines: &[Outline],
        part: &ProhibitedRegion,
        (threshold, d): (Length, f64),
    ) -> Result<usize, PathRefusal> {
        let motions = self.certify_loops(part, threshold)?;
        self.certify_beside(outlines, part, d)?;
        self.residual_can_be(&outlines[..part.region().rings().len()])?;
        Ok(motions)
    }

    /// Checks that no loop comes near the part and that every loop closes. Returns the number of motions.
    fn certify_loops(&self, part: &ProhibitedRegion, threshold: Length) -> Result<usize, PathRefusal> {
        let certify = |each: &FinishingLoop| certify_path(part, threshold, &each.curves);
        let ends: Vec<_> = self.loops.par_iter().map(certify).collect();
        let mut motions = 0;
        for (number, (each, end)) in (1..).zip(self.loops.iter().zip(ends)) {
            let end = end.map_err(|gouge| PathRefusal::Gouge { number, gouge })?;
            let end = end.map(keepout_kernel::FreePoint::point);
            if end.is_none() || end != each.curves.first().map(Curve::from) {
                return Err(PathRefusal::OpenLoop { number });
            }
            motions += each.curves.len();
        }
        Ok(motions)
    }

    /// Checks that no stretch beside the part is missing, and that every loop runs beside the part in its space.
    fn certify_beside(
        &self,
        outlines: &[Outline],
        part: &ProhibitedRegion,
        d: f64,
    ) -> Result<(), PathRefusal> {
        let curves = self.loops.iter().flat_map(|each| &each.curves);
        certify_complete(part, outlines, d, ARC_CHORD_ERROR, curves).map_err(PathRefusal::Incomplete)?;
        for (number, each) in (1..).zip(&self.loops) {
            runs_beside(number, each, part, d)?;
        }
        let found = components(self.loops.iter().map(|each| &each.curves[..]));
        for (number, (each, found)) in (1..).zip(self.loops.iter().zip(found)) {
            if each.component != found {
                return Err(PathRefusal::WrongSpace { number, found, said: each.component });
            }
        }
        Ok(())
    }

    /// Checks the figures of the rest material: the stated contour length equals the true length to a
    /// share of 1e-6, and the rest material is at most that length. The amount itself is not certified.
    /// It follows from the outlines, not from the toolpath.
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

    /// Number of the free space in which `point` lies, as [`FinishingLoop::component`]. The point must be
    /// clear of the part.
    #[must_use]
    pub fn component_of(&self, point: Point) -> usize {
        self.free_spaces().component_of(point)
    }

    /// Connected free spaces, for queries about many points.
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

/// Connected free spaces, bounded by the finishing loops.
pub struct FreeSpaces {
    outlines: Vec<LoopOutline>,
}

impl FreeSpaces {
    /// Number of the free space of a point, as [`FinishingPath::component_of`].
    #[must_use]
    pub fn component_of(&self, point: Point) -> usize {
        component_at(&self.outlines, point, None)
    }
}

/// A loop as a polygon with a chord error of 2 µm. It decides which points the loop encloses.
struct LoopOutline {
    points: Vec<Point>,
    bounds: Window,
    /// Twice the signed area, square lattice units.
    double_area: i128,
}

impl LoopOutline {
    fn new(curves: &[Curve]) -> Self {
        let points = corners(curves.iter(), Length::small(200));
        let edges = points.iter().zip(points.iter().cycle().skip(1));
        let product = |a: i32, b: i32| i128::from(a) * i128::from(b);
        let cross =
            |(a, b): (&Point, &Point)| product(a.x.units(), b.y.units()) - product(a.y.units(), b.x.units());
        let double_area = edges.map(cross).sum();
        let bounds = points.iter().map(|&point| Window::of(point)).reduce(Window::union);
        Self { bounds: bounds.unwrap_or(Window::of(Point::ORIGIN)), points, double_area }
    }

    /// Whether the loop encloses free space: it runs clockwise, with the part on its left.
    fn encloses_free_space(&self) -> bool {
        self.double_area < 0
    }

    fn holds(&self, point: Point) -> bool {
        if !self.bounds.holds(point) {
            return false;
        }
        let edges = self.points.iter().zip(self.points.iter().cycle().skip(1));
        edges.filter(|&(&a, &b)| ray_crosses::<Product>(point.into(), a.into(), b.into())).count() % 2 == 1
    }
}

/// Number, from 1, of the smallest loop that encloses free space around `point`; 0 when no such loop
/// exists.
fn component_at(outlines: &[LoopOutline], point: Point, except: Option<usize>) -> usize {
    outlines
        .iter()
        .enumerate()
        .filter(|&(i, outline)| Some(i) != except && outline.encloses_free_space() && outline.holds(point))
        .min_by_key(|(_, outline)| outline.double_area.abs())
        .map_or(0, |(i, _)| i + 1)
}

//! The finishing path: the tool-centre path that contours the profile, and what the tool can not reach.

use keepout_kernel::curve::nearest_point;
use keepout_kernel::exact::predicate::ray_crosses;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::exact::width::Product;
use keepout_kernel::offset::{self, Missing, Offset};
use keepout_kernel::{Curve, Length, Point, ProhibitedRegion, UNITS_PER_MM};
use thiserror::Error;

use crate::profile::Profile;
use crate::units::place;

/// Added to R + M for the path's own rounding and chords, lattice units (0.6 µm): two chord slacks of the profile, two
/// of the path, and the rounding of joints and centres.
pub const GUARD: u8 = 60;

/// A closed loop of the finishing path, the part on the left of its direction.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishingLoop {
    /// Its motions.
    pub curves: Vec<Curve>,
    /// The connected piece of free space that it lies in: 0 is the unbounded one.
    pub component: usize,
}

/// The finishing path.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishingPath {
    /// Its loops.
    pub loops: Vec<FinishingLoop>,
    /// Length of profile that the tool can not touch, mm.
    pub residual_length_mm: f64,
    /// Area that the tool can not clear, mm².
    pub residual_area_mm2: f64,
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
    /// The path leaves out a piece of the contour that the tool can reach.
    #[error("the path that was found leaves out a piece near {}. This is a limit of the path search, not of the drawing: a tool diameter changed by a hundredth often helps.", place(*at))]
    Incomplete {
        /// A place on the piece.
        at: Point,
    },
    /// The proposed path could not be closed.
    #[error("no closed path was found near {}: {count} loose ends. This is a limit of the path search, not of the drawing: a tool diameter changed by a hundredth often helps.", place(*at))]
    LooseEnds {
        /// Near the first loose end.
        at: Point,
        /// How many there are.
        count: usize,
    },
}

/// Proposes the path at distance `distance` (R + M) plus [`GUARD`] from the profile.
///
/// # Errors
/// [`FinishError`] when the tool fits nowhere, or the search leaves loose ends.
pub fn propose(
    profile: &Profile,
    part: &ProhibitedRegion,
    distance: Length,
    diameter_mm: f64,
) -> Result<FinishingPath, FinishError> {
    let d = f64::from(distance.units()) + f64::from(GUARD);
    let outlines = profile.outlines(part);
    let offset = offset::propose(&outlines, d);
    if let Some(&(x, y)) = offset.loose_ends.first() {
        let at = nearest_point(x, y).unwrap_or(Point::ORIGIN);
        return Err(FinishError::LooseEnds { at, count: offset.loose_ends.len() });
    }
    offset::certify_complete(part, &outlines, d, &offset.loops)
        .map_err(|Missing { at }| FinishError::Incomplete { at })?;
    if offset.loops.is_empty() {
        return Err(FinishError::ToolFitsNowhere { diameter_mm });
    }
    Ok(path_of(offset))
}

fn path_of(offset: Offset) -> FinishingPath {
    let unit = f64::from(UNITS_PER_MM);
    let outlines: Vec<LoopOutline> = offset.loops.iter().map(|each| LoopOutline::new(&each.curves)).collect();
    let component = |i: usize| {
        let own = &outlines[i];
        if own.is_room() { i + 1 } else { component_at(&outlines, own.points[0], Some(i)) }
    };
    let components: Vec<usize> = (0..outlines.len()).map(component).collect();
    let loops = offset.loops.into_iter().zip(components);
    FinishingPath {
        loops: loops.map(|(each, component)| FinishingLoop { curves: each.curves, component }).collect(),
        residual_length_mm: (offset.profile_length - offset.touched_length).max(0.0) / unit,
        residual_area_mm2: offset.residual_area / (unit * unit),
        profile_length_mm: offset.profile_length / unit,
    }
}

impl FinishingPath {
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
        let coarse = Length::small(200);
        let corners =
            |curve: &Curve| curve.chord_points(coarse).unwrap_or_else(|_| vec![curve.from(), curve.to()]);
        let points: Vec<Point> = curves
            .iter()
            .flat_map(|curve| {
                let mut points = corners(curve);
                points.pop();
                points
            })
            .collect();
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

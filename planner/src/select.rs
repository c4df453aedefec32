//! Selection of the contours of a drawing that make the part.

use keepout_kernel::Curve;
use thiserror::Error;

use crate::drawing::{Chained, Drawing, DrawingError, EntityFilter, LeftOutCurve, LeftOutReason, Problem};
use crate::left_out::{Surround, of_chains, surrounds};
use crate::nesting::Nesting;
use crate::plan::Remark;
use crate::profile::{Profile, ProfileLoop, corners};
use crate::ribbon::{Ribbon, ribbons};
use crate::size::SizeQuestion;
use crate::units::{arc_mm, point_mm};
use crate::{Box2, Mm2};

/// The user's selection among the contours of a drawing; all contours by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Selection {
    /// Points, mm. Each selects the smallest contour around it, and the contours directly inside that
    /// contour.
    pub at: Vec<Mm2>,
    /// Least area of a selected contour, mm².
    pub least_area_mm2: Option<f64>,
    /// Largest area of a selected contour, mm².
    pub most_area_mm2: Option<f64>,
    /// Whether open curves are left out. Otherwise they are an error.
    pub leave_out_open: bool,
    /// The contour to take of an outline that is drawn as a stroke with width.
    pub stroke: Option<InkSide>,
}

/// The contour to take of an outline that is drawn as a stroke with width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InkSide {
    /// The outer boundary of the ink.
    Outer,
    /// The inner boundary of the ink.
    Inner,
    /// Both: the part is as thin as the ink.
    Part,
}

/// The selected contours, and the curves that are left out.
#[derive(Clone, Debug, Default)]
pub struct Selected {
    /// The contours.
    pub profile: Profile,
    /// The number of each contour in the drawing, from 1.
    pub numbers: Vec<usize>,
    /// The layer on which each contour begins.
    pub layers: Vec<std::sync::Arc<str>>,
    /// Curves that are left out, as points, mm.
    pub left_out: Vec<Vec<Mm2>>,
}

/// Reasons why a selection is refused.
#[derive(Debug, Error)]
pub enum SelectError {
    /// Contours are open.
    #[error(transparent)]
    Open(#[from] DrawingError),
    /// No contour lies around a point.
    #[error(
        "no closed contour lies around --at {:.3},{:.3} mm. `keepout inspect` lists and draws the contours.",
        .at.x,
        .at.y
    )]
    NothingAt {
        /// The point, mm.
        at: Mm2,
    },
    /// Curves that are left out surround or border the part.
    #[error(transparent)]
    Surround(#[from] Surround),
    /// Outlines are drawn as strokes with width.
    #[error(
        "{count} contours are drawn as strokes {width_mm:.3} mm wide, the first near {at}: the part would be as thin \
         as the ink. Take one side of the ink: --stroke outer or --stroke inner. If such a thin ring is the part, \
         give --stroke part."
    )]
    Stroke {
        /// Number of strokes.
        count: usize,
        /// Width of the first.
        width_mm: f64,
        /// A place on the first.
        at: Mm2,
    },
    /// The part is smaller than any that a machinist cuts.
    #[error(transparent)]
    Size(#[from] SizeQuestion),
    /// No contour has an area within the limits.
    #[error(
        "none of the {count} closed contours has an area within --min-area-mm2 and --max-area-mm2: the \
         largest has {largest_mm2:.3} mm². Change these limits."
    )]
    NothingOfArea {
        /// Number of closed contours.
        count: usize,
        /// Area of the largest, mm².
        largest_mm2: f64,
    },
}

impl SelectError {
    /// The error of outlines that are drawn as strokes, if there are any.
    #[must_use]
    pub fn of_strokes(outlines: &[ContourPolygon], strokes: &[Ribbon]) -> Option<Self> {
        let first = strokes.first()?;
        let at = outlines[first.outer].points.first().copied().unwrap_or_default();
        Some(Self::Stroke { count: strokes.len(), width_mm: first.width_mm, at })
    }

    /// The place of the fault, if it has one.
    #[must_use]
    pub fn at(&self) -> Option<Mm2> {
        match self {
            Self::Stroke { at, .. } | Self::NothingAt { at } => Some(*at),
            Self::Surround(found) => Some(found.at()),
            Self::Open(_) | Self::Size(_) | Self::NothingOfArea { .. } => None,
        }
    }
}

impl Selection {
    /// The selected contours. Adds a remark for each kind of curve that is left out.
    ///
    /// # Errors
    /// [`SelectError`].
    pub fn apply(
        &self,
        chained: Chained,
        (drawing, filter): (&Drawing, &EntityFilter),
        remarks: &mut Vec<Remark>,
    ) -> Result<Selected, SelectError> {
        // If the user points at contours, other curves may be open.
        let chained = if self.leave_out_open || !self.at.is_empty() {
            report_open(&chained, remarks);
            chained
        } else {
            chained.closed()?
        };
        let mut left_out = drawing.aside.clone();
        left_out.extend(of_chains(&chained.open));
        let (loops, layers) = (chained.profile.loops, chained.layers);
        let outlines: Vec<ContourPolygon> = loops.iter().map(ContourPolygon::of).collect();
        let mut keep = self.pointed_at(&outlines, &chained.problems)?;
        let largest_mm2 = outlines.iter().map(|outline| outline.area_mm2).fold(0.0, f64::max);
        let fits = |outline: &ContourPolygon| {
            self.least_area_mm2.is_none_or(|least| outline.area_mm2 >= least)
                && self.most_area_mm2.is_none_or(|most| outline.area_mm2 <= most)
        };
        keep.iter_mut().zip(&outlines).for_each(|(keep, outline)| *keep &= fits(outline));
        self.one_side_of_strokes(&outlines, &mut keep)?;
        let count = loops.len();
        let (mut numbers, mut kept, mut polygons) = (Vec::new(), Vec::new(), Vec::new());
        let mut kept_layers = Vec::new();
        for (index, (each, outline)) in loops.into_iter().zip(outlines).enumerate() {
            if keep[index] {
                numbers.push(index + 1);
                kept_layers.extend(layers.get(index).cloned());
                kept.push(each);
                polygons.push(outline);
            } else {
                left_out.push(LeftOutCurve { points: closed(outline.points), reason: LeftOutReason::Open });
            }
        }
        if kept.is_empty() && count > 0 {
            return Err(SelectError::NothingOfArea { count, largest_mm2 });
        }
        if kept.len() < count {
            let text = format!("left out: {} closed contours that were not selected", count - kept.len());
            remarks.push(text.into());
        }
        if self.at.is_empty() {
            let open = left_out.len() - (count - kept.len());
            let found = surrounds(&polygons, &Nesting::of(&polygons).depths, &left_out[..open], filter);
            found.into_iter().next().map_or(Ok(()), Err)?;
        }
        SizeQuestion::of_part(&polygons, drawing, filter)
            .filter(SizeQuestion::is_problem)
            .map_or(Ok(()), Err)?;
        let left_out = left_out.into_iter().map(|curve| curve.points).collect();
        Ok(Selected { profile: Profile { loops: kept }, numbers, layers: kept_layers, left_out })
    }

    /// Drops one contour of each stroke.
    fn one_side_of_strokes(&self, outlines: &[ContourPolygon], keep: &mut [bool]) -> Result<(), SelectError> {
        let strokes = ribbons(outlines, &Nesting::of(outlines));
        let is_kept = |ribbon: &Ribbon| keep[ribbon.outer] && keep[ribbon.inner];
        let strokes: Vec<Ribbon> = strokes.into_iter().filter(is_kept).collect();
        if strokes.is_empty() {
            return Ok(());
        }
        match self.stroke {
            None => SelectError::of_strokes(outlines, &strokes).map_or(Ok(()), Err),
            Some(InkSide::Part) => Ok(()),
            Some(InkSide::Outer) => {
                strokes.iter().for_each(|stroke| keep[stroke.inner] = false);
                Ok(())
            }
            Some(InkSide::Inner) => {
                strokes.iter().for_each(|stroke| keep[stroke.outer] = false);
                Ok(())
            }
        }
    }

    /// Marks the contours that the user points at; all contours, if the user points at none.
    ///
    /// An open curve inside a marked contour may be an island of it, and so stays an error.
    fn pointed_at(
        &self,
        outlines: &[ContourPolygon],
        problems: &[Problem],
    ) -> Result<Vec<bool>, SelectError> {
        let mut taken = vec![self.at.is_empty(); outlines.len()];
        let parents = if self.at.is_empty() { Vec::new() } else { Nesting::of(outlines).parents };
        for &at in &self.at {
            let around = |i: &usize| outlines[*i].holds(at);
            let by_area = |a: &usize, b: &usize| outlines[*a].area_mm2.total_cmp(&outlines[*b].area_mm2);
            let chosen = (0..outlines.len()).filter(around).min_by(by_area);
            let chosen = chosen.ok_or(SelectError::NothingAt { at })?;
            taken[chosen] = true;
            taken.iter_mut().zip(&parents).for_each(|(taken, parent)| *taken |= *parent == Some(chosen));
        }
        let within = |problem: &&Problem| {
            let at = point_mm(problem.at());
            taken.iter().zip(outlines).any(|(&taken, outline)| taken && outline.holds(at))
        };
        let open: Vec<Problem> = problems.iter().filter(within).cloned().collect();
        if self.leave_out_open || self.at.is_empty() || open.is_empty() {
            Ok(taken)
        } else {
            Err(DrawingError::Problems { problems: open, gaps: None }.into())
        }
    }
}

fn report_open(chained: &Chained, remarks: &mut Vec<Remark>) {
    if !chained.open.is_empty() {
        let chains = format!("left out: {} chains of open curves", chained.open.len());
        remarks.push(chains.into());
        let open =
            |problem: &Problem| Remark { at: Some(problem.at()), text: format!("left out: {problem}") };
        remarks.extend(chained.problems.iter().map(open));
    }
}

fn closed(mut points: Vec<Mm2>) -> Vec<Mm2> {
    points.extend(points.first().copied());
    points
}

/// Positive if `c` is on the left of the line from `a` to `b`. The sign is exact.
fn orientation(a: Mm2, b: Mm2, c: Mm2) -> f64 {
    let coord = |at: Mm2| robust::Coord { x: at.x, y: at.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// A contour as a polygon, to find the points and contours within it. Its corners have a chord error of at
/// most 2 µm.
pub struct ContourPolygon {
    /// Corners, mm.
    pub points: Vec<Mm2>,
    /// Area, mm².
    pub area_mm2: f64,
    /// The box around it.
    pub bounds: Box2,
}

impl ContourPolygon {
    /// The outline of a loop.
    #[must_use]
    pub fn of(each: &ProfileLoop) -> Self {
        let points = corners(each.curves(), keepout_kernel::Length::small(200));
        let points: Vec<Mm2> = points.into_iter().map(point_mm).collect();
        let ends: Vec<Mm2> = each.edges.iter().map(|edge| point_mm(edge.curve.from())).collect();
        let next = ends.iter().cycle().skip(1);
        let arcs =
            each.curves().filter_map(|curve| if let Curve::Arc(arc) = curve { Some(arc) } else { None });
        let bulges: f64 = arcs.map(|arc| arc_mm(arc).double_segment_area()).sum();
        let double = ends.iter().zip(next).map(|(a, b)| a.cross(*b)).sum::<f64>() + bulges;
        let bounds = Box2::around(points.iter().copied()).unwrap_or_default();
        Self { points, area_mm2: double.abs() / 2.0, bounds }
    }

    /// Its length, mm.
    #[must_use]
    pub fn length_mm(&self) -> f64 {
        let next = self.points.iter().cycle().skip(1);
        self.points.iter().zip(next).map(|(a, b)| a.distance(*b)).sum()
    }

    /// Whether the point lies within, by counting the crossings of a ray.
    #[must_use]
    pub fn holds(&self, place: Mm2) -> bool {
        if !self.bounds.holds(place) {
            return false;
        }
        let next = self.points.iter().cycle().skip(1);
        let crossings = self.points.iter().zip(next).filter(|&(a, b)| {
            let upward = b.y > place.y;
            (a.y > place.y) != upward && (orientation(*a, *b, place) > 0.0) == upward
        });
        crossings.count() % 2 == 1
    }
}

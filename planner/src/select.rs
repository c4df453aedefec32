//! Selection of the contours of a drawing that make the part.

use keepout_kernel::Curve;
use thiserror::Error;

use crate::drawing::{Chained, DrawingError, Problem};
use crate::plan::Remark;
use crate::profile::{Profile, ProfileLoop, corners};
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

impl Selection {
    /// The selected contours. Adds a remark for each kind of curve that is left out.
    ///
    /// # Errors
    /// [`SelectError`].
    pub fn apply(&self, chained: Chained, remarks: &mut Vec<Remark>) -> Result<Profile, SelectError> {
        // If the user points at contours, other curves may be open.
        let chained = if self.leave_out_open || !self.at.is_empty() {
            report_open(&chained, remarks);
            chained
        } else {
            chained.closed()?
        };
        let (flat, loops): (Vec<_>, Vec<_>) =
            chained.profile.loops.into_iter().partition(ProfileLoop::is_flat);
        let flat = flat.iter().map(|each| Remark {
            at: each.edges.first().map(|edge| edge.curve.from()),
            text: "left out: a line drawn there and back, which encloses no area".into(),
        });
        remarks.extend(flat);
        let outlines: Vec<ContourPolygon> = loops.iter().map(ContourPolygon::of).collect();
        let taken = self.pointed_at(&outlines, &chained.problems)?;
        let largest_mm2 = outlines.iter().map(|outline| outline.area_mm2).fold(0.0, f64::max);
        let fits = |outline: &ContourPolygon| {
            self.least_area_mm2.is_none_or(|least| outline.area_mm2 >= least)
                && self.most_area_mm2.is_none_or(|most| outline.area_mm2 <= most)
        };
        let count = loops.len();
        let keep: Vec<bool> =
            taken.iter().zip(&outlines).map(|(&taken, outline)| taken && fits(outline)).collect();
        let mut kept = keep.iter();
        let loops: Vec<ProfileLoop> = loops.into_iter().filter(|_| kept.next() == Some(&true)).collect();
        if loops.is_empty() && count > 0 {
            return Err(SelectError::NothingOfArea { count, largest_mm2 });
        }
        if loops.len() < count {
            let text = format!("left out: {} closed contours that were not selected", count - loops.len());
            remarks.push(text.into());
        }
        Ok(Profile { loops })
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
        for &at in &self.at {
            let around = |i: &usize| outlines[*i].holds(at);
            let by_area = |a: &usize, b: &usize| outlines[*a].area_mm2.total_cmp(&outlines[*b].area_mm2);
            let chosen = (0..outlines.len()).filter(around).min_by(by_area);
            let chosen = chosen.ok_or(SelectError::NothingAt { at })?;
            taken[chosen] = true;
            for (i, taken) in taken.iter_mut().enumerate() {
                *taken |= parent(outlines, i) == Some(chosen);
            }
        }
        let within = |problem: &&Problem| {
            let at = point_mm(problem.at());
            taken.iter().zip(outlines).any(|(&taken, outline)| taken && outline.holds(at))
        };
        let open: Vec<Problem> = problems.iter().filter(within).cloned().collect();
        if self.leave_out_open || self.at.is_empty() || open.is_empty() {
            Ok(taken)
        } else {
            Err(DrawingError::Problems(open).into())
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

/// The smallest contour around another.
fn parent(outlines: &[ContourPolygon], i: usize) -> Option<usize> {
    let &inner = outlines[i].points.first()?;
    let around =
        |&j: &usize| j != i && outlines[j].area_mm2 > outlines[i].area_mm2 && outlines[j].holds(inner);
    (0..outlines.len()).filter(around).min_by(|&a, &b| outlines[a].area_mm2.total_cmp(&outlines[b].area_mm2))
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

    /// Whether the point lies within, by counting the crossings of a ray.
    #[must_use]
    pub fn holds(&self, place: Mm2) -> bool {
        if !self.bounds.holds(place) {
            return false;
        }
        let next = self.points.iter().cycle().skip(1);
        let crossings = self.points.iter().zip(next).filter(|&(a, b)| {
            (a.y > place.y) != (b.y > place.y) && place.x < a.x + (b.x - a.x) * (place.y - a.y) / (b.y - a.y)
        });
        crossings.count() % 2 == 1
    }
}

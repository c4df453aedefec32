//! Alignment of the workpiece: the rotation and the offset from drawing coordinates to machine
//! coordinates.
//!
//! Implements SR-26.
//!
//! A machine point is `R(rotation) · drawing + origin`. The fit uses probe points: points of the drawing
//! to which the operator brought the tool's centre, or straight edges that a disc of known diameter
//! touched.
//!
//! The uncertainty of the alignment is **not a term of the margin**. Part, prohibited region and
//! finishing toolpath come from one drawing and shift together, so the tool keeps its distance from the
//! part.
//!
//! The uncertainty tells how far the part may sit off in its stock, and against features that were made
//! before. Drawn clamps do not move with the part: enlarge them by the uncertainty.

pub mod file;
mod fit;
mod part;

use fit::{Fit, Observation};
pub use part::{PartEdges, StraightEdge};
use thiserror::Error;

use crate::Mm2;

/// A place of the part in drawing coordinates, and the tool's centre there in machine coordinates; mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbePoint {
    /// The place in the drawing. For an edge, a place near the touched one.
    pub drawing_mm: Mm2,
    /// The machine coordinates of the tool's centre.
    pub machine_mm: Mm2,
}

/// Probe points of one alignment, and their accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbePoints {
    /// Points to which the tool's centre was brought.
    pub points: Vec<ProbePoint>,
    /// Straight edges that the tool touched from the free side.
    pub edges: Vec<ProbePoint>,
    /// Diameter of the probe or tool that touched the edges, mm.
    pub probe_diameter_mm: f64,
    /// Largest error of a probe point, mm.
    pub probe_error_mm: f64,
    /// Largest permitted difference between drawing and machine, mm.
    pub tolerance_mm: f64,
}

/// Default of [`ProbePoints::probe_error_mm`], mm.
pub const PROBE_ERROR_MM: f64 = 0.005;
/// Default of [`ProbePoints::tolerance_mm`], mm.
pub const TOLERANCE_MM: f64 = 0.05;
/// Largest permitted ratio of the part's error to the probe error. Above it the alignment is refused.
const WORST_GAIN: f64 = 40.0;
/// Ratio above which [`Alignment::poor`] is set.
const POOR_GAIN: f64 = 10.0;
/// Steps per degree to which rotations are rounded. One step is 2 nm at a metre.
const DEGREE_PARTS: f64 = 1e7;
/// Largest shift of a place by rounding, mm. Origins are rounded to 1 µm, as work offsets are.
const ROUND_MM: f64 = 0.000_75;

/// Result of an alignment, and its accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// Rotation of the drawing about its origin, counter-clockwise, degrees in (−180, 180].
    pub rotation_deg: f64,
    /// Machine coordinates of the drawing's origin, mm.
    pub origin_mm: Mm2,
    /// Whether the rotation was measured. Otherwise the drawing's axes count as the machine's.
    pub turned: bool,
    /// Distance of each probe point from its fitted position, mm: the points, then the edges.
    pub residuals_mm: Vec<f64>,
    /// Largest error of a place of the part, mm, with every probe point off by the probe error. It
    /// includes rounding.
    pub uncertainty_mm: f64,
    /// Corner of the part's box with that error, drawing coordinates, mm.
    pub worst_at_mm: Mm2,
    /// Whether the error is many times the probe error.
    pub poor: bool,
}

/// Reason why the probe points give no alignment.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum AlignmentError {
    /// The probe points are too few.
    #[error(
        "too few probe points. For the position alone, give one point, or one touch on each of two edges \
         that are not parallel. To measure the rotation too, give two points, or two touches on one edge \
         and one on another."
    )]
    TooFew,
    /// A figure is out of range.
    #[error("the {what} is {value} mm. Give a value between {least} and {most} mm.")]
    Figure {
        /// Name of the figure.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Least accepted value, mm.
        least: f64,
        /// Largest accepted value, mm.
        most: f64,
    },
    /// The part has no straight edge near the place.
    #[error("the part has no straight edge near {near}. Give a place on the touched edge.")]
    NoEdge {
        /// The place, drawing coordinates.
        near: Mm2,
    },
    /// Two edges are about equally near to the place.
    #[error(
        "two straight edges are about equally near to {near}. \
         Give a place nearer to the touched edge, away from its ends."
    )]
    WhichEdge {
        /// The place, drawing coordinates.
        near: Mm2,
    },
    /// The order of two touches along an edge is ambiguous.
    #[error(
        "the order of the two touches on the edge near {near} is ambiguous. \
         Give places that are as far apart in the drawing as the touches are on the machine."
    )]
    WhichEnd {
        /// The place of the first touch in the drawing.
        near: Mm2,
    },
    /// Two points have different distances in the drawing and on the machine.
    #[error(
        "points {first} and {second} are {drawing_mm:.4} mm apart in the drawing and {machine_mm:.4} mm \
         on the machine. The difference is more than {tolerance_mm} mm. \
         Check the points, the drawing's unit and the machine's steps per mm."
    )]
    Distance {
        /// The first point, from 1.
        first: usize,
        /// The second, from 1.
        second: usize,
        /// Their distance in the drawing, mm.
        drawing_mm: f64,
        /// Their distance on the machine, mm.
        machine_mm: f64,
        /// Largest permitted difference, mm.
        tolerance_mm: f64,
    },
    /// A probe point does not fit the others.
    #[error(
        "{touch} lies {off_mm:.4} mm off the position that the other probe points give. \
         At most {tolerance_mm} mm is permitted. Touch it again, and check its place in the drawing."
    )]
    Residual {
        /// Name of the probe point.
        touch: String,
        /// Its distance from the fitted position, mm.
        off_mm: f64,
        /// Largest permitted distance, mm.
        tolerance_mm: f64,
    },
    /// An edge touch lies beyond the end of its edge.
    #[error(
        "edge touch {touch} would lie {beyond_mm:.3} mm beyond the end of its edge. \
         Check which edge you touched, and from which side."
    )]
    BeyondEdge {
        /// The edge touch, from 1.
        touch: usize,
        /// Distance beyond the end, mm.
        beyond_mm: f64,
    },
    /// The probe points do not determine the alignment.
    #[error(
        "the probe points do not determine the alignment: the points coincide, or all edges are parallel. \
         Touch an edge square to the first, or a point far away."
    )]
    Undetermined,
    /// The probe points are too near each other for the size of the part.
    #[error(
        "a probe error of {probe_error_mm} mm can shift the part by {off_mm:.3} mm at {at_mm}: \
         the probe points are {apart_mm:.2} mm apart, the part is {size_mm:.2} mm long. \
         Touch points farther apart, and edges square to each other."
    )]
    Degenerate {
        /// Error of each probe point, mm.
        probe_error_mm: f64,
        /// Error of the part that follows, mm.
        off_mm: f64,
        /// Place with that error, drawing coordinates, mm.
        at_mm: Mm2,
        /// Largest distance between two probe points, mm.
        apart_mm: f64,
        /// Diagonal of the part's box, mm.
        size_mm: f64,
    },
}

/// Fits the alignment to probe points by least squares. It offsets edge touches by the probe's radius.
///
/// One point, or one touch on each of two edges, gives the position alone. Two points, or two touches on
/// one edge and one on another, give the rotation too. The fit averages additional probe points.
///
/// # Errors
/// [`AlignmentError`] when the probe points contradict each other, or do not determine the alignment well
/// enough.
pub fn align(part: &PartEdges, touches: &ProbePoints) -> Result<Alignment, AlignmentError> {
    touches.check()?;
    let observations = touches.observations(part)?;
    let start = first_rotation(touches, &observations)?;
    let fit = Fit::of(&observations, start, part).ok_or(AlignmentError::Undetermined)?;
    let residuals_mm: Vec<f64> = observations.iter().map(|each| fit.residual_mm(each)).collect();
    touches.check_residuals(&residuals_mm)?;
    check_ends(&fit, &observations, touches)?;
    let (off_mm, worst_at_mm) = fit.uncertainty(&observations, touches.probe_error_mm, part);
    let gain = off_mm / touches.probe_error_mm;
    if gain > WORST_GAIN {
        return Err(AlignmentError::Degenerate {
            probe_error_mm: touches.probe_error_mm,
            off_mm,
            at_mm: worst_at_mm,
            apart_mm: touches.apart_mm(),
            size_mm: part.size_mm(),
        });
    }
    let rotation_deg = wrapped((fit.rotation.to_degrees() * DEGREE_PARTS).round() / DEGREE_PARTS);
    let Mm2 { x, y } = fit.origin(rotation_deg.to_radians());
    let micrometre = |c: f64| (c * 1000.0).round() / 1000.0;
    Ok(Alignment {
        rotation_deg,
        origin_mm: Mm2::new(micrometre(x), micrometre(y)),
        turned: start.is_some(),
        residuals_mm,
        uncertainty_mm: off_mm + ROUND_MM,
        worst_at_mm,
        poor: gain > POOR_GAIN,
    })
}

impl Alignment {
    /// Machine coordinates of a point of the drawing, mm.
    #[must_use]
    pub fn machine_mm(&self, drawing_mm: Mm2) -> Mm2 {
        drawing_mm.turned(self.rotation_deg.to_radians()) + self.origin_mm
    }

    /// Largest residual, mm.
    #[must_use]
    pub fn residual_mm(&self) -> f64 {
        self.residuals_mm.iter().copied().fold(0.0, f64::max)
    }
}

impl ProbePoints {
    fn check(&self) -> Result<(), AlignmentError> {
        let least_probe = if self.edges.is_empty() { 0.0 } else { 0.001 };
        let figures = [
            ("probe diameter", self.probe_diameter_mm, least_probe, 500.0),
            ("probe error", self.probe_error_mm, 0.000_1, 1.0),
            ("tolerance", self.tolerance_mm, 0.000_1, 10.0),
        ];
        for (what, value, least, most) in figures {
            if !(least..=most).contains(&value) {
                return Err(AlignmentError::Figure { what, value, least, most });
            }
        }
        let pairs = (0..self.points.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        for (i, j) in pairs {
            let (a, b) = (self.points[i], self.points[j]);
            let drawing_mm = a.drawing_mm.distance(b.drawing_mm);
            let machine_mm = a.machine_mm.distance(b.machine_mm);
            if (drawing_mm - machine_mm).abs() > self.tolerance_mm {
                let (first, second, tolerance_mm) = (i + 1, j + 1, self.tolerance_mm);
                return Err(AlignmentError::Distance { first, second, drawing_mm, machine_mm, tolerance_mm });
            }
        }
        Ok(())
    }

    fn observations(&self, part: &PartEdges) -> Result<Vec<Observation>, AlignmentError> {
        let points = self.points.iter().map(|&touch| Ok(Observation::Point(touch)));
        let edges = self.edges.iter().map(|&touch| {
            let edge = part.edge_near(touch.drawing_mm)?;
            Ok(Observation::Edge { touch, edge, radius_mm: self.probe_diameter_mm / 2.0 })
        });
        points.chain(edges).collect()
    }

    fn check_residuals(&self, residuals_mm: &[f64]) -> Result<(), AlignmentError> {
        let worst = residuals_mm.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        match worst {
            Some((index, &off_mm)) if off_mm > self.tolerance_mm => {
                let touch = match index.checked_sub(self.points.len()) {
                    None => format!("point {}", index + 1),
                    Some(edge) => format!("edge touch {}", edge + 1),
                };
                Err(AlignmentError::Residual { touch, off_mm, tolerance_mm: self.tolerance_mm })
            }
            _ => Ok(()),
        }
    }

    /// Largest distance between two probe points, mm.
    fn apart_mm(&self) -> f64 {
        let all: Vec<Mm2> = self.points.iter().chain(&self.edges).map(|touch| touch.machine_mm).collect();
        all.iter().flat_map(|&a| all.iter().map(move |&b| a.distance(b))).fold(0.0, f64::max)
    }
}

/// Start of the search for the rotation, rad; `None` when the probe points are too few to measure it.
fn first_rotation(
    touches: &ProbePoints,
    observations: &[Observation],
) -> Result<Option<f64>, AlignmentError> {
    if let [first, others @ ..] = &touches.points[..] {
        let away = |touch: &ProbePoint| first.drawing_mm.distance(touch.drawing_mm);
        if let Some(farthest) = others.iter().max_by(|a, b| away(a).total_cmp(&away(b))) {
            return Ok(Some(turn_between(first, farthest)));
        }
    }
    let edges: Vec<(ProbePoint, StraightEdge)> = observations.iter().filter_map(Observation::edge).collect();
    let pairs = (0..edges.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
    for (i, j) in pairs {
        let ((a, edge), (b, other)) = (edges[i], edges[j]);
        if !edge.is_along(&other) {
            continue;
        }
        let along = edge.along(b.drawing_mm) - edge.along(a.drawing_mm);
        if along.abs() < a.machine_mm.distance(b.machine_mm) / 2.0 {
            return Err(AlignmentError::WhichEnd { near: a.drawing_mm });
        }
        let on = |touch: ProbePoint| ProbePoint { drawing_mm: edge.foot(touch.drawing_mm), ..touch };
        return Ok(Some(turn_between(&on(a), &on(b))));
    }
    match (touches.points.len(), edges.len()) {
        (1, 0) | (0, 2) => Ok(None),
        _ => Err(AlignmentError::TooFew),
    }
}

fn check_ends(fit: &Fit, observations: &[Observation], touches: &ProbePoints) -> Result<(), AlignmentError> {
    let edges = observations.iter().filter_map(Observation::edge);
    for (index, (touch, edge)) in edges.enumerate() {
        let beyond_mm = edge.beyond(fit.drawing_mm(touch.machine_mm));
        if beyond_mm > touches.tolerance_mm {
            return Err(AlignmentError::BeyondEdge { touch: index + 1, beyond_mm });
        }
    }
    Ok(())
}

/// Angle from the line between two points of the drawing to that line on the machine, rad.
fn turn_between(a: &ProbePoint, b: &ProbePoint) -> f64 {
    let angle = |p: Mm2, q: Mm2| (q - p).angle();
    angle(a.machine_mm, b.machine_mm) - angle(a.drawing_mm, b.drawing_mm)
}

/// The angle in (−180, 180] degrees.
fn wrapped(degrees: f64) -> f64 {
    let turned = degrees.rem_euclid(360.0);
    if turned > 180.0 { turned - 360.0 } else { turned }
}

//! How the workpiece lies on the machine: the rotation and offset that take drawing coordinates to machine coordinates.
//!
//! A machine point is `R(rotation) · drawing + origin`. It is found from places of the part that the tool or a probe was
//! brought to: points, or touches of straight edges by a disc of known diameter.
//!
//! What it is uncertain by is **no term of the margin**: part, prohibited region and finishing path are one drawing and shift
//! together, so the tool keeps its distance from the part that it cuts. It decides whether that part lies within its stock,
//! and how well it meets features that were made before. It does count toward what is drawn but does not move with the
//! part, such as clamps: draw those larger by it.

pub mod file;
mod fit;
mod part;

use fit::{Fit, Observation};
pub use part::{Part, StraightEdge};
use thiserror::Error;

use crate::units::mm_pair;

/// A place of the part, drawing coordinates, and where the tool's centre was, machine coordinates; mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbePoint {
    /// The place in the drawing; of a touched edge, a place near where it was touched.
    pub drawing_mm: (f64, f64),
    /// The machine coordinates of the tool's centre.
    pub machine_mm: (f64, f64),
}

/// What was touched, and how well.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbePoints {
    /// Points that the tool's centre was brought to.
    pub points: Vec<ProbePoint>,
    /// Straight edges that the tool touched from the free side.
    pub edges: Vec<ProbePoint>,
    /// Diameter of the probe or tool that touched the edges, mm.
    pub probe_diameter_mm: f64,
    /// How far a touch may be wrong, mm.
    pub probe_error_mm: f64,
    /// How far drawing and machine may disagree, mm.
    pub tolerance_mm: f64,
}

/// A touch may be wrong by this unless told otherwise, mm.
pub const PROBE_ERROR_MM: f64 = 0.005;
/// Drawing and machine may disagree by this unless told otherwise, mm.
pub const TOLERANCE_MM: f64 = 0.05;
/// Refused when a touch error moves some place of the part by more than this many times itself.
const WORST_GAIN: f64 = 40.0;
/// Warned about from this on.
const POOR_GAIN: f64 = 10.0;
/// Rotations are rounded to so many parts of a degree: 2 nm at a metre.
const DEGREE_PARTS: f64 = 1e7;
/// Origins are rounded to 1 µm, as offsets of a machine are; what that moves a place by, mm.
const ROUND_MM: f64 = 0.000_75;

/// How the workpiece lies, and how well that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// Rotation of the drawing about its origin, counter-clockwise, degrees in (−180, 180].
    pub rotation_deg: f64,
    /// Machine coordinates of the drawing's origin, mm.
    pub origin_mm: (f64, f64),
    /// Whether the rotation was measured; otherwise the drawing's axes were taken for the machine's.
    pub turned: bool,
    /// How far each touch is from where it should be, mm: the points, then the edges.
    pub residuals_mm: Vec<f64>,
    /// How far a place of the part can be off when every touch is wrong by the touch error, mm.
    pub uncertainty_mm: f64,
    /// The corner of the part's box where that is, drawing coordinates, mm.
    pub worst_at_mm: (f64, f64),
    /// Whether that is many times the touch error.
    pub poor: bool,
}

/// Why touches do not say how the workpiece lies.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum AlignmentError {
    /// Too few touches.
    #[error(
        "too few touches: give one point, or touches of two edges that are not parallel (no rotation is measured then); two points, or two touches along one edge and one of another, to measure the rotation too"
    )]
    TooFew,
    /// A figure is no length.
    #[error("the {what} of {value} mm is none. Give one between {least} and {most} mm.")]
    Figure {
        /// Which figure.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The least.
        least: f64,
        /// The most.
        most: f64,
    },
    /// There is no straight edge there.
    #[error("the part has no straight edge near {}. Give a place on the edge that was touched.", mm_pair(*near))]
    NoEdge {
        /// The place, drawing coordinates.
        near: (f64, f64),
    },
    /// Two edges are as near.
    #[error("{} is about as near to another straight edge. Give a place nearer to the edge that was touched, away from its ends.", mm_pair(*near))]
    WhichEdge {
        /// The place, drawing coordinates.
        near: (f64, f64),
    },
    /// The order of two touches along an edge is not known.
    #[error("of the two touches along the edge near {} it is not known which is which: give places as far apart along the edge in the drawing as the touches are on the machine", mm_pair(*near))]
    WhichEnd {
        /// The place of the first in the drawing.
        near: (f64, f64),
    },
    /// Distances differ.
    #[error(
        "points {first} and {second} are {drawing_mm:.4} mm apart in the drawing and {machine_mm:.4} mm on the machine, which differs by more than {tolerance_mm} mm. Check the points, the drawing's unit and the machine's steps per mm."
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
        /// What they may differ by, mm.
        tolerance_mm: f64,
    },
    /// A touch does not fit the others.
    #[error(
        "{touch} is {off_mm:.4} mm from where the other touches put it, more than {tolerance_mm} mm. Touch again, and check which place of the drawing it is."
    )]
    Residual {
        /// Which touch.
        touch: String,
        /// How far it is off, mm.
        off_mm: f64,
        /// What it may be off, mm.
        tolerance_mm: f64,
    },
    /// A touch lies beyond its edge.
    #[error(
        "edge touch {touch} would lie {beyond_mm:.3} mm beyond the end of its edge. Check which edge of the drawing was touched, and from which side."
    )]
    BeyondEdge {
        /// The touch, from 1.
        touch: usize,
        /// How far beyond, mm.
        beyond_mm: f64,
    },
    /// The touches leave something open.
    #[error(
        "these touches do not fix how the part lies: points in one place, or edges that are all parallel. Touch another edge that stands square to the first, or a point far away."
    )]
    Undetermined,
    /// The touches are too near each other for the part.
    #[error(
        "a touch error of {probe_error_mm} mm could put the part off by {off_mm:.3} mm at {}: the touches are {apart_mm:.2} mm apart, the part is {size_mm:.2} mm long. Touch points farther apart, and edges that stand square to each other.",
        mm_pair(*at_mm)
    )]
    Degenerate {
        /// What each touch may be wrong by, mm.
        probe_error_mm: f64,
        /// What that comes to, mm.
        off_mm: f64,
        /// Where, drawing coordinates.
        at_mm: (f64, f64),
        /// Largest distance between two touches, mm.
        apart_mm: f64,
        /// The diagonal of the part's box, mm.
        size_mm: f64,
    },
}

/// Finds how the part lies from touches of it: by least squares, edges compensated by the probe's radius.
///
/// One point, or touches of two edges, give the offset alone. The rotation is measured with two points, or two touches along
/// one edge and one of another; more of them are averaged.
///
/// # Errors
/// [`AlignmentError`] when the touches contradict each other or do not fix the part well enough.
pub fn align(part: &Part, touches: &ProbePoints) -> Result<Alignment, AlignmentError> {
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
    let (x, y) = fit.origin(rotation_deg.to_radians());
    let micrometre = |c: f64| (c * 1000.0).round() / 1000.0;
    Ok(Alignment {
        rotation_deg,
        origin_mm: (micrometre(x), micrometre(y)),
        turned: start.is_some(),
        residuals_mm,
        uncertainty_mm: off_mm + ROUND_MM,
        worst_at_mm,
        poor: gain > POOR_GAIN,
    })
}

impl Alignment {
    /// Machine coordinates of a drawing's point, mm.
    #[must_use]
    pub fn machine_mm(&self, drawing_mm: (f64, f64)) -> (f64, f64) {
        let (sin, cos) = self.rotation_deg.to_radians().sin_cos();
        let (x, y) = drawing_mm;
        (x * cos - y * sin + self.origin_mm.0, x * sin + y * cos + self.origin_mm.1)
    }

    /// The largest residual, mm.
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
            ("touch error", self.probe_error_mm, 0.000_1, 1.0),
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
            let drawing_mm = far(a.drawing_mm, b.drawing_mm);
            let machine_mm = far(a.machine_mm, b.machine_mm);
            if (drawing_mm - machine_mm).abs() > self.tolerance_mm {
                let (first, second, tolerance_mm) = (i + 1, j + 1, self.tolerance_mm);
                return Err(AlignmentError::Distance { first, second, drawing_mm, machine_mm, tolerance_mm });
            }
        }
        Ok(())
    }

    fn observations(&self, part: &Part) -> Result<Vec<Observation>, AlignmentError> {
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

    /// The largest distance between two touches, mm.
    fn apart_mm(&self) -> f64 {
        let all: Vec<(f64, f64)> =
            self.points.iter().chain(&self.edges).map(|touch| touch.machine_mm).collect();
        all.iter().flat_map(|&a| all.iter().map(move |&b| far(a, b))).fold(0.0, f64::max)
    }
}

/// Where the search for the rotation begins, rad; `None` when the touches are too few to measure it.
fn first_rotation(
    touches: &ProbePoints,
    observations: &[Observation],
) -> Result<Option<f64>, AlignmentError> {
    if let [first, others @ ..] = &touches.points[..] {
        let away = |touch: &ProbePoint| far(first.drawing_mm, touch.drawing_mm);
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
        if along.abs() < far(a.machine_mm, b.machine_mm) / 2.0 {
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

/// The angle by which the way between two touches is turned on the machine.
fn turn_between(a: &ProbePoint, b: &ProbePoint) -> f64 {
    let angle = |p: (f64, f64), q: (f64, f64)| (q.1 - p.1).atan2(q.0 - p.0);
    angle(a.machine_mm, b.machine_mm) - angle(a.drawing_mm, b.drawing_mm)
}

fn far(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// The angle in (−180, 180].
fn wrapped(degrees: f64) -> f64 {
    let turned = degrees.rem_euclid(360.0);
    if turned > 180.0 { turned - 360.0 } else { turned }
}

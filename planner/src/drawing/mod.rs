//! The drawing: the curves of a DXF file in millimetres, and the closed contours that they form.
//!
//! ```text
//! bytes ── tags ── file (entities, blocks, layers) ── flatten ──> curves in mm
//! curves in mm ── chain ──> profile, repairs, problems
//! ```

mod chain;
mod doubled;
mod entity;
mod file;
mod fit;
mod fit_points;
mod flatten;
mod hatch;
mod import;
mod join;
mod overlap;
mod placement;
mod repair;
mod spline;
mod tags;
mod untangle;

use crate::{Box2, Mm2};
use std::collections::BTreeMap;
use std::sync::Arc;

pub use chain::{Chained, Gaps, JOIN_MM, OpenChain, chain};
pub(crate) use file::{DxfFile, read};
pub use fit::CURVE_MM;
pub use flatten::CURVES_MAX;
pub(crate) use import::curves_of;
pub use import::{EntityFilter, SCALES, SIZE_MAX, census, import, read_file};
use keepout_kernel::{ArcView, LatticeError};
pub use repair::{Problem, Repair};
pub use tags::{Damage, FilePlace};
use thiserror::Error;

/// The entity of the file that a curve comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Entity type by its DXF name.
    pub kind: &'static str,
    /// The entity's handle, or 0 if the file gives no handle.
    pub handle: u64,
    /// The place where the entity begins in the file.
    pub at: FilePlace,
    /// Its layer.
    pub layer: Arc<str>,
    /// The block that holds it, if any.
    pub block: Option<Arc<str>>,
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} on layer \"{}\" ({}", self.kind, self.layer, self.at)?;
        if let Some(block) = &self.block {
            write!(f, ", in block \"{block}\"")?;
        }
        if self.handle == 0 { write!(f, ")") } else { write!(f, ", handle {:X})", self.handle) }
    }
}

/// A curve of the drawing, in millimetres.
#[derive(Clone, Debug, PartialEq)]
pub enum RawCurve {
    /// A straight line.
    Line {
        /// Start point.
        from: Mm2,
        /// End point.
        to: Mm2,
    },
    /// A circular arc of at most one turn.
    Arc {
        /// The arc.
        arc: ArcView,
        /// Start point, from the file or computed from the angle.
        from: Mm2,
        /// End point.
        to: Mm2,
    },
    /// A piece of an ellipse or spline.
    Bezier(Box<RawBezier>),
}

/// A rational Bézier curve: control points in mm, and their positive weights.
#[derive(Clone, Debug, PartialEq)]
pub struct RawBezier {
    /// Control points; the curve begins at the first and ends at the last.
    pub points: Vec<Mm2>,
    /// One weight for each control point.
    pub weights: Vec<f64>,
}

impl RawBezier {
    /// The point at the parameter `t` in [0, 1].
    #[must_use]
    pub fn at(&self, t: f64) -> Mm2 {
        let weighted = |(&Mm2 { x, y }, &w): (&Mm2, &f64)| [x * w, y * w, w];
        let mut row: Vec<[f64; 3]> = self.points.iter().zip(&self.weights).map(weighted).collect();
        while row.len() > 1 {
            let pair = |pair: &[[f64; 3]]| [0, 1, 2].map(|i| pair[0][i] * (1.0 - t) + pair[1][i] * t);
            row = row.windows(2).map(pair).collect();
        }
        row.first().map_or(Mm2::ZERO, |[x, y, w]| Mm2::new(x / w, y / w))
    }

    /// Returns the curve, or a line if it has two control points.
    #[must_use]
    fn simplified(self) -> RawCurve {
        match self.points[..] {
            [from, to] => RawCurve::Line { from, to },
            _ => RawCurve::Bezier(Box::new(self)),
        }
    }
}

impl RawCurve {
    fn bezier(points: Vec<Mm2>, weights: Vec<f64>) -> Self {
        RawBezier { points, weights }.simplified()
    }

    /// The start point.
    #[must_use]
    pub fn from(&self) -> Mm2 {
        match self {
            Self::Line { from, .. } | Self::Arc { from, .. } => *from,
            Self::Bezier(bezier) => bezier.points[0],
        }
    }

    /// The end point.
    #[must_use]
    pub fn to(&self) -> Mm2 {
        match self {
            Self::Line { to, .. } | Self::Arc { to, .. } => *to,
            Self::Bezier(bezier) => bezier.points[bezier.points.len() - 1],
        }
    }

    fn set_from(&mut self, point: Mm2) {
        match self {
            Self::Line { from, .. } | Self::Arc { from, .. } => *from = point,
            Self::Bezier(bezier) => bezier.points[0] = point,
        }
    }

    fn set_to(&mut self, point: Mm2) {
        match self {
            Self::Line { to, .. } | Self::Arc { to, .. } => *to = point,
            Self::Bezier(bezier) => {
                if let Some(last) = bezier.points.last_mut() {
                    *last = point;
                }
            }
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::Line { from, to } => from.is_finite() && to.is_finite(),
            Self::Arc { arc, from, to } => {
                [arc.centre.into(), *from, *to].into_iter().all(Mm2::is_finite)
                    && [arc.radius, arc.start, arc.sweep].into_iter().all(f64::is_finite)
            }
            Self::Bezier(bezier) => {
                bezier.points.iter().all(|point| point.is_finite())
                    && bezier.weights.iter().all(|w| w.is_finite() && *w > 0.0)
            }
        }
    }
}

/// A polyline chain: curves that one entity joins end to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolylineChain {
    /// Index of the first curve in [`Drawing::curves`].
    pub first: usize,
    /// Index after the last curve.
    pub end: usize,
    /// Whether the last curve joins the first.
    pub closed: bool,
    /// Index of the entity in [`Drawing::origins`].
    pub origin: u32,
}

/// The curves of a DXF file, and the notes of the reader.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// The curves of the visible model space, in file order.
    pub curves: Vec<RawCurve>,
    /// The polyline chains that the entities form of them.
    pub runs: Vec<PolylineChain>,
    /// The entities that the curves come from.
    pub origins: Vec<Origin>,
    /// The drawing's unit and its source in words.
    pub unit: String,
    /// The source of the unit.
    pub unit_source: UnitSource,
    /// The unit with the scale, mm.
    pub unit_mm: f64,
    /// Layers with visible curves, and the number of curves taken from each.
    pub layers: BTreeMap<Arc<str>, usize>,
    /// Number of entities left out for each reason: text, dimensions, hidden layers, construction lines.
    pub left_out: BTreeMap<String, usize>,
    /// Curves that are left out, each with the reason.
    pub aside: Vec<LeftOutCurve>,
    /// Other notes on the file, for the user.
    pub remarks: Vec<String>,
}

/// Source of a drawing's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UnitSource {
    /// The file states it.
    #[default]
    File,
    /// The user states it.
    User,
    /// Neither states it.
    Assumed,
}

/// A curve of the drawing that bounds no contour.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOutCurve {
    /// Points along it, mm.
    pub points: Vec<Mm2>,
    /// The reason.
    pub reason: LeftOutReason,
}

/// Reason why a curve is left out.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeftOutReason {
    /// It is off, frozen or invisible.
    Hidden,
    /// Its line type has gaps.
    LineType(String),
    /// Its layer is not selected.
    Layer(Arc<str>),
    /// It does not close.
    Open,
}

impl std::fmt::Display for LeftOutReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Hidden => write!(f, "hidden, off or frozen"),
            Self::LineType(name) => write!(f, "construction lines (line type {name})"),
            Self::Layer(name) => write!(f, "on layer \"{name}\", which is not selected"),
            Self::Open => write!(f, "open curves"),
        }
    }
}

impl Drawing {
    /// The box around the curves' ends and control points.
    fn bounds(&self) -> Box2 {
        let points = self.curves.iter().flat_map(|curve| match curve {
            RawCurve::Bezier(bezier) => bezier.points.clone(),
            other => vec![other.from(), other.to()],
        });
        Box2::around(points).unwrap_or_default()
    }
}

/// Reasons why a drawing can not be used.
#[derive(Debug, Error)]
pub enum DrawingError {
    /// The file is not DXF, or it is damaged.
    #[error("not a readable DXF file: {0}. Export it again from the CAD system, as DXF R12 or later.")]
    Damaged(#[from] Damage),
    /// The unit of `--units`, or the unit that the file states, is not supported.
    #[error(
        "unknown unit \"{name}\". Give the drawing's unit with --units: mm, cm, m, µm (or um), in (or inches), ft \
         or mil."
    )]
    Unit {
        /// The unit's name.
        name: String,
    },
    /// The factor of `--scale` is out of range.
    #[error("--scale {factor} is out of range. Give a factor between 0.000001 and 1000000, such as 0.1.")]
    Scale {
        /// The factor.
        factor: f64,
    },
    /// The numbers of an entity define no curve.
    #[error("{origin}: {problem}. Repair it in the CAD system, or leave out its layer.")]
    BadEntity {
        /// The entity.
        origin: Box<Origin>,
        /// The fault.
        problem: &'static str,
    },
    /// The drawing has more than [`CURVES_MAX`] curves, or inserts its blocks too often.
    #[error(
        "the drawing has more than {CURVES_MAX} curves, or inserts its blocks millions of times. The reader \
         stopped at {origin}. Choose layers with --layer, or export only the profile."
    )]
    TooMany {
        /// The entity at which the reader stopped.
        origin: Box<Origin>,
    },
    /// A coordinate lies outside the lattice.
    #[error("{origin}: {source}. {}", remedy(*bounds))]
    OffLattice {
        /// The entity.
        origin: Box<Origin>,
        /// The coordinate.
        source: LatticeError,
        /// The box around the drawing.
        bounds: Box2,
    },
    /// A selected layer has no visible curves.
    #[error("layer \"{asked}\" has no visible curves. Layers with curves: {}.", list(present))]
    NoLayer {
        /// The layer.
        asked: String,
        /// The layers that have curves.
        present: Vec<String>,
    },
    /// A layer to leave out is not in the file.
    #[error(
        "layer \"{asked}\" of --without-layer is not in the drawing. Layers with curves: {}.",
        list(present)
    )]
    StrangeLayer {
        /// The layer.
        asked: String,
        /// The layers that have curves.
        present: Vec<String>,
    },
    /// The drawing has no curve to machine.
    #[error("there is no curve to machine. Left out: {}.", counted(left_out))]
    Empty {
        /// Number of entities left out for each reason.
        left_out: BTreeMap<String, usize>,
    },
    /// The chord-error bound for splines and ellipses is out of range.
    #[error("--curve-mm {curve_mm} is out of range. Give a value between 0.0001 and 1 mm.")]
    CurveBound {
        /// The given bound, mm.
        curve_mm: f64,
    },
    /// Some contours can not be closed.
    #[error("{}", problems_text(problems, gaps.as_ref()))]
    Problems {
        /// The problems.
        problems: Vec<Problem>,
        /// The joining tolerance that closes all gaps.
        gaps: Option<Gaps>,
    },
}

/// Largest number of problems that the message lists; it counts the rest.
const LISTED: usize = 5;

fn problems_text(problems: &[Problem], gaps: Option<&Gaps>) -> String {
    let mut text: Vec<String> = gaps.map(ToString::to_string).into_iter().collect();
    text.extend(problems.iter().take(LISTED).map(ToString::to_string));
    if problems.len() > LISTED {
        text.push(format!("… and {} more: `keepout inspect` lists and draws them.", problems.len() - LISTED));
    }
    text.join("\n")
}

/// The remedy for a drawing that leaves the lattice. A drawing that is small enough can be moved.
fn remedy(bounds: Box2) -> String {
    const ROOM_MM: f64 = 5300.0;
    let (Box2 { low, high }, Mm2 { x: width, y: height }) = (bounds, bounds.size());
    if low.x.min(low.y) > -ROOM_MM && high.x.max(high.y) < ROOM_MM {
        "One of its arcs or curves reaches that far: repair it in the CAD system, or leave out its layer."
            .into()
    } else if width.max(height) < ROOM_MM {
        let (x, y) = ((-low.x).floor(), (-low.y).floor());
        format!(
            "The drawing lies far from its origin: move it with --offset-mm {x:.0},{y:.0}, or check its \
             units (--units)."
        )
    } else if width.max(height) < 1e9 {
        format!(
            "The drawing is {:.1} m × {:.1} m large: check its units (--units), or choose layers with \
             --layer.",
            width / 1000.0,
            height / 1000.0
        )
    } else {
        "The drawing is larger than any part: check its units (--units), or choose layers with --layer."
            .into()
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

fn counted(reasons: &BTreeMap<String, usize>) -> String {
    let each = |(why, count): (&String, &usize)| format!("{count} {why}");
    let all: Vec<String> = reasons.iter().map(each).collect();
    if all.is_empty() { "nothing, the drawing is empty".into() } else { all.join(", ") }
}

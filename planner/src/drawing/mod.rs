//! The drawing: the curves of a DXF file in millimetres, and the closed contours that they form.
//!
//! ```text
//! bytes ── tags ── file (entities, blocks, layers) ── flatten ──> curves in mm
//! curves in mm ── chain ──> profile, repairs, problems
//! ```

mod chain;
mod damage;
mod doubled;
mod entity;
mod entity_curves;
mod error;
mod file;
mod fit;
mod fit_points;
mod flatten;
mod follow;
mod hatch;
mod import;
mod join;
mod overlap;
mod placement;
mod repair;
mod repeated;
mod spline;
mod tags;
mod unseen;
mod untangle;

use crate::{Box2, Mm2};
use std::collections::BTreeMap;
use std::sync::Arc;

pub use chain::{Chained, Gaps, JOIN_MM, OpenChain, chain};
pub use damage::{Damage, FilePlace};
pub use error::DrawingError;
pub(crate) use file::{DxfFile, read};
pub use fit::CURVE_MM;
pub use flatten::CURVES_MAX;
pub use import::{EntityFilter, SCALES, SIZE_MAX, census, import, read_file};
pub(crate) use import::{NO_END, curves_of};
use keepout_kernel::ArcView;
pub use repair::{Problem, Repair};

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

//! The drawing: what the DXF file says, before anything is decided about it.
//!
//! ```text
//! bytes ── tags ── file (entities, blocks, layers) ── flatten ──> curves in mm ── chain ──> profile, repairs, problems
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

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

pub use chain::{Chained, JOIN_MM, OpenChain, chain};
pub(crate) use file::{DxfFile, read};
pub use fit::CURVE_MM;
pub use flatten::CURVES_MAX;
pub(crate) use import::curves_of;
pub use import::{EntityFilter, SIZE_MAX, census, import, read_file};
use keepout_kernel::LatticeError;
pub use repair::{Problem, Repair};
pub use tags::{Damage, FilePlace};
use thiserror::Error;

/// Where a curve comes from in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Entity type, as DXF names it.
    pub kind: &'static str,
    /// The entity's handle, or 0 when the file gives none.
    pub handle: u64,
    /// Where it begins in the file.
    pub at: FilePlace,
    /// Its layer.
    pub layer: Arc<str>,
    /// The block it was set in with, if any.
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
        /// Where it begins.
        from: (f64, f64),
        /// Where it ends.
        to: (f64, f64),
    },
    /// A circular arc; angles in radians, `sweep` positive counter-clockwise, `|sweep| ≤ 2π`.
    Arc {
        /// The centre.
        centre: (f64, f64),
        /// The radius, positive.
        radius: f64,
        /// Where it begins, as the file gives it or as computed from the angle.
        from: (f64, f64),
        /// Where it ends.
        to: (f64, f64),
        /// Polar angle of the beginning.
        start: f64,
        /// Angle turned through.
        sweep: f64,
    },
    /// A piece of an ellipse or spline.
    Bezier(Box<RawBezier>),
}

/// A rational Bézier curve: control points in mm, and their positive weights.
#[derive(Clone, Debug, PartialEq)]
pub struct RawBezier {
    /// Control points; the curve begins at the first and ends at the last.
    pub points: Vec<(f64, f64)>,
    /// As many weights.
    pub weights: Vec<f64>,
}

impl RawBezier {
    /// The point at the parameter `t` in [0, 1].
    #[must_use]
    pub fn at(&self, t: f64) -> (f64, f64) {
        let weighted = |(&(x, y), &w): (&(f64, f64), &f64)| [x * w, y * w, w];
        let mut row: Vec<[f64; 3]> = self.points.iter().zip(&self.weights).map(weighted).collect();
        while row.len() > 1 {
            let pair = |pair: &[[f64; 3]]| [0, 1, 2].map(|i| pair[0][i] * (1.0 - t) + pair[1][i] * t);
            row = row.windows(2).map(pair).collect();
        }
        row.first().map_or((0.0, 0.0), |[x, y, w]| (x / w, y / w))
    }

    /// The curve, as a line when it has no more than two control points.
    #[must_use]
    fn simplified(self) -> RawCurve {
        match self.points[..] {
            [from, to] => RawCurve::Line { from, to },
            _ => RawCurve::Bezier(Box::new(self)),
        }
    }
}

impl RawCurve {
    fn bezier(points: Vec<(f64, f64)>, weights: Vec<f64>) -> Self {
        RawBezier { points, weights }.simplified()
    }

    /// Where it begins.
    #[must_use]
    pub fn from(&self) -> (f64, f64) {
        match self {
            Self::Line { from, .. } | Self::Arc { from, .. } => *from,
            Self::Bezier(bezier) => bezier.points[0],
        }
    }

    /// Where it ends.
    #[must_use]
    pub fn to(&self) -> (f64, f64) {
        match self {
            Self::Line { to, .. } | Self::Arc { to, .. } => *to,
            Self::Bezier(bezier) => bezier.points[bezier.points.len() - 1],
        }
    }

    fn set_from(&mut self, point: (f64, f64)) {
        match self {
            Self::Line { from, .. } | Self::Arc { from, .. } => *from = point,
            Self::Bezier(bezier) => bezier.points[0] = point,
        }
    }

    fn set_to(&mut self, point: (f64, f64)) {
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
        let finite = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
        match self {
            Self::Line { from, to } => finite(from) && finite(to),
            Self::Arc { centre, radius, from, to, start, sweep } => {
                [centre, from, to].into_iter().all(finite)
                    && [radius, start, sweep].into_iter().all(|value| value.is_finite())
            }
            Self::Bezier(bezier) => {
                bezier.points.iter().all(finite) && bezier.weights.iter().all(|w| w.is_finite() && *w > 0.0)
            }
        }
    }
}

/// Curves that one entity joins end to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PolylineChain {
    /// The first of them, among the drawing's curves.
    pub first: usize,
    /// One past the last.
    pub end: usize,
    /// Whether the last is joined to the first.
    pub closed: bool,
    /// The entity, among the drawing's origins.
    pub origin: u32,
}

/// What was read from a DXF file.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// The curves of the visible model space, in file order.
    pub curves: Vec<RawCurve>,
    /// How entities join them.
    pub runs: Vec<PolylineChain>,
    /// The entities they come from.
    pub origins: Vec<Origin>,
    /// The file's unit, in words, and whether it was stated.
    pub unit: String,
    /// Layers with visible curves, and how many curves were taken from each.
    pub layers: BTreeMap<Arc<str>, usize>,
    /// What was left out, by reason, with counts: text, dimensions, hidden layers, construction lines.
    pub left_out: BTreeMap<String, usize>,
    /// What else a person should know about the file.
    pub remarks: Vec<String>,
}

impl Drawing {
    /// Least and largest x and y of the curves' ends and control points, mm.
    fn bounds(&self) -> ((f64, f64), (f64, f64)) {
        let points = self.curves.iter().flat_map(|curve| match curve {
            RawCurve::Bezier(bezier) => bezier.points.clone(),
            other => vec![other.from(), other.to()],
        });
        points.fold(((f64::MAX, f64::MAX), (f64::MIN, f64::MIN)), |(low, high), p| {
            ((low.0.min(p.0), low.1.min(p.1)), (high.0.max(p.0), high.1.max(p.1)))
        })
    }
}

/// Why a drawing can not be used.
#[derive(Debug, Error)]
pub enum DrawingError {
    /// The file can not be read.
    #[error("can not read {}: {source}. Check the path and the permissions.", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is larger than is read into memory.
    #[error(
        "the drawing has {bytes} bytes; at most {SIZE_MAX} are read. Purge it in the CAD system, or export only the profile."
    )]
    TooLarge {
        /// Its size.
        bytes: u64,
    },
    /// The file is no DXF, or a damaged one.
    #[error("not a readable DXF file: {0}. Export it again from the CAD system, as DXF R12 or later.")]
    Damaged(#[from] Damage),
    /// The unit asked for is unknown, or the file's unit is none of a workshop's.
    #[error("unknown unit \"{name}\". Say with --units which it is: mm, cm, m, in, ft.")]
    Unit {
        /// The unit's name.
        name: String,
    },
    /// An entity has numbers that make no curve.
    #[error("{origin}: {problem}. Repair it in the CAD system, or leave out its layer.")]
    BadEntity {
        /// The entity.
        origin: Box<Origin>,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// There are more curves than are taken.
    #[error(
        "more than {CURVES_MAX} curves, or blocks set in millions of times; the last one taken is {origin}. Choose layers with --layer, or export only the profile."
    )]
    TooMany {
        /// The entity reached.
        origin: Box<Origin>,
    },
    /// A coordinate is off the lattice.
    #[error("{origin}: {source}. {}", remedy(*low, *high))]
    OffLattice {
        /// The entity.
        origin: Box<Origin>,
        /// The coordinate.
        source: LatticeError,
        /// Least x and y of the drawing, mm.
        low: (f64, f64),
        /// Largest x and y of the drawing, mm.
        high: (f64, f64),
    },
    /// A layer that was asked for has no curves.
    #[error("layer \"{asked}\" has no visible curves. Layers with curves: {}.", list(present))]
    NoLayer {
        /// The layer.
        asked: String,
        /// The layers that have curves.
        present: Vec<String>,
    },
    /// A layer that was to be left out is nowhere in the file.
    #[error(
        "layer \"{asked}\", which is to be left out, is not in the drawing. Layers with curves: {}.",
        list(present)
    )]
    StrangeLayer {
        /// The layer.
        asked: String,
        /// The layers that have curves.
        present: Vec<String>,
    },
    /// There is nothing to machine.
    #[error("there is no curve to machine. Left out: {}.", counted(left_out))]
    Empty {
        /// What was left out.
        left_out: BTreeMap<String, usize>,
    },
    /// The bound for curves is none.
    #[error("--curve-mm {curve_mm} is no bound for curves. Give one between 0.0001 and 1 mm.")]
    CurveBound {
        /// What was given, mm.
        curve_mm: f64,
    },
    /// Contours that can not be closed.
    #[error("{}", problems_text(.0))]
    Problems(Vec<Problem>),
}

/// Problems that are told one by one; more are only counted.
const TOLD: usize = 5;

fn problems_text(problems: &[Problem]) -> String {
    let mut text: Vec<String> = problems.iter().take(TOLD).map(ToString::to_string).collect();
    if problems.len() > TOLD {
        text.push(format!("… and {} more: `keepout inspect` lists and draws them.", problems.len() - TOLD));
    }
    text.join("\n")
}

/// What to do about a drawing that leaves the lattice: move it, when it is small enough.
fn remedy(low: (f64, f64), high: (f64, f64)) -> String {
    const ROOM_MM: f64 = 5300.0;
    let (width, height) = (high.0 - low.0, high.1 - low.1);
    if low.0.min(low.1) > -ROOM_MM && high.0.max(high.1) < ROOM_MM {
        "One of its arcs or curves reaches that far: repair it in the CAD system, or leave out its layer."
            .into()
    } else if width.max(height) < ROOM_MM {
        let (x, y) = ((-low.0).floor(), (-low.1).floor());
        format!(
            "The drawing lies far from its origin: move it with --offset-mm {x:.0},{y:.0}, or check its units (--units)."
        )
    } else if width.max(height) < 1e9 {
        format!(
            "The drawing is {:.1} m × {:.1} m large: check its units (--units), or choose layers with --layer.",
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

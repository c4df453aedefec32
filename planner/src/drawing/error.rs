//! Why a drawing can not be used.

use std::collections::BTreeMap;

use keepout_kernel::LatticeError;
use thiserror::Error;

use super::{CURVES_MAX, Damage, Gaps, Origin, Problem};
use crate::{Box2, Mm2};

/// Reasons why a drawing can not be used.
#[derive(Debug, Error)]
pub enum DrawingError {
    /// The file is not DXF, or it is damaged.
    #[error("not a readable DXF file: {0}. {remedy}", remedy = .0.remedy())]
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

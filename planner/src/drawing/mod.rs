//! The drawing: what the DXF file says, before anything is decided about it.

mod chain;
mod import;

use std::collections::BTreeMap;
use std::path::PathBuf;

use keepout_kernel::{LatticeError, Point};
use thiserror::Error;

pub use chain::{Chained, JOIN_MM, Repair, chain};
pub use import::{SIZE_MAX, import, read_file};

use crate::units::place;

/// Where a curve comes from in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Entity type, as DXF names it.
    pub kind: &'static str,
    /// The entity's handle, or 0 when the file gives none.
    pub handle: u64,
    /// Its position among the drawing's entities, from 1.
    pub number: usize,
    /// Its layer.
    pub layer: String,
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} no. {} on layer \"{}\"", self.kind, self.number, self.layer)?;
        if self.handle == 0 { Ok(()) } else { write!(f, " (handle {:X})", self.handle) }
    }
}

/// A curve of the drawing, in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

/// A curve and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnCurve {
    /// The curve.
    pub curve: RawCurve,
    /// Its origin.
    pub origin: Origin,
}

/// What was read from a DXF file.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// The curves of the visible model space, in file order.
    pub curves: Vec<DrawnCurve>,
    /// The file's unit, in words, and whether it was stated.
    pub unit: String,
    /// What was left out, by reason, with counts: text, dimensions, hidden layers, construction lines.
    pub left_out: BTreeMap<String, usize>,
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
    #[error(
        "not a readable DXF file: {reason}. Export it again from the CAD system, as ASCII DXF R12 or later."
    )]
    Damaged {
        /// What the reader stumbled over, and where.
        reason: String,
    },
    /// The unit asked for is unknown, or the file's unit has no length.
    #[error("unknown unit \"{name}\". Use one of mm, cm, m, in, ft.")]
    Unit {
        /// The unit's name.
        name: String,
    },
    /// The profile has curves that are not supported.
    #[error(
        "{count} {kind} on layer \"{layer}\" can not be machined yet. Explode or convert to lines and arcs, or choose other layers with --layer."
    )]
    Unsupported {
        /// The entity's type.
        kind: String,
        /// How many there are.
        count: usize,
        /// The layer of the first one.
        layer: String,
    },
    /// An entity has numbers that make no curve.
    #[error("{origin}: {problem}. Repair it in the CAD system.")]
    BadEntity {
        /// The entity.
        origin: Box<Origin>,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A coordinate is off the lattice.
    #[error("{origin}: {source}. Move the drawing nearer to its origin, or check its units (--units).")]
    OffLattice {
        /// The entity.
        origin: Box<Origin>,
        /// The coordinate.
        source: LatticeError,
    },
    /// There is nothing to machine.
    #[error("no lines, arcs, circles or polylines{}. Layers with curves: {}.", on_layers(.asked), list(.present))]
    Empty {
        /// The layers asked for; empty means all.
        asked: Vec<String>,
        /// The layers that have curves.
        present: Vec<String>,
    },
    /// A contour does not close.
    #[error("open contour: {origin} ends at {} with nothing to join; {}. Close it in the CAD system, or allow it with --join-mm.", place(*.at), gap_text(*.gap_mm))]
    Open {
        /// The curve with the loose end.
        origin: Box<Origin>,
        /// The loose end.
        at: Point,
        /// Distance to the nearest other loose end, if there is one.
        gap_mm: Option<f64>,
    },
    /// More than two curves meet.
    #[error("{count} curve ends meet at {}, one of them {origin}: which contour goes on where is not decided. Remove doubled or construction lines, choose layers with --layer, or lower --join-mm when the drawing has details that small.", place(*.at))]
    Branch {
        /// One of the curves.
        origin: Box<Origin>,
        /// Where they meet.
        at: Point,
        /// How many ends meet.
        count: usize,
    },
}

fn on_layers(asked: &[String]) -> String {
    if asked.is_empty() { String::new() } else { format!(" on layer {}", list(asked)) }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

fn gap_text(gap_mm: Option<f64>) -> String {
    match gap_mm {
        Some(gap) => format!("the nearest other loose end is {gap:.3} mm away"),
        None => "there is no other loose end".into(),
    }
}

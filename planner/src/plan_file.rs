//! The plan file: versioned, hashed, self-contained. What is read from it is certified before use.
//!
//! Layout: the 12 bytes `KEEPOUT PLAN`, the version as `u16`, the SHA-256 of the payload, the payload (postcard).
//! Numbers are little-endian.

use std::io::Write;
use std::path::{Path, PathBuf};

use keepout_kernel::exact::arc::ArcError;
use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Arc, Curve, LatticeError, Length, Point, Segment, Turn};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::finish::{FinishingLoop, FinishingPath};
use crate::machine::{MachineError, MachineProfile};
use crate::margin::Budget;
use crate::plan::{Cut, Pass, Plan, Provenance, Remark};
use crate::profile::{MachinedSide, Profile, ProfileEdge, ProfileLoop, SourceCurve};
use crate::text_file;

const MAGIC: &[u8; 12] = b"KEEPOUT PLAN";
/// The version that is written, and the only one that is read.
pub const VERSION: u16 = 4;
const HEADER: usize = MAGIC.len() + 2 + 32;
/// Largest plan file that is read, in bytes.
pub const SIZE_MAX: u64 = 1 << 30;

/// Why a plan file can not be read or written.
#[derive(Debug, Error)]
pub enum PlanFileError {
    /// The file can not be read.
    #[error("can not read {}: {source}. Check the path, or make the plan with `keepout plan`.", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file can not be written.
    #[error("can not write {}: {source}. Nothing was changed.", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is no plan file.
    #[error("this is no plan file: it does not begin with \"KEEPOUT PLAN\". Make one with `keepout plan`.")]
    NoPlan,
    /// It was written by another version.
    #[error(
        "the plan file has version {found}, this program reads version {VERSION}. Make the plan again from the drawing."
    )]
    Version {
        /// The file's version.
        found: u16,
    },
    /// Its bytes are not those that were written.
    #[error(
        "the plan file is damaged: its contents do not match its hash. Copy it again, or make the plan again from the drawing."
    )]
    Damaged,
    /// It is larger than any plan.
    #[error("the plan file has {bytes} bytes; at most {SIZE_MAX} are read")]
    TooLarge {
        /// Its size.
        bytes: u64,
    },
    /// Its contents make no plan.
    #[error("the plan file holds no valid plan: {0}. Make it again from the drawing.")]
    Contents(String),
}

#[derive(Serialize, Deserialize)]
struct Stored {
    drawing: String,
    drawing_hash: [u8; 32],
    unit: String,
    remarks: Vec<(Option<[i32; 2]>, String)>,
    placed: Option<(f64, (f64, f64))>,
    machine: MachineProfile,
    side: MachinedSide,
    tool_radius: i32,
    stock_to_leave: i32,
    budget: Budget,
    loops: Vec<StoredLoop>,
    zones: Vec<StoredLoop>,
    travel: Option<[i32; 4]>,
    cut: Cut,
    passes: Vec<StoredPass>,
}

#[derive(Serialize, Deserialize)]
struct StoredPass {
    stock_to_leave: i32,
    feed_mm_min: Option<u32>,
    loops: Vec<(Vec<StoredCurve>, u64)>,
    residual_length_mm: f64,
    residual_area_mm2: Option<f64>,
    profile_length_mm: f64,
}

#[derive(Serialize, Deserialize)]
struct StoredLoop {
    edges: Vec<(StoredCurve, i32)>,
    sources: Vec<StoredSource>,
}

/// A spline or ellipse: control points, weights, and the edges that stand for it.
#[derive(Serialize, Deserialize)]
struct StoredSource {
    control: Vec<([i32; 2], u64)>,
    edges: (u32, u32),
}

#[derive(Serialize, Deserialize)]
enum StoredCurve {
    Line([i32; 4]),
    Arc { ends: [i32; 4], centre: [i32; 2], left: bool },
}

/// The SHA-256 of bytes, as recorded for drawings.
#[must_use]
pub fn hash(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}

/// A hash as hexadecimal digits.
#[must_use]
pub fn hex(hash: &[u8]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The plan as the bytes of a plan file.
///
/// # Errors
/// [`PlanFileError::Contents`] when it can not be serialised.
pub fn encode(plan: &Plan) -> Result<Vec<u8>, PlanFileError> {
    let payload =
        postcard::to_allocvec(&stored(plan)).map_err(|error| PlanFileError::Contents(error.to_string()))?;
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(hash(&payload));
    bytes.extend(payload);
    Ok(bytes)
}

/// The plan in the bytes of a plan file; it is not certified yet.
///
/// # Errors
/// [`PlanFileError`] saying what is wrong with the file.
pub fn decode(bytes: &[u8]) -> Result<Plan, PlanFileError> {
    let rest = bytes.strip_prefix(MAGIC).ok_or(PlanFileError::NoPlan)?;
    let (version, rest) = rest.split_first_chunk::<2>().ok_or(PlanFileError::Damaged)?;
    let found = u16::from_le_bytes(*version);
    if found != VERSION {
        return Err(PlanFileError::Version { found });
    }
    let (expected, payload) = rest.split_first_chunk::<32>().ok_or(PlanFileError::Damaged)?;
    if hash(payload) != *expected {
        return Err(PlanFileError::Damaged);
    }
    let (stored, left): (Stored, _) =
        postcard::take_from_bytes(payload).map_err(|error| PlanFileError::Contents(error.to_string()))?;
    if left.is_empty() { restored(stored) } else { Err(PlanFileError::Damaged) }
}

/// Writes the plan to `path`, by a temporary file and a rename.
///
/// # Errors
/// [`PlanFileError::Write`]; the file at `path` is then as it was.
pub fn save(plan: &Plan, path: &Path) -> Result<(), PlanFileError> {
    let bytes = encode(plan)?;
    write_whole(path, &bytes).map_err(|source| PlanFileError::Write { path: path.to_path_buf(), source })
}

/// Writes `bytes` to `path` whole or not at all: to a temporary file beside it, flushed, then renamed. Links are
/// followed; what exists and is no regular file is left alone.
///
/// # Errors
/// The system's error; the temporary file is removed.
pub fn write_whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let followed = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let path = followed.as_path();
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, "it is not a regular file"));
    }
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    let written = std::fs::File::create(&temporary)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| std::fs::rename(&temporary, path));
    if written.is_err() {
        let _ = std::fs::remove_file(&temporary);
    }
    written
}

/// Reads the plan at `path`; it is not certified yet.
///
/// # Errors
/// [`PlanFileError`] saying what is wrong with the file.
pub fn load(path: &Path) -> Result<Plan, PlanFileError> {
    let failed = |source| PlanFileError::Read { path: path.to_path_buf(), source };
    let bytes = std::fs::metadata(path).map_err(failed)?.len();
    if bytes > SIZE_MAX {
        return Err(PlanFileError::TooLarge { bytes });
    }
    let read = text_file::read_up_to(path, SIZE_MAX).map_err(failed)?;
    let bytes = read.len() as u64;
    if bytes > SIZE_MAX { Err(PlanFileError::TooLarge { bytes }) } else { decode(&read) }
}

fn stored(plan: &Plan) -> Stored {
    let provenance = &plan.provenance;
    Stored {
        drawing: provenance.name.clone(),
        drawing_hash: provenance.hash,
        unit: provenance.unit.clone(),
        remarks: provenance.remarks.iter().map(stored_remark).collect(),
        placed: provenance.placed,
        machine: plan.machine.clone(),
        side: plan.side,
        tool_radius: plan.tool_radius.units(),
        stock_to_leave: plan.stock_to_leave.units(),
        budget: plan.budget.clone(),
        loops: plan.profile.loops.iter().map(stored_loop).collect(),
        zones: plan.zones.loops.iter().map(stored_loop).collect(),
        travel: plan.travel.map(|travel| {
            let (x0, y0, x1, y1) = travel.corners();
            [x0, y0, x1, y1]
        }),
        cut: plan.cut,
        passes: plan.passes.iter().map(stored_pass).collect(),
    }
}

fn stored_remark(remark: &Remark) -> (Option<[i32; 2]>, String) {
    (remark.at.map(|at| [at.x.units(), at.y.units()]), remark.text.clone())
}

fn restored_remark((at, text): (Option<[i32; 2]>, String)) -> Result<Remark, PlanFileError> {
    let at = at.map(|[x, y]| Point::from_units(x.into(), y.into())).transpose()?;
    Ok(Remark { at, text })
}

fn stored_pass(pass: &Pass) -> StoredPass {
    let finishing = |each: &FinishingLoop| {
        let component = u64::try_from(each.component).unwrap_or(u64::MAX);
        (each.curves.iter().map(stored_curve).collect(), component)
    };
    StoredPass {
        stock_to_leave: pass.stock_to_leave.units(),
        feed_mm_min: pass.feed_mm_min,
        loops: pass.path.loops.iter().map(finishing).collect(),
        residual_length_mm: pass.path.residual_length_mm,
        residual_area_mm2: pass.path.residual_area_mm2,
        profile_length_mm: pass.path.profile_length_mm,
    }
}

fn restored_pass(stored: &StoredPass) -> Result<Pass, PlanFileError> {
    let mut loops = Vec::new();
    for (curves, component) in &stored.loops {
        let curves = curves.iter().map(restored_curve).collect::<Result<_, _>>()?;
        let component =
            usize::try_from(*component).map_err(|error| PlanFileError::Contents(error.to_string()))?;
        loops.push(FinishingLoop { curves, component });
    }
    let path = FinishingPath {
        loops,
        residual_length_mm: stored.residual_length_mm,
        residual_area_mm2: stored.residual_area_mm2,
        profile_length_mm: stored.profile_length_mm,
    };
    let stock_to_leave = Length::from_units(stored.stock_to_leave.into())?;
    Ok(Pass { stock_to_leave, feed_mm_min: stored.feed_mm_min, path })
}

fn stored_loop(each: &ProfileLoop) -> StoredLoop {
    StoredLoop {
        edges: each.edges.iter().map(|edge| (stored_curve(&edge.curve), edge.chord_error.units())).collect(),
        sources: each.sources.iter().map(stored_source).collect(),
    }
}

fn restored_loop(each: &StoredLoop) -> Result<ProfileLoop, PlanFileError> {
    let edge = |(curve, chord_error): &(StoredCurve, i32)| {
        Ok(ProfileEdge {
            curve: restored_curve(curve)?,
            chord_error: Length::from_units((*chord_error).into())?,
        })
    };
    let edges = each.edges.iter().map(edge).collect::<Result<_, PlanFileError>>()?;
    let sources = each.sources.iter().map(restored_source).collect::<Result<_, PlanFileError>>()?;
    Ok(ProfileLoop { edges, sources })
}

fn restored_profile(loops: &[StoredLoop]) -> Result<Profile, PlanFileError> {
    Ok(Profile { loops: loops.iter().map(restored_loop).collect::<Result<_, _>>()? })
}

fn stored_source(source: &SourceCurve) -> StoredSource {
    let index = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
    let curve = &source.curve;
    let control = curve.control().iter().zip(curve.weights());
    StoredSource {
        control: control.map(|(p, &weight)| ([p.x.units(), p.y.units()], weight)).collect(),
        edges: (index(source.first), index(source.end)),
    }
}

fn restored_source(source: &StoredSource) -> Result<SourceCurve, PlanFileError> {
    let index = |i: u32| usize::try_from(i).unwrap_or(usize::MAX);
    let point = |&([x, y], _): &([i32; 2], u64)| Point::from_units(x.into(), y.into());
    let control = source.control.iter().map(point).collect::<Result<_, _>>()?;
    let weights = source.control.iter().map(|&(_, weight)| weight).collect();
    let curve = Bezier::new(control, weights).map_err(|error| PlanFileError::Contents(error.to_string()))?;
    Ok(SourceCurve { curve, first: index(source.edges.0), end: index(source.edges.1) })
}

fn stored_curve(curve: &Curve) -> StoredCurve {
    let xy = |p: Point| [p.x.units(), p.y.units()];
    let ([a, b], [c, d]) = (xy(curve.from()), xy(curve.to()));
    match curve {
        Curve::Line(_) => StoredCurve::Line([a, b, c, d]),
        Curve::Arc(arc) => StoredCurve::Arc {
            ends: [a, b, c, d],
            centre: xy(arc.centre()),
            left: arc.turn() == Turn::CounterClockwise,
        },
    }
}

fn restored(stored: Stored) -> Result<Plan, PlanFileError> {
    let length = |units: i32| Length::from_units(units.into()).map_err(PlanFileError::from);
    let texts =
        [&stored.drawing, &stored.unit].into_iter().chain(stored.remarks.iter().map(|remark| &remark.1));
    if texts.into_iter().any(|text| text.contains(char::is_control)) {
        return Err(PlanFileError::Contents("its texts hold what can not be shown".into()));
    }
    let passes = stored.passes.iter().map(restored_pass).collect::<Result<Vec<_>, _>>()?;
    if passes.is_empty() {
        return Err(PlanFileError::Contents("it has no finishing pass".into()));
    }
    Ok(Plan {
        provenance: Provenance {
            name: stored.drawing,
            hash: stored.drawing_hash,
            unit: stored.unit,
            remarks: stored.remarks.into_iter().map(restored_remark).collect::<Result<_, _>>()?,
            placed: stored.placed,
        },
        tool_radius: length(stored.tool_radius)?,
        stock_to_leave: length(stored.stock_to_leave)?,
        machine: stored.machine.checked()?,
        side: stored.side,
        budget: stored.budget,
        profile: restored_profile(&stored.loops)?,
        zones: restored_profile(&stored.zones)?,
        travel: stored.travel.map(|[x0, y0, x1, y1]| Window::from_corners(x0, y0, x1, y1)),
        cut: stored.cut,
        passes,
    })
}

fn restored_curve(curve: &StoredCurve) -> Result<Curve, PlanFileError> {
    let at = |x: i32, y: i32| Point::from_units(x.into(), y.into());
    Ok(match *curve {
        StoredCurve::Line([a, b, c, d]) => Curve::Line(Segment { from: at(a, b)?, to: at(c, d)? }),
        StoredCurve::Arc { ends: [a, b, c, d], centre: [x, y], left } => {
            let turn = if left { Turn::CounterClockwise } else { Turn::Clockwise };
            Curve::Arc(Arc::new(at(a, b)?, at(c, d)?, at(x, y)?, turn)?)
        }
    })
}

impl From<LatticeError> for PlanFileError {
    fn from(error: LatticeError) -> Self {
        Self::Contents(error.to_string())
    }
}

impl From<ArcError> for PlanFileError {
    fn from(error: ArcError) -> Self {
        Self::Contents(error.to_string())
    }
}

impl From<MachineError> for PlanFileError {
    fn from(error: MachineError) -> Self {
        Self::Contents(error.to_string())
    }
}

//! The plan file: versioned, hashed and self-contained. A reader certifies the plan before use.
//!
//! Implements SR-20.
//!
//! Layout: the 12 bytes `KEEPOUT PLAN`, the version as `u16`, the SHA-256 of the payload, the payload
//! (postcard). Numbers are little-endian.

use std::path::Path;

use thiserror::Error;

use crate::file::{FileError, FileKind};
use crate::plan::Plan;
use crate::sha256::hash;

const MAGIC: &[u8; 12] = b"KEEPOUT PLAN";
/// Format version of the files that this program writes. It reads no other version.
pub const VERSION: u16 = 10;
const HEADER: usize = MAGIC.len() + 2 + 32;
/// Largest size of a plan file, bytes.
pub const SIZE_MAX: u64 = 1 << 30;
/// The kind of this file.
pub static PLAN_FILE: FileKind = FileKind {
    unreadable: "Check the path, or make the plan with `keepout plan`.",
    too_large: "Check the path, or make the plan with `keepout plan`.",
    ..FileKind::new("plan file")
};

/// Reason why a plan file cannot be read or written.
#[derive(Debug, Error)]
pub enum PlanFileError {
    /// The file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not a plan file.
    #[error("this is no plan file: it does not begin with \"KEEPOUT PLAN\". Make one with `keepout plan`.")]
    NoPlan,
    /// Another version of the program wrote the file.
    #[error(
        "the plan file has version {found}, this program reads version {VERSION}. \
         Make the plan again from the drawing."
    )]
    Version {
        /// The file's version.
        found: u16,
    },
    /// The contents do not match the hash.
    #[error(
        "the plan file is damaged: its contents do not match its hash. \
         Copy it again, or make the plan again from the drawing."
    )]
    Damaged,
    /// The contents are not a valid plan.
    #[error("the plan file holds no valid plan: {0}. Make it again from the drawing.")]
    Contents(String),
}

/// Bytes of a plan file with this plan.
///
/// # Errors
/// [`PlanFileError::Contents`] when the plan cannot be serialised.
pub fn encode(plan: &Plan) -> Result<Vec<u8>, PlanFileError> {
    let payload = postcard::to_allocvec(plan).map_err(|error| PlanFileError::Contents(error.to_string()))?;
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(hash(&payload));
    bytes.extend(payload);
    Ok(bytes)
}

/// The plan in the bytes of a plan file. It is not certified yet.
///
/// # Errors
/// [`PlanFileError`] that names the fault of the file.
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
    let (plan, left): (Plan, _) =
        postcard::take_from_bytes(payload).map_err(|error| PlanFileError::Contents(error.to_string()))?;
    if left.is_empty() { checked(plan) } else { Err(PlanFileError::Damaged) }
}

/// Writes the plan to `path` through a temporary file and a rename.
///
/// # Errors
/// [`PlanFileError::File`]; the file at `path` then stays unchanged. [`PlanFileError::Contents`] as [`encode`].
pub fn save(plan: &Plan, path: &Path) -> Result<(), PlanFileError> {
    Ok(PLAN_FILE.write(path, &encode(plan)?)?)
}

/// Reads the plan at `path`. It is not certified yet.
///
/// # Errors
/// [`PlanFileError`] that names the fault of the file.
pub fn load(path: &Path) -> Result<Plan, PlanFileError> {
    decode(&PLAN_FILE.read(path, SIZE_MAX)?)
}

/// Refuses contents that no planner writes, before the certificate.
fn checked(mut plan: Plan) -> Result<Plan, PlanFileError> {
    let provenance = &plan.provenance;
    let has_control = |text: &String| text.contains(char::is_control);
    if has_control(&provenance.name)
        || has_control(&provenance.unit)
        || provenance.remarks.iter().any(|remark| has_control(&remark.text))
    {
        return Err(PlanFileError::Contents("its texts hold control characters".into()));
    }
    let numbers: std::collections::BTreeSet<usize> = provenance.numbers.iter().copied().collect();
    if ![0, plan.profile.loops.len()].contains(&provenance.numbers.len())
        || numbers.len() < provenance.numbers.len()
        || numbers.contains(&0)
    {
        return Err(PlanFileError::Contents("its contours are not numbered one by one".into()));
    }
    if !provenance.left_out.iter().flatten().all(|point| point.is_finite()) {
        return Err(PlanFileError::Contents("a curve that was left out has no place".into()));
    }
    if plan.passes.is_empty() {
        return Err(PlanFileError::Contents("it has no finishing pass".into()));
    }
    plan.share_paths();
    plan.machine = plan.machine.checked().map_err(|error| PlanFileError::Contents(error.to_string()))?;
    Ok(plan)
}

//! The plan file: versioned, hashed, self-contained. What is read from it is certified before use.
//!
//! Layout: the 12 bytes `KEEPOUT PLAN`, the version as `u16`, the SHA-256 of the payload, the payload (postcard).
//! Numbers are little-endian.

use std::io::Write;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::plan::Plan;
use crate::text_file;

const MAGIC: &[u8; 12] = b"KEEPOUT PLAN";
/// The version that is written, and the only one that is read.
pub const VERSION: u16 = 5;
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
    let payload = postcard::to_allocvec(plan).map_err(|error| PlanFileError::Contents(error.to_string()))?;
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
    let (plan, left): (Plan, _) =
        postcard::take_from_bytes(payload).map_err(|error| PlanFileError::Contents(error.to_string()))?;
    if left.is_empty() { checked(plan) } else { Err(PlanFileError::Damaged) }
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

/// What no writer of plans writes is refused before anything is certified.
fn checked(mut plan: Plan) -> Result<Plan, PlanFileError> {
    let provenance = &plan.provenance;
    let hides = |text: &String| text.contains(char::is_control);
    if hides(&provenance.name)
        || hides(&provenance.unit)
        || provenance.remarks.iter().any(|remark| hides(&remark.text))
    {
        return Err(PlanFileError::Contents("its texts hold what can not be shown".into()));
    }
    if plan.passes.is_empty() {
        return Err(PlanFileError::Contents("it has no finishing pass".into()));
    }
    plan.machine = plan.machine.checked().map_err(|error| PlanFileError::Contents(error.to_string()))?;
    Ok(plan)
}

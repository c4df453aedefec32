//! The plan file: versioned, hashed and self-contained. A reader certifies the plan before use.
//!
//! Layout: the 12 bytes `KEEPOUT PLAN`, the version as `u16`, the SHA-256 of the payload, the payload
//! (postcard). Numbers are little-endian.

use std::io::Write;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::plan::Plan;
use crate::text_file;

const MAGIC: &[u8; 12] = b"KEEPOUT PLAN";
/// Format version of the files that this program writes. It reads no other version.
pub const VERSION: u16 = 5;
const HEADER: usize = MAGIC.len() + 2 + 32;
/// Largest size of a plan file, bytes.
pub const SIZE_MAX: u64 = 1 << 30;

/// Reason why a plan file cannot be read or written.
#[derive(Debug, Error)]
pub enum PlanFileError {
    /// The file cannot be read.
    #[error(
        "can not read {}: {source}. Check the path, or make the plan with `keepout plan`.",
        path.display()
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file cannot be written.
    #[error("can not write {}: {source}. Nothing was changed.", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
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
    /// The file is larger than [`SIZE_MAX`].
    #[error("the plan file has {bytes} bytes; the limit is {SIZE_MAX}")]
    TooLarge {
        /// Its size, bytes.
        bytes: u64,
    },
    /// The contents are not a valid plan.
    #[error("the plan file holds no valid plan: {0}. Make it again from the drawing.")]
    Contents(String),
}

/// SHA-256 of bytes, as the plan records it for the drawing.
#[must_use]
pub fn hash(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}

/// Hexadecimal digits of a hash.
#[must_use]
pub fn hex(hash: &[u8]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
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
/// [`PlanFileError::Write`]; the file at `path` then stays unchanged.
pub fn save(plan: &Plan, path: &Path) -> Result<(), PlanFileError> {
    let bytes = encode(plan)?;
    write_whole(path, &bytes).map_err(|source| PlanFileError::Write { path: path.to_path_buf(), source })
}

/// Writes `bytes` to `path` whole or not at all: to a temporary file beside it, which is flushed and
/// renamed. It follows links. It refuses a path that exists and is not a regular file.
///
/// # Errors
/// The error of the operating system. The temporary file is removed.
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

/// Reads the plan at `path`. It is not certified yet.
///
/// # Errors
/// [`PlanFileError`] that names the fault of the file.
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
    if plan.passes.is_empty() {
        return Err(PlanFileError::Contents("it has no finishing pass".into()));
    }
    plan.machine = plan.machine.checked().map_err(|error| PlanFileError::Contents(error.to_string()))?;
    Ok(plan)
}

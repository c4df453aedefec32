//! Reading a log.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::line::{self, Entry, LineError};
use super::write::Header;
use crate::time::Time;

/// Why a log can not be read.
#[derive(Debug, Error)]
pub enum LogReadError {
    /// The file can not be read.
    #[error("can not read the log {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is no log.
    #[error("this is no keepout log: {reason}")]
    NoLog {
        /// Why not.
        reason: String,
    },
    /// It is damaged before its end.
    #[error(
        "line {line} of the log does not match its checksum, and more follows: the log was damaged or changed. Nothing after line {} can be relied on.", line - 1
    )]
    Damaged {
        /// The line, from 1.
        line: usize,
    },
    /// A line that is intact says nothing that is understood.
    #[error("line {line} of the log: {source}. Was it written by another version?")]
    Line {
        /// The line, from 1.
        line: usize,
        /// Why.
        source: LineError,
    },
}

/// A log that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// What it says of its session.
    pub header: Header,
    /// What happened, in order.
    pub entries: Vec<(Time, Entry)>,
    /// Bytes at the end that are no whole line: the log was torn off there.
    pub torn: usize,
}

impl Log {
    /// Reads a log from a file.
    ///
    /// # Errors
    /// [`LogReadError`] naming the line.
    pub fn load(path: &Path) -> Result<Self, LogReadError> {
        let bytes =
            std::fs::read(path).map_err(|source| LogReadError::Read { path: path.to_path_buf(), source })?;
        Self::parse(&bytes)
    }

    /// Reads a log from its bytes.
    ///
    /// # Errors
    /// [`LogReadError`] naming the line.
    pub fn parse(bytes: &[u8]) -> Result<Self, LogReadError> {
        let lines = intact(bytes)?;
        let mut texts = lines.texts.iter();
        let no_log = |reason: &str| LogReadError::NoLog { reason: reason.into() };
        let first = texts.next().ok_or_else(|| no_log("it has no whole line"))?;
        let header = line::parse_header(first).map_err(|error| no_log(&error.to_string()))?;
        let mut entries: Vec<(Time, Entry)> = Vec::with_capacity(lines.texts.len());
        let mut reader = line::Reader::default();
        for (index, text) in texts.enumerate() {
            let entry =
                reader.parse(text).map_err(|source| LogReadError::Line { line: index + 2, source })?;
            if entries.last().is_some_and(|last| last.0 > entry.0) {
                return Err(LogReadError::Line { line: index + 2, source: LineError::Backwards });
            }
            entries.push(entry);
        }
        Ok(Self { header, entries, torn: lines.torn })
    }
}

struct Lines<'a> {
    texts: Vec<&'a str>,
    torn: usize,
}

/// The lines that match their checksums. Bytes behind the last of them are torn off, unless an intact line follows.
fn intact(bytes: &[u8]) -> Result<Lines<'_>, LogReadError> {
    let mut lines = Lines { texts: Vec::new(), torn: 0 };
    let mut sum = 0;
    let mut rest = bytes;
    while let Some(end) = memchr::memchr(b'\n', rest) {
        let Some((text, next)) = line::verified(&rest[..end], sum) else {
            return if follows(&rest[end + 1..]) {
                Err(LogReadError::Damaged { line: lines.texts.len() + 1 })
            } else {
                lines.torn = rest.len();
                Ok(lines)
            };
        };
        lines.texts.push(text);
        sum = next;
        rest = &rest[end + 1..];
    }
    lines.torn = rest.len();
    Ok(lines)
}

/// Whether a line that matches the line before it is among the bytes.
fn follows(bytes: &[u8]) -> bool {
    let mut before: Option<u32> = None;
    bytes.split(|&byte| byte == b'\n').any(|text| {
        let good = before.is_some_and(|sum| line::verified(text, sum).is_some());
        before = line::stated(text);
        good
    })
}

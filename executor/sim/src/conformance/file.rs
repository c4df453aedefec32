//! Recordings as JSON lines: a header, and one line for each event.
//!
//! ```text
//! {"keepout_conformance":3,"dialect":"grbl","digit_mm":0.001,"step_mm":0.0025}
//! {"at_us":15200,"what":{"begin":{"name":"hold in jog, 3 of 4","origin":[-100.0,-100.0]}}}
//! {"at_us":15200,"what":{"sent":"$J=G53G90G21X-107Y-100F6000\n"}}
//! {"at_us":19873,"what":{"received":"ok"}}
//! {"at_us":20010,"what":{"tool":{"at":[-100.0025,-100.0],"kind":"jog"}}}
//! {"at_us":98000,"what":"rest"}
//! ```
//!
//! `sent` holds bytes, `received` holds a line without its end, and `tool` holds the true position of a
//! simulated tool.

use std::io::{BufRead, BufReader, Read as _};
use std::path::Path;

use keepout_guard::Time;
use keepout_planner::file::{FileError, FileKind};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::recording::{EVENTS_MAX, RecordedEvent, Recording, RecordingHeader, What};

const VERSION: u32 = 3;
/// Longest accepted line, bytes.
const LINE_MAX: usize = 4096;
static RECORDING: FileKind = FileKind::new("recording");

/// Why a recording cannot be read.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not a recording.
    #[error(
        "line 1: not a conformance recording. Record one with `keepout doctor --conformance --record FILE`."
    )]
    Title,
    /// Another version wrote it.
    #[error("line 1: the recording has version {found}; this program reads version {VERSION}. Record again.")]
    Version {
        /// The file's version.
        found: u32,
    },
    /// A line is not an event.
    #[error("line {line}: not an event of a recording. The file is damaged; record again.")]
    Form {
        /// The line, from 1.
        line: usize,
    },
    /// A time is earlier than that of a previous line.
    #[error(
        "line {line}: its time is earlier than that of a previous line. The file is damaged; record again."
    )]
    Backwards {
        /// The line, from 1.
        line: usize,
    },
    /// A line is too long.
    #[error("line {line}: longer than {LINE_MAX} bytes. The file is damaged; record again.")]
    LongLine {
        /// The line, from 1.
        line: usize,
    },
    /// The recording has too many events.
    #[error("more than {EVENTS_MAX} events. Record fewer scenarios.")]
    TooLong,
}

/// Reads the recording at `path`.
///
/// # Errors
/// [`RecordingError`] naming the line.
pub fn load(path: &Path) -> Result<Recording, RecordingError> {
    read(BufReader::new(RECORDING.open(path)?), path)
}

/// Writes the recording to `path`, completely or not at all.
///
/// # Errors
/// [`FileError::Write`].
pub fn save(recording: &Recording, path: &Path) -> Result<(), FileError> {
    RECORDING.write(path, write(recording).as_bytes())
}

/// The first line of the file.
#[derive(Serialize, Deserialize)]
struct FirstLine {
    keepout_conformance: u32,
    #[serde(flatten)]
    header: RecordingHeader,
}

/// The recording as text.
#[must_use]
pub fn write(recording: &Recording) -> String {
    let first = FirstLine { keepout_conformance: VERSION, header: recording.header.clone() };
    let events = recording.events.iter().map(serde_json::to_string);
    let lines = std::iter::once(serde_json::to_string(&first)).chain(events);
    // Numbers, strings and enums always serialize to JSON.
    lines.map_while(Result::ok).map(|line| line + "\n").collect()
}

/// Reads a recording, with bounded memory. `path` appears in the error message.
///
/// # Errors
/// [`RecordingError`] naming the line.
pub fn read(mut from: impl BufRead, path: &Path) -> Result<Recording, RecordingError> {
    let mut number = 1;
    let first = line(&mut from, number, path)?.ok_or(RecordingError::Title)?;
    let mut recording = Recording { header: header(&first)?, events: Vec::new() };
    let mut before = Time::ZERO;
    loop {
        number += 1;
        let Some(text) = line(&mut from, number, path)? else { return Ok(recording) };
        let event: RecordedEvent =
            serde_json::from_str(&text).map_err(|_| RecordingError::Form { line: number })?;
        // A simulated tool's positions may be older than lines received before them.
        if !matches!(event.what, What::Tool { .. }) {
            if event.at < before {
                return Err(RecordingError::Backwards { line: number });
            }
            before = event.at;
        }
        if recording.events.len() >= EVENTS_MAX {
            return Err(RecordingError::TooLong);
        }
        recording.events.push(event);
    }
}

/// The next line without its end; `None` at the end of the file.
fn line(from: &mut impl BufRead, number: usize, path: &Path) -> Result<Option<String>, RecordingError> {
    let mut bytes = Vec::new();
    let read = from.by_ref().take(LINE_MAX as u64).read_until(b'\n', &mut bytes);
    read.map_err(RECORDING.read_error(path))?;
    match bytes.pop() {
        None => Ok(None),
        Some(b'\n') => String::from_utf8(bytes).map(Some).map_err(|_| RecordingError::Form { line: number }),
        Some(_) if bytes.len() + 1 >= LINE_MAX => Err(RecordingError::LongLine { line: number }),
        // The last line is incomplete.
        Some(_) => Err(RecordingError::Form { line: number }),
    }
}

fn header(line: &str) -> Result<RecordingHeader, RecordingError> {
    if line.starts_with("keepout-conformance 1 ") {
        return Err(RecordingError::Version { found: 1 });
    }
    let first: FirstLine = serde_json::from_str(line).map_err(|_| RecordingError::Title)?;
    if first.keepout_conformance != VERSION {
        return Err(RecordingError::Version { found: first.keepout_conformance });
    }
    let is_length = |value: f64| (0.0..=10.0).contains(&value);
    let holds = is_length(first.header.digit_mm) && is_length(first.header.step_mm);
    if holds { Ok(first.header) } else { Err(RecordingError::Form { line: 1 }) }
}

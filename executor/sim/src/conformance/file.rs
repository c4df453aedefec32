//! Recordings as text files: one event a line.
//!
//! ```text
//! keepout-conformance 1 dialect=grbl digit_mm=0.001 step_mm=0.0025
//! 15200 b -100.0 -100.0 cancel of one jog, 6000 mm/min, 3 of 10
//! 15200 s $J=G53G90G21X-107Y-100F6000\n
//! 19873 r ok
//! 19901 s ?
//! 20010 p -100.0025 -100.0 jog
//! 26230 r <Jog|MPos:-100.010,-100.000,0.000|FS:120,0>
//! 98000 e
//! ```
//!
//! Times are microseconds. `b` begins a scenario, `s` and `r` are bytes sent and a line received, `p` is the true position of a
//! simulated tool, `e` is rest.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader, Read as _};
use std::path::{Path, PathBuf};

use keepout_executor::session::SampleKind;
use keepout_executor::session::log::unescaped;
use keepout_guard::Time;
use keepout_planner::plan_file::write_whole;
use thiserror::Error;

use super::path::Mm2;
use super::recording::{EVENTS_MAX, Event, Header, Recording, What};

const TITLE: &str = "keepout-conformance";
const VERSION: &str = "1";
/// Longest line that is read, bytes.
const LINE_MAX: usize = 4096;

/// Why a recording can not be read.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file can not be read.
    #[error("can not read {}: {source}. Check the path.", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// It is not a recording.
    #[error(
        "line 1: not a conformance recording. Record one with `keepout doctor --conformance --record FILE`."
    )]
    Title,
    /// Another version wrote it.
    #[error("line 1: the recording has version {found}; this program reads version {VERSION}. Record again.")]
    Version {
        /// The file's version.
        found: String,
    },
    /// A line is not an event.
    #[error("line {line}: not an event of a recording. The file is damaged; record again.")]
    Form {
        /// The line, from 1.
        line: usize,
    },
    /// A time is before the one of an earlier line.
    #[error(
        "line {line}: its time is earlier than that of a line before it. The file is damaged; record again."
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
    /// It has too many events.
    #[error("more than {EVENTS_MAX} events. Record fewer scenarios.")]
    TooLong,
}

/// Reads the recording at `path`.
///
/// # Errors
/// [`RecordingError`] with the line.
pub fn load(path: &Path) -> Result<Recording, RecordingError> {
    let failed = |source| RecordingError::File { path: path.to_path_buf(), source };
    read(BufReader::new(File::open(path).map_err(failed)?)).map_err(|error| match error {
        RecordingError::File { source, .. } => failed(source),
        other => other,
    })
}

/// Writes the recording to `path`, whole or not at all.
///
/// # Errors
/// The system's.
pub fn save(recording: &Recording, path: &Path) -> std::io::Result<()> {
    write_whole(path, write(recording).as_bytes())
}

/// The recording as text.
#[must_use]
pub fn write(recording: &Recording) -> String {
    let Header { dialect, digit_mm, step_mm } = &recording.header;
    let mut text = format!("{TITLE} {VERSION} dialect={dialect} digit_mm={digit_mm:?} step_mm={step_mm:?}\n");
    for event in &recording.events {
        // Writing to a string does not fail.
        let _ = write!(text, "{} ", event.at.micros());
        let _ = match &event.what {
            What::Begin { name, origin } => writeln!(text, "b {:?} {:?} {name}", origin.x, origin.y),
            What::Sent(bytes) => writeln!(text, "s {}", bytes.escape_ascii()),
            What::Received(line) => writeln!(text, "r {}", line.escape_ascii()),
            What::Rest => writeln!(text, "e"),
            What::Tool { at, kind } => writeln!(text, "p {:?} {:?} {}", at.x, at.y, word(*kind)),
        };
    }
    text
}

/// Reads a recording; the memory it takes is bounded.
///
/// # Errors
/// [`RecordingError`] with the line.
pub fn read(mut from: impl BufRead) -> Result<Recording, RecordingError> {
    let mut number = 1;
    let first = line(&mut from, number)?.ok_or(RecordingError::Title)?;
    let mut recording = Recording { header: header(&first)?, events: Vec::new() };
    let mut before = Time::ZERO;
    loop {
        number += 1;
        let Some(text) = line(&mut from, number)? else { return Ok(recording) };
        let event = event(&text).ok_or(RecordingError::Form { line: number })?;
        // A simulated tool's positions may be older than what was received after them.
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
fn line(from: &mut impl BufRead, number: usize) -> Result<Option<String>, RecordingError> {
    let mut bytes = Vec::new();
    let failed = |source| RecordingError::File { path: PathBuf::new(), source };
    from.by_ref().take(LINE_MAX as u64).read_until(b'\n', &mut bytes).map_err(failed)?;
    match bytes.pop() {
        None => Ok(None),
        Some(b'\n') => String::from_utf8(bytes).map(Some).map_err(|_| RecordingError::Form { line: number }),
        Some(_) if bytes.len() + 1 >= LINE_MAX => Err(RecordingError::LongLine { line: number }),
        // The last line was not written whole.
        Some(_) => Err(RecordingError::Form { line: number }),
    }
}

fn header(line: &str) -> Result<Header, RecordingError> {
    let mut words = line.split(' ');
    if words.next() != Some(TITLE) {
        return Err(RecordingError::Title);
    }
    let found = words.next().ok_or(RecordingError::Title)?;
    if found != VERSION {
        return Err(RecordingError::Version { found: found.escape_default().take(20).collect() });
    }
    let mut value = |name: &str| words.next()?.strip_prefix(name)?.strip_prefix('=');
    let mut parsed = || {
        let dialect = value("dialect")?.to_string();
        let digit_mm = length(value("digit_mm")?)?;
        Some(Header { dialect, digit_mm, step_mm: length(value("step_mm")?)? })
    };
    parsed().ok_or(RecordingError::Form { line: 1 })
}

fn event(line: &str) -> Option<Event> {
    let (time, rest) = line.split_once(' ')?;
    let at = Time::from_micros(time.parse().ok()?);
    let (letter, rest) = rest.split_once(' ').unwrap_or((rest, ""));
    let what = match letter {
        "b" => {
            let mut words = rest.splitn(3, ' ');
            let origin = place(&mut words)?;
            What::Begin { name: words.next()?.to_string(), origin }
        }
        "s" => What::Sent(unescaped(rest)?),
        "r" => What::Received(unescaped(rest)?),
        "e" if rest.is_empty() => What::Rest,
        "p" => {
            let mut words = rest.splitn(3, ' ');
            let at = place(&mut words)?;
            let kind = [SampleKind::Rest, SampleKind::Jog, SampleKind::Run];
            let name = words.next()?;
            What::Tool { at, kind: kind.into_iter().find(|kind| word(*kind) == name)? }
        }
        _ => return None,
    };
    Some(Event { at, what })
}

fn place<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<Mm2> {
    let mut number = || words.next()?.parse::<f64>().ok().filter(|value| value.is_finite());
    Some(Mm2 { x: number()?, y: number()? })
}

/// A length of a machine, mm.
fn length(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value| (0.0..=10.0).contains(value))
}

fn word(kind: SampleKind) -> &'static str {
    match kind {
        SampleKind::Rest => "rest",
        SampleKind::Jog => "jog",
        SampleKind::Run => "run",
    }
}

//! The reader of a log, line by line.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use keepout_guard::Time;
use keepout_planner::file::FileError;
use thiserror::Error;

use super::header::{Header, VERSION};
use super::line::{self, LineError};
use super::{EventLine, LOG, LoggedEvent};
use crate::supervisor::OperatorInput;

/// An error in a log.
#[derive(Debug, Error)]
pub enum LogReadError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is no log.
    #[error("this is no keepout log: {reason}")]
    NoLog {
        /// The reason.
        reason: String,
    },
    /// Another version of the program wrote the log.
    #[error(
        "the log has version {found}, this program reads version {VERSION}. \
         Replay it with the program that wrote it."
    )]
    Version {
        /// The log's version.
        found: u32,
    },
    /// A complete line does not match its checksum.
    #[error(
        "line {line} of the log does not match its checksum and the line before: \
         the log was damaged or changed. Do not rely on anything from that line on."
    )]
    Damaged {
        /// The line, from 1.
        line: usize,
    },
    /// An intact line has a content that this program does not understand.
    #[error("line {line} of the log: {source}. Was it written by another version?")]
    Line {
        /// The line, from 1.
        line: usize,
        /// The error in the line.
        source: LineError,
    },
}

/// Longest line, bytes.
const LINE_MAX: u64 = 1 << 28;

/// A reader of a log. It checks each line against the line before, and keeps one line at a time.
///
/// A line ends with a line feed, and the program writes it whole before the next. So a killed program or a
/// full disk leaves complete lines, and at most one incomplete line after them. An incomplete line is no
/// error, see [`LogReader::torn`]. A complete line with a wrong checksum is an error.
#[derive(Debug)]
pub struct LogReader<R> {
    source: R,
    path: PathBuf,
    header: Header,
    line: Vec<u8>,
    lines: usize,
    sum: u32,
    torn: usize,
    input: OperatorInput,
    last: Time,
}

/// An event of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its line in the file, from 1.
    pub line: usize,
    /// The time of the event.
    pub at: Time,
    /// The event.
    pub event: LoggedEvent<'static>,
}

impl LogReader<BufReader<File>> {
    /// Opens a log.
    ///
    /// # Errors
    /// [`LogReadError`] if the file cannot be read or is no log.
    pub fn open(path: &Path) -> Result<Self, LogReadError> {
        Self::new(BufReader::new(LOG.open(path)?), path)
    }
}

impl<R: BufRead> LogReader<R> {
    /// Reads the header of a log. `path` appears in messages only.
    ///
    /// # Errors
    /// [`LogReadError`] if it is no log.
    pub fn new(source: R, path: &Path) -> Result<Self, LogReadError> {
        let no_log = |reason: &str| LogReadError::NoLog { reason: reason.into() };
        let mut log = Self {
            source,
            path: path.to_path_buf(),
            header: Header::default(),
            line: Vec::new(),
            lines: 0,
            sum: 0,
            torn: 0,
            input: OperatorInput::default(),
            last: Time::ZERO,
        };
        let first = log.advance().map_err(|error| match error {
            LogReadError::Damaged { .. } if log.line.starts_with(b"keepout-log 1") => {
                LogReadError::Version { found: 1 }
            }
            LogReadError::Damaged { .. } => no_log("its first line is not the first line of a log"),
            other => other,
        })?;
        if !first {
            return Err(no_log("it has no complete line"));
        }
        log.header = line::read(&mut log.line).map_err(|error| no_log(&error.to_string()))?;
        if log.header.keepout_log != VERSION {
            return Err(LogReadError::Version { found: log.header.keepout_log });
        }
        Ok(log)
    }

    /// The set-up of the session.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Complete lines read so far, with the header.
    #[must_use]
    pub fn lines(&self) -> usize {
        self.lines
    }

    /// The checksum of the last complete line. It covers all lines up to there.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        self.sum
    }

    /// Bytes of the incomplete line at the end, once the reader has reached it. Zero if the log ends with a
    /// complete line.
    #[must_use]
    pub fn torn(&self) -> usize {
        self.torn
    }

    /// Reads the next line without its line end, and checks it. Returns whether there was a complete line.
    fn advance(&mut self) -> Result<bool, LogReadError> {
        self.line.clear();
        let damaged = LogReadError::Damaged { line: self.lines + 1 };
        let read = self.source.by_ref().take(LINE_MAX).read_until(b'\n', &mut self.line);
        let count = read.map_err(LOG.read_error(&self.path))?;
        if self.line.pop_if(|last| *last == b'\n').is_none() {
            self.torn = count;
            return if self.line.len() < usize::try_from(LINE_MAX).unwrap_or(usize::MAX) {
                Ok(false)
            } else {
                Err(damaged)
            };
        }
        self.sum = line::verified(&self.line, self.sum).ok_or(damaged)?;
        self.lines += 1;
        Ok(true)
    }

    fn parse(&mut self) -> Result<Entry, LogReadError> {
        let wrong = |source| LogReadError::Line { line: self.lines, source };
        let EventLine { at, event } = line::read(&mut self.line).map_err(wrong)?;
        if at < self.last {
            return Err(wrong(LineError::Backwards));
        }
        self.last = at;
        let event = event.unwrap_or(LoggedEvent::Input(self.input));
        if let LoggedEvent::Input(input) = event {
            self.input = input;
        }
        Ok(Entry { line: self.lines, at, event })
    }
}

impl<R: BufRead> Iterator for LogReader<R> {
    type Item = Result<Entry, LogReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self.advance() {
            Ok(true) => Some(self.parse()),
            Ok(false) => None,
            Err(error) => Some(Err(error)),
        }
    }
}

/// A complete log in memory. Use [`LogReader`] for a long log.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// The set-up of the session.
    pub header: Header,
    /// The events in order.
    pub entries: Vec<Entry>,
    /// Bytes of the incomplete line at the end.
    pub torn: usize,
}

impl Log {
    /// Reads a log from a file.
    ///
    /// # Errors
    /// [`LogReadError`], which names the line.
    pub fn load(path: &Path) -> Result<Self, LogReadError> {
        Self::collect(LogReader::open(path)?)
    }

    /// Reads a log from its bytes.
    ///
    /// # Errors
    /// [`LogReadError`], which names the line.
    pub fn parse(bytes: &[u8]) -> Result<Self, LogReadError> {
        Self::collect(LogReader::new(bytes, Path::new("in memory"))?)
    }

    fn collect<R: BufRead>(mut reader: LogReader<R>) -> Result<Self, LogReadError> {
        let entries = reader.by_ref().collect::<Result<_, _>>()?;
        Ok(Self { torn: reader.torn(), header: reader.header, entries })
    }
}

//! Reading a log, line by line.

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

/// Why a log can not be read.
#[derive(Debug, Error)]
pub enum LogReadError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// It is no log.
    #[error("this is no keepout log: {reason}")]
    NoLog {
        /// Why not.
        reason: String,
    },
    /// It was written by another version.
    #[error(
        "the log has version {found}, this program reads version {VERSION}. Replay it with the program that wrote it."
    )]
    Version {
        /// The log's version.
        found: u32,
    },
    /// A whole line is not what was written.
    #[error(
        "line {line} of the log does not match its checksum and the line before: the log was damaged or changed. Nothing from that line on can be relied on."
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

/// Longest line that is read, bytes.
const LINE_MAX: u64 = 1 << 28;

/// A log that is read line by line, each checked against the line before; it keeps one line at a time.
///
/// A line ends with a line feed and is written whole before the next, so what a dying program or a full disk leaves is a
/// beginning of the log: whole lines, and behind them less than one. That is no error, see [`LogReader::torn`]. A whole line
/// that does not match is one.
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
    /// When it happened.
    pub at: Time,
    /// What happened.
    pub event: LoggedEvent<'static>,
}

impl LogReader<BufReader<File>> {
    /// Opens a log.
    ///
    /// # Errors
    /// [`LogReadError`] when the file can not be read or is no log.
    pub fn open(path: &Path) -> Result<Self, LogReadError> {
        Self::new(BufReader::new(LOG.open(path)?), path)
    }
}

impl<R: BufRead> LogReader<R> {
    /// Reads the header of a log; `path` is for messages.
    ///
    /// # Errors
    /// [`LogReadError`] when it is no log.
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
            LogReadError::Damaged { .. } => no_log("its first line does not begin a log"),
            other => other,
        })?;
        if !first {
            return Err(no_log("it has no whole line"));
        }
        log.header = line::read(&mut log.line).map_err(|error| no_log(&error.to_string()))?;
        if log.header.keepout_log != VERSION {
            return Err(LogReadError::Version { found: log.header.keepout_log });
        }
        Ok(log)
    }

    /// What the log says of its session.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Whole lines read so far, the header among them.
    #[must_use]
    pub fn lines(&self) -> usize {
        self.lines
    }

    /// The checksum of the last whole line: over all that was read.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        self.sum
    }

    /// Once all was read: bytes at the end that are no whole line. The log was torn off there.
    #[must_use]
    pub fn torn(&self) -> usize {
        self.torn
    }

    /// Reads the next line, without its end, and checks it; whether there was a whole one.
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

/// A log that was read whole. [`LogReader`] is for long ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// What it says of its session.
    pub header: Header,
    /// What happened, in order.
    pub entries: Vec<Entry>,
    /// Bytes at the end that are no whole line: the log was torn off there.
    pub torn: usize,
}

impl Log {
    /// Reads a log from a file.
    ///
    /// # Errors
    /// [`LogReadError`] naming the line.
    pub fn load(path: &Path) -> Result<Self, LogReadError> {
        Self::collect(LogReader::open(path)?)
    }

    /// Reads a log from its bytes.
    ///
    /// # Errors
    /// [`LogReadError`] naming the line.
    pub fn parse(bytes: &[u8]) -> Result<Self, LogReadError> {
        Self::collect(LogReader::new(bytes, Path::new("in memory"))?)
    }

    fn collect<R: BufRead>(mut reader: LogReader<R>) -> Result<Self, LogReadError> {
        let entries = reader.by_ref().collect::<Result<_, _>>()?;
        Ok(Self { torn: reader.torn(), header: reader.header, entries })
    }
}

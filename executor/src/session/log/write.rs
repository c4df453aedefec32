//! Writing the log.

use std::fmt::Write as _;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use keepout_guard::Time;
use thiserror::Error;

use super::header::{self, Header};
use super::line;
use crate::session::event_log::{EventLog, EventLogError, LoggedEvent};
use crate::supervisor::OperatorInput;

/// Why a log can not be written.
#[derive(Debug, Error)]
pub enum LogError {
    /// It can not be created.
    #[error("can not write the log {}: {source}. Choose another place with --log.", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// There is something there already.
    #[error("the log {} exists already: a log is written once and never changed. Choose another name, or move it away.", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
}

/// A log that is written.
#[derive(Debug)]
pub struct LogTape {
    out: BufWriter<std::fs::File>,
    sum: u32,
    input: Option<OperatorInput>,
    text: String,
    dirty: bool,
}

impl LogTape {
    /// A new log at `path`.
    ///
    /// # Errors
    /// [`LogError`] when there is one already, or it can not be created.
    pub fn create(path: &Path, header: &Header) -> Result<Self, LogError> {
        let file = std::fs::OpenOptions::new().create_new(true).append(true).open(path);
        let file = file.map_err(|source| match source.kind() {
            std::io::ErrorKind::AlreadyExists => LogError::Exists { path: path.to_path_buf() },
            _ => LogError::Create { path: path.to_path_buf(), source },
        })?;
        let mut log =
            Self { out: BufWriter::new(file), sum: 0, input: None, text: String::new(), dirty: false };
        log.text = header::text(header);
        log.end_line().and_then(|()| log.flush()).map_err(|error| LogError::Create {
            path: path.to_path_buf(),
            source: std::io::Error::other(error.to_string()),
        })?;
        Ok(log)
    }

    fn end_line(&mut self) -> Result<(), EventLogError> {
        self.sum = line::checksum(self.sum, &self.text);
        writeln!(self.out, "{}\t{:08x}", self.text, self.sum)?;
        self.dirty = true;
        Ok(())
    }
}

impl EventLog for LogTape {
    fn take(&mut self, now: Time, record: &LoggedEvent<'_>) -> Result<(), EventLogError> {
        let text = &mut self.text;
        text.clear();
        // Writing to a string does not fail.
        let _ = write!(text, "{} ", now.micros());
        line::push_record(text, record, &mut self.input);
        self.end_line()
    }

    fn flush(&mut self) -> Result<(), EventLogError> {
        if std::mem::take(&mut self.dirty) {
            self.out.flush()?;
        }
        Ok(())
    }
}

impl Drop for LogTape {
    fn drop(&mut self) {
        // What was flushed outlives the program; this makes it outlive a power cut too.
        let _ = self.out.flush();
        let _ = self.out.get_ref().sync_data();
    }
}

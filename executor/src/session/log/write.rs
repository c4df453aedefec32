//! Writing the log.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use keepout_guard::Time;
use keepout_planner::file::FileError;
use serde::Serialize;
use thiserror::Error;

use super::header::Header;
use super::{EventLine, LOG, line};
use crate::session::event_log::{EventLog, EventLogError, LoggedEvent};
use crate::supervisor::OperatorInput;

/// Why a log can not be written.
#[derive(Debug, Error)]
pub enum LogError {
    /// The file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is something there already.
    #[error("the log {} exists already: a log is written once and never changed. Choose another name, or move it away.", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
}

/// A log that is written.
#[derive(Debug)]
pub struct LogWriter {
    out: BufWriter<std::fs::File>,
    sum: u32,
    input: Option<OperatorInput>,
    line: Vec<u8>,
    dirty: bool,
}

impl LogWriter {
    /// A new log at `path`.
    ///
    /// # Errors
    /// [`LogError`] when there is one already, or it can not be created.
    pub fn create(path: &Path, header: &Header) -> Result<Self, LogError> {
        let file = std::fs::OpenOptions::new().create_new(true).append(true).open(path);
        let file = file.map_err(|source| match source.kind() {
            std::io::ErrorKind::AlreadyExists => LogError::Exists { path: path.to_path_buf() },
            _ => LOG.write_error(path)(source).into(),
        })?;
        let mut log = Self { out: BufWriter::new(file), sum: 0, input: None, line: Vec::new(), dirty: false };
        log.write(header).and_then(|()| log.out.flush()).map_err(LOG.write_error(path))?;
        Ok(log)
    }

    fn write(&mut self, content: &impl Serialize) -> std::io::Result<()> {
        self.sum = line::write(&mut self.line, self.sum, content)?;
        self.line.push(b'\n');
        self.out.write_all(&self.line)?;
        self.dirty = true;
        Ok(())
    }
}

/// Whether two inputs are the same to the bit: equal numbers are not, when one of them is −0.
fn is_same(a: &OperatorInput, b: &OperatorInput) -> bool {
    let bits = |input: &OperatorInput| {
        let ((x, y), (u, v)) = (input.velocity, input.turned_mm);
        [x, y, u, v].map(f64::to_bits)
    };
    bits(a) == bits(b) && a == b
}

impl EventLog for LogWriter {
    fn take(&mut self, now: Time, event: &LoggedEvent<'_>) -> Result<(), EventLogError> {
        let input = if let LoggedEvent::Input(input) = event { Some(*input) } else { None };
        let same = input.zip(self.input).is_some_and(|(input, before)| is_same(&input, &before));
        self.input = input.or(self.input);
        Ok(self.write(&EventLine { at: now, event: (!same).then(|| event.clone()) })?)
    }

    fn flush(&mut self) -> Result<(), EventLogError> {
        if std::mem::take(&mut self.dirty) {
            self.out.flush()?;
        }
        Ok(())
    }
}

impl Drop for LogWriter {
    fn drop(&mut self) {
        // What was flushed outlives the program; this makes it outlive a power cut too.
        let _ = self.out.flush();
        let _ = self.out.get_ref().sync_data();
    }
}

//! The writer of a log.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::file::FileError;
use serde::Serialize;
use thiserror::Error;

use super::header::Header;
use super::{EventLine, LOG, line};
use crate::session::event_log::{EventLog, EventLogError, LoggedEvent};
use crate::supervisor::OperatorInput;

/// An error of a log writer.
#[derive(Debug, Error)]
pub enum LogError {
    /// The file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file exists at that path.
    #[error(
        "the log {} exists already: Keepout writes a log once and never changes it. \
         Choose another name, or move it away.",
        path.display()
    )]
    Exists {
        /// The file.
        path: PathBuf,
    },
}

/// A log file under way.
#[derive(Debug)]
pub struct LogWriter {
    out: BufWriter<std::fs::File>,
    sum: u32,
    input: Option<OperatorInput>,
    line: Vec<u8>,
    dirty: bool,
}

impl LogWriter {
    /// Creates a log at `path`.
    ///
    /// # Errors
    /// [`LogError`] if a file exists there, or if the log cannot be created.
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

/// Whether two inputs are the same bit for bit. So 0 and −0 differ.
fn is_same(a: &OperatorInput, b: &OperatorInput) -> bool {
    let bits = |input: &OperatorInput| {
        let (Mm2 { x, y }, Mm2 { x: u, y: v }) = (input.velocity, input.turned_mm);
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
        // Flushed lines outlive the program. After the sync they outlive a power cut, too.
        let _ = self.out.flush();
        let _ = self.out.get_ref().sync_data();
    }
}

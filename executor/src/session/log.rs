//! The session log: one line for each thing that happened, appended and flushed as it goes.

use std::io::Write;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::time::Time;

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
    /// It can not be written on.
    #[error("the log could not be written on: {0}. The machine was stopped.")]
    Write(#[from] std::io::Error),
}

/// A log, or none.
pub struct Log {
    out: Option<std::io::BufWriter<std::fs::File>>,
}

impl Log {
    /// No log.
    #[must_use]
    pub fn none() -> Self {
        Self { out: None }
    }

    /// A new log at `path`; an existing file is continued.
    ///
    /// # Errors
    /// [`LogError::Create`] when the file can not be opened.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        let file = file.map_err(|source| LogError::Create { path: path.to_path_buf(), source })?;
        Ok(Self { out: Some(std::io::BufWriter::new(file)) })
    }

    /// Appends `TIME<tab>KIND<tab>TEXT`; control characters in the text are escaped.
    ///
    /// # Errors
    /// [`LogError::Write`] when the disk is full or gone.
    pub fn line(&mut self, now: Time, kind: &str, text: &str) -> Result<(), LogError> {
        if let Some(out) = &mut self.out {
            writeln!(out, "{:.6}\t{kind}\t{}", now.seconds(), text.escape_debug())?;
        }
        Ok(())
    }

    /// Hands everything written so far to the system.
    ///
    /// # Errors
    /// [`LogError::Write`] when the disk is full or gone.
    pub fn flush(&mut self) -> Result<(), LogError> {
        if let Some(out) = &mut self.out {
            out.flush()?;
        }
        Ok(())
    }
}

//! Files: one error for all of them, reads up to a size limit, and writes that are whole or not at all.

use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Largest size of a text file that people write, bytes.
pub const TEXT_SIZE_MAX: u64 = 1 << 20;

/// What a program writes for its user: a picture, a page, a profile, or the folder for them.
pub static OUTPUT: FileKind = FileKind::new("output");

/// Kind of a file: its name in messages, and the remedies that end them.
#[derive(Debug, PartialEq, Eq)]
pub struct FileKind {
    /// Name, without an article.
    pub name: &'static str,
    /// Remedy when a file cannot be read.
    pub unreadable: &'static str,
    /// Remedy when a file cannot be written.
    pub unwritable: &'static str,
    /// Remedy when a file is too large.
    pub too_large: &'static str,
}

/// Reason why a file cannot be read or written.
#[derive(Debug, Error)]
pub enum FileError {
    /// The file cannot be read.
    #[error("cannot read the {} {}: {source}. {}", kind.name, path.display(), kind.unreadable)]
    Read {
        /// Kind of the file.
        kind: &'static FileKind,
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write the {} {}: {source}. {}", kind.name, path.display(), kind.unwritable)]
    Write {
        /// Kind of the file.
        kind: &'static FileKind,
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The file is larger than the limit.
    #[error(
        "the {} {} has more than {size_max} bytes, the limit for a file of this kind. {}",
        kind.name,
        path.display(),
        kind.too_large
    )]
    TooLarge {
        /// Kind of the file.
        kind: &'static FileKind,
        /// The file.
        path: PathBuf,
        /// Largest size, bytes.
        size_max: u64,
    },
}

impl FileKind {
    /// A kind with the usual remedies.
    #[must_use]
    pub const fn new(name: &'static str) -> Self {
        Self {
            name,
            unreadable: "Check the path.",
            unwritable: "Nothing was changed. Choose another place.",
            too_large: "Check the path.",
        }
    }

    /// Makes the error of a file that cannot be read.
    pub fn read_error(&'static self, path: &Path) -> impl Fn(io::Error) -> FileError {
        move |source| FileError::Read { kind: self, path: path.to_path_buf(), source }
    }

    /// Makes the error of a file that cannot be written.
    pub fn write_error(&'static self, path: &Path) -> impl Fn(io::Error) -> FileError {
        move |source| FileError::Write { kind: self, path: path.to_path_buf(), source }
    }

    /// Opens a file to read it piece by piece.
    ///
    /// # Errors
    /// [`FileError::Read`].
    pub fn open(&'static self, path: &Path) -> Result<File, FileError> {
        File::open(path).map_err(self.read_error(path))
    }

    /// Reads a file of at most `size_max` bytes. The limit also covers a device without end, whose stated
    /// length is 0.
    ///
    /// # Errors
    /// [`FileError::Read`] and [`FileError::TooLarge`].
    pub fn read(&'static self, path: &Path, size_max: u64) -> Result<Vec<u8>, FileError> {
        let file = self.open(path)?;
        let stated = file.metadata().map_err(self.read_error(path))?.len();
        let mut bytes = Vec::new();
        if stated <= size_max {
            file.take(size_max.saturating_add(1)).read_to_end(&mut bytes).map_err(self.read_error(path))?;
        }
        if stated.max(bytes.len() as u64) > size_max {
            return Err(FileError::TooLarge { kind: self, path: path.to_path_buf(), size_max });
        }
        Ok(bytes)
    }

    /// Reads a text of at most [`TEXT_SIZE_MAX`] bytes.
    ///
    /// # Errors
    /// [`FileError::TooLarge`]; [`FileError::Read`], also for a file that is not text in UTF-8.
    pub fn read_text(&'static self, path: &Path) -> Result<String, FileError> {
        let other = |_| io::Error::new(ErrorKind::InvalidData, "it is not text in UTF-8");
        String::from_utf8(self.read(path, TEXT_SIZE_MAX)?).map_err(other).map_err(self.read_error(path))
    }

    /// Writes a file with [`write_whole`].
    ///
    /// # Errors
    /// [`FileError::Write`]. The file at `path` then stays unchanged.
    pub fn write(&'static self, path: &Path, bytes: &[u8]) -> Result<(), FileError> {
        write_whole(path, bytes).map_err(self.write_error(path))
    }
}

/// Writes `bytes` to `path` whole or not at all: to a temporary file beside it, which is flushed and
/// renamed. It follows links. It refuses a path that exists and is not a regular file.
///
/// # Errors
/// The error of the operating system. The temporary file is removed.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let followed = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let path = followed.as_path();
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return Err(io::Error::new(ErrorKind::InvalidInput, "it is not a regular file"));
    }
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    let written = File::create(&temporary)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| std::fs::rename(&temporary, path));
    if written.is_err() {
        let _ = std::fs::remove_file(&temporary);
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    static NOTE: FileKind = FileKind { unreadable: "Write one.", ..FileKind::new("note") };

    fn path_of(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("keepout-file-{}-{name}", std::process::id()))
    }

    #[test]
    fn files_above_the_size_limit_are_refused() {
        let path = path_of("large");
        std::fs::write(&path, vec![b' '; (1 << 20) + 1]).unwrap();
        let error = NOTE.read_text(&path).unwrap_err();
        assert!(matches!(error, FileError::TooLarge { size_max: TEXT_SIZE_MAX, .. }), "{error}");
        std::fs::write(&path, vec![b' '; 1 << 20]).unwrap();
        assert_eq!(NOTE.read_text(&path).unwrap().len(), 1 << 20);
        std::fs::remove_file(&path).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn device_without_end_is_read_up_to_the_limit() {
        let error = NOTE.read(Path::new("/dev/zero"), 1000).unwrap_err().to_string();
        assert!(error.starts_with("the note /dev/zero has more than 1000 bytes"), "{error}");
    }

    #[test]
    fn messages_name_kind_path_reason_and_remedy() {
        let path = path_of("none").join("note");
        let error = NOTE.read_text(&path).unwrap_err().to_string();
        let begin = format!("cannot read the note {}: ", path.display());
        assert!(error.starts_with(&begin) && error.ends_with(". Write one."), "{error}");
        let error = NOTE.write(&path, b"").unwrap_err().to_string();
        let begin = format!("cannot write the note {}: ", path.display());
        assert!(error.starts_with(&begin) && error.contains("Nothing was changed."), "{error}");
    }

    #[test]
    fn file_that_is_not_text_is_refused() {
        let path = path_of("bytes");
        NOTE.write(&path, b"\xff").unwrap();
        let error = NOTE.read_text(&path).unwrap_err().to_string();
        std::fs::remove_file(&path).unwrap();
        assert!(error.contains("not text in UTF-8"), "{error}");
    }
}

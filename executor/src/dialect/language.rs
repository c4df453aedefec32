//! The dialects by name.
//!
//! Implements SR-17, SR-29.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use keepout_planner::file::{FileError, FileKind};
use keepout_planner::sha256;
use keepout_planner::text_file::shown;
use thiserror::Error;

use super::{Described, Description, DescriptionError, Dialect, DialectConfig, Grbl, Venus, Zaber};

/// The dialect that a user names: a built-in one, or a file that describes one.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DialectName {
    /// GRBL 1.1.
    #[default]
    Grbl,
    /// grblHAL.
    GrblHal,
    /// Zaber ASCII, with streams.
    Zaber,
    /// Venus-1 (ITK/Micos Corvus).
    Venus,
    /// A TOML file that describes the dialect.
    Described {
        /// The file's path, as the user gave it.
        file: String,
        /// The description read from the file.
        description: Arc<Description>,
    },
}

static DIALECT_DESCRIPTION: FileKind = FileKind::new("dialect description");

/// Why a name gives no dialect.
#[derive(Debug, Error)]
pub enum DialectNameError {
    /// The name is neither built in nor a file.
    #[error(
        "no dialect \"{}\": give one of {}, or the path of a file that describes one",
        shown(name),
        DialectName::NAMES.join(", ")
    )]
    Unknown {
        /// The name.
        name: String,
    },
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not a valid description.
    #[error("{}: {error}", path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// The reason.
        error: DescriptionError,
    },
}

impl DialectName {
    /// The names of the built-in dialects.
    pub const NAMES: [&'static str; 4] = ["grbl", "grblhal", "zaber", "venus"];

    /// The dialect of that name, or described by the file of that name.
    ///
    /// # Errors
    /// [`DialectNameError`] if the name is unknown, or if the file is not a valid description.
    pub fn named(name: &str) -> Result<Self, DialectNameError> {
        Ok(match name {
            "grbl" => Self::Grbl,
            "grblhal" => Self::GrblHal,
            "zaber" => Self::Zaber,
            "venus" => Self::Venus,
            _ if Path::new(name).is_file() => {
                let path = Path::new(name);
                let description = Description::of(&DIALECT_DESCRIPTION.read_text(path)?)
                    .map_err(|error| DialectNameError::Description { path: path.to_path_buf(), error })?;
                Self::Described { file: name.into(), description: Arc::new(description) }
            }
            _ => return Err(DialectNameError::Unknown { name: name.into() }),
        })
    }

    /// The dialect's name, or its file.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Grbl => "grbl",
            Self::GrblHal => "grblhal",
            Self::Zaber => "zaber",
            Self::Venus => "venus",
            Self::Described { file, .. } => file,
        }
    }

    /// SHA-256 of the describing text, as hexadecimal digits; empty for a built-in dialect.
    #[must_use]
    pub fn hash(&self) -> String {
        match self {
            Self::Described { description, .. } => sha256::hex(&description.hash),
            _ => String::new(),
        }
    }

    /// Whether a session can have a third axis.
    #[must_use]
    pub fn has_third_axis(&self) -> bool {
        match self {
            Self::Grbl | Self::GrblHal | Self::Zaber => true,
            Self::Venus => false,
            Self::Described { description, .. } => description.z.is_some(),
        }
    }

    /// Whether the dialect has words that switch the spindle.
    #[must_use]
    pub fn switches_spindle(&self) -> bool {
        matches!(self, Self::Grbl | Self::GrblHal)
    }

    /// Whether each motion states a height, so that no session has two axes.
    #[must_use]
    pub fn needs_third_axis(&self) -> bool {
        matches!(self, Self::Described { description, .. } if description.z.is_some())
    }

    /// The dialect of one session.
    #[must_use]
    pub fn dialect(&self, setting: DialectConfig) -> Box<dyn Dialect> {
        match self {
            Self::Grbl => Box::new(Grbl::new(setting)),
            Self::GrblHal => Box::new(Grbl::hal(setting)),
            Self::Zaber => Box::new(Zaber::new(setting)),
            Self::Venus => Box::new(Venus::new(setting)),
            Self::Described { description, .. } => Box::new(Described::new(Arc::clone(description), setting)),
        }
    }
}

//! Which language a controller speaks.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use keepout_planner::plan_file;
use keepout_planner::text_file::shown;
use thiserror::Error;

use super::{Described, Description, DescriptionError, Dialect, DialectConfig, Grbl, Venus, Zaber};

/// A controller's language, as it is asked for.
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
    /// Described by a file.
    Described {
        /// The file, as it was named.
        file: String,
        /// What it says.
        description: Arc<Description>,
    },
}

/// Why there is no such language.
#[derive(Debug, Error)]
pub enum DialectNameError {
    /// Neither built in nor a file.
    #[error("no dialect \"{}\": it is none of {} and no file that describes one", shown(name), DialectName::NAMES.join(", "))]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// A file that describes none.
    #[error("{}: {error}", path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: DescriptionError,
    },
}

impl DialectName {
    /// The names of the languages that are built in.
    pub const NAMES: [&'static str; 4] = ["grbl", "grblhal", "zaber", "venus"];

    /// The language of that name, or described by the file of that name.
    ///
    /// # Errors
    /// [`DialectNameError`] naming what is wrong.
    pub fn named(name: &str) -> Result<Self, DialectNameError> {
        Ok(match name {
            "grbl" => Self::Grbl,
            "grblhal" => Self::GrblHal,
            "zaber" => Self::Zaber,
            "venus" => Self::Venus,
            _ if Path::new(name).is_file() => {
                let path = Path::new(name);
                let description = Description::load(path)
                    .map_err(|error| DialectNameError::Description { path: path.to_path_buf(), error })?;
                Self::Described { file: name.into(), description: Arc::new(description) }
            }
            _ => return Err(DialectNameError::Unknown { name: name.into() }),
        })
    }

    /// Its name.
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

    /// SHA-256 of the text that describes it, as hexadecimal digits; empty for one that is built in.
    #[must_use]
    pub fn hash(&self) -> String {
        match self {
            Self::Described { description, .. } => plan_file::hex(&description.hash),
            _ => String::new(),
        }
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

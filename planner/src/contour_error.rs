//! How the contour error of a machine profile was obtained.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// How the contour error of a profile was obtained, with the details. In a file: the word, a colon, and the details.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum ContourErrorSource {
    /// Measured at the machine, such as by a circular test. `keepout drives ballbar` writes it.
    Measured(String),
    /// Computed from a model of the feed drives and of the controller that they run. `keepout drives budget` writes
    /// it.
    Modelled(String),
    /// Stated by a person.
    Stated(String),
}

/// Reason why a text is no source of a contour error.
#[derive(Debug, Error)]
#[error(
    "contour_error_source must begin with \"measured: \", \"modelled: \" or \"stated: \", as in \"measured: circular \
     test\""
)]
pub struct ContourErrorSourceError;

impl ContourErrorSource {
    /// The details.
    #[must_use]
    pub fn details(&self) -> &str {
        match self {
            Self::Measured(details) | Self::Modelled(details) | Self::Stated(details) => details,
        }
    }
}

impl std::fmt::Display for ContourErrorSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let how = match self {
            Self::Measured(_) => "measured",
            Self::Modelled(_) => "modelled",
            Self::Stated(_) => "stated",
        };
        write!(f, "{how}: {}", self.details())
    }
}

impl From<ContourErrorSource> for String {
    fn from(source: ContourErrorSource) -> Self {
        source.to_string()
    }
}

impl TryFrom<String> for ContourErrorSource {
    type Error = ContourErrorSourceError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        match text.split_once(": ") {
            Some(("measured", details)) => Ok(Self::Measured(details.into())),
            Some(("modelled", details)) => Ok(Self::Modelled(details.into())),
            Some(("stated", details)) => Ok(Self::Stated(details.into())),
            _ => Err(ContourErrorSourceError),
        }
    }
}

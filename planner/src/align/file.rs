//! The alignment file: how the workpiece lies on the machine, and how the alignment was measured.
//!
//! Implements SR-26, SR-29.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::Mm2;
use crate::file::{FileError, FileKind};
use crate::plan::Plan;
use crate::text_file;

/// Format version of the files that this program writes. It reads no other version.
pub const VERSION: u32 = 1;
static ALIGNMENT_FILE: FileKind = FileKind {
    unreadable: "Check the path, or make it with `keepout align`.",
    ..FileKind::new("alignment file")
};

/// Method by which an alignment was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Points of the drawing.
    Points,
    /// Touches of straight edges.
    Edges,
    /// Points and edges.
    PointsAndEdges,
}

/// Alignment of the workpiece on the machine. Planning turns the drawing about its origin, so the
/// certificate holds for the part as it lies. A run moves the plan, and does not turn it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlignmentFile {
    /// [`VERSION`].
    pub version: u32,
    /// Rotation of the drawing about its origin, counter-clockwise, degrees.
    pub rotation_deg: f64,
    /// Machine coordinates of the drawing's origin, mm.
    #[serde(deserialize_with = "text_file::pair")]
    pub origin_mm: [f64; 2],
    /// Name of the drawing that was aligned.
    pub drawing: String,
    /// Method of the measurement.
    pub method: Method,
    /// Number of probe points.
    pub touches: usize,
    /// Whether the rotation was measured. Otherwise it is assumed to be 0.
    pub rotation_measured: bool,
    /// The largest residual, mm.
    pub residual_mm: f64,
    /// Largest error of each probe point, mm.
    pub probe_error_mm: f64,
    /// Largest distance by which a place of the part may be off because of that error, mm.
    pub uncertainty_mm: f64,
    /// Machine coordinate of the top of the part under the tool that touched it, mm. `None`: not touched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub top_mm: Option<f64>,
}

/// Reason why an alignment file is refused.
#[derive(Debug, Error)]
pub enum AlignmentFileError {
    /// The file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file does not hold an alignment.
    #[error("{} is no alignment file: {reason}. Make one with `keepout align`.", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Place in the file, and the fault there.
        reason: String,
    },
    /// Another version of the program wrote the file.
    #[error(
        "{} has version {found}, this program reads version {VERSION}. Run `keepout align` again.",
        path.display()
    )]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: i64,
    },
    /// A figure is out of range.
    #[error("alignment: {field} is {value}, it must be {range}. Run `keepout align` again.")]
    Figure {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
        /// Accepted range, in words.
        range: &'static str,
    },
    /// The plan and the alignment differ in rotation.
    #[error(
        "the plan was made for a drawing turned by {plan_deg}°, the workpiece lies turned by {setup_deg}°. \
         Make the plan again with `keepout plan --alignment`."
    )]
    Turned {
        /// The rotation of the plan, degrees.
        plan_deg: f64,
        /// The rotation of the alignment, degrees.
        setup_deg: f64,
    },
    /// The plan was made with an offset.
    #[error(
        "the plan was made with --offset-mm {},{}, but the alignment holds for the drawing without \
         an offset. Make the plan again with `keepout plan --alignment`, without --offset-mm.",
        .by_mm.x, .by_mm.y
    )]
    Moved {
        /// Offset of the plan, mm.
        by_mm: Mm2,
    },
}

impl AlignmentFile {
    /// Reads an alignment file.
    ///
    /// # Errors
    /// [`AlignmentFileError`] that names the file and its fault.
    pub fn load(path: &Path) -> Result<Self, AlignmentFileError> {
        Self::parse(path, &ALIGNMENT_FILE.read_text(path)?)
    }

    /// The alignment that `text` holds. Messages name `path`.
    ///
    /// # Errors
    /// [`AlignmentFileError`] that names the fault.
    pub fn parse(path: &Path, text: &str) -> Result<Self, AlignmentFileError> {
        let own = || path.to_path_buf();
        let parse = |error: toml::de::Error| AlignmentFileError::Parse {
            path: own(),
            reason: text_file::reason(&error),
        };
        let table: toml::Table = toml::from_str(text).map_err(parse)?;
        let found = table.get("version").and_then(toml::Value::as_integer);
        if let Some(found) = found.filter(|&found| found != i64::from(VERSION)) {
            return Err(AlignmentFileError::Version { path: own(), found });
        }
        toml::from_str::<Self>(text).map_err(parse)?.checked()
    }

    /// Writes the whole file, or leaves the old file unchanged.
    ///
    /// # Errors
    /// [`AlignmentFileError`] with the error of the operating system.
    pub fn save(&self, path: &Path) -> Result<(), AlignmentFileError> {
        let text = toml::to_string(self).map_err(|error| AlignmentFileError::Parse {
            path: path.to_path_buf(),
            reason: error.to_string(),
        })?;
        Ok(ALIGNMENT_FILE.write(path, text.as_bytes())?)
    }

    /// Checks that every figure is possible for a workpiece.
    ///
    /// # Errors
    /// [`AlignmentFileError::Figure`] for the first figure that is out of range.
    pub fn checked(self) -> Result<Self, AlignmentFileError> {
        let [x, y] = self.origin_mm;
        let figures = [
            ("rotation_deg", self.rotation_deg, -360.0..=360.0, "between -360 and 360"),
            ("origin_mm", x, -1e4..=1e4, "within 10 m"),
            ("origin_mm", y, -1e4..=1e4, "within 10 m"),
            ("residual_mm", self.residual_mm, 0.0..=1e3, "a length"),
            ("probe_error_mm", self.probe_error_mm, 0.0..=1e3, "a length"),
            ("uncertainty_mm", self.uncertainty_mm, 0.0..=1e3, "a length"),
            ("top_mm", self.top_mm.unwrap_or(0.0), -1e4..=1e4, "within 10 m"),
        ];
        match figures.into_iter().find(|(_, value, range, _)| !range.contains(value)) {
            Some((field, value, _, range)) => Err(AlignmentFileError::Figure { field, value, range }),
            None => Ok(self),
        }
    }

    /// Placement of the drawing for planning ([`crate::drawing::EntityFilter::placed`]): turned, not
    /// moved.
    #[must_use]
    pub fn placed(&self) -> Option<(f64, Mm2)> {
        (self.rotation_deg != 0.0).then_some((self.rotation_deg, Mm2::ZERO))
    }

    /// Machine coordinates of the plan's origin, mm.
    ///
    /// # Errors
    /// [`AlignmentFileError`] when the plan has another rotation, or an offset.
    pub fn origin_for(&self, plan: &Plan) -> Result<Mm2, AlignmentFileError> {
        let (plan_deg, by_mm) = plan.provenance.placed.unwrap_or_default();
        if by_mm != Mm2::ZERO {
            return Err(AlignmentFileError::Moved { by_mm });
        }
        #[expect(clippy::float_cmp, reason = "both were read from the same digits")]
        if plan_deg != self.rotation_deg {
            return Err(AlignmentFileError::Turned { plan_deg, setup_deg: self.rotation_deg });
        }
        let [x, y] = self.origin_mm;
        Ok(Mm2::new(x, y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alignment_file_is_read_as_written() {
        let alignment = AlignmentFile {
            version: VERSION,
            rotation_deg: -12.345_678_9,
            origin_mm: [-250.001, 17.5],
            drawing: "a \"part\".dxf".into(),
            method: Method::PointsAndEdges,
            touches: 4,
            rotation_measured: true,
            residual_mm: 0.001_25,
            probe_error_mm: 0.005,
            uncertainty_mm: 0.02,
            top_mm: None,
        };
        let alignment = AlignmentFile { top_mm: Some(-42.13), ..alignment };
        let path = std::env::temp_dir().join(format!("keepout-alignment-{}.toml", std::process::id()));
        alignment.save(&path).unwrap();
        let read = AlignmentFile::load(&path);
        std::fs::remove_file(&path).unwrap();
        assert_eq!(read.unwrap(), alignment);
        assert_eq!(alignment.placed(), Some((-12.345_678_9, Mm2::ZERO)));
        assert!(AlignmentFile { residual_mm: f64::NAN, ..alignment }.checked().is_err());
    }
}

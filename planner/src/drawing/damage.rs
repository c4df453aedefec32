//! Faults of the bytes of a DXF file, with their places.

use thiserror::Error;

use super::tags::TEXT_MAX;

/// A place in a DXF file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilePlace {
    /// A line of an ASCII file, from 1.
    Line(u32),
    /// A byte of a binary file, from 0.
    Byte(u32),
}

impl std::fmt::Display for FilePlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// The first bytes of other files, their types, and the remedies.
const OTHER_FILES: [(&[u8], &str, &str); 13] = [
    (b"AC10", "a DWG drawing", "Save it as DXF in the CAD system"),
    (b"%PDF", "a PDF document", "Export the drawing as DXF from the CAD system"),
    (b"ISO-10303-21", "a STEP model", "Export a drawing of its outline as DXF"),
    (b"<svg", "an SVG picture", "Save it as DXF, for example with Inkscape"),
    (b"<?xml", "an XML file, such as an SVG picture", "Save it as DXF, for example with Inkscape"),
    (b"PK\x03\x04", "a ZIP archive", "Unpack it, and give the DXF file in it"),
    (b"\x1f\x8b", "a gzip archive", "Unpack it, and give the DXF file in it"),
    (b"7z\xbc\xaf", "a 7-Zip archive", "Unpack it, and give the DXF file in it"),
    (b"\x89PNG", "a PNG picture", "A picture has no contours: export the drawing as DXF"),
    (b"\xff\xd8\xff", "a JPEG picture", "A picture has no contours: export the drawing as DXF"),
    (b"\xff\xfe", "text in UTF-16", "Save it in UTF-8, or export it again as DXF"),
    (b"\xfe\xff", "text in UTF-16", "Save it in UTF-8, or export it again as DXF"),
    (b"KEEPOUT PLAN", "a plan of keepout", "Give the drawing, not its plan"),
];

impl Damage {
    /// What to do about it.
    #[must_use]
    pub fn remedy(&self) -> String {
        match self {
            Self::OtherFile { remedy, .. } => format!("{remedy}."),
            _ => "Export it again from the CAD system, as DXF R12 or later.".into(),
        }
    }

    /// The type of a file that is no DXF file, by its first bytes.
    pub(super) fn other_file(bytes: &[u8]) -> Option<Self> {
        let begin = bytes.trim_ascii_start();
        let other =
            OTHER_FILES.iter().find(|(magic, ..)| bytes.starts_with(magic) || begin.starts_with(magic));
        other.map(|&(_, found, remedy)| Self::OtherFile { found, remedy })
    }
}

/// Faults of the bytes of a DXF file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Damage {
    /// The file is of another type.
    #[error("this is {found}")]
    OtherFile {
        /// The type, with its article.
        found: &'static str,
        /// The remedy.
        remedy: &'static str,
    },
    /// The file has no group codes.
    #[error("it has no DXF group codes")]
    NoDxf,
    /// The file has other text in the place of a group code.
    #[error("at {at} the file has \"{found}\", but a group code must be there")]
    Code {
        /// The place.
        at: FilePlace,
        /// The text there, shortened.
        found: String,
    },
    /// A value must be a finite number, and is not.
    #[error("at {at} the value of group {code} is \"{found}\", but it must be a finite number")]
    Number {
        /// The place.
        at: FilePlace,
        /// Its group code.
        code: i16,
        /// The value there, shortened.
        found: String,
    },
    /// An entity lacks a group.
    #[error("the entity that ends at {at} lacks its group {code}")]
    Missing {
        /// The place where the entity ends.
        at: FilePlace,
        /// The code of the group.
        code: i16,
    },
    /// The file ends too early.
    #[error("it ends at {at} inside {inside}: a piece of the file is missing")]
    EndsEarly {
        /// The place.
        at: FilePlace,
        /// The unfinished part of the file.
        inside: &'static str,
    },
    /// A text of a binary file is longer than the reader accepts.
    #[error("the text at {at} is longer than {TEXT_MAX} bytes")]
    Text {
        /// The place where the text begins.
        at: FilePlace,
    },
}

//! Questions about the size of a part: a wrong unit makes it implausible.
//!
//! Implements SR-27.

use thiserror::Error;

use crate::contour::short;
use crate::drawing::{Drawing, EntityFilter, UnitSource};
use crate::select::ContourPolygon;
use crate::{Box2, Mm2};

/// A part with a shorter longer side is implausible, mm.
pub const LEAST_MM: f64 = 2.0;
/// A plausible part has at most this longer side, mm.
const LARGEST_MM: f64 = 2000.0;
/// Units that a drawing may have, mm.
const UNITS: [(&str, f64); 4] = [("mm", 1.0), ("cm", 10.0), ("inches", 25.4), ("m", 1000.0)];

/// Question about the size of a part.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SizeQuestion {
    /// The part is smaller than any that a machinist cuts.
    #[error(
        "the part is {} mm: smaller than {LEAST_MM} mm. Is the unit right? {likely} Give --units, or --scale. If \
         the size is right, give --units mm.",
        size(*size_mm)
    )]
    Tiny {
        /// Its size, mm.
        size_mm: Mm2,
        /// The likely units.
        likely: String,
    },
    /// The part is larger than any machine of this kind.
    #[error(
        "the part is {} mm: larger than {LARGEST_MM} mm. Is the unit right? {likely} Give --units, or --scale.",
        size(*size_mm)
    )]
    Huge {
        /// Its size, mm.
        size_mm: Mm2,
        /// The likely units.
        likely: String,
    },
    /// The file states no unit.
    #[error(
        "the file states no unit, so the program reads mm: the part is {} mm. {likely} --units states it.",
        size(*size_mm)
    )]
    NoUnit {
        /// Its size, mm.
        size_mm: Mm2,
        /// Sizes in other units.
        likely: String,
    },
}

impl SizeQuestion {
    /// The question about the part of these contours, if there is one. A user who states the unit or a scale has
    /// answered it.
    #[must_use]
    pub fn of_part(outlines: &[ContourPolygon], drawing: &Drawing, filter: &EntityFilter) -> Option<Self> {
        let size_mm = outlines.iter().map(|outline| outline.bounds).reduce(Box2::union)?.size();
        let longer = size_mm.x.max(size_mm.y);
        if drawing.unit_source == UnitSource::User || filter.scale.is_some() {
            return None;
        }
        if longer < LEAST_MM {
            return Some(Self::Tiny { size_mm, likely: likely(size_mm, drawing.unit_mm) });
        }
        if longer > LARGEST_MM {
            return Some(Self::Huge { size_mm, likely: likely(size_mm, drawing.unit_mm) });
        }
        let assumed = drawing.unit_source == UnitSource::Assumed;
        assumed.then(|| Self::NoUnit { size_mm, likely: likely(size_mm, drawing.unit_mm) })
    }

    /// Whether no plan is made before the user answers.
    #[must_use]
    pub fn is_problem(&self) -> bool {
        matches!(self, Self::Tiny { .. })
    }
}

/// The plausible sizes in other units.
fn likely(size_mm: Mm2, unit_mm: f64) -> String {
    let other = UNITS.iter().filter(|(_, mm)| (mm - unit_mm).abs() > 1e-9);
    let sized = other.map(|(name, mm)| (name, size_mm * (mm / unit_mm)));
    let plausible = sized.filter(|(_, size)| (LEAST_MM..=LARGEST_MM).contains(&size.x.max(size.y)));
    let all: Vec<String> = plausible.map(|(name, at)| format!("as {name} it is {} mm", size(at))).collect();
    match all[..] {
        [] => "Another unit gives no usual size.".into(),
        _ => format!("Read {}.", all.join(", ")),
    }
}

/// Width and height.
#[must_use]
pub fn size(size_mm: Mm2) -> String {
    format!("{} × {}", short(size_mm.x), short(size_mm.y))
}

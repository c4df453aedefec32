//! Reads a DXF file into curves in millimetres.

use std::collections::BTreeMap;
use std::path::Path;

use super::damage::Damage;
use super::file::{DxfFile, folded, read};
use super::flatten::{Flattener, name_of};
use super::placement::Placement;
use super::{Drawing, DrawingError, LeftOutReason, UnitSource};
use crate::Mm2;
use crate::file::{FileError, FileKind};

/// Largest file that is read, in bytes.
pub const SIZE_MAX: u64 = 1 << 30;
/// Permitted factors of `--scale`.
pub const SCALES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;
static DRAWING: FileKind = FileKind {
    unreadable: "Check the path and the permissions.",
    too_large: "Purge it in the CAD system, or export only the profile.",
    ..FileKind::new("drawing")
};

/// Words in the line-type names of construction lines. Such lines inform the reader; the tool does not
/// cut along them.
const CONSTRUCTION: [&str; 8] = ["HIDDEN", "CENTER", "CENTRE", "PHANTOM", "DASH", "DIVIDE", "DOT", "ISO"];

/// The remark on a file without its end.
pub(crate) const NO_END: &str =
    "the file has no end mark (EOF): if it was cut short, contours may be missing";

/// Entity filter: the layers, entity types and line types to take, and their unit and placement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EntityFilter {
    /// Layers to take; all visible layers if empty.
    pub layers: Vec<String>,
    /// Layers to leave out.
    pub without: Vec<String>,
    /// Layers of keep-out zones and of the machine's travel. The part takes no curve from them.
    pub other_layers: Vec<String>,
    /// Unit that overrides the file's.
    pub unit: Option<String>,
    /// Line types with gaps to take nevertheless.
    pub line_types: Vec<String>,
    /// Line types with gaps that bound no contour. They may surround the part.
    pub without_line_types: Vec<String>,
    /// Factor for all coordinates, besides the unit.
    pub scale: Option<f64>,
    /// Whether to take the boundaries of hatches.
    pub hatches: bool,
    /// Whether to take the outlines of solids and traces.
    pub solids: bool,
    /// Placement of the drawing on the machine: a rotation about its origin in degrees, then an
    /// offset (x, y) in mm.
    pub placed: Option<(f64, Mm2)>,
}

impl EntityFilter {
    /// Whether the filter takes curves of the layer.
    #[must_use]
    pub fn takes_layer(&self, name: &str) -> bool {
        let has = |names: &[String]| names.iter().any(|one| same_name(one, name));
        let all = self.layers.is_empty();
        (all || has(&self.layers)) && !self.leaves_out_layer(name) && !self.is_other_layer(name)
    }

    /// Whether the user names the layer as one to leave out.
    #[must_use]
    pub fn leaves_out_layer(&self, name: &str) -> bool {
        self.without.iter().any(|one| same_name(one, name))
    }

    /// Whether the layer has keep-out zones or the machine's travel.
    pub(super) fn is_other_layer(&self, name: &str) -> bool {
        self.other_layers.iter().any(|one| same_name(one, name))
    }

    /// The reason why the filter hides an entity; `None` if it does not.
    ///
    /// The user expects an entity that is off, frozen or invisible to be left out. Its line type may surprise.
    pub(super) fn hides(
        &self,
        file: &DxfFile,
        layer: u32,
        (line_type, line_layer): (Option<u32>, u32),
        invisible: bool,
        is_insert: bool,
    ) -> Option<LeftOutReason> {
        let layer = file.layers.get(&folded(file.names.get(layer)));
        // A frozen layer hides a whole insert. A layer that is off hides only the block's entities on it.
        let hides = layer.is_some_and(|layer| layer.frozen || layer.off && !is_insert);
        if invisible || hides {
            return Some(LeftOutReason::Hidden);
        }
        if is_insert {
            return None;
        }
        let own = line_type.map(|number| folded(file.names.get(number)));
        let own = own.filter(|name| !name.is_empty() && name != "BYLAYER");
        let by_layer = file.layers.get(&folded(file.names.get(line_layer)));
        let name = own.or_else(|| by_layer.map(|layer| layer.line_type.clone())).unwrap_or_default();
        let wanted = self.line_types.iter().any(|line_type| line_type.eq_ignore_ascii_case(&name));
        let gaps = file.gaps.get(&name).copied().unwrap_or(false);
        let construction = gaps || CONSTRUCTION.iter().any(|word| name.contains(word));
        (construction && !wanted).then_some(LeftOutReason::LineType(name))
    }
}

/// Compares two names without regard to case, as CAD systems do.
fn same_name(one: &str, other: &str) -> bool {
    one.eq_ignore_ascii_case(other) || folded(one) == folded(other)
}

/// Reads the bytes of the drawing at `path`.
///
/// # Errors
/// [`FileError`] of a drawing that cannot be read, or has more than [`SIZE_MAX`] bytes.
pub fn read_file(path: &Path) -> Result<Vec<u8>, FileError> {
    DRAWING.read(path, SIZE_MAX)
}

/// Reads DXF bytes, ASCII or binary.
///
/// # Errors
/// [`DrawingError`], which names the line, entity or layer at fault and the remedy.
pub fn import(bytes: &[u8], filter: &EntityFilter) -> Result<Drawing, DrawingError> {
    curves_of(&read(bytes)?, filter)
}

/// The curves of a file that the filter takes.
///
/// # Errors
/// As [`import`].
pub(crate) fn curves_of(file: &DxfFile, filter: &EntityFilter) -> Result<Drawing, DrawingError> {
    let (scale, unit, unit_source) = scale_of(filter.unit.as_deref(), file.units)?;
    let factor = filter.scale.unwrap_or(1.0);
    if !(SCALES.contains(&factor)) {
        return Err(DrawingError::Scale { factor });
    }
    let unit = if factor == 1.0 { unit } else { format!("{unit}, scaled by {factor} (--scale)") };
    let mut placement = Placement::scaled(scale * factor);
    if let Some((degrees, by)) = filter.placed {
        placement = placement.placed(degrees, by);
    }
    let mut flattener = Flattener::new(file, filter, unit);
    flattener.run(placement)?;
    let remarks = flattener.unseen.remarks();
    let mut drawing = Drawing { unit_source, unit_mm: scale * factor, remarks, ..flattener.drawing };
    if !file.ends_well {
        drawing.remarks.push(NO_END.into());
    }
    let known = |name: &String| drawing.layers.keys().any(|layer| same_name(layer, name));
    let present = || drawing.layers.keys().map(ToString::to_string).collect();
    if let Some(missing) = filter.layers.iter().chain(&filter.other_layers).find(|name| !known(name)) {
        return Err(DrawingError::NoLayer { asked: missing.clone(), present: present() });
    }
    // The filter may also leave out a layer without curves, and layer 0, which every drawing has. Any
    // other name that the file lacks is a spelling mistake.
    let exists = |name: &String| {
        name == "0" || known(name) || file.layers.contains_key(&folded(name)) || file.names.has(name)
    };
    if let Some(strange) = filter.without.iter().find(|name| !exists(name)) {
        return Err(DrawingError::StrangeLayer { asked: strange.clone(), present: present() });
    }
    if drawing.curves.is_empty() {
        return Err(DrawingError::Empty { left_out: drawing.left_out });
    }
    Ok(drawing)
}

/// Counts the entities outside blocks that can bound a contour, by kind.
///
/// # Errors
/// [`Damage`] with the place.
pub fn census(bytes: &[u8]) -> Result<BTreeMap<&'static str, usize>, Damage> {
    let mut counts = BTreeMap::new();
    for name in read(bytes)?.entities.iter().filter_map(|entity| name_of(&entity.shape).ok()) {
        *counts.entry(name).or_default() += 1;
    }
    Ok(counts)
}

fn scale_of(asked: Option<&str>, stated: Option<i64>) -> Result<(f64, String, UnitSource), DrawingError> {
    const UNITS: [(&str, f64, i64); 16] = [
        ("mm", 1.0, 4),
        ("cm", 10.0, 5),
        ("dm", 100.0, 14),
        ("m", 1000.0, 6),
        ("in", 25.4, 1),
        ("ft", 304.8, 2),
        ("yd", 914.4, 10),
        ("mil", 0.0254, 9),
        ("µin", 25.4e-6, 8),
        ("µm", 1e-3, 13),
        ("um", 1e-3, 0),
        ("inch", 25.4, 0),
        ("inches", 25.4, 0),
        ("feet", 304.8, 0),
        ("thou", 0.0254, 0),
        ("mils", 0.0254, 0),
    ];
    if let Some(name) = asked {
        let known = UNITS.iter().find(|(unit, ..)| unit.eq_ignore_ascii_case(name));
        let (unit, scale, _) = known.ok_or_else(|| DrawingError::Unit { name: name.into() })?;
        return Ok((*scale, format!("{unit} (from --units)"), UnitSource::User));
    }
    match stated {
        None | Some(0) => {
            let unit = "mm (assumed: the file states no unit; set another with --units)".into();
            Ok((1.0, unit, UnitSource::Assumed))
        }
        Some(number) => {
            let known = UNITS.iter().find(|(.., code)| *code == number);
            let (unit, scale, _) =
                known.ok_or_else(|| DrawingError::Unit { name: format!("$INSUNITS {number}") })?;
            Ok((*scale, format!("{unit} (as the file states)"), UnitSource::File))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_a_damaged_file() {
        for bytes in
            [&b""[..], b"hello", b"\x00\x01\x02", b"0\nSECTION\n2\nENTITIES\n0\nLINE\n10\nabc\n0\nEOF\n"]
        {
            let error = import(bytes, &EntityFilter::default()).unwrap_err();
            assert!(matches!(error, DrawingError::Damaged(_)), "{bytes:?}: {error}");
        }
    }
}

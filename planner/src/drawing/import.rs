//! Reads a DXF file into curves in millimetres.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};
use std::io::Cursor;
use std::path::Path;
use std::sync::Once;

use dxf::entities::{Entity, EntityType, LwPolyline, Polyline};
use dxf::enums::Units;
use dxf::tables::Layer;

use super::{Drawing, DrawingError, DrawnCurve, Origin, RawCurve};

/// Largest file that is read, in bytes.
pub const SIZE_MAX: u64 = 512 << 20;

/// An arc flatter than this (mm, half a lattice unit) is drawn as its chord.
const FLAT_MM: f64 = 5e-6;

/// What a line type says about a line: these are drawn for the reader, not for the cutter.
const CONSTRUCTION: [&str; 7] = ["HIDDEN", "CENTER", "CENTRE", "PHANTOM", "DASHDOT", "DIVIDE", "ISO"];

/// Reads the bytes of the drawing at `path`.
///
/// # Errors
/// [`DrawingError::Read`] and [`DrawingError::TooLarge`].
pub fn read_file(path: &Path) -> Result<Vec<u8>, DrawingError> {
    let failed = |source| DrawingError::Read { path: path.to_path_buf(), source };
    let bytes = std::fs::metadata(path).map_err(failed)?.len();
    if bytes > SIZE_MAX {
        return Err(DrawingError::TooLarge { bytes });
    }
    std::fs::read(path).map_err(failed)
}

/// Reads DXF bytes, ASCII or binary. `layers` restricts to those layers when not empty; `unit` overrides the file's.
///
/// # Errors
/// [`DrawingError`], naming the line, entity or layer at fault and the remedy.
pub fn import(bytes: &[u8], layers: &[String], unit: Option<&str>) -> Result<Drawing, DrawingError> {
    let file = load(bytes)?;
    let (scale, unit) = scale_of(unit, file.header.default_drawing_units)?;
    let table: BTreeMap<String, &Layer> =
        file.layers().map(|layer| (layer.name.to_uppercase(), layer)).collect();
    let frozen = frozen_layers(bytes);
    let mut drawing = Drawing { unit, ..Drawing::default() };
    let mut present: Vec<String> = Vec::new();
    let mut unsupported: BTreeMap<&'static str, (usize, String)> = BTreeMap::new();
    for (index, entity) in file.entities().enumerate() {
        let layer = &entity.common.layer;
        let mut leave_out = |why: String| *drawing.left_out.entry(why).or_default() += 1;
        let Some(kind) = curve_kind(&entity.specific) else {
            leave_out(format!("{} (no profile)", kind_name(&entity.specific)));
            continue;
        };
        let name = layer.to_uppercase();
        if let Some(why) = invisible(entity, table.get(&name).copied(), frozen.contains(&name)) {
            leave_out(why);
            continue;
        }
        if !present.contains(layer) {
            present.push(layer.clone());
        }
        if !layers.is_empty() && !layers.iter().any(|asked| asked.eq_ignore_ascii_case(layer)) {
            leave_out("on layers not asked for".into());
            continue;
        }
        let origin = Origin { kind, handle: entity.common.handle.0, number: index + 1, layer: layer.clone() };
        match curves_of(&entity.specific, scale, &origin)? {
            Some(curves) => drawing
                .curves
                .extend(curves.into_iter().map(|curve| DrawnCurve { curve, origin: origin.clone() })),
            None => unsupported.entry(kind).or_insert((0, layer.clone())).0 += 1,
        }
    }
    if let Some((kind, (count, layer))) = unsupported.into_iter().next() {
        return Err(DrawingError::Unsupported { kind: kind.into(), count, layer });
    }
    if drawing.curves.is_empty() {
        return Err(DrawingError::Empty { asked: layers.to_vec(), present });
    }
    Ok(drawing)
}

/// The names (upper case) of frozen layers in an ASCII file: the DXF reader drops the flag (code 70, bit 1).
fn frozen_layers(bytes: &[u8]) -> BTreeSet<String> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines().map(str::trim);
    let mut frozen = BTreeSet::new();
    let (mut in_layer, mut name) = (false, String::new());
    while let (Some(code), Some(value)) = (lines.next(), lines.next()) {
        match (code, value) {
            ("2", "ENTITIES") => break,
            ("0", kind) => in_layer = kind == "LAYER",
            ("2", value) if in_layer => name = value.to_uppercase(),
            ("70", flags) if in_layer && flags.parse::<i32>().is_ok_and(|flags| flags & 1 != 0) => {
                frozen.insert(name.clone());
            }
            _ => {}
        }
    }
    frozen
}

/// Parses the file. The reader is kept from taking the program down: a panic in it is a damaged file.
fn load(bytes: &[u8]) -> Result<dxf::Drawing, DrawingError> {
    let looks_like_dxf =
        bytes.starts_with(b"AutoCAD Binary DXF") || bytes.iter().take(4096).any(|&b| b == b'\n');
    if !looks_like_dxf {
        return Err(DrawingError::Damaged { reason: "it has no DXF group codes".into() });
    }
    let parse = || dxf::Drawing::load(&mut Cursor::new(bytes));
    match quietly(parse) {
        Some(Ok(file)) => Ok(file),
        Some(Err(error)) => Err(DrawingError::Damaged { reason: error.to_string() }),
        None => Err(DrawingError::Damaged { reason: "the DXF reader gave up on its contents".into() }),
    }
}

thread_local! {
    /// Whether panics of this thread are expected, and say nothing.
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work`, turning a panic of the DXF reader into `None`, without its message.
fn quietly<T>(work: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if !QUIET.get() {
                usual(info);
            }
        }));
    });
    QUIET.set(true);
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).ok();
    QUIET.set(false);
    result
}

fn scale_of(asked: Option<&str>, stated: Units) -> Result<(f64, String), DrawingError> {
    if let Some(name) = asked {
        let scale = match name.to_lowercase().as_str() {
            "mm" => 1.0,
            "cm" => 10.0,
            "m" => 1000.0,
            "in" | "inch" => 25.4,
            "ft" => 304.8,
            _ => return Err(DrawingError::Unit { name: name.into() }),
        };
        return Ok((scale, format!("{name} (as asked)")));
    }
    let stated = match stated {
        Units::Millimeters => (1.0, "mm"),
        Units::Centimeters => (10.0, "cm"),
        Units::Decimeters => (100.0, "dm"),
        Units::Meters => (1000.0, "m"),
        Units::Inches => (25.4, "in"),
        Units::Feet => (304.8, "ft"),
        Units::Yards => (914.4, "yd"),
        Units::Mils => (0.0254, "mil"),
        Units::Microinches => (25.4e-6, "microinch"),
        Units::Microns => (1e-3, "µm"),
        _ => return Ok((1.0, "mm (the file states none)".into())),
    };
    Ok((stated.0, format!("{} (as the file states)", stated.1)))
}

fn kind_name(entity: &EntityType) -> &'static str {
    match entity {
        EntityType::Text(_) | EntityType::MText(_) => "text",
        EntityType::Attribute(_) | EntityType::AttributeDefinition(_) => "attribute",
        EntityType::ModelPoint(_) => "point",
        EntityType::Leader(_) | EntityType::MLine(_) => "leader or multiline",
        EntityType::Seqend(_) => "sequence end",
        EntityType::RotatedDimension(_)
        | EntityType::RadialDimension(_)
        | EntityType::DiameterDimension(_)
        | EntityType::AngularThreePointDimension(_)
        | EntityType::OrdinateDimension(_) => "dimension",
        _ => "other entity",
    }
}

/// The DXF name of an entity that can bound a part, supported or not.
fn curve_kind(entity: &EntityType) -> Option<&'static str> {
    Some(match entity {
        EntityType::Line(_) => "LINE",
        EntityType::Arc(_) => "ARC",
        EntityType::Circle(_) => "CIRCLE",
        EntityType::LwPolyline(_) => "LWPOLYLINE",
        EntityType::Polyline(_) => "POLYLINE",
        EntityType::Ellipse(_) => "ELLIPSE",
        EntityType::Spline(_) => "SPLINE",
        EntityType::Insert(_) => "INSERT",
        _ => return None,
    })
}

fn invisible(entity: &Entity, layer: Option<&Layer>, frozen: bool) -> Option<String> {
    if entity.common.is_in_paper_space {
        return Some("in paper space".into());
    }
    if !entity.common.is_visible || frozen || layer.is_some_and(|layer| !layer.is_layer_on) {
        return Some("hidden, off or frozen".into());
    }
    let named = &entity.common.line_type_name;
    let by_layer = named.is_empty() || named.eq_ignore_ascii_case("BYLAYER");
    let line_type = if by_layer { layer.map(|layer| &layer.line_type_name) } else { Some(named) };
    let line_type = line_type?.to_uppercase();
    CONSTRUCTION
        .iter()
        .any(|name| line_type.contains(name))
        .then(|| format!("construction lines ({line_type})"))
}

type Curves = Result<Option<Vec<RawCurve>>, DrawingError>;

fn curves_of(entity: &EntityType, scale: f64, origin: &Origin) -> Curves {
    let bad = |problem| DrawingError::BadEntity { origin: Box::new(origin.clone()), problem };
    let curves = match entity {
        EntityType::Line(line) => {
            let at = |p: &dxf::Point| (p.x * scale, p.y * scale);
            vec![RawCurve::Line { from: at(&line.p1), to: at(&line.p2) }]
        }
        EntityType::Arc(arc) => {
            let sweep = (arc.end_angle - arc.start_angle).to_radians().rem_euclid(TAU);
            let sweep = if sweep == 0.0 { TAU } else { sweep };
            let centre = (arc.center.x * scale, arc.center.y * scale);
            let raw = arc_from_angles(centre, arc.radius * scale, arc.start_angle.to_radians(), sweep);
            vec![in_plane(raw, &arc.normal).ok_or(bad("the arc lies in a tilted plane"))?]
        }
        EntityType::Circle(circle) => {
            let centre = (circle.center.x * scale, circle.center.y * scale);
            let raw = arc_from_angles(centre, circle.radius * scale, 0.0, TAU);
            vec![in_plane(raw, &circle.normal).ok_or(bad("the circle lies in a tilted plane"))?]
        }
        EntityType::LwPolyline(line) => {
            let curves = lw_polyline(line, scale, &bad)?;
            flipped(curves, &line.extrusion_direction).ok_or(bad("the polyline lies in a tilted plane"))?
        }
        EntityType::Polyline(line) => {
            let curves = polyline(line, scale, &bad)?;
            flipped(curves, &line.normal).ok_or(bad("the polyline lies in a tilted plane"))?
        }
        _ => return Ok(None),
    };
    for curve in &curves {
        match *curve {
            RawCurve::Line { from, to } if ![from.0, from.1, to.0, to.1].iter().all(|c| c.is_finite()) => {
                return Err(bad("a coordinate is no number"));
            }
            RawCurve::Arc { centre, radius, start, sweep, .. }
                if ![centre.0, centre.1, radius, start, sweep].iter().all(|c| c.is_finite()) =>
            {
                return Err(bad("a coordinate, radius or angle is no number"));
            }
            RawCurve::Arc { radius, .. } if radius <= 0.0 => return Err(bad("the radius is not positive")),
            _ => {}
        }
    }
    Ok(Some(curves))
}

fn arc_from_angles(centre: (f64, f64), radius: f64, start: f64, sweep: f64) -> RawCurve {
    let at = |phi: f64| (centre.0 + radius * phi.cos(), centre.1 + radius * phi.sin());
    let from = at(start);
    let to = if sweep.abs() >= TAU { from } else { at(start + sweep) };
    RawCurve::Arc { centre, radius, from, to, start, sweep }
}

fn flipped(curves: Vec<RawCurve>, normal: &dxf::Vector) -> Option<Vec<RawCurve>> {
    curves.into_iter().map(|curve| in_plane(curve, normal)).collect()
}

/// A curve of the object's own plane in drawing coordinates: as it is for the normal (0, 0, 1), mirrored in x for
/// (0, 0, −1), nothing for a tilted plane.
fn in_plane(curve: RawCurve, normal: &dxf::Vector) -> Option<RawCurve> {
    if normal.x.abs() > 1e-6 || normal.y.abs() > 1e-6 || normal.z == 0.0 {
        return None;
    }
    if normal.z > 0.0 {
        return Some(curve);
    }
    let mirror = |p: (f64, f64)| (-p.0, p.1);
    Some(match curve {
        RawCurve::Line { from, to } => RawCurve::Line { from: mirror(from), to: mirror(to) },
        RawCurve::Arc { centre, radius, from, to, start, sweep } => RawCurve::Arc {
            centre: mirror(centre),
            radius,
            from: mirror(from),
            to: mirror(to),
            start: PI - start,
            sweep: -sweep,
        },
    })
}

type Bad<'a> = &'a dyn Fn(&'static str) -> DrawingError;

fn lw_polyline(line: &LwPolyline, scale: f64, bad: Bad<'_>) -> Result<Vec<RawCurve>, DrawingError> {
    let vertices: Vec<((f64, f64), f64)> =
        line.vertices.iter().map(|v| ((v.x * scale, v.y * scale), v.bulge)).collect();
    bulged(&vertices, line.flags & 1 != 0, bad)
}

fn polyline(line: &Polyline, scale: f64, bad: Bad<'_>) -> Result<Vec<RawCurve>, DrawingError> {
    const MESHES: i32 = 16 | 64;
    const SPLINE_FRAME: i32 = 16;
    if line.flags & MESHES != 0 {
        return Err(bad("a polygon mesh or polyface is no contour"));
    }
    let vertices: Vec<((f64, f64), f64)> = line
        .vertices()
        .filter(|v| v.flags & SPLINE_FRAME == 0)
        .map(|v| ((v.location.x * scale, v.location.y * scale), v.bulge))
        .collect();
    bulged(&vertices, line.flags & 1 != 0, bad)
}

fn bulged(vertices: &[((f64, f64), f64)], closed: bool, bad: Bad<'_>) -> Result<Vec<RawCurve>, DrawingError> {
    let count = if closed { vertices.len() } else { vertices.len().saturating_sub(1) };
    let mut curves = Vec::with_capacity(count);
    for i in 0..count {
        let (from, bulge) = vertices[i];
        let (to, _) = vertices[(i + 1) % vertices.len()];
        if !bulge.is_finite() {
            return Err(bad("a bulge is no number"));
        }
        if from != to {
            curves.push(bulge_curve(from, to, bulge));
        }
    }
    Ok(curves)
}

/// The arc from `from` to `to` with `bulge` = tan(sweep / 4); its chord when it is flat.
fn bulge_curve(from: (f64, f64), to: (f64, f64), bulge: f64) -> RawCurve {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let chord = dx.hypot(dy);
    if bulge.abs() * chord / 2.0 < FLAT_MM {
        return RawCurve::Line { from, to };
    }
    // Distance from the chord's middle to the centre, to the left of the chord: chord·(1 − b²) / 4b.
    let to_centre = (1.0 - bulge * bulge) / (4.0 * bulge);
    let centre = (f64::midpoint(from.0, to.0) - dy * to_centre, f64::midpoint(from.1, to.1) + dx * to_centre);
    let radius = chord * (1.0 + bulge * bulge) / (4.0 * bulge.abs());
    let start = (from.1 - centre.1).atan2(from.0 - centre.0);
    RawCurve::Arc { centre, radius, from, to, start, sweep: 4.0 * bulge.atan() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bulge_of_a_semicircle() {
        let RawCurve::Arc { centre, radius, sweep, .. } = bulge_curve((0.0, 0.0), (10.0, 0.0), 1.0) else {
            panic!("a bulge of one is an arc")
        };
        assert!((centre.0 - 5.0).abs() < 1e-12 && centre.1.abs() < 1e-12 && (radius - 5.0).abs() < 1e-12);
        assert!((sweep - PI).abs() < 1e-12);
    }

    #[test]
    fn quarter_bulge_bends_to_the_right_of_the_chord() {
        // bulge > 0 turns counter-clockwise: the arc from (0,0) to (1,1) about (0,1).
        let bulge = (PI / 8.0).tan();
        let RawCurve::Arc { centre, .. } = bulge_curve((0.0, 0.0), (1.0, 1.0), bulge) else { panic!() };
        assert!((centre.0).abs() < 1e-12 && (centre.1 - 1.0).abs() < 1e-12, "{centre:?}");
    }

    #[test]
    fn nonsense_is_a_damaged_file() {
        for bytes in [&b""[..], b"hello", b"\x00\x01\x02", b"0\nSECTION\n2\nENTITIES\n0\nLINE\n10\nabc\n"] {
            let error = import(bytes, &[], None).unwrap_err();
            assert!(
                matches!(error, DrawingError::Damaged { .. } | DrawingError::Empty { .. }),
                "{bytes:?}: {error}"
            );
        }
    }
}

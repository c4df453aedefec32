//! The independent reading of the shared drawings, and the comparison with ours.

use std::collections::BTreeMap;
use std::path::Path;

use keepout_planner::inspect::Inspection;
use serde_json::Value;

/// The independent reading of a drawing, in mm.
pub struct Oracle {
    /// The program that wrote the file.
    pub exporter: String,
    /// Its DXF version.
    pub version: String,
    /// The defects of the file.
    pub defects: Vec<String>,
    /// Closed loops, their even-odd area with its tolerance, and the box around them. `None` if the reading
    /// failed.
    pub reading: Option<OracleReading>,
}

/// The closed loops of a drawing and their area.
pub struct OracleReading {
    /// Count of closed loops.
    pub loops: usize,
    /// Their area by the even-odd rule, mm².
    pub area: f64,
    /// Tolerance of that area, mm².
    pub area_tolerance: f64,
    /// The box around the loops, mm. `None` without loops.
    pub bounds: Option<[f64; 4]>,
}

/// Reads the oracle's entries, by file name under `dxf/`.
///
/// # Errors
/// The fault of the oracle's file.
pub fn read(shared: &Path) -> Result<BTreeMap<String, Oracle>, String> {
    let path = shared.join("dxf/oracle_dev.json");
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let entries: BTreeMap<String, Value> = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    Ok(entries.into_iter().map(|(name, entry)| (name, oracle(&entry))).collect())
}

fn oracle(entry: &Value) -> Oracle {
    let text = |name: &str| entry[name].as_str().unwrap_or("").to_string();
    let defects = entry["defects"].as_array().cloned().unwrap_or_default();
    Oracle {
        exporter: text("exporter"),
        version: text("version"),
        defects: defects.iter().filter_map(Value::as_str).map(ToString::to_string).collect(),
        reading: reading(entry),
    }
}

fn reading(entry: &Value) -> Option<OracleReading> {
    let reference = &entry["ref"];
    // Millimetres per unit of the file. `$INSUNITS` 1 is inches, 6 is metres.
    let scale = match entry["insunits"].as_u64() {
        Some(1) => 25.4,
        Some(6) => 1000.0,
        _ => 1.0,
    };
    let corners: Option<Vec<f64>> = reference["bbox_loops"].as_array()?.iter().map(Value::as_f64).collect();
    Some(OracleReading {
        loops: usize::try_from(reference["loops"].as_u64()?).ok()?,
        area: reference["area_evenodd"].as_f64()? * scale * scale,
        area_tolerance: reference["area_tolerance"].as_f64().unwrap_or(0.0) * scale * scale,
        bounds: corners.and_then(|corners| corners.try_into().ok()).map(|c: [f64; 4]| c.map(|c| c * scale)),
    })
}

impl OracleReading {
    /// Compares our reading: the same loops, the area within 0.1 % and the oracle's tolerance, the box within
    /// 0.02 mm.
    ///
    /// # Errors
    /// The first difference.
    pub fn agrees(&self, found: &Inspection) -> Result<(), String> {
        // The oracle counts a line drawn there and back as a loop. Ours lists it as a repair.
        let flat = found.repairs.iter().filter(|note| note.text.contains("drawn there and back")).count();
        let loops = found.contours.len() + flat;
        if loops != self.loops {
            return Err(format!("{loops} contours, the oracle has {}", self.loops));
        }
        if (found.area_mm2 - self.area).abs() > 0.001 * self.area.abs() + self.area_tolerance {
            return Err(format!("area {:.3} mm², the oracle has {:.3}", found.area_mm2, self.area));
        }
        match (found.box_mm, self.bounds) {
            (Some(ours), Some(bounds)) => {
                let off = <[f64; 4]>::from(ours)
                    .into_iter()
                    .zip(bounds)
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, f64::max);
                if off > 0.02 { Err(format!("box off by {off:.4} mm")) } else { Ok(()) }
            }
            _ => Ok(()),
        }
    }
}

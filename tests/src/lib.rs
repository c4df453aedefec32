//! What the end-to-end tests share: making plans from drawings, and finding the shared test data.
//!
//! ```
//! assert_eq!(keepout_tests::order(3.0).job.tool_diameter_mm, 3.0);
//! ```

pub mod decisions;
pub mod feel;
pub mod hostile;
#[cfg(unix)]
pub mod kills;
pub mod oracle;

use std::path::{Path, PathBuf};

use keepout_planner::drawing::read_file;
use keepout_planner::machine::MachineProfile;
use keepout_planner::margin::TermKind;
use keepout_planner::plan::{CertifiedPlan, PlanParameters};
use keepout_planner::request::{PlanRequest, PlanRequestError};

/// An order for a tool of the diameter, all else by default.
#[must_use]
pub fn order(tool_diameter_mm: f64) -> PlanRequest {
    PlanRequest {
        job: PlanParameters { tool_diameter_mm, ..PlanParameters::default() },
        ..PlanRequest::default()
    }
}

/// Drawing file to certified plan for the simulated machine.
///
/// # Errors
/// The message that a person would read.
pub fn plan_of(path: &Path, order: &PlanRequest) -> Result<CertifiedPlan, String> {
    let bytes = read_file(path).map_err(|error| error.to_string())?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    plan_bytes(&name, &bytes, order).map_err(|error| error.to_string())
}

/// Drawing bytes to certified plan for the simulated machine.
///
/// # Errors
/// [`PlanRequestError`].
pub fn plan_bytes(name: &str, bytes: &[u8], order: &PlanRequest) -> Result<CertifiedPlan, PlanRequestError> {
    order.plan(name, bytes, &MachineProfile::simulated(), &mut |_| {})
}

/// How much a finishing path may leave on the part, mm: the margin, and what the tool may be off by
/// beside it, by the plan's own terms.
#[must_use]
pub fn most_left_mm(plan: &CertifiedPlan) -> f64 {
    let terms = &plan.plan.budget.terms;
    let physical = [TermKind::ContourError, TermKind::Repeatability, TermKind::StepResolution];
    let off = terms.iter().filter(|term| physical.contains(&term.kind));
    terms.iter().map(|term| term.mm).sum::<f64>() + off.map(|term| term.mm).sum::<f64>()
}

/// Area of the part's contours by the even–odd rule, mm².
#[must_use]
pub fn area_mm2(plan: &CertifiedPlan) -> f64 {
    let region = plan.part.region();
    let rings = region.rings().iter().zip(region.depths());
    let signed = rings.map(|(ring, depth)| {
        let area = ring.double_area().unsigned_abs();
        let area = u64::try_from(area).map_or(f64::INFINITY, |area| approximate(area) / 2e10);
        if depth % 2 == 0 { area } else { -area }
    });
    signed.sum()
}

#[expect(clippy::cast_precision_loss, reason = "areas are compared to a thousandth")]
fn approximate(value: u64) -> f64 {
    value as f64
}

/// The folder of shared test data, from `KEEPOUT_SHARED`; says on standard error when a test is skipped without it.
#[must_use]
pub fn shared() -> Option<PathBuf> {
    let folder = std::env::var_os("KEEPOUT_SHARED").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: no KEEPOUT_SHARED");
    }
    folder
}

/// Drawings of the shared set that the whole job is run on: file, exporter.
pub const REAL_DRAWINGS: [(&str, &str); 16] = [
    ("gen__dev_cq_plate.dxf", "ezdxf (CadQuery)"),
    ("gen__dev_fc_plate_r14.dxf", "FreeCAD"),
    ("gen__dev_mk_ellipse.dxf", "maker.js"),
    ("Mendel90__y_heatshield.dxf", "OpenSCAD"),
    ("dxf__hatches.dxf", "LibreCAD"),
    ("lumberjack-keyboard__brutal60-split.dxf", "KiCad"),
    ("source_one__SO_v0.2_5inch_arm_hole_4mm_4x.dxf", "QCAD"),
    ("source_one__Wolf_Outline.dxf", "AutoCAD-style writer"),
    ("trimesh__apu-mount.DXF", "SolidWorks"),
    ("trimesh__2_cycloidal.dxf", "AutoCAD family"),
    ("trimesh__ChuteHolderPrint.DXF", "SolidWorks"),
    ("trimesh__buffer_regions.dxf", "AutoCAD family"),
    ("trimesh__wrench.dxf", "unknown"),
    ("dxf__issue27b.dxf", "Adobe Illustrator, splines"),
    ("ezdxf__x0292430_c.dxf", "Creo, splines and ellipses"),
    ("gen__dev_fc_cam_r14.dxf", "FreeCAD, spline"),
];

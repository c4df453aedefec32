//! Helpers of the end-to-end tests: plans from drawings, and the folder of shared test data.

pub mod decisions;
pub mod feel;
pub mod histogram;
pub mod hostile;
#[cfg(unix)]
pub mod kills;
pub mod oracle;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use keepout_planner::drawing::read_file;
use keepout_planner::machine::MachineProfile;
use keepout_planner::margin::TermKind;
use keepout_planner::plan::{CertifiedPlan, PlanParameters};
use keepout_planner::request::{PlanRequest, PlanRequestError};

/// A plan request for a tool of this diameter, mm. All other parameters have their defaults.
#[must_use]
pub fn order(tool_diameter_mm: f64) -> PlanRequest {
    PlanRequest {
        job: PlanParameters { tool_diameter_mm, ..PlanParameters::default() },
        ..PlanRequest::default()
    }
}

/// The certified plan of a drawing file, for the simulated machine.
///
/// # Errors
/// The message for the operator.
pub fn plan_of(path: &Path, request: &PlanRequest) -> Result<CertifiedPlan, String> {
    let bytes = read_file(path).map_err(|error| error.to_string())?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    plan_bytes(&name, &bytes, request).map_err(|error| error.to_string())
}

/// The certified plan of a drawing's bytes, for the simulated machine.
///
/// # Errors
/// [`PlanRequestError`].
pub fn plan_bytes(
    name: &str,
    bytes: &[u8],
    request: &PlanRequest,
) -> Result<CertifiedPlan, PlanRequestError> {
    request.plan(name, bytes, &MachineProfile::simulated(), &mut |_| {})
}

/// The most material that a finishing toolpath may leave on the part, mm. It is the margin plus the machine's
/// own error terms in the plan: the tool may be off by these to the other side, too.
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

/// The folder of shared test data, from `KEEPOUT_SHARED`. Without it, it prints on standard error that the
/// test is skipped.
#[must_use]
pub fn shared() -> Option<PathBuf> {
    let folder = std::env::var_os("KEEPOUT_SHARED").map(PathBuf::from);
    if folder.is_none() {
        // The harness would keep what `eprintln!` prints.
        let _ = writeln!(std::io::stderr(), "skipped: no KEEPOUT_SHARED");
    }
    folder
}

/// The drawings of the shared set for the end-to-end job: file, exporter.
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

//! What independent checks of the first wave found. Each test showed its finding before the mend.
#![expect(clippy::unwrap_used, reason = "a test may stop")]

mod dxf;
mod figures;
mod part_and_air;
mod pictures;
mod remarks;
mod repairs;

use keepout_planner::inspect::{Inspection, inspect};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::request::PlanRequest;
use keepout_tests::{order, plan_bytes};

/// The plan for a tool of this diameter, or the message.
fn plan(sketch: &dxf::SmallDrawing, tool_mm: f64) -> Result<CertifiedPlan, String> {
    plan_with(sketch, &order(tool_mm))
}

fn plan_with(sketch: &dxf::SmallDrawing, request: &PlanRequest) -> Result<CertifiedPlan, String> {
    plan_bytes("sketch.dxf", &sketch.bytes(), request).map_err(|error| error.to_string())
}

fn inspected(sketch: &dxf::SmallDrawing) -> Inspection {
    let request = PlanRequest::default();
    let (drawing, chained) = request.contours(&sketch.bytes()).unwrap();
    inspect(&drawing, &chained, &request.choice)
}

//! The small plan for logs and sessions.

use std::sync::OnceLock;

use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::machine::MachineProfile;
use keepout_planner::request::PlanRequest;
use keepout_planner::{plan_file, sha256};

/// A plate of 24 × 16 mm with a slot that the tool enters and a step.
pub const PLATE: &str = "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n\
    0\nLWPOLYLINE\n8\n0\n90\n10\n70\n1\n10\n0\n20\n0\n10\n24\n20\n0\n10\n24\n20\n10\n10\n18\n20\n16\n10\n\
    14\n20\n16\n10\n14\n20\n8\n10\n6\n20\n8\n10\n6\n20\n16\n10\n3\n20\n16\n10\n0\n20\n12\n0\nENDSEC\n0\n\
    EOF\n";

/// The plate, planned for a tool of 6 mm on the simulated machine.
///
/// # Panics
/// Never: it can be planned.
#[must_use]
pub fn work() -> PreparedPlan {
    static WORK: OnceLock<PreparedPlan> = OnceLock::new();
    let planned = || {
        let machine = MachineProfile::simulated();
        let plan = PlanRequest::default().plan("plate", PLATE.as_bytes(), &machine, &mut |_| {});
        PreparedPlan::new(plan.expect("the plate can be planned"))
    };
    WORK.get_or_init(planned).clone()
}

/// The hash of its plan file, as logs name it.
///
/// # Panics
/// Never: a plan in memory can be written.
#[must_use]
pub fn hash() -> &'static str {
    static HASH: OnceLock<String> = OnceLock::new();
    HASH.get_or_init(|| {
        let bytes = plan_file::encode(&work().plan.plan).expect("a plan in memory can be written");
        sha256::hex(&sha256::hash(&bytes))
    })
}

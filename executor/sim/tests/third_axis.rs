//! Whole sessions with a third axis: a part with an outline, two through holes and a pocket, from solid stock.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::session::{Going, NoEventLog};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::depth::{DepthParameters, EntryMove, FaceChoice, FaceDepth};
use keepout_planner::machine::{MachineProfile, ZProfile};
use keepout_planner::plan::PlanParameters;
use keepout_planner::request::PlanRequest;
use keepout_sim::operator;
use keepout_sim::session::{Scene, SimResult, SimRun, run_simulated};

/// A dialect description with a third axis.
const DESCRIBED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/described/three-axes.toml");

fn machine() -> MachineProfile {
    MachineProfile { z: Some(ZProfile::simulated()), ..MachineProfile::simulated() }
}

/// A cover of 6 mm: two holes go through, the pocket is 3 mm deep, and a pass takes 2 mm at most.
fn work(entry: EntryMove) -> PreparedPlan {
    let bytes = include_bytes!("../../cli/drawings/cover.dxf");
    let pocket = FaceDepth { of: FaceChoice::Layer("POCKET".into()), depth_mm: Some(3.0) };
    let depth =
        DepthParameters { faces: vec![pocket], step_down_mm: Some(2.0), entry, ..DepthParameters::of(6.0) };
    let job = PlanParameters { depth: Some(depth), ..PlanParameters::default() };
    let request = PlanRequest { job, ..PlanRequest::default() };
    PreparedPlan::new(request.plan("cover", bytes, &machine(), &mut |_| {}).unwrap())
}

fn session(entry: EntryMove, dialect: DialectName, seed: u64) -> SimResult {
    let run = SimRun {
        machine: machine(),
        dialect,
        seed,
        baud: 38_400,
        latency: Duration::from_millis(20),
        ..SimRun::default()
    };
    let operator = operator::named("wall", 20.0, seed).unwrap();
    run_simulated(work(entry), &run, operator, Box::new(NoEventLog), &mut |_, _, _| Going::On).unwrap()
}

#[test]
fn dialect_of_two_axes_is_refused() {
    let run = SimRun { machine: machine(), dialect: DialectName::Venus, ..SimRun::default() };
    let refused = Scene::of(work(EntryMove::Plunge), &run).unwrap_err().to_string();
    assert!(refused.starts_with("the plan has depths, and the dialect venus moves two axes"), "{refused}");
}

#[test]
fn whole_part_is_cut_from_solid_stock_by_a_plunging_operator() {
    let (ramp, plunge) = (EntryMove::default(), EntryMove::Plunge);
    let sessions = [("grbl", ramp), ("grblhal", plunge), ("zaber", plunge), (DESCRIBED, plunge)];
    for (dialect, entry) in sessions {
        let result = session(entry, DialectName::named(dialect).unwrap(), 3);
        let facts = &result.facts;
        assert_eq!(facts.deepest_mm, Some(0.0), "{dialect}: {facts:?}");
        assert_eq!(facts.outcome.to_string(), "complete: 4 of 4 contours cut", "{dialect}: {facts:?}");
    }
}

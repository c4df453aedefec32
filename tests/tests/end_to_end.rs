//! The end-to-end job on our own drawings: passes, climb milling, clamps, a turned drawing.

use std::path::Path;
use std::time::Duration;

use keepout_executor::session::{Going, NoEventLog};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::Mm2;
use keepout_planner::plan::{Cut, PassParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::PlanRequest;
use keepout_sim::operator;
use keepout_sim::session::{Link, SimRun, run_simulated};
use keepout_tests::{most_left_mm, order, plan_of};

/// Runs the job with an operator over a slow line. The error is the failed outcome.
fn run(drawing: &str, request: &PlanRequest, operator: &str) -> Result<(), String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("drawings");
    let plan = plan_of(&folder.join(drawing), request)?;
    let loops = plan.plan.loop_count();
    let most_left_mm = most_left_mm(&plan);
    let run = SimRun {
        link: Link::Virtual,
        baud: 9600,
        latency: Duration::from_millis(150),
        feed_mm_min: 3000,
        ..SimRun::default()
    };
    let operator = operator::named(operator, 15.0, 7).map_err(|error| error.to_string())?;
    let result =
        run_simulated(PreparedPlan::new(plan), &run, operator, Box::new(NoEventLog), &mut |_, _, _| {
            Going::On
        })
        .map_err(|error| error.to_string())?;
    let facts = result.facts;
    let coverage = facts.coverage.ok_or(format!("no contour was cut: {facts:?}"))?;
    let whole = facts.outcome.is_by_operator()
        && !facts.outcome.lacks_link_move()
        && result.work.plan.plan.loop_count() == loops;
    let good = facts.deepest_mm == Some(0.0)
        && facts.closest_by_hand_mm.is_some_and(|closest| closest > 0.2)
        && coverage.missed == 0
        && coverage.worst_mm <= most_left_mm;
    if whole && good && !facts.progress.finished.is_empty() { Ok(()) } else { Err(format!("{facts:?}")) }
}

#[test]
fn splines_are_cut_in_two_passes_climb_and_conventional() {
    let mut wanted = order(4.0);
    wanted.job.passes = vec![
        PassParameters { stock_to_leave_mm: 0.1, feed_mm_min: Some(3000) },
        PassParameters { stock_to_leave_mm: 0.0, feed_mm_min: Some(1500) },
    ];
    for (cut, operator) in [(Cut::Conventional, "wall"), (Cut::Climb, "calm")] {
        wanted.job.cut = cut;
        run("rounded_plate.dxf", &wanted, operator).unwrap_or_else(|reason| panic!("{cut:?}: {reason}"));
    }
}

#[test]
fn tool_keeps_out_of_clamps_and_goes_around_them() {
    let mut wanted = order(6.0);
    wanted.keep_out_layers = vec!["CLAMPS".into()];
    wanted.travel_layer = Some("TABLE".into());
    for side in [MachinedSide::Outside, MachinedSide::Inside] {
        wanted.job.side = side;
        for operator in ["wall", "random"] {
            run("clamps.dxf", &wanted, operator)
                .unwrap_or_else(|reason| panic!("{side:?}, {operator}: {reason}"));
        }
    }
}

#[test]
fn turned_drawing_is_cut() {
    let mut wanted = order(4.0);
    wanted.choice.placed = Some((33.3, Mm2::new(12.5, -7.25)));
    run("rounded_plate.dxf", &wanted, "reversal").unwrap_or_else(|reason| panic!("{reason}"));
}

//! The hostile run, with the guard as it is and with its in-flight rule taken out.

use std::time::Duration;

use keepout_planner::machine::MachineProfile;
use keepout_planner::order::Order;
use keepout_planner::plan::CertifiedPlan;

use super::log::Log;
use super::simulated::{SimRun, run_simulated};
use crate::operator;

fn bracket() -> CertifiedPlan {
    let bytes = include_bytes!("../../drawings/bracket.dxf");
    Order::default().plan("bracket", bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap()
}

/// Deepest incursion of one minute of an operator over a slow line, mm.
fn deepest(operator: &str, seed: u64, forget_in_flight: bool) -> f64 {
    let run = SimRun {
        baud: 9600,
        latency: Duration::from_millis(150),
        seed,
        limit: Duration::from_secs(60),
        ..SimRun::default()
    };
    let operator = operator::named(operator, 3600.0, seed).unwrap();
    let prepare = |supervisor: &mut crate::supervisor::Supervisor| {
        supervisor.guard_mut().forget_in_flight = forget_in_flight;
    };
    let result = run_simulated(bracket(), &run, operator, Log::none(), prepare, &mut |_, _, _| {}).unwrap();
    assert!(result.watched > 100_000, "the witness watched at 2 kHz");
    assert!(result.facts.counts.jogs > 20, "the operator did steer: {:?}", result.facts);
    let by_hand = result.facts.closest_by_hand_mm.unwrap();
    assert!(forget_in_flight || by_hand > 0.2, "by hand the allowance of 0.2 mm is kept: {by_hand}");
    result.facts.deepest_mm.unwrap()
}

#[test]
fn nobody_gets_in_and_without_the_in_flight_rule_they_do() {
    let mut invasions = 0;
    for operator in ["wall", "random", "reversal"] {
        for seed in 0..4 {
            assert_eq!(
                deepest(operator, seed, false).to_bits(),
                0.0_f64.to_bits(),
                "{operator}, seed {seed}"
            );
            invasions += u32::from(deepest(operator, seed, true) > 0.0);
        }
    }
    assert!(invasions >= 3, "only {invasions} of 12 hostile runs got in without the in-flight rule");
}

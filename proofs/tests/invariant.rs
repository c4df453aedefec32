//! The guard's invariant, explored in every world.
#![cfg(feature = "guard")]

use std::sync::atomic::{AtomicUsize, Ordering};

use keepout_proofs::second_controller::SecondController;
use keepout_proofs::worlds;

/// States of each world that this test explores. `explore` in `.ci/weekly` goes on to the last one.
const FIRST: usize = 50_000;

#[test]
fn every_point_where_the_tool_can_be_lies_in_a_certified_set() {
    let worlds = worlds::all();
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(world) = worlds.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let explored = world.explore(FIRST);
                    assert!(explored.violation.is_none(), "{}: {:#?}", world.name, explored.violation);
                }
            });
        }
    });
}

/// Names of worlds that the second model explores in seconds.
const QUICK: [&str; 8] = [
    "heights: rise, cross, lower",
    "heights: lines and answers are lost",
    "heights: contour with a plunge, lines lost",
    "a line is refused",
    "targets at the threshold",
    "contour, lines twice",
    "contour, held by somebody, and a piece lost",
    "contour through the part",
];

#[test]
fn second_model_of_the_controller_keeps_the_invariant() {
    let all = worlds::all();
    for name in QUICK {
        let world = all.iter().find(|world| world.name == name).unwrap();
        let explored = world.explore_with::<SecondController>(worlds::STATES);
        assert!(explored.violation.is_none(), "{name}: {:#?}", explored.violation);
        assert!(explored.complete, "{name}: the limit of states was reached");
    }
}

/// A duplicate that is read and not yet planned is in no buffer. Two reports at rest released its target before the
/// guard waited for the end of parsing.
#[test]
fn duplicate_that_is_being_parsed_stays_in_the_set() {
    let all = worlds::all();
    let explore = |name: &str, states: usize| {
        let world = all.iter().find(|world| world.name == name).unwrap();
        let explored = world.explore_with::<SecondController>(states);
        assert!(explored.violation.is_none(), "{name}: {:#?}", explored.violation);
        explored
    };
    assert!(explore("a line comes twice, and once is refused", worlds::STATES).complete);
    // A duplicate whose motion was cancelled. The violation was state 266,100.
    explore("lines and answers come twice", 300_000);
}

/// Assumptions exclude these pairs of faults. Each shows the reason, and the first model shows it for
/// most of them.
#[test]
fn excluded_pairs_of_faults_defeat_the_evidence() {
    let mut only_second = Vec::new();
    for world in worlds::pairs::excluded() {
        let explored = world.explore_with::<SecondController>(worlds::STATES);
        assert!(explored.violation.is_some(), "{}: {} states", world.name, explored.states);
        if world.explore(worlds::STATES).violation.is_none() {
            only_second.push(world.name);
        }
    }
    assert_eq!(only_second, ["pair: a copy and a reset", "pair: a copy and a clock jump"]);
}

//! The supervisor's invariant, explored in every world.
#![cfg(feature = "guard")]

use keepout_proofs::worlds;

/// The most states of one world.
const STATES: usize = 1_500_000;

#[test]
fn every_point_where_the_tool_can_be_lies_in_a_certified_set() {
    for world in worlds::all() {
        let explored = world.explore(STATES);
        println!("{}: {} states, {} steps, depth {}", world.name, explored.states, explored.steps, explored.depth);
        assert!(explored.violation.is_none(), "{}: {:#?}", world.name, explored.violation);
        assert!(explored.complete, "{}: not all states were seen", world.name);
    }
}

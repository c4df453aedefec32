//! The guard's invariant, explored in every world.
#![cfg(feature = "guard")]

use std::sync::atomic::{AtomicUsize, Ordering};

use keepout_proofs::worlds;

#[test]
fn every_point_where_the_tool_can_be_lies_in_a_certified_set() {
    let worlds = worlds::all();
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(world) = worlds.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let explored = world.explore(worlds::STATES);
                    assert!(explored.violation.is_none(), "{}: {:#?}", world.name, explored.violation);
                    assert!(explored.complete, "{}: the limit of states was reached", world.name);
                }
            });
        }
    });
}

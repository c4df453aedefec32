//! The supervisor's invariant, explored in every world.
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
                    assert!(explored.complete, "{}: not all states were seen", world.name);
                }
            });
        }
    });
}

/// Each part of the guard that is taken out is noticed in some world.
#[cfg(feature = "mutations")]
#[test]
fn every_part_of_the_guard_is_needed() {
    use keepout_guard::Mutation;
    let worlds = worlds::all();
    for mutation in Mutation::ALL {
        // All worlds a little way first.
        let noticed = [4_000, 40_000, 400_000].into_iter().any(|states| {
            let notices = |world: &keepout_proofs::invariant::World| {
                world.explore_with(states, |guard| guard.mutate(mutation)).violation.is_some()
            };
            worlds.iter().any(notices)
        });
        assert!(noticed, "nobody notices {mutation:?}");
    }
}

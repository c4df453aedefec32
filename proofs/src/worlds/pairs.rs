//! Worlds that combine two kinds of faults, each with each.

use super::{JOGS, NORTH, QUIET, WEST};
use crate::controller::Trouble;
use crate::invariant::World;

/// Two jogs over the pairs of faults that the guard withstands. A loss with a copy is one of them within these bounds,
/// although assumption A-06 excludes it.
pub(super) fn all() -> Vec<World> {
    WITHSTOOD.iter().map(world).collect()
}

/// The same over the other pairs, which assumptions exclude. Each of them defeats the evidence with the
/// second model of the controller.
#[must_use]
pub fn excluded() -> Vec<World> {
    EXCLUDED.iter().map(world).collect()
}

/// Whether the world combines two kinds of faults for the sake of their combination.
#[must_use]
pub fn is_pair(world: &World) -> bool {
    WITHSTOOD.iter().any(|(name, _)| *name == world.name)
}

/// The pairs that the assumptions exclude, in words.
#[must_use]
pub fn exclusions() -> String {
    let names: Vec<&str> = EXCLUDED.iter().filter_map(|(name, _)| name.strip_prefix("pair: ")).collect();
    names.join(", ")
}

/// After a rejection the guard waits, so time passes.
fn world(&(name, trouble): &(&'static str, Trouble)) -> World {
    World { name, budget: [2, 3, 1, trouble.refused], trouble, targets: &[WEST, NORTH], ..JOGS }
}

// Evidence for SR-08, SR-10.
const WITHSTOOD: &[(&str, Trouble)] = &[
    ("pair: a loss and a copy", Trouble { lost: 1, doubled: 1, ..QUIET }),
    ("pair: a loss and a swap", Trouble { lost: 1, swapped: 1, ..QUIET }),
    ("pair: a loss and an old report", Trouble { lost: 1, lies: 1, ..QUIET }),
    ("pair: a loss and a rejection", Trouble { lost: 1, refused: 1, ..QUIET }),
    ("pair: a loss and a reset", Trouble { lost: 1, resets: 1, ..QUIET }),
    ("pair: a loss and a hold", Trouble { lost: 1, holds: 1, ..QUIET }),
    ("pair: a loss and a clock jump", Trouble { lost: 1, jumps: 1, ..QUIET }),
    ("pair: a copy and a rejection", Trouble { doubled: 1, refused: 1, ..QUIET }),
    ("pair: a copy and a hold", Trouble { doubled: 1, holds: 1, ..QUIET }),
    ("pair: a swap and a rejection", Trouble { swapped: 1, refused: 1, ..QUIET }),
    ("pair: a swap and a reset", Trouble { swapped: 1, resets: 1, ..QUIET }),
    ("pair: a swap and a hold", Trouble { swapped: 1, holds: 1, ..QUIET }),
    ("pair: a swap and a clock jump", Trouble { swapped: 1, jumps: 1, ..QUIET }),
    ("pair: an old report and a rejection", Trouble { lies: 1, refused: 1, ..QUIET }),
    ("pair: an old report and a reset", Trouble { lies: 1, resets: 1, ..QUIET }),
    ("pair: an old report and a hold", Trouble { lies: 1, holds: 1, ..QUIET }),
    ("pair: an old report and a clock jump", Trouble { lies: 1, jumps: 1, ..QUIET }),
    ("pair: a rejection and a reset", Trouble { refused: 1, resets: 1, ..QUIET }),
    ("pair: a rejection and a hold", Trouble { refused: 1, holds: 1, ..QUIET }),
    ("pair: a rejection and a clock jump", Trouble { refused: 1, jumps: 1, ..QUIET }),
    ("pair: a reset and a hold", Trouble { resets: 1, holds: 1, ..QUIET }),
    ("pair: a reset and a clock jump", Trouble { resets: 1, jumps: 1, ..QUIET }),
    ("pair: a hold and a clock jump", Trouble { holds: 1, jumps: 1, ..QUIET }),
];

const EXCLUDED: &[(&str, Trouble)] = &[
    ("pair: a copy and a swap", Trouble { doubled: 1, swapped: 1, ..QUIET }),
    ("pair: a copy and an old report", Trouble { doubled: 1, lies: 1, ..QUIET }),
    ("pair: a swap and an old report", Trouble { swapped: 1, lies: 1, ..QUIET }),
    ("pair: a copy and a reset", Trouble { doubled: 1, resets: 1, ..QUIET }),
    ("pair: a copy and a clock jump", Trouble { doubled: 1, jumps: 1, ..QUIET }),
];

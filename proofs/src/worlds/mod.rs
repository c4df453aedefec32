//! The worlds that the exploration visits, with their bounds.

mod heights;
pub mod pairs;

use crate::controller::{MotionModel, Trouble};
use crate::invariant::World;
use crate::properties::Xyz;

/// Largest number of explored states per world. Every world has fewer, so its exploration is complete.
pub const STATES: usize = 4_000_000;

/// Points south, west and north of the part. A straight motion between two neighbours is clear. From south
/// to north it is not.
const SOUTH: Xyz = (200, -600, 0);
const WEST: Xyz = (-600, 200, 0);
const NORTH: Xyz = (200, 1000, 0);
/// Targets from the south. A cancel is clear on the way to the first two, and not on the way to the third.
const BESIDE: &[Xyz] = &[(-600, -600, 0), (900, -700, 0), (-160, 200, 0)];
/// Halfway from south to west, so that motions lead back over each other.
const MIDDLE: Xyz = (-200, -200, 0);
/// Inside the jogging clearance, by less than the margin.
const NEAR: Xyz = (-97, 200, 0);
/// The nearest point outside the jogging clearance.
const CLEAR: Xyz = (-101, 200, 0);
/// Targets that lead out and back.
const BACK: &[Xyz] = &[WEST, MIDDLE];
const ACROSS: &[Xyz] = &[SOUTH, WEST, NORTH];
const AROUND: &[Xyz] = &[SOUTH, WEST, NORTH, MIDDLE];

const STRAIGHT: MotionModel = MotionModel {
    apart: false,
    flushes: false,
    cancels: true,
    strays: false,
    errs: false,
    halves: 1,
    climbs: false,
};
const ERRING: MotionModel = MotionModel { errs: true, ..STRAIGHT };
const QUIET: Trouble =
    Trouble { lost: 0, doubled: 0, swapped: 0, lies: 0, refused: 0, resets: 0, holds: 0, jumps: 0 };

/// A world of jogs around the part.
const JOGS: World = World {
    // Evidence for SR-07, SR-08.
    name: "delays and cancels",
    start: SOUTH,
    targets: AROUND,
    rises: &[],
    contour: &[],
    budget: [3, 3, 1, 0],
    open: 2,
    trouble: QUIET,
    drive: STRAIGHT,
    checked: false,
    simplified_by: 0,
};

/// A contour along the part. A tool that skips one of its corners cuts through the part.
const CONTOUR: World = World {
    // Evidence for SR-12.
    name: "contour",
    start: (-108, -108, 0),
    targets: &[],
    rises: &[],
    contour: &[(-108, -108, 0), (-108, 508, 0), (508, 508, 0), (600, 508, 0)],
    budget: [1, 3, 0, 0],
    open: 2,
    trouble: QUIET,
    drive: MotionModel { cancels: false, ..STRAIGHT },
    checked: false,
    simplified_by: 0,
};

/// All worlds.
#[must_use]
pub fn all() -> Vec<World> {
    [heights::all(), lines(), times(), machines(), errors(), contours(), pairs::all()].concat()
}

fn with(name: &'static str, budget: [u8; 4], trouble: Trouble) -> World {
    World { name, budget, trouble, ..JOGS }
}

/// Worlds with jogs over an impaired link.
fn lines() -> Vec<World> {
    vec![
        JOGS,
        // Evidence for SR-07, SR-08, SR-10.
        with("lines and answers are lost", [2, 3, 1, 0], Trouble { lost: 1, ..QUIET }),
        with("lines and answers change places", [2, 3, 1, 0], Trouble { swapped: 1, ..QUIET }),
        World {
            targets: ACROSS,
            ..with("lines and answers come twice", [2, 3, 1, 1], Trouble { doubled: 1, ..QUIET })
        },
        World {
            targets: ACROSS,
            ..with("lines and answers come many times", [4, 1, 0, 0], Trouble { doubled: 3, ..QUIET })
        },
        World {
            targets: ACROSS,
            ..with("three lines, and one is lost", [3, 2, 1, 1], Trouble { lost: 1, ..QUIET })
        },
        with("an old report in place of one", [2, 4, 0, 0], Trouble { lies: 1, ..QUIET }),
        with("a reset that nobody hears of", [2, 3, 1, 0], Trouble { resets: 1, ..QUIET }),
        World { targets: ACROSS, ..with("a line is refused", [3, 3, 0, 1], Trouble { refused: 1, ..QUIET }) },
        World {
            targets: &[WEST, NORTH],
            ..with(
                "a line comes twice, and once is refused",
                [2, 3, 0, 1],
                Trouble { refused: 1, doubled: 1, ..QUIET },
            )
        },
    ]
}

/// Worlds in which time passes or the clock jumps.
fn times() -> Vec<World> {
    vec![
        World { targets: BACK, open: 1, ..with("targets leave the set: time passes", [2, 4, 0, 2], QUIET) },
        World {
            targets: BACK,
            checked: true,
            ..with("targets leave the set, with a checksum", [2, 3, 0, 2], QUIET)
        },
        World { targets: &[WEST, NORTH, MIDDLE], ..with("time and cancels", [2, 4, 1, 2], QUIET) },
        World {
            targets: &[(-600, -600, 0), WEST],
            checked: true,
            ..with("a clock that jumps, no motion leading back", [2, 3, 0, 0], Trouble { jumps: 1, ..QUIET })
        },
        // The clock jumps by `DRAIN` while a motion that has left the planner still runs. The next motion
        // leads back over it.
        World {
            targets: &[MIDDLE, WEST],
            ..with("a clock that jumps", [2, 5, 0, 0], Trouble { jumps: 1, ..QUIET })
        },
        World {
            targets: &[SOUTH, WEST],
            checked: true,
            ..with("a clock that jumps, with a checksum", [2, 3, 0, 0], Trouble { jumps: 1, ..QUIET })
        },
    ]
}

/// Worlds with other machines, start positions and targets.
fn machines() -> Vec<World> {
    let flushing = MotionModel { flushes: true, ..STRAIGHT };
    vec![
        World { drive: flushing, ..with("cancels that flush", [2, 3, 2, 1], QUIET) },
        World {
            drive: flushing,
            targets: ACROSS,
            ..with("cancels that flush, three lines", [3, 2, 1, 1], QUIET)
        },
        World {
            drive: MotionModel { halves: 2, ..STRAIGHT },
            ..with("cancels in more places", [3, 2, 1, 1], QUIET)
        },
        World {
            drive: MotionModel { apart: true, ..STRAIGHT },
            targets: &[SOUTH, (-600, -600, 0), WEST, (-600, 1000, 0)],
            ..with("axes that run apart", [3, 4, 1, 0], QUIET)
        },
        World {
            // Evidence for SR-11.
            drive: MotionModel { strays: true, ..STRAIGHT },
            targets: BESIDE,
            ..with("cancels that leave the path", [2, 4, 1, 1], QUIET)
        },
        World {
            drive: MotionModel { strays: true, errs: true, ..STRAIGHT },
            targets: BESIDE,
            ..with("cancels that leave the path, reports that err", [1, 3, 1, 1], QUIET)
        },
        World {
            drive: MotionModel { strays: true, flushes: true, ..STRAIGHT },
            targets: BESIDE,
            ..with(
                "cancels that leave the path and flush, a line lost",
                [2, 3, 1, 1],
                Trouble { lost: 1, ..QUIET },
            )
        },
        World {
            drive: MotionModel { strays: true, apart: true, ..STRAIGHT },
            targets: BESIDE,
            ..with("cancels that leave the box", [2, 3, 1, 1], QUIET)
        },
        // Evidence for SR-07.
        World { targets: &[NEAR, CLEAR, WEST], ..with("targets at the threshold", [2, 3, 1, 1], QUIET) },
        World {
            start: (-60, 200, 0),
            targets: &[(-300, 200, 0), (-60, 600, 0), (-97, -40, 0), WEST],
            // Evidence for SR-14.
            ..with("retract moves", [2, 4, 1, 1], QUIET)
        },
        // At this start only the simplified outline is too near.
        World {
            start: (-104, 200, 0),
            simplified_by: 8,
            targets: &[(-108, 200, 0), (-109, 200, 0), (-104, 600, 0), WEST],
            ..with("retract moves from a simplified outline", [2, 4, 1, 1], QUIET)
        },
    ]
}

/// Worlds in which reports have errors of up to the resolution.
fn errors() -> Vec<World> {
    let erring = |name, targets, budget| World { drive: ERRING, targets, ..with(name, budget, QUIET) };
    vec![
        // Evidence for SR-07, SR-09.
        erring("reports that err", ACROSS, [2, 3, 1, 0]),
        World { checked: true, ..erring("reports that err, with a checksum", &[WEST, NORTH], [2, 3, 0, 0]) },
        World { open: 1, ..erring("reports that err, and time passes", BACK, [2, 3, 0, 2]) },
        erring("reports that err, at the threshold", &[NEAR, CLEAR, WEST], [2, 3, 1, 1]),
    ]
}

/// Worlds in which the host cuts a contour.
fn contours() -> Vec<World> {
    vec![
        CONTOUR,
        // Evidence for SR-12.
        World { name: "contour, lines lost", trouble: Trouble { lost: 1, ..QUIET }, ..CONTOUR },
        World { name: "contour, lines twice", trouble: Trouble { doubled: 1, ..QUIET }, ..CONTOUR },
        World { name: "contour, held by somebody", trouble: Trouble { holds: 2, ..QUIET }, ..CONTOUR },
        World {
            name: "contour, held by somebody, and a piece lost",
            trouble: Trouble { holds: 1, lost: 1, ..QUIET },
            ..CONTOUR
        },
        World {
            name: "contour, reports that err",
            drive: MotionModel { errs: true, ..CONTOUR.drive },
            ..CONTOUR
        },
        World {
            name: "contour through the part",
            contour: &[(-108, -108, 0), (508, 508, 0), (600, 508, 0)],
            ..CONTOUR
        },
    ]
}

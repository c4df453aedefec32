//! Worlds with a third axis: a plate with a top, a clamp and a table.

use super::{CONTOUR, JOGS, QUIET, STRAIGHT};
use crate::controller::{MotionModel, Trouble};
use crate::invariant::World;
use crate::properties::Xyz;
use crate::square::{CLAMP_TOP, HEIGHT_MARGIN, TABLE};

/// Beside the plate and below its top, above that place, above the plate, and just above it.
const DEEP: Xyz = (200, -600, -100);
const RISEN: Xyz = (200, -600, 50);
const OVER: Xyz = (200, 200, 50);
const LOW: Xyz = (200, 200, HEIGHT_MARGIN);
/// On the plate, a unit below what the height margin permits.
const TOO_LOW: Xyz = (200, 200, HEIGHT_MARGIN - 1);
/// Above the clamp and beside it, just above the table, and a unit lower.
const OVER_CLAMP: Xyz = (1000, 100, CLAMP_TOP + HEIGHT_MARGIN);
const INTO_CLAMP: Xyz = (1000, 100, 50);
const ON_TABLE: Xyz = (-600, 200, TABLE + HEIGHT_MARGIN);
const IN_TABLE: Xyz = (-600, 200, TABLE + HEIGHT_MARGIN - 1);

const CLIMBING: MotionModel = MotionModel { climbs: true, ..STRAIGHT };

/// All of these worlds.
pub(super) fn all() -> Vec<World> {
    [impaired(), places(), errors(), contours()].concat()
}

/// A world that begins beside the plate, below its top.
fn jogs(name: &'static str, targets: &'static [Xyz], budget: [u8; 4], trouble: Trouble) -> World {
    World { name, start: DEEP, rises: &[50], targets, budget, trouble, drive: CLIMBING, ..JOGS }
}

/// Worlds with an impaired link, with cancels and with time.
fn impaired() -> Vec<World> {
    let over: &[Xyz] = &[OVER, LOW, TOO_LOW];
    vec![
        // Evidence for SR-08, SR-13.
        jogs("heights: rise, cross, lower", over, [3, 4, 0, 0], QUIET),
        jogs("heights: cancels", &[OVER, RISEN, DEEP], [3, 3, 1, 1], QUIET),
        jogs("heights: lines and answers are lost", over, [2, 4, 0, 0], Trouble { lost: 1, ..QUIET }),
        jogs("heights: lines and answers come twice", over, [2, 3, 1, 1], Trouble { doubled: 1, ..QUIET }),
        jogs("heights: lines and answers change places", over, [2, 4, 0, 0], Trouble { swapped: 1, ..QUIET }),
        jogs(
            "heights: an old report in place of one",
            &[OVER, DEEP],
            [2, 4, 0, 0],
            Trouble { lies: 1, ..QUIET },
        ),
        jogs("heights: a reset that nobody hears of", over, [2, 4, 0, 0], Trouble { resets: 1, ..QUIET }),
        World { open: 1, ..jogs("heights: time passes", &[OVER, DEEP], [3, 4, 0, 2], QUIET) },
        World { checked: true, ..jogs("heights: with a checksum", over, [3, 3, 1, 0], QUIET) },
    ]
}

/// Worlds with other places: the clamp, the table, inside the jogging clearance, axes that run apart.
fn places() -> Vec<World> {
    vec![
        World {
            start: OVER,
            rises: &[CLAMP_TOP + HEIGHT_MARGIN],
            ..jogs("heights: the clamp", &[OVER_CLAMP, INTO_CLAMP, RISEN], [3, 4, 0, 0], QUIET)
        },
        World {
            start: (-600, 200, 50),
            ..jogs("heights: the table", &[ON_TABLE, IN_TABLE, OVER], [3, 3, 1, 1], QUIET)
        },
        World {
            drive: MotionModel { apart: true, ..CLIMBING },
            ..jogs("heights: axes that run apart", &[OVER, DEEP, (-600, -600, -100)], [3, 4, 0, 0], QUIET)
        },
    ]
}

/// Worlds in which reports have errors, or cancels leave the path.
fn errors() -> Vec<World> {
    vec![
        World {
            drive: MotionModel { errs: true, ..CLIMBING },
            ..jogs("heights: reports that err", &[OVER, LOW], [2, 4, 0, 0], QUIET)
        },
        World {
            drive: MotionModel { errs: true, ..CLIMBING },
            checked: true,
            ..jogs("heights: reports that err, with a checksum", &[OVER, LOW], [2, 3, 0, 0], QUIET)
        },
        World {
            drive: MotionModel { strays: true, ..CLIMBING },
            start: (-600, -600, 400),
            ..jogs(
                // Evidence for SR-11, SR-13.
                "heights: cancels that leave the path",
                &[(-600, 900, 400), (-600, 900, 100)],
                [2, 3, 1, 1],
                QUIET,
            )
        },
        World {
            start: (-60, 200, -100),
            ..jogs(
                // Evidence for SR-13, SR-14.
                "heights: retract moves aside and up",
                &[(-300, 200, -100), (-60, 600, -100), OVER],
                [3, 4, 0, 0],
                QUIET,
            )
        },
    ]
}

/// A contour that plunges beside the plate, and rises at its end.
const PLUNGE: &[Xyz] =
    &[(-108, -108, 50), (-108, -108, -100), (-108, 508, -100), (-108, 508, 50), (200, 200, 50)];

/// Worlds in which the host cuts a contour.
fn contours() -> Vec<World> {
    vec![
        World {
            // Evidence for SR-12, SR-13.
            name: "heights: contour with a plunge",
            start: (-108, -108, 50),
            contour: PLUNGE,
            drive: MotionModel { cancels: false, ..CLIMBING },
            ..CONTOUR
        },
        World {
            name: "heights: contour with a plunge, lines lost",
            start: (-108, -108, 50),
            contour: PLUNGE,
            drive: MotionModel { cancels: false, ..CLIMBING },
            trouble: Trouble { lost: 1, ..QUIET },
            ..CONTOUR
        },
        World {
            name: "heights: a ramp through the plate",
            start: (-600, 200, 50),
            contour: &[(-600, 200, 50), (200, 200, -10), (200, 200, 50)],
            drive: MotionModel { cancels: false, ..CLIMBING },
            ..CONTOUR
        },
    ]
}

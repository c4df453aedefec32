//! Levels: the part as a height field.

use alloc::vec;

use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::{Height, HeightField, Levels, Region, Ring};

use crate::lattice::{at, height};
use crate::{Cases, harnesses};

harnesses! {
    "kernel/src/levels.rs" {
        levels_hold_what_stands_above_the_tip:
            "a square of height zero is prohibited exactly for tips below height zero", "every height", unwind 24;
        the_table_is_prohibited_below_its_height:
            "below the table every point is prohibited, and above it those of the part alone", "every height",
            unwind 24;
        levels_grow_as_the_tip_falls:
            "what is prohibited at a height is prohibited at every lower height", "every pair of heights",
            unwind 24;
    }
}

const TABLE: i32 = -500;

fn plate() -> Levels {
    let ring = Ring::new(vec![at(-4, -4), at(4, -4), at(4, 4), at(-4, 4)]).expect("a square is a ring");
    let field = HeightField {
        outlines: Region::new(vec![ring]).expect("one ring is a region"),
        tops: vec![Some(Height::ZERO)],
        around: None,
        zones: vec![],
        floor: Some(height(TABLE)),
    };
    Levels::new(&field).expect("two heights are two levels")
}

fn levels_hold_what_stands_above_the_tip(c: &mut impl Cases) {
    let tip = c.int(-COORD_MAX, COORD_MAX);
    assert!(plate().at(height(tip)).holds(at(0, 0)) == (tip < 0));
}

fn the_table_is_prohibited_below_its_height(c: &mut impl Cases) {
    let tip = c.int(-COORD_MAX, COORD_MAX);
    assert!(plate().at(height(tip)).holds(at(9, 0)) == (tip < TABLE));
}

fn levels_grow_as_the_tip_falls(c: &mut impl Cases) {
    let (one, other) = (c.int(-COORD_MAX, COORD_MAX), c.int(-COORD_MAX, COORD_MAX));
    let plate = plate();
    let level = |tip| plate.at(height(tip)).level();
    assert!(one < other || level(one) <= level(other));
}

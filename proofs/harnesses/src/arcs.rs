//! Arcs, their chords, and curves.

use alloc::vec;

use keepout_kernel::exact::arc::ArcChords;
use keepout_kernel::exact::bezier::{Bezier, WEIGHTS};
use keepout_kernel::{Arc, Turn};

use crate::lattice::at;
use crate::{Cases, harnesses};

harnesses! {
    // Evidence for SR-02.
    "kernel/src/exact/arc.rs" {
        arcs_end_on_their_circle:
            "an arc of radius 64 ends at most 1 unit inside and 2 units outside of its circle",
            "centre at the origin, the end on the y axis", unwind 40;
        arcs_have_a_least_radius:
            "an arc has a radius of at least 64 units", "radii of 63 to 65 units", unwind 40;
        arcs_need_two_ends:
            "an arc does not end where it begins", "a circle of radius 64, the end within ±2 of the start", unwind 40;
        chords_begin_and_end_with_the_arc:
            "a chain of chords is accepted only when it begins and ends with the arc",
            "a quarter circle of radius 64, both ends of the chain moved by up to 1 unit", unwind 40;
        chords_have_their_corners_on_the_circle:
            "a corner of an accepted chain lies at most 2 units inside and 3 outside of the circle",
            "a quarter circle of radius 100, the corner along its bisector", unwind 40;
    }
    "kernel/src/exact/bezier.rs" {
        weights_are_in_their_range:
            "a weight of a curve is within its range", "every weight of 64 bits", unwind 20;
    }
}

fn arcs_end_on_their_circle(c: &mut impl Cases) {
    let y = c.int(-70, 70);
    let arc = Arc::new(at(64, 0), at(0, y), at(0, 0), Turn::CounterClockwise);
    assert!(arc.is_ok() == (63..=66).contains(&y.abs()));
}

fn arcs_have_a_least_radius(c: &mut impl Cases) {
    let x = c.int(63, 65);
    let arc = Arc::new(at(x, 0), at(0, x), at(0, 0), Turn::CounterClockwise);
    assert!(arc.is_ok() == (x >= 64));
}

fn arcs_need_two_ends(c: &mut impl Cases) {
    let (x, y) = (c.int(62, 66), c.int(-2, 2));
    let arc = Arc::new(at(64, 0), at(x, y), at(0, 0), Turn::Clockwise);
    assert!(arc.is_err() || (x, y) != (64, 0));
}

fn chords_begin_and_end_with_the_arc(c: &mut impl Cases) {
    let arc = Arc::new(at(64, 0), at(0, 64), at(0, 0), Turn::CounterClockwise).expect("a quarter circle");
    let (dx, dy) = (c.int(-1, 1), c.int(-1, 1));
    let chain = vec![at(64 + dx, 0), at(45, 45), at(0, 64 + dy)];
    assert!(ArcChords::check(&arc, chain).is_ok() == (dx == 0 && dy == 0));
}

fn chords_have_their_corners_on_the_circle(c: &mut impl Cases) {
    let arc = Arc::new(at(100, 0), at(0, 100), at(0, 0), Turn::CounterClockwise).expect("a quarter circle");
    let along = c.int(60, 80);
    let accepted = ArcChords::check(&arc, vec![at(100, 0), at(along, along), at(0, 100)]).is_ok();
    // 2 · along² lies between 98² and 103² exactly from 70 to 72.
    assert!(accepted == (70..=72).contains(&along));
}

fn weights_are_in_their_range(c: &mut impl Cases) {
    let weight = c.wide().cast_unsigned();
    let curve = Bezier::new(vec![at(0, 0), at(8, 0)], vec![WEIGHTS.0, weight]);
    assert!(curve.is_ok() == (WEIGHTS.0..=WEIGHTS.1).contains(&weight));
}

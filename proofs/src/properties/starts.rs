//! The guard: where a tool may start, and how many lines may be in flight.

use std::sync::Arc;

use keepout_guard::{Guard, Interpolation, Refusal, Time};
use keepout_kernel::Point;

use super::guard::feedback;
use crate::families::at;
use crate::property::properties;
use crate::square::{self, MANUAL};

properties! {
    "guard: starts", "executor/guard/src/lib.rs";
    // Evidence for SR-14.
    starts_beside_the_simplified_outline_are_inside |d|
        starts_beside_the_simplified_outline_are_inside(d.int(0, 60), d.int(-200, -1), d.int(0, 400))
        => "a tool that rests beside the part is inside the jogging clearance exactly when the part or its simplified \
            outline is within that distance; from there no jog is admitted, and a retract move is";
        random 20_000;
    // Evidence for SR-07.
    no_thirteenth_line_goes_out |d| no_thirteenth_line_goes_out(d.int(4, 200))
        => "while twelve lines are in flight, no other is admitted";
        random 1_000;
}

/// A square whose simplified outline is larger by `simplified_by` on each side.
fn beside(simplified_by: i64) -> Guard {
    let rules = square::rules(Interpolation::Linear, true);
    Guard::new(Arc::new(square::square(0)), Arc::new(square::square(simplified_by)), rules)
}

fn starts_beside_the_simplified_outline_are_inside(simplified_by: i64, x: i64, y: i64) {
    let mut guard = beside(simplified_by);
    guard.locate(at((x, y)).in_plane()).expect("it is beside the part");
    let inside = -x <= MANUAL + simplified_by;
    assert_eq!(guard.is_inside_jogging_clearance(), inside, "{simplified_by} {x} {y}");
    let away = at((x - 300, y)).in_plane();
    assert_eq!(guard.admissions().admit(away).is_ok(), !inside, "{simplified_by} {x} {y}");
    assert_eq!(guard.admissions().admit_retract(away).is_ok(), inside, "{simplified_by} {x} {y}");
}

/// Jogs along a line. The controller acknowledges and reads each, and has executed none.
fn no_thirteenth_line_goes_out(step: i64) {
    let mut guard = beside(0);
    let place = |k: i64| -> Point { at((-4000 + k * step, 0)) };
    guard.locate(place(0).in_plane()).expect("it is beside the part");
    for (k, queued) in (1..=12).zip(1..) {
        guard.jog(place(k).in_plane(), 600).expect("fewer than twelve are in flight");
        guard.acknowledged().expect("one line");
        let stamp = guard.stamp(Time::ZERO);
        guard.reported(&feedback(place(0), false, queued), stamp, Time::ZERO).expect("it has not moved");
    }
    assert_eq!(guard.jog(place(13).in_plane(), 600).map(drop), Err(Refusal::Full), "{step}");
}

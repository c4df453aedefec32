//! Defects below the joining tolerance are repaired and listed, as gaps are.

use crate::dxf::{PlainXy, SmallDrawing};
use crate::{inspected, plan};

const PLATE: [PlainXy; 4] = [(0.0, 0.0), (60.0, 0.0), (60.0, 30.0), (0.0, 30.0)];

/// Checks that the drawing is a plate of 60 × 30 mm after one listed repair at most.
fn is_plate(sketch: &SmallDrawing, repair: &str) {
    let found = inspected(sketch);
    assert!(found.problems.is_empty(), "{:?}", found.problems);
    assert!(found.repairs.iter().any(|note| note.text.contains(repair)), "{:?}", found.repairs);
    let plan = plan(sketch, 3.0).unwrap();
    assert_eq!(plan.contours().len(), 1);
    assert!((plan.enclosed_mm2() - 1800.0).abs() < 0.5, "{}", plan.enclosed_mm2());
}

fn with_corners(more: &[PlainXy]) -> SmallDrawing {
    SmallDrawing::mm().loop_on("0", "", &[&PLATE[..], more].concat())
}

#[test]
fn closing_segment_that_runs_back_is_removed() {
    is_plate(&with_corners(&[(0.0, -0.0006)]), "crossing of 0.00120 mm removed");
    is_plate(&with_corners(&[(0.0006, -0.0003)]), "crossing of 0.00157 mm removed");
}

/// Two sides of a needle cross halfway. Found by the fuzzer: the needle beyond the crossing was removed, however
/// long, where its end was short.
#[test]
fn needle_beyond_a_crossing_is_removed_only_if_it_is_short() {
    let needle = |length: f64| {
        let top = 30.0 + length;
        let corners = [(30.001, 30.0), (29.999, top), (30.001, top), (29.999, 30.0), (0.0, 30.0)];
        SmallDrawing::mm().loop_on("0", "", &[&PLATE[..3], &corners].concat())
    };
    is_plate(&needle(0.01), "crossing of");
    let found = inspected(&needle(15.0));
    assert!(found.repairs.is_empty(), "{:?}", found.repairs);
    assert!(plan(&needle(15.0), 3.0).is_err(), "7.5 mm of the needle would be missing");
}

#[test]
fn small_loop_in_a_side_is_removed() {
    let corners = [
        (0.0, 0.0),
        (60.0, 0.0),
        (60.0, 30.0),
        (30.0, 30.0),
        (30.001, 30.0005),
        (30.0005, 29.9995),
        (0.0, 30.0),
    ];
    is_plate(&SmallDrawing::mm().loop_on("0", "", &corners), "removed at (30.00");
}

#[test]
fn overshoots_at_corners_are_closed() {
    for over in [0.0001, 0.001, 0.005] {
        let found = inspected(&SmallDrawing::mm().lines(&PLATE, (over, over)));
        assert!(found.problems.is_empty() && found.contours.len() == 1, "{over}: {:?}", found.problems);
    }
}

#[test]
fn side_drawn_twice_one_micrometre_apart_is_dropped() {
    for (from, to) in
        [((0.0, 0.001), (60.0, 0.001)), ((10.0, 0.001), (40.0, 0.001)), ((0.0, -0.003), (60.0, -0.003))]
    {
        is_plate(&SmallDrawing::mm().lines(&PLATE, (0.0, 0.0)).line(from, to), "doubled curve of");
    }
}

/// A wall that is wider than the tolerance stays.
#[test]
fn line_beside_a_side_stays_a_problem() {
    let found = inspected(&SmallDrawing::mm().lines(&PLATE, (0.0, 0.0)).line((0.0, 0.05), (60.0, 0.05)));
    assert_eq!(found.problems.len(), 2);
}

#[test]
fn arc_of_radius_zero_is_left_out_and_counted() {
    for angles in [(0.0, 90.0), (30.0, 30.0)] {
        let found = inspected(&SmallDrawing::mm().lines(&PLATE, (0.0, 0.0)).arc((60.0, 30.0), 0.0, angles));
        assert!(found.problems.is_empty());
        assert_eq!(found.left_out.get("ARC without size"), Some(&1), "{:?}", found.left_out);
    }
}

/// Details of the drawing that are as small as the tolerance, and cross nothing, stay.
#[test]
fn small_steps_of_a_side_stay() {
    let corners = [(0.0, 0.0), (60.0, 0.0), (60.0, 30.0), (30.0, 30.0), (30.0, 30.005), (0.0, 30.005)];
    let found = inspected(&SmallDrawing::mm().loop_on("0", "", &corners));
    assert!(found.repairs.is_empty() && found.contours[0].lines == 6, "{:?}", found.repairs);
}

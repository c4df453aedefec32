//! The prohibited region of a square: free points, motions, simplified outlines, finishing toolpaths.

use alloc::vec;

use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, ProhibitedRegion, Region, Ring, Segment, Side};

use crate::lattice::{at, length};
use crate::{Cases, harnesses};

harnesses! {
    "kernel/src/clear.rs" {
        free_points_are_outside_and_clear:
            "a point is free exactly when it is farther than r from the square and outside of it",
            "a square of 8 units, points up to 12 units right of it and within ±3 along it, r up to 6", unwind 24;
        points_inside_are_not_free:
            "no point inside the square is free at any r", "points within the square, r up to 2", unwind 24;
        holding_is_the_side:
            "the region holds exactly the points of the square", "points within ±8 of the middle", unwind 24;
        motions_end_clear:
            "an accepted motion from a free point ends farther than r from the square",
            "from 12 units right of the square, targets on the same level, r up to 6", unwind 24;
        motions_do_not_pass_through:
            "no motion from the right of the square to the left of it on its level is accepted",
            "r up to 6, targets up to 12 units left of it", unwind 24;
        retract_moves_come_no_nearer:
            "an accepted retract move from a point near the square ends no nearer to it",
            "from 2 units right of the square, targets on the same level, thresholds up to 6", unwind 24;
    }
    "kernel/src/simplify.rs" {
        simplified_outlines_hold_the_part:
            "what is free of the simplified square is free of the square",
            "points up to 12 units right of it, r and tolerances up to 4", unwind 24;
    }
    "kernel/src/offset/certify.rs" {
        certified_lines_keep_their_distance:
            "a certified line beside the square keeps the threshold",
            "vertical lines up to 12 units right of it, thresholds up to 6", unwind 24;
        certified_paths_are_joined:
            "a path is certified only when each line begins where the one before it ends",
            "two lines far from the square, the joint off by up to 1 unit", unwind 24;
    }
}

/// A square of 8 units about the origin, machined from outside.
pub(crate) fn square() -> ProhibitedRegion {
    let ring = Ring::new(vec![at(-4, -4), at(4, -4), at(4, 4), at(-4, 4)]).expect("a square is a ring");
    let region = Region::new(vec![ring]).expect("one ring is a region");
    ProhibitedRegion::new(region, Side::Outside).expect("four edges have an index")
}

fn free_points_are_outside_and_clear(c: &mut impl Cases) {
    let (x, y, r) = (c.int(4, 16), c.int(-3, 3), c.int(0, 6));
    assert!(square().free_point(at(x, y), length(r)).is_ok() == (x - 4 > r));
}

fn points_inside_are_not_free(c: &mut impl Cases) {
    let p = at(c.int(-4, 4), c.int(-4, 4));
    assert!(square().free_point(p, length(c.int(0, 2))).is_err());
}

fn holding_is_the_side(c: &mut impl Cases) {
    let (x, y) = (c.int(-8, 8), c.int(-8, 8));
    assert!(square().holds(at(x, y)) == (x.abs() <= 4 && y.abs() <= 4));
}

fn motions_end_clear(c: &mut impl Cases) {
    let (x, r) = (c.int(-8, 20), c.int(0, 6));
    let part = square();
    let from = part.free_point(at(16, 0), length(r)).expect("12 units are more than 6");
    assert!(part.motion(from, at(x, 0)).is_ok() == (x - 4 > r));
}

fn motions_do_not_pass_through(c: &mut impl Cases) {
    let (x, r) = (c.int(-16, -4), c.int(0, 6));
    let part = square();
    let from = part.free_point(at(16, 0), length(r)).expect("12 units are more than 6");
    assert!(part.motion(from, at(x, 0)).is_err());
}

fn retract_moves_come_no_nearer(c: &mut impl Cases) {
    let (x, threshold) = (c.int(-16, 16), c.int(2, 6));
    let part = square();
    let from = part.free_point(at(6, 0), length(1)).expect("2 units are more than 1");
    assert!(part.retract(from, at(x, 0), length(threshold)).is_err() || x >= 6);
}

fn simplified_outlines_hold_the_part(c: &mut impl Cases) {
    let (x, r, tolerance) = (c.int(4, 16), c.int(0, 4), c.int(0, 4));
    let part = square();
    let simplified = part.simplified(length(tolerance)).expect("four edges have an index");
    let free = |part: &ProhibitedRegion| part.free_point(at(x, 0), length(r)).is_ok();
    assert!(!free(&simplified) || free(&part));
}

fn certified_lines_keep_their_distance(c: &mut impl Cases) {
    let (x, threshold) = (c.int(4, 16), c.int(0, 6));
    let line = Curve::Line(Segment { from: at(x, -2), to: at(x, 2) });
    assert!(certify_path(&square(), length(threshold), &[line]).is_err() || x - 4 > threshold);
}

fn certified_paths_are_joined(c: &mut impl Cases) {
    let (dx, dy) = (c.int(-1, 1), c.int(-1, 1));
    let far = 1000;
    let one = Curve::Line(Segment { from: at(far, 0), to: at(far, 9) });
    let other = Curve::Line(Segment { from: at(far + dx, 9 + dy), to: at(far, 20) });
    assert!(certify_path(&square(), length(1), &[one, other]).is_ok() == (dx == 0 && dy == 0));
}

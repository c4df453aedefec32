//! Rings, regions and polygons.

use alloc::vec;

use keepout_kernel::exact::region::Location;
use keepout_kernel::exact::segment::{Orientation, orientation};
use keepout_kernel::{Convex, Region, Ring};

use crate::lattice::{at, near_origin};
use crate::{Cases, harnesses};

harnesses! {
    // Evidence for SR-04.
    "kernel/src/exact/ring.rs" {
        insides_are_between_the_sides:
            "a point is inside a square exactly when it is strictly between its sides",
            "a square of 6 units, points within ±8", unwind 24;
    }
    "kernel/src/exact/region.rs" {
        holes_are_outside:
            "a point in the inner one of two squares is outside of the region",
            "squares of 12 and 4 units, points within ±2 of the middle", unwind 24;
    }
    // Evidence for SR-01.
    "kernel/src/exact/convex.rs" {
        convex_polygons_are_asked_at_every_side:
            "a quadrangle with a corner that turns right is no convex polygon",
            "three corners of a square of 4 units, the fourth within ±4", unwind 24;
    }
}

/// A square with its lower left corner there.
fn square(x: i32, y: i32, side: i32) -> Ring {
    let corners = vec![at(x, y), at(x + side, y), at(x + side, y + side), at(x, y + side)];
    Ring::new(corners).expect("a square is a ring")
}

fn insides_are_between_the_sides(c: &mut impl Cases) {
    let region = Region::new(vec![square(-3, -3, 6)]).expect("one ring is a region");
    let p = near_origin(c, 8);
    let (x, y) = (p.x.units().abs(), p.y.units().abs());
    let expected = match x.max(y) {
        0..=2 => Location::Inside,
        3 => Location::Boundary,
        _ => Location::Outside,
    };
    assert!(region.locate(p) == expected);
}

fn holes_are_outside(c: &mut impl Cases) {
    let rings = vec![square(-6, -6, 12), square(-2, -2, 4)];
    let region = Region::new(rings).expect("the squares do not touch");
    let p = near_origin(c, 2);
    let on_hole = p.x.units().abs().max(p.y.units().abs()) == 2;
    assert!(region.locate(p) == if on_hole { Location::Boundary } else { Location::Outside });
}

fn convex_polygons_are_asked_at_every_side(c: &mut impl Cases) {
    let p = near_origin(c, 4);
    let corners = [at(0, 0), at(4, 0), at(4, 4), p];
    let turns = |a, b, d| orientation(a, b, d) == Orientation::Right;
    let [a, b, d, _] = corners;
    let bent = turns(d, p, a) || turns(p, a, b) || turns(b, d, p);
    assert!(!bent || Convex::check(&corners).is_none());
}

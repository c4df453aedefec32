//! The prohibited region of a square: free points, motions, simplified outlines, finishing toolpaths.

use alloc::vec;

use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, ProhibitedRegion, Region, Ring, Segment, Side};

use crate::lattice::{at, length};
use crate::{Cases, harnesses};

harnesses! {
    // Evidence for SR-12.
    "kernel/src/offset/certify.rs" {
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

fn certified_paths_are_joined(c: &mut impl Cases) {
    let (dx, dy) = (c.int(-1, 1), c.int(-1, 1));
    let far = 1000;
    let one = Curve::Line(Segment { from: at(far, 0), to: at(far, 9) });
    let other = Curve::Line(Segment { from: at(far + dx, 9 + dy), to: at(far, 20) });
    assert!(certify_path(&square(), length(1), &[one, other]).is_ok() == (dx == 0 && dy == 0));
}

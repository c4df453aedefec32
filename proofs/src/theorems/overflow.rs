//! Proof that no operation overflows at the product's width.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::predicate::{
    ahead, beyond, box_point, box_segment, box_side, convex_holds, convex_segment, crosses_properly, on_ring,
    orientation, point_point, point_segment, ray_crosses, retract, sagitta, segment_segment, strictly_inside,
    triangle_segment,
};

use super::plane::V;
use crate::smt::explore::{Part, explore};
use crate::smt::prover::Prover;
use crate::smt::range::Ranges;
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic, operations};
use crate::smt::term::Term;

/// Largest magnitude of the corners that `box_side` takes.
const FAR: i128 = 1 << 31;

/// The theorem that no operation overflows.
pub const OVERFLOW: Theorem = Theorem {
    name: "no_overflow",
    source: "all of predicate.rs, at the width Product",
    claim: "with coordinates of at most 2^29 and lengths from 0 to 2^29, every difference fits i32, every \
            sum of products fits i64, and every product of areas fits i128",
    proof: |prover| prove(prover, COORD_MAX.into()),
};

/// Runs every predicate, and proves the range of every operation.
pub fn prove(prover: &mut Prover<'_>, limit: i128) {
    let _ = operations();
    let mut ranges = Ranges::default();
    let place = |ranges: &mut Ranges, most: i128| {
        let point = V::unknown("p");
        ranges.set(point.x, most);
        ranges.set(point.y, most);
        point.place()
    };
    let points: [_; 5] = std::array::from_fn(|_| place(&mut ranges, limit));
    let [a, b, c, d, e] = points;
    let [low, high] = std::array::from_fn(|_| place(&mut ranges, FAR));
    let r = Scalar(Term::fresh("r"));
    let length_2 = Term::fresh("L2");
    ranges.set(r.0, limit);
    // A squared distance of two points.
    ranges.set(length_2, 8 * limit * limit);
    let parts = [
        Part::PointSegment,
        Part::SegmentSegment,
        Part::CrossesProperly,
        Part::StrictlyInside,
        Part::BoxPoint,
        Part::Beyond,
        Part::ConvexHolds,
    ];
    let ordered = [(a.x.0, b.x.0), (a.y.0, b.y.0)];
    let mut count = 0;
    count += explore(&[], &[], || orientation::<Symbolic>(a, b, c)).len();
    count += explore(&[], &[], || point_point::<Symbolic>(a, b, r)).len();
    count += explore(&[], &[], || point_segment::<Symbolic>(a, b, c, r)).len();
    count += explore(&[], &[], || crosses_properly::<Symbolic>(a, b, c, d)).len();
    count += explore(&[], &[], || strictly_inside::<Symbolic>(a, b, c, d)).len();
    count += explore(&[], &[], || ray_crosses::<Symbolic>(a, b, c)).len();
    count += explore(&[], &[], || retract::<Symbolic>(a, b, c, d)).len();
    count += explore(&ordered, &[], || box_point::<Symbolic>(a, b, c, r)).len();
    count += explore(&[], &[], || beyond::<Symbolic>([a, b], [c, d].into_iter(), r)).len();
    count += explore(&[], &[], || convex_holds::<Symbolic>([a, b].into_iter(), c)).len();
    // The parts of these predicates take the same points, and were run above.
    count += explore(&[], &parts, || segment_segment::<Symbolic>([a, b], [c, d], r)).len();
    count += explore(&[], &parts, || triangle_segment::<Symbolic>([a, b, c], [d, e], r)).len();
    count += explore(&[], &parts, || convex_segment::<Symbolic>([a, b, c].into_iter(), [d, e], r)).len();
    count += explore(&ordered, &parts, || box_segment::<Symbolic>(a, b, c, d, r)).len();
    count += explore(&[], &[], || box_side::<Symbolic>(low, high, a, b)).len();
    for (inward, outward) in [(1, 2), (2, 3)] {
        count += explore(&[], &[], || on_ring::<Symbolic>(a, b, r, inward, outward)).len();
    }
    count += explore(&[], &[], || sagitta::<Symbolic>(length_2, r)).len();
    count += explore(&[], &[], || ahead::<Symbolic>(a, b, c, d, 4)).len();
    prover.ran(count);
    ranges.prove(prover, &operations());
}

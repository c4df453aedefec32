//! Point–segment.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::predicate::point_segment;

use super::plane::{V, share, to_segment, v};
use crate::smt::explore::explore;
use crate::smt::fact::{all, at_most, claim, less, not};
use crate::smt::prover::{Contract, at_least_zero, positive};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

const NAME: &str = "point_segment";

/// Clear: no point of the segment is within r.
pub const CLEAR: Contract<8, 0> = Contract {
    theorem: NAME,
    name: "clear: no point of the segment is within r",
    statement: |near, [px, py, ax, ay, bx, by, r, t], []| {
        let distance_2 = to_segment(v(px, py), v(ax, ay), v(bx, by), t).norm_2();
        claim([not(near), at_least_zero(r), share(t)], less(square(r), distance_2))
    },
};

/// Near: some point of the segment is within r.
pub const NEAR: Contract<7, 1> = Contract {
    theorem: NAME,
    name: "near: some point of the segment is within r",
    statement: |near, [px, py, ax, ay, bx, by, r], [t]| {
        let distance_2 = to_segment(v(px, py), v(ax, ay), v(bx, by), t).norm_2();
        claim([near, at_least_zero(r)], all([share(t), at_most(distance_2, square(r))]))
    },
};

/// Point–segment.
pub const POINT_SEGMENT: Theorem = Theorem {
    name: NAME,
    source: "predicate::point_segment",
    claim: "near exactly when there is t in [0, 1] with |p − a − t(b − a)| ≤ r, for r ≥ 0",
    proof: |prover| {
        let p = V::unknown("p");
        let a = p.other("a");
        let b = a.other("b");
        let [r, t] = ["r", "t"].map(Term::fresh);
        let paths = explore(&[], &[], || {
            !point_segment::<Symbolic>(p.place(), a.place(), b.place(), Scalar(r)).is_clear()
        });
        prover.contract(&CLEAR, &paths, [p.x, p.y, a.x, a.y, b.x, b.y, r, t], ([], &[]));
        // The nearest point: an end, or the foot of the perpendicular.
        let (along, length_2) = ((p - a).dot(b - a), (b - a).norm_2());
        let (before, past) = (at_most(along, whole(0)), at_most(length_2, along));
        let (foot, definition) = prover.define(
            "foot",
            &[
                (before, whole(0), whole(1)),
                (all([positive(along), past]), whole(1), whole(1)),
                (all([positive(along), less(along, length_2)]), along, length_2),
            ],
        );
        prover.contract(&NEAR, &paths, [p.x, p.y, a.x, a.y, b.x, b.y, r], ([foot], &definition));
    },
};

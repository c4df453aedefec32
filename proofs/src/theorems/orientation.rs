//! Orientation and point–point.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::predicate::{Orientation, orientation, point_point};

use super::plane::V;
use crate::smt::explore::{explore, outcome_is};
use crate::smt::fact::{Implication, at_most, claim, equal, less, same};
use crate::smt::prover::{Prover, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

/// Orientation.
pub const ORIENTATION: Theorem = Theorem {
    name: "orientation",
    source: "predicate::orientation",
    claim: "the answer is the sign of the area of a, b, c; a swap changes the sign, a rotation does not",
    proof: |prover| {
        let [a, b, c] = ["a", "b", "c"].map(V::unknown);
        let of =
            |p: V, q: V, r: V| explore(&[], &[], || orientation::<Symbolic>(p.place(), q.place(), r.place()));
        let paths = of(a, b, c);
        // Twice the area, from Green's formula over the triangle's sides.
        let area = a.cross(b) + b.cross(c) + c.cross(a);
        prover.on_paths("sign of the area", &paths, |outcome| {
            claim(
                [],
                match outcome {
                    Orientation::Left => less(whole(0), area),
                    Orientation::On => equal(area, whole(0)),
                    Orientation::Right => less(area, whole(0)),
                },
            )
        });
        let laws = [("rotation", of(b, c, a), false), ("swap", of(b, a, c), true)];
        for (name, other, swapped) in laws {
            for side in [Orientation::Left, Orientation::On, Orientation::Right] {
                let image = match (side, swapped) {
                    (Orientation::Left, true) => Orientation::Right,
                    (Orientation::Right, true) => Orientation::Left,
                    (side, _) => side,
                };
                let then = same(&outcome_is(&paths, &side), &outcome_is(&other, &image));
                prover.prove(&format!("{name}, {side:?}"), &claim([], then));
            }
        }
    },
};

/// Point–point.
pub const POINT_POINT: Theorem = Theorem {
    name: "point_point",
    source: "predicate::point_point",
    claim: "near exactly when |p − q| ≤ r",
    proof: |prover: &mut Prover<'_>| {
        let [p, q] = ["p", "q"].map(V::unknown);
        let (r, distance) = (Term::fresh("r"), Term::fresh("distance"));
        let paths = explore(&[], &[], || point_point::<Symbolic>(p.place(), q.place(), Scalar(r)).is_clear());
        let given =
            vec![at_least_zero(r), at_least_zero(distance), equal(square(distance), (p - q).norm_2())];
        prover.on_paths("distance", &paths, |&clear| Implication {
            given: given.clone(),
            then: if clear { less(r, distance) } else { at_most(distance, r) },
        });
    },
};

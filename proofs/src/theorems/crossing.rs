//! Proper crossing of two segments.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::predicate::crosses_properly;

use super::plane::{V, between_segments, v as vector};
use crate::smt::explore::explore;
use crate::smt::fact::{Fact, all, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Prover};
use crate::smt::run::Theorem;
use crate::smt::symbolic::Symbolic;
use crate::smt::term::{Term, whole};

const CROSSES: &str = "crosses_properly";

pub(super) fn inner(t: Term) -> Fact {
    all([less(whole(0), t), less(t, whole(1))])
}

pub(super) fn four([ax, ay, bx, by, cx, cy, dx, dy]: [Term; 8]) -> [[V; 2]; 2] {
    [[vector(ax, ay), vector(bx, by)], [vector(cx, cy), vector(dx, dy)]]
}

/// The eight coordinates of two segments.
pub(super) fn coordinates([[a, b], [c, d]]: [[V; 2]; 2]) -> [Term; 8] {
    [a.x, a.y, b.x, b.y, c.x, c.y, d.x, d.y]
}

pub(super) fn numbers<const N: usize>(segments: [[V; 2]; 2], more: &[Term]) -> [Term; N] {
    let all: Vec<Term> = coordinates(segments).into_iter().chain(more.iter().copied()).collect();
    all.try_into().expect("as many numbers as the contract has")
}

/// Two segments of unknown ends.
pub(super) fn unknown_segments() -> [[V; 2]; 2] {
    let c = V::unknown("c");
    let a = c.other("a");
    [[a, a.other("b")], [c, c.other("d")]]
}

/// Crossing: there is a point interior to both.
pub const CROSSING: Contract<8, 2> = Contract {
    theorem: CROSSES,
    name: "crossing: there is a point interior to both",
    statement: |crosses, points, [s, t]| {
        let [ab, cd] = four(points);
        let meet = between_segments(ab, cd, s, t).is_zero();
        let parallel = equal((ab[1] - ab[0]).cross(cd[1] - cd[0]), whole(0));
        claim([crosses], all([inner(s), inner(t), meet, not(parallel)]))
    },
};

/// Not crossing: segments that are not parallel have no common point interior to both.
pub const NOT_CROSSING: Contract<10, 0> = Contract {
    theorem: CROSSES,
    name: "not crossing: no point of lines that are not parallel is interior to both",
    statement: |crosses, [ax, ay, bx, by, cx, cy, dx, dy, s, t], []| {
        let [ab, cd] = four([ax, ay, bx, by, cx, cy, dx, dy]);
        let parallel = equal((ab[1] - ab[0]).cross(cd[1] - cd[0]), whole(0));
        let meet = between_segments(ab, cd, s, t).is_zero();
        claim([not(crosses), not(parallel), meet], not(all([inner(s), inner(t)])))
    },
};

/// The parameters of the common point of two lines that are not parallel.
pub(super) fn meeting(prover: &mut Prover<'_>, [ab, cd]: [[V; 2]; 2]) -> ([Term; 2], Vec<Instance>) {
    let (w, u, v) = (ab[0] - cd[0], ab[1] - ab[0], cd[1] - cd[0]);
    let determinant = u.cross(v);
    let some = not(equal(determinant, whole(0)));
    let (s, mut definition) = prover.define("s0", &[(some.clone(), v.cross(w), determinant)]);
    let (t, more) = prover.define("t0", &[(some, u.cross(w), determinant)]);
    definition.extend(more);
    ([s, t], definition)
}

/// The theorem about proper crossings.
pub const CROSSES_PROPERLY: Theorem = Theorem {
    name: CROSSES,
    source: "predicate::crosses_properly",
    claim: "yes exactly when the lines are not parallel and meet at a point interior to both segments",
    proof: |prover| {
        let [ab, cd] = unknown_segments();
        let paths = explore(&[], &[], || {
            let [a, b, c, d] = [ab[0], ab[1], cd[0], cd[1]].map(V::place);
            crosses_properly::<Symbolic>(a, b, c, d)
        });
        let (meet, definition) = meeting(prover, [ab, cd]);
        prover.contract(&CROSSING, &paths, coordinates([ab, cd]), (meet, &definition));
        let [s, t] = ["s", "t"].map(Term::fresh);
        prover.contract(&NOT_CROSSING, &paths, numbers([ab, cd], &[s, t]), ([], &[]));
    },
};

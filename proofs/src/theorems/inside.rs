//! Points strictly inside a triangle.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::predicate::strictly_inside;

use super::plane::{V, terms, v};
use crate::smt::explore::explore;
use crate::smt::fact::{Fact, all, any, at_most, claim, equal, not};
use crate::smt::prover::{Contract, Instance, Prover, at_least_zero, positive};
use crate::smt::run::Theorem;
use crate::smt::symbolic::Symbolic;
use crate::smt::term::{Term, whole};

const INSIDE: &str = "strictly_inside";

/// The point with these weights of the corners.
pub(super) fn weighted([a, b, c]: [V; 3], [p, q, r]: [Term; 3]) -> V {
    a.times(p) + b.times(q) + c.times(r)
}

/// Whether the numbers are weights of a point of the triangle.
pub(super) fn are_weights([p, q, r]: [Term; 3]) -> Fact {
    all([at_least_zero(p), at_least_zero(q), at_least_zero(r), sum_is_one([p, q, r])])
}

pub(super) fn sum_is_one([p, q, r]: [Term; 3]) -> Fact {
    equal(p + q + r, whole(1))
}

pub(super) fn area([a, b, c]: [V; 3]) -> Term {
    (b - a).cross(c - a)
}

/// Inside: a mean of the corners with positive weights.
pub const IS_INSIDE: Contract<8, 3> = Contract {
    theorem: INSIDE,
    name: "yes: a mean of the corners with positive weights",
    statement: |inside, [px, py, ax, ay, bx, by, cx, cy], weights| {
        let point = weighted([v(ax, ay), v(bx, by), v(cx, cy)], weights);
        let facts = weights.map(positive).into_iter().chain([sum_is_one(weights), point.is(v(px, py))]);
        claim([inside], all(facts))
    },
};

/// Not inside: no such mean.
pub const NOT_INSIDE: Contract<11, 0> = Contract {
    theorem: INSIDE,
    name: "no: no such mean, unless the triangle is flat",
    statement: |inside, [px, py, ax, ay, bx, by, cx, cy, p, q, r], []| {
        let corners = [v(ax, ay), v(bx, by), v(cx, cy)];
        let mean = weighted(corners, [p, q, r]).is(v(px, py));
        let flat = equal(area(corners), whole(0));
        let given = [not(inside), not(flat), sum_is_one([p, q, r]), mean];
        claim(given, any([p, q, r].map(|weight| at_most(weight, whole(0)))))
    },
};

/// The weights of a point in a triangle that is not flat.
pub(super) fn weights_of(prover: &mut Prover<'_>, p: V, [a, b, c]: [V; 3]) -> ([Term; 3], Vec<Instance>) {
    let some = not(equal(area([a, b, c]), whole(0)));
    let mut using = Vec::new();
    let weights = [(b, c), (c, a), (a, b)].map(|(d, e)| {
        let case = (some.clone(), (d - p).cross(e - p), area([a, b, c]));
        let (weight, definition) = prover.define("weight", &[case]);
        using.extend(definition);
        weight
    });
    let known = prover.lemma("weights make the point", |[px, py, ax, ay, bx, by, cx, cy, q, r, s]| {
        let (p, a, b, c) = (v(px, py), v(ax, ay), v(bx, by), v(cx, cy));
        let whole_area = area([a, b, c]);
        let shares = [(q, b, c), (r, c, a), (s, a, b)];
        let [x, y, z] = shares.map(|(weight, d, e)| equal(weight * whole_area, (d - p).cross(e - p)));
        let given = [not(equal(whole_area, whole(0))), x, y, z];
        claim(given, all([sum_is_one([q, r, s]), weighted([a, b, c], [q, r, s]).is(p)]))
    });
    using.push(known.at(terms(&[p, a, b, c], &weights)));
    (weights, using)
}

pub(super) fn unknown_corners() -> [V; 3] {
    let a = V::unknown("a");
    [a, a.other("b"), a.other("c")]
}

/// The theorem about points strictly inside.
pub const STRICTLY_INSIDE: Theorem = Theorem {
    name: INSIDE,
    source: "predicate::strictly_inside",
    claim: "yes exactly when the point is a mean of the corners with positive weights, and the triangle \
            is not flat",
    proof: |prover| {
        let corners = unknown_corners();
        let [a, b, c] = corners;
        let p = a.other("p");
        let paths =
            explore(&[], &[], || strictly_inside::<Symbolic>(p.place(), a.place(), b.place(), c.place()));
        let (weights, definition) = weights_of(prover, p, corners);
        prover.contract(&IS_INSIDE, &paths, terms(&[p, a, b, c], &[]), (weights, &definition));
        // For any weights of the point: the point is where they put it.
        let free = [Term::fresh("q"), Term::fresh("r"), Term::fresh("s")];
        prover.contract(&NOT_INSIDE, &paths, terms(&[p, a, b, c], &free), ([], &[]));
    },
};

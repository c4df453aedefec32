//! Rings of chords: the checks on pairs of edges.
//!
//! Evidence for SR-04.

use super::plane::{V, share, v};
use crate::smt::fact::{Implication, all, any, at_most, claim, equal, less, not};
use crate::smt::prover::positive;
use crate::smt::run::Theorem;
use crate::smt::term::{Term, whole};

/// The theorem about the short cut of `touches`.
pub const TOUCHES: Theorem = Theorem {
    name: "touches",
    source: "Segment::touches",
    claim: "segments have no common point if one lies strictly on one side of the other's line; else the \
            answer is that of `segment_segment` at 0",
    proof: |prover| {
        prover.lemma(
            "a point strictly on one side is not on the line",
            |[ax, ay, bx, by, cx, cy, dx, dy, t]| {
                let (a, b, c, d) = (v(ax, ay), v(bx, by), v(cx, cy), v(dx, dy));
                let side = |p: V| (b - a).cross(p - a);
                let zero = whole(0);
                let left = all([less(zero, side(c)), less(zero, side(d))]);
                let right = all([less(side(c), zero), less(side(d), zero)]);
                claim([any([left, right]), share(t)], not(equal(side(c + (d - c).times(t)), zero)))
            },
        );
        prover.lemma("a point of a segment is on its line", |[ax, ay, bx, by, s]| {
            let (a, b) = (v(ax, ay), v(bx, by));
            claim([], equal((b - a).cross((b - a).times(s)), whole(0)))
        });
    },
};

/// Edges that share an end.
pub const FOLDS_BACK: Theorem = Theorem {
    name: "folds_back",
    source: "ring::folds_back",
    claim: "edges from a shared end have a second common point only if they are parallel and the end of \
            one lies on the other",
    proof: |prover| {
        let [u, w] = ["u", "w"].map(V::unknown);
        let [s, t] = ["s", "t"].map(Term::fresh);
        let one = [positive(s), at_most(s, whole(1)), positive(t), at_most(t, whole(1))];
        let common = u.times(s).is(w.times(t));
        let mut given = vec![common.clone()];
        given.extend(one.clone());
        let parallel = equal(u.cross(w), whole(0));
        prover.prove("parallel", &Implication { given, then: parallel });
        for (name, near, far, p, q) in [("first", s, t, u, w), ("second", t, s, w, u)] {
            // The end of the edge that the common point is farther along lies on the other.
            let (k, using) = prover.define("k", &[(positive(near), far, near)]);
            let then = all([share(k), p.is(q.times(k))]);
            let mut given = vec![common.clone(), at_most(far, near)];
            given.extend(one.clone());
            let title = format!("the end of the {name} lies on the other");
            prover.follows(&title, &using, &Implication { given, then });
        }
    },
};

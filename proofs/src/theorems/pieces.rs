//! Proof that the pieces of a swept arc cover it.
//!
//! Evidence for SR-02.

use super::plane::{V, v};
use crate::smt::fact::{all, any, at_most, claim, equal};
use crate::smt::prover::{at_least_zero, positive};
use crate::smt::run::Theorem;
use crate::smt::term::whole;

/// The theorem about the pieces of a swept arc.
pub const SWEPT_PIECES: Theorem = Theorem {
    name: "swept_arc_pieces",
    source: "SweptArc::reaches_before, push_halves, follows; ArcChords::check",
    claim: "let two corners be less than half a turn apart: a ray between them lies between the first and \
            a middle corner, or between the middle and the second. An end ahead of a corner and behind \
            the next quarter turn lies between the two",
    proof: |prover| {
        // All lemmas are for left turns about the origin. Right turns are their mirror image.
        prover.lemma(
            "orientations tell whether a point is between two rays",
            |[ax, ay, bx, by, x, y, k, m]| {
                let (a, b, p) = (v(ax, ay), v(bx, by), v(x, y));
                let turn = a.cross(b);
                let given = [
                    positive(turn),
                    all([at_least_zero(a.cross(p)), at_least_zero(p.cross(b))]),
                    all([equal(k * turn, p.cross(b)), equal(m * turn, a.cross(p))]),
                ];
                let mean = (a.times(k) + b.times(m)).is(p);
                claim(given, all([mean, at_least_zero(k), at_least_zero(m)]))
            },
        );
        prover.lemma("a mean of two rays lies between them", |[ax, ay, bx, by, k, m]| {
            let (a, b) = (v(ax, ay), v(bx, by));
            let p = a.times(k) + b.times(m);
            let given = [positive(a.cross(b)), at_least_zero(k), at_least_zero(m)];
            claim(given, all([at_least_zero(a.cross(p)), at_least_zero(p.cross(b))]))
        });
        prover.lemma("two halves cover the whole", |[ax, ay, mx, my, bx, by, x, y]| {
            let (a, middle, b, p) = (v(ax, ay), v(mx, my), v(bx, by), v(x, y));
            let ahead = all([positive(a.cross(middle)), positive(middle.cross(b)), positive(a.cross(b))]);
            let between = |a: V, b: V| all([at_least_zero(a.cross(p)), at_least_zero(p.cross(b))]);
            claim([ahead, between(a, b)], any([between(a, middle), between(middle, b)]))
        });
        prover.lemma("an end within the next quarter", |[ax, ay, ex, ey]| {
            let (a, end) = (v(ax, ay), v(ex, ey));
            let next = v(whole(0) - ay, ax);
            let given = [positive(a.cross(end)), positive(end.cross(next))];
            claim(given, all([positive(a.cross(next)), positive(a.dot(end)), positive(next.dot(end))]))
        });
        prover.lemma("a quarter turn keeps the distance", |[x, y]| {
            let (a, next) = (v(x, y), v(whole(0) - y, x));
            claim([], all([equal(a.norm_2(), next.norm_2()), equal(a.dot(next), whole(0))]))
        });
        prover.lemma(
            "points of a chord less than half a turn long are not the centre",
            |[ax, ay, bx, by, m]| {
                let (a, b) = (v(ax, ay), v(bx, by));
                let p = a + (b - a).times(m);
                let given = [positive(a.cross(b)), at_most(whole(0), m), at_most(m, whole(1))];
                claim(given, positive(p.norm_2()))
            },
        );
    },
};

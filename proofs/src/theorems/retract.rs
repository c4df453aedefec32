//! Motions that retract from a segment.
//!
//! Evidence for SR-14.

use keepout_kernel::exact::predicate::retract;

use super::plane::{V, share, to_segment, v};
use crate::smt::explore::explore;
use crate::smt::fact::{Fact, all, any, at_most, claim, equal, less, not};
use crate::smt::prover::{at_least_zero, positive};
use crate::smt::run::Theorem;
use crate::smt::symbolic::Symbolic;
use crate::smt::term::{Term, whole};

/// The theorem about retracting motions.
pub const RETRACTS: Theorem = Theorem {
    name: "retracts",
    source: "predicate::retract",
    claim: "yes: no point of the motion is nearer to any point of the segment than its start is to the \
            segment; no: some point of the motion is nearer to the segment than its start is",
    proof: |prover| {
        let p = V::unknown("p");
        let [q, a] = ["q", "a"].map(|name| p.other(name));
        let b = a.other("b");
        let paths = explore(&[], &[], || retract::<Symbolic>(p.place(), q.place(), a.place(), b.place()));
        let (along, length_2) = ((p - a).dot(b - a), (b - a).norm_2());
        let (before, past) = (at_most(along, whole(0)), at_most(length_2, along));
        let (foot, mut using) = prover.define(
            "foot",
            &[
                (before, whole(0), whole(1)),
                (all([positive(along), past]), whole(1), whole(1)),
                (all([positive(along), less(along, length_2)]), along, length_2),
            ],
        );
        // From the nearest point of the segment to p, and from any point of it.
        let nearest = a + (b - a).times(foot);
        let n = p - nearest;
        let rate = n.dot(q - p);
        prover.on_paths_by("yes: the rate at the start is not negative", &paths, &using, |&retract| {
            claim([retract.into()], at_least_zero(rate))
        });
        prover.on_paths_by("no: it is negative", &paths, &using, |&retract| {
            claim([(!retract).into()], less(rate, whole(0)))
        });
        let [s, t] = ["s", "t"].map(Term::fresh);
        let obtuse = prover.follows(
            "the nearest point is in front of all others",
            &using,
            &claim([share(s)], at_most(n.dot((b - a).times(s - foot)), whole(0))),
        );
        let there = p + (q - p).times(t);
        let any_point = a + (b - a).times(s);
        let z = there - any_point;
        let split = claim([], equal(n.dot(z), (n.norm_2() + t * rate) - n.dot((b - a).times(s - foot))));
        using = vec![obtuse, prover.fact("the difference along n", &split)];
        let product = prover.lemma("products of numbers that are not negative", |[t, rate]| {
            claim([at_least_zero(t), at_least_zero(rate)], at_least_zero(t * rate))
        });
        using.push(product.at([t, rate]));
        let cauchy = prover.lemma("longer along n is longer", |[nx, ny, zx, zy]| {
            let (n, z) = (v(nx, ny), v(zx, zy));
            claim([at_most(n.norm_2(), n.dot(z))], at_most(n.norm_2(), z.norm_2()))
        });
        using.push(cauchy.at([n.x, n.y, z.x, z.y]));
        let given = [at_least_zero(rate), share(s), share(t)];
        prover.glue("so no point is nearer", &using, &claim(given, at_most(n.norm_2(), z.norm_2())));
        prover.prove(
            "the start is as far from the segment's nearest point as n is long",
            &claim([], equal(n.norm_2(), to_segment(p, a, b, foot).norm_2())),
        );
        // A negative rate: at t = min(1, −rate / |q − p|²) the motion is nearer to that point.
        prover.lemma("a motion with a negative rate comes nearer", |[nx, ny, mx, my, t]| {
            let (n, m) = (v(nx, ny), v(mx, my));
            let rate = n.dot(m);
            let nearer = less((n + m.times(t)).norm_2(), n.norm_2());
            let short = any_of(at_most(-rate, m.norm_2()), equal(t * m.norm_2(), -rate), equal(t, whole(1)));
            claim([less(rate, whole(0)), short], all([share(t), nearer]))
        });
        prover.lemma("such a motion has a length", |[nx, ny, mx, my]| {
            let (n, m) = (v(nx, ny), v(mx, my));
            claim([less(n.dot(m), whole(0))], not(equal(m.norm_2(), whole(0))))
        });
    },
};

fn any_of(case: Fact, then: Fact, other: Fact) -> Fact {
    all([any([not(case.clone()), then]), any([case, other])])
}

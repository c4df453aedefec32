//! Sums of distances: rounding, and prefixes of motions.
//!
//! Evidence for SR-01, SR-03.

use super::plane::{V, between_segments, share, terms, v};
use super::segments;
use crate::smt::explore::{Part, answer};
use crate::smt::fact::{Fact, Implication, all, at_most, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Prover, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::term::{Term, square, whole};

const INEQUALITY: &str = "triangle_inequality";

fn difference(p: V, z: V) -> Term {
    (p - z).norm_2()
}

/// A vector longer than p and one of at most z differ by more than p − z.
pub const FARTHER: Contract<6, 0> = Contract {
    theorem: INEQUALITY,
    name: "longer than p, and at most z: more than p − z apart",
    statement: |_, [px, py, zx, zy, p, z], []| {
        let (long, short) = (v(px, py), v(zx, zy));
        let given = [
            at_least_zero(z),
            at_most(z, p),
            less(square(p), long.norm_2()),
            at_most(short.norm_2(), square(z)),
        ];
        claim(given, less(square(p - z), difference(long, short)))
    },
};

/// As [`FARTHER`], with "at least".
pub const LONGER: Contract<6, 0> = Contract {
    theorem: INEQUALITY,
    name: "at least p, and at most z: at least p − z apart",
    statement: |_, [px, py, zx, zy, p, z], []| {
        let (long, short) = (v(px, py), v(zx, zy));
        let given = [
            at_least_zero(z),
            at_most(z, p),
            at_most(square(p), long.norm_2()),
            at_most(short.norm_2(), square(z)),
        ];
        claim(given, at_most(square(p - z), difference(long, short)))
    },
};

/// The triangle inequality.
pub const TRIANGLE_INEQUALITY: Theorem = Theorem {
    name: INEQUALITY,
    source: "(plane geometry)",
    claim: "a vector longer than p and one of length z or less are more than p − z apart, for z ≤ p",
    proof: |prover| {
        let [long, short] = ["p", "z"].map(V::unknown);
        let [p, z] = ["p", "z"].map(Term::fresh);
        let (x, mut using) = prover.root("x", &[], long.norm_2());
        let (y, more) = prover.root("y", &[], short.norm_2());
        using.extend(more);
        let cauchy = prover.lemma("Cauchy and Schwarz", |[ax, ay, bx, by, x, y]| {
            let (a, b) = (v(ax, ay), v(bx, by));
            let squares = equal(square(x * y), square(a.dot(b)) + square(a.cross(b)));
            claim([equal(x * x, a.norm_2()), equal(y * y, b.norm_2())], squares)
        });
        using.push(cauchy.at(terms(&[long, short], &[x, y])));
        let dot = prover.lemma("so a product is at most that of the lengths", |[dot, cross, x, y]| {
            let given =
                [at_least_zero(x), at_least_zero(y), equal(square(x * y), square(dot) + square(cross))];
            claim(given, at_most(dot, x * y))
        });
        using.push(dot.at([long.dot(short), long.cross(short), x, y]));
        let apart = prover.lemma("the distance", |[ax, ay, bx, by, x, y]| {
            let (a, b) = (v(ax, ay), v(bx, by));
            let given = [equal(x * x, a.norm_2()), equal(y * y, b.norm_2()), at_most(a.dot(b), x * y)];
            claim(given, at_most(square(x - y), difference(a, b)))
        });
        using.push(apart.at(terms(&[long, short], &[x, y])));
        let strict = prover.lemma("more than p, at most z", |[p, z, x, y]| {
            let given = [
                at_least_zero(x),
                at_least_zero(y),
                at_least_zero(z),
                at_most(z, p),
                less(square(p), x * x),
                at_most(y * y, square(z)),
            ];
            claim(given, less(square(p - z), square(x - y)))
        });
        let weak = prover.lemma("at least p, at most z", |[p, z, x, y]| {
            let given = [
                at_least_zero(x),
                at_least_zero(y),
                at_least_zero(z),
                at_most(z, p),
                at_most(square(p), x * x),
                at_most(y * y, square(z)),
            ];
            claim(given, at_most(square(p - z), square(x - y)))
        });
        using.extend([strict.at([p, z, x, y]), weak.at([p, z, x, y])]);
        let numbers = || terms(&[long, short], &[p, z]);
        prover.establish(&FARTHER, Fact::True, numbers(), ([], &using));
        prover.establish(&LONGER, Fact::True, numbers(), ([], &using));
    },
};

/// The theorem about rounding toward safety.
pub const ROUNDING: Theorem = Theorem {
    name: "rounding",
    source: "margin: lattice rounding",
    claim: "if a rounded point, motion or swept triangle is clear by r + 1, the true one is clear by r, \
            when rounding moves ends by at most 1",
    proof: |prover| {
        prover.lemma("rounding to the nearest moves a point by less than 1", |[dx, dy]| {
            let half = |d: Term| all([at_most(whole(-1), whole(2) * d), at_most(whole(2) * d, whole(1))]);
            claim([half(dx), half(dy)], less(v(dx, dy).norm_2(), whole(1)))
        });
        let jensen =
            prover.lemma("the square of a mean is at most the mean of the squares", |[x, y, z, p, q, r]| {
                let weights =
                    [at_least_zero(p), at_least_zero(q), at_least_zero(r), equal(p + q + r, whole(1))];
                let mean = (p * x + q * y) + r * z;
                let squares = (p * square(x) + q * square(y)) + r * square(z);
                claim(weights, at_most(square(mean), squares))
            });
        let weighted = prover.lemma("a mean of lengths of at most 1", |[a, b, c, p, q, r]| {
            let weights = [at_least_zero(p), at_least_zero(q), at_least_zero(r), equal(p + q + r, whole(1))];
            let short = all([a, b, c].map(|square| at_most(square, whole(1))));
            let [w, x, y, z] = weights;
            claim([w, x, y, z, short], at_most((p * a + q * b) + r * c, whole(1)))
        });
        let sums = prover.lemma("both coordinates", |[p, q, r, x, y, z, u, v, w]| {
            let of = |a: Term, b: Term, c: Term| (p * a + q * b) + r * c;
            let together = of(square(x) + square(u), square(y) + square(v), square(z) + square(w));
            let apart = of(square(x), square(y), square(z)) + of(square(u), square(v), square(w));
            claim([], equal(together, apart))
        });
        let names = ["a", "b", "c"];
        let shifts = names.map(|name| V::unknown(&format!("shift {name}")));
        let [p, q, r] = ["p", "q", "r"].map(Term::fresh);
        let mean = V {
            x: (p * shifts[0].x + q * shifts[1].x) + r * shifts[2].x,
            y: (p * shifts[0].y + q * shifts[1].y) + r * shifts[2].y,
        };
        let [a, b, c] = shifts;
        let squares = |shift: V| square(shift.x) + square(shift.y);
        let using = [
            jensen.at([a.x, b.x, c.x, p, q, r]),
            jensen.at([a.y, b.y, c.y, p, q, r]),
            weighted.at([squares(a), squares(b), squares(c), p, q, r]),
            sums.at([p, q, r, a.x, b.x, c.x, a.y, b.y, c.y]),
        ];
        let weights = all([at_least_zero(p), at_least_zero(q), at_least_zero(r), equal(p + q + r, whole(1))]);
        let short = all(shifts.map(|shift| at_most(squares(shift), whole(1))));
        let moved = claim([weights, short], at_most(square(mean.x) + square(mean.y), whole(1)));
        prover.glue("every point of a triangle, a motion or a point moves by at most 1", &using, &moved);
        // Then its distance from anything is that of the rounded one, less 1 at most.
        let [point, shift] = ["point", "shift"].map(V::unknown);
        let r = Term::fresh("r");
        let reach = r + whole(1);
        let step = prover.by(&FARTHER, Fact::True, terms(&[point, shift], &[reach, whole(1)])).0;
        let left = prover.fact("the rest", &claim([], equal(square(reach - whole(1)), square(r))));
        let one = prover.fact("one", &claim([], equal(square(whole(1)), whole(1))));
        let given =
            [at_least_zero(r), less(square(reach), point.norm_2()), at_most(shift.norm_2(), whole(1))];
        prover.glue(
            "so the distance shrinks by at most 1",
            &[step, left, one],
            &claim(given, less(square(r), difference(point, shift))),
        );
    },
};

/// The theorem about prefixes of motions.
pub const CLIP: Theorem = Theorem {
    name: "clip_prefix",
    source: "ProhibitedRegion::clip, longest_prefix",
    claim: "a prefix of a clear motion is clear: `segment_segment` is near for a part of a motion only if \
            it is near for the whole",
    proof: |prover: &mut Prover<'_>| {
        let c = V::unknown("c");
        let [a, d] = ["a", "d"].map(|name| c.other(name));
        let b = a.other("b");
        let [r, part] = ["r", "part"].map(Term::fresh);
        let end = a + (b - a).times(part);
        let question = |b: V| answer(Part::SegmentSegment, &terms::<9>(&[a, b, c, d], &[r]));
        let (found, [s, t]) = prover.by(&segments::NEAR, question(end), terms(&[a, end, c, d], &[r]));
        let (clear, []) = prover.by(&segments::CLEAR, question(b), terms(&[a, b, c, d], &[r, part * s, t]));
        let same = prover.lemma("a share of a share", |[ax, ay, bx, by, cx, cy, dx, dy, part, s, t]| {
            let (a, b, c, d) = (v(ax, ay), v(bx, by), v(cx, cy), v(dx, dy));
            let end = a + (b - a).times(part);
            let of = |b: V, s: Term| between_segments([a, b], [c, d], s, t).norm_2();
            claim([], equal(of(end, s), of(b, part * s)))
        });
        let stays =
            prover.lemma("a product of shares", |[part, s]| claim([share(part), share(s)], share(part * s)));
        let using: [Instance; 4] =
            [found, clear, same.at(terms(&[a, b, c, d], &[part, s, t])), stays.at([part, s])];
        let given = vec![at_least_zero(r), share(part), not(question(b))];
        prover.glue("no prefix is near", &using, &Implication { given, then: not(question(end)) });
    },
};

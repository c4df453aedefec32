//! Triangle–segment.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::predicate::triangle_segment;

use super::inside::{IS_INSIDE, are_weights, sum_is_one, unknown_corners, weighted};
use super::plane::{V, between_segments, share, terms, v};
use super::segments;
use super::triangle_exit::LEAVES;
use crate::smt::explore::{Part, answer, explore};
use crate::smt::fact::{Fact, all, at_most, claim, equal, less, not};
use crate::smt::prover::{Contract, at_least_zero, positive};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

const TRIANGLE: &str = "triangle_segment";

/// Clear: no point of the filled triangle is within r of the segment.
pub const CLEAR: Contract<15, 0> = Contract {
    theorem: TRIANGLE,
    name: "clear: no point of the triangle is within r of a point of the segment",
    statement: |near, [ax, ay, bx, by, cx, cy, dx, dy, ex, ey, r, p, q, s, t], []| {
        let corners = [v(ax, ay), v(bx, by), v(cx, cy)];
        let other = v(dx, dy) + (v(ex, ey) - v(dx, dy)).times(t);
        let distance_2 = (weighted(corners, [p, q, s]) - other).norm_2();
        claim([not(near), at_least_zero(r), are_weights([p, q, s]), share(t)], less(square(r), distance_2))
    },
};

/// Near: some point of the filled triangle is within r of the segment.
pub const NEAR: Contract<11, 4> = Contract {
    theorem: TRIANGLE,
    name: "near: some point of the triangle is within r of a point of the segment",
    statement: |near, [ax, ay, bx, by, cx, cy, dx, dy, ex, ey, r], [p, q, s, t]| {
        let corners = [v(ax, ay), v(bx, by), v(cx, cy)];
        let other = v(dx, dy) + (v(ex, ey) - v(dx, dy)).times(t);
        let distance_2 = (weighted(corners, [p, q, s]) - other).norm_2();
        claim(
            [near, at_least_zero(r)],
            all([are_weights([p, q, s]), share(t), at_most(distance_2, square(r))]),
        )
    },
};

/// Triangle–segment.
pub const TRIANGLE_SEGMENT: Theorem = Theorem {
    name: TRIANGLE,
    source: "predicate::triangle_segment",
    claim: "near exactly when a point of the filled triangle is within r of a point of the segment, for r \
            ≥ 0",
    proof: |prover| {
        let corners = unknown_corners();
        let [d, e] = ["d", "e"].map(|name| corners[0].other(name));
        let [r, t] = ["r", "t"].map(Term::fresh);
        let weights = ["p", "q", "s"].map(Term::fresh);
        let parts = [Part::SegmentSegment, Part::StrictlyInside];
        let paths = explore(&[], &parts, || {
            let corners = corners.map(V::place);
            !triangle_segment::<Symbolic>(corners, [d.place(), e.place()], Scalar(r)).is_clear()
        });
        let sides: [[Term; 9]; 3] =
            std::array::from_fn(|i| terms(&[corners[i], corners[(i + 1) % 3], d, e], &[r]));
        let near_side = |i: usize| answer(Part::SegmentSegment, &sides[i]);
        let is_inside =
            |p: V| answer(Part::StrictlyInside, &terms::<8>(&[p, corners[0], corners[1], corners[2]], &[]));
        let triple = |p: V| [p, corners[0], corners[1], corners[2]];

        // Clear: from a point of the triangle toward one of the segment, and from there toward the
        // segment's beginning.
        let other = d + (e - d).times(t);
        let from = weighted(corners, weights);
        let (first, [way, s]) = prover.by(&LEAVES, is_inside(other), terms(&triple(other), &weights));
        let (within, inner) = prover.by(&IS_INSIDE, is_inside(other), terms(&triple(other), &[]));
        let (second, [back, s2]) = prover.by(&LEAVES, is_inside(d), terms(&triple(d), &inner));
        let t2 = t * (whole(1) - back);
        let mut using = vec![first, within, second];
        let nearer = prover.lemma("a point on the way is as near", |[fx, fy, ox, oy, way]| {
            let (from, to) = (v(fx, fy), v(ox, oy));
            let there = from + (to - from).times(way);
            claim([share(way)], at_most((there - to).norm_2(), (from - to).norm_2()))
        });
        using.push(nearer.at([from.x, from.y, other.x, other.y, way]));
        let shares = prover.lemma("a share of a share", |[t, back]| {
            claim([share(t), share(back)], share(t * (whole(1) - back)))
        });
        using.push(shares.at([t, back]));
        let there = from + (other - from).times(way);
        let mean = weighted(corners, inner);
        for i in 0..3 {
            let pair = |s: Term, t: Term| -> [Term; 11] {
                let all: Vec<Term> = sides[i].into_iter().chain([s, t]).collect();
                all.try_into().expect("nine numbers and two")
            };
            using.push(prover.by(&segments::CLEAR, near_side(i), pair(s, t)).0);
            using.push(prover.by(&segments::CLEAR, near_side(i), pair(s2, t2)).0);
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let side = prover.lemma(
                "a point of a side as segments see it",
                |[ax, ay, bx, by, dx, dy, ex, ey, s, t, x, y]| {
                    let (a, b, d, e) = (v(ax, ay), v(bx, by), v(dx, dy), v(ex, ey));
                    let difference = between_segments([a, b], [d, e], s, t);
                    let other = d + (e - d).times(t);
                    let given = [v(x, y).is(a + (b - a).times(s))];
                    claim(given, equal(difference.norm_2(), (v(x, y) - other).norm_2()))
                },
            );
            using.push(side.at(terms(&[a, b, d, e], &[s, t, there.x, there.y])));
            let touch = prover.lemma(
                "a common point of side and segment",
                |[ax, ay, bx, by, dx, dy, ex, ey, s, t, back, mx, my]| {
                    let (a, b, d, e, mean) = (v(ax, ay), v(bx, by), v(dx, dy), v(ex, ey), v(mx, my));
                    let at = t * (whole(1) - back);
                    let difference = between_segments([a, b], [d, e], s, at);
                    let given = [
                        mean.is(d + (e - d).times(t)),
                        (mean + (d - mean).times(back)).is(a + (b - a).times(s)),
                    ];
                    claim(given, equal(difference.norm_2(), whole(0)))
                },
            );
            using.push(touch.at(terms(&[a, b, d, e], &[s2, t, back, mean.x, mean.y])));
        }
        let squares = prover.lemma("a square", |[r]| claim([], at_least_zero(square(r))));
        using.push(squares.at([r]));
        let weak = prover.lemma("weights", |[p, q, r]| {
            let facts = [p, q, r].map(positive).into_iter().chain([sum_is_one([p, q, r])]);
            claim([all(facts)], are_weights([p, q, r]))
        });
        using.push(weak.at(inner));
        let numbers =
            terms(&[corners[0], corners[1], corners[2], d, e], &[r, weights[0], weights[1], weights[2], t]);
        prover.by_parts(&CLEAR, &paths, numbers, ([], &using));

        // Near: a point of a side, or the beginning of the segment.
        let mut using = Vec::new();
        let mut candidates = Vec::new();
        for i in 0..3 {
            let (found, [s, t]) = prover.by(&segments::NEAR, near_side(i), sides[i]);
            using.push(found);
            let mut weights = [whole(0); 3];
            weights[i] = whole(1) - s;
            weights[(i + 1) % 3] = s;
            candidates.push((near_side(i), weights, t));
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let difference = between_segments([a, b], [d, e], s, t);
            let same = (weighted(corners, weights) - (d + (e - d).times(t))).norm_2();
            using.push(prover.fact("a point of a side", &claim([], equal(difference.norm_2(), same))));
        }
        let (within, inner) = prover.by(&IS_INSIDE, is_inside(d), terms(&triple(d), &[]));
        using.push(within);
        candidates.push((is_inside(d), inner, whole(0)));
        let gone = (weighted(corners, inner) - (d + (e - d).times(whole(0)))).norm_2();
        let touching = claim([weighted(corners, inner).is(d)], at_most(gone, square(r)));
        using.push(prover.fact("the beginning touches", &touching));
        let mut pick = |name: &str, of: &dyn Fn(usize) -> Term| {
            let cases: Vec<_> = (0..candidates.len())
                .map(|i| {
                    let before = candidates[..i].iter().map(|candidate| not(candidate.0.clone()));
                    (all(before.chain([candidates[i].0.clone()])), of(i), whole(1))
                })
                .collect();
            let (number, definition) = prover.define(name, &cases);
            using.extend(definition);
            number
        };
        let weights: [Term; 3] = std::array::from_fn(|k| pick("weight", &|i| candidates[i].1[k]));
        let t = pick("t", &|i| candidates[i].2);
        let distance_2 =
            |weights: [Term; 3], t: Term| (weighted(corners, weights) - (d + (e - d).times(t))).norm_2();
        for (_, w, t0) in &candidates {
            let given = vec![weights[0], weights[1], weights[2], t].into_iter().zip([w[0], w[1], w[2], *t0]);
            let equal_numbers: Vec<Fact> = given.map(|(a, b)| equal(a, b)).collect();
            let then = equal(distance_2(weights, t), distance_2(*w, *t0));
            let same = crate::smt::fact::Implication { given: equal_numbers, then };
            using.push(prover.fact("equal weights, equal distances", &same));
        }
        let numbers = terms(&[corners[0], corners[1], corners[2], d, e], &[r]);
        prover.by_parts(&NEAR, &paths, numbers, ([weights[0], weights[1], weights[2], t], &using));
    },
};

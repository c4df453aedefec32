//! Straight ways that leave a triangle.
//!
//! Evidence for SR-01.

use super::inside::{NOT_INSIDE, are_weights, area, sum_is_one, unknown_corners, weighted, weights_of};
use super::plane::{V, share, terms, v};
use crate::smt::explore::{Part, answer};
use crate::smt::fact::{Fact, all, any, at_most, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Prover, at_least_zero, positive};
use crate::smt::run::Theorem;
use crate::smt::term::{Term, whole};

const EXIT: &str = "triangle_exit";

/// The straight way from a point of the triangle to one that is not strictly inside has a point of a side.
pub const LEAVES: Contract<11, 2> = Contract {
    theorem: EXIT,
    name: "the way to a point that is not strictly inside meets a side",
    statement: |inside, [tx, ty, ax, ay, bx, by, cx, cy, p, q, r], [way, s]| {
        let (target, corners) = (v(tx, ty), [v(ax, ay), v(bx, by), v(cx, cy)]);
        let from = weighted(corners, [p, q, r]);
        let there = from + (target - from).times(way);
        let met = (0..3).map(|i| there.is(on_side(corners, i, s)));
        claim([not(inside), are_weights([p, q, r])], all([share(way), share(s), any(met)]))
    },
};

/// The cases of the share of the way from weight `p` to weight `z` at which the weight is zero. It is 1
/// when `z` is positive.
fn exit_cases(p: Term, z: Term) -> [(Fact, Term, Term); 3] {
    let zero = whole(0);
    [
        (all([at_most(z, zero), less(z, p)]), p, p - z),
        (all([at_most(z, zero), at_most(p, z)]), zero, whole(1)),
        (positive(z), whole(1), whole(1)),
    ]
}

fn is_exit(p: Term, z: Term, way: Term) -> Fact {
    all(exit_cases(p, z).map(|(guard, dividend, divisor)| {
        let body = if divisor == whole(1) { way } else { way * divisor };
        any([not(guard), equal(body, dividend)])
    }))
}

/// The theorem about leaving a triangle.
pub const TRIANGLE_EXIT: Theorem = Theorem {
    name: EXIT,
    source: "predicate::triangle_segment",
    claim: "a straight way from a point of the filled triangle to one that is not strictly inside meets a \
            side",
    proof: |prover| {
        let corners = unknown_corners();
        let target = corners[0].other("target");
        let weights = ["p", "q", "r"].map(Term::fresh);
        let places = [target, corners[0], corners[1], corners[2]];
        let inside = answer(Part::StrictlyInside, &terms::<8>(&places, &[]));
        let flat = equal(area(corners), whole(0));
        let mut using = Vec::new();
        let through = until_a_side(prover, corners, (target, inside.clone()), weights, &mut using);
        let lying = on_a_side(prover, corners, weights, &mut using);
        let mut both = |name: &str, a: Term, b: Term| {
            let (number, definition) =
                prover.define(name, &[(not(flat.clone()), a, whole(1)), (flat.clone(), b, whole(1))]);
            using.extend(definition);
            number
        };
        let way = both("way", through.0, whole(0));
        let s = both("s", through.1, lying);
        let same = prover.lemma("equal shares, equal places", |[fx, fy, tx, ty, way, other]| {
            let (from, to) = (v(fx, fy), v(tx, ty));
            let there = |way| from + (to - from).times(way);
            claim([equal(way, other)], there(way).is(there(other)))
        });
        let from = weighted(corners, weights);
        for other in [through.0, whole(0)] {
            using.push(same.at([from.x, from.y, target.x, target.y, way, other]));
        }
        let stay = prover.lemma("no way, no move", |[fx, fy, tx, ty]| {
            let (from, to) = (v(fx, fy), v(tx, ty));
            claim([], (from + (to - from).times(whole(0))).is(from))
        });
        using.push(stay.at([from.x, from.y, target.x, target.y]));
        let side = prover.lemma("equal shares, equal places of a side", |[ax, ay, bx, by, s, other]| {
            let at = |s| v(ax, ay) + (v(bx, by) - v(ax, ay)).times(s);
            claim([equal(s, other)], at(s).is(at(other)))
        });
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            for other in [through.1, lying] {
                using.push(side.at([a.x, a.y, b.x, b.y, s, other]));
            }
        }
        prover.establish(&LEAVES, inside, terms(&places, &weights), ([way, s], &using));
    },
};

/// A triangle that is not flat: the weights change linearly to those of the target until one is zero.
fn until_a_side(
    prover: &mut Prover<'_>,
    corners: [V; 3],
    (target, inside): (V, Fact),
    weights: [Term; 3],
    using: &mut Vec<Instance>,
) -> (Term, Term) {
    let (goal, definition) = weights_of(prover, target, corners);
    using.extend(definition);
    let places = [target, corners[0], corners[1], corners[2]];
    using.push(prover.by(&NOT_INSIDE, inside, terms(&places, &goal)).0);
    let bounds = prover.lemma("the way to zero is a share", |[p, z, way]| {
        claim([at_least_zero(p), is_exit(p, z, way)], share(way))
    });
    let stays = prover.lemma("before it the weight is not negative", |[p, z, way, part]| {
        let given = [at_least_zero(p), is_exit(p, z, way), at_least_zero(part), at_most(part, way)];
        claim(given, at_least_zero(p + part * (z - p)))
    });
    let leaves = prover.lemma("there it is zero", |[p, z, way, part]| {
        let given = [at_least_zero(p), is_exit(p, z, way), at_most(z, whole(0)), equal(part, way)];
        claim(given, equal(p + part * (z - p), whole(0)))
    });
    let ways: [Term; 3] = std::array::from_fn(|i| {
        let (way, definition) = prover.define("way", &exit_cases(weights[i], goal[i]));
        using.extend(definition);
        using.push(bounds.at([weights[i], goal[i], way]));
        way
    });
    let [p, q, r] = ways;
    let (part, definition) = prover.define(
        "part",
        &[
            (all([at_most(p, q), at_most(p, r)]), p, whole(1)),
            (all([less(q, p), at_most(q, r)]), q, whole(1)),
            (all([less(r, p), less(r, q)]), r, whole(1)),
        ],
    );
    using.extend(definition);
    for i in 0..3 {
        using.push(stays.at([weights[i], goal[i], ways[i], part]));
        using.push(leaves.at([weights[i], goal[i], ways[i], part]));
    }
    let sum = prover.lemma("weights on the way add up", |[p, q, r, x, y, z, part]| {
        let now = |p: Term, x: Term| p + part * (x - p);
        claim([sum_is_one([p, q, r]), sum_is_one([x, y, z])], sum_is_one([now(p, x), now(q, y), now(r, z)]))
    });
    let [p, q, r] = weights;
    let [x, y, z] = goal;
    using.push(sum.at([p, q, r, x, y, z, part]));
    let s = on_the_side_met(prover, corners, target, (weights, goal, part), using);
    (part, s)
}

/// The share of the side whose opposite weight is zero at this part of the way.
fn on_the_side_met(
    prover: &mut Prover<'_>,
    corners: [V; 3],
    target: V,
    (weights, goal, part): ([Term; 3], [Term; 3], Term),
    using: &mut Vec<Instance>,
) -> Term {
    let now: [Term; 3] = std::array::from_fn(|i| weights[i] + part * (goal[i] - weights[i]));
    let ([p, q, r], [x, y, z]) = (weights, goal);
    let zero = |i: usize| equal(now[i], whole(0));
    let (s, definition) = prover.define(
        "s",
        &[
            (zero(2), now[1], whole(1)),
            (all([not(zero(2)), zero(0)]), now[2], whole(1)),
            (all([not(zero(2)), not(zero(0)), zero(1)]), now[0], whole(1)),
        ],
    );
    using.extend(definition);
    let side = prover.lemma("a weight of zero is a side", |[a, b, c, p, q, r, t, x, y, z, part, s]| {
        let (from, now) = (p * a + q * b + r * c, |p: Term, x: Term| p + part * (x - p));
        let (p1, q1, r1) = (now(p, x), now(q, y), now(r, z));
        let there = from + part * (t - from);
        let case = |gone: Term, share: Term, from: Term, to: Term| {
            any([not(all([equal(gone, whole(0)), equal(s, share)])), equal(there, from + s * (to - from))])
        };
        let given = [equal(t, x * a + y * b + z * c), sum_is_one([p1, q1, r1])];
        claim(given, all([case(r1, q1, a, b), case(p1, r1, b, c), case(q1, p1, c, a)]))
    });
    for axis in [|v: V| v.x, |v: V| v.y] {
        let [a, b, c] = corners.map(axis);
        using.push(side.at([a, b, c, p, q, r, axis(target), x, y, z, part, s]));
    }
    s
}

/// A flat triangle is the union of its sides. Returns the share on the side where the point lies.
fn on_a_side(
    prover: &mut Prover<'_>,
    corners: [V; 3],
    [p, q, r]: [Term; 3],
    using: &mut Vec<Instance>,
) -> Term {
    let (zero, one) = (whole(0), whole(1));
    let (u, w) = (corners[1] - corners[0], corners[2] - corners[0]);
    let point = equal(u.norm_2(), zero);
    let (k, definition) = prover.define("k", &[(not(point.clone()), u.dot(w), u.norm_2())]);
    using.extend(definition);
    // From the first corner the second lies at 1, the third at k, and the point at x.
    let x = q + r * k;
    let guard = |fact: Fact| all([not(point.clone()), fact]);
    let (s, definition) = prover.define(
        "s",
        &[
            (point.clone(), one - r, one),
            (guard(all([at_most(zero, k), at_most(k, one)])), x, one),
            (guard(less(one, k)), k - x, k),
            (guard(less(k, zero)), one - x, one - k),
        ],
    );
    using.extend(definition);
    let lemma = prover.lemma("a point of a flat triangle lies on a side", |[p, q, r, k, s]| {
        let (zero, one) = (whole(0), whole(1));
        let x = q + r * k;
        let case = |guard: Fact, fact: Fact| any([not(guard), all([share(s), fact])]);
        let facts = [
            case(all([at_most(zero, k), at_most(k, one), equal(s, x)]), equal(x, s)),
            case(all([less(one, k), equal(s * k, k - x)]), equal(x, k - s * k)),
            case(all([less(k, zero), equal(s * (one - k), one - x)]), equal(x, one + s * (k - one))),
        ];
        claim([are_weights([p, q, r])], all(facts))
    });
    using.push(lemma.at([p, q, r, k, s]));
    let multiple = prover.lemma("the third corner of a flat triangle", |[ux, uy, wx, wy, k]| {
        let (u, w) = (v(ux, uy), v(wx, wy));
        let given =
            [equal(u.cross(w), whole(0)), not(equal(u.norm_2(), whole(0))), equal(k * u.norm_2(), u.dot(w))];
        claim(given, w.is(u.times(k)))
    });
    using.push(multiple.at([u.x, u.y, w.x, w.y, k]));
    let none = prover.lemma("a side of no length", |[ux, uy]| {
        claim([equal(v(ux, uy).norm_2(), whole(0))], v(ux, uy).is_zero())
    });
    using.push(none.at([u.x, u.y]));
    let place = prover.lemma("where it lies", |[a, b, c, p, q, r, k, s]| {
        let (one, x, at) = (whole(1), q + r * k, p * a + q * b + r * c);
        let on = |from: Term, to: Term| equal(at, from + s * (to - from));
        let case = |guard: Fact, then: Fact| any([not(guard), then]);
        let flat = equal(c - a, k * (b - a));
        let facts = [
            case(all([equal(b - a, whole(0)), equal(s, one - r)]), on(c, a)),
            case(all([flat.clone(), equal(x, s)]), on(a, b)),
            case(all([flat.clone(), equal(x, k - s * k)]), on(c, a)),
            case(all([flat, equal(x, one + s * (k - one))]), on(b, c)),
        ];
        claim([sum_is_one([p, q, r])], all(facts))
    });
    for axis in [|v: V| v.x, |v: V| v.y] {
        let [a, b, c] = corners.map(axis);
        using.push(place.at([a, b, c, p, q, r, k, s]));
    }
    s
}

/// The point of the side from corner `i` to the next at `s`.
fn on_side(corners: [V; 3], i: usize, s: Term) -> V {
    let (from, to) = (corners[i], corners[(i + 1) % 3]);
    from + (to - from).times(s)
}

//! Triangles: strictly inside, and triangle–segment.

use keepout_kernel::exact::predicate::{strictly_inside, triangle_segment};

use super::plane::{V, between_segments, share, terms, v};
use super::segments;
use crate::smt::explore::{Part, answer, explore};
use crate::smt::fact::{Fact, all, any, at_most, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Prover, at_least_zero, positive};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

const INSIDE: &str = "strictly_inside";
const EXIT: &str = "triangle_exit";
const TRIANGLE: &str = "triangle_segment";

/// The point with these weights of the corners.
fn weighted([a, b, c]: [V; 3], [p, q, r]: [Term; 3]) -> V {
    a.times(p) + b.times(q) + c.times(r)
}

/// Weights of a point of the triangle.
fn are_weights([p, q, r]: [Term; 3]) -> Fact {
    all([at_least_zero(p), at_least_zero(q), at_least_zero(r), sum_is_one([p, q, r])])
}

fn sum_is_one([p, q, r]: [Term; 3]) -> Fact {
    equal(p + q + r, whole(1))
}

fn area([a, b, c]: [V; 3]) -> Term {
    (b - a).cross(c - a)
}

/// The point of the side from corner `i` to the next at `s`.
fn on_side(corners: [V; 3], i: usize, s: Term) -> V {
    let (from, to) = (corners[i], corners[(i + 1) % 3]);
    from + (to - from).times(s)
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

/// The weights of a point, when the triangle is not flat.
fn weights_of(prover: &mut Prover<'_>, p: V, [a, b, c]: [V; 3]) -> ([Term; 3], Vec<Instance>) {
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

fn unknown_corners() -> [V; 3] {
    let a = V::unknown("a");
    [a, a.other("b"), a.other("c")]
}

/// Strictly inside.
pub const STRICTLY_INSIDE: Theorem = Theorem {
    name: INSIDE,
    source: "predicate::strictly_inside",
    claim: "yes exactly when the point is a mean of the corners with positive weights, and the triangle is not flat",
    proof: |prover| {
        let corners = unknown_corners();
        let [a, b, c] = corners;
        let p = a.other("p");
        let paths =
            explore(&[], &[], || strictly_inside::<Symbolic>(p.place(), a.place(), b.place(), c.place()));
        let (weights, definition) = weights_of(prover, p, corners);
        prover.contract(&IS_INSIDE, &paths, terms(&[p, a, b, c], &[]), (weights, &definition));
        // Any weights of the point: it is where they put it.
        let free = [Term::fresh("q"), Term::fresh("r"), Term::fresh("s")];
        prover.contract(&NOT_INSIDE, &paths, terms(&[p, a, b, c], &free), ([], &[]));
    },
};

/// On the way from a point of the triangle to one that is not strictly inside is a point of a side.
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

/// What holds of the share of the way from weight `p` to weight `z` after which it is zero; 1 when `z` is positive.
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

/// Leaving a triangle.
pub const TRIANGLE_EXIT: Theorem = Theorem {
    name: EXIT,
    source: "predicate::triangle_segment",
    claim: "a way from a point of the filled triangle to one that is not strictly inside meets a side",
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

/// A triangle that is not flat: the weights run straight to those of the target until one is zero.
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
    let now: [Term; 3] = std::array::from_fn(|i| weights[i] + part * (goal[i] - weights[i]));
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
    // The share of the side whose opposite weight is zero.
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
    (part, s)
}

/// A flat triangle is the union of its sides: the share on that side where the point lies.
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

/// Near: some point of it is.
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
    claim: "near exactly when a point of the filled triangle is within r of a point of the segment, for r ≥ 0",
    proof: |prover| {
        let corners = unknown_corners();
        let [d, e] = ["d", "e"].map(|name| corners[0].other(name));
        let [r, t] = ["r", "t"].map(Term::fresh);
        let weights = ["p", "q", "s"].map(Term::fresh);
        let parts = [Part::SegmentSegment, Part::StrictlyInside];
        let paths = explore(&[], &parts, || {
            let corners = corners.map(V::place);
            !triangle_segment::<Symbolic>(corners, d.place(), e.place(), Scalar(r)).is_clear()
        });
        let sides: [[Term; 9]; 3] =
            std::array::from_fn(|i| terms(&[corners[i], corners[(i + 1) % 3], d, e], &[r]));
        let near_side = |i: usize| answer(Part::SegmentSegment, &sides[i]);
        let is_inside =
            |p: V| answer(Part::StrictlyInside, &terms::<8>(&[p, corners[0], corners[1], corners[2]], &[]));
        let triple = |p: V| [p, corners[0], corners[1], corners[2]];

        // Clear. From a point of the triangle toward one of the segment, and from there toward its beginning.
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
                all.try_into().expect("nine and two")
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

        // Near. A point of a side, or the beginning of the segment.
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
            let same = crate::smt::fact::Claim { given: equal_numbers, then };
            using.push(prover.fact("equal weights, equal distances", &same));
        }
        let numbers = terms(&[corners[0], corners[1], corners[2], d, e], &[r]);
        prover.by_parts(&NEAR, &paths, numbers, ([weights[0], weights[1], weights[2], t], &using));
    },
};

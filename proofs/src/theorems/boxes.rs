//! Boxes: box–point, boxes beside a line, and the boxes that an index may skip.
//!
//! Evidence for SR-03.

use keepout_kernel::exact::predicate::{Orientation, box_point, box_side};

use super::plane::{V, share, terms, to_segment, v};
use crate::smt::explore::explore;
use crate::smt::fact::{Fact, all, any, at_most, between, claim, equal, less, not};
use crate::smt::prover::{Contract, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

const BOX_POINT_NAME: &str = "box_point";

/// Clear: no point of the box is within r.
pub const CLEAR: Contract<9, 0> = Contract {
    theorem: BOX_POINT_NAME,
    name: "clear: no point of the box is within r",
    statement: |near, [lx, ly, hx, hy, px, py, r, qx, qy], []| {
        let inside = v(qx, qy).is_in(v(lx, ly), v(hx, hy));
        let distance_2 = (v(qx, qy) - v(px, py)).norm_2();
        claim([not(near), at_least_zero(r), inside], less(square(r), distance_2))
    },
};

/// Near: some point of the box is within r.
pub const NEAR: Contract<7, 2> = Contract {
    theorem: BOX_POINT_NAME,
    name: "near: some point of the box is within r",
    statement: |near, [lx, ly, hx, hy, px, py, r], [qx, qy]| {
        let (low, high, q) = (v(lx, ly), v(hx, hy), v(qx, qy));
        let sound = [at_most(lx, hx), at_most(ly, hy)];
        let distance_2 = (q - v(px, py)).norm_2();
        claim([near, at_least_zero(r), all(sound)], all([q.is_in(low, high), at_most(distance_2, square(r))]))
    },
};

/// Box–point.
pub const BOX_POINT: Theorem = Theorem {
    name: BOX_POINT_NAME,
    source: "predicate::box_point",
    claim: "near exactly when a point of the closed box is within r of the point, for r ≥ 0",
    proof: |prover| {
        let low = V::unknown("low");
        let (high, p) = (low.other("high"), low.other("p"));
        let (q, r) = (low.other("q"), Term::fresh("r"));
        let ordered = [(low.x, high.x), (low.y, high.y)];
        let paths = explore(&ordered, &[], || {
            !box_point::<Symbolic>(low.place(), high.place(), p.place(), Scalar(r)).is_clear()
        });
        let numbers = [low.x, low.y, high.x, high.y, p.x, p.y, r, q.x, q.y];
        prover.contract(&CLEAR, &paths, numbers, ([], &[]));
        let mut using = Vec::new();
        let mut clamped = |low: Term, high: Term, c: Term| {
            let (foot, definition) = prover.define(
                "foot",
                &[
                    (less(c, low), low, whole(1)),
                    (all([at_most(low, c), less(high, c)]), high, whole(1)),
                    (between(low, c, high), c, whole(1)),
                ],
            );
            using.extend(definition);
            foot
        };
        let foot = [clamped(low.x, high.x, p.x), clamped(low.y, high.y, p.y)];
        let [lx, ly, hx, hy, px, py, r, ..] = numbers;
        prover.contract(&NEAR, &paths, [lx, ly, hx, hy, px, py, r], (foot, &using));
    },
};

const SIDE: &str = "box_side";

/// Right: the whole box is strictly to the right.
pub const RIGHT: Contract<10, 0> = Contract {
    theorem: SIDE,
    name: "right: every point of the box is strictly to the right of the line",
    statement: |right, [lx, ly, hx, hy, px, py, qx, qy, x, y], []| {
        let (p, q, x) = (v(px, py), v(qx, qy), v(x, y));
        let inside = x.is_in(v(lx, ly), v(hx, hy));
        claim([right, inside], less((q - p).cross(x - p), whole(0)))
    },
};

/// The theorem about boxes on one side of a line.
pub const BOX_SIDE: Theorem = Theorem {
    name: SIDE,
    source: "predicate::box_side, Window::side_of, index::query (boxes left out along a motion)",
    claim: "left or right only when the whole box lies strictly on that side of the line; so a box that, \
            grown by T, is on one side of the line holds no point within T of it",
    proof: |prover| {
        let low = V::unknown("low");
        let [high, p, q, x] = ["high", "p", "q", "x"].map(|name| low.other(name));
        let side = || box_side::<Symbolic>(low.place(), high.place(), p.place(), q.place());
        // Products of a component with a value between bounds.
        let term = prover.lemma("a product is between those of the bounds", |[d, low, c, high]| {
            let least = any([at_most(d * low, d * c), at_most(d * high, d * c)]);
            let most = any([at_most(d * c, d * low), at_most(d * c, d * high)]);
            claim([between(low, c, high)], all([least, most]))
        });
        let d = q - p;
        let using = [
            term.at([d.x, low.y - p.y, x.y - p.y, high.y - p.y]),
            term.at([d.y, low.x - p.x, x.x - p.x, high.x - p.x]),
        ];
        let inside = x.is_in(low, high);
        prover.on_paths_by("strictly on that side", &explore(&[], &[], side), &using, |&side| {
            let off = d.cross(x - p);
            let then = match side {
                Orientation::Left => less(whole(0), off),
                Orientation::Right => less(off, whole(0)),
                Orientation::On => Fact::True,
            };
            claim([inside.clone()], then)
        });
        let right = explore(&[], &[], || side() == Orientation::Right);
        prover.contract(&RIGHT, &right, terms(&[low, high, p, q, x], &[]), ([], &using));
        prover.lemma("a point within T of a box is in the box grown by T", |[x, y, t, dx, dy, lx, hx]| {
            let given = [
                between(lx, x, hx),
                at_least_zero(t),
                at_most(v(dx, dy).norm_2(), square(t)),
                equal(y, x + dx),
            ];
            claim(given, between(lx - t, y, hx + t))
        });
        prover.lemma("points of the motion are on its line", |[px, py, qx, qy, t]| {
            let (p, d) = (v(px, py), v(qx, qy) - v(px, py));
            let at = p + d.times(t);
            claim([], equal(d.x * (at.y - py) - d.y * (at.x - px), whole(0)))
        });
    },
};

/// The theorem about boxes that a query may skip.
pub const PRUNING: Theorem = Theorem {
    name: "pruning",
    source: "Window::of, including, grown, meets; CheckedIndex::search, visit",
    claim: "let s be the chord-error bound of a chord within T + s of a point of a shape: the chord's \
            box, grown by s, meets the shape's box grown by T. So a box that does not meet that one holds \
            no such chord",
    proof: |prover| {
        // In each coordinate: a point c of a chord between its ends a and b, and a point x of a shape in
        // its box from low to high.
        prover.lemma("a distance bounds its components", |[dx, dy, r]| {
            let given = [at_least_zero(r), at_most(v(dx, dy).norm_2(), square(r))];
            claim(given, all([between(-r, dx, r), between(-r, dy, r)]))
        });
        prover.lemma("a point of a chord is in its box", |[a, b, s]| {
            let c = a + (b - a) * s;
            claim([share(s)], any([between(a, c, b), between(b, c, a)]))
        });
        prover.lemma("boxes meet", |[a, b, c, x, low, high, t, chord_error]| {
            let given = [
                any([between(a, c, b), between(b, c, a)]),
                between(low, x, high),
                between(-(t + chord_error), c - x, t + chord_error),
                at_least_zero(t),
                at_least_zero(chord_error),
            ];
            let meets = |least: Term, most: Term| {
                all([at_most(least - chord_error, high + t), at_most(low - t, most + chord_error)])
            };
            let of_chord = [(at_most(a, b), meets(a, b)), (less(b, a), meets(b, a))];
            claim(given, all(of_chord.map(|(order, meets)| any([not(order), meets]))))
        });
        prover.lemma(
            "a box that meets a part of another meets the other",
            |[low, high, inner, upper, least, most]| {
                let given =
                    [at_most(low, inner), at_most(upper, high), at_most(inner, most), at_most(least, upper)];
                claim(given, all([at_most(low, most), at_most(least, high)]))
            },
        );
        prover.lemma("a triangle's point is in its box", |[a, b, c, p, q, r, low, high]| {
            let bounds = all([a, b, c].map(|corner| between(low, corner, high)));
            let weights =
                all([at_least_zero(p), at_least_zero(q), at_least_zero(r), equal(p + q + r, whole(1))]);
            claim([bounds, weights], between(low, a * p + b * q + c * r, high))
        });
    },
};

/// The theorem that the points near a segment form a convex set.
pub const CONVEX: Theorem = Theorem {
    name: "near_is_convex",
    source: "Window::within_reach_of, index::cells (blocked squares), simplify::simplify",
    claim: "the points within r of a segment form a convex set: it holds a square with the square's \
            corners, and a chord with the chord's ends",
    proof: |prover| {
        let mean = prover.lemma("a mean of two short vectors is short", |[x, y, z, w, r, m]| {
            let (a, b) = (v(x, y), v(z, w));
            let given =
                [share(m), at_least_zero(r), at_most(a.norm_2(), square(r)), at_most(b.norm_2(), square(r))];
            claim(given, at_most((a + (b - a).times(m)).norm_2(), square(r)))
        });
        let (a, p) = (V::unknown("a"), V::unknown("p"));
        let (b, q) = (a.other("b"), p.other("q"));
        let [s, t, m, r] = ["s", "t", "m", "r"].map(Term::fresh);
        let (first, second) = (to_segment(p, a, b, s), to_segment(q, a, b, t));
        let at = p + (q - p).times(m);
        let share_there = s + (t - s) * m;
        let between_them = first + (second - first).times(m);
        let there = to_segment(at, a, b, share_there);
        let same =
            prover.fact("the mean of the ways is the way of the mean", &claim([], between_them.is(there)));
        let stays = prover.lemma("a mean of shares", |[s, t, m]| {
            claim([share(s), share(t), share(m)], share(s + (t - s) * m))
        });
        let squares = prover.lemma("equal vectors, equal squares", |[x, y, z, w]| {
            claim([v(x, y).is(v(z, w))], equal(v(x, y).norm_2(), v(z, w).norm_2()))
        });
        let using = [
            same,
            stays.at([s, t, m]),
            mean.at([first.x, first.y, second.x, second.y, r, m]),
            squares.at([between_them.x, between_them.y, there.x, there.y]),
        ];
        let given = [
            all([share(s), share(t), share(m)]),
            at_least_zero(r),
            at_most(first.norm_2(), square(r)),
            at_most(second.norm_2(), square(r)),
        ];
        let then = all([share(share_there), at_most(there.norm_2(), square(r))]);
        prover.glue("between two near points", &using, &claim(given, then));
        prover.lemma("a point of a box is a mean of means of its corners", |[lx, ly, hx, hy, x, y]| {
            // (h − l)·c = (h − c)·l + (c − l)·h in each coordinate: first along x, then along y.
            let of = |l: Term, c: Term, h: Term| equal((h - l) * c, (h - c) * l + (c - l) * h);
            claim([v(x, y).is_in(v(lx, ly), v(hx, hy))], all([of(lx, x, hx), of(ly, y, hy)]))
        });
    },
};

//! The guard's in-flight set: motions within a hull, and the fans over its sides.

use super::plane::{V, share, terms, v};
use crate::smt::fact::{Claim, all, any, at_most, between, claim, equal, less, not};
use crate::smt::prover::{at_least_zero, positive};
use crate::smt::run::Theorem;
use crate::smt::term::{Term, whole};

/// Most points of the in-flight set, as in the guard's `hull.rs`.
const POINTS_MAX: usize = 14;

fn total(numbers: &[Term]) -> Term {
    numbers.iter().skip(1).fold(numbers[0], |sum, &number| sum + number)
}

/// Convexity of the in-flight set.
pub const CONVEX_SET: Theorem = Theorem {
    name: "in_flight_is_convex",
    source: "executor: guard::in_flight (both shapes of motion)",
    claim: "a straight motion from a point of the hull of up to 14 points to one of them stays in the hull; and one whose axes run \
            apart stays in their box",
    proof: |prover| {
        let unknowns = |name: &str| -> Vec<Term> { (0..POINTS_MAX).map(|_| Term::fresh(name)).collect() };
        let (from, to, places) = (unknowns("from"), unknowns("to"), unknowns("place"));
        let way = Term::fresh("way");
        let mixed: Vec<Term> = from.iter().zip(&to).map(|(&a, &b)| a + way * (b - a)).collect();
        prover.lemma("weights on the way are not negative", |[a, b, way]| {
            claim([at_least_zero(a), at_least_zero(b), share(way)], at_least_zero(a + way * (b - a)))
        });
        let one = |weights: &[Term]| equal(total(weights), whole(1));
        let given = vec![one(&from), one(&to)];
        prover.prove("and add up to one", &Claim { given, then: one(&mixed) });
        let at = |weights: &[Term]| {
            let parts: Vec<Term> =
                weights.iter().zip(&places).map(|(&weight, &place)| weight * place).collect();
            total(&parts)
        };
        let there = at(&from) + way * (at(&to) - at(&from));
        prover.prove("they make the point of the motion", &claim([], equal(at(&mixed), there)));
        prover.lemma("a coordinate between two of a box stays in it", |[low, high, a, b, way]| {
            let given = [between(low, a, high), between(low, b, high), share(way)];
            claim(given, between(low, a + way * (b - a), high))
        });
    },
};

/// Fans cover the new hull.
pub const FANS_COVER: Theorem = Theorem {
    name: "fans_cover",
    source: "executor: guard::in_flight::admit_line, guard::hull",
    claim: "a point of the hull of a convex polygon and a new target is in the polygon, or in the triangle of a side and the target",
    proof: |prover| {
        // From a point Y of the polygon to X outside: `f` is the orientation of a side, not negative inside.
        prover.lemma("orientation is affine along a line", |[ax, ay, bx, by, yx, yy, xx, xy, way]| {
            let (a, b, inside, outside) = (v(ax, ay), v(bx, by), v(yx, yy), v(xx, xy));
            let f = |p: V| (b - a).cross(p - a);
            let there = inside + (outside - inside).times(way);
            claim([], equal(f(there), f(inside) + way * (f(outside) - f(inside))))
        });
        prover.lemma("at the first side that is reached no other was passed", |[y, x, way, first]| {
            // `way`: where this side is reached, when X is beyond it; `first`: the least of them all.
            let reached = any([not(less(x, whole(0))), all([equal(way * (y - x), y), at_most(first, way)])]);
            let given = [at_least_zero(y), share(first), reached];
            claim(given, at_least_zero(y + first * (x - y)))
        });
        prover.lemma("a side that is passed is reached on the way", |[y, x, way]| {
            claim(
                [at_least_zero(y), less(x, whole(0)), equal(way * (y - x), y)],
                all([share(way), equal(y + way * (x - y), whole(0))]),
            )
        });
        prover.lemma("and has a place of its own", |[y, x]| {
            claim([at_least_zero(y), less(x, whole(0))], not(equal(y - x, whole(0))))
        });
        // Corners g, a, b, h turn left: on the side's line, and inside the sides next to it, is on the side.
        let a = V::unknown("a");
        let [g, b, h, p] = ["g", "b", "h", "p"].map(|name| a.other(name));
        let left = |o: V, d: V, x: V| (d - o).cross(x - o);
        let u = b - a;
        let (s, using) = prover.define("s", &[(not(equal(u.norm_2(), whole(0))), u.dot(p - a), u.norm_2())]);
        let turns = [positive(left(g, a, b)), positive(left(a, b, h))];
        let distinct = claim([turns[0].clone()], not(equal(u.norm_2(), whole(0))));
        let distinct = prover.fact("corners that turn are distinct", &distinct);
        let on_line = prover.lemma("a point of a line", |[ux, uy, wx, wy, s]| {
            let (u, w) = (v(ux, uy), v(wx, wy));
            let given = [
                equal(u.cross(w), whole(0)),
                not(equal(u.norm_2(), whole(0))),
                equal(s * u.norm_2(), u.dot(w)),
            ];
            claim(given, w.is(u.times(s)))
        });
        let w = p - a;
        let linear =
            prover.lemma("the next sides see how far along it is", |[gx, gy, ux, uy, hx, hy, wx, wy, s]| {
                // From a: the corner before is g, the one after b is h, the point is w = s·u.
                let (g, u, h, w) = (v(gx, gy), v(ux, uy), v(hx, hy), v(wx, wy));
                let before = equal(
                    (v(whole(0), whole(0)) - g).cross(w - g),
                    s * (v(whole(0), whole(0)) - g).cross(u - g),
                );
                let after = equal((h - u).cross(w - u), (whole(1) - s) * u.cross(h));
                claim([w.is(u.times(s))], all([before, after]))
            });
        let relative = |x: V| x - a;
        let origin = v(whole(0), whole(0));
        let (g0, h0) = (relative(g), relative(h));
        let same = [
            equal(left(g, a, p), (origin - g0).cross(w - g0)),
            equal(left(g, a, b), (origin - g0).cross(u - g0)),
            equal(left(b, h, p), (h0 - u).cross(w - u)),
            equal(left(a, b, h), u.cross(h0)),
            equal(left(a, b, p), u.cross(w)),
        ];
        let same = prover.fact("seen from a", &claim([], all(same)));
        let sign = prover.lemma("a product that is not negative", |[s, f]| {
            claim([positive(f), at_least_zero(s * f)], at_least_zero(s))
        });
        let mut steps = vec![
            distinct,
            on_line.at([u.x, u.y, w.x, w.y, s]),
            linear.at(terms(&[g0, u, h0, w], &[s])),
            same,
            sign.at([s, (origin - g0).cross(u - g0)]),
            sign.at([whole(1) - s, u.cross(h0)]),
        ];
        steps.extend(using);
        let given = [
            turns[0].clone(),
            turns[1].clone(),
            equal(left(a, b, p), whole(0)),
            at_least_zero(left(g, a, p)),
            at_least_zero(left(b, h, p)),
        ];
        prover.glue("a point of a side", &steps, &claim(given, all([share(s), w.is(u.times(s))])));
        // X lies between that point of the side and the target, so in their triangle.
        prover.define("rest", &{
            let (near, far) = (Term::fresh("near"), Term::fresh("far"));
            [
                (less(near, whole(1)), far - near, whole(1) - near),
                (not(less(near, whole(1))), whole(0), whole(1)),
            ]
        });
        prover.lemma("beyond the side toward the target", |[y, t, near, far, rest]| {
            let at = |way: Term| y + way * (t - y);
            let given = [
                share(near),
                share(far),
                at_most(near, far),
                any([not(less(near, whole(1))), equal(rest * (whole(1) - near), far - near)]),
                any([less(near, whole(1)), equal(rest, whole(0))]),
            ];
            claim(given, all([share(rest), equal(at(far), at(near) + rest * (t - at(near)))]))
        });
        prover.lemma("is in the triangle", |[a, b, t, s, rest]| {
            let on_side = a + s * (b - a);
            let left = whole(1) - rest;
            let weights = [left * (whole(1) - s), left * s, rest];
            let mean = (weights[0] * a + weights[1] * b) + weights[2] * t;
            let is_mean = equal(on_side + rest * (t - on_side), mean);
            let sum = equal((weights[0] + weights[1]) + weights[2], whole(1));
            claim([share(s), share(rest)], all([is_mean, sum, all(weights.map(at_least_zero))]))
        });
    },
};

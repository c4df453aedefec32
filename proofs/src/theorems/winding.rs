//! Sides: crossings of a ray, the triangle, and the reason why a clear motion does not change sides.
//!
//! Evidence for SR-04.

use keepout_kernel::exact::predicate::{crosses_properly, ray_crosses, strictly_inside};

use super::plane::{V, share, to_segment};
use crate::smt::explore::{explore, outcome_is};
use crate::smt::fact::{Fact, all, any, claim, equal, less, not, same};
use crate::smt::prover::Prover;
use crate::smt::run::Theorem;
use crate::smt::symbolic::Symbolic;
use crate::smt::term::{Term, whole};

fn crosses(prover: &mut Prover<'_>, p: V, a: V, b: V) -> Fact {
    let paths = explore(&[], &[], || ray_crosses::<Symbolic>(p.place(), a.place(), b.place()));
    prover.ran(paths.len());
    outcome_is(&paths, &true)
}

pub fn odd(a: Fact, b: Fact) -> Fact {
    not(same(&a, &b))
}

/// Whether `x` is a point of the segment, by its position.
fn is_on(x: V, a: V, b: V) -> Fact {
    let between = at_most_zero((x - a).dot(x - b));
    all([equal((b - a).cross(x - a), whole(0)), between])
}

fn at_most_zero(a: Term) -> Fact {
    not(less(whole(0), a))
}

/// The theorem about the parity of a triangle.
pub const TRIANGLE_PARITY: Theorem = Theorem {
    name: "ray_crosses_triangle",
    source: "predicate::ray_crosses, Ring::crossing_parity_is_odd",
    claim: "for a point on no side of a triangle, its ray crosses an odd number of sides exactly when the \
            point is inside",
    proof: |prover: &mut Prover<'_>| {
        let p = V::unknown("p");
        let [a, b, c] = ["a", "b", "c"].map(|name| p.other(name));
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[from, to]| crosses(prover, p, from, to));
        let count = odd(odd(ab, bc), ca);
        let paths =
            explore(&[], &[], || strictly_inside::<Symbolic>(p.place(), a.place(), b.place(), c.place()));
        let on_side = any([is_on(p, a, b), is_on(p, b, c), is_on(p, c, a)]);
        prover.on_paths("parity", &paths, |&inside| {
            let then = if inside { count.clone() } else { not(count.clone()) };
            claim([not(on_side.clone())], then)
        });
    },
};

/// The theorem about the parity of a ring.
pub const RING_PARITY: Theorem = Theorem {
    name: "ray_crosses_ring",
    source: "predicate::ray_crosses, Ring::crossing_parity_is_odd, CheckedIndex::locate, FreePoint",
    claim: "a motion that touches no edge of a ring does not change the parity: an edge's crossing \
            changes only when the ray sweeps over exactly one of its corners, and in a closed ring every \
            corner belongs to two edges. A ray that begins far to the right crosses no edge",
    proof: |prover| {
        let p = V::unknown("p");
        let [q, a, b] = ["q", "a", "b"].map(|name| p.other(name));
        // The ray sweeps over x when x lies to the right of the motion, at a height between its ends.
        let above = |x: V, p: V| less(p.y, x.y);
        let swept = |x: V, low: V, high: V| {
            let right = less((high - low).cross(x - low), whole(0));
            all([odd(above(x, p), above(x, q)), right])
        };
        let touches = touching(p, q, a, b);
        let change = odd(crosses(prover, p, a, b), crosses(prover, q, a, b));
        for (name, case, low, high) in
            [("up", less(p.y, q.y), p, q), ("down", less(q.y, p.y), q, p), ("level", equal(p.y, q.y), p, q)]
        {
            let corners = odd(swept(a, low, high), swept(b, low, high));
            let given = [case, not(touches.clone())];
            let name = format!("an edge and a motion that do not touch, {name}");
            prover.prove(&name, &claim(given, same(&change, &corners)));
        }
        let right = [less(a.x, p.x), less(b.x, p.x)];
        let at_right = crosses(prover, p, a, b);
        prover.prove("to the right of an edge", &claim(right, not(at_right)));
        // Segments that touch have a common point, so their distance is not more than any r.
        let (x, u) = (q, b - a);
        let (foot, definition) =
            prover.define("foot", &[(not(equal(u.norm_2(), whole(0))), (x - a).dot(u), u.norm_2())]);
        let on = all([is_on(x, a, b), not(equal(u.norm_2(), whole(0)))]);
        let then = all([share(foot), to_segment(x, a, b, foot).is_zero()]);
        prover.follows("an end on the other segment is a common point", &definition, &claim([on], then));
        let on = all([is_on(x, a, b), equal(u.norm_2(), whole(0))]);
        prover.prove("or on a segment of no length", &claim([on], x.is(a)));
        let paths = explore(&[], &[], || {
            let [p, q, a, b] = [p, q, a, b].map(V::place);
            crosses_properly::<Symbolic>(p, q, a, b)
        });
        let is_crossing = same(&outcome_is(&paths, &true), &crossing(p, q, a, b));
        prover.prove("the crossing agrees with `crosses_properly`", &claim([], is_crossing));
    },
};

/// Whether two segments have a common point, by orientations: an end of one is on the other, or the ends
/// lie on both sides.
fn touching(p: V, q: V, a: V, b: V) -> Fact {
    any([is_on(a, p, q), is_on(b, p, q), is_on(p, a, b), is_on(q, a, b), crossing(p, q, a, b)])
}

fn crossing(p: V, q: V, a: V, b: V) -> Fact {
    let side = |o: V, d: V, x: V| (d - o).cross(x - o);
    let opposite = |m: Term, n: Term| {
        let zero = whole(0);
        any([all([less(m, zero), less(zero, n)]), all([less(zero, m), less(n, zero)])])
    };
    all([opposite(side(p, q, a), side(p, q, b)), opposite(side(a, b, p), side(a, b, q))])
}

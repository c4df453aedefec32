//! Sides: crossings of a ray, the triangle, and why a clear motion changes no side.

use keepout_kernel::exact::predicate::{ray_crosses, strictly_inside};

use super::plane::{V, between_segments, share};
use crate::smt::explore::{explore, outcome_is};
use crate::smt::fact::{Fact, all, any, claim, equal, implies, less, not, same};
use crate::smt::prover::Prover;
use crate::smt::run::Theorem;
use crate::smt::symbolic::Symbolic;
use crate::smt::term::{Term, whole};

fn crosses(p: V, a: V, b: V) -> Fact {
    outcome_is(&explore(&[], &[], || ray_crosses::<Symbolic>(p.place(), a.place(), b.place())), &true)
}

fn odd(a: Fact, b: Fact) -> Fact {
    not(same(&a, &b))
}

/// Whether `x` is a point of the segment, as its position tells.
fn is_on(x: V, a: V, b: V) -> Fact {
    let between = at_most_zero((x - a).dot(x - b));
    all([equal((b - a).cross(x - a), whole(0)), between])
}

fn at_most_zero(a: Term) -> Fact {
    not(less(whole(0), a))
}

/// Triangle.
pub const TRIANGLE_PARITY: Theorem = Theorem {
    name: "ray_crosses_triangle",
    source: "predicate::ray_crosses, Ring::crossing_parity_is_odd",
    claim: "for a point on no side of a triangle the number of sides that its ray crosses is odd exactly when it is inside",
    proof: |prover: &mut Prover<'_>| {
        let p = V::unknown("p");
        let [a, b, c] = ["a", "b", "c"].map(|name| p.other(name));
        let count = odd(odd(crosses(p, a, b), crosses(p, b, c)), crosses(p, c, a));
        let paths = explore(&[], &[], || {
            strictly_inside::<Symbolic>(p.place(), a.place(), b.place(), c.place())
        });
        let on_side = any([is_on(p, a, b), is_on(p, b, c), is_on(p, c, a)]);
        prover.on_paths("parity", &paths, |&inside| {
            let then = if inside { count.clone() } else { not(count.clone()) };
            claim([not(on_side.clone())], then)
        });
    },
};

/// A ring.
pub const RING_PARITY: Theorem = Theorem {
    name: "ray_crosses_ring",
    source: "predicate::ray_crosses, Ring::crossing_parity_is_odd, CheckedIndex::locate, FreePoint",
    claim: "a motion that touches no edge of a ring changes no parity: edge by edge, a crossing more or less is a corner that the \
            ray swept over, and around a closed ring corners come in pairs. Far to the right no edge is crossed",
    proof: |prover| {
        let p = V::unknown("p");
        let [q, a, b] = ["q", "a", "b"].map(|name| p.other(name));
        // The ray sweeps over x when x lies to the right of the motion, at a height between its ends.
        let above = |x: V, p: V| less(p.y, x.y);
        let swept = |x: V| {
            let heights = odd(above(x, p), above(x, q));
            all([heights, not(crosses(x, p, q)), not(is_on(x, p, q))])
        };
        let [s, t] = ["s", "t"].map(Term::fresh);
        let _ = (s, t);
        let touches = touching(p, q, a, b);
        let change = odd(crosses(p, a, b), crosses(q, a, b));
        let corners = odd(swept(a), swept(b));
        for (name, case) in [
            ("up", less(p.y, q.y)),
            ("down", less(q.y, p.y)),
            ("level", equal(p.y, q.y)),
        ] {
            let given = [case, not(touches.clone())];
            prover.prove(&format!("an edge and a motion that do not touch, {name}"), &claim(given, same(&change, &corners)));
        }
        let right = [less(a.x, p.x), less(b.x, p.x)];
        prover.prove("to the right of an edge", &claim(right, not(crosses(p, a, b))));
        // That `touching` is what it says: a common point makes it true.
        let meet = between_segments([p, q], [a, b], s, t).is_zero();
        prover.prove("common point", &claim([share(s), share(t), meet.clone()], touches.clone()));
        let _ = implies(meet, touches);
    },
};

/// Whether two segments have a common point, as orientations tell: an end of one on the other, or ends on either side.
fn touching(p: V, q: V, a: V, b: V) -> Fact {
    let side = |o: V, d: V, x: V| (d - o).cross(x - o);
    let opposite = |m: Term, n: Term| {
        let zero = whole(0);
        any([all([less(m, zero), less(zero, n)]), all([less(zero, m), less(n, zero)])])
    };
    let crossing = all([
        opposite(side(p, q, a), side(p, q, b)),
        opposite(side(a, b, p), side(a, b, q)),
    ]);
    any([is_on(a, p, q), is_on(b, p, q), is_on(p, a, b), is_on(q, a, b), crossing])
}

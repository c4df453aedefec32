//! The guard's in-flight set: motions within a hull, and the hull as one polygon.
//!
//! Evidence for SR-07.

use super::beyond::off;
use super::convex::{CONVEX_HOLDS, CONVEX_NEAR_SEGMENT};
use super::plane::{share, v};
use crate::smt::fact::{Implication, all, between, claim, equal, less, not, same};
use crate::smt::prover::at_least_zero;
use crate::smt::run::Theorem;
use crate::smt::term::{Term, whole};

/// Largest number of points of the in-flight set, as in the guard's `hull.rs`.
const POINTS_MAX: usize = 14;

fn total(numbers: &[Term]) -> Term {
    numbers.iter().skip(1).fold(numbers[0], |sum, &number| sum + number)
}

/// The theorem about the convexity of the in-flight set.
pub const CONVEX_SET: Theorem = Theorem {
    name: "in_flight_is_convex",
    source: "executor: guard::in_flight (both shapes of motion)",
    claim: "a straight motion from a point of the hull of up to 14 points to one of the points stays in \
            the hull; a motion of non-interpolated axes stays in their box",
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
        prover.prove("and add up to one", &Implication { given, then: one(&mixed) });
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

/// The theorem that one polygon query covers the new hull.
pub const HULL_POLYGON: Theorem = Theorem {
    name: "hull_is_one_polygon",
    source: "executor: guard::in_flight::admit_line, guard::hull::Hull::holds; ProhibitedRegion::polygon",
    claim: "the polygon holds every point that the hull reports as held, and the straight way between two \
            such points; so a polygon that holds the set and the target, and to which no edge is near \
            (`convex_near_segment`), holds every motion that the machine can make, on the side of the \
            confirmed position",
    proof: |prover| {
        prover.needs(CONVEX_HOLDS.name);
        prover.needs(CONVEX_NEAR_SEGMENT.name);
        // Three corners or more turn left at each, so the box check is not needed (`convex_holds`, corners
        // not on a line).
        prover.lemma("corners that turn left are not on a line", |[ux, uy, hx, hy, wx, wy]| {
            let (u, h, w) = (v(ux, uy), v(hx, hy), v(wx, wy));
            let on_line = all([equal(u.cross(w), whole(0)), equal(h.cross(w), whole(0))]);
            claim([less(whole(0), u.cross(h)), not(w.is_zero())], not(on_line))
        });
        prover.lemma(
            "two corners: a point right of neither side is on the line",
            |[ax, ay, bx, by, px, py]| {
                let (a, b, p) = (v(ax, ay), v(bx, by), v(px, py));
                let [there, back] = [off([a, b], p), off([b, a], p)];
                let neither = all([at_least_zero(there), at_least_zero(back)]);
                claim([], same(&neither, &equal(there, whole(0))))
            },
        );
        prover.lemma(
            "a way between points that are held is right of no side",
            |[ax, ay, bx, by, px, py, qx, qy, way]| {
                let (side, p, q) = ([v(ax, ay), v(bx, by)], v(px, py), v(qx, qy));
                let given = [share(way), at_least_zero(off(side, p)), at_least_zero(off(side, q))];
                claim(given, at_least_zero(off(side, p + (q - p).times(way))))
            },
        );
        prover.lemma("and in the box of the corners", |[low, high, p, q, way]| {
            let given = [share(way), between(low, p, high), between(low, q, high)];
            claim(given, between(low, p + way * (q - p), high))
        });
        // The guard first checks the edge that blocked last, against the ways from the old corners to the
        // target.
        prover.lemma("a way to the target is a way between points that are held", |[p, q, way]| {
            let there = p + way * (q - p);
            claim([], equal(there, (whole(1) - way) * p + way * q))
        });
    },
};

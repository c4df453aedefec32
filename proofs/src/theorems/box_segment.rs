//! The theorem about box–segment.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::predicate::box_segment;

use super::box_met::{MEETS, SLIDES, corners, crossing_of, diagonals, is_ordered};
use super::crossing::CROSSING;
use super::plane::{V, between_segments, share, terms, to_segment, v};
use super::segment_ends::END_IS_NEARER;
use super::{boxes, point_segment};
use crate::smt::explore::{Part, answer, explore};
use crate::smt::fact::{Fact, all, any, at_most, between, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Lemma, Prover, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

const BOX: &str = "box_segment";

/// Clear: no point of the box is within r of a point of the segment.
const CLEAR: Contract<12, 0> = Contract {
    theorem: BOX,
    name: "clear: no point of the box is within r of a point of the segment",
    statement: |near, [lx, ly, hx, hy, ax, ay, bx, by, r, qx, qy, t], []| {
        let (low, high, a, b) = (v(lx, ly), v(hx, hy), v(ax, ay), v(bx, by));
        let q = v(qx, qy);
        let distance_2 = (q - (a + (b - a).times(t))).norm_2();
        let given = [not(near), at_least_zero(r), is_ordered(low, high), q.is_in(low, high), share(t)];
        claim(given, less(square(r), distance_2))
    },
};

/// Near: some point of the box is within r of a point of the segment.
const NEAR: Contract<9, 3> = Contract {
    theorem: BOX,
    name: "near: some point of the box is within r of a point of the segment",
    statement: |near, [lx, ly, hx, hy, ax, ay, bx, by, r], [qx, qy, t]| {
        let (low, high, a, b) = (v(lx, ly), v(hx, hy), v(ax, ay), v(bx, by));
        let q = v(qx, qy);
        let distance_2 = (q - (a + (b - a).times(t))).norm_2();
        let given = [near, at_least_zero(r), is_ordered(low, high)];
        claim(given, all([q.is_in(low, high), share(t), at_most(distance_2, square(r))]))
    },
};

/// Box–segment.
pub const BOX_SEGMENT: Theorem = Theorem {
    name: BOX,
    source: "predicate::box_segment",
    claim: "near exactly when a point of the closed box is within r of a point of the segment, for r ≥ 0",
    proof: |prover| {
        let low = V::unknown("low");
        let [high, a, q] = ["high", "a", "q"].map(|name| low.other(name));
        let b = a.other("b");
        let [r, t] = ["r", "t"].map(Term::fresh);
        let parts = [Part::BoxPoint, Part::PointSegment, Part::CrossesProperly];
        let ordered = [(low.x, high.x), (low.y, high.y)];
        let paths = explore(&ordered, &parts, || {
            let [low, high, a, b] = [low, high, a, b].map(V::place);
            !box_segment::<Symbolic>(low, high, a, b, Scalar(r)).is_clear()
        });
        let mut using = Vec::new();
        let (slides, [mx, my, m]) = prover.by(&SLIDES, Fact::True, terms(&[low, high, a, b, q], &[t]));
        using.push(slides);
        let (moved, places) = (v(mx, my), corners(low, high));
        let question = BoxQuestion { low, high, a, b, r };
        question.end_in_box(prover, a, moved, &mut using);
        let there = a + (b - a).times(m);
        let begin = moved - there;
        let apart = q - (a + (b - a).times(t));
        let squares = prover.lemma("equal vectors, equal squares", |[x, y, z, w]| {
            claim([v(x, y).is(v(z, w))], equal(v(x, y).norm_2(), v(z, w).norm_2()))
        });
        using.push(squares.at([begin.x, begin.y, apart.x, apart.y]));
        let at_beginning = prover.lemma("at the beginning", |[ax, ay, bx, by, mx, my, m]| {
            let (a, b, moved) = (v(ax, ay), v(bx, by), v(mx, my));
            let apart = moved - (a + (b - a).times(m));
            claim([equal(m, whole(0))], equal((moved - a).norm_2(), apart.norm_2()))
        });
        using.push(at_beginning.at(terms(&[a, b, moved], &[m])));
        for i in 0..4 {
            question.side(prover, [places[i], places[(i + 1) % 4]], (moved, m), &mut using);
        }
        let positive = prover.lemma("a square", |[r]| claim([], at_least_zero(square(r))));
        using.push(positive.at([r]));
        prover.by_parts(&CLEAR, &paths, terms(&[low, high, a, b], &[r, q.x, q.y, t]), ([], &using));
        let (found, using) = question.found(prover);
        prover.by_parts(&NEAR, &paths, terms(&[low, high, a, b], &[r]), (found, &using));
    },
};

struct BoxQuestion {
    low: V,
    high: V,
    a: V,
    b: V,
    r: Term,
}

impl BoxQuestion {
    /// An end of the segment and a point of the box.
    fn end_in_box(&self, prover: &mut Prover<'_>, end: V, point: V, using: &mut Vec<Instance>) {
        let question = answer(Part::BoxPoint, &terms::<7>(&[self.low, self.high, end], &[self.r]));
        let numbers = terms(&[self.low, self.high, end], &[self.r, point.x, point.y]);
        using.push(prover.by(&boxes::CLEAR, question, numbers).0);
    }

    /// A corner and a point of the segment.
    fn corner(&self, prover: &mut Prover<'_>, corner: V, t: Term, using: &mut Vec<Instance>) {
        let question = answer(Part::PointSegment, &terms::<7>(&[corner, self.a, self.b], &[self.r]));
        let numbers = terms(&[corner, self.a, self.b], &[self.r, t]);
        using.push(prover.by(&point_segment::CLEAR, question, numbers).0);
    }

    /// The near points of the parts: one of the box, and the share of one of the segment.
    fn found(&self, prover: &mut Prover<'_>) -> ([Term; 3], Vec<Instance>) {
        let Self { low, high, a, b, r } = *self;
        let places = corners(low, high);
        let mut using = Vec::new();
        let mut candidates: Vec<(Fact, V, Term)> = Vec::new();
        for (end, t) in [(a, whole(0)), (b, whole(1))] {
            let numbers = terms(&[low, high, end], &[r]);
            let question = answer(Part::BoxPoint, &numbers);
            let (found, [x, y]) = prover.by(&boxes::NEAR, question.clone(), numbers);
            let apart = v(x, y) - (a + (b - a).times(t));
            let same = claim([], equal(apart.norm_2(), (v(x, y) - end).norm_2()));
            using.extend([found, prover.fact("an end", &same)]);
            candidates.push((question, v(x, y), t));
        }
        for corner in places {
            let numbers = terms(&[corner, a, b], &[r]);
            let question = answer(Part::PointSegment, &numbers);
            let (found, [t]) = prover.by(&point_segment::NEAR, question.clone(), numbers);
            let apart = corner - (a + (b - a).times(t));
            let same = claim([], equal(apart.norm_2(), to_segment(corner, a, b, t).norm_2()));
            using.extend([found, prover.fact("a corner", &same)]);
            candidates.push((question, corner, t));
        }
        for (i, question) in diagonals(low, high, a, b).into_iter().enumerate() {
            let (from, to) = (places[i], places[i + 2]);
            let (found, [s, t]) = prover.by(&CROSSING, question.clone(), terms(&[from, to, a, b], &[]));
            let meet = from + (to - from).times(s);
            let apart = meet - (a + (b - a).times(t));
            let zero = between_segments([from, to], [a, b], s, t).is_zero();
            let same = claim([zero], at_most(apart.norm_2(), square(r)));
            let inside = prover.lemma("a diagonal is in the box, from low", |[low, high, s]| {
                let there = |f: Term, g: Term| between(low, f + s * (g - f), high);
                claim([share(s), at_most(low, high)], all([there(low, high), there(high, low)]))
            });
            using.extend([found, prover.fact("a common point", &same)]);
            using.extend([inside.at([low.x, high.x, s]), inside.at([low.y, high.y, s])]);
            candidates.push((question, meet, t));
        }
        let mut pick = |name: &str, of: &dyn Fn(&(Fact, V, Term)) -> Term| {
            let cases: Vec<_> = (0..candidates.len())
                .map(|i| {
                    let before = candidates[..i].iter().map(|candidate| not(candidate.0.clone()));
                    (all(before.chain([candidates[i].0.clone()])), of(&candidates[i]), whole(1))
                })
                .collect();
            let (number, definition) = prover.define(name, &cases);
            using.extend(definition);
            number
        };
        let (x, y, t) = (pick("x", &|each| each.1.x), pick("y", &|each| each.1.y), pick("t", &|each| each.2));
        let distance_2 = |q: V, t: Term| (q - (a + (b - a).times(t))).norm_2();
        for (_, q, share) in &candidates {
            let given = [v(x, y).is(*q), equal(t, *share)];
            let then = equal(distance_2(v(x, y), t), distance_2(*q, *share));
            using.push(prover.fact("equal points, equal distances", &claim(given, then)));
        }
        ([x, y, t], using)
    }

    /// The moved point lies on this side of the box, at a share `s`. An end of the side or of the segment
    /// is as near, or the two cross. If they cross, the segment meets the box.
    fn side(
        &self,
        prover: &mut Prover<'_>,
        [f, g]: [V; 2],
        (moved, m): (V, Term),
        using: &mut Vec<Instance>,
    ) {
        let Self { low, high, a, b, .. } = *self;
        let upright = f.x == g.x;
        let axis = |p: V| if upright { p.y } else { p.x };
        let flat = equal(axis(f), axis(g));
        let (s, definition) = prover.define(
            "s",
            &[(not(flat.clone()), axis(moved) - axis(f), axis(g) - axis(f)), (flat, whole(0), whole(1))],
        );
        using.extend(definition);
        let share_of = share_on_side(prover);
        using.push(share_of.at([axis(f), axis(g), axis(moved), s, axis(low), axis(high)]));
        let inside = prover.lemma("a side is in the box", |[f, g, s, low, high]| {
            let given = [share(s), between(low, f, high), between(low, g, high)];
            claim(given, between(low, f + s * (g - f), high))
        });
        let crosses = crossing_of(f, g, a, b);
        let (nearer, [s1, t1]) = prover.by(&END_IS_NEARER, crosses.clone(), terms(&[f, g, a, b], &[s, m]));
        let (crossing, [s2, t2]) = prover.by(&CROSSING, crosses, terms(&[f, g, a, b], &[]));
        using.extend([nearer, crossing]);
        let at = |s: Term| f + (g - f).times(s);
        for s in [s, s1, s2] {
            using.push(inside.at([f.x, g.x, s, low.x, high.x]));
            using.push(inside.at([f.y, g.y, s, low.y, high.y]));
        }
        let same = prover.fact(
            "on the side",
            &claim([at(s).is(moved)], {
                let apart = moved - (a + (b - a).times(m));
                equal(between_segments([f, g], [a, b], s, m).norm_2(), apart.norm_2())
            }),
        );
        let level = prover.fact(
            "a side along an axis",
            &claim([], {
                let other = |p: V| if upright { p.x } else { p.y };
                equal(other(at(s)), other(f))
            }),
        );
        using.extend([same, level]);
        // Ends: corners of the box, and ends of the segment.
        let distance_2 = between_segments([f, g], [a, b], s1, t1).norm_2();
        for (corner, end) in [(f, 0), (g, 1)] {
            self.corner(prover, corner, t1, using);
            let then = equal(distance_2, to_segment(corner, a, b, t1).norm_2());
            using.push(prover.fact("a corner", &claim([equal(s1, whole(end))], then)));
        }
        for (point, end) in [(a, 0), (b, 1)] {
            self.end_in_box(prover, point, at(s1), using);
            let then = equal(distance_2, (at(s1) - point).norm_2());
            using.push(prover.fact("an end", &claim([equal(t1, whole(end))], then)));
        }
        self.crossed(prover, [f, g], [s2, t2], using);
    }

    /// The segment crosses this side, so it meets the box: an end is in the box, or a corner is on the
    /// segment.
    fn crossed(
        &self,
        prover: &mut Prover<'_>,
        [f, g]: [V; 2],
        [s2, t2]: [Term; 2],
        using: &mut Vec<Instance>,
    ) {
        let Self { low, high, a, b, .. } = *self;
        let at = |s: Term| f + (g - f).times(s);
        let met = a + (b - a).times(t2);
        let zero = between_segments([f, g], [a, b], s2, t2).is_zero();
        using.push(prover.fact("the common point", &claim([zero], met.is(at(s2)))));
        let [one, other] = diagonals(low, high, a, b);
        let (meets, [s3]) = prover.by(&MEETS, any([one, other]), terms(&[low, high, a, b], &[t2]));
        using.push(meets);
        let nothing = prover.lemma("no vector, no distance", |[x, y]| {
            claim([v(x, y).is_zero()], equal(v(x, y).norm_2(), whole(0)))
        });
        for corner in corners(low, high) {
            self.corner(prover, corner, s3, using);
            let way = to_segment(corner, a, b, s3);
            using.push(nothing.at([way.x, way.y]));
        }
        for (end, itself) in [(a, a), (b, b)] {
            self.end_in_box(prover, end, itself, using);
            let way = itself - end;
            using.push(nothing.at([way.x, way.y]));
        }
    }
}

fn share_on_side(prover: &mut Prover<'_>) -> Lemma<6> {
    prover.lemma("the share on a side", |[f, g, c, s, low, high]| {
        let of = any([all([equal(f, low), equal(g, high)]), all([equal(f, high), equal(g, low)])]);
        let is_share =
            all([any([equal(f, g), equal(s * (g - f), c - f)]), any([not(equal(f, g)), equal(s, whole(0))])]);
        let given = [of, at_most(low, high), between(low, c, high), is_share];
        claim(given, all([share(s), equal(f + s * (g - f), c)]))
    })
}

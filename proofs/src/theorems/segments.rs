//! Segment–segment.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::predicate::segment_segment;

use super::beyond::{APART, BOTH, MEAN, off};
use super::crossing::{CROSSING, coordinates, four, numbers, unknown_segments};
use super::plane::{V, between_segments, share, terms, to_segment, v};
use super::point_segment;
use super::segment_ends::END_IS_NEARER;
use crate::smt::explore::{Part, answer, explore};
use crate::smt::fact::{Fact, all, at_most, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Prover, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

const SEGMENTS: &str = "segment_segment";

/// Clear: no two points of the segments are within r.
pub const CLEAR: Contract<11, 0> = Contract {
    theorem: SEGMENTS,
    name: "clear: no two points are within r",
    statement: |near, [ax, ay, bx, by, cx, cy, dx, dy, r, s, t], []| {
        let [ab, cd] = four([ax, ay, bx, by, cx, cy, dx, dy]);
        let distance_2 = between_segments(ab, cd, s, t).norm_2();
        claim([not(near), at_least_zero(r), share(s), share(t)], less(square(r), distance_2))
    },
};

/// Near: some two points are within r.
pub const NEAR: Contract<9, 2> = Contract {
    theorem: SEGMENTS,
    name: "near: some two points are within r",
    statement: |near, [ax, ay, bx, by, cx, cy, dx, dy, r], [s, t]| {
        let [ab, cd] = four([ax, ay, bx, by, cx, cy, dx, dy]);
        let distance_2 = between_segments(ab, cd, s, t).norm_2();
        claim([near, at_least_zero(r)], all([share(s), share(t), at_most(distance_2, square(r))]))
    },
};

/// Segment–segment.
pub const SEGMENT_SEGMENT: Theorem = Theorem {
    name: SEGMENTS,
    source: "predicate::segment_segment",
    claim: "near exactly when there are s, t in [0, 1] with |a + s(b − a) − c − t(d − c)| ≤ r, for r ≥ 0",
    proof: |prover| {
        let [ab, cd] = unknown_segments();
        let [a, b] = ab;
        let [c, d] = cd;
        let [r, s, t] = ["r", "s", "t"].map(Term::fresh);
        let parts = [Part::Beyond, Part::PointSegment, Part::CrossesProperly];
        let paths = explore(&[], &parts, || {
            !segment_segment::<Symbolic>(ab.map(V::place), cd.map(V::place), Scalar(r)).is_clear()
        });
        let crosses = answer(Part::CrossesProperly, &coordinates([ab, cd]));
        let (nearer, [s1, t1]) = prover.by(&END_IS_NEARER, crosses.clone(), numbers([ab, cd], &[s, t]));
        let (crossing, [s2, t2]) = prover.by(&CROSSING, crosses.clone(), coordinates([ab, cd]));
        let (mut clear, mut near) = (vec![nearer], vec![crossing]);
        let mut candidates = vec![(crosses, s2, t2)];
        // For each end: the point, the segment, and the shares at which the difference of the segments
        // leads from one to the other.
        for (p, [q, e], at, is_first) in
            [(c, ab, 0, true), (d, ab, 1, true), (a, cd, 0, false), (b, cd, 1, false)]
        {
            let arguments = [p.x, p.y, q.x, q.y, e.x, e.y, r];
            let question = answer(Part::PointSegment, &arguments);
            let shares = |free: Term| if is_first { (free, whole(at)) } else { (whole(at), free) };
            let free = if is_first { s1 } else { t1 };
            let [px, py, qx, qy, ex, ey, r] = arguments;
            let (far, []) =
                prover.by(&point_segment::CLEAR, question.clone(), [px, py, qx, qy, ex, ey, r, free]);
            let (found, [foot]) = prover.by(&point_segment::NEAR, question.clone(), arguments);
            clear.push(far);
            near.push(found);
            // The difference at an end is that of point and segment.
            let (s1, t1) = shares(free);
            let (s2, t2) = shares(foot);
            for (free, (s, t), list) in [(free, (s1, t1), &mut clear), (foot, (s2, t2), &mut near)] {
                list.push(end_distance(prover, [ab, cd], (p, [q, e]), free, [s, t]));
            }
            candidates.push((question, s2, t2));
        }
        // An end's share is 0 or 1. The distance is the one with that number.
        for (s0, t0) in [(s1, whole(0)), (s1, whole(1)), (whole(0), t1), (whole(1), t1)] {
            clear.push(substituted(prover, [ab, cd], [s1, t1], [s0, t0]));
        }
        clear.extend(separated(prover, [ab, cd], [r, s, t]));
        prover.by_parts(&CLEAR, &paths, numbers([ab, cd], &[r, s, t]), ([], &clear));
        let cases = |i: usize| -> Vec<(Fact, Term, Term)> {
            let mut before: Vec<Fact> = Vec::new();
            let mut cases = Vec::new();
            for (question, s, t) in &candidates {
                let guard = all(before.iter().cloned().map(not).chain([question.clone()]));
                cases.push((guard, [*s, *t][i], whole(1)));
                before.push(question.clone());
            }
            cases
        };
        let (s, definition) = prover.define("s", &cases(0));
        near.extend(definition);
        let (t, definition) = prover.define("t", &cases(1));
        near.extend(definition);
        for &(_, s0, t0) in &candidates {
            near.push(substituted(prover, [ab, cd], [s, t], [s0, t0]));
        }
        near.push(touching(prover, [ab, cd], [s2, t2], r));
        prover.by_parts(&NEAR, &paths, numbers([ab, cd], &[r]), ([s, t], &near));
    },
};

/// Facts about the points at `s` and `t` when a line of one segment has the other beyond it.
fn separated(prover: &mut Prover<'_>, [ab, cd]: [[V; 2]; 2], [r, s, t]: [Term; 3]) -> Vec<Instance> {
    let mut using = Vec::new();
    let on_line = prover.lemma("a point of a segment is on its line", |[ax, ay, bx, by, t]| {
        let (a, b) = (v(ax, ay), v(bx, by));
        let there = a + (b - a).times(t);
        claim([], all([equal(off([a, b], there), whole(0)), equal(off([b, a], there), whole(0))]))
    });
    let at = |[p, q]: [V; 2], share: Term| p + (q - p).times(share);
    for ([a, b], t_line, [c, d], t_points) in [(ab, s, cd, t), (cd, t, ab, s)] {
        let (y, x) = (at([a, b], t_line), at([c, d], t_points));
        using.push(on_line.at(terms(&[a, b], &[t_line])));
        for [a, b] in [[a, b], [b, a]] {
            let arguments = terms::<9>(&[a, b, c, d], &[r]);
            using.push(prover.by(&BOTH, answer(Part::Beyond, &arguments), arguments).0);
            using.push(prover.by(&MEAN, Fact::True, terms(&[a, b, c, d], &[r, t_points])).0);
            using.push(prover.by(&APART, Fact::True, terms(&[a, b, x, y], &[r])).0);
        }
        let same = equal((x - y).norm_2(), between_segments(ab, cd, s, t).norm_2());
        using.push(prover.fact("their distance", &claim([], same)));
    }
    using
}

fn end_distance(
    prover: &mut Prover<'_>,
    [ab, cd]: [[V; 2]; 2],
    (p, [q, e]): (V, [V; 2]),
    free: Term,
    [s, t]: [Term; 2],
) -> Instance {
    let then = equal(between_segments(ab, cd, s, t).norm_2(), to_segment(p, q, e, free).norm_2());
    prover.fact("the distance from an end", &claim([], then))
}

fn substituted(
    prover: &mut Prover<'_>,
    [ab, cd]: [[V; 2]; 2],
    [s, t]: [Term; 2],
    [s0, t0]: [Term; 2],
) -> Instance {
    let distance_2 = |s, t| between_segments(ab, cd, s, t).norm_2();
    let then = equal(distance_2(s, t), distance_2(s0, t0));
    prover.fact("equal shares, equal distances", &claim([equal(s, s0), equal(t, t0)], then))
}

fn touching(prover: &mut Prover<'_>, [ab, cd]: [[V; 2]; 2], [s, t]: [Term; 2], r: Term) -> Instance {
    let difference = between_segments(ab, cd, s, t);
    let then = at_most(difference.norm_2(), square(r));
    prover.fact("no difference, no distance", &claim([difference.is_zero()], then))
}

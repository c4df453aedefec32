//! Segments that do not cross are nearest at an end.
//!
//! Evidence for SR-01.

use super::crossing::{NOT_CROSSING, coordinates, four, inner, meeting, numbers, unknown_segments};
use super::plane::{V, between_lines, between_segments, share, v as vector};
use crate::smt::explore::{Part, answer};
use crate::smt::fact::{Fact, all, any, at_most, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Prover};
use crate::smt::run::Theorem;
use crate::smt::term::{Term, whole};

const ENDS: &str = "segment_ends";

/// For any two points of segments that do not cross properly, two others are no farther apart, and one of
/// these is an end.
pub const END_IS_NEARER: Contract<10, 2> = Contract {
    theorem: ENDS,
    name: "not crossing: an end of one is as near to the other as any two points are",
    statement: |crosses, [ax, ay, bx, by, cx, cy, dx, dy, s, t], [s1, t1]| {
        let [ab, cd] = four([ax, ay, bx, by, cx, cy, dx, dy]);
        let distance_2 = |s, t| between_segments(ab, cd, s, t).norm_2();
        let ends = [(s1, 0), (s1, 1), (t1, 0), (t1, 1)].map(|(share, end)| equal(share, whole(end)));
        let nearer = at_most(distance_2(s1, t1), distance_2(s, t));
        claim([not(crosses), share(s), share(t)], all([share(s1), share(t1), any(ends), nearer]))
    },
};

/// The cases of `way`, the share of the way from `s` to `s0` at which it leaves [0, 1]. It is 1 when `s0`
/// lies inside.
fn exit_cases(s: Term, s0: Term) -> [(Fact, Term, Term); 5] {
    let (zero, one) = (whole(0), whole(1));
    [
        (all([at_most(s0, zero), less(s0, s)]), s, s - s0),
        (all([at_most(one, s0), less(s, s0)]), one - s, s0 - s),
        (all([at_most(s0, zero), at_most(s, s0)]), zero, one),
        (all([at_most(one, s0), at_most(s0, s)]), zero, one),
        (inner(s0), one, one),
    ]
}

fn is_exit([s, s0, way]: [Term; 3]) -> Fact {
    all(exit_cases(s, s0).map(|(guard, dividend, divisor)| {
        let body = if divisor == whole(1) { way } else { way * divisor };
        any([not(guard), equal(body, dividend)])
    }))
}

fn moved(s: Term, s0: Term, way: Term) -> Term {
    s + way * (s0 - s)
}

/// The theorem that an end decides.
pub const SEGMENT_ENDS: Theorem = Theorem {
    name: ENDS,
    source: "predicate::segment_segment",
    claim: "segments that do not cross properly are nearest at an end of one of them",
    proof: |prover| {
        let [ab, cd] = unknown_segments();
        let [s, t] = ["s", "t"].map(Term::fresh);
        let crosses = answer(Part::CrossesProperly, &coordinates([ab, cd]));
        let lines = (ab[0] - cd[0], ab[1] - ab[0], cd[1] - cd[0]);
        let parallel = equal(lines.1.cross(lines.2), whole(0));
        let (meet, mut using) = meeting(prover, [ab, cd]);
        using.push(prover.by(&NOT_CROSSING, crosses.clone(), numbers([ab, cd], &meet)).0);
        let crossed = toward_meeting(prover, lines, [s, t], meet, &mut using);
        let slid = along_parallels(prover, lines, [s, t], &mut using);
        let of =
            |i: usize| [(not(parallel.clone()), crossed[i], whole(1)), (parallel.clone(), slid[i], whole(1))];
        let (s1, definition) = prover.define("s1", &of(0));
        using.extend(definition);
        let (t1, definition) = prover.define("t1", &of(1));
        using.extend(definition);
        let same = prover.lemma("equal shares, equal distances", |[wx, wy, ux, uy, vx, vy, s, t, s1, t1]| {
            let distance_2 =
                |s, t| between_lines(vector(wx, wy), vector(ux, uy), vector(vx, vy), s, t).norm_2();
            claim([equal(s, s1), equal(t, t1)], equal(distance_2(s, t), distance_2(s1, t1)))
        });
        let (w, u, v) = lines;
        for [s, t] in [crossed, slid] {
            using.push(same.at([w.x, w.y, u.x, u.y, v.x, v.y, s1, t1, s, t]));
        }
        prover.establish(&END_IS_NEARER, crosses, numbers([ab, cd], &[s, t]), ([s1, t1], &using));
    },
};

/// Lines that meet: the parameters move from (s, t) straight toward the common point, until one is at an
/// end. The distance shrinks.
fn toward_meeting(
    prover: &mut Prover<'_>,
    (w, u, v): (V, V, V),
    [s, t]: [Term; 2],
    [s0, t0]: [Term; 2],
    using: &mut Vec<Instance>,
) -> [Term; 2] {
    let cramer = prover.lemma("Cramer", |[wx, wy, ux, uy, vx, vy, s, t]| {
        let (w, u, v) = (vector(wx, wy), vector(ux, uy), vector(vx, vy));
        let d = u.cross(v);
        let given = [not(equal(d, whole(0))), equal(s * d, v.cross(w)), equal(t * d, u.cross(w))];
        claim(given, between_lines(w, u, v, s, t).is_zero())
    });
    using.push(cramer.at([w.x, w.y, u.x, u.y, v.x, v.y, s0, t0]));
    let mut ways = Vec::new();
    let bounds = prover
        .lemma("the exit is a share", |[s, s0, way]| claim([share(s), is_exit([s, s0, way])], share(way)));
    let stays = prover.lemma("before the exit the point is inside", |[s, s0, way, part]| {
        let given = [share(s), is_exit([s, s0, way]), at_most(whole(0), part), at_most(part, way)];
        claim(given, share(moved(s, s0, part)))
    });
    let leaves = prover.lemma("at the exit is an end", |[s, s0, way, part]| {
        let given = [share(s), is_exit([s, s0, way]), not(inner(s0)), equal(part, way)];
        let end = moved(s, s0, part);
        claim(given, any([equal(end, whole(0)), equal(end, whole(1))]))
    });
    for (s, s0) in [(s, s0), (t, t0)] {
        let (way, definition) = prover.define("way", &exit_cases(s, s0));
        using.extend(definition);
        using.push(bounds.at([s, s0, way]));
        ways.push((s, s0, way));
    }
    let (one, other) = (ways[0].2, ways[1].2);
    let (part, definition) =
        prover.define("part", &[(at_most(one, other), one, whole(1)), (less(other, one), other, whole(1))]);
    using.extend(definition);
    for (s, s0, way) in ways {
        using.push(stays.at([s, s0, way, part]));
        using.push(leaves.at([s, s0, way, part]));
    }
    let scaled = prover.lemma("the difference shrinks", |[w, u, v, s, t, s0, t0, part]| {
        let of = |s, t| (w + s * u) - t * v;
        let now = of(moved(s, s0, part), moved(t, t0, part));
        claim([equal(of(s0, t0), whole(0))], equal(now, (whole(1) - part) * of(s, t)))
    });
    let shorter = prover.lemma("so the distance does", |[x, y, x1, y1, part]| {
        let left = whole(1) - part;
        let given = [share(part), equal(x1, left * x), equal(y1, left * y)];
        claim(given, at_most(vector(x1, y1).norm_2(), vector(x, y).norm_2()))
    });
    for (w, u, v) in [(w.x, u.x, v.x), (w.y, u.y, v.y)] {
        using.push(scaled.at([w, u, v, s, t, s0, t0, part]));
    }
    let end = [moved(s, s0, part), moved(t, t0, part)];
    let (now, then) = (between_lines(w, u, v, s, t), between_lines(w, u, v, end[0], end[1]));
    using.push(shorter.at([now.x, now.y, then.x, then.y, part]));
    end
}

/// Parallel lines: both points move by the same vector until one is an end. Their difference stays.
fn along_parallels(
    prover: &mut Prover<'_>,
    (w, u, v): (V, V, V),
    [s, t]: [Term; 2],
    using: &mut Vec<Instance>,
) -> [Term; 2] {
    let (zero, one) = (whole(0), whole(1));
    let length_2 = u.norm_2();
    let point = equal(length_2, zero);
    let (k, definition) = prover.define("k", &[(not(point.clone()), u.dot(v), length_2)]);
    using.extend(definition);
    // d − c is k times b − a. The value s − k·t stays.
    let rest = s - k * t;
    let turns = not(equal(k, zero));
    let before = all([not(point.clone()), less(rest, zero), turns.clone()]);
    let past = all([not(point.clone()), less(one, rest), turns]);
    let within = all([not(point.clone()), share(rest)]);
    let (s1, definition) = prover.define(
        "slid s",
        &[
            (point.clone(), zero, one),
            (within.clone(), rest, one),
            (before.clone(), zero, one),
            (past.clone(), one, one),
        ],
    );
    using.extend(definition);
    let (t1, definition) = prover.define(
        "slid t",
        &[(point, t, one), (within, zero, one), (before, k * t - s, k), (past, (k * t - s) + one, k)],
    );
    using.extend(definition);
    shares_after_sliding(prover, [k, s, t, t1], using);
    difference_stays(prover, (w, u, v), [k, s, t, s1, t1], using);
    [s1, t1]
}

fn shares_after_sliding(prover: &mut Prover<'_>, [k, s, t, t1]: [Term; 4], using: &mut Vec<Instance>) {
    let product = prover.lemma("no slide of t, no slide of s", |[k, t1]| {
        claim([equal(t1, whole(0))], equal(k * t1, whole(0)))
    });
    using.push(product.at([k, t1]));
    let turned = prover.lemma("product turned", |[k, t1]| claim([], equal(k * t1, t1 * k)));
    using.push(turned.at([k, t1]));
    let before = prover.lemma("slid before the beginning", |[k, s, t, t1]| {
        let given = [share(s), share(t), less(s - k * t, whole(0)), equal(t1 * k, k * t - s)];
        claim(given, share(t1))
    });
    using.push(before.at([k, s, t, t1]));
    let past = prover.lemma("slid past the end", |[k, s, t, t1]| {
        let given = [share(s), share(t), less(whole(1), s - k * t), equal(t1 * k, (k * t - s) + whole(1))];
        claim(given, share(t1))
    });
    using.push(past.at([k, s, t, t1]));
    let turns = prover.lemma("no slide without a direction", |[k, s, t]| {
        claim([share(s), not(share(s - k * t))], not(equal(k, whole(0))))
    });
    using.push(turns.at([k, s, t]));
}

fn difference_stays(
    prover: &mut Prover<'_>,
    (w, u, v): (V, V, V),
    [k, s, t, s1, t1]: [Term; 5],
    using: &mut Vec<Instance>,
) {
    let multiple = prover.lemma("parallels are multiples", |[ux, uy, vx, vy, k]| {
        let (u, v) = (vector(ux, uy), vector(vx, vy));
        let given =
            [equal(u.cross(v), whole(0)), not(equal(u.norm_2(), whole(0))), equal(k * u.norm_2(), u.dot(v))];
        claim(given, v.is(u.times(k)))
    });
    using.push(multiple.at([u.x, u.y, v.x, v.y, k]));
    let stays = prover.lemma("the difference stays", |[w, u, v, k, s, t, s1, t1]| {
        let of = |s, t| (w + s * u) - t * v;
        let given = [equal(v, k * u), equal(s1 - k * t1, s - k * t)];
        claim(given, equal(of(s1, t1), of(s, t)))
    });
    for (w, u, v) in [(w.x, u.x, v.x), (w.y, u.y, v.y)] {
        using.push(stays.at([w, u, v, k, s, t, s1, t1]));
    }
    let none = prover.lemma("a segment of no length", |[ux, uy]| {
        claim([equal(vector(ux, uy).norm_2(), whole(0))], vector(ux, uy).is_zero())
    });
    using.push(none.at([u.x, u.y]));
    let still = prover.lemma("its point stays where it is", |[w, u, v, s, t, s1, t1]| {
        let of = |s, t| (w + s * u) - t * v;
        claim([equal(u, whole(0)), equal(t1, t)], equal(of(s1, t1), of(s, t)))
    });
    for (w, u, v) in [(w.x, u.x, v.x), (w.y, u.y, v.y)] {
        using.push(still.at([w, u, v, s, t, s1, t1]));
    }
    let equal_squares = prover.lemma("equal differences, equal distances", |[x, y, x1, y1]| {
        claim([vector(x, y).is(vector(x1, y1))], equal(vector(x1, y1).norm_2(), vector(x, y).norm_2()))
    });
    let (now, then) = (between_lines(w, u, v, s, t), between_lines(w, u, v, s1, t1));
    using.push(equal_squares.at([now.x, now.y, then.x, then.y]));
}

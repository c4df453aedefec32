//! Crossing, and segment–segment.

use keepout_kernel::exact::predicate::{crosses_properly, segment_segment};

use super::plane::{V, between_lines, between_segments, share, to_segment, v as vector};
use super::point_segment;
use crate::smt::explore::{Part, answer, explore};
use crate::smt::fact::{Fact, all, any, at_most, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Prover, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

const CROSSES: &str = "crosses_properly";
const ENDS: &str = "segment_ends";
const SEGMENTS: &str = "segment_segment";

fn inner(t: Term) -> Fact {
    all([less(whole(0), t), less(t, whole(1))])
}

fn four([ax, ay, bx, by, cx, cy, dx, dy]: [Term; 8]) -> [[V; 2]; 2] {
    [[vector(ax, ay), vector(bx, by)], [vector(cx, cy), vector(dx, dy)]]
}

/// The eight coordinates of two segments.
pub fn coordinates([[a, b], [c, d]]: [[V; 2]; 2]) -> [Term; 8] {
    [a.x, a.y, b.x, b.y, c.x, c.y, d.x, d.y]
}

fn numbers<const N: usize>(segments: [[V; 2]; 2], more: &[Term]) -> [Term; N] {
    let all: Vec<Term> = coordinates(segments).into_iter().chain(more.iter().copied()).collect();
    all.try_into().expect("as many numbers as the contract has")
}

/// Two segments of unknown ends.
fn unknown_segments() -> [[V; 2]; 2] {
    let c = V::unknown("c");
    let a = c.other("a");
    [[a, a.other("b")], [c, c.other("d")]]
}

/// Crossing: there is a point interior to both.
pub const CROSSING: Contract<8, 2> = Contract {
    theorem: CROSSES,
    name: "crossing: there is a point interior to both",
    statement: |crosses, points, [s, t]| {
        let [ab, cd] = four(points);
        let meet = between_segments(ab, cd, s, t).is_zero();
        let parallel = equal((ab[1] - ab[0]).cross(cd[1] - cd[0]), whole(0));
        claim([crosses], all([inner(s), inner(t), meet, not(parallel)]))
    },
};

/// Not crossing: segments that are not parallel have no common point interior to both.
pub const NOT_CROSSING: Contract<10, 0> = Contract {
    theorem: CROSSES,
    name: "not crossing: no point of lines that are not parallel is interior to both",
    statement: |crosses, [ax, ay, bx, by, cx, cy, dx, dy, s, t], []| {
        let [ab, cd] = four([ax, ay, bx, by, cx, cy, dx, dy]);
        let parallel = equal((ab[1] - ab[0]).cross(cd[1] - cd[0]), whole(0));
        let meet = between_segments(ab, cd, s, t).is_zero();
        claim([not(crosses), not(parallel), meet], not(all([inner(s), inner(t)])))
    },
};

/// The parameters of the common point of two lines, when they are not parallel.
fn meeting(prover: &mut Prover<'_>, [ab, cd]: [[V; 2]; 2]) -> ([Term; 2], Vec<Instance>) {
    let (w, u, v) = (ab[0] - cd[0], ab[1] - ab[0], cd[1] - cd[0]);
    let determinant = u.cross(v);
    let some = not(equal(determinant, whole(0)));
    let (s, mut definition) = prover.define("s0", &[(some.clone(), v.cross(w), determinant)]);
    let (t, more) = prover.define("t0", &[(some, u.cross(w), determinant)]);
    definition.extend(more);
    ([s, t], definition)
}

/// Crossing.
pub const CROSSES_PROPERLY: Theorem = Theorem {
    name: CROSSES,
    source: "predicate::crosses_properly",
    claim: "yes exactly when the lines are not parallel and meet at a point interior to both segments",
    proof: |prover| {
        let [ab, cd] = unknown_segments();
        let paths = explore(&[], &[], || {
            let [a, b, c, d] = [ab[0], ab[1], cd[0], cd[1]].map(V::place);
            crosses_properly::<Symbolic>(a, b, c, d)
        });
        let (meet, definition) = meeting(prover, [ab, cd]);
        prover.contract(&CROSSING, &paths, coordinates([ab, cd]), (meet, &definition));
        let [s, t] = ["s", "t"].map(Term::fresh);
        prover.contract(&NOT_CROSSING, &paths, numbers([ab, cd], &[s, t]), ([], &[]));
    },
};

/// Whatever two points of segments that do not cross properly: two others are no farther apart, one of which is an end.
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

/// What holds of `way`, the share of the way from `s` to `s0` after which [0, 1] is left; 1 when `s0` lies inside.
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

/// Ends decide.
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

/// Lines that meet: from (s, t) straight toward where they meet, until an end is reached. The distance shrinks.
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
        .lemma("the way out is a share", |[s, s0, way]| claim([share(s), is_exit([s, s0, way])], share(way)));
    let stays = prover.lemma("before the way out one is inside", |[s, s0, way, part]| {
        let given = [share(s), is_exit([s, s0, way]), at_most(whole(0), part), at_most(part, way)];
        claim(given, share(moved(s, s0, part)))
    });
    let leaves = prover.lemma("at the way out is an end", |[s, s0, way, part]| {
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

/// Parallels: both points are moved by the same vector until one is an end. The difference stays.
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
    // b − a is to be run through k times for d − c; s − k·t stays.
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
    let product = prover
        .lemma("nothing slides nothing", |[k, t1]| claim([equal(t1, whole(0))], equal(k * t1, whole(0))));
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
    let equal_squares = prover.lemma("equal differences, equal distances", |[x, y, x1, y1]| {
        claim([vector(x, y).is(vector(x1, y1))], equal(vector(x1, y1).norm_2(), vector(x, y).norm_2()))
    });
    let (now, then) = (between_lines(w, u, v, s, t), between_lines(w, u, v, s1, t1));
    using.push(equal_squares.at([now.x, now.y, then.x, then.y]));
    [s1, t1]
}

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
        let parts = [Part::PointSegment, Part::CrossesProperly];
        let paths = explore(&[], &parts, || {
            let [a, b, c, d] = [a, b, c, d].map(V::place);
            !segment_segment::<Symbolic>(a, b, c, d, Scalar(r)).is_clear()
        });
        let crosses = answer(Part::CrossesProperly, &coordinates([ab, cd]));
        let (nearer, [s1, t1]) = prover.by(&END_IS_NEARER, crosses.clone(), numbers([ab, cd], &[s, t]));
        let (crossing, [s2, t2]) = prover.by(&CROSSING, crosses.clone(), coordinates([ab, cd]));
        let (mut clear, mut near) = (vec![nearer], vec![crossing]);
        let mut candidates = vec![(crosses, s2, t2)];
        // Each end: the point, the segment, and the shares at which the segments' difference is from one to the other.
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
        // An end's share is 0 or 1: the distance is that with the number put in.
        for (s0, t0) in [(s1, whole(0)), (s1, whole(1)), (whole(0), t1), (whole(1), t1)] {
            clear.push(substituted(prover, [ab, cd], [s1, t1], [s0, t0]));
        }
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

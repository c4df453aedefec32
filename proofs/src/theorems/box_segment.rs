//! Box–segment.

use keepout_kernel::exact::predicate::box_segment;

use super::plane::{V, between_segments, share, terms, to_segment, v};
use super::{boxes, point_segment, segments};
use crate::smt::explore::{Part, answer, explore};
use crate::smt::fact::{Fact, all, any, at_most, between, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Prover, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

const MET: &str = "box_met";
const SLIDE: &str = "box_slide";
const BOX: &str = "box_segment";

/// The corners, counter-clockwise from the lowest.
fn corners(low: V, high: V) -> [V; 4] {
    [low, v(high.x, low.y), high, v(low.x, high.y)]
}

fn crossing_of(a: V, b: V, c: V, d: V) -> Fact {
    answer(Part::CrossesProperly, &segments::coordinates([[a, b], [c, d]]))
}

fn diagonals(low: V, high: V, a: V, b: V) -> [Fact; 2] {
    let [low, right, high, left] = corners(low, high);
    [crossing_of(low, high, a, b), crossing_of(right, left, a, b)]
}

fn is_ordered(low: V, high: V) -> Fact {
    all([at_most(low.x, high.x), at_most(low.y, high.y)])
}

/// A segment with a point in the box that crosses no diagonal: an end is in the box, or a corner is on the segment.
const MEETS: Contract<9, 1> = Contract {
    theorem: MET,
    name: "no diagonal crossed: an end in the box, or a corner on the segment",
    statement: |crosses, [lx, ly, hx, hy, ax, ay, bx, by, t], [s]| {
        let (low, high, a, b) = (v(lx, ly), v(hx, hy), v(ax, ay), v(bx, by));
        let inside = (a + (b - a).times(t)).is_in(low, high);
        let corner = corners(low, high).map(|corner| to_segment(corner, a, b, s).is_zero());
        let given = [not(crosses), is_ordered(low, high), share(t), inside];
        claim(given, any([a.is_in(low, high), b.is_in(low, high), all([share(s), any(corner)])]))
    },
};

/// A box met.
pub const BOX_MET: Theorem = Theorem {
    name: MET,
    source: "predicate::box_segment",
    claim: "a segment that meets a box has an end in it, a corner of the box on it, or crosses a diagonal properly",
    proof: |prover| {
        let low = V::unknown("low");
        let [high, a] = ["high", "a"].map(|name| low.other(name));
        let (b, t) = (a.other("b"), Term::fresh("t"));
        let u = b - a;
        let flags = diagonals(low, high, a, b);
        let mut using = Vec::new();
        // A point of the line that is in the box lies between the ends, unless an end is in the box.
        let between_ends = prover.lemma("the box is convex", |[a, u, s, t, low, high]| {
            let at = |s: Term| a + s * u;
            let inside = |c: Term| between(low, c, high);
            let given = [inside(at(s)), inside(at(t)), share(t)];
            let a_in = any([not(at_most(s, whole(0))), inside(a)]);
            let b_in = any([not(at_most(whole(1), s)), inside(a + u)]);
            claim(given, all([a_in, b_in]))
        });
        let strict = |s: Term, using: &mut Vec<Instance>| {
            using.push(between_ends.at([a.x, u.x, s, t, low.x, high.x]));
            using.push(between_ends.at([a.y, u.y, s, t, low.y, high.y]));
        };
        // A corner on the line.
        let point = equal(u.norm_2(), whole(0));
        let places = corners(low, high);
        let mut shares = Vec::new();
        for corner in places {
            let (s, definition) =
                prover.define("corner", &[(not(point.clone()), u.dot(corner - a), u.norm_2())]);
            using.extend(definition);
            let on_line = prover.lemma("a point of the line", |[ax, ay, bx, by, cx, cy, s]| {
                let (a, u, c) = (v(ax, ay), v(bx, by) - v(ax, ay), v(cx, cy));
                let given = [
                    equal(u.cross(c - a), whole(0)),
                    not(equal(u.norm_2(), whole(0))),
                    equal(s * u.norm_2(), u.dot(c - a)),
                ];
                claim(given, all([to_segment(c, a, v(bx, by), s).is_zero(), (a + u.times(s)).is(c)]))
            });
            using.push(on_line.at(terms(&[a, b, corner], &[s])));
            strict(s, &mut using);
            shares.push((equal(u.cross(corner - a), whole(0)), s));
        }
        // A segment of no length is its end.
        let still = prover.lemma("a segment of no length", |[ax, ay, ux, uy, t]| {
            let (a, u) = (v(ax, ay), v(ux, uy));
            claim([equal(u.norm_2(), whole(0))], all([u.is_zero(), (a + u.times(t)).is(a)]))
        });
        using.push(still.at([a.x, a.y, u.x, u.y, t]));
        // No corner on the line: not all lie on one side, so those of a diagonal lie on different ones.
        let level = prover.lemma("the sides of the corners", |[lx, ly, hx, hy, ax, ay, ux, uy, t]| {
            let (low, high, a, u) = (v(lx, ly), v(hx, hy), v(ax, ay), v(ux, uy));
            let sides = corners(low, high).map(|corner| u.cross(corner - a));
            let zero = whole(0);
            let given = [is_ordered(low, high), (a + u.times(t)).is_in(low, high)];
            let sum = equal(sides[0] + sides[2], sides[1] + sides[3]);
            let some_left = any(sides.map(|side| at_most(zero, side)));
            let some_right = any(sides.map(|side| at_most(side, zero)));
            claim(given, all([sum, some_left, some_right]))
        });
        using.push(level.at(terms(&[low, high, a, u], &[t])));
        for (i, flag) in flags.iter().enumerate() {
            let (from, to) = (places[i], places[i + 2]);
            let (d, w) = (to - from, from - a);
            let determinant = d.cross(u);
            let some = not(equal(determinant, whole(0)));
            let (along, definition) = prover.define("along", &[(some.clone(), u.cross(w), determinant)]);
            using.extend(definition);
            let (across, definition) = prover.define("across", &[(some, d.cross(w), determinant)]);
            using.extend(definition);
            let meeting =
                prover.lemma("where a diagonal meets the line", |[fx, fy, gx, gy, ax, ay, bx, by, s, t]| {
                    let (from, to, a, b) = (v(fx, fy), v(gx, gy), v(ax, ay), v(bx, by));
                    let (d, w, u) = (to - from, from - a, b - a);
                    let (m, n) = (u.cross(from - a), u.cross(to - a));
                    let zero = whole(0);
                    let opposite =
                        any([all([less(m, zero), less(zero, n)]), all([less(zero, m), less(n, zero)])]);
                    let given = [
                        opposite,
                        any([equal(d.cross(u), zero), equal(s * d.cross(u), u.cross(w))]),
                        any([equal(d.cross(u), zero), equal(t * d.cross(u), d.cross(w))]),
                    ];
                    let inner = all([less(zero, s), less(s, whole(1))]);
                    let meets = between_segments([from, to], [a, b], s, t).is_zero();
                    let same = (a + u.times(t)).is(from + d.times(s));
                    claim(given, all([not(equal(d.cross(u), zero)), inner, meets, same]))
                });
            using.push(meeting.at(terms(&[from, to, a, b], &[along, across])));
            let inside = prover.lemma("a diagonal is in the box", |[f, g, low, high, s]| {
                let given = [
                    share(s),
                    any([all([equal(f, low), equal(g, high)]), all([equal(f, high), equal(g, low)])]),
                ];
                claim(
                    [given[0].clone(), given[1].clone(), at_most(low, high)],
                    between(low, f + s * (g - f), high),
                )
            });
            using.push(inside.at([from.x, to.x, low.x, high.x, along]));
            using.push(inside.at([from.y, to.y, low.y, high.y, along]));
            strict(across, &mut using);
            using.push(
                prover
                    .by(&segments::NOT_CROSSING, flag.clone(), terms(&[from, to, a, b], &[along, across]))
                    .0,
            );
        }
        let cases: Vec<(Fact, Term, Term)> = (0..4)
            .map(|i| {
                let before = shares[..i].iter().map(|(on_line, _)| not(on_line.clone()));
                (all(before.chain([shares[i].0.clone()])), shares[i].1, whole(1))
            })
            .collect();
        let (s, definition) = prover.define("s", &cases);
        using.extend(definition);
        let same = prover.lemma("equal shares, equal places", |[px, py, ax, ay, bx, by, s, t]| {
            let to = |s| to_segment(v(px, py), v(ax, ay), v(bx, by), s);
            claim([equal(s, t)], to(s).is(to(t)))
        });
        for (corner, (_, share)) in places.into_iter().zip(&shares) {
            using.push(same.at(terms(&[corner, a, b], &[s, *share])));
        }
        prover.establish(&MEETS, any(flags), terms(&[low, high, a, b], &[t]), ([s], &using));
    },
};

/// A point of a box and one of a segment can be moved alike until one is an end, or on a side of the box.
const SLIDES: Contract<11, 3> = Contract {
    theorem: SLIDE,
    name: "moved alike until the beginning, or a side",
    statement: |_, [lx, ly, hx, hy, ax, ay, bx, by, qx, qy, t], [mx, my, m]| {
        let (low, high, a, b) = (v(lx, ly), v(hx, hy), v(ax, ay), v(bx, by));
        let (q, moved) = (v(qx, qy), v(mx, my));
        let apart = |q: V, t: Term| q - (a + (b - a).times(t));
        let sides = [(mx, lx), (mx, hx), (my, ly), (my, hy)].map(|(c, bound)| equal(c, bound));
        let ends = any([equal(m, whole(0)), any(sides)]);
        let given = [is_ordered(low, high), q.is_in(low, high), share(t)];
        claim(given, all([share(m), moved.is_in(low, high), apart(moved, m).is(apart(q, t)), ends]))
    },
};

/// Sliding.
pub const BOX_SLIDE: Theorem = Theorem {
    name: SLIDE,
    source: "predicate::box_segment",
    claim: "a point of a box and one of a segment, moved alike, come to the segment's beginning or to a side of the box",
    proof: |prover| {
        let low = V::unknown("low");
        let [high, a, q] = ["high", "a", "q"].map(|name| low.other(name));
        let (b, t) = (a.other("b"), Term::fresh("t"));
        let u = b - a;
        let mut using = Vec::new();
        // How far both can be moved back along the segment until a coordinate reaches its bound.
        let room = |u: Term, q: Term, low: Term, high: Term| {
            let zero = whole(0);
            [(less(zero, u), q - low, u), (less(u, zero), q - high, u), (equal(u, zero), whole(1), whole(1))]
        };
        let mut back = Vec::new();
        for (u, q, low, high) in [(u.x, q.x, low.x, high.x), (u.y, q.y, low.y, high.y)] {
            let (way, definition) = prover.define("room", &room(u, q, low, high));
            using.extend(definition);
            back.push(way);
        }
        let (x, y) = (back[0], back[1]);
        let (way, definition) = prover.define(
            "back",
            &[
                (all([at_most(t, x), at_most(t, y)]), t, whole(1)),
                (all([less(x, t), at_most(x, y)]), x, whole(1)),
                (all([less(y, t), less(y, x)]), y, whole(1)),
            ],
        );
        using.extend(definition);
        let stays =
            prover.lemma("inside until the bound, and there on it", |[u, q, low, high, room, way, t]| {
                let zero = whole(0);
                let is_room = all([
                    any([not(less(zero, u)), equal(room * u, q - low)]),
                    any([not(less(u, zero)), equal(room * u, q - high)]),
                    any([not(equal(u, zero)), equal(room, whole(1))]),
                ]);
                let there = q - way * u;
                let at_bound = any([equal(there, low), equal(there, high)]);
                let given = [
                    between(low, q, high),
                    is_room,
                    share(t),
                    at_least_zero(way),
                    at_most(way, room),
                    at_most(way, t),
                ];
                let reached = any([less(way, room), not(less(way, t)), at_bound]);
                claim(given, all([between(low, there, high), reached]))
            });
        let roomy = prover.lemma("room is not negative", |[u, q, low, high, room]| {
            let zero = whole(0);
            let is_room = all([
                any([not(less(zero, u)), equal(room * u, q - low)]),
                any([not(less(u, zero)), equal(room * u, q - high)]),
                any([not(equal(u, zero)), equal(room, whole(1))]),
            ]);
            claim([between(low, q, high), is_room], at_least_zero(room))
        });
        let alike = prover.lemma("moved alike", |[a, u, q, way, t]| {
            let apart = |q: Term, t: Term| q - (a + t * u);
            claim([], equal(apart(q - way * u, t - way), apart(q, t)))
        });
        for (a, u, q, low, high, room) in
            [(a.x, u.x, q.x, low.x, high.x, x), (a.y, u.y, q.y, low.y, high.y, y)]
        {
            using.push(stays.at([u, q, low, high, room, way, t]));
            using.push(roomy.at([u, q, low, high, room]));
            using.push(alike.at([a, u, q, way, t]));
        }
        let moved = q - u.times(way);
        let numbers = terms(&[low, high, a, b, q], &[t]);
        prover.establish(&SLIDES, Fact::True, numbers, ([moved.x, moved.y, t - way], &using));
    },
};

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

/// Near: some point of the box is.
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

    /// The points that the parts found near: one of the box, and the share of one of the segment.
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
            let (found, [s, t]) =
                prover.by(&segments::CROSSING, question.clone(), terms(&[from, to, a, b], &[]));
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

    /// The moved point lies on this side of the box, at a share `s`: an end of the side or of the segment is as near, or they
    /// cross, and then the segment meets the box.
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
        let share_of = prover.lemma("the share on a side", |[f, g, c, s, low, high]| {
            let of = any([all([equal(f, low), equal(g, high)]), all([equal(f, high), equal(g, low)])]);
            let is_share = all([
                any([equal(f, g), equal(s * (g - f), c - f)]),
                any([not(equal(f, g)), equal(s, whole(0))]),
            ]);
            let given = [of, at_most(low, high), between(low, c, high), is_share];
            claim(given, all([share(s), equal(f + s * (g - f), c)]))
        });
        using.push(share_of.at([axis(f), axis(g), axis(moved), s, axis(low), axis(high)]));
        let inside = prover.lemma("a side is in the box", |[f, g, s, low, high]| {
            let given = [share(s), between(low, f, high), between(low, g, high)];
            claim(given, between(low, f + s * (g - f), high))
        });
        let crosses = crossing_of(f, g, a, b);
        let (nearer, [s1, t1]) =
            prover.by(&segments::END_IS_NEARER, crosses.clone(), terms(&[f, g, a, b], &[s, m]));
        let (crossing, [s2, t2]) = prover.by(&segments::CROSSING, crosses, terms(&[f, g, a, b], &[]));
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
        // Crossing: the segment meets the box.
        let met = a + (b - a).times(t2);
        let zero = between_segments([f, g], [a, b], s2, t2).is_zero();
        using.push(prover.fact("the common point", &claim([zero], met.is(at(s2)))));
        let [one, other] = diagonals(low, high, a, b);
        let (meets, [s3]) = prover.by(&MEETS, any([one, other]), terms(&[low, high, a, b], &[t2]));
        using.push(meets);
        let nothing =
            prover.lemma("no way", |[x, y]| claim([v(x, y).is_zero()], equal(v(x, y).norm_2(), whole(0))));
        for corner in corners(low, high) {
            self.corner(prover, corner, s3, using);
            let way = to_segment(corner, a, b, s3);
            using.push(nothing.at([way.x, way.y]));
        }
        for end in [a, b] {
            self.end_in_box(prover, end, end, using);
            let way = end - end;
            using.push(nothing.at([way.x, way.y]));
        }
    }
}

//! Boxes that a segment meets, and points of both that move together.
//!
//! Evidence for SR-03.

use super::crossing::{NOT_CROSSING, coordinates};
use super::plane::{V, between_segments, share, terms, to_segment, v};
use crate::smt::explore::{Part, answer};
use crate::smt::fact::{Fact, all, any, at_most, between, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::term::{Term, whole};

const MET: &str = "box_met";
const SLIDE: &str = "box_slide";

/// The corners, counter-clockwise from the lowest one.
pub(super) fn corners(low: V, high: V) -> [V; 4] {
    [low, v(high.x, low.y), high, v(low.x, high.y)]
}

pub(super) fn crossing_of(a: V, b: V, c: V, d: V) -> Fact {
    answer(Part::CrossesProperly, &coordinates([[a, b], [c, d]]))
}

pub(super) fn diagonals(low: V, high: V, a: V, b: V) -> [Fact; 2] {
    let [low, right, high, left] = corners(low, high);
    [crossing_of(low, high, a, b), crossing_of(right, left, a, b)]
}

pub(super) fn is_ordered(low: V, high: V) -> Fact {
    all([at_most(low.x, high.x), at_most(low.y, high.y)])
}

/// If a segment has a point in the box and crosses no diagonal, an end is in the box or a corner is on the
/// segment.
pub(super) const MEETS: Contract<9, 1> = Contract {
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

/// The theorem about a segment that meets a box.
pub const BOX_MET: Theorem = Theorem {
    name: MET,
    source: "predicate::box_segment",
    claim: "if a segment meets a box, one of its ends is in the box, a corner of the box is on it, or it \
            crosses a diagonal properly",
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
        // No corner is on the line. The corners do not all lie on one side, so the ends of one diagonal lie
        // on different sides.
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
            using.push(prover.by(&NOT_CROSSING, flag.clone(), terms(&[from, to, a, b], &[along, across])).0);
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

/// A point of a box and one of a segment move by the same vector until one is an end, or on a side of the
/// box.
pub(super) const SLIDES: Contract<11, 3> = Contract {
    theorem: SLIDE,
    name: "moved together until the beginning, or a side",
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

/// The theorem about points that move together.
pub const BOX_SLIDE: Theorem = Theorem {
    name: SLIDE,
    source: "predicate::box_segment",
    claim: "a point of a box and one of a segment, moved by the same vector, reach the segment's \
            beginning or a side of the box",
    proof: |prover| {
        let low = V::unknown("low");
        let [high, a, q] = ["high", "a", "q"].map(|name| low.other(name));
        let (b, t) = (a.other("b"), Term::fresh("t"));
        let u = b - a;
        let mut using = Vec::new();
        // The distance by which both can move back along the segment until a coordinate reaches its bound.
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
        let alike = prover.lemma("moved together", |[a, u, q, way, t]| {
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

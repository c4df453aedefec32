//! The convex polygon: the points that it holds, and the shapes near it. Corners are never right of a side.
//!
//! Solvers prove the lemmas for any numbers. The code is run for polygons of few corners. This is the
//! written proof that the lemmas make up the theorems for any number of corners:
//!
//! 1. *A point of the hull is held.* It is a mean of corners, and so a mean of two means of fewer corners.
//!    No corner is right of a side or outside the box. By "a mean of points not right of a side is not",
//!    neither is the point.
//! 2. *A held point is in the hull.* Let Z be held, and C a corner other than Z. The sides add up to zero,
//!    and so do their products with Z − C ("products add up as sides do"). Either some product is negative,
//!    or all are zero. If all are zero, the corners lie on a line (3). Otherwise go from C through Z. The
//!    way reaches the first side with a negative product at Z or after it. Up to there it passes no side,
//!    so the place is right of no side. The place is on that side's line. By the lemmas of `convex_exit`
//!    about places on a line it is on a side. Z lies between C and the place: it is a mean of three
//!    corners.
//! 3. *Corners on a line.* A point right of no side is on that line, and in the box between two corners.
//!    The walk along the corners from one to the other passes the point on a side.
//! 4. *Leaving* (`convex_exit`). From a held point to one that is not held, take the first side that the
//!    way reaches. Up to it the way passes no side, so the place is held and on that side's line. It is on
//!    a side, as in 2.
//! 5. *Near exactly when.* If a line separates the two, every point of the polygon is farther than r ("the
//!    polygon beyond the segment", "the segment beyond a side"). Otherwise let all sides be clear, P a
//!    point of the polygon and X one of the segment. If X is not held, the way from P to X leaves through a
//!    side, and P is farther from X than that side is. If X is held and the end C is not, the way from X to
//!    C leaves through a side. That side would be near, which is a contradiction. If C is held, the code
//!    answers near, and this is right.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::predicate::{convex_holds, convex_segment, sides};

use super::beyond::{APART, BOTH, MEAN, is_beyond, off, some};
use super::plane::{V, between_segments, share, terms, v};
use super::segments;
use crate::smt::explore::{Part, answer, explore};
use crate::smt::fact::{Fact, all, any, at_most, claim, equal, less, not};
use crate::smt::prover::{Prover, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

/// The predicates are run for polygons of up to so many corners. The step to more is by induction.
const HOLDS_MAX: usize = 3;
const SEGMENT_MAX: usize = 6;

/// The theorem about the points that a polygon holds.
pub const CONVEX_HOLDS: Theorem = Theorem {
    name: "convex_holds",
    source: "predicate::convex_holds, Convex::holds",
    claim: "yes exactly for points of the hull of the corners, when no corner is right of a side (run for \
            up to 3 corners; for more by induction over the corners: a point of the hull is a mean of \
            means; the sides add up to zero, so one falls along any direction; the way meets the first \
            side that it passes)",
    proof: |prover| {
        for count in 1..=HOLDS_MAX {
            holds_checks_all_sides(prover, count);
        }
        // A point of the hull is held.
        prover.lemma("a mean of points not right of a side is not", |[ax, ay, bx, by, px, py, qx, qy, t]| {
            let (side, p, q) = ([v(ax, ay), v(bx, by)], v(px, py), v(qx, qy));
            let given = [share(t), at_least_zero(off(side, p)), at_least_zero(off(side, q))];
            claim(given, at_least_zero(off(side, p + (q - p).times(t))))
        });
        prover.lemma("and of two below or above a bound is below or above it", |[bound, p, q, t]| {
            let mean = p + t * (q - p);
            let below = [at_most(p, bound), at_most(q, bound), less(bound, mean)];
            let above = [at_most(bound, p), at_most(bound, q), less(mean, bound)];
            claim([share(t)], not(any([all(below), all(above)])))
        });
        some_side_falls(prover);
        beyond_the_point(prover);
        corners_on_a_line(prover);
    },
};

/// The predicate checks that the point is right of no side, and between corners in both coordinates.
fn holds_checks_all_sides(prover: &mut Prover<'_>, count: usize) {
    let p = V::unknown("p");
    let corners: Vec<V> = (0..count).map(|_| p.other("c")).collect();
    let places = corners.iter().map(|c| c.place());
    let paths = explore(&[], &[], || convex_holds::<Symbolic>(places.clone(), p.place()));
    prover.ran(paths.len());
    let right_of_none = sides(corners.iter().copied()).map(|side| at_least_zero(off(side, p)));
    let one = |fact: fn(V, V) -> Fact| any(corners.iter().map(|&corner| fact(corner, p)));
    let bounds = [
        one(|c, p| at_most(c.x, p.x)),
        one(|c, p| at_most(p.x, c.x)),
        one(|c, p| at_most(c.y, p.y)),
        one(|c, p| at_most(p.y, c.y)),
    ];
    let held = all(right_of_none.chain(bounds));
    prover.chain(&format!("yes, {count} corners"), &[], &claim([some(&paths, true)], held.clone()));
    prover.chain(&format!("no, {count} corners"), &[], &claim([some(&paths, false)], not(held)));
}

/// For corners not all on a line, and Z ≠ C right of no side: the product of some side with Z − C is
/// negative.
fn some_side_falls(prover: &mut Prover<'_>) {
    prover.lemma("products add up as sides do, to zero", |[ux, uy, sx, sy, wx, wy]| {
        let (u, sum, w) = (v(ux, uy), v(sx, sy), v(wx, wy));
        let then = equal((sum + u).cross(w), sum.cross(w) + u.cross(w));
        claim([], all([then, equal(v(whole(0), whole(0)).cross(w), whole(0))]))
    });
    prover.lemma("if no term of a zero sum is negative, all are zero", |[sum, product]| {
        let given = [at_least_zero(sum), at_least_zero(product), equal(sum + product, whole(0))];
        claim(given, all([equal(sum, whole(0)), equal(product, whole(0))]))
    });
    prover.lemma("all sides along one way: the corners are on a line", |[ux, uy, sx, sy, wx, wy]| {
        // The way from one corner to another is a sum of sides.
        let (u, sum, w) = (v(ux, uy), v(sx, sy), v(wx, wy));
        let along = |u: V| equal(u.cross(w), whole(0));
        let given = [not(w.is_zero()), along(u), along(sum)];
        claim(given, all([along(u + sum), equal(u.cross(sum), whole(0))]))
    });
}

/// From a corner C through Z to the first side that the way passes: Z lies between them.
fn beyond_the_point(prover: &mut Prover<'_>) {
    prover.lemma("a side that falls is reached at Z or after it", |[ax, ay, ux, uy, cx, cy, wx, wy, way]| {
        // C + w = Z. `way`: where the side's product is zero.
        let (a, u, c, w) = (v(ax, ay), v(ux, uy), v(cx, cy), v(wx, wy));
        let f = |p: V| u.cross(p - a);
        let given = [
            at_least_zero(f(c)),
            at_least_zero(f(c + w)),
            less(u.cross(w), whole(0)),
            equal(way * u.cross(w), -f(c)),
        ];
        claim(given, all([at_most(whole(1), way), equal(f(c + w.times(way)), whole(0))]))
    });
    prover.lemma("up to the first such place the way passes no side", |[f, fall, way, first]| {
        let reached = any([at_least_zero(fall), all([equal(way * fall, -f), at_most(first, way)])]);
        claim([at_least_zero(f), at_least_zero(first), reached], at_least_zero(f + first * fall))
    });
    let (first, at) = (Term::fresh("first"), Term::fresh("at"));
    prover.define("back", &[(at_most(whole(1), first), at, first)]);
    prover.lemma(
        "Z is between C and a point of a side, so a mean of three corners",
        |[c, a, b, z, way, s, back]| {
            let there = c + way * (z - c);
            let weights = [whole(1) - back, back * (whole(1) - s), back * s];
            let mean = (weights[0] * c + weights[1] * a) + weights[2] * b;
            let given = [
                at_most(whole(1), way),
                equal(back * way, whole(1)),
                share(s),
                equal(there, a + s * (b - a)),
            ];
            let sum = equal((weights[0] + weights[1]) + weights[2], whole(1));
            claim(given, all([equal(z, mean), sum, all(weights.map(at_least_zero))]))
        },
    );
}

/// Corners on a line: a point of the line in their box lies between two of them, and on a side.
fn corners_on_a_line(prover: &mut Prover<'_>) {
    prover.lemma(
        "sides there and back: a point right of neither is on the line",
        |[ux, uy, k, wx, wy, z]| {
            // From a corner: one side is along u, another from w = z·u along −k·u.
            let (u, w, p) = (v(ux, uy), v(ux, uy).times(z), v(wx, wy));
            let given =
                [less(whole(0), k), at_least_zero(u.cross(p)), at_least_zero(u.times(-k).cross(p - w))];
            claim(given, equal(u.cross(p), whole(0)))
        },
    );
    prover.lemma("in the box: between two corners", |[ux, uy, left, right, low, high, z]| {
        let u = v(ux, uy);
        let given = [
            not(u.is_zero()),
            all([at_most(left * ux, z * ux), at_most(z * ux, right * ux)]),
            all([at_most(low * uy, z * uy), at_most(z * uy, high * uy)]),
        ];
        let corners = [left, right, low, high];
        let before = any(corners.map(|corner| at_most(corner, z)));
        claim(given, all([before, any(corners.map(|corner| at_most(z, corner)))]))
    });
    prover.lemma("one corner: the box is the corner", |[cx, cy, px, py]| {
        let (c, p) = (v(cx, cy), v(px, py));
        claim([p.is_in(c, c)], p.is(c))
    });
    prover.lemma("from one to the other the corners pass it on a side", |[from, to, z]| {
        // On the walk from a corner before z, the next corner is past z, or it is before z again.
        claim([at_most(from, z)], any([all([at_most(from, z), at_most(z, to)]), at_most(to, z)]))
    });
    let [from, to, z] = ["from", "to", "z"].map(Term::fresh);
    let (s, using) = prover.define("s", &[(less(from, to), z - from, to - from)]);
    let given = [less(from, to), at_most(from, z), at_most(z, to)];
    prover.follows(
        "with a share of it",
        &using,
        &claim(given, all([share(s), equal(z, from + s * (to - from))])),
    );
}

/// The theorem about leaving a polygon.
pub const CONVEX_EXIT: Theorem = Theorem {
    name: "convex_exit",
    source: "predicate::convex_segment",
    claim: "a straight way from a point of the polygon to a point outside meets a side (by induction over \
            the sides: it meets the first side that it reaches; where corners lie on a straight part it \
            meets some side of that part)",
    proof: |prover| {
        prover.needs(CONVEX_HOLDS.name);
        // From a point Y of the polygon to X outside. `f` is the product of a side. It is not negative
        // inside.
        prover.lemma("orientation is affine along a line", |[ax, ay, bx, by, yx, yy, xx, xy, way]| {
            let (side, inside, outside) = ([v(ax, ay), v(bx, by)], v(yx, yy), v(xx, xy));
            let f = |p: V| off(side, p);
            let there = inside + (outside - inside).times(way);
            claim([], equal(f(there), f(inside) + way * (f(outside) - f(inside))))
        });
        prover.lemma(
            "at the first side that the way reaches it has passed no other",
            |[y, x, way, first]| {
                // `way`: where this side is reached, when X is beyond it; `first`: the least of them all.
                let reached =
                    any([not(less(x, whole(0))), all([equal(way * (y - x), y), at_most(first, way)])]);
                let given = [at_least_zero(y), share(first), reached];
                claim(given, at_least_zero(y + first * (x - y)))
            },
        );
        prover.lemma("a side that is passed is reached on the way", |[y, x, way]| {
            claim(
                [at_least_zero(y), less(x, whole(0)), equal(way * (y - x), y)],
                all([share(way), equal(y + way * (x - y), whole(0))]),
            )
        });
        prover.lemma("the place of that side exists", |[y, x]| {
            claim([at_least_zero(y), less(x, whole(0))], not(equal(y - x, whole(0))))
        });
        prover.lemma("a side that is passed has a length", |[ax, ay, bx, by, xx, xy]| {
            let (a, b) = (v(ax, ay), v(bx, by));
            claim([less(off([a, b], v(xx, xy)), whole(0))], not((b - a).is_zero()))
        });
        prover.lemma("a point of a line", |[ux, uy, wx, wy, s]| {
            let (u, w) = (v(ux, uy), v(wx, wy));
            let given = [equal(u.cross(w), whole(0)), not(u.is_zero()), equal(s * u.norm_2(), u.dot(w))];
            claim(given, w.is(u.times(s)))
        });
        let u = V::unknown("u");
        prover.define("s", &[(not(u.is_zero()), Term::fresh("along"), u.norm_2())]);
        on_the_line_on_a_side(prover);
    },
};

/// The point a + s·u lies on the line of the side from a to b = a + u, and right of no side.
fn on_the_line_on_a_side(prover: &mut Prover<'_>) {
    prover.lemma("past the end the next corner is on the line", |[ux, uy, hx, hy, s]| {
        // The next corner: b + h. It is not right of a b, and the point not right of b, b + h.
        let (u, h) = (v(ux, uy), v(hx, hy));
        let given =
            [less(whole(1), s), at_least_zero(u.cross(h)), at_least_zero(h.cross(u.times(s - whole(1))))];
        claim(given, equal(u.cross(h), whole(0)))
    });
    prover.lemma("before the beginning the previous corner is on the line", |[ux, uy, gx, gy, s]| {
        // The corner before: a + g. It is not right of a b, and the point not right of a + g, a.
        let (u, g) = (v(ux, uy), v(gx, gy));
        let origin = v(whole(0), whole(0));
        let given =
            [less(s, whole(0)), at_least_zero(u.cross(g)), at_least_zero((origin - g).cross(u.times(s) - g))];
        claim(given, equal(u.cross(g), whole(0)))
    });
    prover.lemma("a next corner farther on: the point is on that side, or past it too", |[s, k, rest]| {
        // The next corner: b + k·u. The side's share of the point.
        let given = [less(whole(1), s), less(whole(0), k), equal(rest * k, s - whole(1))];
        claim(given, any([share(rest), less(whole(1), rest)]))
    });
    prover.lemma("a corner that turns back: all corners are on the line", |[ux, uy, k, cx, cy]| {
        // The side from b to b − k·u, and a corner b + c.
        let (u, c) = (v(ux, uy), v(cx, cy));
        let given = [less(whole(0), k), at_least_zero(u.cross(c)), at_least_zero(u.times(-k).cross(c))];
        claim(given, equal(u.cross(c), whole(0)))
    });
    // A walk that never turns back cannot end, but the corners come around. On a line, the point where the
    // way begins is on a side already: it is in the hull of the corners (`convex_holds`).
    prover.lemma("a walk that goes on never returns to a corner", |[at, k]| {
        claim([less(whole(0), k)], less(at, at + k))
    });
}

/// Polygon–segment.
pub const CONVEX_NEAR_SEGMENT: Theorem = Theorem {
    name: "convex_near_segment",
    source: "predicate::convex_segment, Convex::near_segment, Edge::near_convex",
    claim: "near exactly when a point of the filled polygon is within r of a point of the segment, for r \
            ≥ 0, when no corner is right of a side (run for up to 6 corners. That a polygon is clear if \
            no line separates it from the segment, all sides are clear and the end is not held follows \
            from these lemmas and those of `convex_exit` and `convex_holds`, by a written proof in \
            `theorems/convex.rs`)",
    proof: |prover| {
        prover.needs(CONVEX_HOLDS.name);
        prover.needs(CONVEX_EXIT.name);
        for count in 1..=SEGMENT_MAX {
            checks_sides_and_an_end(prover, count);
        }
        separated(prover);
        not_clear_of_a_side(prover);
        points_that_are_near(prover);
    },
};

/// Clear exactly when some line separates the two, or all sides are clear and the end is not held.
fn checks_sides_and_an_end(prover: &mut Prover<'_>, count: usize) {
    let c = V::unknown("c");
    let (d, r) = (c.other("d"), Term::fresh("r"));
    let corners: Vec<V> = (0..count).map(|_| c.other("p")).collect();
    let places = corners.iter().map(|corner| corner.place());
    let parts = [Part::Beyond, Part::SegmentSegment, Part::ConvexHolds];
    let paths = explore(&[], &parts, || {
        !convex_segment::<Symbolic>(places.clone(), [c.place(), d.place()], Scalar(r)).is_clear()
    });
    prover.ran(paths.len());
    let numbers = |points: &[V], more: &[Term]| -> Vec<Term> {
        points.iter().flat_map(|p| [p.x, p.y]).chain(more.iter().copied()).collect()
    };
    let beyond = |line: [V; 2], points: &[V]| answer(Part::Beyond, &numbers(&[&line, points].concat(), &[r]));
    let all_sides: Vec<[V; 2]> = sides(corners.iter().copied()).collect();
    // The reversed side of a segment gives the same answer: see `points_that_are_near`.
    let asked = if count == 2 { &all_sides[..1] } else { &all_sides[..] };
    let by_line = all_sides.iter().map(|&side| beyond(side, &[c, d]));
    let apart = any(by_line.chain([beyond([c, d], &corners), beyond([d, c], &corners)]));
    let near_side =
        any(asked.iter().map(|[a, b]| answer(Part::SegmentSegment, &numbers(&[*a, *b, c, d], &[r]))));
    let holds = answer(Part::ConvexHolds, &numbers(&[&corners[..], &[c]].concat(), &[]));
    let near = all([not(apart), any([near_side, holds])]);
    prover.chain(&format!("near, {count} corners"), &[], &claim([some(&paths, true)], near.clone()));
    prover.chain(&format!("clear, {count} corners"), &[], &claim([some(&paths, false)], not(near)));
}

/// A point of the polygon and one of the segment, separated by a line.
fn separated(prover: &mut Prover<'_>) {
    let c = V::unknown("c");
    let [d, a, b, p] = ["d", "a", "b", "p"].map(|name| c.other(name));
    let [r, t] = ["r", "t"].map(Term::fresh);
    let x = c + (d - c).times(t);
    let then = || less(square(r), (p - x).norm_2());
    // By the line of the segment: the corners are beyond it, and so is every point between them (`beyond`).
    let on_line = prover.lemma("a point of a segment is on its line", |[ax, ay, bx, by, t]| {
        let (a, b) = (v(ax, ay), v(bx, by));
        let there = a + (b - a).times(t);
        claim([], all([equal(off([a, b], there), whole(0)), equal(off([b, a], there), whole(0))]))
    });
    for (name, line) in [("there", [c, d]), ("back", [d, c])] {
        let apart = prover.by(&APART, Fact::True, terms(&[line[0], line[1], p, x], &[r])).0;
        let given = [at_least_zero(r), share(t), is_beyond(line, p, r)];
        let title = format!("the polygon beyond the segment, {name}");
        prover.glue(&title, &[apart, on_line.at(terms(&[c, d], &[t]))], &claim(given, then()));
    }
    // By the line of a side.
    let arguments = terms::<9>(&[a, b, c, d], &[r]);
    let beyond = answer(Part::Beyond, &arguments);
    let same = prover.fact("same distance both ways", &claim([], equal((x - p).norm_2(), (p - x).norm_2())));
    let using = [
        prover.by(&BOTH, beyond.clone(), arguments).0,
        prover.by(&MEAN, Fact::True, terms(&[a, b, c, d], &[r, t])).0,
        prover.by(&APART, Fact::True, terms(&[a, b, x, p], &[r])).0,
        same,
    ];
    let given = [beyond, at_least_zero(r), share(t), at_least_zero(off([a, b], p))];
    prover.glue("the segment beyond a side", &using, &claim(given, then()));
}

/// All sides are clear. The way from a point P of the polygon to a point X of the segment meets a side. If
/// X is held, the way on from X to the segment's end C meets one (`convex_exit`).
fn not_clear_of_a_side(prover: &mut Prover<'_>) {
    let c = V::unknown("c");
    let [d, a, b, p] = ["d", "a", "b", "p"].map(|name| c.other(name));
    let [r, t, way, s] = ["r", "t", "way", "s"].map(Term::fresh);
    let near = answer(Part::SegmentSegment, &terms::<9>(&[a, b, c, d], &[r]));
    let x = c + (d - c).times(t);
    let nearer = prover.lemma("a point on the way is as near", |[fx, fy, ox, oy, way]| {
        let (from, to) = (v(fx, fy), v(ox, oy));
        let there = from + (to - from).times(way);
        claim([share(way)], at_most((there - to).norm_2(), (from - to).norm_2()))
    });
    let seen = prover.lemma(
        "a point of a side as segments see it",
        |[ax, ay, bx, by, cx, cy, dx, dy, s, t, x, y]| {
            let (a, b, c, d) = (v(ax, ay), v(bx, by), v(cx, cy), v(dx, dy));
            let difference = between_segments([a, b], [c, d], s, t);
            let other = c + (d - c).times(t);
            let given = [v(x, y).is(a + (b - a).times(s))];
            claim(given, equal(difference.norm_2(), (v(x, y) - other).norm_2()))
        },
    );
    let there = p + (x - p).times(way);
    let using = [
        prover.by(&segments::CLEAR, near.clone(), terms(&[a, b, c, d], &[r, s, t])).0,
        nearer.at(terms(&[p, x], &[way])),
        seen.at(terms(&[a, b, c, d], &[s, t, there.x, there.y])),
    ];
    let met = |there: V| there.is(a + (b - a).times(s));
    let given = [not(near.clone()), at_least_zero(r), share(t), share(way), share(s), met(there)];
    let far = less(square(r), (p - x).norm_2());
    prover.glue("X is not held: P is farther than the side", &using, &claim(given, far));

    let back = x + (c - x).times(way);
    let at = t * (whole(1) - way);
    let on_segment = c + (d - c).times(at);
    let shares = prover.lemma("a share of a share", |[t, back]| {
        claim([share(t), share(back)], share(t * (whole(1) - back)))
    });
    let same = prover.fact("on the way back", &claim([], back.is(on_segment)));
    let touch = prover.lemma("a common point", |[ax, ay, bx, by, cx, cy, dx, dy, s, t]| {
        let (a, b, c, d) = (v(ax, ay), v(bx, by), v(cx, cy), v(dx, dy));
        let given = [(c + (d - c).times(t)).is(a + (b - a).times(s))];
        claim(given, equal(between_segments([a, b], [c, d], s, t).norm_2(), whole(0)))
    });
    let squares = prover.lemma("a square", |[r]| claim([], at_least_zero(square(r))));
    let using = [
        prover.by(&segments::CLEAR, near.clone(), terms(&[a, b, c, d], &[r, s, at])).0,
        shares.at([t, way]),
        same,
        touch.at(terms(&[a, b, c, d], &[s, at])),
        squares.at([r]),
    ];
    // This cannot be for a clear side, so X is not held.
    let given = [at_least_zero(r), share(t), share(way), share(s), met(back)];
    prover.glue("X is held, C is not: a side is near", &using, &claim(given, near));
}

/// The segment is near a side, or its end is in the polygon: then some point of the polygon is within r.
fn points_that_are_near(prover: &mut Prover<'_>) {
    let c = V::unknown("c");
    let [d, a, b] = ["d", "a", "b"].map(|name| c.other(name));
    let r = Term::fresh("r");
    let arguments = terms::<9>(&[a, b, c, d], &[r]);
    let near = answer(Part::SegmentSegment, &arguments);
    let (found, [s, t]) = prover.by(&segments::NEAR, near.clone(), arguments);
    let mean = a.times(whole(1) - s) + b.times(s);
    let distance_2 = (mean - (c + (d - c).times(t))).norm_2();
    let same = equal(between_segments([a, b], [c, d], s, t).norm_2(), distance_2);
    let same = prover.fact("a mean of two corners", &claim([], same));
    let then = all([at_least_zero(s), at_least_zero(whole(1) - s), share(t), at_most(distance_2, square(r))]);
    prover.glue("a side is near: a point of it is", &[found, same], &claim([near, at_least_zero(r)], then));
    prover.lemma("the end is held: it is within r of itself", |[cx, cy, dx, dy, r]| {
        let (c, d) = (v(cx, cy), v(dx, dy));
        claim([], at_most((c - (c + (d - c).times(whole(0)))).norm_2(), square(r)))
    });
    prover.lemma("the way back over a segment is the same", |[ax, ay, bx, by, s]| {
        let (a, b) = (v(ax, ay), v(bx, by));
        let there = b + (a - b).times(s);
        claim([share(s)], all([share(whole(1) - s), there.is(a + (b - a).times(whole(1) - s))]))
    });
}

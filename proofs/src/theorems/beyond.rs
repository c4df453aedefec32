//! Points beyond a line, and separation by a line.
//!
//! Evidence for SR-01.

use keepout_kernel::exact::predicate::beyond;

use super::plane::{V, share, terms, v};
use crate::smt::explore::{PredicatePath, explore};
use crate::smt::fact::{Fact, Implication, all, any, at_most, claim, equal, less, not};
use crate::smt::prover::{Contract, Prover, at_least_zero};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

const NAME: &str = "beyond";
/// The predicate is run with up to so many points. The step to more is by induction.
const POINTS_MAX: usize = 5;

/// Distance of `p` to the left of the line, times the length of `a b`.
pub(super) fn off([a, b]: [V; 2], p: V) -> Term {
    (b - a).cross(p - a)
}

/// Right of the line, and farther than `r` from it.
pub(super) fn is_beyond(line: [V; 2], p: V, r: Term) -> Fact {
    let length_2 = (line[1] - line[0]).norm_2();
    all([less(off(line, p), whole(0)), less(square(r) * length_2, square(off(line, p)))])
}

/// Two points: both are beyond.
pub const BOTH: Contract<9, 0> = Contract {
    theorem: NAME,
    name: "yes: both points are beyond",
    statement: |yes, [ax, ay, bx, by, cx, cy, dx, dy, r], []| {
        let line = [v(ax, ay), v(bx, by)];
        claim([yes], all([is_beyond(line, v(cx, cy), r), is_beyond(line, v(dx, dy), r)]))
    },
};

/// The set of points beyond a line is convex.
pub const MEAN: Contract<10, 0> = Contract {
    theorem: NAME,
    name: "every point between two points beyond is beyond",
    statement: |_, [ax, ay, bx, by, px, py, qx, qy, r, t], []| {
        let (line, p, q) = ([v(ax, ay), v(bx, by)], v(px, py), v(qx, qy));
        let given = [at_least_zero(r), share(t), is_beyond(line, p, r), is_beyond(line, q, r)];
        claim(given, is_beyond(line, p + (q - p).times(t), r))
    },
};

/// A point beyond the line, and one that is not right of it.
pub const APART: Contract<9, 0> = Contract {
    theorem: NAME,
    name: "a point beyond is farther than r from every point on the line or left of it",
    statement: |_, [ax, ay, bx, by, xx, xy, yx, yy, r], []| {
        let (line, x, y) = ([v(ax, ay), v(bx, by)], v(xx, xy), v(yx, yy));
        let given = [at_least_zero(r), is_beyond(line, x, r), at_least_zero(off(line, y))];
        claim(given, less(square(r), (x - y).norm_2()))
    },
};

/// Beyond a line.
pub const BEYOND: Theorem = Theorem {
    name: NAME,
    source: "predicate::beyond",
    claim: "for r ≥ 0: yes exactly when there are points, and each is right of the line and farther than \
            r from it. Then so is every point of their hull, and it is farther than r from every point on \
            the line or left of it (run with up to 5 points; for more by induction: the loop keeps the \
            point with the greatest product)",
    proof: |prover| {
        let a = V::unknown("a");
        let line = [a, a.other("b")];
        let r = Term::fresh("r");
        let points: [V; POINTS_MAX] = std::array::from_fn(|_| a.other("p"));
        for count in 1..=POINTS_MAX {
            each_is_beyond(prover, line, &points[..count], r);
        }
        let none =
            explore(&[], &[], || beyond::<Symbolic>(line.map(V::place), std::iter::empty(), Scalar(r)));
        assert!(none.iter().all(|path| !path.outcome), "without points the answer is no");
        half_plane(prover, line, r);
    },
};

/// Yes exactly when each of the points is beyond.
fn each_is_beyond(prover: &mut Prover<'_>, line: [V; 2], points: &[V], r: Term) {
    let paths = explore(&[], &[], || {
        beyond::<Symbolic>(line.map(V::place), points.iter().map(|p| p.place()), Scalar(r))
    });
    let farther = prover.lemma("farther right, greater square", |[x, y]| {
        claim([at_most(x, y), less(y, whole(0))], at_most(square(y), square(x)))
    });
    let mut using = Vec::new();
    for &p in points {
        using.extend(points.iter().filter(|&&q| q != p).map(|&q| farther.at([off(line, p), off(line, q)])));
    }
    let each = all(points.iter().map(|&p| is_beyond(line, p, r)));
    let count = points.len();
    if let &[c, d] = points {
        prover.by_parts(&BOTH, &paths, terms(&[line[0], line[1], c, d], &[r]), ([], &using));
    } else {
        prover.ran(paths.len());
    }
    prover.glue(
        &format!("yes: each of {count} is beyond"),
        &using,
        &claim([some(&paths, true)], each.clone()),
    );
    prover.glue(&format!("no: one of {count} is not"), &using, &claim([some(&paths, false)], not(each)));
}

/// On a path with this answer.
pub(super) fn some(paths: &[PredicatePath<bool>], answer: bool) -> Fact {
    any(paths.iter().filter(|path| path.outcome == answer).map(|path| all(path.conditions.clone())))
}

/// The points beyond a line form an open half-plane, at the stated distance from the line.
fn half_plane(prover: &mut Prover<'_>, line: [V; 2], r: Term) {
    let [a, b] = line;
    let [p, q] = ["p", "q"].map(|name| a.other(name));
    let t = Term::fresh("t");
    let u = b - a;
    let (length, mut using) = prover.root("length", &[], u.norm_2());
    let reach = prover.lemma("the product is compared to reach times length", |[f, r, length, length_2]| {
        let given = [at_least_zero(r), at_least_zero(length), equal(length * length, length_2)];
        let far = all([less(f, whole(0)), less(square(r) * length_2, square(f))]);
        let less_far = less(f, -(r * length));
        claim(given, all([any([not(far.clone()), less_far.clone()]), any([not(less_far), far])]))
    });
    let mean = prover.lemma("products are affine", |[ux, uy, px, py, qx, qy, t]| {
        let (u, p, q) = (v(ux, uy), v(px, py), v(qx, qy));
        let there = p + (q - p).times(t);
        claim([], equal(u.cross(there), u.cross(p) + t * (u.cross(q) - u.cross(p))))
    });
    let below = prover.lemma("a mean of two that are less", |[f, g, most, t]| {
        claim([share(t), less(f, most), less(g, most)], less(f + t * (g - f), most))
    });
    let there = p + (q - p).times(t);
    let seen = {
        let relative = (p - a) + ((q - a) - (p - a)).times(t);
        prover.fact("seen from a", &claim([], equal(off(line, there), u.cross(relative))))
    };
    let (f, g) = (off(line, p), off(line, q));
    using.extend([f, g, off(line, there)].map(|f| reach.at([f, r, length, u.norm_2()])));
    using.push(mean.at(terms(&[u, p - a, q - a], &[t])));
    using.push(below.at([f, g, -(r * length), t]));
    using.push(seen);
    prover.establish(&MEAN, Fact::True, terms(&[a, b, p, q], &[r, t]), ([], &using));

    let difference = prover.fact("the product of a difference", &{ claim([], equal(u.cross(q - p), g - f)) });
    let cauchy = prover.lemma("a product is at most that of the lengths", |[ux, uy, wx, wy]| {
        let (u, w) = (v(ux, uy), v(wx, wy));
        claim([], at_most(square(u.cross(w)), u.norm_2() * w.norm_2()))
    });
    let wide = prover.lemma("so the vector is longer", |[product, r, length, length_2, way_2]| {
        let given = [
            at_least_zero(r),
            at_least_zero(length),
            equal(length * length, length_2),
            less(r * length, product),
            at_most(square(product), length_2 * way_2),
        ];
        claim(given, less(square(r), way_2))
    });
    let same = Implication { given: Vec::new(), then: equal((q - p).norm_2(), (p - q).norm_2()) };
    let same = prover.fact("same distance both ways", &same);
    using.push(difference);
    using.push(cauchy.at(terms(&[u, q - p], &[])));
    using.push(wide.at([u.cross(q - p), r, length, u.norm_2(), (q - p).norm_2()]));
    using.push(same);
    prover.establish(&APART, Fact::True, terms(&[a, b, p, q], &[r]), ([], &using));
}

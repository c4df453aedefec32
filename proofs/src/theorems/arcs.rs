//! Arcs: rings, the chord-error bound of chords, and the rules by which a swept arc is clear of a chord.
//!
//! Evidence for SR-02.

use keepout_kernel::exact::predicate::{ahead, on_ring, sagitta};

use super::near::{FARTHER, LONGER};
use super::plane::{V, share, terms, v};
use crate::smt::explore::explore;
use crate::smt::fact::{Fact, all, any, at_most, claim, equal, less, not};
use crate::smt::prover::{Contract, Instance, Prover, at_least_zero, positive};
use crate::smt::run::Theorem;
use crate::smt::symbolic::{Scalar, Symbolic};
use crate::smt::term::{Term, square, whole};

/// Rounding of an arc's ends and of its chords' corners, inward and outward, as in `arc.rs`.
const ENDS: (i8, i8) = (1, 2);
const CORNERS: (i8, i8) = (2, 3);

const CHORD_ERROR_BOUND: &str = "chord_error_bound";
const CORNER: &str = "swept_arc_corner";

fn number(units: i8) -> Term {
    whole(units.into())
}

/// Whether the square is that of a length between ρ − inward and ρ + outward.
fn in_ring(square_of: Term, rho: Term, (inward, outward): (i8, i8)) -> Fact {
    let (least, most) = (rho - number(inward), rho + number(outward));
    all([at_most(square(least), square_of), at_most(square_of, square(most))])
}

/// The theorem about rings.
pub const ON_RING: Theorem = Theorem {
    name: "on_ring",
    source: "predicate::on_ring, Arc::has_on_circle",
    claim: "yes exactly when the distance from the centre is between ρ − inward and ρ + outward, for ρ ≥ 64",
    proof: |prover| {
        let centre = V::unknown("centre");
        let p = centre.other("p");
        let rho = Term::fresh("rho");
        for ring in [ENDS, CORNERS] {
            let paths = explore(&[], &[], || {
                on_ring::<Symbolic>(p.place(), centre.place(), Scalar(rho), ring.0, ring.1)
            });
            let is = in_ring((p - centre).norm_2(), rho, ring);
            prover.on_paths(&format!("ring {ring:?}"), &paths, |&yes| {
                claim([at_most(whole(64), rho)], if yes { is.clone() } else { not(is.clone()) })
            });
        }
    },
};

/// The theorem about the sagitta's quotient.
pub const SAGITTA: Theorem = Theorem {
    name: "sagitta",
    source: "predicate::sagitta",
    claim: "the answer is more than L² / 7ρ, for ρ ≥ 64",
    proof: |prover| {
        let [length_2, rho] = ["L2", "rho"].map(Term::fresh);
        let paths = explore(&[], &[], || sagitta::<Symbolic>(length_2, Scalar(rho)));
        prover.on_paths("more", &paths, |&answer| {
            let given = [at_least_zero(length_2), at_most(whole(64), rho)];
            claim(given, all([less(length_2, answer * (whole(7) * rho)), at_most(whole(1), answer)]))
        });
    },
};

/// The conditions on a chord of an arc: corners in the ring, no longer than ρ, ρ ≥ 64. The centre is the
/// origin.
fn is_chord(a: V, b: V, rho: Term) -> Fact {
    let corners = [a, b].map(|corner| in_ring(corner.norm_2(), rho, CORNERS));
    all(corners.into_iter().chain([at_most((b - a).norm_2(), square(rho)), at_most(whole(64), rho)]))
}

/// The least distance of a chord from the centre.
const CHORD_DISTANCE: Contract<6, 0> = Contract {
    theorem: CHORD_ERROR_BOUND,
    name: "four times the square of a chord point's distance is at least 4(ρ − 2)² − L²",
    statement: |_, [ax, ay, bx, by, rho, m], []| {
        let (a, b) = (v(ax, ay), v(bx, by));
        let on_chord = (a + (b - a).times(m)).norm_2();
        let least = whole(4) * square(rho - whole(2)) - (b - a).norm_2();
        let most = square(rho + whole(3));
        claim(
            [is_chord(a, b, rho), share(m)],
            all([at_most(least, whole(4) * on_chord), at_most(on_chord, most)]),
        )
    },
};

/// The theorem about the chord-error bound of chords.
pub const CHORD_ERROR: Theorem = Theorem {
    name: CHORD_ERROR_BOUND,
    source: "ArcChords::check, SweptArc::chord_error",
    claim: "a point of the curve at the polar angle of a point of the chord is within sagitta + 4 of that \
            point: ⌊L² / 7ρ⌋ + 1 + 4",
    proof: |prover| {
        let [a, b] = ["a", "b"].map(V::unknown);
        let [rho, m, k, sigma] = ["rho", "m", "k", "sigma"].map(Term::fresh);
        let on_chord = a + (b - a).times(m);
        let (length_2, y_2) = ((b - a).norm_2(), on_chord.norm_2());
        let identity = prover.lemma("the square of a mean", |[ax, ay, bx, by, m]| {
            let (a, b) = (v(ax, ay), v(bx, by));
            let rest = whole(1) - m;
            let mean = (rest * a.norm_2() + m * b.norm_2()) - (m * rest) * (b - a).norm_2();
            claim([], equal((a + (b - a).times(m)).norm_2(), mean))
        });
        let bounds = prover.lemma("whose parts are bounded", |[a_2, b_2, length_2, rho, m]| {
            let rest = whole(1) - m;
            let mean = (rest * a_2 + m * b_2) - (m * rest) * length_2;
            let given =
                [share(m), in_ring(a_2, rho, CORNERS), in_ring(b_2, rho, CORNERS), at_least_zero(length_2)];
            let least = whole(4) * square(rho - whole(2)) - length_2;
            claim(given, all([at_most(least, whole(4) * mean), at_most(mean, square(rho + whole(3)))]))
        });
        let squares = prover.lemma("a square", |[x, y]| claim([], at_least_zero(v(x, y).norm_2())));
        let using = [
            identity.at([a.x, a.y, b.x, b.y, m]),
            bounds.at([a.norm_2(), b.norm_2(), length_2, rho, m]),
            squares.at([(b - a).x, (b - a).y]),
        ];
        prover.establish(&CHORD_DISTANCE, Fact::True, [a.x, a.y, b.x, b.y, rho, m], ([], &using));

        let (y, mut using) = prover.root("y", &[], y_2);
        using.push(prover.by(&CHORD_DISTANCE, Fact::True, [a.x, a.y, b.x, b.y, rho, m]).0);
        using.push(squares.at([(b - a).x, (b - a).y]));
        // σ is at least L² / 7ρ. The chord leaves the ring of its corners by no more than σ.
        let depth = prover.lemma("the sagitta", |[length_2, rho, sigma]| {
            let given = [
                at_most(whole(64), rho),
                at_least_zero(length_2),
                at_most(length_2, square(rho)),
                at_most(length_2, sigma * (whole(7) * rho)),
                at_most(sigma, rho - whole(2)),
            ];
            let least = whole(4) * square(rho - whole(2)) - length_2;
            claim(given, at_most(whole(4) * square((rho - whole(2)) - sigma), least))
        });
        using.push(depth.at([length_2, rho, sigma]));
        let roots = prover.lemma("roots keep the order", |[u, w]| {
            claim([at_most(square(u), square(w)), at_least_zero(w)], at_most(u, w))
        });
        // The curve's point lies at k times the chord's, and its distance is k·y.
        let x = k * y;
        for (u, w) in
            [((rho - whole(2)) - sigma, y), (y, rho + whole(3)), (rho - whole(1), x), (x, rho + whole(2))]
        {
            using.push(roots.at([u, w]));
        }
        let curve = on_chord.times(k);
        let scaled = prover.lemma("the distance along the ray", |[x, y, k, length]| {
            let (p, given) = (v(x, y), equal(length * length, v(x, y).norm_2()));
            let apart = (p.times(k) - p).norm_2();
            let difference = k * length - length;
            claim(
                [given],
                all([equal(apart, square(difference)), equal(p.times(k).norm_2(), square(k * length))]),
            )
        });
        using.push(scaled.at([on_chord.x, on_chord.y, k, y]));
        let product = prover
            .lemma("products", |[k, y]| claim([at_least_zero(k), at_least_zero(y)], at_least_zero(k * y)));
        using.push(product.at([k, y]));
        let bounded = prover.lemma("squares keep the order", |[d, most]| {
            claim([at_most(d, most), at_most(-d, most)], at_most(square(d), square(most)))
        });
        let chord_error = sigma + whole(4);
        using.push(bounded.at([x - y, chord_error]));
        let given = [
            is_chord(a, b, rho),
            share(m),
            at_least_zero(k),
            in_ring(curve.norm_2(), rho, ENDS),
            at_least_zero(sigma),
            at_most(length_2, sigma * (whole(7) * rho)),
        ];
        let then = at_most((curve - on_chord).norm_2(), square(chord_error));
        prover.glue("the chord-error bound", &using, &claim(given, then));
    },
};

/// The theorem about the rules of swept arcs.
pub const SWEPT_RULES: Theorem = Theorem {
    name: "swept_arc_rules",
    source: "SweptArc::near_chord, piece_clear",
    claim: "let s be the chord-error bound of a chord of the arc: a chord within ρ − 2 − t of the centre, \
            beyond ρ + 2 + t from it, or farther than t + s from that chord of the arc is farther than t \
            from the curve",
    proof: |prover| {
        let [curve, chord, foot] = ["curve", "chord", "foot"].map(V::unknown);
        let [rho, t, chord_error] = ["rho", "t", "chord_error"].map(Term::fresh);
        let on_curve = in_ring(curve.norm_2(), rho, ENDS);
        let far = less(square(t), (curve - chord).norm_2());
        let sizes = [at_least_zero(t), at_most(whole(64), rho)];
        let numbers = |p: V, q: V, a: Term, b: Term| terms(&[p, q], &[a, b]);
        let same = prover.lemma("either way about", |[x, y, z, w]| {
            claim([], equal((v(x, y) - v(z, w)).norm_2(), (v(z, w) - v(x, y)).norm_2()))
        });
        let turned = same.at([curve.x, curve.y, chord.x, chord.y]);
        let squares = prover.lemma("squares keep the order", |[a, b]| {
            claim([at_least_zero(a), less(a, b)], less(square(a), square(b)))
        });
        // Inside: the ends, and so all of the chord, lie within ρ − 2 − t of the centre.
        let reach = (rho - whole(2)) - t;
        let step = prover.by(&LONGER, Fact::True, numbers(curve, chord, rho - whole(1), reach)).0;
        let gap = (rho - whole(1)) - reach;
        let using = [step, squares.at([t, gap])];
        let [one, two] = sizes.clone();
        let given =
            [one, two, on_curve.clone(), at_least_zero(reach), at_most(chord.norm_2(), square(reach))];
        prover.glue("inside", &using, &claim(given, far.clone()));
        // Outside.
        let reach = (rho + whole(2)) + t;
        let step = prover.by(&FARTHER, Fact::True, numbers(chord, curve, reach, rho + whole(2))).0;
        let left = prover.fact("the rest", &claim([], equal(square(reach - (rho + whole(2))), square(t))));
        let [one, two] = sizes.clone();
        let given = [one, two, on_curve, less(square(reach), chord.norm_2())];
        prover.glue("outside", &[step, left, turned.clone()], &claim(given, far.clone()));
        // Beside a chord of the arc.
        let reach = t + chord_error;
        let (from_foot, to_curve) = (chord - foot, curve - foot);
        let step = prover.by(&FARTHER, Fact::True, numbers(from_foot, to_curve, reach, chord_error)).0;
        let left = prover.fact("the rest", &claim([], equal(square(reach - chord_error), square(t))));
        let whole_way = prover.fact(
            "by way of the foot",
            &claim([], equal((from_foot - to_curve).norm_2(), (chord - curve).norm_2())),
        );
        let given = [
            at_least_zero(t),
            at_least_zero(chord_error),
            less(square(reach), from_foot.norm_2()),
            at_most(to_curve.norm_2(), square(chord_error)),
        ];
        prover.glue("beside a chord", &[step, left, whole_way, turned], &claim(given, far));
    },
};

/// The theorem about chords behind a corner.
pub const SWEPT_CORNER: Theorem = Theorem {
    name: CORNER,
    source: "predicate::ahead, SweptArc::behind_corner",
    claim: "a chord that begins at the centre, to 3 units, and leads away from a piece of the arc is \
            farther than t from that piece, for ρ ≥ t + 13",
    proof: |prover| {
        // `ahead`, with the direction's length.
        let origin = V::unknown("origin");
        let [p, from] = ["p", "from"].map(|name| origin.other(name));
        let to = from.other("to");
        let length = Term::fresh("length");
        let paths =
            explore(&[], &[], || ahead::<Symbolic>(origin.place(), p.place(), from.place(), to.place(), 4));
        let is_length = all([at_least_zero(length), equal(square(length), (to - from).norm_2())]);
        prover.on_paths("ahead", &paths, |&yes| {
            let (along, reach) = ((p - origin).dot(to - from), whole(4) * length);
            claim([is_length.clone()], if yes { less(reach, along) } else { at_most(along, reach) })
        });

        let [a, b, e, corner] = ["a", "b", "e", "v"].map(V::unknown);
        let [rho, t, alpha, beta, way] = ["rho", "t", "alpha", "beta", "way"].map(Term::fresh);
        let curve = a.times(alpha) + b.times(beta);
        let (length, mut using) = prover.root("length", &[], e.norm_2());
        using.extend(at_most_five_quarters(prover, [a, b], [rho, alpha, beta]));
        let reach = prover.lemma(
            "the curve is at most 5 ahead of the centre",
            |[ax, ay, bx, by, ex, ey, p, q, length]| {
                let (a, b, e) = (v(ax, ay), v(bx, by), v(ex, ey));
                let given = [
                    at_least_zero(p),
                    at_least_zero(q),
                    at_most(whole(4) * (p + q), whole(5)),
                    at_least_zero(length),
                    at_most(a.dot(e), whole(4) * length),
                    at_most(b.dot(e), whole(4) * length),
                ];
                claim(given, at_most((a.times(p) + b.times(q)).dot(e), whole(5) * length))
            },
        );
        using.push(reach.at(terms(&[a, b, e], &[alpha, beta, length])));
        let behind = prover.lemma("the corner is at most 3 behind the centre", |[x, y, ex, ey, length]| {
            let (p, e) = (v(x, y), v(ex, ey));
            let given =
                [at_most(p.norm_2(), whole(9)), at_least_zero(length), equal(length * length, e.norm_2())];
            claim(given, at_most(-(whole(3) * length), p.dot(e)))
        });
        using.push(behind.at(terms(&[corner, e], &[length])));
        let between = curve - corner;
        let split = claim([], equal(between.dot(e), curve.dot(e) - corner.dot(e)));
        using.push(prover.fact("from the corner", &split));
        let apart = terms(&[curve, corner], &[rho - whole(1), whole(3)]);
        using.push(prover.by(&LONGER, Fact::True, apart).0);
        let squares = prover.lemma("squares keep the order", |[a, b]| {
            claim([at_least_zero(a), at_most(a, b)], at_most(square(a), square(b)))
        });
        using.push(squares.at([t + whole(9), (rho - whole(1)) - whole(3)]));
        using.extend(passed(prover, (between, e), [length, way, t]));
        let on_line = corner + e.times(way);
        let distance = equal((between - e.times(way)).norm_2(), (curve - on_line).norm_2());
        using.push(prover.fact("the point of the chord", &claim([], distance)));
        let given = [
            is_chord(a, b, rho),
            at_least_zero(alpha),
            at_least_zero(beta),
            in_ring(curve.norm_2(), rho, ENDS),
            at_most(a.dot(e), whole(4) * length),
            at_most(b.dot(e), whole(4) * length),
            at_most(corner.norm_2(), whole(9)),
            at_least_zero(t),
            at_most(t + whole(13), rho),
            at_least_zero(way),
        ];
        prover.glue("behind the corner", &using, &claim(given, less(square(t), (curve - on_line).norm_2())));
    },
};

/// A line of direction e passes q at more than t, if q is at most 8 ahead and at least t + 9 away.
fn passed(prover: &mut Prover<'_>, (q, e): (V, V), [length, way, t]: [Term; 3]) -> [Instance; 3] {
    let expanded = prover.lemma("the square of a difference", |[x, y, ex, ey, length, way]| {
        let (q, e) = (v(x, y), v(ex, ey));
        let squares = (q.norm_2() - whole(2) * (way * q.dot(e))) + square(way * length);
        claim([equal(length * length, e.norm_2())], equal((q - e.times(way)).norm_2(), squares))
    });
    let ahead = prover.lemma("at most 8 lengths ahead", |[way, along, length]| {
        let given = [at_least_zero(way), at_most(along, whole(8) * length)];
        claim(given, at_most(way * along, whole(8) * (way * length)))
    });
    let far = prover.lemma("at least t + 9, less 8", |[q_2, ahead, z, t]| {
        let given = [at_least_zero(t), at_most(square(t + whole(9)), q_2), at_most(ahead, whole(8) * z)];
        claim(given, less(square(t), (q_2 - whole(2) * ahead) + square(z)))
    });
    [
        expanded.at(terms(&[q, e], &[length, way])),
        ahead.at([way, q.dot(e), length]),
        far.at([q.norm_2(), way * q.dot(e), way * length, t]),
    ]
}

/// A curve point αa + βb has α + β ≤ 5/4.
fn at_most_five_quarters(
    prover: &mut Prover<'_>,
    [a, b]: [V; 2],
    [rho, alpha, beta]: [Term; 3],
) -> Vec<Instance> {
    let sum = alpha + beta;
    let some = positive(sum);
    let (m, mut using) = prover.define("m", &[(some.clone(), beta, sum), (not(some), whole(0), whole(1))]);
    let on_chord = a + (b - a).times(m);
    using.push(prover.by(&CHORD_DISTANCE, Fact::True, terms(&[a, b], &[rho, m])).0);
    let part = prover.lemma("a part of two", |[p, q, m]| {
        let sum = p + q;
        let defined =
            all([any([not(positive(sum)), equal(m * sum, q)]), any([positive(sum), equal(m, whole(0))])]);
        claim([at_least_zero(p), at_least_zero(q), defined], share(m))
    });
    using.push(part.at([alpha, beta, m]));
    let ray = prover.lemma("on the ray of a chord point", |[ax, ay, bx, by, p, q, m]| {
        let (a, b, sum) = (v(ax, ay), v(bx, by), p + q);
        let on_chord = a + (b - a).times(m);
        let curve = a.times(p) + b.times(q);
        claim([equal(m * sum, q)], equal(curve.norm_2(), square(sum) * on_chord.norm_2()))
    });
    using.push(ray.at(terms(&[a, b], &[alpha, beta, m])));
    let curve = (a.times(alpha) + b.times(beta)).norm_2();
    let bound = prover.lemma("the point cannot be farther out", |[y_2, curve, sum, rho, length_2]| {
        let given = [
            at_most(whole(64), rho),
            at_least_zero(sum),
            at_most(length_2, square(rho)),
            at_most(whole(4) * square(rho - whole(2)) - length_2, whole(4) * y_2),
            at_most(curve, square(rho + whole(2))),
            equal(curve, square(sum) * y_2),
        ];
        claim(given, at_most(whole(4) * sum, whole(5)))
    });
    using.push(bound.at([on_chord.norm_2(), curve, sum, rho, (b - a).norm_2()]));
    using
}

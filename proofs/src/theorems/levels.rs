//! The third axis: levels, and the lowest height of the in-flight set.
//!
//! Evidence for SR-06.

use super::plane::{V, share, v};
use super::winding::{RING_PARITY, odd};
use crate::smt::fact::{all, any, at_most, between, claim, equal, less, same};
use crate::smt::prover::at_least_zero;
use crate::smt::run::Theorem;
use crate::smt::term::Term;

/// The theorem that a certificate at a height holds at every greater height.
pub const MONOTONE: Theorem = Theorem {
    name: "levels_are_monotone",
    source: "kernel: levels::Levels::new, Levels::at",
    claim: "the prohibited region of a height contains that of every greater height; a shape outside the \
            one and farther than a threshold from its outline is so for the other; a level's outlines \
            are those with exactly one face of the level beside them",
    proof: |prover| {
        prover.lemma("a top above the higher tip is above the lower tip", |[low, high, top]| {
            claim([at_most(low, high), less(high, top)], less(low, top))
        });
        prover.lemma("a face of a level is a face of every level below", |[face, upper, lower]| {
            claim([at_most(lower, upper), at_most(upper, face)], at_most(lower, face))
        });
        // From face to face outward, the level is entered or left at exactly its outlines.
        prover.lemma("across an outline", |[inner, outer, top]| {
            let (inside, outside) = (at_most(top, inner), at_most(top, outer));
            let outline = odd(inside.clone(), outside.clone());
            claim([], same(&inside, &odd(outside, outline)))
        });
        // A line from a shape outside the level to a point of it touches its outline on the way.
        prover.needs(RING_PARITY.name);
        prover.lemma("a point on the way is no farther", |[px, py, qx, qy, way]| {
            let (p, q) = (v(px, py), v(qx, qy));
            claim([share(way)], at_most((q - p).times(way).norm_2(), (q - p).norm_2()))
        });
        let [p, on, q] = ["p", "on", "q"].map(V::unknown);
        let r = Term::fresh("r");
        let given = [less(r, (on - p).norm_2()), at_most((on - p).norm_2(), (q - p).norm_2())];
        prover
            .prove("so the end is farther than the threshold, too", &claim(given, less(r, (q - p).norm_2())));
    },
};

/// The theorem that the lowest height of the in-flight set bounds every motion from below.
pub const LOWEST: Theorem = Theorem {
    name: "lowest_height_suffices",
    source: "executor: guard::in_flight::InFlight::lowest",
    claim: "a tool that is at most e below the lowest height of the set, and moves to a target of the set, \
            stays at most e below it: on a straight motion, with non-interpolated axes, and when the \
            motion is interrupted; a report within e that raises the lowest height keeps this true",
    proof: |prover| {
        prover.lemma("a straight motion", |[low, e, from, to, way]| {
            let given = [at_least_zero(e), at_most(low - e, from), at_most(low, to), share(way)];
            claim(given, at_most(low - e, from + way * (to - from)))
        });
        prover.lemma("a motion of non-interpolated axes", |[low, e, from, to, height]| {
            let passes = any([between(from, height, to), between(to, height, from)]);
            let given = [at_least_zero(e), at_most(low - e, from), at_most(low, to), passes];
            claim(given, at_most(low - e, height))
        });
        prover.lemma(
            "an interrupted motion, and one to another target",
            |[low, e, from, to, next, way, on]| {
                let stop = from + way * (to - from);
                let given = [
                    all([at_least_zero(e), at_most(low - e, from)]),
                    all([at_most(low, to), at_most(low, next)]),
                    all([share(way), share(on)]),
                ];
                claim(given, at_most(low - e, stop + on * (next - stop)))
            },
        );
        prover.lemma("a report within e gives the confirmed height", |[low, e, tool, report, confirmed]| {
            let highest = any([
                all([at_most(low, report), equal(confirmed, report)]),
                all([at_most(report, low), equal(confirmed, low)]),
            ]);
            let given = [at_most(low - e, tool), at_most(report - e, tool), highest];
            claim(given, at_most(confirmed - e, tool))
        });
        prover.lemma("a target that leaves the set raises the lowest height", |[low, e, tool, least, to]| {
            // What is left: the confirmed height and later targets, of which `least` is the lowest.
            let given = [at_least_zero(e), at_most(least - e, tool), at_most(least, to), at_most(low, least)];
            claim(given, all([at_most(low - e, tool), at_most(low, to)]))
        });
        prover.lemma(
            "after a stop beside the path, at most its reach lower",
            |[low, e, stray, tool, after]| {
                let given = [at_most(low - e, tool), at_most(tool - stray, after)];
                claim(given, at_most((low - stray) - e, after))
            },
        );
    },
};

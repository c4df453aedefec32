//! The boxes that an index skips around a polygon.
//!
//! Evidence for SR-03.

use super::beyond::off;
use super::boxes;
use super::plane::{V, terms, v};
use crate::smt::fact::{Fact, Implication, all, at_most, claim, less};
use crate::smt::prover::at_least_zero;
use crate::smt::run::Theorem;
use crate::smt::term::{Term, square};

/// The theorem about boxes that a query around a polygon may skip.
pub const POLYGON_PRUNING: Theorem = Theorem {
    name: "polygon_pruning",
    source: "index::query (Around), Window::grown, side_of",
    claim: "let a polygon not lie right of a side's line: a box that, grown by T, is wholly right of that \
            line holds no point within T of the polygon. Boxes hold chords grown by their chord-error \
            bound s, so such a box holds no chord within T + s",
    proof: |prover| {
        let low = V::unknown("low");
        let [high, a, b, x] = ["high", "a", "b", "x"].map(|name| low.other(name));
        let (t, chord_error) = (Term::fresh("T"), Term::fresh("chord_error"));
        let c = x + V::unknown("way");
        let way = c - x;
        let grown = [low - v(t, t), high + v(t, t)];
        let components = prover.lemma("a distance bounds its components", |[dx, dy, r]| {
            let given = [at_least_zero(r), at_most(v(dx, dy).norm_2(), square(r))];
            let within = |d: Term| all([at_most(-r, d), at_most(d, r)]);
            claim(given, all([within(dx), within(dy)]))
        });
        let right = Fact::Answer("the grown box is right of the side".to_owned());
        let arguments = terms(&[grown[0], grown[1], a, b, x], &[]);
        let using = [
            components.at([way.x, way.y, t + chord_error]),
            prover.by(&boxes::RIGHT, right.clone(), arguments).0,
        ];
        let given = vec![
            all([at_least_zero(t), at_least_zero(chord_error)]),
            c.is_in(low + v(chord_error, chord_error), high - v(chord_error, chord_error)),
            at_least_zero(off([a, b], x)),
            right,
        ];
        let then = less(square(t + chord_error), way.norm_2());
        prover.glue(
            "a chord's point in the box, the bound from its border",
            &using,
            &Implication { given, then },
        );
    },
};

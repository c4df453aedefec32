//! Proof that no operation overflows at the product's width.
//!
//! The magnitude of every result is computed from the magnitudes of a function's inputs, operation by
//! operation. The solver confirms each step: operands within their magnitudes give a result within the
//! claimed magnitude, and that magnitude fits the width. The magnitude of a part holds on every path that
//! leads there.

use std::collections::HashMap;

use super::fact::between;
use super::prover::Prover;
use super::symbolic::Width;
use super::term::{Term, TermNode, whole};

/// The largest magnitudes of the unknowns.
#[derive(Clone, Debug, Default)]
pub struct Ranges {
    most: HashMap<Term, i128>,
}

impl Ranges {
    /// Sets the largest magnitude of an unknown.
    pub fn set(&mut self, unknown: Term, most: i128) {
        self.most.insert(unknown, most);
    }

    /// Proves that every operation fits its width.
    pub fn prove(&mut self, prover: &mut Prover<'_>, operations: &[(Term, Width)]) {
        let mut steps = HashMap::new();
        for &(term, width) in operations {
            self.magnitude(term);
            let (a, b) = match term.parts().as_slice() {
                &[a, b] => (self.magnitude(a), self.magnitude(b)),
                _ => continue,
            };
            let sign = std::mem::discriminant(&term.node());
            steps.entry((sign, a, b, width)).or_insert((term, a, b));
        }
        let mut steps: Vec<_> = steps.into_iter().map(|((_, _, _, width), step)| (step, width)).collect();
        steps.sort_unstable();
        for ((term, a, b), width) in steps {
            self.step(prover, term, (a, b), width);
        }
    }

    fn magnitude(&mut self, term: Term) -> i128 {
        if let Some(&most) = self.most.get(&term) {
            return most;
        }
        let most = match term.node() {
            TermNode::Variable(name) => unreachable!("{name} has no range"),
            TermNode::Whole(value) => value.saturating_abs(),
            TermNode::Sum(a, b) | TermNode::Difference(a, b) => self.magnitude(a) + self.magnitude(b),
            TermNode::Product(a, b) => self.magnitude(a) * self.magnitude(b),
            TermNode::Quotient(a, _) => self.magnitude(a),
        };
        self.most.insert(term, most);
        most
    }

    fn step(&mut self, prover: &mut Prover<'_>, term: Term, (a, b): (i128, i128), width: Width) {
        let (x, y) = (Term::fresh("x"), Term::fresh("y"));
        let (sign, result) = match term.node() {
            TermNode::Sum(..) => ("+", x + y),
            TermNode::Difference(..) => ("-", x - y),
            TermNode::Product(..) => ("·", x * y),
            // `quotient` requires a ≥ 0 and b > 0, and b is whole.
            TermNode::Quotient(..) => return self.quotient(prover, (a, b), width),
            _ => return,
        };
        let given = [between(whole(-a), x, whole(a)), between(whole(-b), y, whole(b))];
        let most = self.magnitude(term);
        prover.bounded(&format!("{a} {sign} {b} is at most {most}"), &given, result, most);
        prover.bounded(
            &format!("{most} fits {width:?}"),
            &[between(whole(-most), x, whole(most))],
            x,
            limit(width),
        );
    }

    fn quotient(&mut self, prover: &mut Prover<'_>, (a, b): (i128, i128), width: Width) {
        let (x, y) = (Term::fresh("x"), Term::fresh("y"));
        let given = [between(whole(0), x, whole(a)), between(whole(1), y, whole(b))];
        let result = Term::of(TermNode::Quotient(x, y));
        prover.bounded(&format!("{a} / {b} is at most {a}"), &given, result, a);
        prover.bounded(&format!("{a} fits {width:?}"), &given, x, limit(width));
    }
}

fn limit(width: Width) -> i128 {
    match width {
        Width::Linear => i32::MAX.into(),
        Width::Area => i64::MAX.into(),
        Width::Volume => i128::MAX,
    }
}

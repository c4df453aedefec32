//! SMT-LIB text of a question.

use std::collections::{BTreeSet, HashSet};
use std::fmt::Write;

use super::fact::{Fact, Relation};
use super::term::{Term, TermNode};

/// How much of the arithmetic the solver sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// All of it: polynomials over the reals.
    Whole,
    /// Sums only: every product of two unknowns is a new unknown. A refutation of this weaker question is
    /// valid.
    Sums,
}

/// The text that asks whether all the facts can hold together.
#[must_use]
pub fn script(title: &str, facts: &[Fact], arithmetic: Arithmetic) -> String {
    let mut text = String::new();
    for line in title.lines() {
        let _ = writeln!(text, "; {line}");
    }
    let logic = if arithmetic == Arithmetic::Whole { "QF_NRA" } else { "QF_LRA" };
    let _ = writeln!(text, "(set-logic {logic})");
    let terms = terms_of(facts, arithmetic);
    let mut side = Vec::new();
    for &term in &terms {
        declare(&mut text, term, arithmetic, &mut side);
    }
    let mut answers = BTreeSet::new();
    for fact in facts {
        fact.visit_answers(&mut |name| {
            answers.insert(name.to_owned());
        });
    }
    for name in answers {
        let _ = writeln!(text, "(declare-const |{name}| Bool)");
    }
    for fact in &side {
        let _ = writeln!(text, "(assert {fact})");
    }
    for fact in facts {
        let _ = writeln!(text, "(assert {})", write_fact(fact));
    }
    text.push_str("(check-sat)\n");
    text
}

/// The terms that the facts need, parts first.
fn terms_of(facts: &[Fact], arithmetic: Arithmetic) -> Vec<Term> {
    let mut seen = HashSet::new();
    let mut open = Vec::new();
    for fact in facts {
        fact.visit_terms(&mut |term| open.push(term));
    }
    while let Some(term) = open.pop() {
        if seen.insert(term) && !(arithmetic == Arithmetic::Sums && is_unknown_product(term)) {
            open.extend(term.parts());
        }
    }
    let mut terms: Vec<Term> = seen.into_iter().collect();
    terms.sort_unstable();
    terms
}

fn is_unknown_product(term: Term) -> bool {
    let is_number = |term: Term| matches!(term.node(), TermNode::Whole(_));
    match term.node() {
        TermNode::Product(a, b) => !is_number(a) && !is_number(b),
        TermNode::Quotient(..) => true,
        _ => false,
    }
}

fn declare(text: &mut String, term: Term, arithmetic: Arithmetic, side: &mut Vec<String>) {
    let name = name(term);
    let mut define = |body: String| {
        let _ = writeln!(text, "(define-fun {name} () Real {body})");
    };
    match term.node() {
        TermNode::Whole(_) => {}
        TermNode::Variable(_) => {
            let _ = writeln!(text, "(declare-const {name} Real)");
        }
        _ if arithmetic == Arithmetic::Sums && is_unknown_product(term) => {
            let _ = writeln!(text, "(declare-const {name} Real)");
        }
        TermNode::Sum(a, b) => define(format!("(+ {} {})", self::name(a), self::name(b))),
        TermNode::Difference(a, b) => define(format!("(- {} {})", self::name(a), self::name(b))),
        TermNode::Product(a, b) => define(format!("(* {} {})", self::name(a), self::name(b))),
        TermNode::Quotient(a, b) => {
            let (a, b) = (self::name(a), self::name(b));
            let _ = writeln!(text, "(declare-const {name} Real)");
            side.push(format!(
                "(=> (and (>= {a} 0.0) (> {b} 0.0)) \
                 (and (<= 0.0 {name}) (<= (* {name} {b}) {a}) (< {a} (* (+ {name} 1.0) {b}))))"
            ));
        }
    }
}

fn name(term: Term) -> String {
    match term.node() {
        TermNode::Variable(name) => format!("|{name}|"),
        TermNode::Whole(value) if value < 0 => format!("(- {}.0)", value.unsigned_abs()),
        TermNode::Whole(value) => format!("{value}.0"),
        _ => format!("t{}", term.number()),
    }
}

fn write_fact(fact: &Fact) -> String {
    let join = |facts: &[Fact]| facts.iter().map(write_fact).collect::<Vec<_>>().join(" ");
    match fact {
        Fact::True => "true".to_owned(),
        Fact::False => "false".to_owned(),
        Fact::Compare(relation, a, b) => {
            let sign = match relation {
                Relation::Less => "<",
                Relation::AtMost => "<=",
                Relation::Equal => "=",
            };
            format!("({sign} {} {})", name(*a), name(*b))
        }
        Fact::Answer(name) => format!("|{name}|"),
        Fact::Not(fact) => format!("(not {})", write_fact(fact)),
        Fact::All(facts) => format!("(and {})", join(facts)),
        Fact::Any(facts) => format!("(or {})", join(facts)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::fact::{less, not};
    use super::super::term::{self, Term, whole};
    use super::*;

    #[test]
    fn text_declares_what_it_uses() {
        term::forget();
        let (a, b) = (Term::fresh("a"), Term::fresh("b"));
        let facts = [less(a * b, whole(-3)), not(less(a, b))];
        assert_eq!(
            script("title", &facts, Arithmetic::Whole),
            "; title\n(set-logic QF_NRA)\n(declare-const |a.1| Real)\n(declare-const |b.2| Real)\n\
             (define-fun t2 () Real (* |a.1| |b.2|))\n(assert (< t2 (- 3.0)))\n\
             (assert (not (< |a.1| |b.2|)))\n(check-sat)\n"
        );
        let sums = script("", &facts, Arithmetic::Sums);
        assert!(sums.contains("(declare-const t2 Real)") && sums.contains("QF_LRA"), "{sums}");
    }
}

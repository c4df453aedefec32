//! Statements about terms.

use super::term::Term;

/// How two terms compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Relation {
    /// Less.
    Less,
    /// Less or equal.
    AtMost,
    /// Equal.
    Equal,
}

/// A statement. The functions below make it, and leave out trivial parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fact {
    /// True.
    True,
    /// False.
    False,
    /// A comparison.
    Compare(Relation, Term, Term),
    /// The answer of a closed predicate, by its name.
    Answer(String),
    /// Not.
    Not(Box<Fact>),
    /// All of them.
    All(Vec<Fact>),
    /// At least one of them.
    Any(Vec<Fact>),
}

impl Fact {
    /// Every term in it.
    pub fn visit_terms(&self, visit: &mut impl FnMut(Term)) {
        match self {
            Self::True | Self::False | Self::Answer(_) => {}
            Self::Compare(_, a, b) => {
                visit(*a);
                visit(*b);
            }
            Self::Not(fact) => fact.visit_terms(visit),
            Self::All(facts) | Self::Any(facts) => facts.iter().for_each(|fact| fact.visit_terms(visit)),
        }
    }

    /// Every answer in it.
    pub fn visit_answers(&self, visit: &mut impl FnMut(&str)) {
        match self {
            Self::True | Self::False | Self::Compare(..) => {}
            Self::Answer(name) => visit(name),
            Self::Not(fact) => fact.visit_answers(visit),
            Self::All(facts) | Self::Any(facts) => facts.iter().for_each(|fact| fact.visit_answers(visit)),
        }
    }
}

impl From<bool> for Fact {
    fn from(value: bool) -> Self {
        if value { Self::True } else { Self::False }
    }
}

/// `a < b`.
#[must_use]
pub fn less(a: Term, b: Term) -> Fact {
    Fact::Compare(Relation::Less, a, b)
}

/// `a ≤ b`.
#[must_use]
pub fn at_most(a: Term, b: Term) -> Fact {
    Fact::Compare(Relation::AtMost, a, b)
}

/// `a = b`.
#[must_use]
pub fn equal(a: Term, b: Term) -> Fact {
    Fact::Compare(Relation::Equal, a, b)
}

/// Not.
#[must_use]
pub fn not(fact: Fact) -> Fact {
    match fact {
        Fact::True => Fact::False,
        Fact::False => Fact::True,
        Fact::Not(fact) => *fact,
        fact => Fact::Not(Box::new(fact)),
    }
}

/// All of them.
#[must_use]
pub fn all(facts: impl IntoIterator<Item = Fact>) -> Fact {
    let mut kept = Vec::new();
    for fact in facts {
        match fact {
            Fact::True => {}
            Fact::False => return Fact::False,
            Fact::All(more) => kept.extend(more),
            fact => kept.push(fact),
        }
    }
    match kept.len() {
        0 => Fact::True,
        1 => kept.swap_remove(0),
        _ => Fact::All(kept),
    }
}

/// At least one of them.
#[must_use]
pub fn any(facts: impl IntoIterator<Item = Fact>) -> Fact {
    not(all(facts.into_iter().map(not)))
}

/// If, then.
#[must_use]
pub fn implies(given: Fact, then: Fact) -> Fact {
    any([not(given), then])
}

/// Both or neither.
#[must_use]
pub fn same(a: &Fact, b: &Fact) -> Fact {
    any([all([a.clone(), b.clone()]), all([not(a.clone()), not(b.clone())])])
}

/// `low ≤ a ≤ high`.
#[must_use]
pub fn between(low: Term, a: Term, high: Term) -> Fact {
    all([at_most(low, a), at_most(a, high)])
}

/// A statement with its premises. The prover checks that the premises can be met.
#[derive(Clone, Debug)]
pub struct Implication {
    /// The premises.
    pub given: Vec<Fact>,
    /// The conclusion.
    pub then: Fact,
}

impl Implication {
    /// The claim as one statement.
    #[must_use]
    pub fn fact(&self) -> Fact {
        implies(all(self.given.clone()), self.then.clone())
    }
}

/// The claim that `then` follows from `given`.
#[must_use]
pub fn claim<const N: usize>(given: [Fact; N], then: Fact) -> Implication {
    Implication { given: given.into(), then }
}

#[cfg(test)]
mod tests {
    use super::super::term::Term;
    use super::*;

    #[test]
    fn trivial_statements_vanish() {
        let (a, b) = (Term::fresh("a"), Term::fresh("b"));
        let fact = less(a, b);
        assert_eq!(all([Fact::True, fact.clone()]), fact);
        assert_eq!(any([Fact::False, fact.clone()]), fact);
        assert_eq!(implies(Fact::False, fact.clone()), Fact::True);
        assert_eq!(implies(fact.clone(), Fact::True), Fact::True);
        assert_eq!(all([fact, Fact::False]), Fact::False);
    }
}

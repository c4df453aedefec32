//! Terms over the reals. A term is an index into an arena of the thread, so it can be copied.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::{Add, Mul, Neg, Sub};

/// A symbolic number. Equal terms have equal indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Term(u32);

/// The structure of a term.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum TermNode {
    /// A variable, by its name.
    Variable(String),
    /// A whole number.
    Whole(i128),
    /// A sum.
    Sum(Term, Term),
    /// A difference.
    Difference(Term, Term),
    /// A product.
    Product(Term, Term),
    /// `⌊a / b⌋`, of which only `0 ≤ q` and `q·b ≤ a < (q + 1)·b` is known, for `a ≥ 0` and `b > 0`.
    Quotient(Term, Term),
}

#[derive(Default)]
struct Arena {
    nodes: Vec<TermNode>,
    known: HashMap<TermNode, Term>,
    fresh: u32,
}

thread_local! {
    static ARENA: RefCell<Arena> = RefCell::default();
}

impl Term {
    /// The term of this node, the same for equal nodes.
    ///
    /// # Panics
    /// When the arena holds 2^32 terms.
    #[must_use]
    pub fn of(node: TermNode) -> Self {
        ARENA.with_borrow_mut(|arena| {
            if let Some(&term) = arena.known.get(&node) {
                return term;
            }
            let term = Self(u32::try_from(arena.nodes.len()).expect("proofs have fewer than 2^32 terms"));
            arena.nodes.push(node.clone());
            arena.known.insert(node, term);
            term
        })
    }

    /// A new variable. Its name begins with `name`.
    #[must_use]
    pub fn fresh(name: &str) -> Self {
        let number = ARENA.with_borrow_mut(|arena| {
            arena.fresh += 1;
            arena.fresh
        });
        Self::of(TermNode::Variable(format!("{name}.{number}")))
    }

    /// The structure of the term.
    #[must_use]
    pub fn node(self) -> TermNode {
        ARENA.with_borrow(|arena| arena.nodes[self.0 as usize].clone())
    }

    /// Its index in the arena. Its parts have smaller indices.
    #[must_use]
    pub fn number(self) -> u32 {
        self.0
    }

    /// Its operands.
    #[must_use]
    pub fn parts(self) -> Vec<Term> {
        match self.node() {
            TermNode::Variable(_) | TermNode::Whole(_) => Vec::new(),
            TermNode::Sum(a, b)
            | TermNode::Difference(a, b)
            | TermNode::Product(a, b)
            | TermNode::Quotient(a, b) => {
                vec![a, b]
            }
        }
    }
}

/// Forgets all terms of the thread.
pub fn forget() {
    ARENA.with_borrow_mut(|arena| *arena = Arena::default());
}

impl From<i128> for Term {
    fn from(value: i128) -> Self {
        Self::of(TermNode::Whole(value))
    }
}

impl Add for Term {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::of(TermNode::Sum(self, other))
    }
}

impl Sub for Term {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::of(TermNode::Difference(self, other))
    }
}

impl Mul for Term {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::of(TermNode::Product(self, other))
    }
}

impl Neg for Term {
    type Output = Self;
    fn neg(self) -> Self {
        whole(0) - self
    }
}

/// The term of a whole number.
#[must_use]
pub fn whole(value: i128) -> Term {
    Term::from(value)
}

/// The square of a term.
#[must_use]
pub fn square(a: Term) -> Term {
    a * a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_terms_are_one() {
        let (a, b) = (Term::fresh("a"), Term::fresh("a"));
        assert_ne!(a, b, "fresh variables differ");
        assert_eq!(a * b - whole(3), a * b - whole(3));
        assert_ne!(a * b, b * a);
        assert_eq!((a + b).parts(), [a, b]);
    }
}

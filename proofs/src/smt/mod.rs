//! Proofs by solver. The explorer runs the shipped predicates on symbolic numbers, path by path. For each
//! path the prover hands the negated claim to an SMT solver, and the solver must refute it.
//!
//! Numbers are reals. A lattice of any width is a part of them, so a theorem over the reals holds over the
//! full range of the product's width. A separate proof shows that no operation overflows there ([`range`]).
//!
//! A theorem is a list of questions. Lemmas are proved for all numbers. A step may assume only instances of
//! earlier proofs, and the type [`prover::Instance`] enforces this. The proof of a predicate that calls
//! others uses the theorems about those. The prover also checks that premises can be met, so that no
//! theorem is empty.
//!
//! Trusted here: the explorer takes every path ([`explore`](mod@explore)), terms are written correctly
//! ([`script`](mod@script)), the claims say what the reader takes from them, and one solver is correct.
//! Statements about polygons of any number of corners, rings and trees of boxes are proved for one corner,
//! edge or box. The step to all of them is induction by hand.

pub mod explore;
pub mod fact;
pub mod prover;
pub mod range;
pub mod results;
pub mod run;
pub mod script;
pub mod solver;
pub mod symbolic;
pub mod term;

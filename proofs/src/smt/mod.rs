//! Proofs by solver: the shipped predicates are run on symbolic numbers, path by path, and what must hold on each path is
//! handed, negated, to an SMT solver, which must refute it.
//!
//! Numbers are reals. A lattice of any width is a part of them, so a theorem over the reals holds at the product's width over
//! its full range; that no operation overflows there is proved apart ([`range`]).

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

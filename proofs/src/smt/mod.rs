//! Proofs by solver: the shipped predicates are run on symbolic numbers, path by path, and what must hold on each path is
//! handed, negated, to an SMT solver, which must refute it.
//!
//! Numbers are reals. A lattice of any width is a part of them, so a theorem over the reals holds at the product's width over
//! its full range; that no operation overflows there is proved apart ([`range`]).

//! A theorem is a list of questions. Small lemmas are proved for all numbers; a step takes nothing for granted but instances of
//! what was proved before it, by type ([`prover::Instance`]). A predicate that calls others is proved from what is proved of
//! them. Conditions are asked to be possible, so that no theorem is empty.
//!
//! Trusted here: that the explorer takes every path ([`explore`](mod@explore)), that terms are written as they are
//! ([`script`](mod@script)), the reading of each claim, and one solver. What is said of polygons of any number of corners,
//! of rings and of trees of boxes is proved for one corner, edge or box; the step to all of them is induction by hand.

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

//! The trusted core: the lattice, the predicates, segments, arcs, rings and regions.
//!
//! Every safety answer of the kernel rests on this folder, so a reviewer must check all of it. It uses no
//! floats, no `unsafe` and no `as` (two constant functions excepted). It allocates only to hold rings, chains
//! of chords and curves, and to check them. The predicates calculate only in [`width`], where each operation
//! states the bound that rules out an overflow. The other modules use operations that cannot overflow, such
//! as saturating and checked ones.
#![deny(clippy::arithmetic_side_effects, clippy::as_conversions, clippy::float_arithmetic)]

pub mod arc;
pub mod bezier;
pub mod contact;
pub mod convex;
pub mod lattice;
pub mod predicate;
pub mod region;
pub mod ring;
pub mod segment;
pub mod swept_arc;
pub mod width;

//! The trusted core: the lattice, the predicates, segments, arcs, rings and regions.
//!
//! A reviewer must believe what is in this folder, and nothing else of the kernel's geometry. It uses no floats, no
//! `unsafe`, no `as`, and allocates only to hold rings. Arithmetic happens in one place, [`width`], where each
//! operation states the bound that keeps it from overflowing.
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

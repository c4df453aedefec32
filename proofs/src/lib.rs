//! What the trusted core promises, one plain function a property, with several engines over the same body.
//!
//! | engine | where | what it covers |
//! |---|---|---|
//! | exhaustive | `tests/exhaustive.rs` | every input on a small lattice, at [`Narrow`] and at product width |
//! | random, full range | `tests/random.rs` | proptest, with thresholds at and beside the exact distance |
//! | soak, degenerate families | `tests/soak.rs`, and `cargo run --release -p keepout-proofs --bin soak` for as long as one likes | predicates, index, cells, near list and arcs beside the definitions over all edges |
//! | solvers | `src/smt/`, `src/theorems/`; `cargo run --release -p keepout-proofs -- prove` | the shipped source on symbolic numbers: all inputs over the full range |
//! | Kani | `src/harnesses.rs` under `cfg(kani)` | all inputs at [`Narrow`] width, symbolically; for reviewers who have Kani |
//!
//! The mathematical side of each property is [`oracle`]: exact rational arithmetic on big integers, written from the
//! definitions and sharing nothing with the kernel.
//!
//! [`Narrow`]: keepout_kernel::exact::width::Narrow

pub mod families;
pub mod oracle;
pub mod properties;
pub mod smt;
pub mod soak;
pub mod theorems;

#[cfg(kani)]
mod harnesses;

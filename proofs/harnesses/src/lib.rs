//! Questions about the trusted crates for bounded model checkers: one question per harness.
//!
//! A harness draws inputs, runs code of the product and asserts one statement. Its table states the bounds of the
//! inputs and of the loops. Three programs run it:
//!
//! - `keepout-proofs model-check` compiles this crate to WebAssembly, translates it to C, and gives each harness to
//!   CBMC. CBMC decides the statement for all inputs within the bounds at once.
//! - `cargo kani` takes the same harnesses, for reviewers who have Kani.
//! - `cargo test` runs each harness on random inputs. This finds errors of the harness, and proves nothing.
//!
//! Harnesses use coordinates of a few units where products matter, because a product of two unknown numbers is hard
//! for a SAT solver. Comparisons and sums run over the full range. Theorems answer the questions about products over
//! all numbers.
#![cfg_attr(target_arch = "wasm32", no_std)]

extern crate alloc;

mod arcs;
mod canaries;
mod guard;
mod index;
mod lattice;
#[cfg(not(target_arch = "wasm32"))]
mod native;
mod parts;
mod predicates;
mod rings;
#[cfg(target_arch = "wasm32")]
mod wasm;
mod windows;

#[cfg(not(target_arch = "wasm32"))]
pub use native::{Inputs, all, canaries};

/// A source of inputs.
pub trait Cases {
    /// A number from `low` to `high`, both included.
    fn int(&mut self, low: i32, high: i32) -> i32;

    /// Any number of 64 bits.
    fn wide(&mut self) -> i64;

    /// A number from 0 to `last`.
    fn up_to(&mut self, last: u8) -> u8 {
        u8::try_from(self.int(0, last.into())).unwrap_or(0)
    }

    /// A boolean.
    fn coin(&mut self) -> bool {
        self.int(0, 1) == 1
    }
}

/// A harness: a question, and the bounds within which a model checker answers it.
#[cfg(not(target_arch = "wasm32"))]
#[derive(Clone, Copy, Debug)]
pub struct ModelHarness {
    /// Its name.
    pub name: &'static str,
    /// The statement.
    pub claim: &'static str,
    /// The file whose code it runs.
    pub file: &'static str,
    /// The bounds of its inputs, in words.
    pub bounds: &'static str,
    /// How often loops are unwound.
    pub unwind: u32,
    /// Runs it on given or random inputs.
    pub run: fn(&mut Inputs),
}

/// Lists harnesses: file of the code, name, claim, bounds of the inputs and of loops.
macro_rules! harnesses {
    ($( $file:literal { $( $name:ident: $claim:literal, $bounds:literal, unwind $unwind:literal; )+ } )+) => {
        /// The harnesses of this file.
        #[cfg(not(target_arch = "wasm32"))]
        pub(crate) const ALL: &[crate::ModelHarness] = &[ $( $( crate::ModelHarness {
            name: stringify!($name),
            claim: $claim,
            file: $file,
            bounds: $bounds,
            unwind: $unwind,
            run: |cases| $name(cases),
        } ),+ ),+ ];

        #[cfg(target_arch = "wasm32")]
        #[expect(unsafe_code, reason = "the model checker finds harnesses by name")]
        mod exports {
            $( $(
                #[unsafe(no_mangle)]
                extern "C" fn $name() {
                    super::$name(&mut crate::wasm::AllInputs);
                }
            )+ )+
        }

        #[cfg(all(test, not(kani)))]
        mod tests {
            $( $(
                #[test]
                fn $name() {
                    crate::native::try_many(stringify!($name));
                }
            )+ )+
        }

        #[cfg(kani)]
        mod kani_harnesses {
            $( $(
                #[cfg_attr(not(kani_shim), kani::proof, kani::unwind($unwind))]
                #[cfg_attr(kani_shim, expect(dead_code, reason = "only Kani calls harnesses"))]
                fn $name() {
                    super::$name(&mut crate::native::KaniInputs);
                }
            )+ )+
        }
    };
}

pub(crate) use harnesses;

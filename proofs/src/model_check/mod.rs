//! Bounded model checking by CBMC: the harnesses of `keepout-harnesses`, as WebAssembly, as C, as one formula each.
//!
//! `cargo` compiles all harnesses to one module of WebAssembly. `wasm2c` translates the module to C. `translate`
//! cuts out one harness with everything that it calls, and gives it a memory that CBMC handles well. CBMC unwinds
//! the loops, checks that the bound was enough, and asks `kissat` whether any input makes the harness fail. So the
//! answer covers all inputs within the harness's bounds, and the machine code's arithmetic with its overflow checks.
//!
//! [`tools`] names the programs, [`run`] runs them, [`results`] keeps the answers.

pub mod results;
pub mod run;
pub mod tools;
mod translate;

//! Properties of the trusted core. Each is a plain function, and several engines run the same function.
//!
//! | engine | where | coverage |
//! |---|---|---|
//! | every case | [`property`], `cargo test` | every input on a small lattice, predicates at [`Narrow`] width |
//! | random, full range | [`property`], `tests/random.rs` | from a fixed seed, with thresholds at and near the exact distance |
//! | soak, degenerate families | `tests/soak.rs`, `keepout-proofs soak` | predicates, index, cells and arcs against the definitions over all edges |
//! | exploration | `invariant`, `tests/invariant.rs`, `keepout-proofs explore` | the guard with a model of the controller: every state |
//! | bytes | the fuzz target `property` | any bytes, as the inputs of any property |
//! | seeded faults | `faults.toml`, `keepout-proofs faults` | faults in copies of the tree, each of which must be noticed |
//! | solvers | [`smt`], [`theorems`], `keepout-proofs prove` | the shipped source on symbolic numbers: all inputs over the full range |
//! | bounded model checker | `keepout-harnesses`, [`model_check`], `keepout-proofs model-check` | all inputs within stated bounds, by a SAT solver |
//!
//! Each property is a plain function in [`properties`]. The lists there name its engines. `keepout-proofs
//! table` writes `README.md`.
//!
//! [`oracle`] holds the mathematical definitions: exact rational arithmetic on big integers. It shares no
//! code with the kernel.
//!
//! [`Narrow`]: keepout_kernel::exact::width::Narrow
//!
//! ```
//! // The first two bytes choose a property, the others are its inputs.
//! keepout_proofs::property_of_bytes(&[0, 0, 1, 2, 3, 4, 5, 6, 7, 8]);
//! ```

#[cfg(all(feature = "tools", feature = "guard", feature = "solvers"))]
pub mod carried;
pub mod check;
#[cfg(feature = "guard")]
pub mod controller;
pub mod draw;
pub mod families;
#[cfg(feature = "tools")]
pub mod faults;
#[cfg(feature = "guard")]
pub mod invariant;
#[cfg(feature = "guard")]
pub mod model;
#[cfg(feature = "tools")]
pub mod model_check;
#[cfg(feature = "tools")]
pub mod mutants;
pub mod oracle;
pub mod properties;
pub mod property;
#[cfg(feature = "guard")]
pub mod second_controller;
#[cfg(feature = "solvers")]
pub mod smt;
pub mod soak;
#[cfg(feature = "guard")]
pub mod square;
#[cfg(all(feature = "tools", feature = "guard", feature = "solvers"))]
pub mod table;
#[cfg(feature = "solvers")]
pub mod theorems;
#[cfg(all(feature = "tools", feature = "guard", feature = "solvers"))]
pub mod trace;
#[cfg(feature = "guard")]
pub mod wire;
#[cfg(feature = "guard")]
pub mod worlds;

/// Runs one property. The first two bytes choose it, the rest are its inputs.
///
/// # Panics
/// When the property does not hold.
pub fn property_of_bytes(bytes: &[u8]) {
    chosen_of_bytes(&properties::all(), bytes);
}

/// Runs one of the named properties. The first two bytes choose it, the rest are its inputs.
///
/// # Panics
/// When the property does not hold, or no property has one of the names.
pub fn named_of_bytes(names: &[&str], bytes: &[u8]) {
    let all = properties::all();
    let named = |name: &&str| *all.iter().find(|each| each.name == *name).expect("a property has the name");
    chosen_of_bytes(&names.iter().map(named).collect::<Vec<_>>(), bytes);
}

fn chosen_of_bytes(among: &[&property::Property], bytes: &[u8]) {
    let Some((number, inputs)) = bytes.split_first_chunk::<2>() else { return };
    let property = among[usize::from(u16::from_le_bytes(*number)) % among.len()];
    (property.bytes)(&mut draw::Bytes::of(inputs));
}

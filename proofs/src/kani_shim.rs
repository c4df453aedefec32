//! No model checker. It has the names of Kani that the harnesses use, so that they can be type-checked where Kani is not:
//! `cargo rustc -p keepout-proofs --lib -- --cfg kani --cfg kani_shim`. Whoever runs a harness over it gets a panic.

/// Stands for Kani's `any`: any value of a type.
///
/// # Panics
/// Always: only Kani has all values.
pub fn any<T>() -> T {
    panic!("this is a shim for type-checking harnesses: only Kani can run them")
}

/// Stands for Kani's `assume`.
///
/// # Panics
/// Always, as [`any`].
pub fn assume(_condition: bool) {
    panic!("this is a shim for type-checking harnesses: only Kani can run them")
}

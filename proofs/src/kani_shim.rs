//! Stand-in for Kani, without a model checker. It defines the names of Kani that the harnesses use, so that
//! the compiler can check them without Kani: `cargo rustc -p keepout-proofs --lib -- --cfg kani --cfg
//! kani_shim`. A harness that runs on it panics.

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

//! Controller languages, one file each.

mod grbl;

pub use grbl::Grbl;

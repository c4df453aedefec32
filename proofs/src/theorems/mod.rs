//! What is proved of the trusted core by solvers.

mod orientation;
mod plane;
mod point_segment;

use crate::smt::run::Theorem;

/// All theorems; each rests only on those before it.
pub const THEOREMS: &[Theorem] = &[
    orientation::ORIENTATION,
    orientation::POINT_POINT,
    point_segment::POINT_SEGMENT,
];

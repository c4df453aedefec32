//! What is proved of the trusted core by solvers.

mod boxes;
mod orientation;
mod plane;
mod point_segment;
mod recedes;
mod segments;
mod triangle;
mod winding;

use crate::smt::run::Theorem;

/// All theorems; each rests only on those before it.
pub const THEOREMS: &[Theorem] = &[
    orientation::ORIENTATION,
    orientation::POINT_POINT,
    point_segment::POINT_SEGMENT,
    segments::CROSSES_PROPERLY,
    segments::SEGMENT_ENDS,
    segments::SEGMENT_SEGMENT,
    triangle::STRICTLY_INSIDE,
    triangle::TRIANGLE_EXIT,
    triangle::TRIANGLE_SEGMENT,
    boxes::BOX_POINT,
    boxes::BESIDE,
    boxes::PRUNING,
    boxes::CONVEX,
    winding::TRIANGLE_PARITY,
    winding::RING_PARITY,
    recedes::RECEDES,
];

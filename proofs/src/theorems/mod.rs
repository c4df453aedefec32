//! The theorems about the trusted core. Solvers prove them.

mod arcs;
mod beyond;
mod box_met;
mod box_segment;
mod boxes;
mod convex;
mod crossing;
mod hull;
mod inside;
mod levels;
mod near;
mod orientation;
mod overflow;
mod pieces;
mod plane;
mod point_segment;
mod polygon_pruning;
mod retract;
mod ring;
mod segment_ends;
mod segments;
mod triangle;
mod triangle_exit;
mod winding;

pub use overflow::prove as no_overflow_up_to;

use crate::smt::run::Theorem;

/// All theorems. Each rests only on those before it.
pub const THEOREMS: &[Theorem] = &[
    orientation::ORIENTATION,
    orientation::POINT_POINT,
    point_segment::POINT_SEGMENT,
    beyond::BEYOND,
    crossing::CROSSES_PROPERLY,
    segment_ends::SEGMENT_ENDS,
    segments::SEGMENT_SEGMENT,
    inside::STRICTLY_INSIDE,
    triangle_exit::TRIANGLE_EXIT,
    triangle::TRIANGLE_SEGMENT,
    convex::CONVEX_HOLDS,
    convex::CONVEX_EXIT,
    convex::CONVEX_NEAR_SEGMENT,
    boxes::BOX_POINT,
    box_met::BOX_MET,
    box_met::BOX_SLIDE,
    box_segment::BOX_SEGMENT,
    boxes::BOX_SIDE,
    boxes::PRUNING,
    polygon_pruning::POLYGON_PRUNING,
    boxes::CONVEX,
    ring::TOUCHES,
    ring::FOLDS_BACK,
    winding::TRIANGLE_PARITY,
    winding::RING_PARITY,
    retract::RETRACTS,
    near::TRIANGLE_INEQUALITY,
    arcs::ON_RING,
    arcs::SAGITTA,
    arcs::CHORD_ERROR,
    pieces::SWEPT_PIECES,
    arcs::SWEPT_RULES,
    arcs::SWEPT_CORNER,
    near::ROUNDING,
    near::CLIP,
    hull::CONVEX_SET,
    hull::HULL_POLYGON,
    levels::MONOTONE,
    levels::LOWEST,
    overflow::OVERFLOW,
];

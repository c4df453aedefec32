//! The offset: the set at distance `d` from the profile on the free side, as closed loops of lines and true
//! arcs.
//!
//! [`propose`] searches in `f64` and is untrusted. [`certify_path`] checks each motion of a path exactly
//! against the part, at a given threshold. [`certify_complete`] checks that the loops miss no stretch of the
//! true offset.

mod certify;
mod complete;
mod plane;
mod propose;
mod stitch;
mod track;

pub use certify::{Gouge, GougeCause, PATH_CHORD_ERROR, certify_path, shortest_arc};
pub use complete::{BESIDE, COVERAGE, Missing, RESOLUTION, certify_complete};
pub use propose::{CutContour, Offset, OffsetLoop, Outline, propose};

//! The set at distance `d` from the profile on the free side, as closed loops of lines and true arcs.
//!
//! [`propose`] searches in `f64`; [`certify_path`] believes nothing: each motion of a path is checked exactly against
//! the part at the threshold the caller states. [`certify_complete`] looks the other way: no piece of the true offset is
//! missing.

mod certify;
mod complete;
mod plane;
mod propose;
mod stitch;
mod track;

pub use certify::{Gouge, GougeCause, PATH_CHORD_ERROR, certify_path, shortest_arc};
pub use complete::{BESIDE, COVERAGE, Missing, RESOLUTION, certify_complete};
pub use propose::{Offset, OffsetLoop, Outline, propose};

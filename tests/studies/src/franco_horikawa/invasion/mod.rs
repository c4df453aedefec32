//! The paper's invasion checks and tool-radius construction (sections 5.2 and 5.3), for comparison only.
//!
//! Keepout does not use this module. It computes in `f64`, and it keeps the defects of the paper on purpose.
//! A test shows each defect on a drawing of a few lines. The predicates of Keepout are in [`keepout_kernel`].
//!
//! A profile is a closed polygon. Its corners are in the order of the route, and the last corner connects to
//! the first.

use keepout_planner::Mm2;
mod checks;
mod operations;
mod radius;

pub use checks::{
    Classified, Intervals, MatrixError, PointMatrix, angle_sum_deg, angle_sum_invades, is_external,
};
pub use operations::{Operations, mean_operations, of_angles, of_intervals, of_matrix};
pub use radius::{RadiusError, filter_very_close, is_above, prohibited, setback_mm, turn_rad};

/// The segments of a closed profile in route order: P1P2, P2P3, and last the segment back to P1.
fn segments(profile: &[Mm2]) -> impl Iterator<Item = (Mm2, Mm2)> {
    profile.iter().copied().zip(profile.iter().copied().cycle().skip(1))
}

#[cfg(test)]
mod tests;

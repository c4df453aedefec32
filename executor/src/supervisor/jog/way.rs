//! The path ahead of the tool.

use keepout_guard::Guard;
use keepout_kernel::{Length, Point, Segment};
use keepout_planner::units::length_up_from_mm;

/// The path ahead of the tool: from its confirmed position along the targets that it has not passed. A target
/// stays in the in-flight set for some time after the tool has passed it.
pub(super) struct Way {
    points: [Point; WAY_MAX],
    first: usize,
    count: usize,
}

/// Greatest number of points of a path.
const WAY_MAX: usize = 16;
/// A tool within this distance of the motion between two targets counts as on it, mm.
const ON_WAY_MM: f64 = 0.02;

impl Way {
    pub(super) fn of(guard: &Guard, struck: u64) -> Self {
        let mut way = Self { points: [Point::ORIGIN; WAY_MAX], first: 0, count: 0 };
        for point in guard.way_after(struck).take(WAY_MAX) {
            way.points[way.count] = point;
            way.count += 1;
        }
        let confirmed = way.points[0];
        let near = length_up_from_mm(ON_WAY_MM).unwrap_or(Length::ZERO);
        let on = |k: &usize| {
            let leg = Segment { from: way.points[*k], to: way.points[*k + 1] };
            !leg.near_point(confirmed, near).is_clear()
        };
        if let Some(leg) = (1..way.count.saturating_sub(1)).rev().find(on) {
            way.points[leg] = confirmed;
            way.first = leg;
        }
        way
    }

    pub(super) fn points(&self) -> &[Point] {
        &self.points[self.first..self.count]
    }
}

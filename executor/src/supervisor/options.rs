//! Options of a session.

use std::time::Duration;

use keepout_kernel::Height;
use keepout_kernel::exact::segment::Window;
use keepout_planner::job::Progress;

/// Options of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Feed of the finishing contour, mm/min.
    pub feed_mm_min: u32,
    /// Home the machine before the start.
    pub home: bool,
    /// The machine's travel, drawing coordinates.
    pub travel: Window,
    /// The lowest and the greatest height of the third axis, drawing coordinates. `None` for a session with two
    /// axes.
    pub heights: Option<[Height; 2]>,
    /// Longest permitted silence of the controller.
    pub answer_within: Duration,
    /// Baud rate of the line.
    pub baud: u32,
    /// Progress of the plan's contours in earlier sessions.
    pub progress: Progress,
}

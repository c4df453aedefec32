//! The first line of a log: the set-up of its session.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Height, Point, Vector};
use keepout_planner::job::Progress;
use serde::{Deserialize, Serialize};

use crate::session::place::PlacedZ;

/// The log version that this program writes, and the only one that it reads.
pub const VERSION: u32 = 3;

/// The set-up of a session. It is complete enough for a replay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// [`VERSION`].
    pub keepout_log: u32,
    /// The beginning of the session by the computer's clock: UTC, in the form of RFC 3339.
    pub began: String,
    /// SHA-256 of the plan file's content.
    pub plan: String,
    /// Name of the drawing.
    pub drawing: String,
    /// The dialect, as the command line names it.
    pub dialect: String,
    /// SHA-256 of the dialect's file. Empty for a built-in dialect.
    pub description: String,
    /// Whether the machine is simulated.
    pub simulated: bool,
    /// Whether the run is a dry run, which cuts nothing.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub dry_run: bool,
    /// Machine coordinates minus drawing coordinates.
    #[serde(with = "keepout_planner::stored")]
    pub offset: Vector,
    /// The machine's travel in x and y, mm.
    pub travel_mm: Option<[f64; 2]>,
    /// The soft limit of the session within that travel, drawing coordinates.
    #[serde(with = "keepout_planner::stored")]
    pub travel: Window,
    /// The third axis. `None` for a session with two axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<HeaderZ>,
    /// Feed of the contour, mm/min.
    pub feed_mm_min: u32,
    /// Whether the session begins with homing.
    pub home: bool,
    /// Longest silence of the controller, ms.
    pub answer_within_ms: u64,
    /// Baud rate of the line.
    pub baud: u32,
    /// The progress of earlier sessions on the plan's contours.
    pub progress: Progress,
    /// The operator, as the command line names it.
    pub operator: String,
    /// The machine and its port, in words.
    pub setting: String,
}

/// The third axis of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeaderZ {
    /// The machine's height where the drawing's height is zero.
    #[serde(with = "keepout_planner::stored")]
    pub zero: Height,
    /// The lowest height of the travel, drawing coordinates.
    #[serde(with = "keepout_planner::stored")]
    pub lowest: Height,
    /// The greatest height of the travel.
    #[serde(with = "keepout_planner::stored")]
    pub highest: Height,
}

impl HeaderZ {
    /// The place of the drawing along the axis.
    #[must_use]
    pub fn place(&self) -> PlacedZ {
        PlacedZ { zero: self.zero, travel: [self.lowest, self.highest] }
    }
}

impl Default for Header {
    fn default() -> Self {
        Self {
            keepout_log: VERSION,
            began: String::new(),
            plan: String::new(),
            drawing: String::new(),
            dialect: String::new(),
            description: String::new(),
            simulated: false,
            dry_run: false,
            offset: Vector { dx: 0, dy: 0 },
            travel_mm: None,
            travel: Window::of(Point::ORIGIN),
            z: None,
            feed_mm_min: 0,
            home: false,
            answer_within_ms: 0,
            baud: 115_200,
            progress: Progress::default(),
            operator: String::new(),
            setting: String::new(),
        }
    }
}

//! The first line of a log: what its session was set up with.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Point, Vector};
use keepout_planner::job::Progress;
use serde::{Deserialize, Serialize};

/// The version that is written, and the only one that is read.
pub const VERSION: u32 = 3;

/// What a log says of its session: enough to play it again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// [`VERSION`].
    pub keepout_log: u32,
    /// When the session began by the computer's clock: date and time, UTC, as RFC 3339 writes them.
    pub began: String,
    /// SHA-256 of the plan file's content.
    pub plan: String,
    /// Name of the drawing.
    pub drawing: String,
    /// The dialect, as it is asked for on the command line.
    pub dialect: String,
    /// SHA-256 of the text that describes it; empty for one that is built in.
    pub description: String,
    /// Whether nothing but a simulated machine moved.
    pub simulated: bool,
    /// Machine coordinates less drawing coordinates.
    #[serde(with = "keepout_planner::stored")]
    pub offset: Vector,
    /// The machine's travel in x and y, mm.
    pub travel_mm: Option<[f64; 2]>,
    /// Where the tool may go of that, drawing coordinates.
    #[serde(with = "keepout_planner::stored")]
    pub travel: Window,
    /// Feed of the contour, mm/min.
    pub feed_mm_min: u32,
    /// Whether the session begins with homing.
    pub home: bool,
    /// Longest silence of the controller, ms.
    pub answer_within_ms: u64,
    /// Baud rate of the line.
    pub baud: u32,
    /// What an earlier session had done of the plan's contours.
    pub progress: Progress,
    /// Who steers, as asked for on the command line.
    pub operator: String,
    /// The machine and its port, in words.
    pub setting: String,
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
            offset: Vector { dx: 0, dy: 0 },
            travel_mm: None,
            travel: Window::of(Point::ORIGIN),
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

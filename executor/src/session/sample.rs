//! Sampled positions of the tool.

use keepout_guard::Time;
use keepout_planner::Mm3;
use serde::{Deserialize, Serialize};

/// The machine's motion at a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SampleKind {
    /// In position. In a log, the session is starting.
    Rest,
    /// Moving by jogs.
    Jog,
    /// Moving by programmed motions.
    Run,
}

/// A tool position. The simulator gives true positions, and between two of them the tool moves straight. A
/// log or a real machine gives reported positions, and between two of them the tool's path is unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The time of the sample.
    pub at: Time,
    /// The tool's tip, machine coordinates, mm. Its height is zero on a machine with two axes.
    pub position_mm: Mm3,
    /// The machine's motion.
    pub kind: SampleKind,
}

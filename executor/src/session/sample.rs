//! True positions of the tool.

use keepout_guard::Time;
use serde::{Deserialize, Serialize};

/// What the machine was doing at a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SampleKind {
    /// Standing still.
    Rest,
    /// Moving by jogs.
    Jog,
    /// Moving by programmed motions.
    Run,
}

/// A true tool position: between two samples the tool moves straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When.
    pub at: Time,
    /// Where, machine coordinates, mm.
    pub position_mm: (f64, f64),
    /// What the machine was doing.
    pub kind: SampleKind,
}

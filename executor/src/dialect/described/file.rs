//! The tables of a description file.
//!
//! Implements SR-07, SR-11, SR-17, SR-18, SR-29.

use keepout_guard::Interpolation;
use keepout_planner::text_file;
use serde::Deserialize;

use crate::supervisor::Mode;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    #[serde(default)]
    pub(super) line: LineTable,
    pub(super) units: UnitsTable,
    pub(super) ask: AskTable,
    pub(super) status: StatusTable,
    pub(super) motion: MotionTable,
    #[serde(default)]
    pub(super) start: StartTable,
    #[serde(default)]
    pub(super) errors: Vec<ErrorTable>,
    #[serde(default)]
    pub(super) ignore: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct LineTable {
    pub(super) end: String,
    pub(super) echo: bool,
    pub(super) prompt: String,
}

impl Default for LineTable {
    fn default() -> Self {
        Self { end: "\r".into(), echo: false, prompt: String::new() }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct UnitsTable {
    pub(super) counts_per_mm: f64,
    #[serde(default)]
    pub(super) decimals: u8,
    pub(super) speed_counts_per_mm_s: f64,
    #[serde(default)]
    pub(super) speed_decimals: u8,
    #[serde(default, deserialize_with = "text_file::pair")]
    pub(super) zero: [i64; 2],
    #[serde(default)]
    pub(super) swap: bool,
    #[serde(default, deserialize_with = "text_file::pair")]
    pub(super) invert: [bool; 2],
    pub(super) z: Option<UnitsZTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct UnitsZTable {
    pub(super) counts_per_mm: f64,
    #[serde(default)]
    pub(super) decimals: u8,
    #[serde(default)]
    pub(super) zero: i64,
    #[serde(default)]
    pub(super) invert: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AskTable {
    pub(super) status: ExchangeTable,
    pub(super) position: Option<ExchangeTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExchangeTable {
    pub(super) send: String,
    pub(super) answer: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StatusTable {
    pub(super) rules: Vec<RuleTable>,
    pub(super) otherwise: ModeName,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RuleTable {
    pub(super) equals: Option<String>,
    pub(super) contains: Option<String>,
    pub(super) bits: Option<u32>,
    pub(super) mode: ModeName,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ModeName {
    Idle,
    Moving,
    Homing,
    Alarm,
    Other,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MotionTable {
    pub(super) line: Vec<String>,
    pub(super) arc_counterclockwise: Option<Vec<String>>,
    pub(super) arc_clockwise: Option<Vec<String>>,
    pub(super) stop: Option<String>,
    #[serde(default)]
    pub(super) stop_at_once: bool,
    #[serde(default)]
    pub(super) stop_keeps_path: bool,
    pub(super) accepted: AcceptedName,
    #[serde(default)]
    pub(super) answer: Option<String>,
    pub(super) interpolation: InterpolationName,
    pub(super) contours: Option<InterpolationName>,
    #[serde(default)]
    pub(super) queues: bool,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum AcceptedName {
    Prompt,
    Answer,
    Query,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum InterpolationName {
    Linear,
    Independent,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct StartTable {
    pub(super) prepare: Vec<String>,
    pub(super) home: Vec<String>,
    pub(super) arm: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ErrorTable {
    pub(super) says: String,
    #[serde(default)]
    pub(super) transient: bool,
}

pub(super) fn mode_of(name: ModeName) -> Mode {
    match name {
        ModeName::Idle => Mode::Idle,
        ModeName::Moving => Mode::Moving,
        ModeName::Homing => Mode::Homing,
        ModeName::Alarm => Mode::Alarm,
        ModeName::Other => Mode::Other,
    }
}

pub(super) fn shape_of(name: InterpolationName) -> Interpolation {
    match name {
        InterpolationName::Linear => Interpolation::Linear,
        InterpolationName::Independent => Interpolation::Independent,
    }
}

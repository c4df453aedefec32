//! Inspection of a controller: it reads identity and settings, and changes no setting.

use crate::supervisor::Limits;

/// Queries a controller's identity and settings. It only reads: the queries store no setting, start no motion
/// and change no mode.
pub trait Inspector: Send {
    /// The queries. Each is answered before the next one is sent.
    fn questions(&self) -> &'static [&'static [u8]];

    /// Takes a received line. Returns whether it ends the answer to the query.
    fn hear(&mut self, line: &str) -> bool;

    /// The findings for motions planned with `steps_per_mm` and arcs within `arc_tolerance_mm`.
    fn inspected(&self, steps_per_mm: f64, arc_tolerance_mm: f64) -> Inspected;
}

/// The result of an inspection.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspected {
    /// The findings, in the order of display.
    pub findings: Vec<Finding>,
    /// Steps per mm of the coarser axis.
    pub steps_per_mm: Option<f64>,
    /// The last digit of a reported position, mm.
    pub report_digit_mm: Option<f64>,
    /// Speed and acceleration of the slower axis.
    pub limits: Limits,
    /// Travel of x and y, mm.
    pub travel_mm: Option<[f64; 2]>,
    /// The third axis.
    pub z: StatedAxis,
    /// Identity of the firmware.
    pub firmware: Option<String>,
}

/// The figures that a controller states for one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StatedAxis {
    /// Travel, mm.
    pub travel_mm: Option<f64>,
    /// Rapid rate, mm/s.
    pub max_rate_mm_s: Option<f64>,
    /// Acceleration, mm/s².
    pub acceleration_mm_s2: Option<f64>,
    /// Steps per mm.
    pub steps_per_mm: Option<f64>,
}

/// One inspected property of a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The property's name.
    pub name: String,
    /// Its value, as text.
    pub value: String,
    /// Whether a session can work with this value.
    pub fit: Fit,
}

/// Whether a session can work with a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fit {
    /// The value is as needed.
    Good,
    /// A session sets it, or works without it. The text states the consequence.
    Minor(&'static str),
    /// No session can begin. The text states the remedy.
    Wrong(&'static str),
}

//! Looking at a controller without changing anything.

use crate::supervisor::Limits;

/// Asks a controller who it is and how it is set up. It only reads: nothing is stored, nothing moves, no mode is changed.
pub trait Inspector: Send {
    /// The questions, each of which is answered before the next is asked.
    fn questions(&self) -> &'static [&'static [u8]];

    /// Takes a line; whether it is the last of the answer to the question.
    fn hear(&mut self, line: &str) -> bool;

    /// What was found, for motions planned with `steps_per_mm` and arcs within `arc_tolerance_mm`.
    fn inspected(&self, steps_per_mm: f64, arc_tolerance_mm: f64) -> Inspected;
}

/// What was found at a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspected {
    /// One thing after the other.
    pub findings: Vec<Finding>,
    /// Steps per mm of the coarser axis.
    pub steps_per_mm: Option<f64>,
    /// Last digit of a reported place, mm.
    pub report_digit_mm: Option<f64>,
    /// Speed and acceleration of the slower axis.
    pub limits: Limits,
}

/// One thing that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What.
    pub name: String,
    /// How it is.
    pub value: String,
    /// Whether that is as needed.
    pub fit: Fit,
}

/// Whether something is as needed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fit {
    /// It is.
    Good,
    /// A session sets it, or does without it; what that means.
    Minor(&'static str),
    /// No session can begin; what to do.
    Wrong(&'static str),
}

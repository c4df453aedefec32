//! The controllers of Koren & Lo, each in its own file, and better ones.

pub mod adaptive;
pub mod box_program;
pub mod contouring;
pub mod cross_coupling;
pub mod drive_feedforward;
pub mod estimator;
pub mod exact_inverse;
pub mod inverse_filter;
pub mod kind;
pub mod law;
pub mod matching;
pub mod observer;
pub mod optimal;
pub mod optimal_cross_coupling;
pub mod pid;
pub mod predictive;
pub mod proportional;
pub mod repetitive;
pub mod selection;
pub mod speed;
pub mod state_feedback;
pub mod zero_phase;

use super::Axes;
use super::drive::Drive;
use super::profile::Uncertainty;
use super::reference::Window;

/// A controller of two axes, stepped once in every sampling period.
pub trait Controller: Send + std::fmt::Debug {
    /// The command for the coming period, bits, from the reference around now and the measured position, pulses. It is not
    /// bounded: the amplifier does that. Nothing is allocated.
    fn step(&mut self, window: &Window, measured: Axes) -> Axes;
}

/// What a controller believes of its drives, and how it samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// X and Y.
    pub drives: [Drive; 2],
    /// T, s.
    pub period_s: f64,
    /// The largest command that the amplifier takes, bits.
    pub limit: Option<f64>,
    /// Whether its encoders count whole pulses.
    pub whole_numbers: bool,
    /// Samples by which commands come late: the contouring controller reckons with them.
    pub delay_samples: usize,
    /// By how much loads change at once, bits: friction turns from one side to the other where an axis turns back. Twice that,
    /// or the force of the cut, serves well.
    pub load_bits: f64,
}

impl Belief {
    /// The same, wrong by these shares with these signs: gain and time constant of X, of Y.
    #[must_use]
    pub fn off_by(&self, by: Uncertainty, signs: [f64; 4]) -> Self {
        let [x, y] = self.drives;
        let drives = [
            x.off_by(by.gain * signs[0], by.time_constant * signs[1]),
            y.off_by(by.gain * signs[2], by.time_constant * signs[3]),
        ];
        Self { drives, ..*self }
    }
}

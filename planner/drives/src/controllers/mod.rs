//! The controllers of Koren & Lo, and better ones. One file per controller.

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
pub mod passed;
pub mod pid;
pub mod pid_zero_phase;
pub mod predictive;
pub mod proportional;
pub mod repetitive;
pub mod selection;
pub mod speed;
pub mod state_feedback;
pub mod zero_phase;

use super::Axes;
use super::drive::Drive;
use super::plant::PlantModel;
use super::profile::Uncertainty;
use super::reference::ReferenceWindow;

/// A controller of two axes. It runs once in every sampling period.
pub trait Controller: Send + std::fmt::Debug {
    /// The command for the next period, bits, from the reference around now and the measured position,
    /// pulses.
    ///
    /// The amplifier limits the command, so a controller need not limit it. A step allocates no memory.
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes;
}

/// The model of the drives that a controller uses. The real drives may differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// X and Y.
    pub drives: [Drive; 2],
    /// T, the sampling period, s.
    pub period_s: f64,
    /// Largest command that the amplifier accepts, bits.
    pub limit: Option<f64>,
    /// Delay of the commands, samples. Only the contouring controller uses it.
    pub delay_samples: usize,
    /// The rest of the delay, as a share of a sample: from 0 to below 1. Where the delay is uncertain, the middle of
    /// its range. Only the contouring controller uses it.
    pub delay_share: f64,
    /// Friction of X and Y. Only the contouring controller uses it.
    pub friction: [FrictionBelief; 2],
}

/// The friction that a controller expects.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionBelief {
    /// Coulomb friction, bits.
    pub coulomb: f64,
    /// Distance that it gives elastically after a reversal, pulses.
    pub presliding: f64,
}

impl Belief {
    /// The same model with the limit and the friction of a plant.
    #[must_use]
    pub fn on(&self, plant: &PlantModel) -> Self {
        Self { limit: plant.limit, friction: plant.axes.map(|axis| axis.friction_belief()), ..*self }
    }

    /// The same model with errors of these shares and signs: gain and time constant of X, then of Y.
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

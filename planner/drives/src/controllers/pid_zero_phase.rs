//! PID with ZPETC (section 8: "may have the ability to reject all the error sources").
//!
//! The drive's zero-phase inverse gives the command of an exact drive, and a PID law acts on the difference from
//! the position that this drive would have. That is ZPETC (eq. (11)) around a PID loop, with its poles at the zeros of
//! the PID law.

use super::drive_feedforward::DriveInverse;
use super::law::{Law, PidGains};
use super::{Belief, Controller};
use crate::Axes;
use crate::reference::ReferenceWindow;

/// The feedforward, and a PID law for each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PidZeroPhase {
    inverse: DriveInverse,
    laws: [Law; 2],
}

impl PidZeroPhase {
    /// The controller for a drive model and these gains.
    #[must_use]
    pub fn new(belief: &Belief, gains: PidGains) -> Self {
        Self { inverse: DriveInverse::new(belief), laws: [Law::new(gains, belief.period_s); 2] }
    }
}

impl Controller for PidZeroPhase {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        let error = self.inverse.position(window) - measured;
        let feedback = Axes::new(self.laws[0].step(error.x), self.laws[1].step(error.y));
        self.inverse.command(window) + feedback
    }
}

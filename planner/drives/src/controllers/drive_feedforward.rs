//! Feedforward of the drive's inverse (Fig. 5b, eq. (9)), with zero phase error.

use super::{Belief, Controller};
use crate::Axes;
use crate::drive::Loop;
use crate::reference::ReferenceWindow;

/// The inverse `D0⁻¹(z)`, with both zeros treated as unacceptable. Its command alone makes an exact drive
/// follow the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveInverse {
    drives: [Loop; 2],
}

impl DriveInverse {
    /// The inverse of the drive model.
    #[must_use]
    pub fn new(belief: &Belief) -> Self {
        // The poles and zeros of the open drive, without feedback.
        let open = belief.drives.map(|drive| {
            let held = drive.held(belief.period_s);
            Loop { poles: held.poles(), zeros: [held.b0, held.b1] }
        });
        Self { drives: open }
    }

    /// The position of an exact drive under [`DriveInverse::command`], pulses: the reference with the gain of
    /// eq. (14).
    #[must_use]
    pub fn position(&self, window: &ReferenceWindow) -> Axes {
        let on = |axis: usize| self.drives[axis].zero_phase_output(|ahead| window.position(ahead)[axis]);
        Axes::new(on(0), on(1))
    }

    /// The feedforward command, bits.
    #[must_use]
    pub fn command(&self, window: &ReferenceWindow) -> Axes {
        let on = |axis: usize| self.drives[axis].zero_phase(|ahead| window.position(ahead)[axis]);
        Axes::new(on(0), on(1))
    }
}

/// A P controller with feedforward of the drive's inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveFeedforward {
    inverse: DriveInverse,
    gain: f64,
}

impl DriveFeedforward {
    /// Feedforward with a P controller of `gain`, bits/pulse.
    #[must_use]
    pub fn new(belief: &Belief, gain: f64) -> Self {
        Self { inverse: DriveInverse::new(belief), gain }
    }
}

impl Controller for DriveFeedforward {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        self.inverse.command(window) + (window.position(0) - measured) * self.gain
    }
}

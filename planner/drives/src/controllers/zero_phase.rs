//! Zero phase error tracking, ZPETC (section 4.2): a reference that a P loop follows without delay.

use super::{Belief, Controller};
use crate::Axes;
use crate::drive::Loop;
use crate::reference::ReferenceWindow;

/// ZPETC: a P controller with the reference of eq. (11).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZeroPhase {
    loops: [Loop; 2],
    gain: f64,
}

impl ZeroPhase {
    /// ZPETC for a P controller of `gain`, bits/pulse.
    #[must_use]
    pub fn new(belief: &Belief, gain: f64) -> Self {
        Self { loops: loops(belief, gain), gain }
    }

    /// The reference, pulses, with which the P loop follows `wanted(samples ahead)`.
    #[must_use]
    pub fn reference(&self, wanted: impl Fn(isize) -> Axes) -> Axes {
        let on = |axis: usize| self.loops[axis].zero_phase(|ahead| wanted(ahead)[axis]);
        Axes::new(on(0), on(1))
    }

    /// The command, bits, with which the loop follows `wanted`.
    #[must_use]
    pub fn command(&self, wanted: impl Fn(isize) -> Axes, measured: Axes) -> Axes {
        (self.reference(wanted) - measured) * self.gain
    }
}

/// The P loops of both axes.
#[must_use]
pub fn loops(belief: &Belief, gain: f64) -> [Loop; 2] {
    belief.drives.map(|drive| drive.held(belief.period_s).closed(gain))
}

impl Controller for ZeroPhase {
    fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
        self.command(|ahead| window.position(ahead), measured)
    }
}

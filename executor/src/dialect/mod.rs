//! Controller dialects, one file each.
//!
//! Implements SR-17, SR-18.

pub mod described;
mod exchange;
mod grbl;
mod inspect;
mod language;
mod lines;
mod scale;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;
mod venus;
pub mod zaber;

pub use described::{Described, Description, DescriptionError, TemplateError};
pub use grbl::{Grbl, Status};
pub use inspect::{Finding, Fit, Inspected, Inspector, StatedAxis};
use keepout_kernel::{Height, LatticeError, Place, Vector};
use keepout_planner::machine::MachineProfile;
pub use language::{DialectName, DialectNameError};
pub use venus::Venus;
pub use zaber::Zaber;

use crate::supervisor::{Abilities, Command, EncodeError, Reply};

/// A controller dialect: encodes commands as bytes, and decodes bytes into replies.
///
/// The dialect itself runs exchanges of more than one line (reading settings, echoed characters): after any
/// received byte it may add bytes to send. It holds no clock, at most one partial input line, and a bounded
/// output queue.
pub trait Dialect: Send {
    /// The controller's abilities.
    fn abilities(&self) -> Abilities;

    /// Adds the bytes of a command.
    ///
    /// # Errors
    /// [`EncodeError`] when the language cannot express the command. Then no byte is added.
    fn encode(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError>;

    /// Takes one byte from the controller, and returns the message that this byte completes. Adds bytes to
    /// send when the exchange goes on. Total: every byte sequence gives some replies and no panic, and memory
    /// is bounded.
    fn decode(&mut self, byte: u8, out: &mut Vec<u8>) -> Option<Reply>;

    /// Forgets partial lines and open exchanges, after the port was opened again.
    fn reset(&mut self);

    /// The queries that read a controller's identity and settings and change nothing. `None` for a dialect
    /// without such queries: it reads its settings when a session begins.
    fn inspector(&self) -> Option<Box<dyn Inspector>> {
        None
    }
}

/// The session's parameters for a dialect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DialectConfig {
    /// Machine coordinates minus drawing coordinates.
    pub offset: Vector,
    /// Least steps per mm. A controller that reports fewer is rejected.
    pub steps_per_mm: f64,
    /// Arc tolerance, mm. The dialect sets it in the controller unless the controller's own is smaller.
    pub arc_tolerance_mm: f64,
    /// Travel of x and y, mm. `None` where a log does not state it: the dialect then does not compare the
    /// controller's travel.
    pub travel_mm: Option<[f64; 2]>,
    /// The third axis. `None` on a machine with two axes.
    pub z: Option<DialectZ>,
    /// Speed at which the controller starts the spindle, rpm. `None` where it does not switch the spindle.
    pub spindle_rpm: Option<u32>,
}

/// The session's parameters for a dialect's third axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DialectZ {
    /// The machine's height where the drawing's height is zero.
    pub zero: Height,
    /// Least steps per mm of the axis.
    pub steps_per_mm: f64,
    /// Its travel, mm. `None` where a log does not state it.
    pub travel_mm: Option<f64>,
}

impl DialectConfig {
    /// The parameters from the plan's machine profile and the drawing's offset.
    #[must_use]
    pub fn of(machine: &MachineProfile, offset: Vector) -> Self {
        let MachineProfile { steps_per_mm, arc_tolerance_mm, travel_mm, spindle_rpm, .. } = *machine;
        Self { offset, steps_per_mm, arc_tolerance_mm, travel_mm: Some(travel_mm), z: None, spindle_rpm }
    }

    /// A place of the drawing in machine coordinates. Without a third axis its height is zero.
    ///
    /// # Errors
    /// [`LatticeError`] when it leaves the lattice.
    pub(crate) fn on_machine(&self, place: Place) -> Result<Place, LatticeError> {
        let height = match self.z {
            Some(z) => i64::from(place.height.units()) + i64::from(z.zero.units()),
            None => 0,
        };
        Ok(place.point.translated(self.offset)?.at_height(Height::from_units(height)?))
    }

    /// A place in machine coordinates, in those of the drawing. Without a third axis its height is zero.
    ///
    /// # Errors
    /// [`LatticeError`] when it leaves the lattice.
    pub(crate) fn in_drawing(&self, place: Place) -> Result<Place, LatticeError> {
        let Vector { dx, dy } = self.offset;
        let height = match self.z {
            Some(z) => i64::from(place.height.units()) - i64::from(z.zero.units()),
            None => 0,
        };
        let point = place.point.translated(Vector { dx: -dx, dy: -dy })?;
        Ok(point.at_height(Height::from_units(height)?))
    }
}

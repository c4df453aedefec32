//! Controller languages, one file each.

pub mod described;
mod exchange;
mod grbl;
mod inspect;
mod language;
mod lines;
mod scale;
#[cfg(test)]
pub(crate) mod testing;
mod venus;
pub mod zaber;

pub use described::{Described, Description, DescriptionError, TemplateError};
pub use grbl::{Grbl, Status};
pub use inspect::{Finding, Fit, Inspected, Inspector};
use keepout_kernel::Vector;
use keepout_planner::machine::MachineProfile;
pub use language::{DialectName, DialectNameError};
pub use venus::Venus;
pub use zaber::Zaber;

use crate::supervisor::{Abilities, Command, EncodeError, Reply};

/// A controller's language: commands to bytes, bytes to replies.
///
/// Exchanges of more than one line (reading settings, echoed characters) are the dialect's own affair: whatever it hears, it
/// may add bytes to send. It keeps no time, no more than one line of what it hears, and few of what it has still to say.
pub trait Dialect: Send {
    /// What the controller can do.
    fn abilities(&self) -> Abilities;

    /// Adds the bytes of a command.
    ///
    /// # Errors
    /// [`EncodeError`] when the language has no words for the command; nothing is added then.
    fn encode(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError>;

    /// Takes one byte from the controller, and answers with the message that it completes. Adds bytes to send when the
    /// exchange goes on. Total: any bytes give some replies, never a panic, and memory is bounded.
    fn decode(&mut self, byte: u8, out: &mut Vec<u8>) -> Option<Reply>;

    /// The port was opened anew: what was half received or half done is forgotten.
    fn reset(&mut self);

    /// What asks the controller who it is and how it is set up, without changing anything. A dialect without such questions
    /// has none; its settings are read when a session begins.
    fn inspector(&self) -> Option<Box<dyn Inspector>> {
        None
    }
}

/// What a dialect is told of the session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DialectConfig {
    /// Machine coordinates less drawing coordinates.
    pub offset: Vector,
    /// Steps per mm below which the controller's own figure is refused.
    pub steps_per_mm: f64,
    /// Arc tolerance, mm, that the controller is given unless its own is smaller.
    pub arc_tolerance_mm: f64,
    /// Travel of x and y, mm; `None` where a log does not say it: then no controller's is compared.
    pub travel_mm: Option<[f64; 2]>,
}

impl DialectConfig {
    /// What a plan's machine and the place of its drawing make of it.
    #[must_use]
    pub fn of(machine: &MachineProfile, offset: Vector) -> Self {
        let MachineProfile { steps_per_mm, arc_tolerance_mm, travel_mm, .. } = *machine;
        Self { offset, steps_per_mm, arc_tolerance_mm, travel_mm: Some(travel_mm) }
    }
}

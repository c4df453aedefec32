//! Simulated machines: controllers that speak the dialects, with their drives, behind a serial line that takes time.
//!
//! The same objects run in virtual time ([`VirtualPort`]) and behind a real pty ([`pty`]). The [`witness`] watches the
//! true tool position and knows only the part and the tool.

mod controller;
mod grbl;
mod line;
mod machine;
mod motion;
#[cfg(unix)]
pub mod pty;
#[cfg(unix)]
pub mod standalone;
pub mod witness;

pub use controller::{Controller, Disturbance};
pub use grbl::{GrblSim, SimSettings};
pub use line::Wire;
pub use machine::{SimMachine, Slip, VirtualPort};
pub use motion::{Sample, SampleKind};

use crate::link::dialect::Language;

/// A simulated controller that speaks the language.
#[must_use]
pub fn speaking(language: &Language, settings: SimSettings) -> Box<dyn Controller> {
    match language {
        Language::Grbl => Box::new(GrblSim::new(settings)),
        Language::GrblHal => Box::new(GrblSim::hal(settings)),
    }
}

//! Simulated machines: controllers that speak the dialects, with their drives, behind a serial line that takes time.
//!
//! The same objects run in virtual time ([`VirtualPort`]) and behind a real pty ([`pty`]). The [`witness`] watches the
//! true tool position and knows only the part and the tool.

mod apart;
pub mod conformance;
mod controller;
mod described;
pub mod faults;
mod follower;
mod grbl;
mod line;
mod machine;
pub mod operator;
mod plant;
#[cfg(unix)]
pub mod pty;
#[cfg(test)]
mod round_trip;
pub mod session;
#[cfg(unix)]
pub mod standalone;
mod venus;
pub mod witness;
mod zaber;

pub use controller::{Controller, Disturbance};
pub use described::DescribedSim;
pub use follower::{Follower, Servo};
pub use grbl::{GrblSim, Quirks, SimSettings};
use keepout_executor::dialect::Language;
pub use line::Wire;
pub use machine::{SimMachine, Slip, VirtualPort};
pub use venus::VenusSim;
pub use zaber::ZaberSim;

/// A simulated controller that speaks the language.
#[must_use]
pub fn speaking(language: &Language, settings: SimSettings) -> Box<dyn Controller> {
    match language {
        Language::Grbl => Box::new(GrblSim::new(settings)),
        Language::GrblHal => Box::new(GrblSim::hal(settings)),
        Language::Zaber => Box::new(ZaberSim::new(settings)),
        Language::Venus => Box::new(VenusSim::new(settings)),
        Language::Described { description, .. } => Box::new(DescribedSim::new(description, settings)),
    }
}

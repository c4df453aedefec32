//! Simulated machines: controllers for each dialect, with their drives, behind a serial line with a baud rate
//! and a latency.
//!
//! The same objects run in virtual time ([`VirtualPort`]) and behind a real pty ([`pty`]). The [`monitor`]
//! reads the true tool position and knows only the part and the tool.

pub mod conformance;
mod controller;
mod described;
pub mod faults;
mod grbl;
mod independent;
mod line;
mod machine;
pub mod monitor;
pub mod operator;
mod plant;
#[cfg(unix)]
pub mod pty;
#[cfg(test)]
mod round_trip;
mod servo_drive;
pub mod session;
#[cfg(unix)]
pub mod standalone;
mod venus;
mod zaber;

pub use controller::{Disturbance, SimulatedController};
pub use described::DescribedSim;
pub use grbl::{GrblSim, Quirks, SimSettings};
use keepout_executor::dialect::DialectName;
pub use line::Wire;
pub use machine::{PositioningError, SimMachine, VirtualPort};
pub use servo_drive::{ServoConfig, ServoDrive};
pub use venus::VenusSim;
pub use zaber::ZaberSim;

/// A simulated controller for the dialect.
#[must_use]
pub fn speaking(language: &DialectName, settings: SimSettings) -> Box<dyn SimulatedController> {
    match language {
        DialectName::Grbl => Box::new(GrblSim::new(settings)),
        DialectName::GrblHal => Box::new(GrblSim::hal(settings)),
        DialectName::Zaber => Box::new(ZaberSim::new(settings)),
        DialectName::Venus => Box::new(VenusSim::new(settings)),
        DialectName::Described { description, .. } => Box::new(DescribedSim::new(description, settings)),
    }
}

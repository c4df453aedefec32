//! The simulated machine: a GRBL 1.1 controller with its drives, behind a serial line that takes time.
//!
//! The same object runs in virtual time ([`VirtualPort`]) and behind a real pty ([`pty`]). The [`witness`] watches the
//! true tool position and knows only the part and the tool.

mod grbl;
mod line;
mod machine;
mod motion;
#[cfg(unix)]
pub mod pty;
pub mod witness;

pub use grbl::{GrblSim, SimSettings};
pub use line::Wire;
pub use machine::{SimMachine, VirtualPort};
pub use motion::{Sample, SampleKind};

//! Simulated machines: controllers for each dialect, with their drives, behind a serial line with a baud rate
//! and a latency.
//!
//! The same objects run in virtual time ([`VirtualPort`]) and behind a real pty ([`pty`]). The [`monitor`]
//! reads the true tool position and knows only the part and the tool.
//!
//! ```
//! use keepout_executor::session::{Going, NoEventLog};
//! use keepout_executor::supervisor::PreparedPlan;
//! use keepout_planner::machine::MachineProfile;
//! use keepout_planner::request::PlanRequest;
//! use keepout_sim::operator;
//! use keepout_sim::session::{SimRun, run_simulated};
//!
//! let drawing = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../executor/cli/drawings/bracket.dxf"));
//! let machine = MachineProfile::simulated();
//! let plan = PlanRequest::default().plan("bracket", drawing, &machine, &mut |_| {}).unwrap();
//! // The operator pushes at the wall for a second, and then touches the part.
//! let operator = operator::named("wall", 1.0, 1).unwrap();
//! let run = SimRun { servo: None, ..SimRun::default() };
//! let watch = &mut |_: &_, _: &_, _| Going::On;
//! let result = run_simulated(PreparedPlan::new(plan), &run, operator, Box::new(NoEventLog), watch);
//! assert_eq!(result.unwrap().facts.deepest_mm, Some(0.0));
//! ```

pub mod conformance;
mod controller;
mod described;
pub mod faults;
mod grbl;
mod grbl_documented;
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
mod start;
mod venus;
mod zaber;

pub use controller::{Disturbance, SimulatedController};
pub use described::DescribedSim;
pub use grbl::{GrblSim, Quirks, SimSettings};
pub use grbl_documented::DocumentedGrbl;
use keepout_executor::dialect::DialectName;
pub use line::Wire;
pub use machine::{PositioningError, SimMachine, VirtualPort};
pub use servo_drive::ServoDrive;
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

//! The lean online part of Keepout: what stands between a person's hand and a spinning tool.
//!
//! ```text
//! operator ──> supervisor (guard) ──> dialect ──> port ──> controller
//!                  ^                     |
//!                  └──── replies ────────┘
//! ```
//!
//! The same supervisor runs on a real serial port, on a pty and against the simulated machine in virtual time.
//!
//! ```
//! use keepout_executor::dialect::{DialectConfig, DialectName};
//! use keepout_executor::supervisor::Command;
//! use keepout_kernel::Vector;
//! use keepout_planner::machine::MachineProfile;
//!
//! let config = DialectConfig::of(&MachineProfile::simulated(), Vector { dx: 0, dy: 0 });
//! let mut grbl = DialectName::named("grbl").unwrap().dialect(config);
//! let mut bytes = Vec::new();
//! grbl.encode(&Command::Query, &mut bytes).unwrap();
//! assert_eq!(bytes, b"?");
//! ```

pub mod dialect;
pub mod operator;
pub mod session;
pub mod supervisor;

//! The executor: the online part of Keepout, between the operator and the machine.
//!
//! ```text
//! operator ──> supervisor (guard) ──> dialect ──> port ──> controller
//!                  ^                     |
//!                  └──── replies ────────┘
//! ```
//!
//! The same supervisor runs on a real serial port, on a pty, and on the simulated machine in virtual time.

pub mod dialect;
pub mod operator;
pub mod session;
pub mod supervisor;

//! The lean online part of Keepout: what stands between a person's hand and a spinning tool.
//!
//! ```text
//! operator ──> supervisor (guard) ──> dialect ──> port ──> controller
//!                  ^                     |
//!                  └──── replies ────────┘
//! ```
//!
//! The same supervisor runs on a real serial port, on a pty and against the simulated machine in virtual time.

pub mod dialect;
pub mod operator;
pub mod session;
pub mod supervisor;

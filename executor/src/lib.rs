//! The lean online part of Keepout: what stands between a person's hand and a spinning tool.
//!
//! ```text
//! operator ──> supervisor (guard) ──> dialect ──> port ──> controller
//!                  ^                     |
//!                  └──── replies ────────┘
//! ```
//!
//! The same supervisor runs on a real serial port, on a pty and against the simulated machine in virtual time.

pub mod conformance;
pub mod link;
pub mod operator;
pub mod servo;
pub mod session;
pub mod sim;
pub mod study;
pub mod supervisor;
pub mod time;

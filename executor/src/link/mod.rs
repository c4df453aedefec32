//! The link to the controller: ports, and the dialects spoken over them.

pub mod dialect;
pub mod port;
pub mod serial;

//! The operator's panel: a local web server and its page.
//!
//! The panel is one more source of jog input and operator commands. It can only ask the supervisor, which can only ask
//! the guard. So latency, a lost socket or a lying browser cost comfort, and not the part.
//!
//! - [`lease`]: one client steers, the others watch.
//! - [`gate`]: what the holder of the lease sends counts in order and in time only.
//! - [`hub`]: the meeting place of the browsers and the session loop, which never waits for them.

#[cfg(feature = "server")]
pub mod access;
pub mod bench;
pub mod gate;
pub mod hub;
pub mod latest;
pub mod lease;
pub mod protocol;
#[cfg(feature = "server")]
pub mod server;
pub mod snapshot;

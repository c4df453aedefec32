//! The session log: one line for each thing that happened, in order, each with a checksum over itself and the line before
//! it, after a tab.
//!
//! ```text
//! keepout-log 1 plan=9f86… dialect=grbl offset=-20000000,500 …  1c291ca3
//! 1204417 r <Idle|MPos:-10.000,-10.000,0.000|Bf:15,128>\r\n  8bb02b2c
//! 1204417 c -9.5,-10 {-10,-10 -9.5,-10}  0a3e51d1
//! 1204417 s $J=G53G90G21X-9.5Y-10F12000\n  77d1a2c0
//! ```
//!
//! Times are microseconds since the session began. Lines are appended and never changed. A tail that was torn off by a
//! power cut is no error; damage before the end is, with its line.

mod job;
mod line;
mod read;
mod write;

pub(crate) use line::as_entry;
pub use line::{Certificate, Entry, LineError};
pub use read::{Log, LogReadError};
pub use write::{Header, LogError, LogTape};

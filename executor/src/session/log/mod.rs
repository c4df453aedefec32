//! The session log: one line for each thing that went into the engine or came out of it, in order, each with a checksum over
//! itself and the line before it, after a tab.
//!
//! ```text
//! keepout-log 1 began=2026-11-21T16:50:02Z plan=e5cd… drawing=bracket.dxf dialect=grbl offset=-24500000,…   15926028
//! 1085196 r <Idle|MPos:-1.000,-1.000,0.000|Bf:15,128|FS:0,0|WCO:-37.250,-21.500,0.000>\r\n   8bb02b2c
//! 1085196 p Manual   47d05c69
//! 1090000 w -0.709 -0.704 0.0 0.0 0 -   0a3e51d1
//! 1090000 c jog 24500000 20404200 12000 {24400000 20900000, 24500000 20404200}   3470a8af
//! 1090000 s $J=G53G90G21X0Y-5.958F12000\n   77d1a2c0
//! 1100000 w   1c291ca3
//! ```
//!
//! Times are microseconds since the session began; the header has the date. A letter says what the line is:
//!
//! | | |
//! |---|---|
//! | `r` `s` | bytes received, bytes sent |
//! | `w` | the operator's input: direction, turns in mm, automatic mode, what is asked; alone when it is as before |
//! | `t` | time passed |
//! | `j` | a contouring job was worked out |
//! | `x` `o` `h` | the port failed, was found again; the session is to end |
//! | `c` | a motion was certified: its target, feed and in-flight set, or the contour's motion, in lattice units |
//! | `p` | the supervisor went into another state; a fault behind it |
//!
//! Lines are appended and never changed, and handed to the system before anything is sent. A tail without its line end is no
//! error, a whole line that does not match is. That whole lines are missing at the end can not be seen, but that the session's
//! end is.

mod date;
mod header;
mod job;
mod line;
mod read;
mod write;

pub use date::rfc_3339;
pub use header::Header;
pub(crate) use line::as_entry;
pub use line::{Certificate, Entry, LineError, unescaped};
pub use read::{Log, LogReadError, LogReader, LoggedEntry};
pub use write::{LogError, LogTape};

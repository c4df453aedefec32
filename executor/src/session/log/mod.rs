//! The log file of a session: one JSON line per event, with a checksum over itself and the line before.
//!
//! ```text
//! {"crc":"15926028","keepout_log":3,"began":"2026-11-21T16:50:02Z","plan":"e5cd…","dialect":"grbl",…}
//! {"crc":"8bb02b2c","at_us":1085196,"event":{"received":"<Idle|MPos:-1.000,-1.000,0.000|Bf:15,128|FS:0,0>\r\n"}}
//! {"crc":"47d05c69","at_us":1085196,"event":{"phase":{"phase":"manual"}}}
//! {"crc":"0e3a51d1","at_us":1090000,"event":{"input":{"velocity":[-0.709,-0.704],…}}}
//! {"crc":"3470a8af","at_us":1090000,"event":{"certificate":{"jog":{"to":[24500000,20404200],"set":[…],…}}}}
//! {"crc":"77d1a2c0","at_us":1090000,"event":{"sent":"$J=G53G90G21X0Y-5.958F12000\n"}}
//! {"crc":"1c291ca3","at_us":1100000}
//! ```
//!
//! Times are microseconds since the session began. The header has the date. [`LoggedEvent`] lists the events.
//! A line without an event repeats the last jog input. Coordinates are in lattice units. Each byte is the
//! character with the same number.
//!
//! The program appends lines, and never changes one. It hands them to the operating system before it sends
//! bytes. An incomplete last line is allowed. A complete line with a wrong checksum is an error. A reader
//! cannot detect that complete lines are missing at the end, but it detects that the session's end is
//! missing.

mod date;
mod header;
mod line;
mod read;
mod write;

pub use date::rfc_3339;
pub use header::{Header, HeaderZ, VERSION};
use keepout_guard::Time;
use keepout_planner::file::FileKind;
pub use line::LineError;
pub use read::{Entry, Log, LogReadError, LogReader};
use serde::{Deserialize, Serialize};
pub use write::{LogError, LogWriter};

use super::event_log::LoggedEvent;

/// The file kind of a log.
pub static LOG: FileKind =
    FileKind { unwritable: "Choose another place with --log.", ..FileKind::new("log") };

/// A line after the header.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct EventLine<'a> {
    #[serde(with = "super::micros", rename = "at_us")]
    at: Time,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    event: Option<LoggedEvent<'a>>,
}

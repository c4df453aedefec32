//! Zaber messages on the wire: frames, checksums, answers and the meaning of their flags.
//!
//! Implements SR-18.

use std::io::Write as _;

use crate::dialect::exchange::Sent;
use crate::supervisor::{Mode, Reply};

/// A framed command, such as `/1 0 07 get pos:A3`.
pub(super) fn framed(number: u8, command: std::fmt::Arguments<'_>) -> Sent {
    let mut line = Sent::new();
    // A command is far shorter than the longest line.
    let _ = write!(line, "/1 0 {number:02} {command}");
    let sum = checksum(&line[1..]);
    let _ = writeln!(line, ":{sum:02X}");
    line
}

/// The two's complement of the sum of the bytes.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0_u8, |sum, &byte| sum.wrapping_add(byte)).wrapping_neg()
}

/// The text between the first character and the checksum. `None` when the checksum is wrong, or missing
/// although `needed`.
#[must_use]
pub fn content(line: &str, needed: bool) -> Option<&str> {
    let rest = line.get(1..)?;
    match rest.rsplit_once(':') {
        Some((content, sum)) => {
            let right = sum.len() == 2 && u8::from_str_radix(sum, 16) == Ok(checksum(content.as_bytes()));
            right.then_some(content)
        }
        None => (!needed).then_some(rest),
    }
}

/// An answer: `01 0 07 OK IDLE -- 12345 678`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer<'a> {
    pub(super) number: u8,
    pub(super) ok: bool,
    pub(super) busy: bool,
    pub(super) warning: &'a str,
    pub(super) data: &'a str,
}

impl<'a> Answer<'a> {
    pub(super) fn read(content: &'a str) -> Option<Self> {
        let mut fields = content.splitn(7, ' ');
        let (device, _axis) = (fields.next()?, fields.next()?);
        let number = fields.next()?;
        let (flag, status, warning) = (fields.next()?, fields.next()?, fields.next()?);
        let known = matches!(flag, "OK" | "RJ") && matches!(status, "IDLE" | "BUSY") && device == "01";
        known.then_some(Self {
            number: number.parse().ok()?,
            ok: flag == "OK",
            busy: status == "BUSY",
            warning,
            data: fields.next().unwrap_or("").trim(),
        })
    }

    /// The numbers of the axes: two, or three with `three`. The third is otherwise zero.
    pub(super) fn axes(&self, three: bool) -> Option<[i64; 3]> {
        let mut values = self.data.split(' ').map(|value| value.parse::<i64>().ok());
        Some([values.next()??, values.next()??, if three { values.next()?? } else { 0 }])
    }

    pub(super) fn mode(&self) -> Mode {
        match self.warning {
            warning if warning.starts_with('F') => Mode::Alarm,
            // No reference, not homed, an unexpected limit switch.
            "WR" | "WH" | "WL" => Mode::Alarm,
            // The operator turns the knob.
            "NC" => Mode::Other,
            _ if self.busy => Mode::Moving,
            _ => Mode::Idle,
        }
    }
}

pub(super) fn alarm(warning: &str) -> Reply {
    let (code, meaning) = match warning.get(..2).unwrap_or("") {
        "FS" => (1, "stalled and stopped"),
        "FE" => (2, "limit switches"),
        "FQ" => (3, "encoder"),
        "FD" => (4, "driver off"),
        "FB" => (5, "a stream left the travel"),
        "FO" | "FP" => (6, "the axis left its path"),
        "WR" | "WH" => (7, "not homed"),
        "WL" => (8, "an unexpected limit switch"),
        _ => (0, ""),
    };
    Reply::Alarm { code, meaning }
}

pub(super) fn refusal(reason: &str) -> (u16, &'static str) {
    match reason {
        "AGAIN" => (1, "the stream is full"),
        "BADAXIS" => (2, "no such axis"),
        "BADCOMMAND" => (3, "no such command"),
        "BADDATA" => (4, "beyond the machine's travel, or a number out of range"),
        "STATUSBUSY" => (5, "busy"),
        "FULL" => (6, "no room"),
        "NOACCESS" => (7, "no access"),
        "PARKED" => (8, "parked"),
        _ => (0, ""),
    }
}

//! The meaning of the firmware's words and numbers.
//!
//! Implements SR-18, SR-19.

use crate::supervisor::Mode;

/// The mode of a state word. After a colon may stand a number for the kind of state. `None` for anything
/// else: such a state is part of a damaged report.
pub(super) fn mode(state: &str) -> Option<Mode> {
    let (word, kind) = match state.split_once(':') {
        Some((word, kind)) => (word, Some(kind.parse::<u8>().ok()?)),
        None => (state, None),
    };
    Some(match (word, kind) {
        ("Idle", _) => Mode::Idle,
        ("Jog" | "Run", _) => Mode::Moving,
        ("Hold", Some(1)) => Mode::Slowing,
        ("Hold", _) => Mode::Held,
        ("Home", _) => Mode::Homing,
        ("Alarm", _) => Mode::Alarm,
        ("Door" | "Check" | "Sleep" | "Tool", _) => Mode::Other,
        _ => return None,
    })
}

pub(super) fn error_text(code: u16) -> &'static str {
    match code {
        1..=3 => "a damaged line",
        8 => "not idle",
        9 => "locked by an alarm",
        11 | 14 => "a line too long",
        15 => "beyond the machine's travel",
        20..=25 | 33..=35 => "not valid G-code",
        _ => "",
    }
}

pub(super) fn alarm_text(code: u16) -> &'static str {
    match code {
        1 => "limit switch",
        2 => "beyond the machine's travel",
        3 => "reset while moving, position lost",
        6..=9 => "homing failed",
        _ => "",
    }
}

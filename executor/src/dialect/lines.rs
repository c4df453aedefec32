//! Lines of text from a controller, and numbers in them.
//!
//! Implements SR-17.

use arrayvec::ArrayVec;
use keepout_kernel::{Height, Place};
use keepout_planner::Mm2;
use keepout_planner::units::{height_from_mm, point_from_mm};

use crate::supervisor::{Text, text};

/// Longest accepted line from a controller, bytes.
const LINE_MAX: usize = 256;

/// Gathers bytes into lines.
#[derive(Clone, Debug, Default)]
pub(super) struct Lines {
    line: ArrayVec<u8, LINE_MAX>,
    spoilt: bool,
}

/// A complete line.
#[derive(Clone, Debug)]
pub(super) enum Line {
    /// Printable ASCII.
    Text(ArrayVec<u8, LINE_MAX>),
    /// Too long, or not printable.
    Garbled(Text),
}

impl Lines {
    /// Takes a byte. A line feed completes the line; empty lines are skipped.
    pub(super) fn take(&mut self, byte: u8) -> Option<Line> {
        match byte {
            b'\n' => self.complete(),
            b'\r' => None,
            _ => {
                self.spoilt |= !(0x20..0x7f).contains(&byte) || self.line.try_push(byte).is_err();
                None
            }
        }
    }

    /// Ends the line here.
    pub(super) fn complete(&mut self) -> Option<Line> {
        let line = std::mem::take(&mut self.line);
        if std::mem::take(&mut self.spoilt) {
            return Some(Line::Garbled(text(as_str(&line))));
        }
        (!line.is_empty()).then_some(Line::Text(line))
    }

    /// Whether the received part of the line equals `text`.
    pub(super) fn stands_at(&self, text: &[u8]) -> bool {
        !self.spoilt && self.line.as_slice() == text
    }

    /// Whether the received part of the line is empty or only spaces.
    pub(super) fn is_blank(&self) -> bool {
        !self.spoilt && self.line.iter().all(|&byte| byte == b' ')
    }

    /// Drops the partial line.
    pub(super) fn clear(&mut self) {
        self.line.clear();
        self.spoilt = false;
    }
}

/// The bytes as text; empty if they are not UTF-8.
pub(super) fn as_str(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap_or("")
}

/// The place from the first values of a comma-separated list in mm: two, or three on a machine with `three`
/// axes. Without a third axis its height is zero.
pub(super) fn place(value: &str, three: bool) -> Option<Place> {
    let mut values = value.split(',').map(|number| number.trim().parse::<f64>().ok());
    let point = point_from_mm(Mm2::new(values.next()??, values.next()??)).ok()?;
    Some(point.at_height(if three { height_from_mm(values.next()??).ok()? } else { Height::ZERO }))
}

/// A destination for bytes. Bytes that do not fit are dropped.
pub trait Sink {
    /// Takes a byte.
    fn put(&mut self, byte: u8);
}

impl Sink for Vec<u8> {
    fn put(&mut self, byte: u8) {
        self.push(byte);
    }
}

impl<const N: usize> Sink for ArrayVec<u8, N> {
    fn put(&mut self, byte: u8) {
        let _ = self.try_push(byte);
    }
}

/// Adds a length in lattice units as exact decimal mm, with as few digits as possible: `1.5`, `-0.00001`.
pub(super) fn push_mm(out: &mut impl Sink, units: i32) {
    if units < 0 {
        out.put(b'-');
    }
    let magnitude = units.unsigned_abs();
    push_number(out, u64::from(magnitude / 100_000));
    let mut fraction = magnitude % 100_000;
    if fraction == 0 {
        return;
    }
    out.put(b'.');
    let mut place = 10_000;
    while fraction > 0 {
        out.put(digit(u64::from(fraction / place)));
        fraction %= place;
        place = (place / 10).max(1);
    }
}

/// Adds a whole number.
pub(super) fn push_number(out: &mut impl Sink, number: u64) {
    let mut place = 1;
    while number / place >= 10 {
        place *= 10;
    }
    let mut rest = number;
    while place > 0 {
        out.put(digit(rest / place));
        rest %= place;
        place /= 10;
    }
}

fn digit(value: u64) -> u8 {
    b'0' + u8::try_from(value % 10).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_numbers_are_exact_and_short() {
        for (units, written) in [
            (150_000, "1.5"),
            (-1, "-0.00001"),
            (0, "0"),
            (-12_345_600, "-123.456"),
            (i32::MIN, "-21474.83648"),
        ] {
            let mut out = Vec::new();
            push_mm(&mut out, units);
            assert_eq!(as_str(&out), written);
        }
        let mut out = Vec::new();
        push_number(&mut out, u64::MAX);
        assert_eq!(as_str(&out), u64::MAX.to_string());
    }

    #[test]
    fn lines_are_bounded() {
        let mut lines = Lines::default();
        assert!((0..5000).all(|_| lines.take(b'x').is_none()));
        assert!(matches!(lines.take(b'\n'), Some(Line::Garbled(_))));
        assert!(b"\r\n".iter().all(|&byte| lines.take(byte).is_none()));
        assert!(lines.take(0xff).is_none());
        assert!(matches!(lines.take(b'\n'), Some(Line::Garbled(_))));
    }
}

//! The words of a line: letters with numbers, and the error codes of the firmware.
//!
//! Source: `doc/csv/error_codes_en_US.csv`.

use std::fmt;

/// The number of an `error:` answer.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct LineErrorCode(pub u8);

impl fmt::Debug for LineErrorCode {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "error:{}", self.0)
    }
}

impl LineErrorCode {
    pub const LETTER: Self = Self(1);
    pub const NUMBER: Self = Self(2);
    pub const STATEMENT: Self = Self(3);
    pub const NEGATIVE: Self = Self(4);
    pub const HOMING_OFF: Self = Self(5);
    pub const SHORT_PULSE: Self = Self(6);
    pub const NOT_IDLE: Self = Self(8);
    pub const LOCKED: Self = Self(9);
    pub const SOFT_LIMITS_WITHOUT_HOMING: Self = Self(10);
    pub const LONG_LINE: Self = Self(11);
    pub const TRAVEL: Self = Self(15);
    pub const JOG: Self = Self(16);
    pub const UNSUPPORTED: Self = Self(20);
    pub const MODAL_GROUP: Self = Self(21);
    pub const FEED: Self = Self(22);
    pub const WHOLE_NUMBER: Self = Self(23);
    pub const AXIS_CONFLICT: Self = Self(24);
    pub const REPEATED: Self = Self(25);
    pub const NO_AXIS: Self = Self(26);
    pub const LINE_NUMBER: Self = Self(27);
    pub const MISSING_VALUE: Self = Self(28);
    pub const SYSTEM: Self = Self(29);
    pub const G53: Self = Self(30);
    pub const UNUSED_AXIS: Self = Self(31);
    pub const NO_AXIS_IN_PLANE: Self = Self(32);
    pub const TARGET: Self = Self(33);
    pub const RADIUS: Self = Self(34);
    pub const NO_OFFSET: Self = Self(35);
    pub const UNUSED: Self = Self(36);
    pub const TOOL_AXIS: Self = Self(37);
    pub const TOOL: Self = Self(38);
}

/// A G or M word: the letter, and its number in tenths (G38.2 is 382).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CodeWord {
    pub letter: u8,
    pub tenths: u16,
}

/// The value words of a line. Each one is taken once, so that leftover words are found.
#[derive(Clone, Debug, Default)]
pub(super) struct LineWords {
    values: [Option<f64>; 26],
}

/// Letters that carry a value.
const VALUES: &[u8] = b"FIJKLNPRSTXYZ";
/// Value letters that must not be negative.
const POSITIVE: &[u8] = b"FNPTS";

impl LineWords {
    /// The value words of a line that has capital letters and no spaces. `code` takes the G and M words, in order.
    pub fn of(
        line: &[u8],
        mut code: impl FnMut(CodeWord) -> Result<(), LineErrorCode>,
    ) -> Result<Self, LineErrorCode> {
        let mut words = Self::default();
        let mut rest = line;
        while let Some((&letter, after)) = rest.split_first() {
            if !letter.is_ascii_uppercase() {
                return Err(LineErrorCode::LETTER);
            }
            let (value, after) = number(after).ok_or(LineErrorCode::NUMBER)?;
            if matches!(letter, b'G' | b'M') {
                let tenths =
                    format!("{:.0}", value * 10.0).parse().map_err(|_| LineErrorCode::UNSUPPORTED)?;
                code(CodeWord { letter, tenths })?;
            } else {
                words.take_in(letter, value)?;
            }
            rest = after;
        }
        Ok(words)
    }

    fn take_in(&mut self, letter: u8, value: f64) -> Result<(), LineErrorCode> {
        if !VALUES.contains(&letter) {
            return Err(LineErrorCode::UNSUPPORTED);
        }
        if POSITIVE.contains(&letter) && value < 0.0 {
            return Err(LineErrorCode::NEGATIVE);
        }
        if letter == b'T' && value > 255.0 {
            return Err(LineErrorCode::TOOL);
        }
        let place = &mut self.values[usize::from(letter - b'A')];
        if place.is_some() {
            return Err(LineErrorCode::REPEATED);
        }
        *place = Some(value);
        Ok(())
    }

    /// The value of a letter, which stays unused.
    pub fn seen(&self, letter: u8) -> Option<f64> {
        self.values[usize::from(letter - b'A')]
    }

    /// Takes the value of a letter.
    pub fn take(&mut self, letter: u8) -> Option<f64> {
        self.values[usize::from(letter - b'A')].take()
    }

    /// Takes the values of three letters.
    pub fn take_three(&mut self, letters: &[u8; 3]) -> [Option<f64>; 3] {
        letters.map(|letter| self.take(letter))
    }

    /// Whether the line has an axis word.
    pub fn has_axis(&self) -> bool {
        b"XYZ".iter().any(|&letter| self.seen(letter).is_some())
    }

    /// Whether value words are left.
    pub fn has_unused(&self) -> bool {
        self.values.iter().any(Option::is_some)
    }
}

/// A number at the start of a text: digits with at most one point, and no exponent. And the rest of the text.
pub(super) fn number(text: &[u8]) -> Option<(f64, &[u8])> {
    let signed = usize::from(matches!(text.first(), Some(b'+' | b'-')));
    let mut end = signed;
    let (mut points, mut digits) = (0, 0);
    while let Some(&byte) = text.get(end) {
        match byte {
            b'0'..=b'9' => digits += 1,
            b'.' if points == 0 => points += 1,
            _ => break,
        }
        end += 1;
    }
    if digits == 0 {
        return None;
    }
    let value = std::str::from_utf8(&text[..end]).ok()?.parse().ok()?;
    Some((value, &text[end..]))
}

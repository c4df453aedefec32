//! Line templates with slots for values. The same template writes a line and reads one.
//!
//! Implements SR-18.

use thiserror::Error;

use super::super::lines::Sink;

/// The kind of value in a slot of a template.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// First coordinate.
    X,
    /// Second coordinate.
    Y,
    /// Height, where the machine has a third axis.
    Z,
    /// From an arc's start to its centre, first coordinate.
    I,
    /// As [`Slot::I`], second coordinate.
    J,
    /// The feed.
    Feed,
    /// A state, as a word or a number.
    Status,
    /// The number of an error.
    Code,
    /// Any text, ignored.
    Any,
}

const SLOTS: [(&str, Slot); 9] = [
    ("x", Slot::X),
    ("y", Slot::Y),
    ("z", Slot::Z),
    ("i", Slot::I),
    ("j", Slot::J),
    ("feed", Slot::Feed),
    ("status", Slot::Status),
    ("code", Slot::Code),
    ("any", Slot::Any),
];

impl Slot {
    fn index(self) -> usize {
        SLOTS.iter().position(|&(_, slot)| slot == self).unwrap_or(0)
    }

    /// Whether the slot holds a number.
    fn is_number(self) -> bool {
        !matches!(self, Self::Status | Self::Any)
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Piece {
    Text(String),
    Slot(Slot),
}

/// A line with slots for values: `MA{x},{y}`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Template {
    pieces: Vec<Piece>,
}

/// Why a line is not a valid template.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TemplateError {
    /// An unknown slot name.
    #[error(
        "{{{0}}} is unknown: use {{x}}, {{y}}, {{z}}, {{i}}, {{j}}, {{feed}}, {{status}}, {{code}} or {{any}}"
    )]
    Unknown(String),
    /// A brace without its partner.
    #[error("a {{ without its }}, or a }} without its {{")]
    Brace,
    /// A character that is not printable ASCII.
    #[error("{0:?} is not a printable ASCII character")]
    Letter(char),
}

impl Template {
    /// Reads a template.
    pub(super) fn of(text: &str) -> Result<Self, TemplateError> {
        if let Some(letter) = text.chars().find(|letter| !(' '..='~').contains(letter)) {
            return Err(TemplateError::Letter(letter));
        }
        let mut pieces = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            if !before.is_empty() {
                pieces.push(Piece::Text(before.into()));
            }
            let (name, behind) = after.split_once('}').ok_or(TemplateError::Brace)?;
            let slot = SLOTS.iter().find(|(known, _)| *known == name);
            pieces.push(Piece::Slot(slot.ok_or_else(|| TemplateError::Unknown(name.into()))?.1));
            rest = behind;
        }
        if !rest.is_empty() {
            pieces.push(Piece::Text(rest.into()));
        }
        let stray = pieces.iter().any(|piece| matches!(piece, Piece::Text(text) if text.contains('}')));
        if stray { Err(TemplateError::Brace) } else { Ok(Self { pieces }) }
    }

    /// Whether it has that slot.
    pub(super) fn has(&self, slot: Slot) -> bool {
        self.pieces.contains(&Piece::Slot(slot))
    }

    /// The most bytes that it can write, with `number` bytes for each value.
    pub(super) fn longest(&self, number: usize) -> usize {
        let each = |piece: &Piece| match piece {
            Piece::Text(text) => text.len(),
            Piece::Slot(_) => number,
        };
        self.pieces.iter().map(each).sum()
    }

    /// Writes the line, with each value from `write`.
    pub fn write<S: Sink>(&self, out: &mut S, mut write: impl FnMut(Slot, &mut S)) {
        for piece in &self.pieces {
            match piece {
                Piece::Text(text) => text.bytes().for_each(|byte| out.put(byte)),
                Piece::Slot(slot) => write(*slot, out),
            }
        }
    }

    /// Reads a line of this form. `None` when the line has another form. The line may have spaces where the
    /// template has none.
    #[must_use]
    pub fn read<'a>(&self, line: &'a str) -> Option<Captures<'a>> {
        let mut captures = Captures::default();
        let mut rest = line.trim();
        for (index, piece) in self.pieces.iter().enumerate() {
            rest = rest.trim_start();
            match piece {
                Piece::Text(text) => {
                    for word in text.split_whitespace() {
                        rest = rest.trim_start().strip_prefix(word)?;
                    }
                }
                Piece::Slot(slot) => {
                    let end = self.end_of(index, *slot, rest);
                    let (value, behind) = rest.split_at(end);
                    let goes_on = slot.is_number() && self.goes_on(index, *slot, behind);
                    if value.is_empty() && *slot != Slot::Any || goes_on {
                        return None;
                    }
                    captures.values[slot.index()] = Some(value.trim());
                    rest = behind;
                }
            }
        }
        rest.trim().is_empty().then_some(captures)
    }

    /// Whether the text `behind` may continue the number at `index`: `1.0e-05` is not 1. A number ends at a
    /// space, or at the template's next text. An error code also ends before any character that is not a
    /// letter or a digit.
    fn goes_on(&self, index: usize, slot: Slot, behind: &str) -> bool {
        let Some(letter) = behind.chars().next() else { return false };
        let ends = match self.pieces.get(index + 1) {
            Some(Piece::Text(text)) => text.trim_start().starts_with(letter),
            Some(Piece::Slot(_)) => !letter.is_ascii_alphanumeric(),
            None => false,
        };
        let code = slot == Slot::Code && !letter.is_ascii_alphanumeric();
        !letter.is_whitespace() && !ends && !code
    }

    /// The end of the value at `index`: a number ends with its last digit, a word before the template's next
    /// text.
    fn end_of(&self, index: usize, slot: Slot, rest: &str) -> usize {
        if slot.is_number() {
            return rest.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(rest.len());
        }
        let goes_on = index + 2 < self.pieces.len();
        let follows = match self.pieces.get(index + 1) {
            // Text that begins with a space follows a word, and the word may contain the same letters.
            Some(Piece::Text(text)) if text.starts_with(' ') && !text.trim().is_empty() => {
                let behind = rest.find(text.trim_end()).or_else(|| rest.find(text.trim()));
                return behind.unwrap_or(rest.len());
            }
            Some(Piece::Text(text)) => text.trim().chars().next().or(goes_on.then_some(' ')),
            Some(Piece::Slot(_)) => Some(' '),
            None => None,
        };
        follows.and_then(|letter| rest.find(letter)).unwrap_or(rest.len())
    }
}

/// The values in the slots of a line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Captures<'a> {
    values: [Option<&'a str>; SLOTS.len()],
}

impl<'a> Captures<'a> {
    /// The text in that slot.
    #[must_use]
    pub fn text(&self, slot: Slot) -> Option<&'a str> {
        self.values[slot.index()]
    }

    /// The number in that slot.
    #[must_use]
    pub fn number(&self, slot: Slot) -> Option<f64> {
        self.text(slot)?.parse().ok().filter(|number: &f64| number.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn templates_are_read_back() {
        let template = Template::of("$J=G90 X{x}Y{y}F{feed}").unwrap();
        let mut out = Vec::new();
        template.write(&mut out, |slot, out: &mut Vec<u8>| match slot {
            Slot::X => out.extend(b"-1.5"),
            Slot::Y => out.extend(b"2"),
            _ => out.extend(b"600"),
        });
        assert_eq!(out, b"$J=G90 X-1.5Y2F600");
        let captures = template.read("$J=G90 X-1.5Y2F600").unwrap();
        assert_eq!((captures.number(Slot::X), captures.number(Slot::Feed)), (Some(-1.5), Some(600.0)));
        assert!(template.read("$J=G90 X-1.5Y2").is_none() && template.read("G90").is_none());
        let state = Template::of("<{status}|MPos:{x},{y},{any}").unwrap();
        let captures = state.read("<Idle|MPos:1.000,2.000,0.000|FS:0,0>").unwrap();
        assert_eq!((captures.text(Slot::Status), captures.number(Slot::Y)), (Some("Idle"), Some(2.0)));
        assert!(Template::of("{x} {y}").unwrap().read("  12   -3 \r").is_some());
        assert!(Template::of("{x} {y}").unwrap().read("12").is_none());
    }

    // Evidence for SR-18.
    /// Found by review: `{any}` matched the exponent of a number.
    #[test]
    fn number_ends_only_at_a_space_or_the_next_text() {
        for (template, line) in [
            ("{x} {y} {any}", "12.0 1.0e-05 0"),
            ("{x} {y} {any}", "12.0 1.0,5 0"),
            ("{x},{y}{any}", "12.0,1.0E3"),
            ("{x},{y} {any}", "12.0e1,1.0 0"),
            ("{x} {y}", "12.0 0x10"),
            ("ERR {code} {any}", "ERR 12h axis busy"),
        ] {
            assert!(Template::of(template).unwrap().read(line).is_none(), "{line}");
        }
        for (template, line) in [
            ("{x} {y} {any}", "12.0 1.0 0"),
            ("{x},{y}{any}", "12.0,1.0|FS"),
            ("X{x}Y{y}F{feed}", "X1 Y2F3"),
            ("{x} mm {y} mm", "1mm 2 mm"),
            ("ERR {code} {any}", "ERR 12: axis busy"),
        ] {
            assert!(Template::of(template).unwrap().read(line).is_some(), "{line}");
        }
    }

    /// Found by review: a state before a space matched the whole line, and a state ended at the first letter
    /// of the following text.
    #[test]
    fn state_is_one_word() {
        for (template, line, state) in [
            ("{status} {x} {y}", "I 12.000 3.000", "I"),
            ("{status} MPos:{x},{y}", "Moving MPos:12.000,3.000", "Moving"),
            ("{status}MPos:{x},{y}", "I MPos:12.000,3.000", "I"),
            ("{status} :{x} {y}", "I:12.000 3.000", "I"),
            ("{any} {status} X{x} Y{y}", "07 Idle X12.000 Y3.000", "Idle"),
        ] {
            let template = Template::of(template).unwrap();
            let captures = template.read(line).unwrap_or_else(|| panic!("{line}"));
            assert_eq!(captures.text(Slot::Status).map(str::trim), Some(state), "{line}");
            assert_eq!(
                (captures.number(Slot::X), captures.number(Slot::Y)),
                (Some(12.0), Some(3.0)),
                "{line}"
            );
        }
        assert_eq!(Template::of("S {status} ").unwrap().read("S I ").unwrap().text(Slot::Status), Some("I"));
    }

    #[test]
    fn invalid_templates_are_rejected() {
        assert_eq!(Template::of("{w}"), Err(TemplateError::Unknown("w".into())));
        assert_eq!(Template::of("{x"), Err(TemplateError::Brace));
        assert_eq!(Template::of("x}"), Err(TemplateError::Brace));
        assert_eq!(Template::of("a\n"), Err(TemplateError::Letter('\n')));
    }

    #[test]
    fn reading_is_total() {
        let mut random = fastrand::Rng::with_seed(9);
        let letters = b"<{status}|xy{x},{y}0123.-+ {any}>";
        for _ in 0..20_000 {
            let mut some = |most: usize| -> String {
                (0..random.usize(0..most))
                    .map(|_| char::from(letters[random.usize(0..letters.len())]))
                    .collect()
            };
            let (pattern, line) = (some(20), some(40));
            if let Ok(template) = Template::of(&pattern) {
                let _ = template.read(&line);
            }
        }
    }
}

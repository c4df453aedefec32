//! The scanner: reads DXF bytes, ASCII or binary, as a stream of group codes and values.
//!
//! Implements SR-27.

use super::damage::{Damage, FilePlace};

/// Longest text that the reader accepts in a binary file, bytes.
pub(super) const TEXT_MAX: usize = 1 << 16;
const SENTINEL: &[u8] = b"AutoCAD Binary DXF\r\n\x1a\0";

/// The value of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// Text, or a number not yet parsed, without blanks around it.
    Text(&'a [u8]),
    /// An integer of a binary file.
    Integer(i64),
    /// A number of a binary file.
    Real(f64),
}

/// A group: its code and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tag<'a> {
    /// The group code.
    pub code: i16,
    /// The value.
    pub value: Value<'a>,
    /// The line of the value in an ASCII file, or the first byte of the group in a binary file.
    pub at: FilePlace,
}

impl<'a> Tag<'a> {
    /// The value as text; empty for the numbers of binary files.
    #[must_use]
    pub fn text(&self) -> &'a [u8] {
        match self.value {
            Value::Text(text) => text,
            _ => b"",
        }
    }

    /// The value as a finite number.
    ///
    /// # Errors
    /// [`Damage::Number`] with the place.
    pub fn real(&self) -> Result<f64, Damage> {
        let number = match self.value {
            Value::Real(number) => Some(number),
            Value::Integer(integer) => i32::try_from(integer).ok().map(f64::from),
            Value::Text(text) => std::str::from_utf8(text).ok().and_then(|text| text.parse().ok()),
        };
        number.filter(|number| number.is_finite()).ok_or_else(|| self.no_number())
    }

    /// The value as an integer. A real number without a fraction is valid, too.
    ///
    /// # Errors
    /// [`Damage::Number`] with the place.
    pub fn integer(&self) -> Result<i64, Damage> {
        match self.value {
            Value::Integer(integer) => Ok(integer),
            Value::Text(text) => {
                let text = std::str::from_utf8(text).unwrap_or("");
                text.parse().or_else(|_| self.whole())
            }
            Value::Real(_) => self.whole(),
        }
    }

    fn whole(&self) -> Result<i64, Damage> {
        let number = self.real()?;
        let whole = keepout_kernel::curve::nearest_unit(number);
        if number.fract() == 0.0 && whole != i64::MAX { Ok(whole) } else { Err(self.no_number()) }
    }

    fn no_number(&self) -> Damage {
        let found = match self.value {
            Value::Text(text) => shortened(text),
            Value::Integer(integer) => integer.to_string(),
            Value::Real(real) => real.to_string(),
        };
        Damage::Number { at: self.at, code: self.code, found }
    }
}

fn shortened(text: &[u8]) -> String {
    String::from_utf8_lossy(text).chars().filter(|c| !c.is_control()).take(40).collect()
}

/// Reads groups one after the other and skips comments (code 999).
#[derive(Clone, Debug)]
pub struct Tags<'a> {
    rest: &'a [u8],
    form: Form,
    /// Lines or bytes read so far.
    passed: u32,
    held: Option<Tag<'a>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// Text lines; each ends with this byte.
    Ascii(u8),
    /// Group codes of one byte (up to R12) or two.
    Binary { wide: bool },
}

impl<'a> Tags<'a> {
    /// Detects the form of the file from its beginning.
    ///
    /// # Errors
    /// [`Damage::NoDxf`] if the file is neither binary DXF nor lines of text.
    pub fn new(bytes: &'a [u8]) -> Result<Self, Damage> {
        if let Some(rest) = bytes.strip_prefix(SENTINEL) {
            // The first group is (0, "SECTION"). If codes have two bytes, a second zero byte precedes the S.
            let wide = rest.get(1) == Some(&0);
            return Ok(Self { rest, form: Form::Binary { wide }, passed: 22, held: None });
        }
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let head = &bytes[..bytes.len().min(4096)];
        let end = match (head.contains(&b'\n'), head.contains(&b'\r')) {
            (true, _) => b'\n',
            (false, true) => b'\r',
            (false, false) => return Err(Damage::NoDxf),
        };
        Ok(Self { rest: bytes, form: Form::Ascii(end), passed: 0, held: None })
    }

    /// The place reached.
    #[must_use]
    pub fn place(&self) -> FilePlace {
        match self.form {
            Form::Ascii(_) => FilePlace::Line(self.passed),
            Form::Binary { .. } => FilePlace::Byte(self.passed),
        }
    }

    /// The next group; `None` at the end of the file.
    ///
    /// # Errors
    /// [`Damage`] with the place.
    pub fn next(&mut self) -> Result<Option<Tag<'a>>, Damage> {
        if let Some(tag) = self.held.take() {
            return Ok(Some(tag));
        }
        loop {
            let tag = match self.form {
                Form::Ascii(end) => self.next_ascii(end)?,
                Form::Binary { wide } => self.next_binary(wide)?,
            };
            match tag {
                Some(Tag { code: 999, .. }) => {}
                tag => return Ok(tag),
            }
        }
    }

    /// Puts a group back: `next` returns it again.
    pub fn hold(&mut self, tag: Tag<'a>) {
        self.held = Some(tag);
    }

    fn next_ascii(&mut self, end: u8) -> Result<Option<Tag<'a>>, Damage> {
        let code = loop {
            match self.line(end) {
                // Blank lines at the end of a file are not a group. Blank lines before a group are skipped.
                Some([]) => {}
                Some(line) => break line,
                None => return Ok(None),
            }
        };
        let at = self.place();
        let number = small_integer(code).ok_or_else(|| match code {
            [0x1a, ..] => Damage::EndsEarly { at, inside: "the drawing" },
            _ => Damage::Code { at, found: shortened(code) },
        })?;
        let Some(value) = self.line(end) else { return Err(Damage::EndsEarly { at, inside: "a group" }) };
        Ok(Some(Tag { code: number, value: Value::Text(value), at: self.place() }))
    }

    fn line(&mut self, end: u8) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        let (line, rest) = match memchr::memchr(end, self.rest) {
            Some(length) => (&self.rest[..length], &self.rest[length + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        self.passed = self.passed.saturating_add(1);
        Some(line.trim_ascii())
    }

    fn next_binary(&mut self, wide: bool) -> Result<Option<Tag<'a>>, Damage> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        let at = self.place();
        let code = if wide {
            i16::from_le_bytes(self.bytes()?)
        } else {
            match self.bytes::<1>()? {
                [255] => i16::from_le_bytes(self.bytes()?),
                [code] => i16::from(code),
            }
        };
        let value = match code {
            10..=59 | 110..=149 | 210..=239 | 460..=469 | 1010..=1059 => {
                Value::Real(f64::from_le_bytes(self.bytes()?))
            }
            60..=79 | 170..=179 | 270..=289 | 370..=389 | 400..=409 | 1060..=1070 => {
                Value::Integer(i16::from_le_bytes(self.bytes()?).into())
            }
            90..=99 | 420..=429 | 440..=459 | 1071 => {
                Value::Integer(i32::from_le_bytes(self.bytes()?).into())
            }
            160..=169 => Value::Integer(i64::from_le_bytes(self.bytes()?)),
            290..=299 => Value::Integer(self.bytes::<1>()?[0].into()),
            310..=319 | 1004 => {
                let length = usize::from(self.bytes::<1>()?[0]);
                Value::Text(self.take(length)?)
            }
            0..=9 | 100..=109 | 300..=369 | 390..=399 | 410..=419 | 430..=439 | 470..=481 | 999..=1009 => {
                let window = &self.rest[..self.rest.len().min(TEXT_MAX)];
                let length = memchr::memchr(0, window).ok_or(Damage::Text { at })?;
                let text = self.take(length)?;
                self.take(1)?;
                Value::Text(text.trim_ascii())
            }
            _ => return Err(Damage::Code { at, found: code.to_string() }),
        };
        Ok(Some(Tag { code, value, at }))
    }

    fn take(&mut self, length: usize) -> Result<&'a [u8], Damage> {
        let place = self.place();
        let (taken, rest) =
            self.rest.split_at_checked(length).ok_or(Damage::EndsEarly { at: place, inside: "a group" })?;
        self.rest = rest;
        self.passed = self.passed.saturating_add(u32::try_from(length).unwrap_or(u32::MAX));
        Ok(taken)
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Damage> {
        let place = self.place();
        let taken = self.take(N)?;
        taken.try_into().map_err(|_| Damage::EndsEarly { at: place, inside: "a group" })
    }
}

/// Parses a group code: up to five digits, and a minus sign if negative.
fn small_integer(text: &[u8]) -> Option<i16> {
    let (sign, digits) = match text {
        [b'-', digits @ ..] => (-1, digits),
        digits => (1, digits),
    };
    if digits.is_empty() || digits.len() > 5 {
        return None;
    }
    let value = digits.iter().try_fold(0_i32, |value, digit| {
        digit.is_ascii_digit().then(|| value * 10 + i32::from(digit - b'0'))
    })?;
    i16::try_from(sign * value).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> Result<Vec<(i16, String)>, Damage> {
        let mut tags = Tags::new(bytes)?;
        let mut found = Vec::new();
        while let Some(tag) = tags.next()? {
            let value = match tag.value {
                Value::Text(text) => String::from_utf8_lossy(text).into_owned(),
                Value::Integer(integer) => integer.to_string(),
                Value::Real(real) => real.to_string(),
            };
            found.push((tag.code, value));
        }
        Ok(found)
    }

    #[test]
    fn every_line_ending_is_read_and_comments_are_skipped() {
        let wanted = vec![(0, "LINE".to_string()), (10, "1.5".to_string())];
        for text in [
            "0\nLINE\n 10\n1.5\n",
            "0\r\nLINE\r\n10\r\n1.5",
            "0\rLINE\r10\r1.5\r",
            "999\nhello\n0\nLINE\n10\n1.5\n\n\n",
        ] {
            assert_eq!(all(text.as_bytes()).unwrap(), wanted, "{text:?}");
        }
    }

    #[test]
    fn binary_group_codes_of_both_widths_are_read() {
        let mut narrow = SENTINEL.to_vec();
        narrow.extend(b"\0LINE\0\x0a");
        narrow.extend(1.5_f64.to_le_bytes());
        narrow.extend(b"\xff\xef\x03note\0");
        assert_eq!(all(&narrow).unwrap(), [(0, "LINE".into()), (10, "1.5".into()), (1007, "note".into())]);
        let mut wide = SENTINEL.to_vec();
        wide.extend(b"\0\0LINE\0\x0a\0");
        wide.extend(1.5_f64.to_le_bytes());
        wide.extend(b"\x46\0\x05\0");
        assert_eq!(all(&wide).unwrap(), [(0, "LINE".into()), (10, "1.5".into()), (70, "5".into())]);
    }

    #[test]
    fn damage_names_the_place() {
        assert_eq!(all(b"hello"), Err(Damage::NoDxf));
        let error = all(b"0\nLINE\nten\n1.5\n").unwrap_err();
        assert_eq!(error, Damage::Code { at: FilePlace::Line(3), found: "ten".into() });
        let error = all(b"0\nLINE\n10\n").unwrap_err();
        assert_eq!(error, Damage::EndsEarly { at: FilePlace::Line(3), inside: "a group" });
        let mut cut = SENTINEL.to_vec();
        cut.extend(b"\0\0LINE\0\x0a\0\x01\x02");
        assert!(matches!(all(&cut), Err(Damage::EndsEarly { at: FilePlace::Byte(31), .. })));
    }

    // Evidence for SR-27.
    #[test]
    fn text_that_is_not_a_finite_number_is_refused() {
        for text in ["nan", "inf", "1e999", "1,5", "", "0x10"] {
            let tag = Tag { code: 40, value: Value::Text(text.as_bytes()), at: FilePlace::Line(7) };
            assert!(tag.real().unwrap_err().to_string().contains("line 7"), "{text}");
        }
        let tag = Tag { code: 70, value: Value::Text(b"4294967297000"), at: FilePlace::Line(7) };
        assert_eq!(tag.integer(), Ok(4_294_967_297_000));
    }
}

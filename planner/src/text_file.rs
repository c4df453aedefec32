//! Contents of small text files that people write: profiles, setups, descriptions, scripts.
//!
//! Implements SR-29.

use std::fmt::{self, Formatter};
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error as _, IgnoredAny, SeqAccess, Visitor};

/// Largest length of a reason, bytes.
const REASON_MAX: usize = 600;

/// Replaces control characters of a text: on a terminal they could hide other lines, or imitate them.
#[must_use]
pub fn shown(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}

/// The fault of a TOML file with its place. The reason quotes the line itself, unless that makes it too long.
#[must_use]
pub fn reason(error: &toml::de::Error) -> String {
    let shown = error.to_string();
    if shown.len() <= REASON_MAX {
        return shown;
    }
    let place = shown.lines().next().unwrap_or_default();
    format!("{place}: {}", error.message()).chars().take(REASON_MAX).collect()
}

/// Reads an array of exactly two elements. By itself, serde takes the first two of a longer array and ignores
/// the rest.
///
/// # Errors
/// The errors of the deserializer, and an error for an array of another length.
pub fn pair<'de, D: Deserializer<'de>, T: Deserialize<'de>>(source: D) -> Result<[T; 2], D::Error> {
    source.deserialize_tuple(2, Pair(PhantomData))
}

struct Pair<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Pair<T> {
    type Value = [T; 2];

    fn expecting(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.write_str("an array of two")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<[T; 2], A::Error> {
        let missing = |found| A::Error::invalid_length(found, &"an array of two");
        let first = from.next_element()?.ok_or_else(|| missing(0))?;
        let second = from.next_element()?.ok_or_else(|| missing(1))?;
        let mut found = 2;
        while from.next_element::<IgnoredAny>()?.is_some() {
            found += 1;
        }
        if found > 2 { Err(missing(found)) } else { Ok([first, second]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fuzzer found this: the reason quoted the whole of a very long line.
    #[test]
    fn long_lines_are_not_quoted() {
        let text = format!("name = 1\n\"{}\n", "x".repeat(100_000));
        let error = toml::from_str::<toml::Table>(&text).expect_err("a quotation mark is missing");
        let reason = reason(&error);
        assert!(reason.len() <= REASON_MAX && reason.contains("line 2"), "{reason}");
    }

    #[test]
    fn control_characters_are_replaced() {
        assert_eq!(shown("a\nb\u{1b}[8m"), "a\u{fffd}b\u{fffd}[8m");
    }
}

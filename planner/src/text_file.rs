//! Readers for small text files that people write: profiles, setups, descriptions, scripts.

use std::fmt::{self, Formatter};
use std::fs::File;
use std::io::{Error, ErrorKind, Read as _, Result};
use std::marker::PhantomData;
use std::path::Path;

use serde::de::{Deserialize, Deserializer, Error as _, IgnoredAny, SeqAccess, Visitor};

/// Largest size of such a file, bytes.
pub const SIZE_MAX: u64 = 1 << 20;
/// Largest length of a reason, bytes.
const REASON_MAX: usize = 600;

/// Reads a file up to `most` bytes and one more. The limit also covers a device without end, whose stated
/// length is 0.
///
/// # Errors
/// The errors of the operating system.
pub fn read_up_to(path: &Path, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Replaces control characters of a text: on a terminal they could hide other lines, or imitate them.
#[must_use]
pub fn shown(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}

/// Reads a file of at most [`SIZE_MAX`] bytes. A device without end is an error, too.
///
/// # Errors
/// The errors of the operating system, and [`ErrorKind::InvalidData`] for a larger file.
pub fn read(path: &Path) -> Result<String> {
    let mut text = String::new();
    let read = File::open(path)?.take(SIZE_MAX + 1).read_to_string(&mut text)?;
    if read as u64 > SIZE_MAX {
        let reason = format!("it has more than {SIZE_MAX} bytes, the limit for a file of this kind");
        return Err(Error::new(ErrorKind::InvalidData, reason));
    }
    Ok(text)
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
pub fn pair<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    source: D,
) -> std::result::Result<[T; 2], D::Error> {
    source.deserialize_tuple(2, Pair(PhantomData))
}

struct Pair<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Pair<T> {
    type Value = [T; 2];

    fn expecting(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.write_str("an array of two")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> std::result::Result<[T; 2], A::Error> {
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

    #[cfg(unix)]
    #[test]
    fn device_without_end_is_read_up_to_the_limit() {
        assert_eq!(read_up_to(Path::new("/dev/zero"), 1000).unwrap().len(), 1001);
        assert_eq!(shown("a\nb\u{1b}[8m"), "a\u{fffd}b\u{fffd}[8m");
    }

    #[test]
    fn files_above_the_size_limit_are_refused() {
        let folder = std::env::temp_dir().join(format!("keepout-text-{}", std::process::id()));
        std::fs::write(&folder, vec![b' '; (1 << 20) + 1]).unwrap();
        assert_eq!(read(&folder).unwrap_err().kind(), ErrorKind::InvalidData);
        std::fs::write(&folder, vec![b' '; 1 << 20]).unwrap();
        assert_eq!(read(&folder).unwrap().len(), 1 << 20);
        std::fs::remove_file(&folder).unwrap();
    }
}

//! Small text files that people write: profiles, setups, descriptions, scripts.

use std::fmt::{self, Formatter};
use std::fs::File;
use std::io::{Error, ErrorKind, Read as _, Result};
use std::marker::PhantomData;
use std::path::Path;

use serde::de::{Deserialize, Deserializer, Error as _, IgnoredAny, SeqAccess, Visitor};

/// Most bytes that are read of such a file.
pub const SIZE_MAX: u64 = 1 << 20;
/// Most letters of a reason.
const REASON_MAX: usize = 600;

/// Reads a file up to `most` bytes and one more: a device that never ends has a length of nothing.
///
/// # Errors
/// The system's.
pub fn read_up_to(path: &Path, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Text with what a terminal would not show replaced: it could hide other lines, or look like them.
#[must_use]
pub fn shown(text: &str) -> String {
    text.replace(char::is_control, "\u{fffd}")
}

/// Reads a file of at most [`SIZE_MAX`] bytes: a device that never ends is none.
///
/// # Errors
/// The system's, and one for a file that is larger.
pub fn read(path: &Path) -> Result<String> {
    let mut text = String::new();
    let read = File::open(path)?.take(SIZE_MAX + 1).read_to_string(&mut text)?;
    if read as u64 > SIZE_MAX {
        let reason = format!("it has more than {SIZE_MAX} bytes, as no file of this kind has");
        return Err(Error::new(ErrorKind::InvalidData, reason));
    }
    Ok(text)
}

/// What is wrong with a TOML file, and where. The line itself is shown when it is of a line's length.
#[must_use]
pub fn reason(error: &toml::de::Error) -> String {
    let shown = error.to_string();
    if shown.len() <= REASON_MAX {
        return shown;
    }
    let place = shown.lines().next().unwrap_or_default();
    format!("{place}: {}", error.message()).chars().take(REASON_MAX).collect()
}

/// An array of two, and of no more: serde by itself takes the first two of a longer one and leaves the rest.
///
/// # Errors
/// The deserializer's, and one for an array of another length.
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

    /// Found by the fuzzer: a file of one long line was shown whole.
    #[test]
    fn long_lines_are_not_shown() {
        let text = format!("name = 1\n\"{}\n", "x".repeat(100_000));
        let error = toml::from_str::<toml::Table>(&text).expect_err("a quotation mark is missing");
        let reason = reason(&error);
        assert!(reason.len() <= REASON_MAX && reason.contains("line 2"), "{reason}");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_read_up_to_a_bound() {
        assert_eq!(read_up_to(Path::new("/dev/zero"), 1000).unwrap().len(), 1001);
        assert_eq!(shown("a\nb\u{1b}[8m"), "a\u{fffd}b\u{fffd}[8m");
    }

    #[test]
    fn files_without_end_are_refused() {
        let folder = std::env::temp_dir().join(format!("keepout-text-{}", std::process::id()));
        std::fs::write(&folder, vec![b' '; (1 << 20) + 1]).unwrap();
        assert_eq!(read(&folder).unwrap_err().kind(), ErrorKind::InvalidData);
        std::fs::write(&folder, vec![b' '; 1 << 20]).unwrap();
        assert_eq!(read(&folder).unwrap().len(), 1 << 20);
        std::fs::remove_file(&folder).unwrap();
    }
}

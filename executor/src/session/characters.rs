//! Bytes of a serial line in JSON: each byte is the character with the same number.

use std::fmt::{self, Display, Formatter, Write as _};

use serde::de::Error as _;
use serde::{Deserialize as _, Deserializer, Serializer};

struct Characters<'a>(&'a [u8]);

impl Display for Characters<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|&byte| f.write_char(char::from(byte)))
    }
}

/// Writes bytes as a string.
///
/// # Errors
/// The serializer's.
pub fn serialize<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&Characters(bytes))
}

/// Reads bytes from a string.
///
/// # Errors
/// The deserializer's, and an error for a character above 255.
pub fn deserialize<'de, T: From<Vec<u8>>, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    let text = String::deserialize(deserializer)?;
    let bytes = text.chars().map(|character| u8::try_from(u32::from(character)).map_err(D::Error::custom));
    bytes.collect::<Result<Vec<u8>, _>>().map(T::from)
}

//! The lines of a log. Each is a JSON object that begins with a checksum over the line before and the rest of
//! this line.
//!
//! Implements SR-23.

use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// An error in the content of an intact line.
#[derive(Debug, Error)]
pub enum LineError {
    /// The line has a wrong form.
    #[error("it has a wrong form: {0}")]
    Form(#[from] serde_json::Error),
    /// The line is earlier than the line before it.
    #[error("its time is earlier than the time of the line before")]
    Backwards,
}

/// The beginning of a line, and the count of checksum digits after it.
const BEGINS: &str = "{\"crc\":\"";
const DIGITS: usize = 8;
/// The text after the digits.
const FOLLOWS: &str = "\",";

/// The checksum of a line: CRC-32 over the checksum of the line before and the rest of this line.
fn checksum(before: u32, rest: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&before.to_le_bytes());
    hasher.update(rest);
    hasher.finalize()
}

/// Writes a line without its line end into `line`, and returns its checksum. The content must be a struct
/// with fields.
///
/// # Errors
/// The serializer's.
pub(super) fn write(line: &mut Vec<u8>, before: u32, content: &impl Serialize) -> serde_json::Result<u32> {
    line.clear();
    line.extend(BEGINS.bytes());
    line.extend([b'0'; DIGITS]);
    line.extend(FOLLOWS.bytes());
    let begins = line.len();
    serde_json::to_writer(&mut *line, content)?;
    // The line begins with a brace already.
    line.remove(begins);
    let sum = checksum(before, &line[begins..]);
    line[BEGINS.len()..BEGINS.len() + DIGITS].copy_from_slice(format!("{sum:08x}").as_bytes());
    Ok(sum)
}

/// The checksum of a line without its line end, if it equals the checksum that the line states.
pub(super) fn verified(line: &[u8], before: u32) -> Option<u32> {
    let stated = line.strip_prefix(BEGINS.as_bytes())?;
    let (digits, rest) = stated.split_at_checked(DIGITS)?;
    // The comparison is by characters: a capital letter or a sign is a changed line, too.
    let sum = checksum(before, rest.strip_prefix(FOLLOWS.as_bytes())?);
    (format!("{sum:08x}").as_bytes() == digits).then_some(sum)
}

/// The content of a line. The call overwrites one byte of the line.
///
/// # Errors
/// [`LineError::Form`] if the content has a wrong form.
pub(super) fn read<T: DeserializeOwned>(line: &mut [u8]) -> Result<T, LineError> {
    let begins = BEGINS.len() + DIGITS + FOLLOWS.len() - 1;
    let content = line.get_mut(begins..).unwrap_or_default();
    if let Some(comma) = content.first_mut() {
        *comma = b'{';
    }
    Ok(serde_json::from_slice(content)?)
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Content {
        at: u64,
        share: f64,
    }

    // Evidence for SR-23.
    #[test]
    fn changed_line_fails_its_checksum() {
        let mut line = Vec::new();
        let content = Content { at: 17, share: -0.1 };
        let sum = write(&mut line, 5, &content).unwrap();
        assert_eq!(line, format!("{{\"crc\":\"{sum:08x}\",\"at\":17,\"share\":-0.1}}").as_bytes());
        assert_eq!(verified(&line, 5), Some(sum));
        assert_eq!(verified(&line, 6), None, "after another line");
        for at in 0..line.len() {
            for bit in 0..8 {
                let mut changed = line.clone();
                changed[at] ^= 1 << bit;
                assert_eq!(verified(&changed, 5), None, "bit {bit} of byte {at}");
            }
        }
        assert_eq!(read::<Content>(&mut line).unwrap(), content);
    }

    #[test]
    fn numbers_are_read_back_bit_for_bit() {
        let mut random = fastrand::Rng::with_seed(5);
        let mut line = Vec::new();
        for _ in 0..50_000 {
            let share = f64::from_bits(random.u64(..));
            let content = Content { at: random.u64(..), share: if share.is_finite() { share } else { -0.0 } };
            write(&mut line, 0, &content).unwrap();
            let read: Content = read(&mut line).unwrap();
            assert_eq!((read.at, read.share.to_bits()), (content.at, content.share.to_bits()));
        }
    }
}

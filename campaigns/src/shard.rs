//! One shard of a campaign.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// Shard I of N, with I from 1 to N. It takes the items 0, 1, 2 … of a campaign in turn: item `k` belongs to the
/// shard `k mod N + 1`. So the shards share no item, and all of them together have every item.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Shard {
    index: u32,
    of: u32,
}

/// Reason why a text names no shard.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ShardError {
    /// The text is not two numbers with a slash between.
    #[error("\"{0}\" is not a shard. Write I/N, such as 1/4 for the first of four shards")]
    Form(String),
    /// The first number is not from 1 to the second.
    #[error("shard {index} of {of} does not exist. Count the shards from 1 to {of}: 1/{of} is the first")]
    Range {
        /// The first number.
        index: u32,
        /// The second number, at least 1.
        of: u32,
    },
    /// The number of shards is 0.
    #[error("\"{0}\" has no shards. Write 1/1 for a run that is not divided")]
    Empty(String),
}

impl Shard {
    /// The only shard of a run that is not divided.
    pub const WHOLE: Self = Self { index: 1, of: 1 };

    /// All shards of a campaign with so many.
    pub fn all(of: u32) -> impl Iterator<Item = Self> {
        (1..=of).map(move |index| Self { index, of })
    }

    /// Its number, from 1 on.
    #[must_use]
    pub fn index(self) -> u32 {
        self.index
    }

    /// The number of shards.
    #[must_use]
    pub fn of(self) -> u32 {
        self.of
    }

    /// Whether the item with this number, from 0 on, belongs to the shard.
    #[must_use]
    pub fn takes(self, number: u64) -> bool {
        number % u64::from(self.of) == u64::from(self.index - 1)
    }

    /// The numbers of its items, in order and without end.
    pub fn numbers(self) -> impl Iterator<Item = u64> {
        (0..).map(move |turn: u64| self.number(turn))
    }

    /// The number of its item with this place among its own, from 0 on.
    #[must_use]
    pub fn number(self, turn: u64) -> u64 {
        turn.saturating_mul(u64::from(self.of)).saturating_add(u64::from(self.index - 1))
    }

    /// Its items among these.
    pub fn part<T>(self, items: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
        (0..).zip(items).filter_map(move |(number, item)| self.takes(number).then_some(item))
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let number = |part: &str| part.bytes().all(|b| b.is_ascii_digit()).then(|| part.parse().ok())?;
        let numbers = text.split_once('/').and_then(|(index, of)| Some((number(index)?, number(of)?)));
        match numbers {
            None => Err(ShardError::Form(text.into())),
            Some((_, 0)) => Err(ShardError::Empty(text.into())),
            Some((index, of)) if index == 0 || index > of => Err(ShardError::Range { index, of }),
            Some((index, of)) => Ok(Self { index, of }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_no_item_and_have_all() {
        for of in [1, 2, 3, 7, 64] {
            let mut items: Vec<u64> = Shard::all(of).flat_map(|shard| shard.part(0..100)).collect();
            items.sort_unstable();
            assert_eq!(items, (0..100).collect::<Vec<_>>(), "{of} shards");
            for shard in Shard::all(of) {
                assert!(shard.numbers().take(100).all(|number| shard.takes(number)), "{shard}");
                let first = shard.numbers().take_while(|&number| number < 100);
                assert_eq!(first.collect::<Vec<_>>(), shard.part(0..100).collect::<Vec<_>>(), "{shard}");
            }
        }
    }

    #[test]
    fn text_is_read_and_written() {
        for text in ["1/1", "1/4", "4/4", "17/4294967295"] {
            assert_eq!(text.parse::<Shard>().map(|shard| shard.to_string()).as_deref(), Ok(text));
        }
        assert_eq!("1/1".parse(), Ok(Shard::WHOLE));
    }

    #[test]
    fn texts_that_name_no_shard_are_refused_with_a_remedy() {
        let error = |text: &str| text.parse::<Shard>().unwrap_err().to_string();
        for text in ["", "1", "/", "1/", "/4", "1/4/4", "a/4", "-1/4", "+1/4", "1 /4", "1/4294967296"] {
            assert!(error(text).ends_with("Write I/N, such as 1/4 for the first of four shards"), "{text}");
        }
        assert_eq!(
            error("0/4"),
            "shard 0 of 4 does not exist. Count the shards from 1 to 4: 1/4 is the first"
        );
        assert!(error("5/4").starts_with("shard 5 of 4 does not exist"));
        assert_eq!(error("0/0"), "\"0/0\" has no shards. Write 1/1 for a run that is not divided");
    }
}

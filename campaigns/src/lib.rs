//! Shards of long runs, their result files, and the merge of these files.
//!
//! A campaign is a run of one program with stated arguments. Shard I of N plays a fixed part of it. No two shards
//! share a part, and all shards together play the campaign. A scheduler that exists distributes the shards:
//! `docs/contributor/campaigns.md` shows three. Each shard writes a file, and the program `merge` adds the files up.
//!
//! ```
//! use keepout_campaigns::Shard;
//!
//! let shard: Shard = "2/3".parse()?;
//! assert_eq!(shard.numbers().take(3).collect::<Vec<_>>(), [1, 4, 7]);
//! # Ok::<(), keepout_campaigns::ShardError>(())
//! ```

mod merge;
mod options;
mod results;
mod seed;
mod shard;

pub use merge::{MergeError, merge, table};
pub use options::{BeginError, ShardOptions, ShardRecord};
pub use results::{Campaign, ItemOutcome, ItemRow, ResultsError, ShardResults};
pub use seed::{mix, numbered};
pub use shard::{Shard, ShardError};

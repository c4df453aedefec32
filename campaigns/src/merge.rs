//! The results of all shards of a campaign as one.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::{Campaign, ItemOutcome, Shard, ShardResults};

/// Reason why results are not one campaign.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MergeError {
    /// There are no results.
    #[error("there is no results file to merge. Name the files that --results wrote")]
    Nothing,
    /// Two files belong to different campaigns.
    #[error(
        "{} and {} are not of one campaign: the {what} is \"{one}\" and \"{another}\". Merge each campaign by itself",
        .files[0].display(),
        .files[1].display()
    )]
    Foreign {
        /// The two files.
        files: Box<[PathBuf; 2]>,
        /// What differs.
        what: &'static str,
        /// Its value in the first file.
        one: String,
        /// Its value in the second file.
        another: String,
    },
    /// Two files have the same shard.
    #[error("{} and {} both hold shard {shard}. Name one of them", .files[0].display(), .files[1].display())]
    Doubled {
        /// The two files.
        files: Box<[PathBuf; 2]>,
        /// The shard.
        shard: Shard,
    },
    /// Shards have no file.
    #[error("there is no file for {}. Run `{command} --shard {}`, and merge again", shards(.missing), .missing[0])]
    Missing {
        /// These shards, in order.
        missing: Vec<Shard>,
        /// Program and arguments of the campaign.
        command: String,
    },
}

/// Some shards in words. The first ten stand for any number of them.
fn shards(shards: &[Shard]) -> String {
    let names: Vec<_> = shards.iter().take(10).map(ToString::to_string).collect();
    let more = shards.len() - names.len();
    let word = if shards.len() == 1 { "shard" } else { "shards" };
    let end = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{word} {}{end}", names.join(", "))
}

/// Merges the results of all shards of a campaign, each with its file. The rows of the merged results are in order,
/// and failed items come first.
///
/// # Errors
/// [`MergeError`], if the files belong to different campaigns, or do not hold every shard once.
pub fn merge(files: &[(PathBuf, ShardResults)]) -> Result<ShardResults, MergeError> {
    let Some((first, one)) = files.first() else { return Err(MergeError::Nothing) };
    let mut merged =
        ShardResults { shard: Shard::WHOLE, totals: BTreeMap::new(), rows: Vec::new(), ..one.clone() };
    let mut seen: BTreeMap<Shard, &Path> = BTreeMap::new();
    for (path, results) in files {
        if let Some((what, one, another)) = difference(one, results) {
            let files = Box::new([first.clone(), path.clone()]);
            return Err(MergeError::Foreign { files, what, one, another });
        }
        if let Some(before) = seen.insert(results.shard, path) {
            let files = Box::new([before.to_path_buf(), path.clone()]);
            return Err(MergeError::Doubled { files, shard: results.shard });
        }
        results.totals.iter().for_each(|(name, count)| merged.add(name, *count));
        merged.rows.extend(results.rows.iter().cloned());
    }
    // The number of shards comes from a file. So a large one costs no memory here.
    let missing = Shard::all(one.shard.of()).filter(|shard| !seen.contains_key(shard));
    let missing: Vec<_> = missing.take(1000).collect();
    if !missing.is_empty() {
        let command = format!("{} {}", one.campaign.program, one.campaign.arguments);
        return Err(MergeError::Missing { missing, command });
    }
    merged.rows.sort();
    Ok(merged)
}

/// The first difference between the campaigns of two files: its name, and both values.
fn difference(one: &ShardResults, another: &ShardResults) -> Option<(&'static str, String, String)> {
    let fields = |results: &ShardResults| {
        let Campaign { program, revision, arguments, data } = results.campaign.clone();
        let shards = results.shard.of().to_string();
        [
            ("program", program),
            ("revision", revision),
            ("list of arguments", arguments),
            ("outside data", data),
            ("number of shards", shards),
        ]
    };
    let mut pairs = fields(one).into_iter().zip(fields(another));
    pairs.find_map(|((what, one), (_, another))| (one != another).then_some((what, one, another)))
}

/// The results as a table for a person: the campaign, the totals, and the items that failed.
#[must_use]
pub fn table(results: &ShardResults) -> String {
    let Campaign { program, revision, arguments, data } = &results.campaign;
    let mut text = format!("{program} {arguments}\nrevision {revision}");
    if !data.is_empty() {
        let _ = write!(text, ", {data}");
    }
    text.push('\n');
    let mut row = |count: &dyn std::fmt::Display, name: &str| {
        let _ = writeln!(text, "{count:>20}  {name}");
    };
    for (name, count) in &results.totals {
        row(count, name);
    }
    let failed: Vec<_> = results.rows.iter().filter(|row| row.outcome == ItemOutcome::Failed).collect();
    let held = results.rows.len() - failed.len();
    if held > 0 {
        row(&held, "items that hold");
    }
    row(&failed.len(), "items that failed");
    // Two rows of one item, such as a fault under two engines, may have one command.
    let mut shown = BTreeSet::new();
    for row in failed {
        let _ = writeln!(text, "failed: {}: {}", row.item, row.detail);
        if shown.insert(&row.again) {
            let _ = writeln!(text, "  again: {}", row.again);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ItemRow;

    fn part(shard: Shard, rows: Vec<ItemRow>) -> (PathBuf, ShardResults) {
        let campaign = Campaign {
            program: "hostile".into(),
            revision: "476b5c9".into(),
            arguments: "--seed 1".into(),
            data: "16 real drawings".into(),
        };
        let totals = [("sessions".into(), u64::from(shard.index())), ("fingerprint".into(), u64::MAX)].into();
        (format!("{}.tsv", shard.index()).into(), ShardResults { campaign, shard, totals, rows })
    }

    fn parts(of: u32) -> Vec<(PathBuf, ShardResults)> {
        Shard::all(of).map(|shard| part(shard, Vec::new())).collect()
    }

    #[test]
    fn totals_add_up_in_any_order_of_the_files() {
        let mut files = parts(3);
        files.reverse();
        let merged = merge(&files).unwrap();
        assert_eq!(merged.totals, [("sessions".into(), 6), ("fingerprint".into(), u64::MAX - 2)].into());
        assert_eq!(merged.shard, Shard::WHOLE);
        assert!(!merged.has_failed());
    }

    #[test]
    fn failed_items_come_first_with_the_command_that_runs_them_again() {
        let row = |outcome, item: &str| ItemRow {
            outcome,
            item: item.into(),
            detail: "a gouge".into(),
            again: format!("hostile --replay {item}"),
        };
        let rows = vec![row(ItemOutcome::Held, "1:1"), row(ItemOutcome::Failed, "2:2")];
        let merged = merge(&[part(Shard::WHOLE, rows)]).unwrap();
        assert!(merged.has_failed());
        assert_eq!(merged.rows[0].item, "2:2");
        let table = table(&merged);
        assert!(table.starts_with("hostile --seed 1\nrevision 476b5c9, 16 real drawings\n"), "{table}");
        assert!(table.ends_with("failed: 2:2: a gouge\n  again: hostile --replay 2:2\n"), "{table}");
    }

    #[test]
    fn missing_shards_are_named_with_a_command() {
        let mut files = parts(4);
        files.remove(1);
        let error = merge(&files).unwrap_err().to_string();
        assert_eq!(
            error,
            "there is no file for shard 2/4. Run `hostile --seed 1 --shard 2/4`, and merge again"
        );
        let error = merge(&files[..1]).unwrap_err().to_string();
        assert!(error.starts_with("there is no file for shards 2/4, 3/4, 4/4. "), "{error}");
        let error = merge(&[part("7/4000000000".parse().unwrap(), Vec::new())]).unwrap_err().to_string();
        assert!(error.contains("10/4000000000") || error.contains("more"), "{error}");
        assert_eq!(merge(&[]), Err(MergeError::Nothing));
    }

    #[test]
    fn doubled_shards_are_named_with_both_files() {
        let mut files = parts(3);
        files[2].1.shard = files[0].1.shard;
        let error = merge(&files).unwrap_err().to_string();
        assert_eq!(error, "1.tsv and 3.tsv both hold shard 1/3. Name one of them");
    }

    #[test]
    fn files_of_other_campaigns_are_named_with_the_difference() {
        let error = |change: fn(&mut ShardResults)| {
            let mut files = parts(2);
            change(&mut files[1].1);
            merge(&files).unwrap_err().to_string()
        };
        for (change, text) in [
            (
                (|results| results.campaign.program = "soak".into()) as fn(&mut ShardResults),
                "the program is \"hostile\" and \"soak\"",
            ),
            (
                |results| results.campaign.revision = "1fdd799".into(),
                "the revision is \"476b5c9\" and \"1fdd799\"",
            ),
            (
                |results| results.campaign.arguments = "--seed 2".into(),
                "the list of arguments is \"--seed 1\" and \"--seed 2\"",
            ),
            (
                |results| results.campaign.data = "0 real drawings".into(),
                "the outside data is \"16 real drawings\" and \"0 real drawings\"",
            ),
            (|results| results.shard = "2/3".parse().unwrap(), "the number of shards is \"2\" and \"3\""),
        ] {
            let error = error(change);
            assert!(error.starts_with("1.tsv and 2.tsv are not of one campaign: "), "{error}");
            assert!(error.contains(text) && error.ends_with("Merge each campaign by itself"), "{error}");
        }
    }
}

//! The results file of a shard: lines of fields with tabs between, and a checksum at the end.
//!
//! | line | fields |
//! |---|---|
//! | `keepout campaign` | the number of this format |
//! | `program`, `revision`, `arguments`, `data` | what was run, see [`Campaign`] |
//! | `shard` | I/N |
//! | `total` | name, number; any count of lines |
//! | `held`, `failed` | item, detail, the command that runs the item again; any count of lines |
//! | `sha256` | of all bytes before this line, in hexadecimal digits |
//!
//! `fuzz/run` writes the same format.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use keepout_planner::file::{FileError, FileKind};
use keepout_planner::sha256::{hash, hex};
use thiserror::Error;

use crate::Shard;

/// The results of a shard as a file.
static RESULTS: FileKind = FileKind::new("results file");
/// Largest size of a results file, bytes.
const SIZE_MAX: u64 = 256 << 20;
/// First field of the file.
const TITLE: &str = "keepout campaign";
/// Number of the format.
const FORMAT: &str = "1";
const CHECKSUM: &str = "sha256";

/// What the shards of a campaign have in common.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Campaign {
    /// Name of the program.
    pub program: String,
    /// Revision of the repository.
    pub revision: String,
    /// Arguments of the program, without those that belong to one shard or one machine.
    pub arguments: String,
    /// Data from outside of the repository that the run depends on, in words.
    pub data: String,
}

/// Whether an item holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ItemOutcome {
    /// It does not hold.
    Failed,
    /// It holds.
    Held,
}

/// The outcome of one item: a session, a world, a fault or a fuzz target.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ItemRow {
    /// Whether it holds.
    pub outcome: ItemOutcome,
    /// Its name or its seeds.
    pub item: String,
    /// The program's findings.
    pub detail: String,
    /// The command that runs the item again.
    pub again: String,
}

/// The results of a shard, or of a merged campaign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShardResults {
    /// The campaign.
    pub campaign: Campaign,
    /// The shard. A merged campaign is [`Shard::WHOLE`].
    pub shard: Shard,
    /// Named sums over the shard. They add up over the shards, modulo 2⁶⁴.
    pub totals: BTreeMap<String, u64>,
    /// Items by themselves. A campaign of many items has rows only for those that failed.
    pub rows: Vec<ItemRow>,
}

/// Reason why a results file cannot be used.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// It cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// It is no results file of this format.
    #[error("{}, line {line}: this is not {expected}. Name a file that --results wrote", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1 on.
        line: usize,
        /// What belongs there.
        expected: &'static str,
    },
    /// Its bytes do not have its checksum.
    #[error("{}: the file is damaged or cut off, its checksum is wrong. Copy it or run its shard again", .0.display())]
    Checksum(PathBuf),
}

impl ItemOutcome {
    fn name(self) -> &'static str {
        match self {
            Self::Failed => "failed",
            Self::Held => "held",
        }
    }
}

impl ShardResults {
    /// Whether an item failed.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.rows.iter().any(|row| row.outcome == ItemOutcome::Failed)
    }

    /// Adds to a total.
    pub fn add(&mut self, total: &str, count: u64) {
        let sum = self.totals.entry(total.into()).or_default();
        *sum = sum.wrapping_add(count);
    }

    /// The text of the file. In a field, one space stands for tabs and line ends.
    #[must_use]
    pub fn text(&self) -> String {
        let Campaign { program, revision, arguments, data } = &self.campaign;
        let mut text = String::new();
        let mut line = |fields: &[&str]| {
            let fields: Vec<_> = fields.iter().map(|field| plain(field)).collect();
            let _ = writeln!(text, "{}", fields.join("\t"));
        };
        line(&[TITLE, FORMAT]);
        line(&["program", program]);
        line(&["revision", revision]);
        line(&["arguments", arguments]);
        line(&["data", data]);
        line(&["shard", &self.shard.to_string()]);
        for (name, count) in &self.totals {
            line(&["total", name, &count.to_string()]);
        }
        for ItemRow { outcome, item, detail, again } in &self.rows {
            line(&[outcome.name(), item, detail, again]);
        }
        let checksum = hex(&hash(text.as_bytes()));
        let _ = writeln!(text, "{CHECKSUM}\t{checksum}");
        text
    }

    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// [`ResultsError::File`].
    pub fn write(&self, path: &Path) -> Result<(), ResultsError> {
        Ok(RESULTS.write(path, self.text().as_bytes())?)
    }

    /// Reads a file of at most 256 MiB.
    ///
    /// # Errors
    /// [`ResultsError`].
    pub fn read(path: &Path) -> Result<Self, ResultsError> {
        let bytes = RESULTS.read(path, SIZE_MAX)?;
        let form = |(line, expected)| ResultsError::Form { path: path.into(), line, expected };
        if !bytes.starts_with(TITLE.as_bytes()) {
            return Err(form((1, "the title of a results file")));
        }
        let damaged = || ResultsError::Checksum(path.into());
        let text = String::from_utf8(bytes).map_err(|_| damaged())?;
        let (text, checksum) = text.rsplit_once(&format!("{CHECKSUM}\t")).ok_or_else(damaged)?;
        if checksum.strip_suffix('\n') != Some(&hex(&hash(text.as_bytes()))) {
            return Err(damaged());
        }
        Self::of_lines(text).map_err(form)
    }

    /// The results from the lines above the checksum. The error is the number of a line, and what belongs there.
    fn of_lines(text: &str) -> Result<Self, (usize, &'static str)> {
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split('\t').collect()).collect();
        let head = |number: usize, name: &str, expected: &'static str| match lines
            .get(number - 1)
            .map(Vec::as_slice)
        {
            Some([field, value]) if *field == name => Ok((*value).to_string()),
            _ => Err((number, expected)),
        };
        if head(1, TITLE, "the title of a results file")? != FORMAT {
            return Err((1, "the format that this program reads"));
        }
        let campaign = Campaign {
            program: head(2, "program", "the program's name")?,
            revision: head(3, "revision", "the revision")?,
            arguments: head(4, "arguments", "the arguments")?,
            data: head(5, "data", "the data of the run")?,
        };
        let shard = head(6, "shard", "the shard")?.parse().map_err(|_| (6, "a shard I/N"))?;
        let mut results = Self { campaign, shard, totals: BTreeMap::new(), rows: Vec::new() };
        for (number, fields) in (1..).zip(&lines).skip(6) {
            match fields.as_slice() {
                ["total", name, count] => {
                    results.add(name, count.parse().map_err(|_| (number, "a total with a whole number"))?);
                }
                [outcome @ ("held" | "failed"), item, detail, again] => results.rows.push(ItemRow {
                    outcome: if *outcome == "held" { ItemOutcome::Held } else { ItemOutcome::Failed },
                    item: (*item).into(),
                    detail: (*detail).into(),
                    again: (*again).into(),
                }),
                _ => return Err((number, "a total or an item")),
            }
        }
        Ok(results)
    }
}

/// The text in one field of one line.
fn plain(text: &str) -> String {
    text.split(['\t', '\r', '\n'])
        .map(str::trim_end)
        .filter(|part| !part.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn results() -> ShardResults {
        let campaign = Campaign {
            program: "hostile".into(),
            revision: "476b5c9".into(),
            arguments: "--seed 1".into(),
            data: String::new(),
        };
        let row = |outcome, item: &str| ItemRow {
            outcome,
            item: item.into(),
            detail: "two\n\tlines".into(),
            again: "hostile --seed 1 --replay 3:4".into(),
        };
        let rows = vec![row(ItemOutcome::Held, "1:2"), row(ItemOutcome::Failed, "3:4")];
        ShardResults { campaign, shard: Shard::WHOLE, totals: [("sessions".into(), u64::MAX)].into(), rows }
    }

    fn path(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("keepout-results-{}-{name}", std::process::id()))
    }

    #[test]
    fn file_holds_the_results() {
        let (path, mut results) = (path("same"), results());
        results.write(&path).unwrap();
        let read = ShardResults::read(&path).unwrap();
        results.rows.iter_mut().for_each(|row| row.detail = "two lines".into());
        assert_eq!(read, results);
        assert!(read.has_failed());
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn every_file_that_is_cut_off_or_changed_is_refused() {
        let (path, text) = (path("damaged"), results().text());
        for end in 0..text.len() {
            std::fs::write(&path, &text[..end]).unwrap();
            let error = ShardResults::read(&path).unwrap_err().to_string();
            assert!(error.contains("damaged") || error.contains("line 1"), "{end}: {error}");
        }
        for place in 0..text.len() {
            let mut bytes = text.clone().into_bytes();
            bytes[place] ^= 1;
            std::fs::write(&path, bytes).unwrap();
            ShardResults::read(&path).unwrap_err();
        }
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn files_of_another_form_are_refused_with_the_line() {
        let path = path("form");
        let error = |find: &str, with: &str| {
            let text = results().text();
            let body = text.split("sha256").next().unwrap().replacen(find, with, 1);
            std::fs::write(&path, format!("{body}sha256\t{}\n", hex(&hash(body.as_bytes())))).unwrap();
            ShardResults::read(&path).unwrap_err().to_string()
        };
        assert!(error("campaign\t1", "campaign\t2").contains("line 1: this is not the format"));
        assert!(error("revision", "version").contains("line 3: this is not the revision"));
        assert!(error("1/1", "2/1").contains("line 6: this is not a shard"));
        assert!(error("18446744073709551615", "-1").contains("line 7: this is not a total"));
        assert!(error("held", "unknown").contains("line 8: this is not a total or an item"));
        std::fs::write(&path, "keepout").unwrap();
        let error = ShardResults::read(&path).unwrap_err().to_string();
        assert!(error.contains("line 1: this is not the title of a results file"), "{error}");
        std::fs::remove_file(&path).unwrap();
        assert!(
            ShardResults::read(&path).unwrap_err().to_string().starts_with("cannot read the results file")
        );
    }
}

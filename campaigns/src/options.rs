//! The options that every program of a campaign has, and the results that it writes.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{fs, io};

use thiserror::Error;

use crate::{Campaign, ItemOutcome, ItemRow, ResultsError, Shard, ShardResults};

/// The shard of a campaign that a program plays, and the file for its results.
#[derive(Clone, Debug, clap::Args)]
pub struct ShardOptions {
    /// Play only this shard of the campaign: I/N, with I from 1 to N.
    #[arg(long, value_name = "I/N", default_value_t = Shard::WHOLE)]
    pub shard: Shard,
    /// Write the results of the shard to this file, for the program `merge`.
    #[arg(long, value_name = "FILE")]
    pub results: Option<PathBuf>,
    /// Revision in the results. The default is the description by `git`.
    #[arg(long, value_name = "TEXT", requires = "results")]
    pub revision: Option<String>,
}

/// Options that belong to one shard or one machine, and not to the campaign. Each has a value.
const LOCAL: [&str; 4] = ["--shard", "--results", "--revision", "--threads"];

/// Reason why the results of a shard cannot begin.
#[derive(Debug, Error)]
pub enum BeginError {
    /// Nobody states the revision.
    #[error("git does not describe the revision of {}. State it: --revision TEXT", .0.display())]
    Revision(PathBuf),
    /// No file can be written at the place of the results.
    #[error("cannot write the results to {}: {error}. Choose another place with --results", path.display())]
    Place {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        error: io::Error,
    },
}

impl ShardOptions {
    /// Begins the results of this process. `data` names data from outside of the repository that the run depends
    /// on. `local` are further arguments that belong to this machine. An old results file at the place is removed,
    /// so that a run which does not end leaves none.
    ///
    /// # Errors
    /// [`BeginError`], with `--results` only.
    pub fn begin(&self, program: &str, data: String, local: &[&OsStr]) -> Result<ShardRecord, BeginError> {
        let revision = match &self.results {
            Some(path) => {
                make_room(path).map_err(|error| BeginError::Place { path: path.clone(), error })?;
                self.revision()?
            }
            None => String::new(),
        };
        let arguments = std::env::args_os().skip(1).filter(|argument| !local.contains(&argument.as_os_str()));
        let arguments = defining(arguments.map(|argument| argument.to_string_lossy().into_owned()));
        let campaign = Campaign { program: program.into(), revision, arguments, data };
        let results = ShardResults { campaign, shard: self.shard, totals: [].into(), rows: Vec::new() };
        Ok(ShardRecord { path: self.results.clone(), results })
    }

    fn revision(&self) -> Result<String, BeginError> {
        if let Some(revision) = &self.revision {
            return Ok(revision.clone());
        }
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut git = Command::new("git");
        git.arg("-C").arg(folder).args(["describe", "--always", "--dirty", "--exclude=*"]);
        let described = git.output().ok().filter(|ran| ran.status.success());
        let text = described.map(|ran| String::from_utf8_lossy(&ran.stdout).trim().to_string());
        text.filter(|text| !text.is_empty()).ok_or_else(|| BeginError::Revision(folder.into()))
    }
}

/// Removes an old file, and makes its folder. Checks that a file can be written there.
fn make_room(path: &Path) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    fs::File::options().append(true).create(true).open(path)?;
    fs::remove_file(path)
}

/// The arguments without the local ones, as a shell reads them.
fn defining(arguments: impl Iterator<Item = String>) -> String {
    let mut kept = Vec::new();
    let mut is_value = false;
    for argument in arguments {
        let name = argument.split_once('=').map_or(argument.as_str(), |(name, _)| name);
        let is_local = LOCAL.contains(&name);
        if !is_value && !is_local {
            kept.push(quoted(&argument));
        }
        is_value = !is_value && is_local && name == argument;
    }
    kept.join(" ")
}

fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./:=,+@%".contains(c);
    if !argument.is_empty() && argument.chars().all(is_plain) {
        return argument.into();
    }
    format!("'{}'", argument.replace('\'', r"'\''"))
}

/// The results of a shard while it runs.
#[derive(Debug)]
pub struct ShardRecord {
    path: Option<PathBuf>,
    results: ShardResults,
}

impl ShardRecord {
    /// Adds to a total.
    pub fn total(&mut self, name: &str, count: u64) {
        self.results.add(name, count);
    }

    /// Adds a row. `again` are the arguments with which the program runs the item again.
    pub fn row(&mut self, outcome: ItemOutcome, item: &str, detail: &str, again: &str) {
        let again = format!("{} {again}", self.results.campaign.program);
        let row = ItemRow { outcome, item: item.into(), detail: detail.into(), again };
        self.results.rows.push(row);
    }

    /// The arguments of the campaign, for the arguments of [`row`](Self::row).
    #[must_use]
    pub fn arguments(&self) -> &str {
        &self.results.campaign.arguments
    }

    /// Writes the file, if there is one to write. Returns whether every item holds.
    ///
    /// # Errors
    /// [`ResultsError::File`].
    pub fn finish(self) -> Result<bool, ResultsError> {
        if let Some(path) = &self.path {
            self.results.write(path)?;
        }
        Ok(!self.results.has_failed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(results: Option<PathBuf>) -> ShardOptions {
        ShardOptions { shard: "2/3".parse().unwrap(), results, revision: Some("476b5c9".into()) }
    }

    #[test]
    fn arguments_of_a_shard_or_a_machine_do_not_define_the_campaign() {
        let text = "soak --seed 1 --shard 1/3 --only x=--shard --threads=4 --results r.tsv --revision --shard --last";
        let text = defining(text.split(' ').map(String::from));
        assert_eq!(text, "soak --seed 1 --only x=--shard --last");
        let text = defining(["a line, twice", "it's", ""].map(String::from).into_iter());
        assert_eq!(text, r"'a line, twice' 'it'\''s' ''");
    }

    #[test]
    fn results_are_written_at_the_end_and_an_old_file_is_removed_at_the_begin() {
        let folder = std::env::temp_dir().join(format!("keepout-record-{}", std::process::id()));
        let path = folder.join("deep/2.tsv");
        for _ in 0..2 {
            let mut record = options(Some(path.clone())).begin("soak", "no data".into(), &[]).unwrap();
            assert!(!path.exists());
            record.total("cases", 2);
            record.row(ItemOutcome::Held, "chunk 1", "", "--chunk 1");
            assert!(record.finish().unwrap());
            let read = ShardResults::read(&path).unwrap();
            assert_eq!((read.shard.to_string().as_str(), read.totals["cases"]), ("2/3", 2));
            assert_eq!(read.rows[0].again, "soak --chunk 1");
        }
        let error = options(Some(folder.clone())).begin("soak", String::new(), &[]).unwrap_err().to_string();
        assert!(error.starts_with("cannot write the results to") && error.contains("--results"), "{error}");
        fs::remove_dir_all(&folder).unwrap();
    }
}

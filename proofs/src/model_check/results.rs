//! The answers of the model checker: a table that each whole run writes again.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use keepout_planner::file::write_whole;

use super::run::{Checked, ModelVerdict};

/// A line of the table.
#[derive(Clone, Debug)]
pub struct ModelRow {
    /// The harness's name.
    pub name: String,
    /// Seconds until it was proved.
    pub seconds: f64,
}

/// The table's file.
#[must_use]
pub fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("results/model-check.tsv")
}

/// The versions of the programs, and the harnesses that were proved.
#[must_use]
pub fn read() -> (String, Vec<ModelRow>) {
    let text = fs::read_to_string(file()).unwrap_or_default();
    let row = |line: &str| {
        let mut fields = line.split('\t');
        let (name, seconds) = (fields.next()?, fields.next()?);
        Some(ModelRow { name: name.into(), seconds: seconds.parse().ok()? })
    };
    let versions = text.lines().next().unwrap_or_default().to_string();
    (versions, text.lines().skip(1).filter_map(row).collect())
}

/// Writes the table.
///
/// # Errors
/// The system's.
pub fn write(versions: &str, checked: &[(&str, Checked)]) -> io::Result<()> {
    let proved = checked.iter().filter(|(_, checked)| checked.verdict == ModelVerdict::Holds);
    let line = |(name, checked): &(&str, Checked)| format!("{name}\t{:.1}\n", checked.seconds);
    let lines: String = proved.map(line).collect();
    write_whole(&file(), format!("{versions}\n{lines}").as_bytes())
}

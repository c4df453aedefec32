//! Who noticed which fault: a table that each run of the faults brings up to date.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use keepout_planner::file::write_whole;

use super::{FaultEngine, SeededFault};

/// Between the names of those that noticed a fault.
const SEPARATOR: &str = " | ";

/// What became of a seeded fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FaultFate {
    /// These noticed it: properties, harnesses, worlds, tests, or a verdict of the collision monitor.
    Noticed(Vec<String>),
    /// Nothing noticed it.
    Survived,
    /// Nothing noticed it, and nothing can.
    Equivalent,
    /// It was not decided in the time given.
    Undecided,
    /// The copy does not build: the catalogue is wrong.
    Unbuilt(String),
}

impl FaultFate {
    /// Its name in the table, and the detail.
    fn fields(&self) -> (&str, String) {
        match self {
            Self::Noticed(by) => ("noticed", by.join(SEPARATOR)),
            Self::Survived => ("survived", String::new()),
            Self::Equivalent => ("equivalent", String::new()),
            Self::Undecided => ("undecided", String::new()),
            Self::Unbuilt(why) => ("does not build", why.clone()),
        }
    }

    fn of(name: &str, detail: &str) -> Option<Self> {
        Some(match name {
            "noticed" => Self::Noticed(detail.split(SEPARATOR).map(String::from).collect()),
            "survived" => Self::Survived,
            "equivalent" => Self::Equivalent,
            "undecided" => Self::Undecided,
            "does not build" => Self::Unbuilt(detail.into()),
            _ => return None,
        })
    }

    /// Whether the fault needs no more work.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        matches!(self, Self::Noticed(_) | Self::Equivalent)
    }
}

impl std::fmt::Display for FaultFate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Noticed(by) if by.len() > 1 => write!(f, "noticed: {}, and {} more", by[0], by.len() - 1),
            Self::Noticed(_) | Self::Unbuilt(_) => write!(f, "{}: {}", self.fields().0, self.fields().1),
            _ => f.write_str(self.fields().0),
        }
    }
}

/// A line of the table: a fault under one engine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaultRow {
    /// The fault's name.
    pub name: String,
    /// The engine's name.
    pub engine: String,
    /// What became of it.
    pub fate: FaultFate,
    /// Seconds until it was noticed, with its build when it was built alone.
    pub seconds: u64,
    /// The fault's [digest](SeededFault::digest).
    pub digest: String,
}

/// Between the fields of a row in a results file, whose fields hold no tabs.
const FIELD_SEPARATOR: &str = " ¦ ";

impl FaultRow {
    /// The row of a fault in its present form.
    #[must_use]
    pub fn new(fault: &SeededFault, engine: FaultEngine, fate: FaultFate, seconds: u64) -> Self {
        Self { name: fault.name.clone(), engine: engine.name().into(), fate, seconds, digest: fault.digest() }
    }

    fn line(&self) -> String {
        let (fate, detail) = self.fate.fields();
        format!("{}\t{}\t{fate}\t{detail}\t{}\t{}", self.name, self.engine, self.seconds, self.digest)
    }

    fn of_line(line: &str) -> Option<Self> {
        let mut fields = line.split('\t');
        let mut next = || fields.next();
        let (name, engine, fate, detail) = (next()?, next()?, next()?, next()?);
        let (seconds, digest) = (next()?.parse().ok()?, next()?.into());
        Some(Self {
            name: name.into(),
            engine: engine.into(),
            fate: FaultFate::of(fate, detail)?,
            seconds,
            digest,
        })
    }

    /// The row as one field of a campaign's results file.
    #[must_use]
    pub fn field(&self) -> String {
        self.line().replace('\t', FIELD_SEPARATOR)
    }

    /// The row from such a field. `None` if the field is of another program.
    #[must_use]
    pub fn of_field(field: &str) -> Option<Self> {
        Self::of_line(&field.replace(FIELD_SEPARATOR, "\t"))
    }
}

/// The table's file.
#[must_use]
pub fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("results/faults.tsv")
}

/// The table; empty when there is none yet.
#[must_use]
pub fn read() -> Vec<FaultRow> {
    fs::read_to_string(file()).unwrap_or_default().lines().filter_map(FaultRow::of_line).collect()
}

/// The row of a fault, in its present form, under an engine.
#[must_use]
pub fn row<'a>(rows: &'a [FaultRow], fault: &SeededFault, engine: FaultEngine) -> Option<&'a FaultRow> {
    let digest = fault.digest();
    rows.iter().find(|row| row.name == fault.name && row.engine == engine.name() && row.digest == digest)
}

/// Whether every engine that must notice the fault did so, or nothing can.
#[must_use]
pub fn is_settled(rows: &[FaultRow], fault: &SeededFault) -> bool {
    let settled = |engine: &FaultEngine| row(rows, fault, *engine).is_some_and(|row| row.fate.is_settled());
    fault.engines().iter().all(settled)
}

/// Keeps a row in the table, and drops those of faults that are no longer in the catalogue. Other runs may go on beside
/// this one, so the table is read again first.
///
/// # Errors
/// The system's.
pub(crate) fn keep(row: FaultRow, catalogue: &[SeededFault]) -> io::Result<()> {
    let mut rows = read();
    rows.retain(|old| old.name != row.name || old.engine != row.engine);
    rows.push(row);
    rows.retain(|row| catalogue.iter().any(|fault| fault.name == row.name));
    let file = file();
    fs::create_dir_all(file.parent().unwrap_or(Path::new(".")))?;
    let lines = rows.iter().map(|row| row.line() + "\n");
    write_whole(&file, lines.collect::<String>().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn row_survives_as_a_line_and_as_a_field() {
        let row = FaultRow {
            name: "contour: a piece is skipped".into(),
            engine: "proofs".into(),
            fate: FaultFate::Noticed(vec!["contour".into(), "contour, lines lost".into()]),
            seconds: 7,
            digest: "88fc3d56".into(),
        };
        assert_eq!(FaultRow::of_line(&row.line()).as_ref(), Some(&row));
        assert_eq!(FaultRow::of_field(&row.field()).as_ref(), Some(&row));
        assert_eq!(FaultRow::of_field("400 states"), None);
    }
}

//! The results file: one line per theorem, fields separated by tabs, names of the fields in the first line.

use std::path::Path;
use std::{fs, io};

use keepout_planner::file::write_whole;

/// Names of the fields, in order.
pub const FIELDS: [&str; 14] = [
    "theorem",
    "source",
    "result",
    "paths",
    "queries",
    "solver",
    "seconds",
    "second",
    "agreed",
    "undecided",
    "second_seconds",
    "rests_on",
    "claim",
    "detail",
];

/// One line of the results file.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoremRow {
    /// Name of the theorem.
    pub theorem: String,
    /// The functions that the theorem is about.
    pub source: String,
    /// `proved`, or `failed`.
    pub result: String,
    /// Number of paths through the predicates that were run.
    pub paths: usize,
    /// Number of questions to the solver.
    pub queries: usize,
    /// The solver and its version.
    pub solver: String,
    /// Time of the first solver, seconds.
    pub seconds: f64,
    /// The second solver and its version, or empty.
    pub second: String,
    /// Number of questions in which the second solver agreed.
    pub agreed: usize,
    /// Number of questions that the second solver left undecided.
    pub undecided: usize,
    /// Time of the second solver, seconds.
    pub second_seconds: f64,
    /// The theorems that this one rests on.
    pub rests_on: String,
    /// The claim.
    pub claim: String,
    /// The first failure.
    pub detail: String,
}

impl TheoremRow {
    fn line(&self) -> String {
        let numbers = [self.paths, self.queries, self.agreed, self.undecided].map(|count| count.to_string());
        let [paths, queries, agreed, undecided] = numbers;
        let [seconds, second_seconds] = [self.seconds, self.second_seconds].map(|s| format!("{s:.2}"));
        let text = |text: &str| text.replace(['\t', '\n'], " ");
        let fields = [
            text(&self.theorem),
            text(&self.source),
            text(&self.result),
            paths,
            queries,
            text(&self.solver),
            seconds,
            text(&self.second),
            agreed,
            undecided,
            second_seconds,
            text(&self.rests_on),
            text(&self.claim),
            text(&self.detail),
        ];
        fields.join("\t")
    }

    fn parse(line: &str) -> Option<Self> {
        let fields: Vec<&str> = line.split('\t').collect();
        let &[
            theorem,
            source,
            result,
            paths,
            queries,
            solver,
            seconds,
            second,
            agreed,
            undecided,
            second_seconds,
            rests_on,
            claim,
            detail,
        ] = fields.as_slice()
        else {
            return None;
        };
        Some(Self {
            theorem: theorem.to_owned(),
            source: source.to_owned(),
            result: result.to_owned(),
            paths: paths.parse().ok()?,
            queries: queries.parse().ok()?,
            solver: solver.to_owned(),
            seconds: seconds.parse().ok()?,
            second: second.to_owned(),
            agreed: agreed.parse().ok()?,
            undecided: undecided.parse().ok()?,
            second_seconds: second_seconds.parse().ok()?,
            rests_on: rests_on.to_owned(),
            claim: claim.to_owned(),
            detail: detail.to_owned(),
        })
    }
}

/// Writes all rows, or leaves the file as it was.
///
/// # Errors
/// Those of the file system.
pub fn write(path: &Path, rows: &[TheoremRow]) -> io::Result<()> {
    let mut text = FIELDS.join("\t") + "\n";
    for row in rows {
        text += &(row.line() + "\n");
    }
    write_whole(path, text.as_bytes())
}

/// Reads the rows of a results file.
///
/// # Errors
/// Those of the file system, and [`io::ErrorKind::InvalidData`] with the number of a line that is not a
/// row.
pub fn read(path: &Path) -> io::Result<Vec<TheoremRow>> {
    let text = fs::read_to_string(path)?;
    let rows = text.lines().enumerate().skip(1);
    rows.map(|(number, line)| {
        let wrong =
            || io::Error::new(io::ErrorKind::InvalidData, format!("line {} is not a result", number + 1));
        TheoremRow::parse(line).ok_or_else(wrong)
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_rows_are_read_back() {
        let row = TheoremRow {
            theorem: "a".into(),
            source: "b".into(),
            result: "proved".into(),
            paths: 1,
            queries: 2,
            solver: "z3 1".into(),
            seconds: 0.5,
            second: String::new(),
            agreed: 0,
            undecided: 3,
            second_seconds: 0.25,
            rests_on: "c, d".into(),
            claim: "e".into(),
            detail: String::new(),
        };
        let path = std::env::temp_dir().join(format!("keepout-results-{}.tsv", std::process::id()));
        write(&path, std::slice::from_ref(&row)).unwrap();
        assert_eq!(read(&path).unwrap(), [row]);
        fs::remove_file(path).unwrap();
    }
}

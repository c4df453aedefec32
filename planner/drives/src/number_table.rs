//! Tables of numbers that somebody recorded: CSV with the names of the columns in the first line.

use std::path::Path;

use keepout_planner::file::{FileError, FileKind};
use thiserror::Error;

/// A table as text. A column becomes numbers when it is asked for: other columns may hold anything.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberTable {
    name: String,
    columns: Vec<String>,
    /// The cells of each row, with the number of its line.
    rows: Vec<(usize, Vec<String>)>,
}

/// Reasons for which a table is rejected.
#[derive(Debug, Error)]
pub enum TableError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// A column is missing.
    #[error("{name} has no columns {wanted}. Write their names into the first line, separated by commas.")]
    Columns {
        /// The file.
        name: String,
        /// The columns.
        wanted: &'static str,
    },
    /// A line is not a row of numbers.
    #[error("{name}: line {line} {reason}. Correct the line.")]
    Row {
        /// The file.
        name: String,
        /// Number of the line, from 1.
        line: usize,
        /// The problem.
        reason: String,
    },
    /// There are too few or too many rows.
    #[error(
        "{name} has {rows} rows of numbers, it must have between {LEAST_ROWS} and {MOST_ROWS}. Record it again."
    )]
    Rows {
        /// The file.
        name: String,
        /// Their number.
        rows: usize,
    },
}

static TABLE: FileKind = FileKind::new("table of numbers");

/// Least number of rows.
pub const LEAST_ROWS: usize = 100;
/// Largest number of rows.
pub const MOST_ROWS: usize = 200_000;
/// Largest size of a number.
const LARGEST: f64 = 1e9;

impl NumberTable {
    /// Reads a CSV file.
    ///
    /// # Errors
    /// [`TableError`] with the place.
    pub fn load(path: &Path) -> Result<Self, TableError> {
        Self::parse(&path.display().to_string(), &TABLE.read_text(path)?)
    }

    /// Reads CSV. Messages refer to the text by `name`.
    ///
    /// # Errors
    /// [`TableError`] if there are too few or too many rows.
    pub fn parse(name: &str, text: &str) -> Result<Self, TableError> {
        let cells = |line: &str| line.split(',').map(|cell| cell.trim().to_string()).collect::<Vec<_>>();
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
        let columns = lines.next().map(|(_, line)| cells(line)).unwrap_or_default();
        let rows: Vec<_> = lines.take(MOST_ROWS + 1).map(|(number, line)| (number, cells(line))).collect();
        if !(LEAST_ROWS..=MOST_ROWS).contains(&rows.len()) {
            return Err(TableError::Rows { name: name.into(), rows: rows.len() });
        }
        Ok(Self { name: name.into(), columns, rows })
    }

    /// The index of a column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }

    /// The numbers of a column with this name; none if there is no such column.
    ///
    /// # Errors
    /// [`TableError`] with the line of a cell that is no number.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, TableError> {
        self.column(name).map_or(Ok(Vec::new()), |column| self.numbers_of(column))
    }

    /// The numbers of a column.
    ///
    /// # Errors
    /// [`TableError`] with the line of a cell that is no number.
    pub fn numbers_of(&self, column: usize) -> Result<Vec<f64>, TableError> {
        let number = |(row, (_, cells)): (usize, &(usize, Vec<String>))| {
            let text = cells.get(column).map_or("", String::as_str);
            let value = text.parse::<f64>().ok().filter(|value| value.abs() <= LARGEST);
            value.ok_or_else(|| {
                self.refused(row, format!("has \"{text}\" for {}, which is no number", self.columns[column]))
            })
        };
        self.rows.iter().enumerate().map(number).collect()
    }

    /// The error for a row, counted from 0.
    #[must_use]
    pub fn refused(&self, row: usize, reason: String) -> TableError {
        TableError::Row { name: self.name.clone(), line: self.rows[row].0, reason }
    }

    /// The error for a table without these columns.
    #[must_use]
    pub fn without(&self, wanted: &'static str) -> TableError {
        TableError::Columns { name: self.name.clone(), wanted }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_tables_are_refused_with_their_place() {
        let text = |rows: usize| "a,b\n\n".to_string() + &"1, 2\n".repeat(rows);
        assert!(NumberTable::parse("t.csv", "").unwrap_err().to_string().contains("has 0 rows"));
        assert!(
            NumberTable::parse("t.csv", &text(LEAST_ROWS - 1))
                .unwrap_err()
                .to_string()
                .contains("has 99 rows")
        );
        assert!(NumberTable::parse("t.csv", &text(MOST_ROWS + 1)).is_err());
        let table = NumberTable::parse("t.csv", &text(LEAST_ROWS).replacen("2\n", "nan\n", 1)).unwrap();
        assert_eq!(table.numbers("a").unwrap(), vec![1.0; LEAST_ROWS]);
        assert_eq!(table.numbers("c").unwrap(), Vec::<f64>::new());
        assert_eq!(
            table.numbers("b").unwrap_err().to_string(),
            "t.csv: line 3 has \"nan\" for b, which is no number. Correct the line."
        );
    }
}

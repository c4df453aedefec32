//! A record of the motion of an axis: time, command and position, as CSV.

use std::path::Path;

use crate::number_table::{NumberTable, TableError};

/// The motion of one axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionRecord {
    /// Times, s, in ascending order. Equal numbers of all three.
    pub times_s: Vec<f64>,
    /// Commands, each from its time on, bits.
    pub commands: Vec<f64>,
    /// Positions, mm.
    pub positions_mm: Vec<f64>,
}

/// The records of the axes of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionRecords {
    /// X, if the file has it.
    pub x: Option<MotionRecord>,
    /// Y, if the file has it.
    pub y: Option<MotionRecord>,
}

impl MotionRecords {
    /// Reads a CSV file.
    ///
    /// # Errors
    /// [`TableError`] with the line.
    pub fn load(path: &Path) -> Result<Self, TableError> {
        Self::of(&NumberTable::load(path)?)
    }

    /// The records of a table with the columns `time_s`, and `command` and `position_mm` with the axis before them, as
    /// in `x_command`.
    ///
    /// # Errors
    /// [`TableError`] if columns are missing, or times do not ascend.
    pub fn of(table: &NumberTable) -> Result<Self, TableError> {
        let times_s = table.column("time_s");
        let axis = |axis: &str| -> Result<Option<MotionRecord>, TableError> {
            let names = ["command", "position_mm"].map(|column| format!("{axis}_{column}"));
            let (Some(times_s), true) = (times_s, names.iter().all(|name| table.column(name).is_some()))
            else {
                return Ok(None);
            };
            let [commands, positions_mm] = names.map(|name| table.numbers(&name));
            let (commands, positions_mm) = (commands?, positions_mm?);
            let times_s = table.numbers_of(times_s)?;
            if let Some(late) = times_s.windows(2).position(|pair| pair[1] <= pair[0]) {
                let reason = format!("is not later than the line before: {} s", times_s[late + 1]);
                return Err(table.refused(late + 1, reason));
            }
            Ok(Some(MotionRecord { times_s, commands, positions_mm }))
        };
        let [x, y] = [axis("x")?, axis("y")?];
        if x.is_none() && y.is_none() {
            return Err(
                table.without("time_s, x_command, x_position_mm, or time_s, y_command, y_position_mm")
            );
        }
        Ok(Self { x, y })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number_table::LEAST_ROWS;

    fn text(rows: usize) -> String {
        use std::fmt::Write as _;
        let mut text = String::from("time_s, y_position_mm, note, y_command\n");
        for row in 0..rows {
            writeln!(text, "0.{:03}, 1.5, -, 20", row).unwrap();
        }
        text
    }

    fn parse(text: &str) -> Result<MotionRecords, TableError> {
        MotionRecords::of(&NumberTable::parse("r.csv", text)?)
    }

    #[test]
    fn columns_are_found_by_their_names() {
        let records = parse(&text(LEAST_ROWS)).unwrap();
        let y = records.y.unwrap();
        assert_eq!(
            (records.x, y.commands[5], y.positions_mm[5], y.times_s.len()),
            (None, 20.0, 1.5, LEAST_ROWS)
        );
    }

    #[test]
    fn bad_records_are_refused_with_their_place() {
        let refused = |text: &str| parse(text).unwrap_err().to_string();
        assert!(
            refused(&text(LEAST_ROWS).replace("y_command", "y")).contains("has no columns time_s, x_command")
        );
        let back = text(LEAST_ROWS) + "0.05, 1.5, -, 20\n";
        assert!(
            refused(&back).contains("line 102 is not later than the line before: 0.05 s"),
            "{}",
            refused(&back)
        );
    }
}

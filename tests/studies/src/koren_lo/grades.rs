//! Table 3 of the paper compared with ours. Our grades follow a rule that we fitted to the paper's grades.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use keepout_drives::controllers::kind::Kind;
use keepout_drives::metrics::figure;
use keepout_drives::profile::{DriveProfile, DriveProfileError};

use super::comparison::{ModelError, Row};
use super::scenario::DriveScenario;

/// The paper's grades.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names are the paper's words")]
pub enum Grade {
    Poor,
    Fair,
    Good,
    Excellent,
}

/// One cell of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Row of the table.
    pub row: &'static str,
    /// The controller.
    pub kind: Kind,
    /// Error of its model, as a share.
    pub error: f64,
    /// The paper's grade. `None` for a controller that is not in the paper.
    pub paper: Option<Grade>,
    /// The grade by our rule.
    pub ours: Grade,
    /// The graded value, µm: the RMS contour error, or the overshoot past the corner.
    pub um: f64,
}

use Grade::{Excellent, Fair, Good, Poor};

type Column = (Kind, f64, Option<Grade>);

/// Command limit for the grades of the corner, bits.
const CORNER_LIMIT: f64 = 400.0;
/// The paper's "2% difference between theoretical model and real system".
const TWO_PERCENT: f64 = 0.02;

/// The rows of the table: name, scenario and the paper's grades.
fn rows() -> [(&'static str, &'static str, Vec<Column>); 6] {
    let paper = |p, pid, exact, wrong, ccc| {
        vec![
            (Kind::P, 0.0, Some(p)),
            (Kind::Pid, 0.0, Some(pid)),
            (Kind::Zpetc, 0.0, Some(exact)),
            (Kind::Zpetc, TWO_PERCENT, Some(wrong)),
            (Kind::Ccc, 0.0, Some(ccc)),
        ]
    };
    let mut corner = paper(Fair, Poor, Fair, Fair, Excellent);
    corner.insert(4, (Kind::Ikf, 0.0, Some(Excellent)));
    corner.insert(5, (Kind::Ikf, TWO_PERCENT, Some(Fair)));
    [
        ("Tracking nonlinear trajectories, low feed", "S1", paper(Fair, Fair, Excellent, Fair, Good)),
        ("Tracking nonlinear trajectories, high feed", "S2", paper(Fair, Poor, Excellent, Fair, Good)),
        ("Sharp corners", "S6", corner),
        ("Axis mismatch", "S3", paper(Fair, Good, Excellent, Fair, Excellent)),
        ("Friction", "S4", paper(Poor, Good, Poor, Poor, Excellent)),
        ("Cutting force", "S5", paper(Poor, Good, Poor, Poor, Excellent)),
    ]
}

/// Controllers that are not in the paper's table. Their models have an error of 2 %.
const BEYOND: [Kind; 4] = [Kind::CccFeedforward, Kind::OptimalCcc, Kind::Gpc, Kind::Contouring];

/// Computes every cell of the table.
///
/// # Errors
/// Only if a built-in file is invalid.
pub fn cells() -> Result<Vec<Cell>, DriveProfileError> {
    let scenarios = DriveScenario::built_in()?;
    let mut cells = Vec::new();
    for (name, scenario, mut columns) in rows() {
        columns.extend(BEYOND.map(|kind| (kind, TWO_PERCENT, None)));
        let Some(mut scenario) = scenarios.iter().find(|row| row.name == scenario).cloned() else { continue };
        let corner = scenario.name == "S6";
        scenario.limit_bits = corner.then_some(CORNER_LIMIT);
        let machine = DriveProfile::load(&scenario.machine)?;
        let row = Row::new(&scenario, &machine);
        let measured: Vec<f64> = columns
            .iter()
            .map(|&(kind, error, _)| {
                let figures = row.entry(kind, ModelError::crossed(error)).map(|entry| entry.outcome.figures);
                let um = figures.map(|figures| if corner { figures.overshoot } else { figures.contour.rms });
                um.map_or(f64::NAN, |pulses| pulses * row.um())
            })
            .collect();
        let of_paper = columns.iter().zip(&measured).filter(|(column, _)| column.2.is_some());
        let best = of_paper.map(|(_, &um)| um).fold(f64::INFINITY, f64::min);
        for (&(kind, error, paper), &um) in columns.iter().zip(&measured) {
            let ours = if corner { of_overshoot(um) } else { of_rms(um, measured[0], best) };
            cells.push(Cell { row: name, kind, error, paper, ours, um });
        }
    }
    Ok(cells)
}

/// Grade of an RMS contour error, compared with P's and the best of the paper's controllers, µm.
fn of_rms(um: f64, of_p: f64, best: f64) -> Grade {
    let share = um / of_p;
    if share <= 0.025 || um <= best {
        Excellent
    } else if share <= 0.27 {
        Good
    } else if um < 300.0 && (share <= 2.5 || um <= 20.0) {
        Fair
    } else {
        Poor
    }
}

/// Grade of an overshoot past the corner, µm.
fn of_overshoot(um: f64) -> Grade {
    if um <= 40.0 {
        Excellent
    } else if um <= 150.0 {
        Fair
    } else {
        Poor
    }
}

/// The table in Markdown, with the number of cells that agree with the paper.
#[must_use]
pub fn markdown(cells: &[Cell]) -> String {
    let mut text = String::from("| | controller | paper | ours | µm |\n|---|---|---|---|---|\n");
    let mut last = "";
    for cell in cells {
        let row = if cell.row == last { "" } else { cell.row };
        last = cell.row;
        let error =
            if cell.error > 0.0 { format!(", model {} % wrong", cell.error * 100.0) } else { String::new() };
        let paper = cell.paper.map_or("–".into(), |grade| format!("{grade:?}"));
        let differs = cell.paper.is_some_and(|paper| paper != cell.ours);
        let ours = if differs { format!("**{:?}**", cell.ours) } else { format!("{:?}", cell.ours) };
        let _ = writeln!(
            text,
            "| {row} | {}{error} | {paper} | {ours} | {} |",
            cell.kind.names().1,
            figure(cell.um)
        );
    }
    let (same, all) = agreement(cells);
    let _ = writeln!(
        text,
        "\n{same} of the paper's {all} printed grades agree. A grade that the paper prints once for several of these \
         rows agrees\nif all of them do. Cells that differ are bold. \
         The rule was fitted to these grades, with four limits: \
         the agreement\nshows that such a rule exists, and no more."
    );
    text
}

/// The number of the paper's printed grades that agree with ours, and of all printed grades.
#[must_use]
pub fn agreement(cells: &[Cell]) -> (usize, usize) {
    let mut printed: BTreeMap<(&str, &str, &str), bool> = BTreeMap::new();
    for cell in cells {
        let Some(paper) = cell.paper else { continue };
        *printed.entry(cell.printed()).or_insert(true) &= paper == cell.ours;
    }
    (printed.values().filter(|same| **same).count(), printed.len())
}

impl Cell {
    /// The printed grade that this cell belongs to: row, column and note.
    fn printed(&self) -> (&'static str, &'static str, &'static str) {
        let row = self.row.split(',').next().unwrap_or(self.row);
        let disturbed = ["Friction", "Cutting force"].contains(&self.row);
        let note = match self.kind {
            Kind::Pid if self.row.ends_with("high feed") => "high f",
            // The paper has one grade for both models where a disturbance acts.
            Kind::Zpetc if disturbed => "",
            _ if self.error > 0.0 => "2 %",
            _ => "",
        };
        (row, self.kind.names().0, note)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Only IKF with a 2 % error may differ. The paper grades it "Fair", but no reading of its model gives
    /// that grade.
    #[test]
    fn all_grades_but_one_agree_with_the_paper() {
        let cells = cells().unwrap();
        let differing: Vec<_> =
            cells.iter().filter(|cell| cell.paper.is_some_and(|paper| paper != cell.ours)).collect();
        assert!(differing.iter().all(|cell| cell.kind == Kind::Ikf && cell.error > 0.0), "{differing:#?}");
        assert_eq!(agreement(&cells), (25, 26));
        for cell in cells.iter().filter(|cell| cell.kind == Kind::Contouring) {
            assert_eq!(cell.ours, Excellent, "{cell:?}");
        }
    }
}

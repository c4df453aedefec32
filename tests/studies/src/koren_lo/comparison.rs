//! Comparison of controllers: runs every row with every controller, and writes tables.

use std::fmt::Write as _;

use keepout_drives::controllers::kind::{Kind, Setting};
use keepout_drives::controllers::selection::Environment;
use keepout_drives::metrics::figure;
use keepout_drives::profile::{DriveProfile, DriveProfileError, Uncertainty};
use keepout_drives::run::{RunOutcome, Task};
use keepout_planner::report::table::markdown;

use super::scenario::DriveScenario;

/// Error of a controller's model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelError {
    /// Error of gains and time constants, as a share.
    pub share: f64,
    /// Signs of the errors: gain and time constant of X, then of Y.
    pub signs: [f64; 4],
}

impl ModelError {
    /// An exact model.
    pub const NONE: Self = Self { share: 0.0, signs: [0.0; 4] };

    /// Our reading of the paper's "2 %": gains +, −, time constants −, +. With these signs the errors do not
    /// cancel.
    #[must_use]
    pub fn crossed(share: f64) -> Self {
        Self { share, signs: [1.0, -1.0, -1.0, 1.0] }
    }
}

/// One controller on one row.
#[derive(Clone, Debug)]
pub struct ControllerEntry {
    /// The controller.
    pub kind: Kind,
    /// The choice, if the controller is the selection.
    pub chosen: Option<Kind>,
    /// Error of its model, as a share.
    pub error: f64,
    /// The result of the run.
    pub outcome: RunOutcome,
}

/// A row with all of its controllers.
#[derive(Clone, Debug)]
pub struct Row {
    /// The scenario.
    pub scenario: DriveScenario,
    /// The machine of the run.
    pub machine: DriveProfile,
    /// The task of the run.
    pub task: Task,
    /// The controllers, in the requested order. A controller that does not exist for this row is missing.
    pub entries: Vec<ControllerEntry>,
}

/// Rows and controllers.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The model error of the controllers.
    pub error: ModelError,
    /// The requested controllers.
    pub kinds: Vec<Kind>,
    /// The rows.
    pub rows: Vec<Row>,
}

/// Largest number of samples in memory, for all rows and controllers together: about 2 GB.
const MOST_KEPT: f64 = 4e7;

impl Row {
    /// `scenario` on `machine`, without any entries.
    #[must_use]
    pub fn new(scenario: &DriveScenario, machine: &DriveProfile) -> Self {
        let task = scenario.task(machine);
        Self { scenario: scenario.clone(), machine: machine.clone(), task, entries: Vec::new() }
    }

    /// The parameters of a controller for this row.
    #[must_use]
    pub fn setting(&self, error: ModelError) -> Setting {
        let mut setting = self.machine.setting(Environment::of(&self.task, error.share));
        let by = Uncertainty { gain: error.share, time_constant: error.share, delay_samples: 0.0 };
        setting.belief = setting.belief.on(&self.task.plant).off_by(by, error.signs);
        setting.round = self.scenario.round(&self.machine);
        setting
    }

    /// Runs a controller on this row. `None` if this kind does not exist for the row.
    #[must_use]
    pub fn entry(&self, kind: Kind, error: ModelError) -> Option<ControllerEntry> {
        let setting = self.setting(error);
        let mut controller = kind.built(&setting)?;
        let chosen = (kind == Kind::Selection).then(|| setting.environment.choice());
        Some(ControllerEntry {
            kind,
            chosen,
            error: error.share,
            outcome: self.task.run(controller.as_mut()),
        })
    }

    /// Length of a pulse, µm.
    #[must_use]
    pub fn um(&self) -> f64 {
        self.machine.um()
    }
}

impl ControllerEntry {
    /// The title of the controller, with its choice and its model error.
    #[must_use]
    pub fn name(&self) -> String {
        let chosen = self.chosen.map_or(String::new(), |kind| format!(": {}", kind.names().1));
        let error =
            if self.error > 0.0 { format!(", model {} % wrong", self.error * 100.0) } else { String::new() };
        format!("{}{chosen}{error}", self.kind.names().1)
    }
}

impl Comparison {
    /// Runs every row with every controller, on `machine` or on the machine of the row. Calls `progress` with
    /// the number of finished runs and of all runs.
    ///
    /// # Errors
    /// [`DriveProfileError`] for a row with an unknown machine, or if the runs need more memory than allowed.
    pub fn run(
        scenarios: &[DriveScenario],
        machine: Option<&DriveProfile>,
        kinds: &[Kind],
        error: ModelError,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Result<Self, DriveProfileError> {
        let count = scenarios.len() * kinds.len();
        let mut samples = 0.0;
        let mut rows = Vec::new();
        for (number, scenario) in scenarios.iter().enumerate() {
            let own = machine.cloned().map_or_else(|| DriveProfile::load(&scenario.machine), Ok)?;
            scenario.checked(&own)?;
            #[expect(clippy::cast_precision_loss, reason = "a few controllers")]
            let kept = scenario.samples(&own) * kinds.len() as f64;
            samples += kept;
            if samples > MOST_KEPT {
                let field = "the number of samples of all rows and controllers";
                let range = format!("{MOST_KEPT} at most: choose fewer with --scenario and --controller");
                return Err(DriveProfileError::Figure {
                    name: scenario.name.clone(),
                    field,
                    value: samples,
                    range,
                });
            }
            let mut row = Row::new(scenario, &own);
            for (done, &kind) in kinds.iter().enumerate() {
                progress(number * kinds.len() + done, count);
                row.entries.extend(row.entry(kind, error));
            }
            rows.push(row);
        }
        Ok(Self { error, kinds: kinds.to_vec(), rows })
    }

    /// Contour errors as a Markdown table, RMS / max in µm: one line per controller, one column per row.
    #[must_use]
    pub fn markdown(&self) -> String {
        let names = self.rows.iter().map(|row| row.scenario.name.clone());
        let mut table = vec![std::iter::once("µm, RMS / max".into()).chain(names).collect()];
        for &kind in &self.kinds {
            let cell = |row: &Row| {
                let found = row.entries.iter().find(|entry| entry.kind == kind);
                found.map_or("–".into(), |entry| {
                    let contour = entry.outcome.figures.contour.times(row.um());
                    format!("{} / {}", figure(contour.rms), figure(contour.max))
                })
            };
            table.push(std::iter::once(kind.names().1.into()).chain(self.rows.iter().map(cell)).collect());
        }
        markdown(&table)
    }

    /// Descriptions of the rows, as a Markdown list.
    #[must_use]
    pub fn legend(&self) -> String {
        let mut text = String::new();
        for row in &self.rows {
            let DriveScenario { name, title, figure, feed_m_min, .. } = &row.scenario;
            let figure = figure.as_ref().map_or(String::new(), |figure| format!(" ({figure})"));
            let _ = writeln!(text, "- **{name}** {title}, {feed_m_min} m/min{figure}: {}", row.machine.name);
        }
        text
    }

    /// All measures, as CSV.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "row,machine,feed_m_min,controller,model_error,rms_um,max_um,settled_rms_um,settled_max_um,\
             axial_um,overshoot_um,saturation_share\n",
        );
        for row in &self.rows {
            for entry in &row.entries {
                let figures = &entry.outcome.figures;
                let (contour, settled) = (figures.contour.times(row.um()), figures.settled.times(row.um()));
                let _ = writeln!(
                    text,
                    "{},{},{},{},{},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4}",
                    quoted(&row.scenario.name),
                    quoted(&row.machine.name),
                    row.scenario.feed_m_min,
                    entry.kind.names().0,
                    self.error.share,
                    contour.rms,
                    contour.max,
                    settled.rms,
                    settled.max,
                    figures.axial * row.um(),
                    figures.overshoot * row.um(),
                    figures.saturation_share,
                );
            }
        }
        text
    }
}

/// `text` as a CSV field, with quotes where necessary.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_have_every_row_and_controller() {
        let rows = DriveScenario::built_in().unwrap();
        let kinds = [Kind::P, Kind::Repetitive, Kind::Selection];
        let mut last = 0;
        let found =
            Comparison::run(&rows[..2], None, &kinds, ModelError::NONE, &mut |done, _| last = done).unwrap();
        assert_eq!(last, 5);
        let markdown = found.markdown();
        assert_eq!(markdown.lines().count(), 5);
        // These paths do not repeat, so repetitive control has no result.
        assert!(markdown.contains("| repetitive P | – | – |"), "{markdown}");
        assert!(markdown.contains("| P | 2.82 / 11.9 | 21.5 / 74.1 |"), "{markdown}");
        assert_eq!(found.csv().lines().count(), 1 + 4);
        assert_eq!(found.rows[0].entries[1].chosen, Some(Kind::CccFeedforward));
    }

    #[test]
    fn figures_have_three_digits() {
        assert_eq!(
            [0.0321, 2.818, 11.93, 566.4, 1e9, f64::NAN].map(figure),
            ["0.032", "2.82", "11.9", "566", "diverges", "diverges"]
        );
    }
}

//! Controllers side by side: every row with every one of them, as tables.

use std::fmt::Write as _;

use keepout_drives::controllers::kind::{Kind, Setting};
use keepout_drives::controllers::selection::Environment;
use keepout_drives::metrics::figure;
use keepout_drives::profile::{DriveProfile, ProfileError, Uncertainty};
use keepout_drives::run::{Outcome, Task};

use super::scenario::Scenario;

/// By how much a controller's model is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelError {
    /// As a share, of gains and time constants.
    pub share: f64,
    /// The signs: gain and time constant of X, of Y.
    pub signs: [f64; 4],
}

impl ModelError {
    /// An exact model.
    pub const NONE: Self = Self { share: 0.0, signs: [0.0; 4] };

    /// As the paper's "2 %" is read: gains +, −, time constants −, +, so that nothing cancels.
    #[must_use]
    pub fn crossed(share: f64) -> Self {
        Self { share, signs: [1.0, -1.0, -1.0, 1.0] }
    }
}

/// One controller on one row.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The controller.
    pub kind: Kind,
    /// What the selection chose, if it is that.
    pub chosen: Option<Kind>,
    /// The share by which its model is wrong.
    pub error: f64,
    /// What came of it.
    pub outcome: Outcome,
}

/// A row with all of its controllers.
#[derive(Clone, Debug)]
pub struct Row {
    /// The row.
    pub scenario: Scenario,
    /// The machine it was run on.
    pub machine: DriveProfile,
    /// What was run.
    pub task: Task,
    /// The controllers, in the order they were asked for. One that there is not for the row is left out.
    pub entries: Vec<Entry>,
}

/// Rows and controllers.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The model error of the controllers.
    pub error: ModelError,
    /// The controllers asked for.
    pub kinds: Vec<Kind>,
    /// The rows.
    pub rows: Vec<Row>,
}

/// Samples that are kept at most, of all rows and controllers together: about 2 GB.
const MOST_KEPT: f64 = 4e7;

impl Row {
    /// `scenario` on `machine`, with nothing run yet.
    #[must_use]
    pub fn new(scenario: &Scenario, machine: &DriveProfile) -> Self {
        let task = scenario.task(machine);
        Self { scenario: scenario.clone(), machine: machine.clone(), task, entries: Vec::new() }
    }

    /// What a controller is built from here.
    #[must_use]
    pub fn setting(&self, error: ModelError) -> Setting {
        let mut setting = self.machine.setting(Environment::of(&self.task, error.share));
        setting.belief.limit = self.task.plant.limit;
        let by = Uncertainty { gain: error.share, time_constant: error.share };
        setting.belief = setting.belief.off_by(by, error.signs);
        setting.round = self.scenario.round(&self.machine);
        setting
    }

    /// What comes of a controller; `None` where there is none of this kind.
    #[must_use]
    pub fn entry(&self, kind: Kind, error: ModelError) -> Option<Entry> {
        let setting = self.setting(error);
        let mut controller = kind.built(&setting)?;
        let chosen = (kind == Kind::Selection).then(|| setting.environment.choice());
        Some(Entry { kind, chosen, error: error.share, outcome: self.task.run(controller.as_mut()) })
    }

    /// Pulses to µm.
    #[must_use]
    pub fn um(&self) -> f64 {
        self.machine.um()
    }
}

impl Entry {
    /// The controller, what it chose, and how far its model is wrong.
    #[must_use]
    pub fn name(&self) -> String {
        let chosen = self.chosen.map_or(String::new(), |kind| format!(": {}", kind.names().1));
        let error =
            if self.error > 0.0 { format!(", model {} % wrong", self.error * 100.0) } else { String::new() };
        format!("{}{chosen}{error}", self.kind.names().1)
    }
}

impl Comparison {
    /// Runs every row with every controller, on `machine` or on the row's own. `progress` is told runs done and all of them.
    ///
    /// # Errors
    /// [`ProfileError`] for a row whose machine is not known, or that takes more samples than are kept.
    pub fn run(
        scenarios: &[Scenario],
        machine: Option<&DriveProfile>,
        kinds: &[Kind],
        error: ModelError,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Result<Self, ProfileError> {
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
                let range = format!("{MOST_KEPT} at most: take fewer at a time");
                return Err(ProfileError::Figure {
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

    /// Contour errors as a Markdown table: controllers below each other, rows side by side, RMS / max in µm.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = String::from("| µm, RMS / max |");
        for row in &self.rows {
            let _ = write!(text, " {} |", row.scenario.name);
        }
        text.push_str("\n|---|");
        text.push_str(&"---|".repeat(self.rows.len()));
        text.push('\n');
        for &kind in &self.kinds {
            let _ = write!(text, "| {} |", kind.names().1);
            for row in &self.rows {
                let found = row.entries.iter().find(|entry| entry.kind == kind);
                let cell = found.map_or("–".into(), |entry| {
                    let contour = entry.outcome.figures.contour.times(row.um());
                    format!("{} / {}", figure(contour.rms), figure(contour.max))
                });
                let _ = write!(text, " {cell} |");
            }
            text.push('\n');
        }
        text
    }

    /// What the rows are, as a Markdown list.
    #[must_use]
    pub fn legend(&self) -> String {
        let mut text = String::new();
        for row in &self.rows {
            let Scenario { name, title, figure, feed_m_min, .. } = &row.scenario;
            let figure = figure.as_ref().map_or(String::new(), |figure| format!(" ({figure})"));
            let _ = writeln!(text, "- **{name}** {title}, {feed_m_min} m/min{figure}: {}", row.machine.name);
        }
        text
    }

    /// Everything that was measured, as CSV.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "row,machine,feed_m_min,controller,model_error,rms_um,max_um,settled_rms_um,settled_max_um,axial_um,overshoot_um,saturation_share\n",
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

/// A field of CSV.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_have_every_row_and_controller() {
        let rows = Scenario::built_in().unwrap();
        let kinds = [Kind::P, Kind::Repetitive, Kind::Selection];
        let mut told = 0;
        let found =
            Comparison::run(&rows[..2], None, &kinds, ModelError::NONE, &mut |done, _| told = done).unwrap();
        assert_eq!(told, 5);
        let markdown = found.markdown();
        assert_eq!(markdown.lines().count(), 5);
        // No path of these repeats.
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

//! The page `docs/research/tuned-controllers.md`.

use std::fmt::Write as _;

use keepout_drives::controllers::kind::Kind;
use keepout_drives::metrics::figure;
use keepout_drives::profile::{DriveProfile, DriveProfileError};
use keepout_drives::tuning::TunedGains;
use keepout_drives::tuning::parameter::Parameter;
use keepout_planner::report::table::markdown;

use super::variant::{Score, ScoringPath, Variant, paths, score};
use crate::franco_horikawa::parallel::{ProgressCallback, parallel};
use crate::franco_horikawa::scenario::StudyError;

/// A controller with its gains and its scores, on a machine.
#[derive(Clone, Debug)]
pub struct TunedRow {
    /// The controller.
    pub kind: Kind,
    /// The gains, or why there are none.
    pub tuned: Result<TunedGains, String>,
    /// The scores, path by path.
    pub scores: Vec<Score>,
}

impl TunedRow {
    /// Tunes a controller for a variant, and runs it on the paths.
    #[must_use]
    pub fn of(variant: &Variant, machine: &DriveProfile, kind: Kind, paths: &[ScoringPath]) -> Self {
        let tuned = variant.tuned(machine, kind).map_err(|error| error.to_string());
        let scores = tuned.as_ref().ok().map(|tuned| {
            let machine = DriveProfile { gains: tuned.gains, ..machine.clone() };
            paths.iter().map_while(|path| score(&machine, kind, path)).collect()
        });
        Self { kind, tuned, scores: scores.unwrap_or_default() }
    }

    /// The text of its cell in the table of a path.
    #[must_use]
    pub fn cell(&self, path: usize) -> String {
        self.scores.get(path).map_or("–".into(), |score| figure(score.rms_um))
    }
}

/// The kinds of the comparison: all that the tuner takes.
#[must_use]
pub fn kinds() -> Vec<Kind> {
    Kind::ALL.into_iter().filter(|kind| !matches!(kind, Kind::Selection | Kind::Repetitive)).collect()
}

/// Best, or within this share of the best.
const NEAR_BEST: f64 = 1.05;

/// Makes the page.
///
/// # Errors
/// Only if a built-in file is invalid.
pub fn page(progress: &ProgressCallback<'_>) -> Result<String, StudyError> {
    let (variants, kinds, paths) = (Variant::all(), kinds(), paths());
    let machines: Vec<DriveProfile> =
        variants.iter().map(Variant::machine).collect::<Result<_, DriveProfileError>>()?;
    // The slow controllers first.
    let count = variants.len() * kinds.len();
    let rows = parallel(count, progress, |number| {
        let (kind, variant) = (kinds[kinds.len() - 1 - number / variants.len()], number % variants.len());
        Ok((variant, TunedRow::of(&variants[variant], &machines[variant], kind, &paths)))
    })?;
    let comparison = TunedComparison { variants, kinds, paths, rows };
    Ok(comparison.text())
}

/// All controllers on all variants and paths.
struct TunedComparison {
    variants: Vec<Variant>,
    kinds: Vec<Kind>,
    paths: Vec<ScoringPath>,
    /// Each with the number of its variant.
    rows: Vec<(usize, TunedRow)>,
}

impl TunedComparison {
    fn row(&self, variant: usize, kind: Kind) -> Option<&TunedRow> {
        self.rows.iter().find(|(at, row)| *at == variant && row.kind == kind).map(|(_, row)| row)
    }

    fn text(&self) -> String {
        let mut text = String::from(HEAD);
        for at in 0..self.paths.len() {
            let _ = write!(text, "\n{}", self.table(at));
        }
        self.ours(&mut text);
        let unstable = self.unstable();
        let listed = if unstable.is_empty() { "none".into() } else { unstable.join("; ") };
        let _ = write!(
            text,
            "\nRuns whose error exceeds {} mm with drives that are 20 % wrong and a command one sample \
             late:\n{listed}.\n",
            UNSTABLE_UM / 1000.0
        );
        self.parameters(&mut text);
        text
    }

    /// The RMS contour errors on a path.
    fn table(&self, path: usize) -> String {
        let names = self.variants.iter().map(Variant::name);
        let head = format!("{}: µm RMS", self.paths[path].name);
        let mut table: Vec<Vec<String>> = vec![std::iter::once(head).chain(names).collect()];
        for &kind in &self.kinds {
            let cell = |variant| self.row(variant, kind).map_or("–".into(), |row| row.cell(path));
            let cells = (0..self.variants.len()).map(cell);
            table.push(std::iter::once(kind.names().1.into()).chain(cells).collect());
        }
        markdown(&table)
    }

    /// Where the contouring MPC is the best, and where it falls short.
    fn ours(&self, text: &mut String) {
        let (mut near_best, mut count) = (0, 0);
        let mut behind = String::new();
        for (at, path) in self.paths.iter().enumerate() {
            for (number, variant) in self.variants.iter().enumerate() {
                let rms = |kind| Some(self.row(number, kind)?.scores.get(at)?.rms_um);
                let others = self.kinds.iter().filter(|kind| **kind != Kind::Contouring);
                let best = others
                    .filter_map(|kind| Some((*kind, rms(*kind)?)))
                    .min_by(|one, other| one.1.total_cmp(&other.1));
                let (Some(ours), Some((kind, best))) = (rms(Kind::Contouring), best) else { continue };
                count += 1;
                if ours <= best * NEAR_BEST {
                    near_best += 1;
                    continue;
                }
                let (name, variant, title) = (path.name, variant.name(), kind.names().1);
                let [ours, best] = [ours, best].map(figure);
                let _ = writeln!(behind, "| {name} | {variant} | {ours} | {title} | {best} |");
            }
        }
        let _ = write!(
            text,
            "\n## Ours\n\nThe contouring MPC is the best, or within 5 % of the best, in {near_best} of {count} rows.\n"
        );
        if !behind.is_empty() {
            let head = "| path | T, encoder | MPC | best | its error |\n|---|---|---|---|---|";
            let _ = write!(text, "It falls short here:\n\n{head}\n{behind}");
        }
    }

    /// The runs with a huge error.
    fn unstable(&self) -> Vec<String> {
        let mut found = Vec::new();
        for (number, row) in &self.rows {
            for (score, path) in row.scores.iter().zip(&self.paths) {
                if !(0.0..UNSTABLE_UM).contains(&score.worst_um) {
                    let variant = self.variants[*number].name();
                    found.push(format!("{} on {} ({variant})", row.kind.names().1, path.name));
                }
            }
        }
        found
    }

    /// The tuned parameters.
    fn parameters(&self, text: &mut String) {
        text.push_str("\n## The tuned parameters\n\n");
        let mut table = vec![["controller", "T, encoder", "parameters", "peak"].map(String::from).to_vec()];
        for &kind in &self.kinds {
            for (number, variant) in self.variants.iter().enumerate() {
                let Some(row) = self.row(number, kind) else { continue };
                let (found, peak) = match &row.tuned {
                    Ok(tuned) => {
                        let values = Parameter::of(kind).iter().map(|each| {
                            let name = each.name.rsplit('.').next().unwrap_or_default();
                            format!("{name} {:.4e}", each.value(&tuned.gains))
                        });
                        (values.collect::<Vec<_>>().join(", "), format!("{:.2}", tuned.peak))
                    }
                    Err(_) => ("none keep the margins".into(), "–".into()),
                };
                table.push(vec![kind.names().1.into(), variant.name(), found, peak]);
            }
        }
        text.push_str(&markdown(&table));
    }
}

/// Error from which a run counts as unstable, µm.
const UNSTABLE_UM: f64 = 5000.0;

const HEAD: &str = "# Every controller, tuned alike\n\n\
    Written by `cargo run --release -p keepout-studies -- tuned`; a test compares some of its cells.\n\n\
    The paper's gains leave its controllers different margins, so a comparison with them compares margins, too. Here\n\
    one tuner finds the gains of every controller, ours included: `planner/drives/src/tuning`, the same as\n\
    `keepout drives tune`.\n\n\
    - **Objective**: the geometric mean of the RMS contour errors on a circle of 7 mm, an ellipse and a corner of\n  \
    60°, until the drives rest, with sticking friction, cutting force, and drives that are 5 % wrong.\n\
    - **Constraint**: the peak of the sensitivity is 2 at most, which leaves a gain margin of 2 and a phase margin\n  \
    of 29°. It holds for drives that are 20 % wrong and for a command up to one sample later than the controller\n  \
    knows.\n\
    - **Search**: an evolution strategy from eight starts, of which half go on after each round; at most 400\n  \
    candidates for each controller. A candidate without the margins is made slower until it has them. The first\n  \
    start is the gains of the profile: the paper's, and for the contouring MPC those that an earlier run of this\n  \
    tuner found on this machine. The others are random around it.\n\n\
    The machine is that of the paper's Table 1 with whole pulses and bits and |U| up to 200 mm/s. The scores below\n\
    are on other paths: a circle of 20 mm, corners of 90° and 150°, a spiral, and the finishing contours of\n\
    the drawings `bracket.dxf` and `spline_periodic.dxf`, at 0.9 m/min, with drives that are 5 % wrong and a command\n\
    half a sample late. A dash: no gains of this controller keep the margins.\n";

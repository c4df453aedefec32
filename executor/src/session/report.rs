//! The page and the picture of a run, from the session itself.

use keepout_planner::Mm3;
use keepout_planner::contour::short;
use keepout_planner::job::Progress;
use keepout_planner::plan::{CertifiedPlan, Cut};
use keepout_planner::report::html::JobPage;
use keepout_planner::report::{RunDrawing, Trace, TraceKind, section_svg, svg};
use keepout_planner::sha256::hex;
use keepout_planner::size::size;
use keepout_planner::stock::StockFigures;
use keepout_planner::units::mm;

use super::coverage::Coverage;
use super::log_page::row;
use super::outcome::{JobOutcome, contour_rows};
use crate::session::{Sample, SampleKind};
use crate::supervisor::{Counts, Supervisor};

/// The figures of a run.
#[derive(Clone, Debug)]
pub struct RunFacts {
    /// The outcome of the job.
    pub outcome: JobOutcome,
    /// Machine time, s.
    pub seconds: f64,
    /// The supervisor's counters.
    pub counts: Counts,
    /// The progress of the contours.
    pub progress: Progress,
    /// Deepest gouge by the monitor, mm; `None` without a monitor.
    pub deepest_mm: Option<f64>,
    /// Least distance between tool and part by the monitor, mm.
    pub closest_mm: Option<f64>,
    /// Least distance between tool and part while jogging, by the monitor, mm.
    pub closest_by_hand_mm: Option<f64>,
    /// The cut contour by the monitor.
    pub coverage: Option<Coverage>,
    /// Operator, machine and port, in words.
    pub setting: String,
    /// The notices that the session showed to the operator.
    pub notices: Vec<String>,
}

impl RunFacts {
    /// The supervisor's figures after a session of `seconds`, without the collision monitor's figures.
    #[must_use]
    pub fn of(supervisor: &Supervisor, outcome: JobOutcome, seconds: f64) -> Self {
        Self {
            outcome,
            seconds,
            counts: supervisor.counts(),
            progress: supervisor.progress(),
            deepest_mm: None,
            closest_mm: None,
            closest_by_hand_mm: None,
            coverage: None,
            setting: String::new(),
            notices: supervisor.notices().iter().map(ToString::to_string).collect(),
        }
    }

    /// The figures of this session and an earlier one of the same job.
    #[must_use]
    pub fn after(self, earlier: &Self) -> Self {
        let least = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        let (a, b) = (self.counts, earlier.counts);
        Self {
            seconds: self.seconds + earlier.seconds,
            counts: Counts {
                jogs: a.jogs + b.jogs,
                contour_motions: a.contour_motions + b.contour_motions,
                cancels: a.cancels + b.cancels,
                clipped: a.clipped + b.clipped,
                queries: a.queries + b.queries,
            },
            deepest_mm: self.deepest_mm.zip(earlier.deepest_mm).map(|(a, b)| a.max(b)),
            closest_mm: least(self.closest_mm, earlier.closest_mm),
            closest_by_hand_mm: least(self.closest_by_hand_mm, earlier.closest_by_hand_mm),
            coverage: [self.coverage, earlier.coverage].into_iter().flatten().reduce(Coverage::and),
            notices: earlier.notices.iter().cloned().chain(self.notices.clone()).collect(),
            ..self
        }
    }

    /// The rows of the table: name and value. `samples`: the places of the tool, drawing coordinates.
    #[must_use]
    pub fn rows(&self, plan: &CertifiedPlan, samples: &[Sample]) -> Vec<(String, String)> {
        let mut rows = vec![
            row("outcome", self.outcome.to_string()),
            row("setting", self.setting.clone()),
            row("time", format!("{:.1} s", self.seconds)),
        ];
        rows.extend(count_rows(&self.counts));
        if let Some(deepest) = self.deepest_mm {
            rows.push(row("deepest gouge", format!("{deepest:.5} mm")));
        }
        if let Some(closest) = self.closest_mm {
            rows.push(row("closest approach of tool and part", format!("{closest:.5} mm")));
        }
        if let Some(closest) = self.closest_by_hand_mm {
            rows.push(row("closest approach while jogging", format!("{closest:.5} mm")));
        }
        if let Some(coverage) = self.coverage.filter(|coverage| coverage.reachable > 0) {
            rows.push(row(
                "cut contour to profile",
                format!(
                    "at most {:.4} mm (at {:.2}, {:.2}), mean {:.4} mm, over {} reachable of {} points",
                    coverage.worst_mm,
                    coverage.worst_at.x,
                    coverage.worst_at.y,
                    coverage.mean_mm,
                    coverage.reachable,
                    coverage.points
                ),
            ));
            if coverage.missed > 0 {
                rows.push(row("reachable points not contoured", coverage.missed.to_string()));
            }
        }
        rows.push(row("rest material after the whole plan", plan.residual()));
        rows.push(row(
            "margin M",
            format!("{:.5} mm", plan.plan.budget.total().map_or(f64::NAN, |m| mm(m.units()))),
        ));
        rows.extend(stock_rows(plan, samples));
        rows.extend(self.notices.iter().map(|notice| row("note", notice.clone())));
        rows
    }
}

/// The rows of the supervisor's counters.
pub(super) fn count_rows(counts: &Counts) -> [(String, String); 2] {
    let Counts { jogs, contour_motions, cancels, queries, clipped } = counts;
    let sent =
        format!("{jogs} jogs, {contour_motions} contour motions, {cancels} cancels, {queries} queries");
    [("commands sent".into(), sent), ("jogs clipped by the guard".into(), clipped.to_string())]
}

/// Most drawn points of a run, about.
const DRAWN: usize = 40_000;

/// The picture of a run from the true positions, in drawing coordinates.
#[must_use]
pub fn picture_of_run(plan: &CertifiedPlan, title: &str, samples: &[Sample], progress: &Progress) -> String {
    let traces = traces(samples);
    svg(plan, title, &RunDrawing { traces: &traces, spots: &[], progress: Some(progress) })
}

/// The section view of a run with depths from the true positions, in drawing coordinates.
#[must_use]
pub fn section_of_run(plan: &CertifiedPlan, title: &str, samples: &[Sample]) -> Option<String> {
    let way: Vec<Mm3> = samples.iter().map(|sample| sample.position_mm).collect();
    section_svg(plan, title, &way)
}

/// The rows about the stock of a run with depths, from the true positions, in drawing coordinates.
pub(super) fn stock_rows(plan: &CertifiedPlan, samples: &[Sample]) -> Vec<(String, String)> {
    let way = samples.iter().map(|sample| (sample.position_mm, sample.kind == SampleKind::Run));
    StockFigures::of(plan, way).map_or(Vec::new(), |figures| figures.rows())
}

/// The traces of a run, one for each stretch of one kind. Long runs are thinned out.
pub(super) fn traces(samples: &[Sample]) -> Vec<Trace> {
    let mut traces: Vec<Trace> = Vec::new();
    let every = (samples.len() / DRAWN).max(1);
    let mut last_kept = 0;
    for (index, sample) in samples.iter().enumerate() {
        let kind = match sample.kind {
            SampleKind::Rest => continue,
            SampleKind::Jog => TraceKind::Manual,
            SampleKind::Run => TraceKind::Contour,
        };
        match traces.last_mut() {
            Some(trace) if trace.kind == kind => {
                if index - last_kept < every {
                    continue;
                }
                trace.points_mm.push(sample.position_mm.plane());
            }
            _ => traces.push(Trace { kind, points_mm: vec![sample.position_mm.plane()] }),
        }
        last_kept = index;
    }
    traces
}

/// A self-contained page of a run, from the session itself. `rows`: its [`RunFacts::rows`].
#[must_use]
pub fn html(
    plan: &CertifiedPlan,
    facts: &RunFacts,
    rows: Vec<(String, String)>,
    picture: &str,
    section: Option<&str>,
) -> String {
    let mut proof = rows;
    proof.push(("drawing SHA-256".into(), hex(&plan.plan.provenance.hash)));
    JobPage {
        title: plan.plan.provenance.name.clone(),
        outcome: facts.outcome.to_string(),
        is_complete: facts.outcome.is_complete(),
        facts: part_rows(plan),
        contours: contour_rows(plan, &facts.progress),
        picture: picture.into(),
        section: section.map(Into::into),
        proof,
        plan: plan.summary(),
        ..JobPage::default()
    }
    .html()
}

/// The rows about part and tool.
pub(super) fn part_rows(plan: &CertifiedPlan) -> Vec<(String, String)> {
    let made = &plan.plan;
    let direction = match made.cut {
        Cut::Conventional => "conventional",
        Cut::Climb => "climb",
    };
    vec![
        row("drawing", made.provenance.name.clone()),
        row("size", format!("{} mm, {}", size(plan.profile_size_mm()), plan.side_words())),
        row("unit", made.provenance.unit.clone()),
        row("tool", format!("Ø {} mm, {direction}", short(2.0 * mm(made.tool_radius.units())))),
        row("stock to leave", format!("{} mm", short(mm(made.stock_to_leave.units())))),
        row("rest material", plan.residual()),
    ]
}

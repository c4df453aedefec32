//! The outcome of a job. The terminal, the view, the event log, the replay, the report and the exit code all use it.
//!
//! Implements SR-23.

use std::fmt;

use keepout_planner::contour::ContourRole;
use keepout_planner::job::{LoopNumber, Progress};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::planned::PlannedContour;

use crate::supervisor::{Phase, Supervisor};

/// How a job ended, and which contours are cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobOutcome {
    /// How it ended.
    pub ending: Ending,
    /// The contours.
    pub tally: ContourTally,
}

/// How a job ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Every contour that the plan cuts is cut.
    Complete,
    /// The operator ended the session between two contours, and some are left.
    Incomplete,
    /// The operator stopped the session before its first contour, or within a contour.
    Stopped,
    /// The time limit ended the session.
    TimeLimit,
    /// A fault ended the session: its reason and its remedy.
    Fault(String),
    /// The log ends in the middle: the program or the computer stopped there.
    NotEnded(Option<Phase>),
}

/// The contours of a plan, after earlier sessions and this one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ContourTally {
    /// Number of contours that are cut.
    pub cut: usize,
    /// Number of contours that the plan cuts.
    pub planned: usize,
    /// The contours that are left, each with the reason.
    pub left: Vec<LeftContour>,
    /// Names of the contours of the drawing that the plan does not cut, because the tool does not fit.
    pub unplanned: Vec<String>,
}

/// A contour that is not cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftContour {
    /// Number and title, such as `2 hole Ø 6.000`.
    pub name: String,
    /// Why it is left.
    pub why: WhyLeft,
}

/// Why a contour is not cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhyLeft {
    /// No contour job included it.
    NotBegun,
    /// It lies in a free space of its own: the tool has to start inside it.
    StartInside,
    /// It is cut in part.
    InPart,
    /// No link move outside the jogging clearance leads to it.
    NoLinkMove,
}

impl fmt::Display for WhyLeft {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotBegun => "not begun",
            Self::StartInside => "not begun: start with the tool inside it",
            Self::InPart => "cut in part",
            Self::NoLinkMove => "no link move leads to it: jog the tool to it",
        })
    }
}

impl ContourTally {
    /// The contours after the supervisor's progress.
    #[must_use]
    pub fn of(supervisor: &Supervisor) -> Self {
        let plan = supervisor.plan();
        let progress = supervisor.progress();
        let (planned, unplanned): (Vec<_>, Vec<_>) =
            plan.contours().iter().partition(|contour| !contour.loops.is_empty());
        let is_cut =
            |contour: &&PlannedContour| contour.loops.iter().all(|each| progress.has_finished(*each));
        let left: Vec<LeftContour> = planned
            .iter()
            .copied()
            .filter(|contour| !is_cut(contour))
            .map(|contour| LeftContour {
                name: contour.name.short(),
                why: why(contour, &progress, supervisor),
            })
            .collect();
        Self {
            cut: planned.len() - left.len(),
            planned: planned.len(),
            left,
            unplanned: unplanned
                .into_iter()
                .filter(|contour| contour.has_wall())
                .map(|contour| contour.name.short())
                .collect(),
        }
    }
}

fn why(contour: &PlannedContour, progress: &Progress, supervisor: &Supervisor) -> WhyLeft {
    let unreached = supervisor.unreached();
    let any = |has: &dyn Fn(LoopNumber) -> bool| contour.loops.iter().any(|&number| has(number));
    if any(&|number| {
        progress.partial.iter().any(|partial| partial.number == number) || progress.has_finished(number)
    }) {
        WhyLeft::InPart
    } else if any(&|number| unreached.contains(&number)) {
        WhyLeft::NoLinkMove
    } else if contour.name.role == ContourRole::Opening && supervisor.plan().plan.relief.is_none() {
        WhyLeft::StartInside
    } else {
        WhyLeft::NotBegun
    }
}

/// The contours of the plan for a table: name, place and length, fate.
#[must_use]
pub fn contour_rows(plan: &CertifiedPlan, progress: &Progress) -> Vec<[String; 3]> {
    let row = |contour: &PlannedContour| {
        let cut = contour.loops.iter().filter(|each| progress.has_finished(**each)).count();
        let in_part =
            contour.loops.iter().any(|each| progress.partial.iter().any(|partial| partial.number == *each));
        let fate = match (contour.loops.len(), cut) {
            (0, _) if !contour.has_wall() => "no wall".into(),
            (0, _) => "NOT CUT: the tool does not fit".into(),
            (all, cut) if all == cut && contour.reach.is_whole() => "cut".into(),
            (all, cut) if all == cut => {
                format!("cut, but for {:.3} mm beside rest material", contour.reach.left_mm)
            }
            (_, 0) if !in_part => "NOT CUT".into(),
            _ => "CUT IN PART".to_string(),
        };
        let name = &contour.name;
        let place =
            format!("at ({:.3}, {:.3}), {:.3} mm", name.middle_mm.x, name.middle_mm.y, name.length_mm);
        [name.short(), place, fate]
    };
    let mut rows: Vec<[String; 3]> = plan.contours().iter().take(ROWS).map(row).collect();
    if plan.contours().len() > ROWS {
        let more = plan.contours().len() - ROWS;
        rows.push([format!("… and {more} more"), String::new(), "see the outcome above".into()]);
    }
    rows
}

/// Largest number of contours of a table.
const ROWS: usize = 200;
/// Largest number of contours that a text lists.
const LISTED: usize = 8;

fn listed(names: impl ExactSizeIterator<Item = String>) -> String {
    let count = names.len();
    let mut all: Vec<String> = names.take(LISTED).collect();
    if count > LISTED {
        all.push(format!("… and {} more", count - LISTED));
    }
    all.join(", ")
}

impl ContourTally {
    /// The same words for a dry run, which traces the contours and cuts none.
    #[must_use]
    pub fn traced(&self) -> String {
        let Self { cut, planned, .. } = self;
        self.with_left(format!("DRY RUN, nothing is cut: {cut} of {planned} contours traced"))
    }

    /// The words, and the contours that are left or that the tool does not fit.
    fn with_left(&self, mut words: String) -> String {
        let Self { left, unplanned, .. } = self;
        if !left.is_empty() {
            let left = left.iter().map(|each| format!("{} ({})", each.name, each.why));
            words += &format!(". Left: {}", listed(left));
        }
        if !unplanned.is_empty() {
            words += &format!(". The tool does not fit: {}", listed(unplanned.iter().cloned()));
        }
        words
    }
}

impl fmt::Display for ContourTally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cut, planned, .. } = self;
        f.write_str(&self.with_left(format!("{cut} of {planned} contours cut")))
    }
}

impl JobOutcome {
    /// The outcome of a session that its operator ended. After a fault that was not recovered, it is the fault.
    #[must_use]
    pub fn by_operator(supervisor: &Supervisor) -> Self {
        let tally = ContourTally::of(supervisor);
        let in_contour = supervisor.is_interrupted() || !supervisor.progress().partial.is_empty();
        let none_new = supervisor.finished().len() == supervisor.finished_before();
        let ending = if let Some(fault) = supervisor.unrecovered() {
            Ending::Fault(fault.to_string())
        } else if tally.left.is_empty() {
            Ending::Complete
        } else if in_contour || none_new {
            Ending::Stopped
        } else {
            Ending::Incomplete
        };
        Self { ending, tally }
    }

    /// The outcome of a session with another ending.
    #[must_use]
    pub fn of(supervisor: &Supervisor, ending: Ending) -> Self {
        Self { ending, tally: ContourTally::of(supervisor) }
    }

    /// Whether every contour that the plan cuts is cut, without a fault.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.ending == Ending::Complete
    }

    /// Whether the operator ended the session, with or without contours that are left.
    #[must_use]
    pub fn is_by_operator(&self) -> bool {
        matches!(self.ending, Ending::Complete | Ending::Incomplete | Ending::Stopped)
    }

    /// Whether a contour is left because no link move leads to it.
    #[must_use]
    pub fn lacks_link_move(&self) -> bool {
        self.tally.left.iter().any(|left| left.why == WhyLeft::NoLinkMove)
    }

    /// The fault that ended the session.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        if let Ending::Fault(fault) = &self.ending { Some(fault) } else { None }
    }

    /// The exit code of the program.
    #[must_use]
    pub fn code(&self) -> u8 {
        match self.ending {
            Ending::Complete => 0,
            Ending::Fault(_) => 6,
            Ending::Incomplete | Ending::Stopped | Ending::TimeLimit | Ending::NotEnded(_) => 9,
        }
    }

    /// The ending in a word or two.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self.ending {
            Ending::Complete => "complete",
            Ending::Incomplete => "incomplete",
            Ending::Stopped => "stopped by the operator",
            Ending::TimeLimit => "stopped by the time limit",
            Ending::Fault(_) => "stopped by a fault",
            Ending::NotEnded(_) => "not ended",
        }
    }
}

impl fmt::Display for JobOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { ending, tally } = self;
        write!(f, "{}: ", self.word())?;
        match ending {
            Ending::Fault(fault) => write!(f, "{} ", fault.trim_end())?,
            Ending::NotEnded(phase) => {
                let phase =
                    phase.map_or("before its first phase".into(), |phase| format!("while {}", phase.words()));
                write!(f, "the program or the computer stopped {phase}. ")?;
            }
            Ending::Complete | Ending::Incomplete | Ending::Stopped | Ending::TimeLimit => {}
        }
        write!(f, "{tally}")
    }
}

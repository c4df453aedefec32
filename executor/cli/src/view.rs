//! The view of a run in a terminal. A machinist with gloves can read it from two metres.

mod canvas;
mod letters;
mod plan;

use keepout_planner::Mm2;
use std::sync::Arc;

use crate::shown_unit::ShownUnit;

pub use plan::ScreenOutline;

/// State of the machine, as the view's first line.
#[derive(Clone, Debug, PartialEq)]
pub enum Headline {
    /// The session connects, reads settings or homes.
    Starting,
    /// The operator jogs.
    Manual,
    /// The operator jogs, and the cycle is armed.
    Armed,
    /// The operator jogs, and the tool stands at the wall.
    AtTheWall,
    /// The operator jogs, and the tool stands at the soft limit.
    EndOfTravel,
    /// The program cuts the contour.
    Contouring {
        /// Share of the contour's motions that were sent, if known.
        percent: Option<u8>,
    },
    /// The tool stands inside the jogging clearance: only retract moves are possible.
    Retracting,
    /// The tool stands at the wall, and the program plans the contour.
    Touching,
    /// Feed hold: the tool runs to the end of the queued motions, and then waits.
    Pausing,
    /// Feed hold: the tool is at rest, and waits for cycle start.
    Paused,
    /// The tool comes to rest.
    Stopping,
    /// The session ended as the operator wanted.
    Done,
    /// A fault stopped the session.
    Stopped {
        /// The cause.
        reason: String,
        /// The action that the operator can take. Empty if the fault names none.
        remedy: String,
    },
}

/// Urgency of a headline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Normal state.
    Calm,
    /// The operator should look.
    Alert,
    /// Fault.
    Alarm,
}

impl Headline {
    /// The headline of a fault. The fault's message is one sentence with the reason, then the remedy.
    pub fn stopped(fault: &str) -> Self {
        let (reason, remedy) = fault.split_once(". ").unwrap_or((fault, ""));
        Self::Stopped { reason: reason.trim_end_matches('.').into(), remedy: remedy.into() }
    }

    /// Urgency of the headline.
    pub fn tone(&self) -> Tone {
        match self {
            Self::Stopped { .. } | Self::Armed => Tone::Alarm,
            Self::AtTheWall
            | Self::EndOfTravel
            | Self::Retracting
            | Self::Pausing
            | Self::Paused
            | Self::Stopping => Tone::Alert,
            Self::Starting | Self::Manual | Self::Touching | Self::Contouring { .. } | Self::Done => {
                Tone::Calm
            }
        }
    }

    fn words(&self) -> String {
        match self {
            Self::Starting => "STARTING".into(),
            Self::Manual => "MANUAL".into(),
            Self::Armed => "ARMED - TOUCH".into(),
            Self::AtTheWall => "AT THE WALL".into(),
            Self::EndOfTravel => "END OF TRAVEL".into(),
            Self::Contouring { percent: Some(percent) } => format!("CONTOURING {percent} %"),
            Self::Contouring { percent: None } => "CONTOURING".into(),
            Self::Retracting => "LEAVE THE PART".into(),
            Self::Touching => "TOUCHED".into(),
            Self::Pausing => "PAUSING".into(),
            Self::Paused => "PAUSED".into(),
            Self::Stopping => "STOPPING".into(),
            Self::Done => "ENDED".into(),
            Self::Stopped { .. } => "STOPPED".into(),
        }
    }
}

/// Content of the view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewFacts {
    /// State of the machine.
    pub headline: Headline,
    /// The tool's centre, drawing coordinates, mm.
    pub position_mm: Option<Mm2>,
    /// The height of the tool's tip, drawing coordinates, mm. `None` for a plan for two axes.
    pub height_mm: Option<f64>,
    /// Distance from the tool's centre to the wall, mm. It is 0 at the wall.
    pub wall_mm: Option<f64>,
    /// Unit in which lengths are shown.
    pub unit: ShownUnit,
    /// Speed of the tool, mm/s.
    pub speed_mm_s: Option<f64>,
    /// The tool's radius, mm.
    pub tool_radius_mm: f64,
    /// Outlines of the part and of the keep-out zones.
    pub outline: Arc<ScreenOutline>,
    /// Past positions of the tool's centre, oldest first, drawing coordinates, mm.
    pub trail: Vec<Mm2>,
    /// Status line of the operator's device: speed or step size.
    pub status: String,
    /// The last notices, oldest first.
    pub notices: Vec<String>,
    /// The contours that are cut and left, such as `1 of 5 contours cut. Left: …`.
    pub tally: String,
    /// Explanation of the keys, if the operator requests it.
    pub help: &'static [&'static str],
    /// Line that explains the keys.
    pub keys: String,
    /// Time since the start of the session, s.
    pub seconds: f64,
}

/// Smallest size of the view with large letters, columns and lines.
const LARGE: (usize, usize) = (76, 22);
/// Columns of the figures beside the plan, in the view with large letters.
const FIGURES: usize = 44;
/// Columns of the figures in the view with small letters.
const SMALL_FIGURES: usize = 20;

/// Draws the view: exactly `height` lines, each at most `width` columns wide.
pub fn draw(facts: &ViewFacts, width: usize, height: usize) -> Vec<String> {
    let mut lines = if width >= LARGE.0 && height >= LARGE.1 {
        large_view(facts, width, height)
    } else {
        small_view(facts, width, height)
    };
    lines.resize(height, String::new());
    lines.into_iter().map(|line| cut(&line, width)).collect()
}

/// Number of lines that the headline takes at the top.
pub fn headline_lines(width: usize, height: usize) -> usize {
    if width >= LARGE.0 && height >= LARGE.1 { 3 } else { 1 }
}

fn large_view(facts: &ViewFacts, width: usize, height: usize) -> Vec<String> {
    let words = facts.headline.words();
    let mut lines =
        letters::large(&words, width).map_or(vec![words, String::new(), String::new()], Vec::from);
    lines.extend(explained(&facts.headline, width));
    lines.push("─".repeat(width));
    // Five lines follow the figures and the plan: a rule, the contours, two notices, the keys.
    let body = height.saturating_sub(lines.len() + 5);
    if facts.help.is_empty() {
        let figures = large_figures(facts, body);
        let plan = plan_of(facts, width - FIGURES, body);
        lines.extend(beside(&figures, &plan, FIGURES));
    } else {
        let help = facts.help.iter().map(ToString::to_string).chain(std::iter::repeat(String::new()));
        lines.extend(help.take(body));
    }
    lines.push("─".repeat(width));
    lines.push(plain(&facts.tally));
    let notices = last_notices(facts, 2);
    lines.extend((0..2).map(|index| notices.get(index).cloned().unwrap_or_default()));
    lines.push(facts.keys.clone());
    lines
}

fn small_view(facts: &ViewFacts, width: usize, height: usize) -> Vec<String> {
    let mut lines = vec![facts.headline.words()];
    lines.extend(explained(&facts.headline, width));
    let body = height.saturating_sub(lines.len() + 2);
    let place = [format!("X {}", position(facts, |at| at.x)), format!("Y {}", position(facts, |at| at.y))];
    let height = facts.height_mm.map(|_| format!("Z {}", height_of(facts)));
    let rest = [
        format!("wall {:>8} {}", distance(facts), facts.unit.symbol()),
        speed(facts),
        facts.status.clone(),
        clock(facts.seconds),
    ];
    let figures = place.into_iter().chain(height).chain(rest);
    let figures: Vec<String> = figures.take(body).map(|line| cut(&line, SMALL_FIGURES)).collect();
    if facts.help.is_empty() {
        let plan = plan_of(facts, width.saturating_sub(SMALL_FIGURES + 1), body);
        lines.extend(beside(&figures, &plan, SMALL_FIGURES + 1));
    } else {
        let help = facts.help.iter().map(ToString::to_string).chain(std::iter::repeat(String::new()));
        lines.extend(help.take(body));
    }
    lines.extend(last_notices(facts, 1).into_iter().chain([String::new()]).take(1));
    lines.push(facts.keys.clone());
    lines
}

/// Reason and remedy of a fault, in at most four lines together.
fn explained(headline: &Headline, width: usize) -> Vec<String> {
    let Headline::Stopped { reason, remedy } = headline else { return Vec::new() };
    [reason, remedy].into_iter().flat_map(|text| wrapped(&plain(text), width)).take(4).collect()
}

/// The figures in at most `room` lines, the most important first: position, wall, then single lines.
fn large_figures(facts: &ViewFacts, room: usize) -> Vec<String> {
    let big = |label: &str, value: &str| -> Vec<String> {
        let rows = letters::large(value, FIGURES - 6).unwrap_or([String::new(), value.into(), String::new()]);
        let labels = ["", label, ""];
        rows.iter().zip(labels).map(|(row, label)| format!("{label:<5}{row}").trim_end().into()).collect()
    };
    let mut lines = big("X", &position(facts, |at| at.x));
    lines.push(String::new());
    lines.extend(big("Y", &position(facts, |at| at.y)));
    lines.push(String::new());
    lines.extend(big("WALL", &format!("{:>9}", distance(facts))));
    let unit = if facts.unit == ShownUnit::Inch { " · lengths in inches" } else { "" };
    let height = facts
        .height_mm
        .map_or(String::new(), |_| format!("Z {} {}", height_of(facts).trim(), facts.unit.symbol()));
    let rest = [height, speed(facts), facts.status.clone(), clock(facts.seconds) + unit];
    let rest = rest.into_iter().filter(|line| !line.is_empty());
    let rest: Vec<String> = rest.collect();
    if lines.len() + rest.len() < room {
        lines.push(String::new());
    }
    lines.extend(rest.into_iter().map(|line| format!("{:<5}{line}", "")));
    lines.truncate(room);
    lines
}

fn plan_of(facts: &ViewFacts, columns: usize, lines: usize) -> Vec<String> {
    let tool = facts.position_mm.map(|at| (at, facts.tool_radius_mm));
    plan::plan(&facts.outline, &facts.trail, tool, columns, lines)
}

fn position(facts: &ViewFacts, axis: fn(Mm2) -> f64) -> String {
    match facts.position_mm.map(axis) {
        Some(mm) if mm.abs() < 99_999.0 => format!("{:>9}", facts.unit.figure(mm)),
        _ => format!("{:>9}", "---"),
    }
}

fn height_of(facts: &ViewFacts) -> String {
    match facts.height_mm {
        Some(mm) if mm.abs() < 99_999.0 => format!("{:>9}", facts.unit.figure(mm)),
        _ => format!("{:>9}", "---"),
    }
}

fn distance(facts: &ViewFacts) -> String {
    match facts.wall_mm {
        Some(mm) if (0.0..99_999.0).contains(&mm) => facts.unit.figure(mm),
        _ => "---".into(),
    }
}

fn speed(facts: &ViewFacts) -> String {
    match facts.speed_mm_s {
        Some(speed) if speed.is_finite() => format!("moving {}", facts.unit.speed(speed)),
        _ => "moving ---".into(),
    }
}

fn clock(seconds: f64) -> String {
    let whole = keepout_kernel::curve::round_down(seconds.clamp(0.0, 1e9));
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    format!("time {hours}:{minutes:02}:{seconds:02}")
}

fn last_notices(facts: &ViewFacts, count: usize) -> Vec<String> {
    let from = facts.notices.len().saturating_sub(count);
    facts.notices[from..].iter().map(|notice| format!("• {}", plain(notice))).collect()
}

/// Puts two blocks of lines side by side. The second begins at column `at`.
fn beside(left: &[String], right: &[String], at: usize) -> Vec<String> {
    (0..left.len().max(right.len()))
        .map(|index| {
            let text = left.get(index).map_or("", String::as_str);
            let pad = " ".repeat(at.saturating_sub(text.chars().count()));
            let beside = right.get(index).map_or("", String::as_str);
            format!("{text}{pad}{beside}").trim_end().into()
        })
        .collect()
}

/// The text with `?` in place of control characters, invisible characters and characters wider than a column.
fn plain(text: &str) -> String {
    let narrow =
        |c: char| !c.is_control() && (u32::from(c) < 0x300 || (0x2000..0x2bff).contains(&u32::from(c)));
    let hidden = |c: char| (0x200b..=0x206f).contains(&u32::from(c)) && !matches!(c, '\u{2010}'..='\u{2027}');
    text.chars().map(|c| if narrow(c) && !hidden(c) { c } else { '?' }).collect()
}

/// Breaks the text at spaces into lines of at most `width` columns. A longer word keeps its length.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

/// The text in at most `width` columns. An ellipsis marks a cut.
fn cut(text: &str, width: usize) -> String {
    let text = plain(text);
    if text.chars().count() <= width {
        return text;
    }
    let mut kept: String = text.chars().take(width.saturating_sub(1)).collect();
    kept.extend((width > 0).then_some('…'));
    kept
}

#[cfg(test)]
mod tests;

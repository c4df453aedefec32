//! The display of a run while it takes place.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};
use keepout_executor::operator::Panel;
use keepout_executor::session::outcome::ContourTally;
use keepout_executor::supervisor::{Phase, Supervisor};
use keepout_guard::Time;
use keepout_planner::Mm3;
use keepout_planner::units::place_mm;

use super::RunArguments;
use super::operator_setup::HELP;
use super::screen::Screen;
use super::shown_unit::ShownUnit;

/// The contours that are cut and left, in words. Computed anew only when a contour is finished.
pub struct TallyLine {
    dry_run: bool,
    finished: Option<usize>,
    words: String,
}

impl TallyLine {
    pub fn new(dry_run: bool) -> Self {
        Self { dry_run, finished: None, words: String::new() }
    }

    /// The contours after the supervisor's progress.
    pub fn of(&mut self, supervisor: &Supervisor) -> &str {
        let finished = supervisor.finished().len();
        if self.finished != Some(finished) {
            self.finished = Some(finished);
            let tally = ContourTally::of(supervisor);
            self.words = if self.dry_run { tally.traced() } else { tally.to_string() };
        }
        &self.words
    }
}

/// The view, or one line with the state of the run. Without the view, every phase, notice and fault is a line of
/// the error output. The line with the state is hidden if the error output is not a terminal.
pub struct Display {
    bar: ProgressBar,
    screen: Option<Screen>,
    panel: Panel,
    unit: ShownUnit,
    tally: TallyLine,
    phase: Option<Phase>,
    finished: usize,
    /// Numbers of notices taken from the panel and from the supervisor.
    taken: (usize, usize),
    helped: bool,
}

impl Display {
    pub fn new(screen: Option<Screen>, panel: Panel, arguments: &RunArguments) -> Self {
        let line = screen.is_none() && std::io::stderr().is_terminal();
        let bar = if line { ProgressBar::new_spinner() } else { ProgressBar::hidden() };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
            bar.set_style(style);
        }
        let (tally, taken) = (TallyLine::new(arguments.dry_run), (0, 0));
        let unit = arguments.display();
        Self { bar, screen, panel, unit, tally, phase: None, finished: 0, taken, helped: false }
    }

    pub fn show(&mut self, supervisor: &Supervisor, closest_mm: Option<f64>, now: Time) {
        if let Some(screen) = &mut self.screen {
            screen.show(supervisor, now);
            return;
        }
        self.tell(supervisor, now);
        if self.bar.is_hidden() || !(now.micros() / 1000).is_multiple_of(100) {
            return;
        }
        let deep = supervisor.plan().plan.relief.is_some();
        let position = supervisor.position().map_or("position unknown".into(), |place| {
            let Mm3 { x, y, z } = place_mm(place);
            let (x, y) = (self.unit.figure(x), self.unit.figure(y));
            let z = if deep { format!("  z {:>8}", self.unit.figure(z)) } else { String::new() };
            format!("x {x:>9}  y {y:>9}{z} {}", self.unit.symbol())
        });
        let progress = supervisor
            .guard()
            .contour_progress()
            .map_or(String::new(), |(sent, all)| format!("  motion {sent}/{all}"));
        let closest = closest_mm
            .map_or(String::new(), |mm| format!("  closest {} {}", self.unit.figure(mm), self.unit.symbol()));
        let armed = if supervisor.is_armed() { "  ARMED: a touch starts the contour" } else { "" };
        self.bar.set_message(format!(
            "{:7.1} s  {}  {position}{progress}{closest}{armed}  {}",
            now.elapsed().as_secs_f64(),
            supervisor.phase().words(),
            self.panel.status()
        ));
        self.bar.tick();
    }

    /// Tells new phases, notices, faults and finished contours, each in a line.
    fn tell(&mut self, supervisor: &Supervisor, now: Time) {
        let mut lines = Vec::new();
        let phase = supervisor.phase();
        if self.phase != Some(phase) {
            // Sliding along the wall and back is no news.
            let steered = |phase: Phase| matches!(phase, Phase::Manual | Phase::Sliding);
            let news = !(steered(phase) && self.phase.is_some_and(steered));
            self.phase = Some(phase);
            // Without a terminal, only news that the reader must act on is printed.
            if news && !self.bar.is_hidden() {
                lines.push(phase.words().to_string());
            }
            lines.extend(supervisor.fault().map(|fault| format!("STOPPED: {fault}")));
        }
        let (new, count) = self.panel.since(self.taken.0);
        lines.extend(new);
        lines.extend(supervisor.notices().iter().skip(self.taken.1).map(ToString::to_string));
        self.taken = (count, supervisor.notices().len());
        if supervisor.finished().len() != self.finished {
            self.finished = supervisor.finished().len();
            lines.push(self.tally.of(supervisor).to_string());
        }
        if self.panel.help() != self.helped {
            self.helped = self.panel.help();
            lines.extend(HELP.iter().filter(|_| self.helped).map(ToString::to_string));
        }
        for line in lines {
            self.line(&format!("{:7.1} s  {line}", now.elapsed().as_secs_f64()));
        }
    }

    fn line(&self, line: &str) {
        if self.bar.is_hidden() {
            // In raw mode a line break does not return to the first column. A closed output is no fault of the run.
            let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("{line}\r\n"));
        } else {
            self.bar.println(line);
        }
    }

    pub fn finish(self) {
        self.bar.finish_and_clear();
        let viewed = self.screen.is_some();
        drop(self.screen);
        // The operator can outlive the display. The notices need the restored terminal now.
        crate::input::terminal::restore();
        for notice in self.panel.notices().iter().filter(|_| viewed) {
            let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("{notice}\n"));
        }
    }
}

//! The display of a run while it takes place.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};
use keepout_executor::operator::Panel;
use keepout_executor::supervisor::Supervisor;
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::units::point_mm;

use super::screen::Screen;

/// The view, or one line with the state of the run. The line is hidden if the error output is not a terminal.
pub struct Display {
    bar: ProgressBar,
    screen: Option<Screen>,
    panel: Panel,
}

impl Display {
    pub fn new(screen: Option<Screen>, panel: Panel) -> Self {
        let line = screen.is_none() && std::io::stderr().is_terminal();
        let bar = if line { ProgressBar::new_spinner() } else { ProgressBar::hidden() };
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
            bar.set_style(style);
        }
        Self { bar, screen, panel }
    }

    pub fn show(&mut self, supervisor: &Supervisor, closest_mm: Option<f64>, now: Time) {
        if let Some(screen) = &mut self.screen {
            screen.show(supervisor, now);
        }
        if self.bar.is_hidden() || !(now.micros() / 1000).is_multiple_of(100) {
            return;
        }
        let position = supervisor.position().map_or("position unknown".into(), |point| {
            let Mm2 { x, y } = point_mm(point);
            format!("x {x:9.3}  y {y:9.3} mm")
        });
        let progress = supervisor
            .guard()
            .contour_progress()
            .map_or(String::new(), |(sent, all)| format!("  motion {sent}/{all}"));
        let closest = closest_mm.map_or(String::new(), |mm| format!("  closest {mm:.4} mm"));
        self.bar.set_message(format!(
            "{:7.1} s  {:?}  {position}{progress}{closest}",
            now.elapsed().as_secs_f64(),
            supervisor.phase()
        ));
        self.bar.tick();
    }

    pub fn finish(self) {
        self.bar.finish_and_clear();
        drop(self.screen);
        // The operator can outlive the display. The notices need the restored terminal now.
        crate::input::terminal::restore();
        for notice in self.panel.notices() {
            eprintln!("{notice}");
        }
    }
}

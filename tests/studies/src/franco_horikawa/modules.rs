//! What the paper's controller moves: a controller that runs linear motions in sequence, and tables that follow with a
//! lag; or the simulated modules that Keepout moves.

use std::collections::VecDeque;
use std::fmt;

use keepout_drives::interpolator::{Drives, QueuedMotion};
use keepout_drives::profile::DriveProfile;
use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;
use keepout_sim::{PositioningError, ServoDrive};

/// Time step of the simulation, s.
pub const STEP_S: f64 = 0.001;
/// Distance from the target at which the table counts as in position, mm.
const ARRIVED_MM: f64 = 1e-4;

/// Distance from the target at which the simulated modules count as in position, mm: their positioning error, and what
/// the drives still correct.
const IN_POSITION_MM: f64 = 0.03;
/// Junction deviation of the simulated controller, mm.
const JUNCTION_MM: f64 = 0.01;
/// Shortest motion of the simulated controller, mm.
const SHORTEST_MM: f64 = 1e-9;

/// Two modules and their controller, as the paper's controller commands them.
pub trait Tables: fmt::Debug {
    /// Position of the tool, mm.
    fn tool(&self) -> Mm2;
    /// Number of unfinished motions.
    fn queued(&self) -> usize;
    /// Whether the tables are in position and the queue is empty.
    fn rests(&self) -> bool;
    /// Queues a motion by `by` from the end of the last motion, mm.
    fn go(&mut self, by: Mm2);
    /// Drops the queued motions. The current motion ends at once if the stop `cuts` it, otherwise at its target.
    fn stop(&mut self, cuts: bool);
    /// Advances by one time step, [`STEP_S`].
    fn step(&mut self);
}

/// Two modules that follow with a lag.
#[derive(Clone, Debug)]
pub struct Modules {
    commanded: Mm2,
    tool: Mm2,
    targets: VecDeque<Mm2>,
    feed_mm_s: f64,
    /// Share of the remaining distance that the table covers in a step.
    follows: f64,
}

impl Modules {
    /// Modules at rest.
    #[must_use]
    pub fn new(at: Mm2, feed_mm_s: f64, inertia_s: f64) -> Self {
        let follows = follows(inertia_s);
        Self { commanded: at, tool: at, targets: VecDeque::new(), feed_mm_s, follows }
    }
}

impl Tables for Modules {
    fn tool(&self) -> Mm2 {
        self.tool
    }

    fn queued(&self) -> usize {
        self.targets.len()
    }

    fn rests(&self) -> bool {
        self.targets.is_empty() && self.tool.distance(self.commanded) < ARRIVED_MM
    }

    fn go(&mut self, by: Mm2) {
        let from = self.targets.back().copied().unwrap_or(self.commanded);
        self.targets.push_back(from + by);
    }

    fn stop(&mut self, cuts: bool) {
        self.targets.truncate(usize::from(!cuts));
    }

    fn step(&mut self) {
        let mut left = self.feed_mm_s * STEP_S;
        while let Some(&target) = self.targets.front() {
            let far = self.commanded.distance(target);
            if far > left {
                let share = left / far;
                self.commanded += (target - self.commanded) * share;
                break;
            }
            self.commanded = target;
            self.targets.pop_front();
            left -= far;
        }
        self.tool += (self.commanded - self.tool) * self.follows;
    }
}

/// The simulated modules of Keepout's sessions: an interpolator that accelerates and brakes on the path, feed drives
/// that follow it, and a positioning error.
#[derive(Debug)]
pub struct SimulatedModules {
    motion: QueuedMotion,
    drive: Option<ServoDrive>,
    error: PositioningError,
    feed_mm_s: f64,
    steps: u64,
    moved: Vec<Sample>,
    tool: Mm2,
}

impl SimulatedModules {
    /// Modules at rest.
    #[must_use]
    pub fn new(at: Mm2, feed_mm_s: f64, machine: &MachineProfile, drives: &DriveProfile, seed: u64) -> Self {
        let rates = Drives::of(machine, JUNCTION_MM);
        Self {
            motion: QueuedMotion::new(rates, at.at_height(0.0)),
            drive: ServoDrive::new(drives, at),
            error: PositioningError::wandering(machine.repeatability_mm, machine.steps_per_mm, seed),
            feed_mm_s,
            steps: 0,
            moved: Vec::new(),
            tool: at,
        }
    }
}

impl Tables for SimulatedModules {
    fn tool(&self) -> Mm2 {
        self.tool
    }

    fn queued(&self) -> usize {
        self.motion.queued()
    }

    fn rests(&self) -> bool {
        self.motion.is_resting() && self.tool.distance(self.motion.position().plane()) < IN_POSITION_MM
    }

    fn go(&mut self, by: Mm2) {
        let to = self.motion.planned_end().plane() + by;
        self.motion.push(to.at_height(0.0), self.feed_mm_s, SHORTEST_MM);
    }

    /// A stop always cuts: the controller brakes on the path.
    fn stop(&mut self, _: bool) {
        if self.motion.queued() > 0 {
            self.motion.cancel();
        }
    }

    fn step(&mut self) {
        self.motion.advance(STEP_S, |_, _| {});
        self.steps += 1;
        let at = Time::from_micros(self.steps * 1000);
        let kind = if self.motion.is_resting() { SampleKind::Rest } else { SampleKind::Jog };
        let commanded = Sample { at, position_mm: self.motion.position(), kind };
        match &mut self.drive {
            Some(drive) => drive.follow(&commanded, &mut self.moved),
            None => self.moved.push(commanded),
        }
        for mut sample in self.moved.drain(..) {
            self.error.apply(&mut sample);
            self.tool = sample.position_mm.plane();
        }
    }
}

/// Share of the remaining distance that a table with this time constant covers in a step.
#[must_use]
pub fn follows(inertia_s: f64) -> f64 {
    if inertia_s > 0.0 { 1.0 - (-STEP_S / inertia_s).exp() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(modules: &mut Modules, count: usize) {
        (0..count).for_each(|_| modules.step());
    }

    #[test]
    fn motions_run_in_sequence_at_the_feed() {
        let mut modules = Modules::new(Mm2::new(0.0, 0.0), 12.0, 0.0);
        modules.go(Mm2::new(3.0, 0.0));
        modules.go(Mm2::new(0.0, 4.0));
        steps(&mut modules, 500);
        assert!(modules.tool().distance(Mm2::new(3.0, 3.0)) < 1e-9 && modules.queued() == 1);
        steps(&mut modules, 100);
        assert!(modules.tool().distance(Mm2::new(3.0, 4.0)) < 1e-9 && modules.rests());
    }

    #[test]
    fn stop_cuts_the_current_motion_or_lets_it_end() {
        for (cuts, end) in [(true, 1.2), (false, 3.0)] {
            let mut modules = Modules::new(Mm2::new(0.0, 0.0), 12.0, 0.0);
            (0..3).for_each(|_| modules.go(Mm2::new(3.0, 0.0)));
            steps(&mut modules, 100);
            modules.stop(cuts);
            steps(&mut modules, 1000);
            assert!(modules.tool().distance(Mm2::new(end, 0.0)) < 1e-9, "{:?}", modules.tool());
        }
    }

    /// In motion, the lag is the feed times the time constant.
    #[test]
    fn table_follows_with_a_lag() {
        let mut modules = Modules::new(Mm2::new(0.0, 0.0), 10.0, 0.05);
        modules.go(Mm2::new(10.0, 0.0));
        steps(&mut modules, 900);
        assert!((9.0 - modules.tool().x - 0.5).abs() < 0.01, "{:?}", modules.tool());
        steps(&mut modules, 100);
        assert!(!modules.rests());
        steps(&mut modules, 1000);
        assert!(modules.rests() && modules.tool().distance(Mm2::new(10.0, 0.0)) < 1e-3);
    }

    /// On the simulated modules a stop takes the braking distance, on the line, and the tool is where Keepout's is.
    #[test]
    fn simulated_modules_brake_on_the_line() {
        let machine = super::super::scenario::machine(12.0).unwrap();
        let drives = super::super::scenario::driven_modules().unwrap();
        let at = Mm2::new(100.0, 50.0);
        let mut modules = SimulatedModules::new(at, 12.0, &machine, &drives, 3);
        modules.go(Mm2::new(3.0, 4.0));
        modules.go(Mm2::new(30.0, 40.0));
        (0..1000).for_each(|_| modules.step());
        assert!(modules.queued() == 1 && !modules.rests());
        modules.stop(true);
        (0..500).for_each(|_| modules.step());
        let way = modules.tool() - at;
        // A second at 12 mm/s, less the acceleration and the delay of the drives, and 0.12 mm of braking.
        assert!(modules.rests() && (way.length() - 12.0).abs() < 0.2, "{way:?}");
        assert!((way.cross(Mm2::new(0.6, 0.8))).abs() < 0.03, "{way:?}");
    }
}

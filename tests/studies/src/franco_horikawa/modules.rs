//! The paper's modules: a controller that runs linear motions in sequence, and tables that follow with a lag.

use std::collections::VecDeque;

use keepout_planner::Mm2;

/// Time step of the simulation, s.
pub const STEP_S: f64 = 0.001;
/// Distance from the target at which the table counts as in position, mm.
const ARRIVED_MM: f64 = 1e-4;

/// Two modules and their controller.
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

    /// Position of the tool, mm.
    #[must_use]
    pub fn tool(&self) -> Mm2 {
        self.tool
    }

    /// Number of unfinished motions.
    #[must_use]
    pub fn queued(&self) -> usize {
        self.targets.len()
    }

    /// Whether the table is in position and the queue is empty.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.targets.is_empty() && self.tool.distance(self.commanded) < ARRIVED_MM
    }

    /// Queues a motion by `by` from the end of the last motion, mm.
    pub fn go(&mut self, by: Mm2) {
        let from = self.targets.back().copied().unwrap_or(self.commanded);
        self.targets.push_back(from + by);
    }

    /// Drops the queued motions. The current motion ends at once if the stop `cuts` it, otherwise at its
    /// target.
    pub fn stop(&mut self, cuts: bool) {
        self.targets.truncate(usize::from(!cuts));
    }

    /// Advances by one time step.
    pub fn step(&mut self) {
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
}

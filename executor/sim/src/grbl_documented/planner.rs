//! The planner: blocks between rest and rest, with speeds that every axis can follow.
//!
//! Each block starts and ends at a speed from which the motions after it can still stop at the end of the
//! queue. The speed at a corner follows from the junction deviation `$11`: the tool takes a corner as if it ran on a
//! circle that passes the corner at this distance.

use std::collections::VecDeque;

use super::axes::{StepPlace, Triple, each, length, to_steps};
use super::parser::BlockFeed;
use super::settings::EepromContent;

/// Usable blocks.
pub(super) const BLOCKS: usize = 15;

/// The figures of the axes, from the settings.
#[derive(Clone, Debug)]
pub(super) struct AxisLimits {
    pub steps_per_mm: Triple,
    rate_mm_s: Triple,
    acceleration: Triple,
    junction_mm: f64,
}

impl AxisLimits {
    /// The figures in the settings.
    pub fn of(eeprom: &EepromContent) -> Self {
        let rate = eeprom.axes(110);
        Self {
            steps_per_mm: eeprom.axes(100),
            rate_mm_s: each(|axis| rate[axis] / 60.0),
            acceleration: eeprom.axes(120),
            junction_mm: eeprom.value(11),
        }
    }

    /// The largest value along a direction that keeps every axis within its limit.
    fn along(limit: Triple, unit: Triple) -> f64 {
        let shares = (0..3).filter(|&axis| unit[axis] != 0.0).map(|axis| limit[axis] / unit[axis].abs());
        shares.fold(f64::INFINITY, f64::min)
    }

    /// The square of the largest speed at the corner between two directions.
    fn corner_2(&self, before: Triple, after: Triple) -> f64 {
        let cosine = -(0..3).map(|axis| before[axis] * after[axis]).sum::<f64>();
        if cosine > 0.999_999 {
            return 0.0;
        }
        if cosine < -0.999_999 {
            return f64::INFINITY;
        }
        let turn = each(|axis| after[axis] - before[axis]);
        let span = length(turn);
        let acceleration = Self::along(self.acceleration, each(|axis| turn[axis] / span));
        let sine = (0.5 * (1.0 - cosine)).sqrt();
        acceleration * self.junction_mm * sine / (1.0 - sine)
    }
}

/// Overrides of feed and rapid rate, as factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RateOverrides {
    pub feed: f64,
    pub rapid: f64,
}

/// A straight motion in the planner.
#[derive(Clone, Debug)]
pub(super) struct PlannedMotion {
    pub from: StepPlace,
    pub to: StepPlace,
    pub jog: bool,
    pub length_mm: f64,
    pub acceleration: f64,
    /// Speed without acceleration limits, mm/s.
    pub nominal: f64,
    feed: BlockFeed,
    rate: f64,
    corner_2: f64,
    /// Square of the greatest speed at its start.
    limit_2: f64,
    /// Square of the planned speed at its start.
    entry_2: f64,
}

/// The queue of motions, and how far the first one has been handed on.
#[derive(Clone, Debug)]
pub(super) struct MotionPlanner {
    limits: AxisLimits,
    overrides: RateOverrides,
    pub blocks: VecDeque<PlannedMotion>,
    /// Distance of the first block that has been handed on, mm, and the speed there.
    pub done_mm: f64,
    pub speed: f64,
    end: StepPlace,
    last_unit: Triple,
    last_nominal: f64,
}

impl MotionPlanner {
    /// An empty queue, with the tool at rest.
    pub fn new(limits: AxisLimits, at: StepPlace) -> Self {
        Self {
            limits,
            overrides: RateOverrides { feed: 1.0, rapid: 1.0 },
            blocks: VecDeque::new(),
            done_mm: 0.0,
            speed: 0.0,
            end: at,
            last_unit: [0.0; 3],
            last_nominal: 0.0,
        }
    }

    pub fn steps_per_mm(&self) -> Triple {
        self.limits.steps_per_mm
    }

    pub fn set_limits(&mut self, limits: AxisLimits) {
        self.limits = limits;
    }

    /// Empties the queue. The next motion starts at this place.
    pub fn empty_at(&mut self, at: StepPlace) {
        self.blocks.clear();
        (self.end, self.done_mm, self.speed) = (at, 0.0, 0.0);
    }

    pub fn is_full(&self) -> bool {
        self.blocks.len() >= BLOCKS
    }

    /// Adds a motion. Returns whether it has a length: a motion without a step is dropped.
    pub fn add(&mut self, target_mm: Triple, feed: BlockFeed, jog: bool) -> bool {
        let to = to_steps(target_mm, self.limits.steps_per_mm);
        let from = self.end;
        let way = each(|axis| f64::from(to[axis] - from[axis]) / self.limits.steps_per_mm[axis]);
        let length_mm = length(way);
        if length_mm == 0.0 {
            return false;
        }
        let unit = each(|axis| way[axis] / length_mm);
        let corner_2 = if self.blocks.is_empty() { 0.0 } else { self.limits.corner_2(self.last_unit, unit) };
        let mut block = PlannedMotion {
            from,
            to,
            jog,
            length_mm,
            acceleration: AxisLimits::along(self.limits.acceleration, unit),
            nominal: 0.0,
            feed,
            rate: AxisLimits::along(self.limits.rate_mm_s, unit),
            corner_2,
            limit_2: 0.0,
            entry_2: 0.0,
        };
        block.set_rate(self.overrides);
        block.limit_2 = corner_2.min(block.nominal.powi(2)).min(self.last_nominal.powi(2));
        (self.end, self.last_unit, self.last_nominal) = (to, unit, block.nominal);
        self.blocks.push_back(block);
        self.replan();
        true
    }

    /// Applies other overrides to all motions in the queue.
    pub fn set_overrides(&mut self, overrides: RateOverrides) {
        self.overrides = overrides;
        let mut before = f64::INFINITY;
        for block in &mut self.blocks {
            block.set_rate(overrides);
            block.limit_2 = block.corner_2.min(block.nominal.powi(2)).min(f64::powi(before, 2));
            before = block.nominal;
        }
        if let Some(last) = self.blocks.back() {
            self.last_nominal = last.nominal;
        }
        self.replan();
    }

    /// Plans the speeds again: backward from rest at the end, then forward from the present speed.
    pub fn replan(&mut self) {
        let mut exit_2 = 0.0;
        for block in self.blocks.iter_mut().skip(1).rev() {
            block.entry_2 = block.limit_2.min(exit_2 + 2.0 * block.acceleration * block.length_mm);
            exit_2 = block.entry_2;
        }
        let mut before_2 = self.speed * self.speed;
        let mut done_mm = self.done_mm;
        for index in 0..self.blocks.len() {
            let block = &mut self.blocks[index];
            if index > 0 {
                block.entry_2 = block.entry_2.min(before_2);
                before_2 = block.entry_2;
            }
            before_2 += 2.0 * block.acceleration * (block.length_mm - done_mm);
            done_mm = 0.0;
        }
    }

    /// Square of the speed at the end of the first block.
    pub fn exit_2(&self) -> f64 {
        self.blocks.get(1).map_or(0.0, |next| next.entry_2)
    }

    /// Hands the first block on completely: it leaves the queue.
    pub fn leave(&mut self) {
        self.blocks.pop_front();
        self.done_mm = 0.0;
    }
}

impl PlannedMotion {
    /// The place after this distance, in whole steps.
    pub fn place(&self, done_mm: f64) -> StepPlace {
        let share = (done_mm / self.length_mm).clamp(0.0, 1.0);
        [0, 1, 2].map(|axis| {
            let way = f64::from(self.to[axis] - self.from[axis]);
            self.from[axis] + super::axes::whole_steps(way * share)
        })
    }

    fn set_rate(&mut self, overrides: RateOverrides) {
        let wanted = match self.feed {
            BlockFeed::Rapid => self.rate * overrides.rapid,
            // Overrides do not change jogs.
            BlockFeed::PerMinute(feed) if self.jog => feed / 60.0,
            BlockFeed::PerMinute(feed) => feed / 60.0 * overrides.feed,
            BlockFeed::Inverse(minutes) => self.length_mm * minutes / 60.0 * overrides.feed,
        };
        self.nominal = wanted.min(self.rate).max(LEAST_SPEED);
    }
}

/// Least speed of a motion, mm/s.
const LEAST_SPEED: f64 = 1.0 / 60.0;

//! The step generator: it takes motions out of the planner in short segments, ahead of their execution.
//!
//! A block leaves the planner when its last segment is prepared. So the planner reports it as free before the
//! tool has driven it.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_guard::Time;

use super::axes::{StepPlace, Triple, to_mm};
use super::parser::BlockFeed;
use super::planner::{AxisLimits, MotionPlanner, PlannedMotion, RateOverrides};

/// Most prepared segments.
const SEGMENTS: usize = 6;
/// Duration of a segment, s.
const SEGMENT_S: f64 = 0.01;
/// A remaining distance that counts as none, mm.
const NOTHING_MM: f64 = 1e-9;

/// Length of a motion that may stop before its end, mm.
const SHORT_MM: f64 = 2.0;
/// Speed of the steps that such a motion left out, mm/s.
const LEFTOVER_MM_S: f64 = 5.0;

/// A part of a motion with a constant acceleration.
#[derive(Clone, Debug)]
struct StepSegment {
    block: PlannedMotion,
    from_mm: f64,
    speeds: [f64; 2],
    seconds: f64,
    end_mm: f64,
}

impl StepSegment {
    /// The steps that a short motion left out.
    fn of_leftover(block: PlannedMotion, from_mm: f64) -> Self {
        let end_mm = block.length_mm;
        let seconds = (end_mm - from_mm) / LEFTOVER_MM_S;
        Self { block, from_mm, speeds: [LEFTOVER_MM_S; 2], seconds, end_mm }
    }

    fn duration(&self) -> Duration {
        Duration::from_secs_f64(self.seconds).max(Duration::from_micros(1))
    }

    fn place_after(&self, elapsed: Duration) -> StepPlace {
        if elapsed >= self.duration() {
            return self.block.place(self.end_mm);
        }
        let (time, whole) = (elapsed.as_secs_f64(), self.seconds.max(1e-9));
        let [from, to] = self.speeds;
        let driven = from * time + (to - from) * time * time / (2.0 * whole);
        self.block.place((self.from_mm + driven).min(self.end_mm))
    }
}

/// The planner and the step generator.
#[derive(Clone, Debug)]
pub(super) struct StepGenerator {
    planner: MotionPlanner,
    segments: VecDeque<StepSegment>,
    /// Start of the first segment.
    since: Time,
    position: StepPlace,
    running: bool,
    braking: bool,
    /// Braking has ended: nothing more is prepared.
    braked: bool,
    /// Decides whether a short motion stops a few steps before its end.
    random: Option<fastrand::Rng>,
    /// A motion that stopped so, and the driven distance, mm.
    leftover: Option<(PlannedMotion, f64)>,
}

impl StepGenerator {
    pub fn new(limits: AxisLimits, at: StepPlace) -> Self {
        Self {
            planner: MotionPlanner::new(limits, at),
            segments: VecDeque::new(),
            since: Time::ZERO,
            position: at,
            running: false,
            braking: false,
            braked: false,
            random: None,
            leftover: None,
        }
    }

    /// Lets some short motions stop a few steps before their end. The next motion runs these steps.
    pub fn leave_steps(&mut self, seed: u64) {
        self.random = Some(fastrand::Rng::with_seed(seed));
    }

    pub fn set_limits(&mut self, limits: AxisLimits) {
        self.planner.set_limits(limits);
    }

    pub fn set_overrides(&mut self, overrides: RateOverrides) {
        self.planner.set_overrides(overrides);
    }

    pub fn is_running(&self) -> bool {
        self.running
    }

    pub fn is_full(&self) -> bool {
        self.planner.is_full()
    }

    /// Number of motions in the planner.
    pub fn queued(&self) -> usize {
        self.planner.blocks.len()
    }

    /// Whether the motion under way, or the next one, is a jog.
    pub fn jogs(&self) -> bool {
        let first = self.segments.front().map(|segment| &segment.block);
        first.or(self.planner.blocks.front()).is_some_and(|block| block.jog)
    }

    /// Adds a motion at the end of the queue.
    pub fn add(&mut self, target_mm: Triple, feed: BlockFeed, jog: bool) {
        if self.planner.add(target_mm, feed, jog) && self.running {
            self.prepare();
        }
    }

    /// Starts the queued motions.
    pub fn start(&mut self, now: Time) {
        (self.running, self.braking, self.braked) = (true, false, false);
        self.planner.speed = 0.0;
        self.planner.replan();
        self.since = now;
        self.prepare();
    }

    /// Brakes to rest on the path.
    pub fn brake(&mut self) {
        self.braking = true;
    }

    /// Stops at once, and empties the queue.
    pub fn halt(&mut self, now: Time) {
        self.position = self.place_at(now);
        self.segments.clear();
        self.running = false;
        self.empty();
    }

    /// Empties the queue of a tool at rest.
    pub fn empty(&mut self) {
        self.leftover = None;
        self.planner.empty_at(self.position);
    }

    /// Counts from another place.
    pub fn set_position(&mut self, at: StepPlace) {
        self.position = at;
        self.empty();
    }

    /// The end of the segment under way.
    pub fn segment_end(&self) -> Option<Time> {
        self.segments.front().map(|segment| self.since.after(segment.duration()))
    }

    /// The position in whole steps.
    pub fn place_at(&self, now: Time) -> StepPlace {
        match self.segments.front() {
            Some(segment) => segment.place_after(now.since(self.since)),
            None => self.position,
        }
    }

    /// The position, mm.
    pub fn mm_at(&self, now: Time) -> Triple {
        to_mm(self.place_at(now), self.planner.steps_per_mm())
    }

    /// The present speed, mm/s.
    pub fn speed_at(&self, now: Time) -> f64 {
        self.segments.front().map_or(0.0, |segment| {
            let share = (now.since(self.since).as_secs_f64() / segment.seconds.max(1e-9)).min(1.0);
            segment.speeds[0] + (segment.speeds[1] - segment.speeds[0]) * share
        })
    }

    /// Ends the segment under way. Returns whether the tool came to rest.
    pub fn end_segment(&mut self) -> bool {
        let Some(segment) = self.segments.pop_front() else { return false };
        self.since = self.since.after(segment.duration());
        self.position = segment.block.place(segment.end_mm);
        self.prepare();
        self.running = !self.segments.is_empty();
        !self.running
    }

    /// Fills the segment buffer.
    fn prepare(&mut self) {
        while self.segments.len() < SEGMENTS && !self.braked {
            let Some(block) = self.planner.blocks.front() else { return };
            if let Some((left, from_mm)) = self.leftover.take() {
                self.segments.push_back(StepSegment::of_leftover(left, from_mm));
                continue;
            }
            let mut segment = self.next_segment(block);
            let last = self.planner.blocks.len() == 1 && !self.braking && segment.end_mm >= block.length_mm;
            self.planner.speed = segment.speeds[1];
            self.planner.done_mm = segment.end_mm;
            let ends = segment.end_mm >= block.length_mm;
            self.braked = self.braking && segment.speeds[1] <= 0.0;
            if last && let Some(short_mm) = self.draw_short(&segment) {
                segment.end_mm -= short_mm;
                self.leftover = Some((segment.block.clone(), segment.end_mm));
            }
            self.segments.push_back(segment);
            if ends {
                self.planner.leave();
            }
        }
    }

    /// The distance that the last segment of a short motion leaves out, mm, now and then.
    fn draw_short(&mut self, segment: &StepSegment) -> Option<f64> {
        let random = self.random.as_mut()?;
        let leaves = segment.block.length_mm < SHORT_MM && random.u8(0..4) == 0;
        let step_mm = 1.0 / self.planner.steps_per_mm()[0];
        let short_mm = f64::from(random.u8(1..=3)) * step_mm;
        (leaves && short_mm < segment.end_mm - segment.from_mm).then_some(short_mm)
    }

    fn next_segment(&self, block: &PlannedMotion) -> StepSegment {
        let (speed, done) = (self.planner.speed, self.planner.done_mm);
        let rest = block.length_mm - done;
        let step = block.acceleration * SEGMENT_S;
        let to = if self.braking {
            (speed - step).max(0.0)
        } else {
            let braked = braking_speed(block.acceleration, speed, self.planner.exit_2(), rest);
            let wanted = if speed > block.nominal {
                (speed - step).max(block.nominal)
            } else {
                (speed + step).min(block.nominal)
            };
            wanted.min(braked).max(speed - step)
        };
        let ramps = self.braking && to <= 0.0;
        let seconds = if ramps { speed / block.acceleration } else { SEGMENT_S };
        let driven = (speed + to) / 2.0 * seconds;
        if to > 0.0 && driven < rest - NOTHING_MM || ramps && driven < rest {
            let end_mm = done + driven;
            return StepSegment { block: block.clone(), from_mm: done, speeds: [speed, to], seconds, end_mm };
        }
        self.last_segment(block, rest)
    }

    /// The segment up to the end of a block.
    fn last_segment(&self, block: &PlannedMotion, rest: f64) -> StepSegment {
        let (speed, done) = (self.planner.speed, self.planner.done_mm);
        let change_2 = 2.0 * block.acceleration * rest;
        let (slowest, fastest) = ((speed * speed - change_2).max(0.0), speed * speed + change_2);
        let wanted = if self.braking { slowest } else { self.planner.exit_2().min(block.nominal.powi(2)) };
        let to = wanted.clamp(slowest, fastest).sqrt();
        // From rest to rest, the tool speeds up along one half and brakes along the other.
        let least = 2.0 * (rest / block.acceleration).sqrt();
        let seconds = if speed + to > 0.0 { (2.0 * rest / (speed + to)).min(least) } else { least };
        StepSegment {
            block: block.clone(),
            from_mm: done,
            speeds: [speed, to],
            seconds,
            end_mm: block.length_mm,
        }
    }
}

/// The largest speed after a segment from which the tool can still slow down in the rest of the block.
fn braking_speed(acceleration: f64, speed: f64, exit_2: f64, rest: f64) -> f64 {
    let step = acceleration * SEGMENT_S;
    let square = step * step + 4.0 * (exit_2 + 2.0 * acceleration * rest - step * speed);
    if square <= 0.0 { 0.0 } else { ((square.sqrt() - step) / 2.0).max(0.0) }
}

//! A controller's interpolator: straight blocks, look-ahead, trapezoidal speed.

use std::collections::VecDeque;

use keepout_planner::machine::MachineProfile;

/// What the drives can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drives {
    /// Top speed of an axis, mm/s.
    pub max_rate: f64,
    /// Acceleration of an axis, mm/s².
    pub acceleration: f64,
    /// Junction deviation, mm (GRBL `$11`).
    pub junction_deviation: f64,
}

impl Drives {
    /// What the machine's drives can do, with a controller of this junction deviation.
    pub fn of(machine: &MachineProfile, junction_deviation: f64) -> Self {
        Self { max_rate: machine.max_rate_mm_s, acceleration: machine.acceleration_mm_s2, junction_deviation }
    }
}

#[derive(Clone, Copy, Debug)]
struct Block {
    to: (f64, f64),
    unit: (f64, f64),
    left: f64,
    nominal: f64,
    acceleration: f64,
    max_entry: f64,
    entry: f64,
    /// Its steps come out one too many when the firmware counts them from its length.
    rounds_up: bool,
}

/// Steps that nobody ordered: the count of steps of a block went below zero.
#[derive(Clone, Copy, Debug)]
struct Runaway {
    unit: (f64, f64),
    left: f64,
    speed: f64,
}

/// How a stop under way ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    /// Keep what is queued.
    Hold,
    /// Drop what is queued.
    Flush,
}

/// What a tick of the drives brought about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing to tell.
    Going,
    /// A hold has come to rest.
    Held,
    /// A cancel has come to rest, and the queue is empty.
    Flushed,
}

/// The planner queue and the tool's motion along it.
#[derive(Clone, Debug)]
pub struct Motion {
    drives: Drives,
    blocks: VecDeque<Block>,
    position: (f64, f64),
    speed: f64,
    stop: Option<Stop>,
    /// Steps per mm of a firmware whose stops can run away.
    runs_away: Option<f64>,
    /// The stop under way ends where the block under way does.
    meets_end: bool,
    /// So long the drives do not know of the block that was queued last, s.
    unaware: f64,
    runaway: Option<Runaway>,
}

/// The drives take up a new plan with the next segment, s.
const SEGMENT_S: f64 = 0.01;
/// Nearer than this the end of a stop and that of a block are one, mm.
const MEETS: f64 = 1e-6;
/// Steps of a 16-bit count below zero, and how fast they come, 1/s.
const RUNAWAY_STEPS: f64 = 65_535.0;
const RUNAWAY_RATE: f64 = 35_000.0;
/// The slowest feed, mm/s.
const CREEP: f64 = 0.2;
/// Speeds are divided by no less than this, mm/s.
const SLOWEST: f64 = 1e-6;
/// Nearer than this a target counts as reached, mm.
const REACHED: f64 = 1e-9;

impl Motion {
    /// Drives at rest at `position`, mm.
    #[must_use]
    pub fn new(drives: Drives, position: (f64, f64)) -> Self {
        Self {
            drives,
            blocks: VecDeque::new(),
            position,
            speed: 0.0,
            stop: None,
            runs_away: None,
            meets_end: false,
            unaware: 0.0,
            runaway: None,
        }
    }

    /// With the defect of GRBL 1.1h and grblHAL: a stop that ends exactly where a block ends, while another is queued, can count the
    /// steps of that other below zero, and sends 65,535 of them. Stops meet the end of a block when the queue has run low: the tool
    /// brakes to its end already, and the next block comes just before or during the stop.
    pub fn with_runaway(mut self, steps_per_mm: f64) -> Self {
        self.runs_away = Some(steps_per_mm);
        self
    }

    /// Where the tool is commanded to be, mm.
    #[must_use]
    pub fn position(&self) -> (f64, f64) {
        self.position
    }

    /// Speed along the block under way, mm/s.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Speed of each axis, mm/s.
    pub fn velocity(&self) -> (f64, f64) {
        let unit = self.blocks.front().map_or((0.0, 0.0), |block| block.unit);
        (unit.0 * self.speed, unit.1 * self.speed)
    }

    /// Blocks that are not finished.
    #[must_use]
    pub fn queued(&self) -> usize {
        self.blocks.len()
    }

    /// Blocks of which more is left than what the drives were given ahead of time, for so many seconds at this speed.
    pub fn queued_behind(&self, ahead_s: f64) -> usize {
        let mut given = self.speed * ahead_s;
        let wholly = self.blocks.iter().take_while(|block| {
            given -= block.left;
            given >= 0.0
        });
        self.blocks.len() - wholly.count()
    }

    /// Whether nothing is queued and no stop is under way.
    #[must_use]
    pub fn is_resting(&self) -> bool {
        self.blocks.is_empty() && self.stop.is_none()
    }

    /// Where the last queued block ends.
    pub fn planned_end(&self) -> (f64, f64) {
        self.blocks.back().map_or(self.position, |block| block.to)
    }

    /// Queues a straight block at `feed` mm/s; whether it was long enough to be one.
    pub fn push(&mut self, to: (f64, f64), feed: f64, shortest: f64) -> bool {
        let from = self.planned_end();
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = dx.hypot(dy);
        if length < shortest {
            return false;
        }
        let unit = (dx / length, dy / length);
        let share = unit.0.abs().max(unit.1.abs());
        let acceleration = self.drives.acceleration / share;
        let nominal = feed.min(self.drives.max_rate / share).max(CREEP);
        let max_entry = self.blocks.back().map_or(0.0, |before| {
            self.junction_speed(before.unit, unit, acceleration).min(nominal).min(before.nominal)
        });
        let rounds_up = self.runs_away.is_some_and(|steps_per_mm| rounds_up(from, to, steps_per_mm));
        let block = Block { to, unit, left: length, nominal, acceleration, max_entry, entry: 0.0, rounds_up };
        if self.runs_away.is_some() && self.blocks.len() == 1 && self.brakes_to_end() {
            self.unaware = SEGMENT_S;
        }
        self.blocks.push_back(block);
        self.look_ahead();
        true
    }

    /// GRBL's junction speed: the speed at which a circle that cuts the corner by the deviation would be followed. The
    /// path itself is not left.
    fn junction_speed(&self, a: (f64, f64), b: (f64, f64), acceleration: f64) -> f64 {
        let cos = -(a.0 * b.0 + a.1 * b.1);
        if cos > 0.999_999 {
            return 0.0;
        }
        let sin_half = ((1.0 - cos) / 2.0).sqrt();
        if sin_half > 0.999_999 {
            return f64::INFINITY;
        }
        (acceleration * self.drives.junction_deviation * sin_half / (1.0 - sin_half)).sqrt()
    }

    /// Entry speeds from which each following block can still come to rest at the end of the queue.
    fn look_ahead(&mut self) {
        let mut exit = 0.0_f64;
        for block in self.blocks.iter_mut().rev() {
            block.entry = (exit * exit + 2.0 * block.acceleration * block.left).sqrt().min(block.max_entry);
            exit = block.entry;
        }
    }

    /// Whether a stop is under way.
    pub fn is_stopping(&self) -> bool {
        self.stop.is_some()
    }

    /// Begins to stop, keeping the queue.
    pub fn hold(&mut self) {
        self.begin_stop(Stop::Hold);
    }

    /// Begins to stop, and drops the queue at rest.
    pub fn cancel(&mut self) {
        self.begin_stop(Stop::Flush);
    }

    fn begin_stop(&mut self, stop: Stop) {
        self.meets_end = self.brakes_to_end();
        self.unaware = 0.0;
        self.stop = Some(stop);
    }

    /// Whether braking from now on ends where the block under way does.
    fn brakes_to_end(&self) -> bool {
        let way = |block: &Block| self.speed * self.speed / (2.0 * block.acceleration);
        self.speed > 0.0 && self.blocks.front().is_some_and(|block| (way(block) - block.left).abs() < MEETS)
    }

    /// Begins to stop as [`Motion::cancel`], but drops the blocks that end within the next `prepared_s` seconds. The blocks after them
    /// begin here, so the tool drives beside their lines.
    pub fn cancel_astray(&mut self, prepared_s: f64) {
        let mut prepared = self.speed * prepared_s;
        while self.blocks.len() > 1
            && let Some(first) = self.blocks.front()
            && first.left < prepared
        {
            prepared -= first.left;
            self.blocks.pop_front();
        }
        if let Some(first) = self.blocks.front() {
            let begins = (first.to.0 - first.unit.0 * first.left, first.to.1 - first.unit.1 * first.left);
            let shift = (self.position.0 - begins.0, self.position.1 - begins.1);
            for block in &mut self.blocks {
                block.to = (block.to.0 + shift.0, block.to.1 + shift.1);
            }
        }
        self.cancel();
    }

    /// Goes on after a hold.
    pub fn resume(&mut self) {
        self.stop = None;
    }

    /// Stops dead and drops everything.
    pub fn kill(&mut self) {
        self.blocks.clear();
        self.speed = 0.0;
        self.stop = None;
        (self.unaware, self.runaway) = (0.0, None);
    }

    /// Moves on by `dt` seconds; calls `corner` at every block end passed.
    pub fn advance(&mut self, dt: f64, mut corner: impl FnMut((f64, f64))) -> Outcome {
        if self.runaway.is_some() {
            return self.run_on(dt);
        }
        let mut left = dt;
        while left > 0.0 {
            let Some((rate, lasts)) = self.phase() else { break };
            let step = lasts.min(left);
            left -= step;
            self.unaware = (self.unaware - step).max(0.0);
            let before = self.speed;
            self.speed = (before + rate * step).max(0.0);
            let length = f64::midpoint(before, self.speed) * step;
            let exit = self.exit();
            let Some(block) = self.blocks.front_mut() else { break };
            let ends = step >= lasts;
            let meets = self.meets_end && length >= block.left - MEETS;
            if self.stop.is_some() && (meets || ends && length < block.left - REACHED || self.speed <= 0.0) {
                go(block, &mut self.position, length.min(block.left));
                self.speed = 0.0;
                if self.meets_end && self.runs_away() {
                    return self.run_on(left);
                }
                return self.come_to_rest();
            }
            if length >= block.left - REACHED {
                self.position = block.to;
                self.speed = if self.stop.is_some() { self.speed } else { self.speed.min(exit.max(0.0)) };
                self.blocks.pop_front();
                corner(self.position);
            } else {
                go(block, &mut self.position, length);
            }
        }
        if self.blocks.is_empty() {
            self.speed = 0.0;
            if self.stop.is_some() {
                return self.come_to_rest();
            }
        }
        Outcome::Going
    }

    /// Begins to run away along the block after the one that has just ended, if its steps come out wrong.
    fn runs_away(&mut self) -> bool {
        let next = self.blocks.get(1).filter(|block| block.rounds_up);
        let Some((steps_per_mm, block)) = self.runs_away.zip(next) else { return false };
        let per_step = 1.0 / (steps_per_mm * block.unit.0.abs().max(block.unit.1.abs()));
        let (left, speed) = (RUNAWAY_STEPS * per_step, RUNAWAY_RATE * per_step);
        self.runaway = Some(Runaway { unit: block.unit, left, speed });
        true
    }

    fn run_on(&mut self, dt: f64) -> Outcome {
        let Some(run) = &mut self.runaway else { return Outcome::Going };
        let step = (run.speed * dt).min(run.left);
        run.left -= step;
        self.position = (self.position.0 + run.unit.0 * step, self.position.1 + run.unit.1 * step);
        if run.left > 0.0 {
            return Outcome::Going;
        }
        self.runaway = None;
        self.blocks.clear();
        self.come_to_rest()
    }

    /// Seconds until the block under way ends, or the tool has come to rest; `None` at rest.
    pub fn next_event(&self) -> Option<f64> {
        if let Some(run) = &self.runaway {
            return Some(run.left / run.speed);
        }
        let block = self.blocks.front()?;
        if self.held() {
            return None;
        }
        let a = block.acceleration;
        if self.stop.is_some() {
            let way = self.speed * self.speed / (2.0 * a);
            if way < block.left {
                return Some(self.speed / a);
            }
            let end = (self.speed * self.speed - 2.0 * a * block.left).max(0.0).sqrt();
            return Some((self.speed - end) / a);
        }
        if self.unaware > 0.0 {
            return Some(self.unaware);
        }
        let exit = self.exit();
        let peak_2 = a * block.left + f64::midpoint(self.speed * self.speed, exit * exit);
        let peak = peak_2.sqrt().min(block.nominal).max(self.speed).max(exit);
        let (up, down) = ((peak - self.speed) / a, (peak - exit) / a);
        let ways = (peak * peak - self.speed * self.speed + peak * peak - exit * exit) / (2.0 * a);
        let cruise = (block.left - ways).max(0.0) / peak.max(SLOWEST);
        Some(up + down + cruise)
    }

    /// Whether the tool stands still in a hold.
    fn held(&self) -> bool {
        self.stop == Some(Stop::Hold) && self.speed <= 0.0
    }

    /// The speed at which the block under way ends.
    fn exit(&self) -> f64 {
        let next = self.blocks.get(1).filter(|_| self.unaware <= 0.0);
        next.map_or(0.0, |next| next.entry)
    }

    /// The change of speed, mm/s², and how long it lasts, s.
    fn phase(&self) -> Option<(f64, f64)> {
        let block = self.blocks.front()?;
        let (v, a, left) = (self.speed, block.acceleration, block.left);
        if self.held() {
            return None;
        }
        if self.stop.is_some() {
            return self.next_event().map(|lasts| (-a, lasts));
        }
        let exit = self.exit();
        let braking = (v * v - exit * exit) / (2.0 * a);
        if braking >= left - REACHED && v > exit {
            // Exactly to the exit speed at the block's end.
            let time = left / f64::midpoint(v, exit).max(SLOWEST);
            let lasts = if self.unaware > 0.0 { time.min(self.unaware) } else { time };
            return Some(((exit - v) / time.max(1e-12), lasts));
        }
        let peak_2 = a * left + f64::midpoint(v * v, exit * exit);
        let peak = peak_2.sqrt().min(block.nominal);
        if v < peak - 1e-9 {
            let to_end = (v * v + 2.0 * a * left).sqrt();
            let top = peak.min(to_end);
            return Some((a, ((top - v) / a).max(1e-9)));
        }
        let cruise = (left - braking.max(0.0)) / v.max(SLOWEST);
        Some((0.0, cruise.max(1e-9)))
    }

    fn come_to_rest(&mut self) -> Outcome {
        match self.stop {
            Some(Stop::Flush) => {
                self.blocks.clear();
                self.stop = None;
                Outcome::Flushed
            }
            Some(Stop::Hold) => {
                // What follows starts from rest.
                if let Some(first) = self.blocks.front_mut() {
                    first.max_entry = 0.0;
                }
                Outcome::Held
            }
            None => Outcome::Going,
        }
    }
}

/// Whether the firmware, in 32-bit floats, counts more steps from a block's length than the block has.
#[expect(clippy::cast_possible_truncation, reason = "the firmware computes in f32")]
fn rounds_up(from: (f64, f64), to: (f64, f64), steps_per_mm: f64) -> bool {
    let steps = |from: f64, to: f64| ((to * steps_per_mm).round() - (from * steps_per_mm).round()) as f32;
    let (x, y, per_mm) = (steps(from.0, to.0), steps(from.1, to.1), steps_per_mm as f32);
    let (count, length) = (x.abs().max(y.abs()), (x / per_mm).hypot(y / per_mm));
    length > 0.0 && (count / length) * length > count
}

fn go(block: &mut Block, position: &mut (f64, f64), step: f64) {
    block.left -= step;
    // Measured from the end, so that rounding does not add up.
    *position = (block.to.0 - block.unit.0 * block.left, block.to.1 - block.unit.1 * block.left);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion() -> Motion {
        Motion::new(Drives { max_rate: 200.0, acceleration: 500.0, junction_deviation: 0.01 }, (0.0, 0.0))
    }

    #[test]
    fn block_is_run_to_its_end_in_trapezoid_time() {
        let mut motion = motion();
        motion.push((100.0, 0.0), 100.0, 0.001);
        let mut ticks = 0;
        while motion.queued() > 0 {
            motion.advance(0.0005, |_| {});
            ticks += 1;
        }
        assert!(motion.position() == (100.0, 0.0));
        // 0.2 s up, 0.2 s down, 80 mm at 100 mm/s between.
        let seconds = f64::from(ticks) * 0.0005;
        assert!((seconds - 1.2).abs() < 0.002, "{seconds}");
    }

    /// Steps of any length come to the same: ends, corners, rest, and the time that was foretold.
    #[test]
    fn large_steps_and_small_ones_agree() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..300 {
            let mut whole = motion();
            for _ in 0..random.usize(1..6) {
                let to = (random.f64() * 40.0, random.f64() * 40.0);
                whole.push(to, 5.0 + random.f64() * 150.0, 0.001);
            }
            let mut fine = whole.clone();
            let (mut corners, mut seconds) = (Vec::new(), 0.0);
            while let Some(step) = whole.next_event() {
                seconds += step;
                whole.advance(step, |at| corners.push(at));
                whole.advance(1e-7, |at| corners.push(at));
                seconds += 1e-7;
            }
            let mut seen = Vec::new();
            for _ in 0..200 {
                fine.advance((seconds + 0.001) / 200.0, |at| seen.push(at));
            }
            assert_eq!(corners, seen);
            assert!(fine.queued() == 0 && whole.position() == fine.position());
        }
    }

    /// The queue runs low, the next block comes while the tool brakes, and a stop just behind it or before it.
    #[test]
    fn stop_at_the_end_of_a_block_runs_away_where_the_firmware_has_that_defect() {
        let slopes = (1..200).map(|k| (22.0, f64::from(k) / 80.0));
        let next = slopes.clone().find(|&to| rounds_up((20.0, 0.0), to, 80.0)).unwrap();
        assert!(slopes.clone().filter(|&to| rounds_up((20.0, 0.0), to, 80.0)).count() < 60, "most do not");
        let run = |defect: bool, block_first: bool| {
            let mut motion = if defect { motion().with_runaway(80.0) } else { motion() };
            motion.push((20.0, 0.0), 50.0, 0.001);
            while !motion.brakes_to_end() {
                motion.advance(1e-4, |_| {});
            }
            if block_first {
                motion.push(next, 50.0, 0.001);
                motion.advance(0.005, |_| {});
                motion.hold();
            } else {
                motion.hold();
                motion.advance(0.005, |_| {});
                motion.push(next, 50.0, 0.001);
            }
            for _ in 0..100_000 {
                motion.advance(1e-4, |_| {});
            }
            motion.position().0
        };
        for block_first in [false, true] {
            assert!((run(false, block_first) - 20.0).abs() < 0.3 && run(true, block_first) > 700.0);
        }
    }

    #[test]
    fn cancel_stops_on_the_path_within_the_braking_distance() {
        let mut motion = motion();
        motion.push((60.0, 80.0), 100.0, 0.001);
        for _ in 0..1000 {
            motion.advance(0.0005, |_| {});
        }
        let before = motion.position();
        motion.cancel();
        let mut outcome = Outcome::Going;
        for _ in 0..1000 {
            outcome = motion.advance(0.0005, |_| {});
            if outcome == Outcome::Flushed {
                break;
            }
        }
        let after = motion.position();
        assert_eq!(outcome, Outcome::Flushed);
        assert!((after.0 * 80.0 - after.1 * 60.0).abs() < 1e-9, "on the line");
        let travelled = (after.0 - before.0).hypot(after.1 - before.1);
        // Acceleration along the diagonal is 500 / 0.8.
        assert!((travelled - 100.0 * 100.0 / (2.0 * 625.0)).abs() < 0.2, "{travelled}");
    }
}

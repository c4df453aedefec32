//! A simulated interpolator of a controller: straight blocks, look-ahead, trapezoidal speed.

mod stop;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use keepout_planner::Mm3;
use keepout_planner::machine::MachineProfile;
use stop::Stop;

/// Limits of the drives and the look-ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drives {
    /// Top speed of an axis, mm/s.
    pub max_rate: f64,
    /// Acceleration of an axis, mm/s².
    pub acceleration: f64,
    /// Top speed and acceleration of the third axis, mm/s and mm/s².
    pub up: [f64; 2],
    /// Junction deviation, mm (GRBL `$11`).
    pub junction_deviation: f64,
}

impl Drives {
    /// The limits of `machine`, with a junction deviation in mm.
    pub fn of(machine: &MachineProfile, junction_deviation: f64) -> Self {
        let (max_rate, acceleration) = (machine.max_rate_mm_s, machine.acceleration_mm_s2);
        let up =
            machine.z.as_ref().map_or([max_rate, acceleration], |z| [z.max_rate_mm_s, z.acceleration_mm_s2]);
        Self { max_rate, acceleration, up, junction_deviation }
    }

    /// Top speed and acceleration along a direction: no axis exceeds its own.
    fn along(&self, unit: Mm3) -> [f64; 2] {
        let share = unit.x.abs().max(unit.y.abs());
        let [rate, acceleration] = self.up.map(|limit| limit / unit.z.abs());
        [(self.max_rate / share).min(rate), (self.acceleration / share).min(acceleration)]
    }
}

#[derive(Clone, Copy, Debug)]
struct Block {
    to: Mm3,
    unit: Mm3,
    left: f64,
    nominal: f64,
    acceleration: f64,
    max_entry: f64,
    entry: f64,
    /// The firmware computes one step too many from the length of this block.
    rounds_up: bool,
}

/// Unwanted steps, after the firmware counted the steps of a block below zero.
#[derive(Clone, Copy, Debug)]
struct Runaway {
    unit: Mm3,
    left: f64,
    speed: f64,
}

/// The result of a time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepOutcome {
    /// No stop ended in this step.
    Going,
    /// The tool stands still after a hold.
    Held,
    /// The tool stands still after a cancel, and the queue is empty.
    Flushed,
}

/// The planner queue and the tool's motion along it.
#[derive(Clone, Debug)]
pub struct QueuedMotion {
    drives: Drives,
    blocks: VecDeque<Block>,
    position: Mm3,
    speed: f64,
    stop: Option<Stop>,
    /// Steps per mm of a firmware with the runaway defect.
    runs_away: Option<f64>,
    /// The current stop ends at the end of the current block.
    meets_end: bool,
    /// Time for which the drives still ignore the last queued block, s.
    unaware: f64,
    runaway: Option<Runaway>,
}

/// Duration of a motion segment, s. The drives follow a new plan from the next segment on.
const SEGMENT_S: f64 = 0.01;
/// Largest distance at which a stop and a block count as ending together, mm.
const MEETS: f64 = 1e-6;
/// Number of unwanted steps after a 16-bit count goes below zero.
const RUNAWAY_STEPS: f64 = 65_535.0;
/// Rate of the unwanted steps, 1/s.
const RUNAWAY_RATE: f64 = 35_000.0;
/// Slowest feed, mm/s.
const CREEP: f64 = 0.2;
/// Smallest divisor among the speeds, mm/s.
const SLOWEST: f64 = 1e-6;
/// Largest distance at which a target counts as reached, mm.
const REACHED: f64 = 1e-9;

impl QueuedMotion {
    /// Drives at rest at `position`, mm.
    #[must_use]
    pub fn new(drives: Drives, position: Mm3) -> Self {
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

    /// Adds the runaway defect of GRBL 1.1h and grblHAL.
    ///
    /// A stop may end exactly at the end of a block while another block is queued. The firmware can then
    /// count the steps of that other block below zero, and sends 65,535 steps. This happens when the queue
    /// runs low: the tool already brakes to the end of its block, and the next block arrives just before or
    /// during the stop.
    pub fn with_runaway(mut self, steps_per_mm: f64) -> Self {
        self.runs_away = Some(steps_per_mm);
        self
    }

    /// Commanded position of the tool, mm.
    #[must_use]
    pub fn position(&self) -> Mm3 {
        self.position
    }

    /// Speed along the current block, mm/s.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Speed of each axis, mm/s.
    pub fn velocity(&self) -> Mm3 {
        self.blocks.front().map_or(Mm3::ZERO, |block| block.unit) * self.speed
    }

    /// Number of unfinished blocks.
    #[must_use]
    pub fn queued(&self) -> usize {
        self.blocks.len()
    }

    /// Number of blocks that reach beyond the next `ahead_s` seconds at the current speed.
    pub fn queued_behind(&self, ahead_s: f64) -> usize {
        let mut given = self.speed * ahead_s;
        let wholly = self.blocks.iter().take_while(|block| {
            given -= block.left;
            given >= 0.0
        });
        self.blocks.len() - wholly.count()
    }

    /// Whether the queue is empty and no stop is in progress.
    #[must_use]
    pub fn is_resting(&self) -> bool {
        self.blocks.is_empty() && self.stop.is_none()
    }

    /// End of the last queued block, mm.
    pub fn planned_end(&self) -> Mm3 {
        self.blocks.back().map_or(self.position, |block| block.to)
    }

    /// Queues a straight block to `to` at `feed` mm/s. Returns false for a block below `shortest` mm, and
    /// drops it.
    pub fn push(&mut self, to: Mm3, feed: f64, shortest: f64) -> bool {
        let from = self.planned_end();
        let length = from.distance(to);
        if length < shortest {
            return false;
        }
        let unit = (to - from) / length;
        let [rate, acceleration] = self.drives.along(unit);
        let nominal = feed.min(rate).max(CREEP);
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

    /// GRBL's junction speed, mm/s: the speed on a circle that cuts the corner by the junction deviation. The
    /// tool itself stays on the path.
    fn junction_speed(&self, a: Mm3, b: Mm3, acceleration: f64) -> f64 {
        let cos = -a.dot(b);
        if cos > 0.999_999 {
            return 0.0;
        }
        let sin_half = ((1.0 - cos) / 2.0).sqrt();
        if sin_half > 0.999_999 {
            return f64::INFINITY;
        }
        (acceleration * self.drives.junction_deviation * sin_half / (1.0 - sin_half)).sqrt()
    }

    /// Sets the entry speeds, so that the tool can still stop at the end of the queue.
    fn look_ahead(&mut self) {
        let mut exit = 0.0_f64;
        for block in self.blocks.iter_mut().rev() {
            block.entry = (exit * exit + 2.0 * block.acceleration * block.left).sqrt().min(block.max_entry);
            exit = block.entry;
        }
    }

    /// Advances the motion by `dt` seconds. Calls `corner` with the end of each block that it completes, and the
    /// seconds until then.
    pub fn advance(&mut self, dt: f64, mut corner: impl FnMut(Mm3, f64)) -> StepOutcome {
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
                corner(self.position, dt - left);
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
        StepOutcome::Going
    }

    /// Begins a runaway along the next block, if the firmware computes one step too many for it. Returns
    /// whether it did.
    fn runs_away(&mut self) -> bool {
        let next = self.blocks.get(1).filter(|block| block.rounds_up);
        let Some((steps_per_mm, block)) = self.runs_away.zip(next) else { return false };
        let Mm3 { x, y, z } = block.unit;
        let per_step = 1.0 / (steps_per_mm * x.abs().max(y.abs()).max(z.abs()));
        let (left, speed) = (RUNAWAY_STEPS * per_step, RUNAWAY_RATE * per_step);
        self.runaway = Some(Runaway { unit: block.unit, left, speed });
        true
    }

    fn run_on(&mut self, dt: f64) -> StepOutcome {
        let Some(run) = &mut self.runaway else { return StepOutcome::Going };
        let step = (run.speed * dt).min(run.left);
        run.left -= step;
        self.position += run.unit * step;
        if run.left > 0.0 {
            return StepOutcome::Going;
        }
        self.runaway = None;
        self.blocks.clear();
        self.come_to_rest()
    }

    /// Seconds until the current block ends or the tool stops. `None` at rest.
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
            let braking = self.speed * self.speed / (2.0 * a);
            if braking < block.left {
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
        let ramps = (peak * peak - self.speed * self.speed + peak * peak - exit * exit) / (2.0 * a);
        let cruise = (block.left - ramps).max(0.0) / peak.max(SLOWEST);
        Some(up + down + cruise)
    }

    /// Whether the tool stands still in a hold.
    fn held(&self) -> bool {
        self.stop == Some(Stop::Hold) && self.speed <= 0.0
    }

    /// Speed at the end of the current block, mm/s.
    fn exit(&self) -> f64 {
        let next = self.blocks.get(1).filter(|_| self.unaware <= 0.0);
        next.map_or(0.0, |next| next.entry)
    }

    /// The current acceleration, mm/s², and its duration, s. `None` at rest.
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
            // Brake exactly to the exit speed at the end of the block.
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

    fn come_to_rest(&mut self) -> StepOutcome {
        match self.stop {
            Some(Stop::Flush) => {
                self.blocks.clear();
                self.stop = None;
                StepOutcome::Flushed
            }
            Some(Stop::Hold) => {
                // The remaining motion starts from rest.
                if let Some(first) = self.blocks.front_mut() {
                    first.max_entry = 0.0;
                }
                StepOutcome::Held
            }
            None => StepOutcome::Going,
        }
    }
}

/// Whether the firmware, in 32-bit floats, computes more steps from the length of a block than the block has.
#[expect(clippy::cast_possible_truncation, reason = "the firmware computes in f32")]
fn rounds_up(from: Mm3, to: Mm3, steps_per_mm: f64) -> bool {
    let steps = |from: f64, to: f64| ((to * steps_per_mm).round() - (from * steps_per_mm).round()) as f32;
    let (x, y, per_mm) = (steps(from.x, to.x), steps(from.y, to.y), steps_per_mm as f32);
    let (count, length) = (x.abs().max(y.abs()), (x / per_mm).hypot(y / per_mm));
    length > 0.0 && (count / length) * length > count
}

fn go(block: &mut Block, position: &mut Mm3, step: f64) {
    block.left -= step;
    // Measure from the end, so that rounding errors do not add up.
    *position = block.to - block.unit * block.left;
}

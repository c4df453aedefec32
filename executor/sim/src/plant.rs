//! The mechanics under a simulated controller: time, drives and homing. The dialects lie on top.

use std::time::Duration;

use keepout_drives::interpolator::{Drives, QueuedMotion, StepOutcome};
use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_planner::Mm3;

use super::independent::Apart;

/// The drives of a simulated controller, in its own time.
#[derive(Clone, Debug)]
pub(super) struct Plant {
    drives: Drives,
    motion: QueuedMotion,
    /// The motion of non-interpolated axes, while one runs.
    apart: Option<Apart>,
    kind: SampleKind,
    homing: Option<Time>,
    now: Time,
    samples: Vec<Sample>,
}

/// Shortest block, mm. Shorter ones are skipped.
const SHORTEST: f64 = 1e-9;

/// Advances a motion from one time to its next event, the other time at most, and adds a sample at each corner.
/// Returns the time of the event.
pub(super) fn run_motion(
    motion: &mut QueuedMotion,
    [from, to]: [Time; 2],
    sample: impl Fn(Mm3, Time) -> Sample,
    into: &mut Vec<Sample>,
) -> (Time, StepOutcome) {
    let left = to.since(from).as_secs_f64();
    let step = motion.next_event().map_or(left, |event| (event + 1e-6).min(left));
    let at = if step < left { from.after(Duration::from_secs_f64(step)) } else { to };
    let outcome = motion.advance(step, |corner, after| {
        into.push(sample(corner, from.after(Duration::from_secs_f64(after)).min(at)));
    });
    (at, outcome)
}

impl Plant {
    /// Its present time.
    pub(super) fn now(&self) -> Time {
        self.now
    }

    /// Drives at rest at `start_mm`, machine coordinates.
    pub(super) fn new(drives: Drives, start_mm: Mm3) -> Self {
        Self {
            motion: QueuedMotion::new(drives, start_mm),
            drives,
            apart: None,
            kind: SampleKind::Rest,
            homing: None,
            now: Time::ZERO,
            samples: Vec::new(),
        }
    }

    pub(super) fn position(&self) -> Mm3 {
        self.apart.map_or(self.motion.position(), |apart| apart.position())
    }

    /// The end of the queued motions.
    pub(super) fn planned_end(&self) -> Mm3 {
        self.motion.planned_end()
    }

    /// Whether an axis moves, or a motion is queued.
    pub(super) fn is_busy(&self) -> bool {
        !self.motion.is_resting() || self.apart.is_some() || self.homing.is_some()
    }

    pub(super) fn is_homing(&self) -> bool {
        self.homing.is_some()
    }

    /// Blocks that are not finished.
    pub(super) fn queued(&self) -> usize {
        self.motion.queued()
    }

    /// Queues a motion to `to`, mm and mm/s.
    pub(super) fn push(&mut self, to: Mm3, feed: f64) {
        self.motion.push(to, feed, SHORTEST);
        self.kind = SampleKind::Run;
    }

    /// Slows down on the path, and drops the queued motions.
    pub(super) fn stop(&mut self) {
        if self.motion.queued() > 0 {
            self.motion.cancel();
        }
    }

    /// Drives each axis independently to `to`, from rest.
    pub(super) fn push_apart(&mut self, to: Mm3, feed: f64) {
        self.apart = Some(Apart::go(self.position(), to, feed, &self.drives));
        self.kind = SampleKind::Run;
    }

    /// Slows down each axis independently, and drops the queued motions. The tool may leave its line.
    pub(super) fn stop_apart(&mut self) {
        let velocity = self.apart.map_or(self.motion.velocity(), |apart| apart.velocity());
        if velocity != Mm3::ZERO || self.is_busy() {
            let at = self.position();
            self.motion = QueuedMotion::new(self.drives, at);
            self.apart = Some(Apart::brake(at, velocity, &self.drives));
        }
    }

    /// Stops at once, without deceleration.
    pub(super) fn kill(&mut self) {
        self.settle();
        self.motion.kill();
        self.homing = None;
    }

    /// Homes. The plant is busy for `lasts`.
    pub(super) fn home(&mut self, lasts: Duration) {
        self.homing = Some(self.now.after(lasts));
    }

    /// The time when the present motion ends, or its next block begins; `None` at rest.
    pub(super) fn next_event(&self) -> Option<Time> {
        let seconds = self.apart.map(|apart| apart.left()).or(self.motion.next_event());
        let motion = seconds.map(|s| self.now.after(Duration::from_secs_f64(s + 2e-6)));
        self.homing.or(motion)
    }

    /// Whether an axis moves.
    pub(super) fn is_moving(&self) -> bool {
        self.apart.is_some() || self.motion.next_event().is_some()
    }

    /// Ends a motion of non-interpolated axes, and leaves the axes at rest at their present position.
    fn settle(&mut self) {
        if let Some(apart) = self.apart.take() {
            self.motion = QueuedMotion::new(self.drives, apart.position());
        }
    }

    fn go_on_apart(&mut self, mut apart: Apart, now: Time) {
        // Whole microseconds, and at least one.
        let step = Duration::from_secs_f64(apart.look().min(apart.left() + 1e-6).max(1e-6));
        let at = self.now.after(step).min(now);
        apart.advance(at.since(self.now).as_secs_f64());
        self.now = at;
        self.samples.push(Sample { at, position_mm: apart.position(), kind: self.kind });
        self.apart = Some(apart);
        if apart.left() <= 0.0 {
            self.settle();
        }
    }

    /// Runs until the next event, `now` at most.
    fn go_on(&mut self, now: Time) {
        if let Some(apart) = self.apart {
            self.go_on_apart(apart, now);
            return;
        }
        let kind = if self.motion.is_resting() { SampleKind::Rest } else { self.kind };
        let sample = |position_mm, at| Sample { at, position_mm, kind };
        let (at, _) = run_motion(&mut self.motion, [self.now, now], sample, &mut self.samples);
        self.samples.push(sample(self.motion.position(), at));
        self.now = at;
    }

    /// Runs until `now`.
    pub(super) fn advance(&mut self, now: Time) {
        if self.homing.is_some_and(|over| now >= over) {
            self.homing = None;
        }
        while self.now < now {
            self.go_on(now);
        }
    }

    pub(super) fn take_samples(&mut self, into: &mut Vec<Sample>) {
        into.append(&mut self.samples);
    }
}

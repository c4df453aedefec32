//! Scenarios as data: lines, real-time characters and waits, around the tool's position.

use std::f64::consts::PI;
use std::time::Duration;

use keepout_kernel::curve::nearest_unit;
use keepout_planner::Mm2;

/// Where a scenario may be played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Care {
    /// At a machine: the scenario moves inside its box, and sends no stop, reset or stored setting.
    Harmless,
    /// At a simulated controller only: the scenario resets, raises alarms, leaves the box, or sends a hold or
    /// a cancel. GRBL and grblHAL can run away at either (`docs/safety/controllers.md`).
    Harmful,
}

/// One step of a scenario. Positions are relative to the middle of the box.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Send a line. The recorder adds its end.
    Line(String),
    /// Send a jog.
    Jog {
        /// The target.
        to: Mm2,
        /// Feed, mm/min.
        feed: u32,
    },
    /// Send a programmed motion (G1).
    Cut {
        /// The target.
        to: Mm2,
        /// Feed, mm/min.
        feed: u32,
    },
    /// Send a real-time character.
    Realtime(u8),
    /// Wait.
    Wait(Duration),
    /// Wait until each line is answered.
    Answered,
    /// Wait until the controller is at rest.
    Rest,
}

/// A named sequence of steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// The name, unique among the scenarios of a recording.
    pub name: String,
    /// Where it may be played.
    pub care: Care,
    /// The steps, in order.
    pub steps: Vec<Step>,
}

/// The machine figures for scenarios.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Side of the box, mm.
    pub box_mm: f64,
    /// Top speed of the slower axis, mm/s.
    pub max_rate_mm_s: f64,
    /// Acceleration of the slower axis, mm/s².
    pub acceleration_mm_s2: f64,
    /// Blocks of the controller's planner.
    pub blocks: u32,
}

/// The character that cancels a jog.
pub(super) const CANCEL: u8 = 0x85;
/// The character of a feed hold.
pub(super) const HOLD: u8 = b'!';
/// The character of a reset.
pub(super) const RESET: u8 = 0x18;

/// Duration of a block in a full planner, s: longer than its line takes at the port.
const BLOCK_S: f64 = 0.025;

/// All scenarios, harmless ones first.
#[must_use]
pub fn scenarios(frame: &Frame) -> Vec<Scenario> {
    let mut all = Vec::new();
    frame.identity(&mut all);
    frame.junctions(&mut all);
    frame.cancels(&mut all);
    frame.holds(&mut all);
    frame.refills(&mut all);
    frame.low_queues(&mut all);
    frame.full_planner(&mut all);
    frame.short_jogs(&mut all);
    frame.override_feed(&mut all);
    frame.illegal_lines(&mut all);
    frame.resets(&mut all);
    frame.soft_limits(&mut all);
    all
}

fn harmless(name: String, steps: Vec<Step>) -> Scenario {
    Scenario { name, care: Care::Harmless, steps }
}

/// A feed in whole mm/min.
fn whole(feed: f64) -> u32 {
    u32::try_from(nearest_unit(feed)).unwrap_or(1).max(1)
}

fn harmful(name: String, steps: Vec<Step>) -> Scenario {
    Scenario { name, care: Care::Harmful, steps }
}

impl Frame {
    /// Largest distance of targets from the middle in each axis. The rest of the box allows for a cancelled
    /// tool that leaves its path.
    fn reach(&self) -> f64 {
        0.35 * self.box_mm
    }

    /// A share of the top speed as a feed, mm/min, limited to a speed that a motion in the box reaches.
    fn feed(&self, share: f64) -> u32 {
        let reachable = (self.acceleration_mm_s2 * self.reach()).sqrt();
        let feed = (self.max_rate_mm_s.min(reachable) * share * 60.0).clamp(10.0, 60_000.0);
        whole(feed)
    }

    /// Duration of a motion of this length from rest to rest, s.
    fn seconds(&self, length_mm: f64, feed: u32) -> f64 {
        let (v, a) = (f64::from(feed) / 60.0, self.acceleration_mm_s2);
        if v * v / a > length_mm { 2.0 * (length_mm / a).sqrt() } else { length_mm / v + v / a }
    }

    fn to(&self, x: f64, y: f64) -> Vec<Step> {
        let to = Mm2::new(x * self.reach(), y * self.reach());
        vec![Step::Jog { to, feed: self.feed(0.7) }, Step::Rest]
    }

    /// Zigzag from the left edge through the box: `count` segments that turn by `angle`, alternately left and
    /// right.
    fn zigzag(&self, count: u32, angle: f64) -> Vec<Mm2> {
        let length = 2.0 * self.reach() / f64::from(count);
        let mut at = Mm2::new(-self.reach(), 0.0);
        let mut points = Vec::new();
        for k in 0..count {
            let side = if k % 2 == 0 { 0.5 } else { -0.5 };
            at += Mm2::unit(side * angle) * length;
            points.push(at);
        }
        points
    }

    fn identity(&self, all: &mut Vec<Scenario>) {
        let line = |text: &str| Step::Line(text.into());
        let steps = vec![line("$N"), Step::Answered, Step::Wait(Duration::from_millis(300))];
        all.push(harmless("startup lines".into(), steps));
    }

    fn junctions(&self, all: &mut Vec<Scenario>) {
        for share in [0.1, 0.4, 1.0] {
            let feed = self.feed(share);
            for degrees in (0..=180_u32).step_by(15) {
                let angle = PI * f64::from(degrees) / 180.0;
                let mut steps = self.to(-1.0, 0.0);
                let corner = Mm2::default();
                steps.push(Step::Jog { to: corner, feed });
                steps.push(Step::Jog { to: corner + Mm2::unit(angle) * self.reach(), feed });
                steps.push(Step::Rest);
                all.push(harmless(format!("junction of {degrees} degrees, {feed} mm/min"), steps));
            }
        }
    }

    fn cancels(&self, all: &mut Vec<Scenario>) {
        for share in [0.3, 1.0] {
            self.cancel_phases(all, (1, 0), (share, 10));
        }
        for count in 2..=4 {
            for degrees in [5, 30, 90, 150] {
                self.cancel_phases(all, (count, degrees), (1.0, 8));
            }
        }
    }

    /// Cancels at equally spaced times along one path.
    fn cancel_phases(
        &self,
        all: &mut Vec<Scenario>,
        (count, degrees): (u32, u32),
        (share, phases): (f64, u32),
    ) {
        let feed = self.feed(share);
        let points = self.zigzag(count, PI * f64::from(degrees) / 180.0);
        let seconds = self.seconds(2.0 * self.reach(), feed);
        for phase in 0..phases {
            let wait = seconds * (f64::from(phase) + 0.5) / f64::from(phases);
            let mut steps = self.to(-1.0, 0.0);
            steps.extend(points.iter().map(|&to| Step::Jog { to, feed }));
            steps.push(Step::Answered);
            steps.push(Step::Wait(Duration::from_secs_f64(wait)));
            steps.push(Step::Realtime(CANCEL));
            steps.push(Step::Rest);
            let name = format!(
                "cancel of {count} jogs at {degrees} degrees, {feed} mm/min, {} of {phases}",
                phase + 1
            );
            all.push(harmful(name, steps));
        }
    }

    fn holds(&self, all: &mut Vec<Scenario>) {
        let feed = self.feed(0.5);
        let seconds = self.seconds(2.0 * self.reach(), feed);
        for phase in 1..=4 {
            let wait = Duration::from_secs_f64(seconds * f64::from(phase) / 5.0);
            let to = Mm2::new(self.reach(), 0.0);
            let still = Duration::from_secs_f64(seconds + 0.3);
            for (what, motion) in [("jog", Step::Jog { to, feed }), ("G1", Step::Cut { to, feed })] {
                let mut steps = self.to(-1.0, 0.0);
                steps.extend([motion, Step::Answered, Step::Wait(wait), Step::Realtime(HOLD)]);
                steps.extend([Step::Wait(still), Step::Realtime(b'~'), Step::Rest]);
                all.push(harmful(format!("hold in {what}, {phase} of 4"), steps));
            }
        }
        let pause = Step::Wait(Duration::from_millis(200));
        let steps = vec![Step::Realtime(HOLD), pause, Step::Realtime(b'~'), Step::Rest];
        all.push(harmful("hold at rest".into(), steps));
    }

    fn refills(&self, all: &mut Vec<Scenario>) {
        let feed = self.feed(0.5);
        let seconds = self.seconds(2.0 * self.reach(), feed);
        for phase in 1..=4 {
            let mut steps = self.to(-1.0, 0.0);
            steps.push(Step::Jog { to: Mm2::new(self.reach(), 0.0), feed });
            steps.push(Step::Answered);
            steps.push(Step::Wait(Duration::from_secs_f64(seconds * f64::from(phase) / 5.0)));
            steps.push(Step::Realtime(CANCEL));
            steps.push(Step::Jog { to: Mm2::new(0.0, self.reach()), feed });
            steps.push(Step::Rest);
            all.push(harmful(format!("refill after cancel, {phase} of 4"), steps));
        }
    }

    /// Low queues: the tool brakes to the end of its queue. Then the next jog arrives, and a cancel directly
    /// after it.
    fn low_queues(&self, all: &mut Vec<Scenario>) {
        let feed = self.feed(0.5);
        let ramp = f64::from(feed) / 60.0 / self.acceleration_mm_s2;
        for (phase, slope) in (1..=3).flat_map(|phase| (1..=24).map(move |slope| (phase, slope))) {
            let wait = self.seconds(self.reach(), feed) - 0.25 * f64::from(phase) * ramp;
            let mut steps = self.to(-1.0, 0.0);
            steps.push(Step::Jog { to: Mm2::default(), feed });
            steps.push(Step::Answered);
            steps.push(Step::Wait(Duration::from_secs_f64(wait.max(0.0))));
            let next = Mm2::new(0.6, 0.0125 * f64::from(slope));
            steps.extend([Step::Jog { to: next, feed }, Step::Answered, Step::Realtime(CANCEL), Step::Rest]);
            all.push(harmful(format!("low queue, cancel {phase} of 3, slope {slope}"), steps));
        }
    }

    fn full_planner(&self, all: &mut Vec<Scenario>) {
        let half = self.blocks.div_ceil(2).max(1);
        let count = 2 * self.blocks;
        for (name, cancels) in [("full planner", false), ("cancel of a full planner", true)] {
            let mut steps = self.to(-1.0, 0.0);
            let length = self.reach() / f64::from(half);
            let feed = whole((length / BLOCK_S * 60.0).clamp(10.0, 1200.0));
            for k in 1..=count {
                let along = f64::from(k % (2 * half)) * length - self.reach();
                steps.push(Step::Jog { to: Mm2::new(along, 0.0), feed });
            }
            if cancels {
                steps.push(Step::Realtime(CANCEL));
            }
            steps.push(Step::Rest);
            let scenario = if cancels { harmful } else { harmless };
            all.push(scenario(name.into(), steps));
        }
    }

    /// Short motions, for the time without answers at their ends.
    fn short_jogs(&self, all: &mut Vec<Scenario>) {
        let feed = self.feed(0.3);
        let mut steps = Vec::new();
        for k in 1..=24 {
            let x = self.reach() * 0.01 * f64::from(k);
            let to = Mm2::new(if k % 2 == 0 { x } else { -x }, 0.0);
            steps.extend([Step::Jog { to, feed }, Step::Rest]);
        }
        all.push(harmless("ends of motions".into(), steps));
    }

    fn override_feed(&self, all: &mut Vec<Scenario>) {
        let feed = self.feed(0.2);
        let pause = || Step::Wait(Duration::from_millis(100));
        let mut steps = self.to(-1.0, 0.0);
        steps.extend([Step::Cut { to: Mm2::new(self.reach(), 0.0), feed }, Step::Answered]);
        for character in [0x91, 0x92, 0x93, 0x94, 0x90] {
            steps.extend([pause(), Step::Realtime(character)]);
        }
        steps.push(Step::Rest);
        all.push(harmless("feed override".into(), steps));
    }

    /// Illegal lines without a target, or with a motion of length zero. A controller that accepts one does
    /// not move.
    fn illegal_lines(&self, all: &mut Vec<Scenario>) {
        for text in ["$J=G91X0", "$J=G91G1X0F100", "$J=G91X0F", "$JX", "G1G2", "G999", "1"] {
            let steps = vec![Step::Line(text.into()), Step::Answered, Step::Rest];
            all.push(harmless(format!("illegal line {text}"), steps));
        }
    }

    fn resets(&self, all: &mut Vec<Scenario>) {
        let wait = |ms| Step::Wait(Duration::from_millis(ms));
        let unlock = [Step::Line("$X".into()), Step::Answered, Step::Rest];
        all.push(harmful("reset at rest".into(), vec![Step::Realtime(RESET), wait(1500), Step::Rest]));
        let mut steps = self.to(-1.0, 0.0);
        steps.push(Step::Jog { to: Mm2::new(self.reach(), 0.0), feed: self.feed(0.3) });
        steps.extend([Step::Answered, wait(100), Step::Realtime(RESET), wait(1500)]);
        steps.push(Step::Line("$J=G91X0F100".into()));
        steps.push(Step::Answered);
        steps.extend(unlock);
        all.push(harmful("reset in motion".into(), steps));
    }

    fn soft_limits(&self, all: &mut Vec<Scenario>) {
        let beyond = Step::Line("$J=G53G90G21X10F600".into());
        all.push(harmful("jog beyond the travel".into(), vec![beyond, Step::Answered, Step::Rest]));
    }
}

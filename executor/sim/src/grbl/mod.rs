//! A simulated GRBL 1.1 or grblHAL controller, as far as a host can observe it.
//!
//! The behaviour follows observations of the real firmware. GRBL acknowledges `$J=` when its block is
//! planned. A line that finds the planner full waits with its absolute target. 0x85 acts only while jogging
//! and keeps the received bytes, so GRBL plans a waiting line from the place where the tool stopped.

mod program;

use std::collections::VecDeque;
use std::time::Duration;

use keepout_drives::interpolator::{Drives, QueuedMotion, StepOutcome};
use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_planner::Mm3;
use keepout_planner::machine::MachineProfile;

use super::controller::{Disturbance, SimulatedController};
use super::plant::run_motion;

/// The set-up of a simulated controller.
#[derive(Clone, Debug, PartialEq)]
pub struct SimSettings {
    /// The machine.
    pub machine: MachineProfile,
    /// The tool's position at power-up, machine coordinates, mm.
    pub start_mm: Mm3,
    /// Whether it is already homed.
    pub homed: bool,
    /// Duration of homing.
    pub homing: Duration,
    /// Work offset of G54, machine coordinates, mm: the origin of programmed motions.
    pub work_offset_mm: Mm3,
    /// Optional behaviour.
    pub quirks: Quirks,
}

impl SimSettings {
    /// A homed machine that starts at `start_mm`, machine coordinates, mm: homing takes 1 s, a work offset is
    /// set, and no optional behaviour.
    #[must_use]
    pub fn of(machine: MachineProfile, start_mm: Mm3) -> Self {
        Self {
            start_mm,
            homed: true,
            homing: Duration::from_secs(1),
            work_offset_mm: Mm3::new(-37.25, -21.5, if machine.z.is_some() { -12.5 } else { 0.0 }),
            machine,
            quirks: Quirks::default(),
        }
    }

    /// Whether a place is beyond the travel. Each axis runs from zero downward.
    pub(super) fn is_beyond(&self, Mm3 { x, y, z }: Mm3) -> bool {
        let [width, height] = self.machine.travel_mm;
        let depth = self.machine.z.as_ref().map_or(0.0, |axis| axis.travel_mm);
        !(-width..=0.0).contains(&x) || !(-height..=0.0).contains(&y) || !(-depth..=0.0).contains(&z)
    }
}

/// Behaviour that some controllers in use show, and others do not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quirks {
    /// grblHAL without its fast hold: a cancelled jog stays on the path.
    pub plain_hold: bool,
    /// GRBL's `$1`: after a motion the controller reads and answers no line for this time. A jog line that
    /// arrives meanwhile becomes a programmed motion, which no cancel stops.
    pub idle_delay: Duration,
    /// The stored startup lines.
    pub startup: [String; 2],
    /// Whether the controller sends no greeting after a reset or a power failure.
    pub silent_reset: bool,
    /// grblHAL without its lock after power-on (`$22` without 4): it starts idle, and counts from its present
    /// position.
    pub wakes_unlocked: bool,
    /// Whether a hold or a cancel can run away: if it ends exactly at the end of a block while another block
    /// is queued, the tool moves 65,535 steps along that block.
    pub stops_run_away: bool,
}

/// The differences between GRBL 1.1 and grblHAL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Firmware {
    greeting: &'static str,
    rx_buffer: usize,
    line_max: usize,
    blocks: usize,
    /// Whether a hold cancels a jog.
    hold_cancels_jogs: bool,
    /// Whether a cancel drops the received bytes.
    cancel_flushes: bool,
    /// Whether a cancel spreads the remaining steps over another block.
    cancel_strays: bool,
    /// Further fields of reports.
    extra: &'static str,
}

const GRBL: Firmware = Firmware {
    greeting: "\r\nGrbl 1.1h ['$' for help]\r\n",
    rx_buffer: 128,
    line_max: 80,
    blocks: 15,
    hold_cancels_jogs: true,
    cancel_flushes: false,
    cancel_strays: false,
    extra: "",
};

const GRBL_HAL: Firmware = Firmware {
    greeting: "\r\nGrblHAL 1.1f ['$' or '$HELP' for help]\r\n",
    rx_buffer: 1024,
    line_max: 120,
    blocks: 100,
    hold_cancels_jogs: false,
    cancel_flushes: true,
    cancel_strays: true,
    extra: "|TLR:0|H:1",
};

/// A block leaves the planner when the last of its steps are in the segment buffer: six segments of 10 ms.
const SEGMENTS_S: f64 = 0.06;
/// Motion time in grblHAL's segment buffer. A cancel drops it.
const PREPARED_S: f64 = 0.1;
/// Every report whose number is a multiple of this carries the work offset.
const OFFSET_EVERY: u32 = 30;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Idle,
    Jog,
    Run,
    Hold,
    Home(Time),
    Alarm,
    /// After ALARM:2 the controller answers no line until a reset.
    Locked,
}

/// The meaning of bare axis words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MotionMode {
    /// G0 or G1.
    Straight,
    Arc {
        left: bool,
    },
    Cancelled,
}

/// The unplanned motions of a line. The controller sends `ok` when all are planned.
#[derive(Clone, Debug)]
struct Waiting {
    targets: VecDeque<Mm3>,
    feed: f64,
    jog: bool,
}

/// The simulated controller.
#[derive(Clone, Debug)]
pub struct GrblSim {
    firmware: Firmware,
    settings: SimSettings,
    motion: QueuedMotion,
    mode: Mode,
    rx: VecDeque<u8>,
    line: Vec<u8>,
    overflowed: bool,
    waiting: Option<Waiting>,
    tx: Vec<u8>,
    now: Time,
    reports: u32,
    report_mask: u16,
    arc_tolerance_mm: f64,
    feed: f64,
    absolute: bool,
    motion_mode: MotionMode,
    startup: [String; 2],
    in_g54: bool,
    /// Whether G20 is active.
    inches: bool,
    /// Speed of the spindle, rpm. Zero while it stands.
    spindle_rpm: f64,
    /// The controller reads and answers no line until this time.
    deaf_until: Option<Time>,
    /// Whether a cancel ended the last motion, or is about to end it.
    cancelled: bool,
    /// Whether a second cancel arrived just after the first one had stopped the tool. Reports then state
    /// idle, and the controller reads no line until `~`.
    hangs: bool,
    /// Whether a status query arrived meanwhile.
    asked_meanwhile: bool,
    /// True position minus the position that the controller counts, mm: zero until a power failure.
    unknown_by: Mm3,
    samples: Vec<Sample>,
    lost_bytes: u64,
}

impl GrblSim {
    /// A GRBL 1.1 controller that was just switched on.
    #[must_use]
    pub fn new(settings: SimSettings) -> Self {
        Self::with(settings, GRBL)
    }

    /// A grblHAL controller that was just switched on.
    #[must_use]
    pub fn hal(settings: SimSettings) -> Self {
        Self::with(settings, GRBL_HAL)
    }

    fn with(settings: SimSettings, firmware: Firmware) -> Self {
        Self {
            firmware,
            motion: at_rest(&settings, settings.start_mm),
            mode: if settings.homed { Mode::Idle } else { Mode::Alarm },
            startup: settings.quirks.startup.clone(),
            settings,
            rx: VecDeque::new(),
            line: Vec::new(),
            overflowed: false,
            waiting: None,
            tx: firmware.greeting.as_bytes().to_vec(),
            now: Time::ZERO,
            reports: 0,
            report_mask: 1,
            arc_tolerance_mm: 0.002,
            feed: 0.0,
            absolute: true,
            motion_mode: MotionMode::Straight,
            in_g54: true,
            inches: false,
            spindle_rpm: 0.0,
            deaf_until: None,
            cancelled: false,
            hangs: false,
            asked_meanwhile: false,
            unknown_by: Mm3::ZERO,
            samples: Vec::new(),
            lost_bytes: 0,
        }
    }

    /// The number of bytes lost because the receive buffer was full.
    #[must_use]
    pub fn lost_bytes(&self) -> u64 {
        self.lost_bytes
    }

    /// Runs until the next event, `now` at most.
    fn go_on(&mut self, now: Time) {
        let now = self.deaf_until.map_or(now, |until| until.min(now)).max(self.now);
        let (kind, by) = (self.sample_kind(), self.unknown_by);
        let sample = |position: Mm3, at| Sample { at, position_mm: position + by, kind };
        let (at, outcome) = run_motion(&mut self.motion, [self.now, now], sample, &mut self.samples);
        match outcome {
            StepOutcome::Held => self.mode = Mode::Hold,
            StepOutcome::Flushed => self.come_to_idle(at),
            StepOutcome::Going if self.motion.is_resting() && matches!(self.mode, Mode::Jog | Mode::Run) => {
                self.come_to_idle(at);
            }
            StepOutcome::Going => {}
        }
        self.samples.push(sample(self.motion.position(), at));
        self.now = at;
        if self.deaf_until.is_some_and(|until| until <= at) {
            self.hear_again();
        }
        self.plan_waiting();
        self.process_lines();
    }

    /// Whether it simulates grblHAL.
    fn is_hal(&self) -> bool {
        self.firmware == GRBL_HAL
    }

    /// Handles the end of a motion: idle at once, or after the delay in which the main program stands still.
    fn come_to_idle(&mut self, at: Time) {
        if self.settings.quirks.idle_delay.is_zero() {
            self.mode = Mode::Idle;
            self.cancelled = false;
        } else if self.deaf_until.is_none() {
            self.deaf_until = Some(at.after(self.settings.quirks.idle_delay));
        }
    }

    /// Ends the delay. A jog line that arrived just before is planned now, and started as a programmed
    /// motion.
    fn hear_again(&mut self) {
        self.deaf_until = None;
        self.cancelled = false;
        if self.rx.contains(&b'\n') && self.mode == Mode::Jog {
            self.process_line();
            self.plan_waiting();
        }
        self.mode = if self.motion.queued() > 0 { Mode::Run } else { Mode::Idle };
        if std::mem::take(&mut self.asked_meanwhile) {
            self.report();
        }
    }

    fn sample_kind(&self) -> SampleKind {
        match self.mode {
            Mode::Jog => SampleKind::Jog,
            Mode::Run => SampleKind::Run,
            _ => SampleKind::Rest,
        }
    }

    fn reply(&mut self, text: &str) {
        self.tx.extend(text.as_bytes());
        self.tx.extend(b"\r\n");
    }

    fn report(&mut self) {
        if self.deaf_until.is_some() {
            self.asked_meanwhile = true;
            return;
        }
        let state = match self.mode {
            Mode::Idle => "Idle",
            Mode::Jog => "Jog",
            Mode::Run if self.motion.is_stopping() => "Hold:1",
            Mode::Run => "Run",
            Mode::Hold => "Hold:0",
            Mode::Alarm => "Alarm",
            Mode::Home(_) | Mode::Locked => return,
        };
        let Mm3 { x, y, z } = self.motion.position();
        let machine = &self.settings.machine;
        let step = |c: f64, steps_per_mm: f64| (c * steps_per_mm).round() / steps_per_mm;
        let (x, y) = (step(x, machine.steps_per_mm), step(y, machine.steps_per_mm));
        let z = machine.z.as_ref().map_or(0.0, |axis| step(z, axis.steps_per_mm));
        let mut text = format!("<{state}|MPos:{x:.3},{y:.3},{z:.3}");
        if self.report_mask & 2 != 0 {
            let queued = self.motion.queued_behind(SEGMENTS_S);
            let free = self.firmware.blocks - queued.min(self.firmware.blocks);
            text += &format!("|Bf:{free},{}", self.firmware.rx_buffer - self.rx.len());
        }
        text += &format!("|FS:{:.0},{:.0}", self.motion.speed() * 60.0, self.spindle_rpm);
        let reports_offset = !self.is_hal() || self.report_mask & 32 != 0;
        if reports_offset && self.reports.is_multiple_of(OFFSET_EVERY) {
            let Mm3 { x, y, z } = self.work_offset();
            text += &format!("|WCO:{x:.3},{y:.3},{z:.3}");
        }
        self.reports += 1;
        text += self.firmware.extra;
        self.reply(&(text + ">"));
    }

    /// The active work offset: G54's as set up, G55's zero.
    fn work_offset(&self) -> Mm3 {
        if self.in_g54 { self.settings.work_offset_mm } else { Mm3::ZERO }
    }

    fn feed_hold(&mut self) {
        match self.mode {
            _ if self.deaf_until.is_some() => {}
            Mode::Jog if self.firmware.hold_cancels_jogs => self.motion.cancel(),
            Mode::Run => self.motion.hold(),
            Mode::Idle => self.mode = Mode::Hold,
            _ => {}
        }
    }

    fn cycle_start(&mut self) {
        if std::mem::take(&mut self.hangs) {
            self.process_lines();
        }
        if self.mode == Mode::Hold {
            self.motion.resume();
            self.mode = if self.motion.queued() > 0 { Mode::Run } else { Mode::Idle };
        }
    }

    fn jog_cancel(&mut self) {
        if self.mode != Mode::Jog {
            return;
        }
        if self.deaf_until.is_some() {
            self.hangs = self.cancelled;
            return;
        }
        self.cancelled = true;
        if self.firmware.cancel_strays && !self.settings.quirks.plain_hold {
            self.motion.cancel_astray(PREPARED_S);
        } else {
            self.motion.cancel();
        }
        if self.firmware.cancel_flushes {
            self.rx.clear();
            self.line.clear();
            self.waiting = None;
        }
    }

    fn reset(&mut self) {
        let moving = self.motion.speed() > 0.0 || matches!(self.mode, Mode::Home(_));
        self.motion.kill();
        self.rx.clear();
        self.line.clear();
        self.waiting = None;
        if moving {
            self.reply("ALARM:3");
        }
        self.mode =
            if moving || matches!(self.mode, Mode::Alarm | Mode::Locked) { Mode::Alarm } else { Mode::Idle };
        if !self.settings.quirks.silent_reset {
            self.spindle_rpm = 0.0;
            self.tx.extend(self.firmware.greeting.as_bytes());
        }
        (self.in_g54, self.absolute, self.inches) = (true, true, false);
        (self.deaf_until, self.asked_meanwhile) = (None, false);
        (self.cancelled, self.hangs) = (false, false);
        self.feed = 1e9;
        self.motion_mode = MotionMode::Straight;
        if self.mode == Mode::Idle {
            for line in self.startup.clone().iter().filter(|line| !line.is_empty()) {
                self.reply(&format!(">{line}:ok"));
                let _ = self.program(line);
            }
        }
    }

    /// Simulates a power failure: the motion stops at once, and the controller counts from its present
    /// position. With homing enabled it locks, unless `wakes_unlocked` is set.
    fn brown_out(&mut self) {
        self.unknown_by += self.motion.position();
        self.motion = at_rest(&self.settings, Mm3::ZERO);
        self.mode = Mode::Idle;
        self.tx.clear();
        self.reset();
        if !self.settings.quirks.wakes_unlocked {
            self.mode = Mode::Alarm;
        }
    }

    /// Ends homing: the position is known again.
    fn homed(&mut self) {
        let position = self.motion.position() + std::mem::take(&mut self.unknown_by);
        self.motion = at_rest(&self.settings, position);
        self.mode = Mode::Idle;
        self.reply("ok");
    }

    /// Reads lines from the receive buffer until one has to wait.
    fn process_lines(&mut self) {
        while self.deaf_until.is_none() && !self.hangs && self.process_line() {}
    }

    /// Reads one line. Returns whether another may follow.
    fn process_line(&mut self) -> bool {
        while self.waiting.is_none() && !matches!(self.mode, Mode::Home(_) | Mode::Locked | Mode::Hold) {
            let Some(byte) = self.rx.pop_front() else { break };
            if byte != b'\n' && byte != b'\r' {
                if self.line.len() < self.firmware.line_max {
                    self.line.push(byte)
                } else {
                    self.overflowed = true
                }
                continue;
            }
            let line = std::mem::take(&mut self.line);
            if std::mem::take(&mut self.overflowed) {
                self.reply("error:11");
                return true;
            }
            let text: String = String::from_utf8_lossy(&line)
                .chars()
                .filter(|c| !c.is_whitespace())
                .collect::<String>()
                .to_uppercase();
            match self.execute(&text) {
                Ok(true) => self.reply("ok"),
                Ok(false) => {}
                Err(code) => self.reply(&format!("error:{code}")),
            }
            self.plan_waiting();
            return true;
        }
        false
    }

    /// Plans the waiting motions, as far as the planner has room.
    fn plan_waiting(&mut self) {
        let stopping = matches!(self.mode, Mode::Hold | Mode::Alarm | Mode::Locked);
        let Some(waiting) = self.waiting.as_mut().filter(|_| !stopping) else { return };
        // A cancel stops the main program until the tool is at rest; a hold does not.
        if waiting.jog && (self.mode == Mode::Run || self.motion.is_stopping()) {
            return;
        }
        let shortest = 0.5 / self.settings.machine.steps_per_mm;
        while self.motion.queued() < self.firmware.blocks {
            let Some(target) = waiting.targets.pop_front() else { break };
            let moves = self.motion.push(target, waiting.feed, shortest);
            if moves && self.mode == Mode::Idle {
                self.mode = if waiting.jog { Mode::Jog } else { Mode::Run };
            }
        }
        if waiting.targets.is_empty() {
            self.waiting = None;
            self.reply("ok");
        }
    }
}

/// The drives at rest at a position, machine coordinates, mm, with GRBL's default junction deviation (`$11`).
fn at_rest(settings: &SimSettings, place_mm: Mm3) -> QueuedMotion {
    let motion = QueuedMotion::new(Drives::of(&settings.machine, 0.01), place_mm);
    if settings.quirks.stops_run_away { motion.with_runaway(settings.machine.steps_per_mm) } else { motion }
}

impl SimulatedController for GrblSim {
    /// Acts on realtime characters at once, and puts others into the receive buffer.
    fn receive(&mut self, byte: u8) {
        match byte {
            b'?' => self.report(),
            b'!' => self.feed_hold(),
            b'~' => self.cycle_start(),
            0x18 => self.reset(),
            0x85 => self.jog_cancel(),
            0x80..=0xff => {}
            _ if self.rx.len() < self.firmware.rx_buffer => self.rx.push_back(byte),
            _ => self.lost_bytes += 1,
        }
        if byte == b'\n' || byte == b'\r' {
            self.process_lines();
        }
    }

    fn is_realtime(&self, byte: u8) -> bool {
        matches!(byte, b'\n' | b'\r' | b'?' | b'!' | b'~' | 0x18 | 0x80..)
    }

    fn transmit(&mut self, into: &mut Vec<u8>) {
        into.append(&mut self.tx);
    }

    fn take_samples(&mut self, into: &mut Vec<Sample>) {
        into.append(&mut self.samples);
    }

    fn advance(&mut self, now: Time) {
        if let Mode::Home(done) = self.mode
            && now >= done
        {
            self.now = self.now.max(done);
            self.homed();
            self.process_lines();
        }
        while self.now < now {
            self.go_on(now);
        }
    }

    fn next_event(&self) -> Time {
        if let Mode::Home(done) = self.mode {
            return done;
        }
        if let Some(until) = self.deaf_until {
            return until;
        }
        let busy = self.waiting.is_some() || self.motion.is_stopping() || !self.rx.is_empty();
        match self.motion.next_event() {
            Some(seconds) if busy => self.now.after(Duration::from_secs_f64(seconds + 2e-6)),
            _ => Time::NEVER,
        }
    }

    fn is_moving(&self) -> bool {
        self.motion.next_event().is_some()
    }

    fn disturb(&mut self, disturbance: Disturbance) {
        match disturbance {
            Disturbance::Reset => self.reset(),
            Disturbance::BrownOut => self.brown_out(),
            Disturbance::Alarm => {
                self.motion.kill();
                self.mode = Mode::Alarm;
                self.reply("ALARM:1");
            }
        }
    }
}

#[cfg(test)]
mod tests;

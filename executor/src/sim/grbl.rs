//! A controller that speaks GRBL 1.1, as far as a host can see.
//!
//! Behaviour follows what was observed on the real firmware: `$J=` is acknowledged when its block is planned, a line
//! that finds the planner full waits with its absolute target, 0x85 acts only while jogging and leaves waiting bytes
//! alone, so that a line that waited is planned from where the tool stopped.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_planner::machine::MachineProfile;

use super::controller::{Controller, Disturbance};
use super::motion::{Drives, Motion, Outcome, Sample, SampleKind};
use crate::time::Time;

/// How the simulated controller is set up.
#[derive(Clone, Debug, PartialEq)]
pub struct SimSettings {
    /// The machine.
    pub machine: MachineProfile,
    /// Where the tool stands at power-up, machine coordinates, mm.
    pub start_mm: (f64, f64),
    /// Whether it is homed already.
    pub homed: bool,
    /// How long homing takes.
    pub homing: Duration,
    /// Work offset of G54, machine coordinates, mm: programmed motions count from there.
    pub work_offset_mm: (f64, f64),
}

/// What GRBL 1.1 and grblHAL do differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Firmware {
    greeting: &'static str,
    rx_buffer: usize,
    line_max: usize,
    blocks: usize,
    /// A hold stops a jog, as a cancel would.
    hold_cancels_jogs: bool,
    /// A cancel throws away what was received.
    cancel_flushes: bool,
    /// What reports carry besides.
    extra: &'static str,
}

const GRBL: Firmware = Firmware {
    greeting: "\r\nGrbl 1.1h ['$' for help]\r\n",
    rx_buffer: 128,
    line_max: 80,
    blocks: 15,
    hold_cancels_jogs: true,
    cancel_flushes: false,
    extra: "",
};

const GRBL_HAL: Firmware = Firmware {
    greeting: "\r\nGrblHAL 1.1f ['$' or '$HELP' for help]\r\n",
    rx_buffer: 1024,
    line_max: 120,
    blocks: 100,
    hold_cancels_jogs: false,
    cancel_flushes: true,
    extra: "|TLR:0|H:1",
};

/// Reports carry the work offset every so many times.
const OFFSET_EVERY: u32 = 30;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Idle,
    Jog,
    Run,
    Hold,
    Home(Time),
    Alarm,
    /// After ALARM:2 nothing is answered until a reset.
    Locked,
}

/// What bare axis words mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MotionMode {
    /// G0 or G1.
    Straight,
    Arc {
        left: bool,
    },
    Cancelled,
}

/// Motions of a line that still have to be planned; its `ok` comes when all are.
#[derive(Clone, Debug)]
struct Waiting {
    targets: VecDeque<(f64, f64)>,
    feed: f64,
    jog: bool,
}

/// The simulated controller.
#[derive(Clone, Debug)]
pub struct GrblSim {
    firmware: Firmware,
    settings: SimSettings,
    motion: Motion,
    mode: Mode,
    rx: VecDeque<u8>,
    line: Vec<u8>,
    overflowed: bool,
    waiting: Option<Waiting>,
    tx: Vec<u8>,
    now: Time,
    reports: u32,
    report_mask: u8,
    arc_tolerance_mm: f64,
    feed: f64,
    absolute: bool,
    motion_mode: MotionMode,
    startup: [String; 2],
    in_g54: bool,
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
        let drives = Drives {
            max_rate: settings.machine.max_rate_mm_s,
            acceleration: settings.machine.acceleration_mm_s2,
            junction_deviation: 0.01,
        };
        Self {
            firmware,
            motion: Motion::new(drives, settings.start_mm),
            mode: if settings.homed { Mode::Idle } else { Mode::Alarm },
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
            startup: [String::new(), String::new()],
            in_g54: true,
            samples: Vec::new(),
            lost_bytes: 0,
        }
    }

    /// Bytes that found the receive buffer full.
    #[must_use]
    pub fn lost_bytes(&self) -> u64 {
        self.lost_bytes
    }

    /// Goes on by the time to the next thing that happens, `now` at most.
    fn go_on(&mut self, now: Time) {
        let left = now.since(self.now).as_secs_f64();
        let step = self.motion.next_event().map_or(left, |event| (event + 1e-6).min(left));
        let at = if step < left { self.now.after(Duration::from_secs_f64(step)) } else { now };
        let kind = self.sample_kind();
        let samples = &mut self.samples;
        let outcome = self.motion.advance(step, |position_mm| samples.push(Sample { at, position_mm, kind }));
        match outcome {
            Outcome::Held => self.mode = Mode::Hold,
            Outcome::Flushed => self.mode = Mode::Idle,
            Outcome::Going if self.motion.is_resting() && matches!(self.mode, Mode::Jog | Mode::Run) => {
                self.mode = Mode::Idle;
            }
            Outcome::Going => {}
        }
        self.samples.push(Sample { at, position_mm: self.motion.position(), kind });
        self.now = at;
        self.plan_waiting();
        self.process_lines();
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
        let state = match self.mode {
            Mode::Idle => "Idle",
            Mode::Jog => "Jog",
            Mode::Run if self.motion.is_stopping() => "Hold:1",
            Mode::Run => "Run",
            Mode::Hold => "Hold:0",
            Mode::Alarm => "Alarm",
            Mode::Home(_) | Mode::Locked => return,
        };
        let (x, y) = self.motion.position();
        let step =
            |c: f64| (c * self.settings.machine.steps_per_mm).round() / self.settings.machine.steps_per_mm;
        let mut text = format!("<{state}|MPos:{:.3},{:.3},0.000", step(x), step(y));
        if self.report_mask & 2 != 0 {
            let free = self.firmware.blocks - self.motion.queued().min(self.firmware.blocks);
            text += &format!("|Bf:{free},{}", self.firmware.rx_buffer - self.rx.len());
        }
        text += &format!("|FS:{:.0},0", self.motion.speed() * 60.0);
        if self.reports.is_multiple_of(OFFSET_EVERY) {
            let (x, y) = self.work_offset();
            text += &format!("|WCO:{x:.3},{y:.3},0.000");
        }
        self.reports += 1;
        text += self.firmware.extra;
        self.reply(&(text + ">"));
    }

    /// G54's offset as set up; G55's is zero.
    fn work_offset(&self) -> (f64, f64) {
        if self.in_g54 { self.settings.work_offset_mm } else { (0.0, 0.0) }
    }

    fn feed_hold(&mut self) {
        match self.mode {
            Mode::Jog if self.firmware.hold_cancels_jogs => self.motion.cancel(),
            Mode::Run => self.motion.hold(),
            Mode::Idle => self.mode = Mode::Hold,
            _ => {}
        }
    }

    fn cycle_start(&mut self) {
        if self.mode == Mode::Hold {
            self.motion.resume();
            self.mode = if self.motion.queued() > 0 { Mode::Run } else { Mode::Idle };
        }
    }

    fn jog_cancel(&mut self) {
        if self.mode != Mode::Jog {
            return;
        }
        self.motion.cancel();
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
        self.tx.extend(self.firmware.greeting.as_bytes());
        self.in_g54 = true;
        self.absolute = true;
        self.feed = 1e9;
        self.motion_mode = MotionMode::Straight;
        if self.mode == Mode::Idle {
            for line in self.startup.clone().iter().filter(|line| !line.is_empty()) {
                self.reply(&format!(">{line}:ok"));
                let _ = self.program(line);
            }
        }
    }

    /// Reads lines from the receive buffer until one has to wait.
    fn process_lines(&mut self) {
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
                continue;
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
        }
    }

    /// Executes a line: whether its `ok` is due now.
    fn execute(&mut self, line: &str) -> Result<bool, u8> {
        match line {
            "" => Ok(true),
            "$" => {
                self.reply("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]");
                Ok(true)
            }
            "$I" => {
                self.reply("[VER:1.1h.20190825:simulated]");
                self.reply(&format!("[OPT:V,{},{}]", self.firmware.blocks, self.firmware.rx_buffer));
                Ok(true)
            }
            "$G" => {
                let (place, units) = (if self.in_g54 { 54 } else { 55 }, if self.absolute { 90 } else { 91 });
                self.reply(&format!(
                    "[GC:G1 G{place} G17 G21 G{units} G94 M5 M9 T0 F{:.0} S0]",
                    self.feed * 60.0
                ));
                Ok(true)
            }
            "$$" => {
                self.list_settings();
                Ok(true)
            }
            "$H" => {
                self.mode = Mode::Home(self.now.after(self.settings.homing));
                Ok(false)
            }
            "$X" => {
                self.mode = if self.mode == Mode::Alarm { Mode::Idle } else { self.mode };
                Ok(true)
            }
            _ if line.starts_with("$J=") => self.jog(&line[3..]),
            _ if line.starts_with("$10=") => {
                self.report_mask = line[4..].parse().map_err(|_| 2_u8)?;
                Ok(true)
            }
            _ if line.starts_with("$12=") => {
                self.arc_tolerance_mm = line[4..].parse().map_err(|_| 2_u8)?;
                Ok(true)
            }
            "$#" => {
                let (x, y) = self.settings.work_offset_mm;
                self.reply(&format!("[G54:{x:.3},{y:.3},0.000]"));
                for name in ["G55", "G56", "G57", "G58", "G59", "G28", "G30", "G92"] {
                    self.reply(&format!("[{name}:0.000,0.000,0.000]"));
                }
                self.reply("[TLO:0.000]");
                self.reply("[PRB:0.000,0.000,0.000:0]");
                Ok(true)
            }
            "$N" => {
                for (number, text) in self.startup.clone().iter().enumerate() {
                    self.reply(&format!("$N{number}={text}"));
                }
                Ok(true)
            }
            _ if line.starts_with("$N0=") || line.starts_with("$N1=") => {
                self.startup[usize::from(line.starts_with("$N1="))] = line[4..].into();
                Ok(true)
            }
            _ if line.starts_with('$') => Err(3),
            _ if self.mode == Mode::Alarm => Err(9),
            _ if self.mode == Mode::Jog => Err(9),
            _ => self.program(line),
        }
    }

    fn list_settings(&mut self) {
        let machine = self.settings.machine.clone();
        let per_minute = machine.max_rate_mm_s * 60.0;
        let values = [
            (10, f64::from(self.report_mask)),
            (11, 0.01),
            (12, self.arc_tolerance_mm),
            (13, 0.0),
            (20, 1.0),
            (21, 1.0),
            (22, 1.0),
            (100, machine.steps_per_mm),
            (101, machine.steps_per_mm),
            (110, per_minute),
            (111, per_minute),
            (120, machine.acceleration_mm_s2),
            (121, machine.acceleration_mm_s2),
            (130, machine.stroke_mm[0]),
            (131, machine.stroke_mm[1]),
        ];
        for (number, value) in values {
            let text = if [10, 13, 20, 21, 22].contains(&number) {
                format!("${number}={value:.0}")
            } else {
                format!("${number}={value:.3}")
            };
            self.reply(&text);
        }
    }

    fn jog(&mut self, text: &str) -> Result<bool, u8> {
        if !matches!(self.mode, Mode::Idle | Mode::Jog) {
            return Err(8);
        }
        let words = words(text)?;
        if words.iter().any(|&(letter, value)| letter == 'G' && (value == 0.0 || value == 1.0)) {
            return Err(16);
        }
        let feed = value_of(&words, 'F').ok_or(22_u8)?;
        let relative = words.contains(&('G', 91.0));
        let offset = if words.contains(&('G', 53.0)) { (0.0, 0.0) } else { self.work_offset() };
        let to = self.target(&words, !relative, offset)?;
        if self.is_beyond(to) {
            return Err(15);
        }
        self.waiting = Some(Waiting { targets: VecDeque::from([to]), feed: feed / 60.0, jog: true });
        Ok(false)
    }

    fn program(&mut self, text: &str) -> Result<bool, u8> {
        let words = words(text)?;
        for &(letter, value) in &words {
            if letter == 'G' {
                match value {
                    0.0 | 1.0 => self.motion_mode = MotionMode::Straight,
                    2.0 | 3.0 => self.motion_mode = MotionMode::Arc { left: value > 2.5 },
                    80.0 => self.motion_mode = MotionMode::Cancelled,
                    90.0 | 91.0 => self.absolute = value < 90.5,
                    // A change of work coordinates is told with the next report.
                    54.0 => (self.in_g54, self.reports) = (true, 0),
                    55.0 => (self.in_g54, self.reports) = (false, 0),
                    17.0 | 21.0 | 40.0 | 49.0 | 53.0 | 94.0 => {}
                    _ => return Err(20),
                }
            }
        }
        if let Some(feed) = value_of(&words, 'F') {
            self.feed = feed / 60.0;
        }
        if value_of(&words, 'X').is_none() && value_of(&words, 'Y').is_none() {
            return Ok(true);
        }
        if self.motion_mode == MotionMode::Cancelled {
            return Err(31);
        }
        if self.feed <= 0.0 {
            return Err(22);
        }
        let to = self.target(&words, self.absolute, self.work_offset())?;
        let targets = match self.motion_mode {
            MotionMode::Arc { left } => self.arc_chords(to, &words, left)?,
            _ => VecDeque::from([to]),
        };
        if targets.iter().any(|&target| self.is_beyond(target)) {
            self.motion.kill();
            self.mode = Mode::Locked;
            self.reply("ALARM:2");
            self.reply("[MSG:Reset to continue]");
            return Ok(false);
        }
        self.waiting = Some(Waiting { targets, feed: self.feed, jog: false });
        Ok(false)
    }

    fn target(&self, words: &[(char, f64)], absolute: bool, offset: (f64, f64)) -> Result<(f64, f64), u8> {
        let end = self.motion.planned_end();
        let axis = |letter, from: f64, offset: f64| match value_of(words, letter) {
            Some(value) if absolute => value + offset,
            Some(value) => from + value,
            None => from,
        };
        let to = (single(axis('X', end.0, offset.0)), single(axis('Y', end.1, offset.1)));
        if to.0.is_finite() && to.1.is_finite() { Ok(to) } else { Err(2) }
    }

    /// GRBL's `mc_arc`, in 32-bit floats as there: the number of chords is rounded down, and a sweep that comes out on
    /// the wrong side of ±5e-7 becomes a full turn.
    #[expect(clippy::cast_possible_truncation, reason = "the firmware computes in f32")]
    fn arc_chords(
        &self,
        to: (f64, f64),
        words: &[(char, f64)],
        left: bool,
    ) -> Result<VecDeque<(f64, f64)>, u8> {
        const EPSILON: f32 = 5e-7;
        let from = self.motion.planned_end();
        let (x, y, to_x, to_y) = (from.0 as f32, from.1 as f32, to.0 as f32, to.1 as f32);
        let (i, j) = match value_of(words, 'R') {
            Some(radius) => centre_of(to_x - x, to_y - y, radius as f32, left)?,
            None => (value_of(words, 'I').unwrap_or(0.0) as f32, value_of(words, 'J').unwrap_or(0.0) as f32),
        };
        let (cx, cy) = (x + i, y + j);
        let radius = i.hypot(j);
        let miss = ((to_x - cx).hypot(to_y - cy) - radius).abs();
        if radius == 0.0 || miss > 0.005 && (miss > 0.5 || miss > 0.001 * radius) {
            return Err(33);
        }
        let (rx, ry, tx, ty) = (-i, -j, to_x - cx, to_y - cy);
        let turned = (rx * ty - ry * tx).atan2(rx * tx + ry * ty);
        let turned = match left {
            false if turned >= -EPSILON => turned - std::f32::consts::TAU,
            true if turned <= EPSILON => turned + std::f32::consts::TAU,
            _ => turned,
        };
        let tolerance = (self.arc_tolerance_mm as f32).min(radius);
        let count = (0.5 * turned * radius).abs() / (tolerance * (2.0 * radius - tolerance)).sqrt();
        let count = count.floor();
        let mut targets = VecDeque::new();
        let mut k = 1.0;
        while k < count {
            let phi = ry.atan2(rx) + turned * (k / count);
            targets.push_back((f64::from(cx + radius * phi.cos()), f64::from(cy + radius * phi.sin())));
            k += 1.0;
        }
        targets.push_back(to);
        Ok(targets)
    }

    fn is_beyond(&self, (x, y): (f64, f64)) -> bool {
        let [width, height] = self.settings.machine.stroke_mm;
        !(-width..=0.0).contains(&x) || !(-height..=0.0).contains(&y)
    }

    /// Plans what is waiting, as far as the planner has room.
    fn plan_waiting(&mut self) {
        let stopping = matches!(self.mode, Mode::Hold | Mode::Alarm | Mode::Locked);
        let Some(waiting) = self.waiting.as_mut().filter(|_| !stopping) else { return };
        // While a stop is under way the planner is not added to.
        if waiting.jog && self.mode == Mode::Run || self.motion.is_stopping() {
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

impl Controller for GrblSim {
    /// Realtime characters act at once, others wait in the receive buffer.
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

    fn minds(&self, byte: u8) -> bool {
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
            self.mode = Mode::Idle;
            self.reply("ok");
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
        let busy = self.waiting.is_some() || self.motion.is_stopping() || !self.rx.is_empty();
        match self.motion.next_event() {
            Some(seconds) if busy => self.now.after(Duration::from_secs_f64(seconds + 2e-6)),
            _ => Time::NEVER,
        }
    }

    fn disturb(&mut self, disturbance: Disturbance) {
        match disturbance {
            Disturbance::Reset => self.reset(),
            Disturbance::Alarm => {
                self.motion.kill();
                self.mode = Mode::Alarm;
                self.reply("ALARM:1");
            }
        }
    }
}

/// GRBL's arc by its radius: the centre, seen from the start.
fn centre_of(x: f32, y: f32, radius: f32, left: bool) -> Result<(f32, f32), u8> {
    if x == 0.0 && y == 0.0 {
        return Err(33);
    }
    let inside = 4.0 * radius * radius - x * x - y * y;
    if inside < 0.0 {
        return Err(34);
    }
    let h = -inside.sqrt() / x.hypot(y);
    let h = if left { -h } else { h };
    let h = if radius < 0.0 { -h } else { h };
    Ok((0.5 * (x - y * h), 0.5 * (y + x * h)))
}

/// A coordinate as the firmware holds it.
#[expect(clippy::cast_possible_truncation, reason = "the firmware computes in f32")]
fn single(value: f64) -> f64 {
    f64::from(value as f32)
}

fn words(text: &str) -> Result<Vec<(char, f64)>, u8> {
    let mut words = Vec::new();
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        if !letter.is_ascii_uppercase() {
            return Err(1);
        }
        let number = &rest[1..];
        let end = number.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(number.len());
        words.push((letter, number[..end].parse().map_err(|_| 2_u8)?));
        rest = &number[end..];
    }
    Ok(words)
}

fn value_of(words: &[(char, f64)], letter: char) -> Option<f64> {
    words.iter().find(|word| word.0 == letter).map(|word| word.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn idle() -> GrblSim {
        let settings = SimSettings {
            machine: MachineProfile::simulated(),
            start_mm: (-100.0, -100.0),
            homed: true,
            homing: Duration::from_secs(1),
            work_offset_mm: (-30.0, -20.0),
        };
        let mut sim = GrblSim::new(settings);
        sim.transmit(&mut Vec::new());
        sim
    }

    fn said(sim: &mut GrblSim) -> String {
        let mut bytes = Vec::new();
        sim.transmit(&mut bytes);
        String::from_utf8(bytes).unwrap()
    }

    fn samples(sim: &mut GrblSim) -> Vec<Sample> {
        let mut samples = Vec::new();
        sim.take_samples(&mut samples);
        samples
    }

    fn say(sim: &mut GrblSim, bytes: &[u8], ms: u64) -> String {
        bytes.iter().for_each(|&byte| sim.receive(byte));
        let until = sim.now.after(Duration::from_millis(ms));
        sim.advance(until);
        said(sim)
    }

    #[test]
    fn jog_is_acknowledged_when_planned_and_ends_idle() {
        let mut sim = idle();
        assert_eq!(say(&mut sim, b"$J=G53G90G21X-90Y-100F6000\n", 1), "ok\r\n");
        assert!(say(&mut sim, b"?", 20).starts_with("<Jog|MPos:-100.000,-100.000"));
        say(&mut sim, b"", 2000);
        assert!(say(&mut sim, b"?", 1).contains("<Idle|MPos:-90.000,-100.000"));
    }

    #[test]
    fn refusals_of_the_real_firmware() {
        let mut sim = idle();
        assert_eq!(say(&mut sim, b"$J=G90X-90\n", 1), "error:22\r\n");
        assert_eq!(say(&mut sim, b"$J=G1X-90F100\n", 1), "error:16\r\n");
        assert_eq!(say(&mut sim, b"$J=G90X35F100\n", 1), "error:15\r\n");
        assert_eq!(say(&mut sim, &[b'X'; 95], 1), "");
        assert_eq!(say(&mut sim, b"\n", 1), "error:11\r\n");
        assert_eq!(say(&mut sim, b"G2X-60Y-80I3J4F100\n", 1), "error:33\r\n");
        assert!(say(&mut sim, b"G1X35Y0F100\n", 1).starts_with("ALARM:2"));
        assert_eq!(say(&mut sim, b"?", 5), "", "nothing answers until reset");
        assert!(say(&mut sim, b"\x18", 5).contains("Grbl 1.1h"));
    }

    #[test]
    fn line_that_waits_through_a_cancel_runs_from_where_the_tool_stopped() {
        let mut sim = idle();
        for k in 0..16 {
            let line = format!("$J=G53G90G21X{}Y-100F6000\n", -99 + k);
            line.bytes().for_each(|byte| sim.receive(byte));
            let now = sim.now.after(Duration::from_millis(1));
            sim.advance(now);
        }
        let acknowledged = said(&mut sim).matches("ok").count();
        assert_eq!(acknowledged, 15, "the sixteenth waits for planner space");
        sim.receive(0x85);
        say(&mut sim, b"", 3000);
        let (x, _) = sim.motion.position();
        assert!((x - -84.0).abs() < 1e-6, "it drove on to the waiting line's target: {x}");
    }

    #[test]
    fn reset_while_moving_loses_the_position() {
        let mut sim = idle();
        say(&mut sim, b"$J=G53G90G21X-10Y-100F6000\n", 300);
        let text = say(&mut sim, b"\x18", 5);
        assert!(text.contains("ALARM:3") && text.contains("Grbl 1.1h"), "{text}");
        assert_eq!(say(&mut sim, b"$J=G90X-50F100\n", 5), "error:8\r\n");
    }

    #[test]
    fn arcs_are_chords_inside_the_circle_and_work_coordinates_count() {
        let mut sim = idle();
        assert_eq!(say(&mut sim, b"G21G90G17G94G55\nG54\n", 1), "ok\r\nok\r\n");
        assert!(say(&mut sim, b"?", 1).contains("WCO:-30.000,-20.000"));
        say(&mut sim, b"G3X-70Y-60I0J10F3000\n", 3000);
        let corners = samples(&mut sim);
        let places = corners.windows(2).flat_map(|pair| {
            let (a, b) = (pair[0].position_mm, pair[1].position_mm);
            (0..=8).map(f64::from).map(move |k| (a.0 + (b.0 - a.0) * k / 8.0, a.1 + (b.1 - a.1) * k / 8.0))
        });
        let off: Vec<f64> = places.map(|(x, y)| 10.0 - (x + 100.0).hypot(y + 90.0)).collect();
        let worst = off.iter().copied().fold(0.0_f64, f64::max);
        assert!(off.iter().all(|&off| off > -2e-5) && worst > 0.001 && worst < 4.0 * 0.002, "{worst}");
        assert!((sim.motion.position().1 - -80.0).abs() < 1e-5);
    }

    #[test]
    fn arc_of_almost_no_sweep_can_become_a_full_circle() {
        let mut sim = idle();
        say(&mut sim, b"G21G90G17G94\n", 1);
        // 20 nm along a circle of 3 mm: less than single precision holds at −100 mm.
        say(&mut sim, b"G3X-69.99999998Y-80I0J3F3000\n", 3000);
        let farthest = samples(&mut sim).iter().map(|s| s.position_mm.1 + 100.0).fold(0.0_f64, f64::max);
        assert!(farthest > 5.9, "that is why the guard refuses such arcs: {farthest}");
    }

    #[test]
    fn half_a_line_is_refused_by_what_a_session_begins_with() {
        for half in ["G91G1X5F600", "G0X-10", "$J=G91X5F600", "$10=", "$H"] {
            let mut sim = idle();
            let said = say(&mut sim, format!("{half}$\n").as_bytes(), 1000);
            assert!(said.contains("error:") && !said.contains("ok"), "{half}: {said}");
            assert_eq!(sim.motion.position(), (-100.0, -100.0), "{half}");
        }
    }
}

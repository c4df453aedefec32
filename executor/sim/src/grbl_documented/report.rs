//! Status reports, and the reports of `$G` and `$#`.
//!
//! Source: `doc/markdown/interface.md`, "Real-time Status Reports".

use std::fmt::Write as _;

use keepout_guard::Time;

use super::DocumentedGrbl;
use super::axes::Triple;
use super::modes::{MotionMode, SpindleMode};
use super::planner::BLOCKS;
use super::realtime::MachineState;

/// A report in this many carries the work offset: in motion, and at rest.
const OFFSET_EVERY: [u8; 2] = [30, 10];
/// A report in this many carries the overrides: in motion, and at rest.
const OVERRIDES_EVERY: [u8; 2] = [20, 10];
const INCH_MM: f64 = 25.4;

/// The next report, and the fields that it carries now and then.
#[derive(Clone, Debug)]
pub(super) struct ReportSchedule {
    due: Time,
    until_offset: u8,
    until_overrides: u8,
    rpm: f64,
}

impl Default for ReportSchedule {
    fn default() -> Self {
        Self { due: Time::NEVER, until_offset: 0, until_overrides: 0, rpm: 0.0 }
    }
}

impl ReportSchedule {
    /// A query, whose report leaves at this time. A second one before the report is ignored.
    pub fn ask(&mut self, due: Time) {
        self.due = self.due.min(due);
    }

    /// The time of the next report.
    pub fn due(&self) -> Time {
        self.due
    }

    /// The next report carries the work offset.
    pub fn show_offset(&mut self) {
        self.until_offset = 0;
    }

    /// The next report carries the overrides.
    pub fn show_overrides(&mut self) {
        self.until_overrides = 0;
    }

    pub fn turns_at(&mut self, rpm: f64) {
        self.rpm = rpm;
        self.show_overrides();
    }

    /// Forgets the query. The first report after a reset carries the work offset, the second the overrides.
    pub fn restart(&mut self) {
        *self = Self::default();
    }
}

impl DocumentedGrbl {
    /// Sends a status report.
    pub(super) fn report(&mut self) {
        self.reports.due = Time::NEVER;
        let scale = if self.eeprom.is_on(13) { INCH_MM } else { 1.0 };
        let digits = if self.eeprom.is_on(13) { 4 } else { 3 };
        let list = |of: Triple| {
            let [x, y, z] = of.map(|value| value / scale);
            format!("{x:.digits$},{y:.digits$},{z:.digits$}")
        };
        let mask = self.eeprom.value(10);
        let place = self.motion.mm_at(self.now);
        let offset = self.parser.work_offset(&self.eeprom);
        let mut text = format!("<{}|", self.state_name());
        // Writing to a string does not fail.
        let _ = if mask % 2.0 >= 1.0 {
            write!(text, "MPos:{}", list(place))
        } else {
            write!(text, "WPos:{}", list([0, 1, 2].map(|axis| place[axis] - offset[axis])))
        };
        if (mask / 2.0) % 2.0 >= 1.0 {
            let _ = write!(text, "|Bf:{},{}", BLOCKS - self.motion.queued().min(BLOCKS), self.serial.free());
        }
        let feed = self.motion.speed_at(self.now) * 60.0 / scale;
        let turns = self.parser.modes.spindle != SpindleMode::Stopped;
        let rpm = if turns { self.reports.rpm } else { 0.0 };
        let _ = write!(text, "|FS:{feed:.0},{rpm:.0}");
        let rests = usize::from(!self.motion.is_running());
        if self.reports.until_offset == 0 {
            let _ = write!(text, "|WCO:{}", list(offset));
            self.reports.until_offset = OFFSET_EVERY[rests];
            // The overrides wait for the next report.
            self.reports.until_overrides = self.reports.until_overrides.max(1);
        } else if self.reports.until_overrides == 0 {
            let [feed, rapid, spindle] = self.flags.overrides;
            let _ = write!(text, "|Ov:{feed},{rapid},{spindle}");
            self.reports.until_overrides = OVERRIDES_EVERY[rests];
            let spindle = match self.parser.modes.spindle {
                SpindleMode::Clockwise => "S",
                SpindleMode::CounterClockwise => "C",
                SpindleMode::Stopped => "",
            };
            let coolant = if self.parser.modes.flood { "F" } else { "" };
            if !spindle.is_empty() || !coolant.is_empty() {
                let _ = write!(text, "|A:{spindle}{coolant}");
            }
        }
        self.reports.until_offset = self.reports.until_offset.saturating_sub(1);
        self.reports.until_overrides = self.reports.until_overrides.saturating_sub(1);
        self.say(&(text + ">\r\n"));
    }

    fn state_name(&self) -> &'static str {
        match self.state {
            MachineState::Idle => "Idle",
            MachineState::Run => "Run",
            MachineState::Jog => "Jog",
            MachineState::Hold { complete: true } => "Hold:0",
            MachineState::Hold { complete: false } => "Hold:1",
            MachineState::Door { complete: true } => "Door:0",
            MachineState::Door { complete: false } => "Door:2",
            MachineState::Alarm => "Alarm",
            MachineState::Home => "Home",
            MachineState::Check => "Check",
            MachineState::Sleep => "Sleep",
        }
    }

    /// The answer to `$G`.
    pub(super) fn modes_text(&self) -> String {
        let modes = &self.parser.modes;
        let motion = match modes.motion {
            MotionMode::Rapid => "G0",
            MotionMode::Straight => "G1",
            MotionMode::Arc { clockwise: true } => "G2",
            MotionMode::Arc { clockwise: false } => "G3",
            MotionMode::Cancelled => "G80",
        };
        let units = if modes.inches { "G20" } else { "G21" };
        let distance = if modes.absolute { "G90" } else { "G91" };
        let feed_mode = if modes.inverse_time { "G93" } else { "G94" };
        let spindle = match modes.spindle {
            SpindleMode::Clockwise => "M3",
            SpindleMode::CounterClockwise => "M4",
            SpindleMode::Stopped => "M5",
        };
        let coolant = if modes.flood { "M8" } else { "M9" };
        let scale = if modes.inches { INCH_MM } else { 1.0 };
        format!(
            "[GC:{motion} G{} G{} {units} {distance} {feed_mode} {spindle} {coolant} T{:.0} F{:.0} S{:.0}]\r\n",
            54 + modes.system,
            modes.plane,
            modes.tool,
            modes.feed / scale,
            modes.rpm
        )
    }

    /// The answer to `$#`.
    pub(super) fn offsets_text(&self) -> String {
        let scale = if self.eeprom.is_on(13) { INCH_MM } else { 1.0 };
        let digits = if self.eeprom.is_on(13) { 4 } else { 3 };
        let list = |of: Triple| {
            let [x, y, z] = of.map(|value| value / scale);
            format!("{x:.digits$},{y:.digits$},{z:.digits$}")
        };
        let mut text = String::new();
        for (number, system) in (54..).zip(self.eeprom.systems) {
            let _ = write!(text, "[G{number}:{}]\r\n", list(system));
        }
        let [first, second] = self.eeprom.parked;
        let _ = write!(text, "[G28:{}]\r\n[G30:{}]\r\n", list(first), list(second));
        let _ = write!(text, "[G92:{}]\r\n", list(self.parser.shift));
        let _ = write!(text, "[TLO:{:.digits$}]\r\n", self.parser.tool_length / scale);
        let _ = write!(text, "[PRB:{}:0]\r\n", list([0.0; 3]));
        text
    }
}

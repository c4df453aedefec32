//! A second simulated controller for GRBL 1.1, written from the firmware's documentation alone.
//!
//! It shares no code with [`GrblSim`](crate::GrblSim) but the settings and the interface. Where both agree, two
//! authors read the documentation in the same way. Sources: `doc/markdown` and `doc/csv` of GRBL 1.1h, the
//! maintainers' answers in its issues, and the observations in `docs/safety/controllers.md`.
//!
//! ```text
//! bytes ──> receive buffer ──> line ──> parser ──> steps of the program ──> planner ──> segments ──> tool
//!   └─ real-time characters ──> flags of the machine state
//! ```

mod arc;
mod axes;
mod command;
mod late_copies;
mod modes;
mod parser;
mod planner;
mod program;
mod realtime;
mod report;
mod serial;
mod settings;
mod stepper;
#[cfg(test)]
mod tests;
mod words;

use std::time::Duration;

use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_planner::Mm3;

use self::axes::{StepPlace, to_mm, to_steps, triple};
use self::late_copies::LateCopies;
use self::parser::GcodeParser;
use self::planner::AxisLimits;
use self::program::ProgramTasks;
use self::realtime::{MachineState, RealtimeFlags};
use self::report::ReportSchedule;
use self::serial::ReceiveBuffer;
use self::settings::EepromContent;
use self::stepper::StepGenerator;
use crate::controller::{Disturbance, SimulatedController};
use crate::{Quirks, SimSettings};

/// A simulated GRBL 1.1 controller, written from the documentation.
///
/// Of the [`Quirks`] it has the idle delay, the startup lines and the silent reset, and it wakes unlocked. It never
/// runs away at a stop.
#[derive(Clone, Debug)]
pub struct DocumentedGrbl {
    quirks: Quirks,
    /// Factor of the times to parse a line and to send a report.
    slowness: u32,
    late: Option<LateCopies>,
    homing: Duration,
    /// The place after homing. Without one, the tool stays where it is.
    home: Option<StepPlace>,
    eeprom: EepromContent,
    now: Time,
    serial: ReceiveBuffer,
    program: ProgramTasks,
    parser: GcodeParser,
    motion: StepGenerator,
    state: MachineState,
    flags: RealtimeFlags,
    reports: ReportSchedule,
    /// The true position less the counted one, steps.
    lost: StepPlace,
    output: Vec<u8>,
    samples: Vec<Sample>,
    last_sample: Option<Sample>,
}

impl DocumentedGrbl {
    /// A controller with these settings.
    #[must_use]
    pub fn new(sim: SimSettings) -> Self {
        let eeprom = EepromContent::of(&sim);
        let limits = AxisLimits::of(&eeprom);
        let start = to_steps(triple(sim.start_mm), limits.steps_per_mm);
        let pull_off = -eeprom.value(27);
        let height = if sim.machine.z.is_some() { pull_off } else { sim.start_mm.z };
        let home = to_steps([pull_off, pull_off, height], limits.steps_per_mm);
        let wakes = sim.homed || sim.quirks.wakes_unlocked;
        let (counted, lost) = if sim.homed { (start, [0; 3]) } else { ([0; 3], start) };
        let mut controller = Self {
            quirks: sim.quirks,
            slowness: 1,
            late: None,
            homing: sim.homing,
            home: Some(home),
            eeprom,
            now: Time::ZERO,
            serial: ReceiveBuffer::default(),
            program: ProgramTasks::default(),
            parser: GcodeParser::default(),
            motion: StepGenerator::new(limits, counted),
            state: if wakes { MachineState::Idle } else { MachineState::Alarm },
            flags: RealtimeFlags::fresh(),
            reports: ReportSchedule::default(),
            lost,
            output: Vec::new(),
            samples: Vec::new(),
            last_sample: None,
        };
        controller.parser.position = controller.motion.mm_at(Time::ZERO);
        controller.greets();
        controller
    }

    /// The same controller, whose homing leaves the tool where it is, and counts from the true position.
    ///
    /// The collision monitor would see a real homing as a motion through the part. A person clears that way.
    #[must_use]
    pub fn homing_in_place(mut self) -> Self {
        self.home = None;
        self
    }

    /// The same controller, which takes this many times longer to parse a line and to send a report.
    ///
    /// The documentation names 1 ms to 5 ms for a line, and 5 ms to 20 ms for a report.
    #[must_use]
    pub fn slower(mut self, times: u32) -> Self {
        self.slowness = times.max(1);
        self
    }

    /// The same controller, in which some short motions stop up to three steps before their end. The next motion runs
    /// these steps. `docs/safety/controllers.md` describes this behaviour of GRBL 1.1h.
    #[must_use]
    pub fn leaving_steps(mut self, seed: u64) -> Self {
        self.motion.leave_steps(seed);
        self
    }

    /// The same controller, which rejects some jogs with `error:8`, and receives them again 1 ms to 200 ms later.
    #[must_use]
    pub fn repeating_late(mut self, seed: u64) -> Self {
        self.late = Some(LateCopies::of(seed));
        self
    }

    /// Receives a late copy of a line, or the next byte from behind it.
    fn receive_copy(&mut self) {
        let Some(late) = self.late.as_mut().filter(|late| late.due() <= self.now) else { return };
        if let Some(line) = late.take(self.now) {
            line.into_iter().chain(*b"\n").for_each(|byte| self.serial.put(byte));
        } else if let Some(byte) = late.next_byte(self.now) {
            self.receive_now(byte);
        }
    }

    fn receive_now(&mut self, byte: u8) {
        if self.is_deaf() {
            return;
        }
        if self.take_realtime(byte) || byte >= 0x80 {
            self.run();
            return;
        }
        self.serial.put(byte);
        if matches!(byte, b'\n' | b'\r') {
            self.run();
        }
    }

    /// Says what a start and a reset say. Without an alarm the startup lines follow.
    fn greets(&mut self) {
        if !self.quirks.silent_reset {
            self.say("\r\nGrbl 1.1h ['$' for help]\r\n");
        }
        if matches!(self.state, MachineState::Alarm | MachineState::Sleep) {
            self.state = MachineState::Alarm;
            self.say("[MSG:'$H'|'$X' to unlock]\r\n");
        } else {
            self.state = MachineState::Idle;
            self.program.run_startup();
        }
    }

    fn say(&mut self, text: &str) {
        self.output.extend_from_slice(text.as_bytes());
    }

    /// The true position of the tool, mm.
    fn true_mm(&self) -> Mm3 {
        let counted = self.motion.place_at(self.now);
        let place = [0, 1, 2].map(|axis| counted[axis] + self.lost[axis]);
        let [x, y, z] = to_mm(place, self.eeprom.axes(100));
        Mm3::new(x, y, z)
    }

    fn sample(&mut self) {
        let kind = match (self.motion.is_running(), self.motion.jogs()) {
            (false, _) => SampleKind::Rest,
            (true, true) => SampleKind::Jog,
            (true, false) => SampleKind::Run,
        };
        let sample = Sample { at: self.now, position_mm: self.true_mm(), kind };
        let rests = |last: &Sample| last.kind == kind && last.position_mm == sample.position_mm;
        if kind == SampleKind::Rest && self.last_sample.as_ref().is_some_and(rests) {
            return;
        }
        self.last_sample = Some(sample);
        self.samples.push(sample);
    }

    /// The time of the next event inside the controller.
    fn next_inside(&self) -> Time {
        let segment = self.motion.segment_end().unwrap_or(Time::NEVER);
        let copy = self.late.as_ref().map_or(Time::NEVER, LateCopies::due);
        segment.min(copy).min(self.next_of_program())
    }
}

impl SimulatedController for DocumentedGrbl {
    fn receive(&mut self, byte: u8) {
        if !self.late.as_mut().is_some_and(|late| late.holds(byte)) {
            self.receive_now(byte);
        }
    }

    fn is_realtime(&self, byte: u8) -> bool {
        // The end of a line starts work at once. While the firmware writes, every byte is lost at its own time.
        matches!(byte, b'?' | b'!' | b'~' | 0x18 | b'\n' | b'\r') || byte >= 0x80 || self.is_deaf()
    }

    fn advance(&mut self, now: Time) {
        loop {
            let next = self.next_inside();
            if next > now {
                break;
            }
            self.now = self.now.max(next);
            if self.motion.segment_end().is_some_and(|end| end <= self.now) {
                // The corner belongs to the motion that ends there.
                self.sample();
                if self.motion.end_segment() {
                    self.comes_to_rest();
                }
            }
            self.receive_copy();
            self.run();
        }
        self.now = self.now.max(now);
    }

    fn next_event(&self) -> Time {
        self.next_inside()
    }

    fn transmit(&mut self, into: &mut Vec<u8>) {
        into.append(&mut self.output);
    }

    fn take_samples(&mut self, into: &mut Vec<Sample>) {
        self.sample();
        into.append(&mut self.samples);
    }

    fn is_moving(&self) -> bool {
        self.motion.is_running()
    }

    fn disturb(&mut self, disturbance: Disturbance) {
        match disturbance {
            Disturbance::Reset => self.reset(),
            Disturbance::BrownOut => self.power_fails(),
            Disturbance::Alarm => self.raise_alarm(1),
        }
        self.run();
    }
}

//! Real-time characters, holds, resets and alarms.
//!
//! Source: `doc/markdown/commands.md`, "Realtime commands".

use std::time::Duration;

use keepout_guard::Time;

use super::DocumentedGrbl;
use super::modes::{ModalState, SpindleMode};
use super::planner::RateOverrides;

/// The state of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MachineState {
    Idle,
    Run,
    Jog,
    /// A feed hold. It is complete when the tool is at rest.
    Hold {
        complete: bool,
    },
    /// The safety door opened. It counts as closed again at once.
    Door {
        complete: bool,
    },
    Alarm,
    Home,
    Check,
    Sleep,
}

/// What the real-time characters left to do, and what the end of a motion left to do.
#[derive(Clone, Debug, Default)]
pub(super) struct RealtimeFlags {
    hold: bool,
    door: bool,
    cancel: bool,
    resume: bool,
    /// A jog is being cancelled.
    pub cancelling: bool,
    /// A cancel that came during the idle delay of another one. The controller executes nothing until `~`.
    pub stuck: bool,
    /// The motion ended, and the program has not noticed it.
    pub motion_ended: bool,
    /// Until this time the firmware delays after a motion, and does nothing else.
    pub delays_until: Time,
    /// A programmed motion leaves the travel. The alarm follows when the tool is at rest.
    pub soft_limit: bool,
    /// An alarm that only a reset ends.
    pub critical: bool,
    /// Feed, rapid and spindle overrides, %.
    pub overrides: [u8; 3],
}

impl RealtimeFlags {
    /// No flags, and overrides of 100 %.
    pub fn fresh() -> Self {
        Self { overrides: [100; 3], ..Self::default() }
    }
}

/// Time from a query to its report.
const LATENCY: Duration = Duration::from_millis(2);
/// The same with late copies: two queries behind a copy get a report each.
const PROMPT: Duration = Duration::from_micros(50);
/// Bounds of the overrides of feed and spindle, %.
const OVERRIDE: (u8, u8) = (10, 200);

impl DocumentedGrbl {
    /// Takes a real-time character. Returns whether the byte is one.
    pub(super) fn take_realtime(&mut self, byte: u8) -> bool {
        match byte {
            b'?' => {
                let latency = if self.late.is_some() { PROMPT } else { LATENCY * self.slowness };
                self.reports.ask(self.now.after(latency));
            }
            b'!' => self.flags.hold = true,
            b'~' => self.flags.resume = true,
            0x18 => self.reset(),
            0x84 => self.flags.door = true,
            0x85 if self.state == MachineState::Jog => {
                self.flags.stuck |= self.flags.cancelling && self.flags.motion_ended;
                self.flags.cancel = true;
            }
            0x90..=0x9d => self.set_override(byte),
            0xa0 => self.parser.modes.flood ^= true,
            _ => return false,
        }
        true
    }

    fn set_override(&mut self, byte: u8) {
        let before = self.flags.overrides;
        let step = |percent: u8, command: u8| -> u8 {
            let changed = match command {
                1 => percent.saturating_add(10),
                2 => percent.saturating_sub(10),
                3 => percent.saturating_add(1),
                4 => percent.saturating_sub(1),
                _ => 100,
            };
            changed.clamp(OVERRIDE.0, OVERRIDE.1)
        };
        let [feed, rapid, spindle] = &mut self.flags.overrides;
        match byte {
            0x90..=0x94 => *feed = step(*feed, byte - 0x90),
            0x95..=0x97 => *rapid = [100, 50, 25][usize::from(byte - 0x95)],
            0x99..=0x9d => *spindle = step(*spindle, byte - 0x99),
            _ => {}
        }
        if self.flags.overrides != before {
            self.reports.show_overrides();
            self.apply_overrides();
        }
    }

    fn apply_overrides(&mut self) {
        let [feed, rapid, _] = self.flags.overrides.map(|percent| f64::from(percent) / 100.0);
        self.motion.set_overrides(RateOverrides { feed, rapid });
    }

    /// Handles the flags. Returns whether it did something.
    pub(super) fn handle_flags(&mut self) -> bool {
        let flags = &mut self.flags;
        if std::mem::take(&mut flags.door) {
            self.open_door();
        } else if std::mem::take(&mut flags.hold) {
            self.flags.resume = false;
            self.hold();
        } else if std::mem::take(&mut flags.cancel) {
            self.flags.resume = false;
            self.cancel_jog();
        } else if std::mem::take(&mut flags.resume) {
            self.resume();
        } else if std::mem::take(&mut flags.motion_ended) {
            self.notice_end();
        } else {
            return false;
        }
        true
    }

    fn cancel_jog(&mut self) {
        if self.state == MachineState::Jog && !self.flags.cancelling {
            self.flags.cancelling = true;
            if self.motion.is_running() {
                self.motion.brake();
            } else {
                self.flags.motion_ended = true;
            }
        }
    }

    fn hold(&mut self) {
        match self.state {
            MachineState::Jog => self.cancel_jog(),
            MachineState::Run => {
                self.motion.brake();
                self.state = MachineState::Hold { complete: !self.motion.is_running() };
            }
            MachineState::Idle => self.state = MachineState::Hold { complete: true },
            _ => {}
        }
    }

    fn open_door(&mut self) {
        match self.state {
            MachineState::Jog => self.cancel_jog(),
            MachineState::Home => return self.raise_alarm(7),
            MachineState::Run => {
                self.motion.brake();
                self.state = MachineState::Door { complete: !self.motion.is_running() };
            }
            MachineState::Idle | MachineState::Hold { complete: true } => {
                self.state = MachineState::Door { complete: true };
            }
            MachineState::Hold { complete: false } => self.state = MachineState::Door { complete: false },
            _ => return,
        }
        self.say("[MSG:Check Door]\r\n");
    }

    fn resume(&mut self) {
        self.flags.stuck = false;
        let held = [MachineState::Hold { complete: true }, MachineState::Door { complete: true }];
        if self.state != MachineState::Idle && !held.contains(&self.state) {
            return;
        }
        self.state = MachineState::Idle;
        if self.motion.queued() > 0 {
            self.state = MachineState::Run;
            self.motion.start(self.now);
        }
    }

    /// The last prepared step was driven. The firmware delays, before it does anything else.
    pub(super) fn comes_to_rest(&mut self) {
        self.sample();
        self.flags.motion_ended = true;
        let delay = self.eeprom.value(1);
        if delay < 255.0 {
            self.flags.delays_until = self.now.after(Duration::from_secs_f64(delay / 1e3));
        }
    }

    /// The program notices that the motion ended.
    fn notice_end(&mut self) {
        match self.state {
            MachineState::Jog if self.flags.cancelling => {
                self.flags.cancelling = false;
                self.motion.empty();
                self.parser.position = self.motion.mm_at(self.now);
                self.state = MachineState::Idle;
            }
            MachineState::Run | MachineState::Jog => self.state = MachineState::Idle,
            MachineState::Hold { .. } => self.state = MachineState::Hold { complete: true },
            MachineState::Door { .. } => self.state = MachineState::Door { complete: true },
            _ => {}
        }
    }

    /// Whether the program executes no line: it is held, or a jog is being cancelled.
    pub(super) fn is_suspended(&self) -> bool {
        let holds =
            matches!(self.state, MachineState::Hold { .. } | MachineState::Door { .. } | MachineState::Sleep);
        holds || self.flags.cancelling || self.flags.stuck || self.flags.critical
    }

    /// A reset. In motion it raises an alarm, because steps may be lost.
    pub(super) fn reset(&mut self) {
        let moves = match self.state {
            MachineState::Run | MachineState::Jog => true,
            MachineState::Hold { complete } | MachineState::Door { complete } => !complete,
            _ => false,
        };
        if self.state == MachineState::Home {
            self.say("ALARM:6\r\n");
            self.state = MachineState::Alarm;
        } else if moves {
            self.say("ALARM:3\r\n");
            self.state = MachineState::Alarm;
        }
        self.restart();
    }

    /// The power fails and returns. The count begins at zero, and the tool is where it was.
    pub(super) fn power_fails(&mut self) {
        self.motion.halt(self.now);
        self.output.clear();
        let counted = self.motion.place_at(self.now);
        self.lost = [0, 1, 2].map(|axis| self.lost[axis] + counted[axis]);
        self.motion.set_position([0; 3]);
        let locks = self.eeprom.is_on(22) && !self.quirks.wakes_unlocked;
        self.state = if locks { MachineState::Alarm } else { MachineState::Idle };
        self.restart();
    }

    /// Begins as after power-on: the modes are the defaults, and all lines are gone.
    fn restart(&mut self) {
        self.motion.halt(self.now);
        self.sample();
        self.serial.clear();
        self.program = super::ProgramTasks::default();
        self.flags = RealtimeFlags::fresh();
        self.apply_overrides();
        self.parser.modes = ModalState::default();
        (self.parser.shift, self.parser.tool_length) = ([0.0; 3], 0.0);
        self.parser.position = self.motion.mm_at(self.now);
        self.reports.restart();
        self.greets();
    }

    /// Raises an alarm: the motion stops at once.
    pub(super) fn raise_alarm(&mut self, number: u8) {
        self.motion.halt(self.now);
        self.sample();
        self.state = MachineState::Alarm;
        self.parser.modes.spindle = SpindleMode::Stopped;
        self.program = super::ProgramTasks::default();
        self.flags = RealtimeFlags { critical: matches!(number, 1 | 2), ..RealtimeFlags::fresh() };
        self.say(&format!("ALARM:{number}\r\n"));
        if self.flags.critical {
            self.say("[MSG:Reset to continue]\r\n");
        }
    }
}

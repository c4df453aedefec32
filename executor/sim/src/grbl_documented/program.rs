//! The firmware's program: it reads lines, executes them one after the other, and answers each.

use std::collections::VecDeque;
use std::time::Duration;

use keepout_guard::Time;

use super::DocumentedGrbl;
use super::parser::{ProgramStep, is_beyond};
use super::planner::AxisLimits;
use super::realtime::MachineState;
use super::serial::CollectedLine;
use super::words::LineErrorCode;

/// The present task.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) enum ProgramTask {
    /// Reads the next line.
    #[default]
    Reads,
    /// Parses a line until this time.
    Parses(Time, CollectedLine),
    /// Executes steps.
    Executes,
    /// Dwells.
    Dwells(Time),
    /// Writes to the EEPROM.
    Writes(Time),
    /// Homes.
    Homes(Time),
}

/// The answer when all steps are executed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) enum ProgramAnswer {
    #[default]
    Ok,
    /// The line is a startup line.
    Startup(String),
}

/// The tasks of the program.
#[derive(Clone, Debug, Default)]
pub(super) struct ProgramTasks {
    pub task: ProgramTask,
    pub steps: VecDeque<ProgramStep>,
    pub answer: ProgramAnswer,
    /// Startup lines to run.
    startup: VecDeque<usize>,
    /// The startup lines belong to homing, whose answer follows them.
    pub after_homing: bool,
}

/// Time to parse a line: a part for any line, and a part for each character.
const PARSE: Duration = Duration::from_micros(800);
const PARSE_CHARACTER: Duration = Duration::from_micros(15);
/// Time to write to the EEPROM.
const WRITE: Duration = Duration::from_millis(10);

impl ProgramTasks {
    /// Lets the startup lines run.
    pub fn run_startup(&mut self) {
        self.startup = VecDeque::from([0, 1]);
    }

    fn deadline(&self) -> Option<Time> {
        match self.task {
            ProgramTask::Reads | ProgramTask::Executes => None,
            ProgramTask::Parses(time, _)
            | ProgramTask::Dwells(time)
            | ProgramTask::Writes(time)
            | ProgramTask::Homes(time) => Some(time),
        }
    }
}

impl DocumentedGrbl {
    /// Whether bytes that arrive are lost, because the firmware writes to the EEPROM.
    pub(super) fn is_deaf(&self) -> bool {
        matches!(self.program.task, ProgramTask::Writes(_))
    }

    /// The time of the next event of the program.
    pub(super) fn next_of_program(&self) -> Time {
        let delay = self.flags.delays_until;
        if delay > self.now {
            return delay;
        }
        let mut next = Time::NEVER;
        if !self.flags.critical {
            let parses = matches!(self.program.task, ProgramTask::Parses(..));
            let suspended = self.is_suspended() && !parses;
            if let Some(deadline) = self.program.deadline().filter(|_| !suspended) {
                next = next.min(deadline);
            }
            if !self.keeps_silent() {
                next = next.min(self.reports.due());
            }
        }
        if next <= self.now { self.now.after(Duration::from_micros(1)) } else { next }
    }

    /// Whether the program does not look at real-time flags.
    fn is_busy(&self) -> bool {
        matches!(self.program.task, ProgramTask::Parses(..) | ProgramTask::Writes(_) | ProgramTask::Homes(_))
    }

    /// Whether the program sends no report. It sends reports while it parses a line, which is then in no buffer.
    fn keeps_silent(&self) -> bool {
        matches!(self.program.task, ProgramTask::Writes(_) | ProgramTask::Homes(_))
    }

    /// Does everything that can be done at the present time.
    pub(super) fn run(&mut self) {
        while self.does_something() {}
    }

    fn does_something(&mut self) -> bool {
        if self.flags.delays_until > self.now || self.flags.critical {
            return false;
        }
        if self.reports.due() <= self.now && !self.keeps_silent() {
            self.report();
            return true;
        }
        if self.is_busy() {
            return self.ends_task();
        }
        if self.handle_flags() {
            return true;
        }
        if self.flags.soft_limit && !self.motion.is_running() {
            self.raise_alarm(2);
            return true;
        }
        if self.is_suspended() || self.flags.soft_limit {
            return false;
        }
        match self.program.task {
            ProgramTask::Executes => self.executes(),
            ProgramTask::Reads => self.reads(),
            _ => self.ends_task(),
        }
    }

    /// Ends a task whose time has come.
    fn ends_task(&mut self) -> bool {
        if self.program.deadline().is_none_or(|deadline| deadline > self.now) {
            return false;
        }
        match std::mem::replace(&mut self.program.task, ProgramTask::Executes) {
            ProgramTask::Parses(_, line) => {
                self.take_line(&line);
                // A motion is planned with its line, before the program notices that another one ended.
                if matches!(self.program.steps.front(), Some(ProgramStep::Move { .. }))
                    && !self.is_suspended()
                {
                    self.executes();
                }
            }
            ProgramTask::Homes(_) => self.ends_homing(),
            _ => {}
        }
        true
    }

    fn reads(&mut self) -> bool {
        if let Some(number) = self.program.startup.pop_front() {
            self.runs_startup(number);
            return true;
        }
        if std::mem::take(&mut self.program.after_homing) {
            self.say("ok\r\n");
            return true;
        }
        if let Some(line) = self.serial.next_line() {
            let characters = match &line {
                CollectedLine::Text(text) => text.len(),
                CollectedLine::TooLong => 0,
            };
            let time = (PARSE + PARSE_CHARACTER * u32::try_from(characters).unwrap_or(0)) * self.slowness;
            self.program.task = ProgramTask::Parses(self.now.after(time), line);
            return true;
        }
        self.starts_cycle()
    }

    fn runs_startup(&mut self, number: usize) {
        let text = self.eeprom.startup[number].clone();
        if text.is_empty() {
            return;
        }
        match self.parser.parse(text.as_bytes(), &mut self.eeprom) {
            Ok(steps) => self.executes_later(steps, ProgramAnswer::Startup(text)),
            Err(error) => self.say(&format!(">{text}:error:{}\r\n", error.0)),
        }
    }

    pub(super) fn executes_later(&mut self, steps: Vec<ProgramStep>, answer: ProgramAnswer) {
        self.program.steps = steps.into();
        (self.program.answer, self.program.task) = (answer, ProgramTask::Executes);
    }

    /// Starts queued motions that wait for a start.
    fn starts_cycle(&mut self) -> bool {
        if self.state != MachineState::Idle || self.motion.queued() == 0 {
            return false;
        }
        self.state = MachineState::Run;
        self.motion.start(self.now);
        true
    }

    fn take_line(&mut self, line: &CollectedLine) {
        let result = match line {
            CollectedLine::TooLong => Err(LineErrorCode::LONG_LINE),
            CollectedLine::Text(text) if text.is_empty() => Ok(Vec::new()),
            CollectedLine::Text(text) if text[0] == b'$' => self.command(&text[1..]),
            CollectedLine::Text(_) if self.is_locked() => Err(LineErrorCode::LOCKED),
            CollectedLine::Text(text) => self.parser.parse(text, &mut self.eeprom),
        };
        match result {
            // A command may have begun a task of its own.
            Ok(steps) if self.program.task == ProgramTask::Executes => {
                self.executes_later(steps, ProgramAnswer::Ok);
            }
            Ok(_) => {}
            Err(error) => {
                self.program.task = ProgramTask::Reads;
                self.say(&format!("error:{}\r\n", error.0));
            }
        }
    }

    fn is_locked(&self) -> bool {
        matches!(self.state, MachineState::Alarm | MachineState::Jog)
    }

    /// Executes the next step. Returns whether it did something.
    fn executes(&mut self) -> bool {
        let Some(&step) = self.program.steps.front() else {
            self.answers();
            return true;
        };
        match step {
            ProgramStep::Move { target, feed, jog } => {
                if !jog && self.eeprom.is_on(20) && is_beyond(target, &self.eeprom) {
                    return self.leaves_travel();
                }
                if self.state == MachineState::Check {
                    self.program.steps.pop_front();
                    return true;
                }
                if self.motion.is_full() {
                    return self.starts_cycle();
                }
                self.motion.add(target, feed, jog);
                self.parser.position = target;
                if jog && self.state == MachineState::Idle && self.motion.queued() > 0 {
                    self.state = MachineState::Jog;
                    self.motion.start(self.now);
                }
            }
            ProgramStep::Synchronize if self.state != MachineState::Check => {
                if self.starts_cycle() {
                    return true;
                }
                if self.motion.is_running() || self.motion.queued() > 0 || self.flags.motion_ended {
                    return false;
                }
            }
            ProgramStep::Synchronize | ProgramStep::Coolant(_) => {}
            ProgramStep::Spindle(_, rpm) => self.reports.turns_at(rpm),
            ProgramStep::Dwell(seconds) if self.state != MachineState::Check => {
                let seconds = seconds.clamp(0.0, 1e6);
                self.program.task = ProgramTask::Dwells(self.now.after(Duration::from_secs_f64(seconds)));
            }
            ProgramStep::Dwell(_) => {}
            ProgramStep::Store => self.program.task = ProgramTask::Writes(self.now.after(WRITE)),
            ProgramStep::OffsetChanged => self.reports.show_offset(),
            ProgramStep::Pause => {
                if self.state == MachineState::Idle {
                    self.state = MachineState::Hold { complete: true };
                }
            }
            ProgramStep::End => self.say("[MSG:Pgm End]\r\n"),
        }
        self.program.steps.pop_front();
        true
    }

    fn answers(&mut self) {
        self.program.task = ProgramTask::Reads;
        match std::mem::take(&mut self.program.answer) {
            ProgramAnswer::Ok => self.say("ok\r\n"),
            ProgramAnswer::Startup(text) => self.say(&format!(">{text}:ok\r\n")),
        }
    }

    /// A programmed motion leaves the travel: the tool brakes, and then the alarm follows.
    fn leaves_travel(&mut self) -> bool {
        self.flags.soft_limit = true;
        if self.motion.is_running() {
            self.motion.brake();
            self.state = MachineState::Hold { complete: false };
        }
        true
    }

    /// Begins to home.
    pub(super) fn homes(&mut self) {
        self.state = MachineState::Home;
        self.program.task = ProgramTask::Homes(self.now.after(self.homing));
    }

    fn ends_homing(&mut self) {
        let counted = self.motion.place_at(self.now);
        let stays = [0, 1, 2].map(|axis| counted[axis] + self.lost[axis]);
        self.lost = [0; 3];
        self.motion.set_position(self.home.unwrap_or(stays));
        self.parser.position = self.motion.mm_at(self.now);
        self.state = MachineState::Idle;
        self.program.task = ProgramTask::Reads;
        self.program.run_startup();
        self.program.after_homing = true;
        self.sample();
    }

    /// Writes a setting.
    pub(super) fn stores(&mut self) -> Vec<ProgramStep> {
        self.motion.set_limits(AxisLimits::of(&self.eeprom));
        vec![ProgramStep::Store]
    }
}

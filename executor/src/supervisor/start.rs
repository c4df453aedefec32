//! The start of a session: connecting, settings, homing, finding the place.

use super::event::{Command, Mode, Report};
use super::settings::Settings;
use super::{Fault, REFUSED_MAX, State, Supervisor, manual};

impl Supervisor {
    pub(super) fn take_ok(&mut self, commands: &mut Vec<Command>) -> Result<(), Fault> {
        match &self.state {
            State::Connecting { .. } => {}
            State::ReadingSettings(settings) => {
                let settings = *settings;
                settings.check(&self.options)?;
                self.limits = settings.limits(self.limits);
                self.store(&settings, commands);
            }
            State::Storing { open: open @ 2.. } => self.state = State::Storing { open: open - 1 },
            State::Storing { .. } => self.home_or_locate(commands),
            State::Waking => self.read_settings(commands),
            State::Homing => self.locate(commands),
            State::Locating { lines_open: open @ 1.. } => {
                self.state = State::Locating { lines_open: open - 1 }
            }
            _ => {
                self.guard.acknowledged()?;
                self.refused = 0;
                // An answer to a query that left before this line would have come before this acknowledgement.
                let guard = &self.guard;
                self.queries.retain(|stamp| !guard.is_outdated(stamp));
            }
        }
        Ok(())
    }

    pub(super) fn take_error(&mut self, code: u16, commands: &mut Vec<Command>) -> Result<(), Fault> {
        /// Not idle: a jog stream that ran dry leaves GRBL in Run for a moment.
        const NOT_IDLE: u16 = 8;
        match &mut self.state {
            State::Connecting { .. } => Ok(()),
            State::Waking => {
                self.read_settings(commands);
                Ok(())
            }
            State::Manual(manual)
                if code == NOT_IDLE && self.refused < REFUSED_MAX && self.guard.refused() =>
            {
                self.refused += 1;
                manual.wait_for_rest();
                Ok(())
            }
            _ => Err(Fault::Refused { code }),
        }
    }

    fn read_settings(&mut self, commands: &mut Vec<Command>) {
        commands.push(Command::ReadSettings);
        self.state = State::ReadingSettings(Settings::default());
    }

    /// Sets what the session relies on, where the controller has it otherwise.
    fn store(&mut self, settings: &Settings, commands: &mut Vec<Command>) {
        let mut open = 0;
        if !settings.reports_blocks() {
            commands.push(Command::ReportBlocks);
            open += 1;
        }
        let mm = self.options.arc_tolerance_mm;
        if !settings.follows_arcs(mm) {
            commands.push(Command::SetArcTolerance { mm });
            open += 1;
        }
        if open == 0 {
            self.home_or_locate(commands);
        } else {
            self.state = State::Storing { open };
        }
    }

    fn home_or_locate(&mut self, commands: &mut Vec<Command>) {
        if self.options.home {
            commands.push(Command::Home);
            self.state = State::Homing;
        } else {
            self.locate(commands);
        }
    }

    fn locate(&mut self, commands: &mut Vec<Command>) {
        commands.push(Command::SetModes);
        self.state = State::Locating { lines_open: 2 };
    }

    pub(super) fn connected(&mut self, report: &Report, commands: &mut Vec<Command>) -> Result<(), Fault> {
        match report.mode {
            Mode::Idle => {}
            Mode::Alarm if self.options.home => {}
            Mode::Alarm => return Err(Fault::NotHomed),
            mode => return Err(Fault::Unexpected { mode }),
        }
        commands.push(Command::Wake);
        self.state = State::Waking;
        Ok(())
    }

    pub(super) fn take_place(&mut self, report: &Report) -> Result<(), Fault> {
        let (Mode::Idle, Some(at), Some(_)) = (report.mode, report.position, self.work_offset) else {
            return Ok(());
        };
        self.planner_blocks = report.free_blocks;
        self.guard.locate(at).map_err(|refusal| Fault::StandsInside { at, refusal })?;
        self.state = State::Manual(manual::Manual::default());
        Ok(())
    }
}

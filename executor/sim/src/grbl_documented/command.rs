//! The `$` commands.
//!
//! Source: `doc/markdown/commands.md`.

use super::DocumentedGrbl;
use super::parser::ProgramStep;
use super::realtime::MachineState;
use super::words::{LineErrorCode, number};

type CommandResult = Result<Vec<ProgramStep>, LineErrorCode>;

/// Longest stored text, characters.
const TEXT_MAX: usize = 79;

impl DocumentedGrbl {
    /// Executes a command: the line after its `$`.
    pub(super) fn command(&mut self, rest: &[u8]) -> CommandResult {
        let idle = matches!(self.state, MachineState::Idle | MachineState::Alarm);
        match rest {
            [] => self.says("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]\r\n"),
            [b'J', line @ ..] => self.jogs(line),
            [b'$'] if matches!(self.state, MachineState::Run | MachineState::Hold { .. }) => {
                Err(LineErrorCode::NOT_IDLE)
            }
            [b'$'] => {
                let text = self.eeprom.listing();
                self.says(&text)
            }
            [b'G'] => {
                let text = self.modes_text();
                self.says(&text)
            }
            [b'X'] => {
                if self.state == MachineState::Alarm {
                    self.state = MachineState::Idle;
                    self.say("[MSG:Caution: Unlocked]\r\n");
                }
                Ok(Vec::new())
            }
            [b'C'] => self.toggles_check(),
            [b'$' | b'G' | b'X' | b'C', ..] => Err(LineErrorCode::STATEMENT),
            _ if !idle => Err(LineErrorCode::NOT_IDLE),
            [b'#'] => {
                let text = self.offsets_text();
                self.says(&text)
            }
            [b'H'] if !self.eeprom.is_on(22) => Err(LineErrorCode::HOMING_OFF),
            [b'H'] => {
                self.homes();
                Ok(Vec::new())
            }
            b"SLP" => {
                self.say("[MSG:Sleeping]\r\n");
                self.state = MachineState::Sleep;
                Ok(Vec::new())
            }
            b"I" => {
                let lock = if self.quirks.wakes_unlocked { "L" } else { "" };
                let text =
                    format!("[VER:1.1h.20190830:{}]\r\n[OPT:V{lock},15,128]\r\n", self.eeprom.build_text);
                self.says(&text)
            }
            b"N" => {
                let text = self.eeprom.startup_listing();
                self.says(&text)
            }
            [b'I', b'=', text @ ..] => {
                let text = String::from_utf8_lossy(text);
                self.eeprom.build_text = text.chars().take(TEXT_MAX).collect();
                Ok(vec![ProgramStep::Store])
            }
            [b'N', line @ ..] => self.stores_startup(line),
            _ => self.stores_setting(rest),
        }
    }

    fn says(&mut self, text: &str) -> CommandResult {
        self.say(text);
        Ok(Vec::new())
    }

    fn jogs(&mut self, rest: &[u8]) -> CommandResult {
        if !matches!(self.state, MachineState::Idle | MachineState::Jog) {
            return Err(LineErrorCode::NOT_IDLE);
        }
        if let Some(late) = &mut self.late {
            let line = [b"$J", rest].concat();
            if late.rejects(&line, self.now) {
                return Err(LineErrorCode::NOT_IDLE);
            }
        }
        match rest {
            [b'=', line @ ..] => self.parser.jog(line, &self.eeprom),
            _ => Err(LineErrorCode::JOG),
        }
    }

    fn toggles_check(&mut self) -> CommandResult {
        match self.state {
            MachineState::Check => {
                self.say("[MSG:Disabled]\r\nok\r\n");
                self.reset();
                Ok(Vec::new())
            }
            MachineState::Idle => {
                self.state = MachineState::Check;
                self.says("[MSG:Enabled]\r\n")
            }
            _ => Err(LineErrorCode::NOT_IDLE),
        }
    }

    fn stores_startup(&mut self, rest: &[u8]) -> CommandResult {
        if self.state != MachineState::Idle {
            return Err(LineErrorCode::NOT_IDLE);
        }
        let (number, line) = match rest {
            [b'0', b'=', line @ ..] => (0, line),
            [b'1', b'=', line @ ..] => (1, line),
            [b'0'..=b'9', ..] => return Err(LineErrorCode::STATEMENT),
            _ => return Err(LineErrorCode::NUMBER),
        };
        // The firmware runs the line to check it.
        let mut steps = self.parser.parse(line, &mut self.eeprom)?;
        self.eeprom.startup[number] = String::from_utf8_lossy(line).into_owned();
        steps.push(ProgramStep::Store);
        Ok(steps)
    }

    fn stores_setting(&mut self, rest: &[u8]) -> CommandResult {
        let (name, rest) = number(rest).ok_or(LineErrorCode::NUMBER)?;
        let [b'=', rest @ ..] = rest else { return Err(LineErrorCode::STATEMENT) };
        let (value, rest) = number(rest).ok_or(LineErrorCode::NUMBER)?;
        if !rest.is_empty() {
            return Err(LineErrorCode::STATEMENT);
        }
        let name: u16 = format!("{name:.0}").parse().map_err(|_| LineErrorCode::STATEMENT)?;
        self.eeprom.store(name, value)?;
        if name == 13 {
            self.reports.show_offset();
        }
        Ok(self.stores())
    }
}

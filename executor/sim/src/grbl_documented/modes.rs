//! The modal state of the parser, and the G and M words of one line.
//!
//! Source: `doc/markdown/commands.md`, the table of modal groups.

use super::words::{CodeWord, LineErrorCode};

/// The motion mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MotionMode {
    Rapid,
    Straight,
    Arc { clockwise: bool },
    Cancelled,
}

/// The commanded state of the spindle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SpindleMode {
    Clockwise,
    CounterClockwise,
    Stopped,
}

/// The modal state.
#[derive(Clone, Copy, Debug)]
pub(super) struct ModalState {
    pub motion: MotionMode,
    /// 17, 18 or 19.
    pub plane: u16,
    pub absolute: bool,
    pub inches: bool,
    pub inverse_time: bool,
    /// Work coordinate system: 0 is G54.
    pub system: usize,
    /// mm/min.
    pub feed: f64,
    pub rpm: f64,
    pub tool: f64,
    pub spindle: SpindleMode,
    pub flood: bool,
}

impl Default for ModalState {
    fn default() -> Self {
        Self {
            motion: MotionMode::Rapid,
            plane: 17,
            absolute: true,
            inches: false,
            inverse_time: false,
            system: 0,
            feed: 0.0,
            rpm: 0.0,
            tool: 0.0,
            spindle: SpindleMode::Stopped,
            flood: false,
        }
    }
}

/// The command that uses the axis words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AxisCommand {
    Motion,
    /// G10.
    StoreOffset,
    /// G28 or G30: the number of the place.
    Park(usize),
    /// G28.1 or G30.1.
    StorePark(usize),
    /// G92.
    Shift,
    /// G43.1.
    ToolLength,
}

/// The program flow at the end of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProgramFlow {
    Pause,
    End,
}

/// The G and M words of one line.
#[derive(Clone, Copy, Debug)]
pub(super) struct CodesOfLine {
    pub modes: ModalState,
    pub axis_command: Option<AxisCommand>,
    pub machine_coordinates: bool,
    pub dwells: bool,
    pub clears_shift: bool,
    pub ends_tool_length: bool,
    pub spindle_named: bool,
    pub coolant_named: bool,
    pub motion_named: bool,
    pub flow: Option<ProgramFlow>,
    groups: u32,
}

/// Bits of the groups that a jog permits: distance mode, units, and G53.
const JOG_GROUPS: u32 = 1 << 3 | 1 << 6 | 1;

impl CodesOfLine {
    /// No words yet, in this modal state.
    pub fn new(modes: ModalState) -> Self {
        Self {
            modes,
            axis_command: None,
            machine_coordinates: false,
            dwells: false,
            clears_shift: false,
            ends_tool_length: false,
            spindle_named: false,
            coolant_named: false,
            motion_named: false,
            flow: None,
            groups: 0,
        }
    }

    /// Whether the line holds a word that a jog does not permit.
    pub fn spoils_jog(&self) -> bool {
        let other =
            self.dwells || self.clears_shift || self.axis_command.is_some_and(|c| c != AxisCommand::Motion);
        self.groups & !JOG_GROUPS != 0 || other
    }

    /// Takes one word.
    pub fn take(&mut self, word: CodeWord) -> Result<(), LineErrorCode> {
        let group = if word.letter == b'G' { self.g_word(word.tenths)? } else { self.m_word(word.tenths)? };
        if self.groups & 1 << group != 0 {
            return Err(LineErrorCode::MODAL_GROUP);
        }
        self.groups |= 1 << group;
        Ok(())
    }

    fn axes_for(&mut self, command: AxisCommand) -> Result<(), LineErrorCode> {
        if self.axis_command.is_some() {
            return Err(LineErrorCode::AXIS_CONFLICT);
        }
        self.axis_command = Some(command);
        Ok(())
    }

    /// Takes a G word, and returns its modal group.
    fn g_word(&mut self, tenths: u16) -> Result<u8, LineErrorCode> {
        match tenths {
            40 => self.dwells = true,
            530 => self.machine_coordinates = true,
            921 => self.clears_shift = true,
            100 => self.axes_for(AxisCommand::StoreOffset)?,
            280 => self.axes_for(AxisCommand::Park(0))?,
            300 => self.axes_for(AxisCommand::Park(1))?,
            281 => self.axes_for(AxisCommand::StorePark(0))?,
            301 => self.axes_for(AxisCommand::StorePark(1))?,
            920 => self.axes_for(AxisCommand::Shift)?,
            _ => return self.modal_g_word(tenths),
        }
        Ok(0)
    }

    fn modal_g_word(&mut self, tenths: u16) -> Result<u8, LineErrorCode> {
        let group = match tenths {
            0 | 10 | 20 | 30 => {
                self.axes_for(AxisCommand::Motion)?;
                self.modes.motion = match tenths {
                    0 => MotionMode::Rapid,
                    10 => MotionMode::Straight,
                    _ => MotionMode::Arc { clockwise: tenths == 20 },
                };
                self.motion_named = true;
                1
            }
            800 => {
                self.modes.motion = MotionMode::Cancelled;
                self.motion_named = true;
                1
            }
            170 | 180 | 190 => {
                self.modes.plane = tenths / 10;
                2
            }
            900 | 910 => {
                self.modes.absolute = tenths == 900;
                3
            }
            911 => 4,
            930 | 940 => {
                self.modes.inverse_time = tenths == 930;
                5
            }
            200 | 210 => {
                self.modes.inches = tenths == 200;
                6
            }
            400 => 7,
            431 => {
                self.axes_for(AxisCommand::ToolLength)?;
                8
            }
            490 => {
                self.ends_tool_length = true;
                8
            }
            540 | 550 | 560 | 570 | 580 | 590 => {
                self.modes.system = usize::from((tenths - 540) / 10);
                9
            }
            591..=593 => return Err(LineErrorCode::SYSTEM),
            610 => 10,
            // Probing is not simulated.
            382..=385 => return Err(LineErrorCode::UNSUPPORTED),
            _ if !tenths.is_multiple_of(10) => return Err(LineErrorCode::WHOLE_NUMBER),
            _ => return Err(LineErrorCode::UNSUPPORTED),
        };
        Ok(group)
    }

    /// Takes an M word, and returns its modal group.
    fn m_word(&mut self, tenths: u16) -> Result<u8, LineErrorCode> {
        let group = match tenths {
            0 | 10 | 20 | 300 => {
                self.flow = match tenths {
                    0 => Some(ProgramFlow::Pause),
                    10 => None,
                    _ => Some(ProgramFlow::End),
                };
                16
            }
            30 | 40 | 50 => {
                self.spindle_named = true;
                self.modes.spindle = match tenths {
                    30 => SpindleMode::Clockwise,
                    40 => SpindleMode::CounterClockwise,
                    _ => SpindleMode::Stopped,
                };
                17
            }
            80 | 90 => {
                self.coolant_named = true;
                self.modes.flood = tenths == 80;
                18
            }
            _ if !tenths.is_multiple_of(10) => return Err(LineErrorCode::WHOLE_NUMBER),
            _ => return Err(LineErrorCode::UNSUPPORTED),
        };
        Ok(group)
    }
}

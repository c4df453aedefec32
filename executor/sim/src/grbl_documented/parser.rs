//! The G-code parser: a line becomes steps of the program, or an error. A line with an error changes nothing.

use super::arc::ArcMotion;
use super::axes::{Triple, each};
use super::modes::{AxisCommand, CodesOfLine, ModalState, MotionMode, ProgramFlow, SpindleMode};
use super::settings::{EepromContent, SYSTEMS};
use super::words::{LineErrorCode, LineWords};

/// The feed of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BlockFeed {
    /// As fast as the axes permit.
    Rapid,
    /// mm/min.
    PerMinute(f64),
    /// The motion takes a minute divided by this.
    Inverse(f64),
}

/// A step of the program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ProgramStep {
    /// A straight motion. The target is in machine coordinates, mm.
    Move { target: Triple, feed: BlockFeed, jog: bool },
    /// Wait until all motions are over.
    Synchronize,
    /// Switch the spindle.
    Spindle(SpindleMode, f64),
    /// Switch the coolant.
    Coolant(bool),
    /// Wait for this time, s.
    Dwell(f64),
    /// Write to the EEPROM.
    Store,
    /// The work offset changed.
    OffsetChanged,
    /// Hold until the operator resumes.
    Pause,
    /// The program ended.
    End,
}

/// The parser with its modal state.
#[derive(Clone, Debug, Default)]
pub(super) struct GcodeParser {
    pub modes: ModalState,
    /// The end of the last motion, machine coordinates, mm.
    pub position: Triple,
    /// The offset of G92, mm.
    pub shift: Triple,
    /// The tool length offset of G43.1, mm.
    pub tool_length: f64,
}

const MM_PER_INCH: f64 = 25.4;
/// Highest line number.
const LINE_NUMBER_MAX: f64 = 9_999_999.0;

impl GcodeParser {
    /// The offset of the work coordinates, machine coordinates, mm.
    pub fn work_offset(&self, eeprom: &EepromContent) -> Triple {
        self.offset_of(self.modes.system, eeprom)
    }

    fn offset_of(&self, system: usize, eeprom: &EepromContent) -> Triple {
        let mut offset = each(|axis| eeprom.systems[system][axis] + self.shift[axis]);
        offset[2] += self.tool_length;
        offset
    }

    /// The steps of a jog: the line after `$J=`.
    pub fn jog(&self, line: &[u8], eeprom: &EepromContent) -> Result<Vec<ProgramStep>, LineErrorCode> {
        let modes = ModalState { motion: MotionMode::Straight, inverse_time: false, ..self.modes };
        let mut codes = CodesOfLine::new(modes);
        let mut words = LineWords::of(line, |word| codes.take(word))?;
        check_line_number(&mut words)?;
        let scale = if codes.modes.inches { MM_PER_INCH } else { 1.0 };
        let feed = words.take(b'F').ok_or(LineErrorCode::FEED)? * scale;
        if feed == 0.0 {
            return Err(LineErrorCode::FEED);
        }
        if !words.has_axis() {
            return Err(LineErrorCode::NO_AXIS);
        }
        let target = self.target(&codes, &mut words, eeprom);
        if words.has_unused() {
            return Err(LineErrorCode::UNUSED);
        }
        if codes.spoils_jog() {
            return Err(LineErrorCode::JOG);
        }
        if eeprom.is_on(20) && is_beyond(target, eeprom) {
            return Err(LineErrorCode::TRAVEL);
        }
        Ok(vec![ProgramStep::Move { target, feed: BlockFeed::PerMinute(feed), jog: true }])
    }

    /// The steps of a line of G-code. The modal state changes with it.
    pub fn parse(
        &mut self,
        line: &[u8],
        eeprom: &mut EepromContent,
    ) -> Result<Vec<ProgramStep>, LineErrorCode> {
        let mut codes = CodesOfLine::new(self.modes);
        let mut words = LineWords::of(line, |word| codes.take(word))?;
        check_line_number(&mut words)?;
        if codes.axis_command.is_none() && words.has_axis() {
            codes.axis_command = Some(AxisCommand::Motion);
        }
        let feed = self.feed(&mut codes, &mut words)?;
        let mut steps = Vec::new();
        self.switches(&mut codes, &mut words, &mut steps);
        if codes.dwells {
            let seconds = words.take(b'P').ok_or(LineErrorCode::MISSING_VALUE)?;
            steps.extend([ProgramStep::Synchronize, ProgramStep::Dwell(seconds)]);
        }
        let mut next = Self { modes: codes.modes, ..self.clone() };
        let mut stored = None;
        next.offsets(&codes, &mut words, eeprom, &mut steps, &mut stored)?;
        if codes.axis_command == Some(AxisCommand::Motion) {
            next.motion(&codes, &mut words, (feed, eeprom), &mut steps)?;
        } else if codes.machine_coordinates
            && !matches!(next.modes.motion, MotionMode::Rapid | MotionMode::Straight)
        {
            return Err(LineErrorCode::G53);
        }
        if words.has_unused() {
            return Err(LineErrorCode::UNUSED);
        }
        next.finish(codes.flow, &mut steps);
        if let Some(content) = stored {
            *eeprom = content;
        }
        *self = next;
        Ok(steps)
    }

    /// The feed of the line's motion. In inverse time every line needs one.
    fn feed(&self, codes: &mut CodesOfLine, words: &mut LineWords) -> Result<Option<f64>, LineErrorCode> {
        let scale = if codes.modes.inches { MM_PER_INCH } else { 1.0 };
        let moves = codes.axis_command == Some(AxisCommand::Motion)
            && matches!(codes.modes.motion, MotionMode::Straight | MotionMode::Arc { .. });
        let value = words.take(b'F');
        if codes.modes.inverse_time {
            if moves && value.is_none() {
                return Err(LineErrorCode::FEED);
            }
            return Ok(value);
        }
        // The feed of inverse time has no meaning afterwards.
        let before = if self.modes.inverse_time { 0.0 } else { codes.modes.feed };
        codes.modes.feed = value.map_or(before, |value| value * scale);
        if moves && codes.modes.feed == 0.0 {
            return Err(LineErrorCode::FEED);
        }
        Ok(None)
    }

    /// Spindle, tool and coolant. Each change waits for the motions before it.
    fn switches(&self, codes: &mut CodesOfLine, words: &mut LineWords, steps: &mut Vec<ProgramStep>) {
        codes.modes.tool = words.take(b'T').unwrap_or(codes.modes.tool);
        codes.modes.rpm = words.take(b'S').unwrap_or(codes.modes.rpm);
        let ModalState { spindle, rpm, flood, .. } = codes.modes;
        let turns = spindle != SpindleMode::Stopped;
        if spindle != self.modes.spindle || turns && (rpm - self.modes.rpm).abs() > 0.0 {
            steps.extend([ProgramStep::Synchronize, ProgramStep::Spindle(spindle, rpm)]);
        }
        if codes.coolant_named && flood != self.modes.flood {
            steps.extend([ProgramStep::Synchronize, ProgramStep::Coolant(flood)]);
        }
    }

    /// Changes of the offsets, and the parked places.
    fn offsets(
        &mut self,
        codes: &CodesOfLine,
        words: &mut LineWords,
        eeprom: &EepromContent,
        steps: &mut Vec<ProgramStep>,
        stored: &mut Option<EepromContent>,
    ) -> Result<(), LineErrorCode> {
        if codes.ends_tool_length || codes.clears_shift {
            self.tool_length = if codes.ends_tool_length { 0.0 } else { self.tool_length };
            self.shift = if codes.clears_shift { [0.0; 3] } else { self.shift };
            steps.extend([ProgramStep::Synchronize, ProgramStep::OffsetChanged]);
        }
        if codes.modes.system != self.modes.system {
            steps.extend([ProgramStep::Synchronize, ProgramStep::OffsetChanged]);
        }
        let Some(command) = codes.axis_command.filter(|&command| command != AxisCommand::Motion) else {
            return Ok(());
        };
        let needs_axis =
            matches!(command, AxisCommand::StoreOffset | AxisCommand::Shift | AxisCommand::ToolLength);
        if needs_axis && !words.has_axis() {
            return Err(LineErrorCode::NO_AXIS);
        }
        match command {
            AxisCommand::StoreOffset => *stored = Some(self.stored_offset(codes, words, eeprom)?),
            AxisCommand::Shift => {
                let base = each(|axis| self.offset_of(self.modes.system, eeprom)[axis] - self.shift[axis]);
                for (axis, value) in axis_values(codes, words).into_iter().enumerate() {
                    if let Some(value) = value {
                        self.shift[axis] = self.position[axis] - base[axis] - value;
                    }
                }
            }
            AxisCommand::ToolLength => {
                let [x, y, z] = axis_values(codes, words);
                match (x, y, z) {
                    (None, None, Some(z)) => self.tool_length = z,
                    _ => return Err(LineErrorCode::TOOL_AXIS),
                }
            }
            AxisCommand::StorePark(number) => {
                let mut content = eeprom.clone();
                content.parked[number] = self.position;
                *stored = Some(content);
            }
            AxisCommand::Park(number) => {
                if words.has_axis() {
                    let target = self.target(codes, words, eeprom);
                    steps.push(ProgramStep::Move { target, feed: BlockFeed::Rapid, jog: false });
                }
                let target = eeprom.parked[number];
                steps.push(ProgramStep::Move { target, feed: BlockFeed::Rapid, jog: false });
                return Ok(());
            }
            AxisCommand::Motion => {}
        }
        steps.extend([ProgramStep::Synchronize, ProgramStep::OffsetChanged]);
        steps.extend(stored.is_some().then_some(ProgramStep::Store));
        Ok(())
    }

    /// The content after G10.
    fn stored_offset(
        &self,
        codes: &CodesOfLine,
        words: &mut LineWords,
        eeprom: &EepromContent,
    ) -> Result<EepromContent, LineErrorCode> {
        let (Some(system), Some(kind)) = (words.take(b'P'), words.take(b'L')) else {
            return Err(LineErrorCode::MISSING_VALUE);
        };
        let system = if system == 0.0 { self.modes.system } else { place_of(system)? };
        let mut content = eeprom.clone();
        for (axis, value) in axis_values(codes, words).into_iter().enumerate() {
            let Some(value) = value else { continue };
            let tool = if axis == 2 { self.tool_length } else { 0.0 };
            content.systems[system][axis] = if kind == 2.0 {
                value
            } else if kind == 20.0 {
                self.position[axis] - self.shift[axis] - tool - value
            } else {
                return Err(LineErrorCode::UNSUPPORTED);
            };
        }
        Ok(content)
    }

    /// The target of a motion, machine coordinates, mm. It takes the axis words.
    fn target(&self, codes: &CodesOfLine, words: &mut LineWords, eeprom: &EepromContent) -> Triple {
        let values = axis_values(codes, words);
        let offset = self.offset_of(codes.modes.system, eeprom);
        each(|axis| match values[axis] {
            None => self.position[axis],
            Some(value) if codes.machine_coordinates => value,
            Some(value) if codes.modes.absolute => value + offset[axis],
            Some(value) => self.position[axis] + value,
        })
    }

    fn motion(
        &mut self,
        codes: &CodesOfLine,
        words: &mut LineWords,
        (inverse, eeprom): (Option<f64>, &EepromContent),
        steps: &mut Vec<ProgramStep>,
    ) -> Result<(), LineErrorCode> {
        let has_axis = words.has_axis();
        match self.modes.motion {
            MotionMode::Cancelled if has_axis => return Err(LineErrorCode::UNUSED_AXIS),
            MotionMode::Arc { .. } if codes.machine_coordinates => return Err(LineErrorCode::G53),
            MotionMode::Arc { .. } if !has_axis => return Err(LineErrorCode::NO_AXIS),
            _ if !has_axis => return Ok(()),
            _ => {}
        }
        let feed = match (self.modes.motion, inverse) {
            (MotionMode::Rapid, _) => BlockFeed::Rapid,
            (_, Some(minutes)) => BlockFeed::Inverse(minutes),
            _ => BlockFeed::PerMinute(self.modes.feed),
        };
        let in_plane = self.plane();
        let axis_in_plane = in_plane[..2].iter().any(|&axis| words.seen(b"XYZ"[axis]).is_some());
        let target = self.target(codes, words, eeprom);
        let MotionMode::Arc { clockwise } = self.modes.motion else {
            steps.push(ProgramStep::Move { target, feed, jog: false });
            self.position = target;
            return Ok(());
        };
        if !axis_in_plane {
            return Err(LineErrorCode::NO_AXIS_IN_PLANE);
        }
        let arc = ArcMotion { from: self.position, to: target, plane: in_plane, clockwise };
        let centre = self.centre(&arc, words)?;
        let chords = arc.chords(centre, eeprom.value(12));
        steps.extend(chords.into_iter().map(|target| ProgramStep::Move { target, feed, jog: false }));
        self.position = target;
        Ok(())
    }

    fn plane(&self) -> [usize; 3] {
        match self.modes.plane {
            18 => [2, 0, 1],
            19 => [1, 2, 0],
            _ => [0, 1, 2],
        }
    }

    fn centre(&self, arc: &ArcMotion, words: &mut LineWords) -> Result<[f64; 2], LineErrorCode> {
        let scale = if self.modes.inches { MM_PER_INCH } else { 1.0 };
        if let Some(radius) = words.take(b'R') {
            return arc.centre_of_radius(radius * scale);
        }
        let [first, second, _] = arc.plane;
        let offsets = [first, second].map(|axis| words.take(b"IJK"[axis]));
        if offsets == [None, None] {
            return Err(LineErrorCode::NO_OFFSET);
        }
        let along = |axis: usize, offset: Option<f64>| arc.from[axis] + offset.unwrap_or(0.0) * scale;
        let centre = [along(first, offsets[0]), along(second, offsets[1])];
        arc.check_centre(centre)?;
        Ok(centre)
    }

    /// The program flow of the line.
    fn finish(&mut self, flow: Option<ProgramFlow>, steps: &mut Vec<ProgramStep>) {
        match flow {
            None => {}
            Some(ProgramFlow::Pause) => steps.extend([ProgramStep::Synchronize, ProgramStep::Pause]),
            Some(ProgramFlow::End) => {
                let ModalState { feed, rpm, tool, inches, .. } = self.modes;
                let motion = MotionMode::Straight;
                self.modes = ModalState { feed, rpm, tool, inches, motion, ..ModalState::default() };
                steps.extend([ProgramStep::Synchronize, ProgramStep::End]);
            }
        }
    }
}

/// The axis words in millimetres.
fn axis_values(codes: &CodesOfLine, words: &mut LineWords) -> [Option<f64>; 3] {
    let scale = if codes.modes.inches { MM_PER_INCH } else { 1.0 };
    words.take_three(b"XYZ").map(|value| value.map(|value| value * scale))
}

fn check_line_number(words: &mut LineWords) -> Result<(), LineErrorCode> {
    match words.take(b'N') {
        Some(number) if number > LINE_NUMBER_MAX => Err(LineErrorCode::LINE_NUMBER),
        _ => Ok(()),
    }
}

/// The place of a work coordinate system that G10 numbers from 1.
fn place_of(number: f64) -> Result<usize, LineErrorCode> {
    (0..SYSTEMS)
        .zip([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
        .find(|&(_, known)| number == known)
        .map(|(place, _)| place)
        .ok_or(LineErrorCode::SYSTEM)
}

/// Whether a place is beyond the travel. Each axis runs from zero downward.
pub(super) fn is_beyond(place: Triple, eeprom: &EepromContent) -> bool {
    let travel = eeprom.axes(130);
    (0..3).any(|axis| !(-travel[axis]..=0.0).contains(&place[axis]))
}

//! GRBL 1.1 and grblHAL: absolute jogs, contours in G1/G2/G3, realtime status. Implements SR-17, SR-18, SR-19.
//!
//! An offset turns drawing coordinates into machine coordinates. The dialect writes targets from integers,
//! digit by digit, without rounding. GRBL itself holds them in 32-bit floats (error below 0.03 µm on a 400 mm
//! table).
//!
//! Arcs are written by their radius, to 10 nm, and sweep at most a quarter turn. The controller's arc through
//! the same ends deviates from the certified one by less than half the difference of the radii. The
//! controller rejects an arc line that arrives twice, because its ends coincide.
//!
//! The dialect never sends a feed hold or a jog cancel, because both firmwares can run away at one
//! (`docs/safety/controllers.md`). grblHAL's planner has more blocks; the dialect counts them from its reports at
//! rest. grblHAL reports more fields; the dialect skips unknown ones.

mod buffers;
mod identity;
mod inspect;
mod meaning;
mod settings;
mod start;
mod status;
#[cfg(test)]
mod tests;
mod words;

use buffers::Buffers;
use identity::Identity;
use inspect::GrblInspector;
use keepout_guard::{Interpolation, Motion, OnCancel};
use keepout_kernel::{Curve, Height, LatticeError, Place, Point, Turn};
use meaning::{alarm_text, error_text};
use settings::{Settings, StartupBlocks, Stated, Stores, setting_value};
pub use status::Status;

use super::lines::{Line, Lines, as_str, push_number};
use super::{Dialect, DialectConfig, Inspector};
use crate::supervisor::{Abilities, Command, EncodeError, Reply, Report, Unfit, text};

/// Longest motion line, bytes: GRBL's receive buffer holds 127, and a line may arrive twice.
const LINE_MAX: usize = 63;

/// The stage of the exchange with the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// No line was sent since the start or the last reset.
    Silent,
    /// A line was sent that terminates a partial line left in the controller's buffer.
    Waking,
    /// `$I` was sent. Its answer states the firmware.
    Identifying(Identity),
    Reading(Settings),
    /// `$N` was sent. Its answer lists the lines that the controller runs after a reset.
    ReadingBlocks(Settings, StartupBlocks),
    /// A line that stores a setting is unanswered; these stores follow.
    Storing(Stores),
    /// A line that stores a startup line is unanswered.
    StoringBlock,
    /// `$N` was sent to read the stored startup line back.
    ReadingBack(StartupBlocks),
    Prepared,
    Homing,
    /// This many lines that set modes are unanswered.
    Arming(u8),
    Ready,
    /// A reset was sent, and the greeting is expected.
    Aborting,
}

/// The GRBL 1.1 dialect of one session.
#[derive(Clone, Debug)]
pub struct Grbl {
    setting: DialectConfig,
    hal: bool,
    stage: Stage,
    /// Work coordinate offset, machine coordinates. `None` until a report carries it.
    work_offset: Option<Place>,
    /// The work offset as the parameter list states it.
    stated: Stated,
    /// The startup line to store before the session arms. GRBL stores none before it is homed.
    startup: Option<&'static [u8]>,
    buffers: Buffers,
    lines: Lines,
    /// A switch of the spindle is unanswered, and no motion is.
    switches_spindle: bool,
}

impl Grbl {
    /// The dialect for a drawing placed on the machine.
    #[must_use]
    pub fn new(setting: DialectConfig) -> Self {
        Self {
            setting,
            hal: false,
            stage: Stage::Silent,
            work_offset: None,
            stated: Stated::default(),
            startup: None,
            buffers: Buffers::default(),
            lines: Lines::default(),
            switches_spindle: false,
        }
    }

    /// The dialect for grblHAL.
    #[must_use]
    pub fn hal(setting: DialectConfig) -> Self {
        Self { hal: true, ..Self::new(setting) }
    }

    fn motion(&self, motion: &Motion, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let first = out.len();
        let feed = match motion {
            Motion::Jog { to, feed_mm_min } => {
                let to = self.setting.on_machine(*to)?;
                out.extend(b"$J=G53G90G21");
                self.target(to, true, out);
                feed_mm_min
            }
            Motion::Contour { curve, heights: [from, to], feed_mm_min } => {
                let climbs = from != to;
                let to = self.work(curve.to().at_height(*to))?;
                // The line states its modes, so it means the same in every mode of the controller. `G1` comes
                // first: the startup lines cancel the motion mode, so after a reset the controller rejects
                // the rest of the line.
                out.extend(match curve {
                    Curve::Line(_) => &b"G1G21G54G90G94"[..],
                    Curve::Arc(arc) if arc.turn() == Turn::CounterClockwise => b"G3G17G21G54G90G94",
                    Curve::Arc(_) => b"G2G17G21G54G90G94",
                });
                // An arc in the plane leaves out its height, because the line must be short.
                self.target(to, climbs || matches!(curve, Curve::Line(_)), out);
                // An arc line that arrives twice is rejected if it gives the radius. If it gave the centre,
                // it would cut a full circle.
                if let Curve::Arc(arc) = curve {
                    words::words(out, &[(b'R', arc.radius().units())]);
                }
                feed_mm_min
            }
        };
        out.push(b'F');
        push_number(out, u64::from(*feed));
        out.push(b'\n');
        let bytes = out.len() - first;
        if bytes > LINE_MAX { Err(EncodeError::LineTooLong { bytes }) } else { Ok(()) }
    }

    fn reply(&mut self, line: &str, out: &mut Vec<u8>) -> Option<Reply> {
        let garbled = Some(Reply::Garbled(text(line)));
        let number = |rest: &str| rest.trim().parse::<u16>().ok();
        if line == "ok" {
            self.answered(out)
        } else if let Some(rest) = line.strip_prefix("error:") {
            number(rest).map_or(garbled, |code| self.refused(code, out))
        } else if let Some(rest) = line.strip_prefix("ALARM:") {
            number(rest).map_or(garbled, |code| Some(Reply::Alarm { code, meaning: alarm_text(code) }))
        } else if line.starts_with('<') && line.ends_with('>') {
            self.report(line).or(garbled)
        } else if let Some((name, value)) = line.strip_prefix('$').and_then(|rest| rest.split_once('=')) {
            match (name.parse::<u16>(), &mut self.stage) {
                (Ok(number), Stage::Reading(settings)) => {
                    settings.take(number, value);
                    None
                }
                (Ok(_), _) => {
                    if setting_value(value).is_nan() {
                        garbled
                    } else {
                        None
                    }
                }
                (_, Stage::ReadingBlocks(_, blocks) | Stage::ReadingBack(blocks))
                    if name.starts_with('N') =>
                {
                    blocks.take(name, value);
                    None
                }
                _ if name.starts_with('N') => Some(Reply::Message(text(line))),
                _ => garbled,
            }
        } else if line.starts_with("Grbl ") || line.starts_with("GrblHAL ") {
            self.greeted()
        } else if line.starts_with("[HLP:") && self.stage == Stage::Waking {
            None
        } else if let Some(inner) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'))
            && matches!(self.stage, Stage::Arming(_) | Stage::Identifying(_))
        {
            match &mut self.stage {
                Stage::Identifying(identity) => identity.take(inner),
                _ => {
                    let three = self.three();
                    self.stated.take(inner, three);
                }
            }
            None
        } else if line.starts_with('[') && line.ends_with(']') || line.starts_with('>') {
            Some(Reply::Message(text(line)))
        } else {
            garbled
        }
    }

    fn greeted(&mut self) -> Option<Reply> {
        match self.stage {
            Stage::Silent => None,
            Stage::Aborting => {
                self.stage = Stage::Silent;
                None
            }
            _ => Some(Reply::Restarted),
        }
    }

    /// Handles `ok`: the controller accepted the oldest line.
    fn answered(&mut self, out: &mut Vec<u8>) -> Option<Reply> {
        match self.stage {
            Stage::Silent | Stage::Aborting => None,
            Stage::Waking => self.identify(out),
            Stage::Identifying(identity) => self.identified(identity, out),
            Stage::Reading(settings) => self.has_read(settings, out),
            Stage::ReadingBlocks(settings, blocks) => self.set_up(&settings, blocks, out),
            Stage::Storing(stores) => self.store(stores, out),
            Stage::StoringBlock => {
                out.extend(b"$N\n");
                self.stage = Stage::ReadingBack(StartupBlocks::default());
                None
            }
            Stage::ReadingBack(blocks) => self.has_block(blocks, out),
            Stage::Homing => {
                self.stage = Stage::Prepared;
                Some(Reply::Homed)
            }
            Stage::Arming(open @ 2..) => {
                self.stage = Stage::Arming(open - 1);
                None
            }
            Stage::Arming(_) => Some(self.stated.check().map_or_else(Reply::Unfit, |()| {
                self.stage = Stage::Ready;
                Reply::Armed
            })),
            _ if std::mem::take(&mut self.switches_spindle) => Some(Reply::SpindleSwitched),
            Stage::Prepared | Stage::Ready => Some(Reply::Accepted),
        }
    }

    fn refused(&mut self, code: u16, out: &mut Vec<u8>) -> Option<Reply> {
        /// Error 8, not idle: after a jog stream runs dry, GRBL stays in Run for a moment.
        const NOT_IDLE: u16 = 8;
        match self.stage {
            Stage::Silent | Stage::Aborting => None,
            Stage::Waking => self.identify(out),
            _ => Some(Reply::Refused { code, meaning: error_text(code), transient: code == NOT_IDLE }),
        }
    }

    /// `None` when the report is malformed: the dialect then uses no part of it.
    fn report(&mut self, line: &str) -> Option<Reply> {
        let Status { mode, position, free, offset, feed_percent, .. } = Status::parse(line, self.three())?;
        let position = position.map(|at| self.setting.in_drawing(at)).transpose().ok()?;
        if offset.is_some_and(|offset| self.displaced(offset)) {
            return Some(Reply::Displaced);
        }
        if let Some(percent @ 101..) = feed_percent
            && self.stage == Stage::Ready
        {
            let needed = "at most 100 %, because the contour error holds for the planned feed: somebody else \
                          raised it";
            return Some(Reply::Unfit(Unfit { name: "feed override", value: percent.into(), needed }));
        }
        let (queued, waiting) = free.and_then(|free| self.buffers.take(mode, free)).unzip();
        let agreed = self.work_offset.is_some() && self.work_offset == self.stated.sum();
        // The position is not used without the report's buffer field, or with a work offset that was not
        // confirmed.
        let position = position.filter(|_| agreed && waiting.is_some() || self.stage != Stage::Ready);
        Some(Reply::Report(Report { mode, position, queued, waiting }))
    }

    /// Takes the reported work offset. Returns whether it changed while the session relies on it.
    fn displaced(&mut self, offset: Place) -> bool {
        let before = self.work_offset.replace(offset);
        self.stage == Stage::Ready && before.is_some_and(|before| before != offset)
    }
}

impl Dialect for Grbl {
    fn abilities(&self) -> Abilities {
        Abilities {
            interpolation: Interpolation::Linear,
            contours: Interpolation::Linear,
            arcs: true,
            queues: true,
            // A hold or a cancel can run away, so the dialect sends neither (`docs/safety/controllers.md`).
            on_cancel: OnCancel::NotOffered,
            checked: false,
            spindle: self.setting.spindle_rpm.is_some(),
        }
    }

    fn encode(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        match command {
            Command::Query => out.push(b'?'),
            // Unreachable: the guard certifies no cancel for this dialect.
            Command::Cancel(_) => out.push(0x85),
            Command::EndHoming | Command::Abort => {
                out.push(0x18);
                self.stage = Stage::Aborting;
            }
            // A partial line may remain from before the cable was pulled. A bare line end would make the
            // controller drive to the partial target. With a `$` at its end every line is rejected, and `$`
            // alone is answered with a help text.
            Command::Prepare => {
                self.switches_spindle = false;
                out.extend(b"$\n");
                self.stage = Stage::Waking;
                // It may be another controller.
                self.buffers = Buffers::default();
            }
            Command::Arm => match self.startup {
                Some(line) => {
                    out.extend(line);
                    self.stage = Stage::StoringBlock;
                }
                None => self.arm(out),
            },
            Command::Home => {
                out.extend(b"$H\n");
                self.stage = Stage::Homing;
            }
            Command::Spindle { runs } => {
                self.spindle(*runs, out)?;
                self.switches_spindle = true;
            }
            Command::Move(certified) => {
                let first = out.len();
                self.motion(certified.motion(), out).inspect_err(|_| out.truncate(first))?;
            }
        }
        Ok(())
    }

    fn decode(&mut self, byte: u8, out: &mut Vec<u8>) -> Option<Reply> {
        match self.lines.take(byte)? {
            Line::Garbled(line) => Some(Reply::Garbled(line)),
            Line::Text(line) => self.reply(as_str(&line), out),
        }
    }

    fn reset(&mut self) {
        self.stage = Stage::Silent;
        self.switches_spindle = false;
        self.lines.clear();
    }

    fn inspector(&self) -> Option<Box<dyn Inspector>> {
        Some(Box::new(GrblInspector::default()))
    }
}

/// A place relative to an origin.
fn apart(place: Place, origin: Place) -> Result<Place, LatticeError> {
    let back = Point::ORIGIN.minus(origin.point);
    let height = i64::from(place.height.units()) - i64::from(origin.height.units());
    Ok(place.point.translated(back)?.at_height(Height::from_units(height)?))
}

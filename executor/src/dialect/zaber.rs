//! Zaber ASCII with streams: lines through a live stream of axes 1 and 2 of device 1, everything under a checksum.
//!
//! Sources: the protocol manual's commands as other hosts use them (`stream 1 setup live 1 2`, `stream 1 line abs`, `get pos`,
//! `home`, `comm.checksum`, `limit.max`); from general knowledge, not yet tried on a device: the checksum (two's complement
//! of the sum between `/` and `:`), message numbers, that speeds are in microsteps/s × 1.6384 and accelerations
//! in microsteps/s² × 1.6384 / 10000, that a stream with something left to do is never reported `IDLE`.
//!
//! A position is a whole number of microsteps counted from the near end of travel; `limit.max` is the machine's zero, as the
//! table is taken to lie in [−width, 0]. How many make a mm no setting tells: the machine profile says it, and `limit.max` must be
//! the profile's travel by that figure.
//!
//! How a stream that is stopped midway leaves its line is not documented. So nothing is ever stopped: a jog is sent at rest
//! and kept short, and a contour is held by not sending the rest of it.

#[cfg(test)]
mod tests;
pub mod wire;

use keepout_guard::{Interpolation, Motion, OnCancel};
use keepout_kernel::{Curve, Point, Vector};
use wire::{Answer, alarm, content, framed, refusal};

use super::exchange::Exchanges;
use super::lines::{Line, Lines, as_str};
use super::scale::Scale;
use super::{Dialect, DialectConfig};
use crate::supervisor::{Abilities, Command, EncodeError, Limits, Mode, Reply, Report, Unfit, text};

/// What a line asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Query,
    /// Checksums on replies, from now on.
    Checksum,
    LimitMax,
    MaxSpeed,
    Acceleration,
    Home,
    /// Whether homing is over.
    Homing,
    StreamOff,
    StreamLive,
    Feed,
    Jog,
    Contour,
    /// How far the tool is from the contour's last target: the next is accepted when that is near.
    Pace,
    /// A little time, before a motion that found the stream full is sent again.
    Again,
}

/// A line under way: its number comes back with the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Asked {
    what: What,
    number: u8,
}

/// A motion, in microsteps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Target {
    to: [i64; 2],
    jog: bool,
}

/// The Zaber ASCII dialect of one session.
#[derive(Clone, Debug)]
pub struct Zaber {
    setting: DialectConfig,
    scale: Scale,
    exchanges: Exchanges<Asked>,
    number: u8,
    /// Replies without a checksum are refused.
    checked: bool,
    /// The machine's zero, microsteps.
    zero: Option<[i64; 2]>,
    limits: Limits,
    feed_mm_min: u32,
    last: Target,
    lines: Lines,
}

/// The next motion of a contour is accepted when the tool is within this of the one before's end, mm: the stream then always
/// has something to do, and never much.
const AHEAD_MM: f64 = 3.0;
/// How far the device's travel may be from the profile's, as a share: stops are set by hand.
const TRAVEL_OFF: f64 = 0.02;
/// The unit of speeds, in parts of ten thousand.
const SPEED_UNIT: i64 = 16_384;

impl Zaber {
    /// The dialect for a drawing placed on the machine.
    #[must_use]
    pub fn new(setting: DialectConfig) -> Self {
        Self {
            scale: Scale::per_mm(setting.steps_per_mm).unwrap_or(FALLBACK),
            setting,
            exchanges: Exchanges::default(),
            number: 0,
            checked: false,
            zero: None,
            limits: Limits::UNLIMITED,
            feed_mm_min: 0,
            last: Target { to: [0; 2], jog: true },
            lines: Lines::default(),
        }
    }

    fn ask(&mut self, what: What, command: std::fmt::Arguments<'_>, out: &mut Vec<u8>) {
        self.number = (self.number + 1) % 100;
        let line = framed(self.number, command);
        self.exchanges.send(Asked { what, number: self.number }, line, out);
    }

    fn ask_position(&mut self, what: What, out: &mut Vec<u8>) {
        self.ask(what, format_args!("get pos"), out);
    }

    fn query(&mut self, out: &mut Vec<u8>) {
        if self.exchanges.wants_query(|asked| asked.what == What::Query, out) {
            self.ask_position(What::Query, out);
        }
    }

    fn motion(&mut self, motion: &Motion, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let (to, feed_mm_min, jog) = match motion {
            Motion::Jog { to, feed_mm_min } => (*to, *feed_mm_min, true),
            Motion::Contour { curve: Curve::Line(line), feed_mm_min } => (line.to, *feed_mm_min, false),
            // Never asked for: this dialect says that it knows no arcs.
            Motion::Contour { curve: Curve::Arc(_), .. } => return Err(EncodeError::NoArcs),
        };
        let to = to.translated(self.setting.offset)?;
        let zero = self.zero.ok_or(EncodeError::WorkOffsetUnknown)?;
        let to = [self.scale.counts(to.x.units()), self.scale.counts(to.y.units())];
        self.last = Target { to: [to[0] + zero[0], to[1] + zero[1]], jog };
        if self.feed_mm_min != feed_mm_min {
            self.feed_mm_min = feed_mm_min;
            let speed = self.speed(feed_mm_min);
            self.ask(What::Feed, format_args!("stream 1 set maxspeed {speed}"), out);
        }
        self.send_last(out);
        Ok(())
    }

    fn send_last(&mut self, out: &mut Vec<u8>) {
        let Target { to: [x, y], jog } = self.last;
        let what = if jog { What::Jog } else { What::Contour };
        self.ask(what, format_args!("stream 1 line abs {x} {y}"), out);
    }

    /// A feed in the controller's unit of speed, at least one.
    fn speed(&self, feed_mm_min: u32) -> i64 {
        let counts = self.scale.counts(i32::try_from(u64::from(feed_mm_min) * 1000).unwrap_or(i32::MAX));
        // 1000 units are 1/100 mm.
        (counts.saturating_mul(SPEED_UNIT) / (60 * 100)).max(1)
    }

    fn reply(&mut self, line: &str, out: &mut Vec<u8>) -> Option<Reply> {
        let garbled = Some(Reply::Garbled(text(line)));
        let Some(content) = content(line, self.checked) else { return garbled };
        match line.bytes().next() {
            Some(b'@') => match Answer::read(content) {
                Some(answer) => self.answered(&answer, line, out),
                None => garbled,
            },
            Some(b'!') => match content.split_once(' ').and_then(|(_, rest)| rest.split_once(' ')) {
                Some((_, state)) => match state.split_once(' ') {
                    Some((_, warning)) if warning.starts_with('F') => Some(alarm(warning)),
                    _ => None,
                },
                None => garbled,
            },
            Some(b'#') => Some(Reply::Message(text(content))),
            _ => garbled,
        }
    }

    fn answered(&mut self, answer: &Answer<'_>, line: &str, out: &mut Vec<u8>) -> Option<Reply> {
        let asked = self.exchanges.open()?;
        // An answer that was given up and comes after all.
        if answer.number != asked.number {
            return None;
        }
        if !answer.ok && asked.what == What::Feed {
            // The supervisor hears that the motion is refused: it must not follow.
            self.exchanges.withdraw(|asked| matches!(asked.what, What::Jog | What::Contour));
            self.feed_mm_min = 0;
        }
        self.exchanges.close(out);
        if !answer.ok {
            return self.refused(asked.what, answer.data, out);
        }
        let what = asked.what;
        match what {
            What::Query => Some(self.report(answer).unwrap_or(Reply::Garbled(text(line)))),
            What::Checksum => {
                self.checked = true;
                self.ask(What::LimitMax, format_args!("get limit.max"), out);
                None
            }
            What::LimitMax | What::MaxSpeed | What::Acceleration => {
                self.setting_read(what, answer, out).unwrap_or(Some(Reply::Garbled(text(line))))
            }
            What::Home | What::Homing if answer.busy || what == What::Home => {
                self.ask_position(What::Homing, out);
                None
            }
            What::Home | What::Homing if answer.mode() == Mode::Alarm => Some(alarm(answer.warning)),
            What::Home | What::Homing => Some(Reply::Homed),
            What::StreamOff => {
                self.ask(What::StreamLive, format_args!("stream 1 setup live 1 2"), out);
                None
            }
            What::StreamLive => {
                self.feed_mm_min = 0;
                Some(Reply::Armed)
            }
            What::Feed => None,
            What::Jog => Some(Reply::Accepted),
            What::Contour => {
                self.ask_position(What::Pace, out);
                None
            }
            What::Pace => self.pace(answer, out).unwrap_or(Some(Reply::Garbled(text(line)))),
            What::Again => {
                self.send_last(out);
                None
            }
        }
    }

    fn refused(&mut self, what: What, reason: &str, out: &mut Vec<u8>) -> Option<Reply> {
        match what {
            // Nothing was set up that could be ended.
            What::StreamOff => {
                self.ask(What::StreamLive, format_args!("stream 1 setup live 1 2"), out);
                None
            }
            What::Checksum => {
                let needed = "1: answers must carry a checksum";
                Some(Reply::Unfit(Unfit { name: "comm.checksum", value: 0.0, needed }))
            }
            What::Jog | What::Contour if reason == "AGAIN" => {
                self.ask_position(What::Again, out);
                None
            }
            _ => {
                let (code, meaning) = refusal(reason);
                // Only a refused motion can be taken back.
                let transient = reason == "STATUSBUSY" && matches!(what, What::Feed | What::Jog);
                Some(Reply::Refused { code, meaning, transient })
            }
        }
    }

    /// What is wrong when the device's travel is not the profile's. Another number of microsteps in the profile makes everything smaller
    /// or larger, what is sent and what is reported alike: only the travel tells.
    fn other_travel(&self, limit: [i64; 2]) -> Option<Unfit> {
        let mut travels =
            limit.map(|counts| self.scale.to_mm(counts)).into_iter().zip(self.setting.travel_mm?);
        let (value, _) = travels.find(|(found, travel)| (found / travel - 1.0).abs() > TRAVEL_OFF)?;
        let needed = "the profile's travel_mm within 2 %; steps_per_mm or travel_mm is not this machine's";
        Some(Unfit { name: "limit.max, in mm by the profile's steps_per_mm,", value, needed })
    }

    /// `None` when the answer is no two numbers of a device's size.
    fn setting_read(&mut self, what: What, answer: &Answer<'_>, out: &mut Vec<u8>) -> Option<Option<Reply>> {
        let values = answer.pair()?;
        let [one, other] = values.map(|value| i32::try_from(value).ok());
        let (least, most) = (one?.min(other?), one?.max(other?));
        let figure = |counts: i32| f64::from(counts) * 10_000.0 / 16_384.0 / self.scale.per_mm_f64();
        Some(match what {
            What::LimitMax => {
                let wrong = self.other_travel(values);
                self.zero = if wrong.is_some() { None } else { Some(values) };
                if wrong.is_none() {
                    self.ask(What::MaxSpeed, format_args!("get maxspeed"), out);
                }
                wrong.map(Reply::Unfit)
            }
            What::MaxSpeed => {
                self.limits.speed_mm_s = figure(least);
                self.ask(What::Acceleration, format_args!("get accel"), out);
                None
            }
            _ => {
                self.limits.acceleration_mm_s2 = figure(least) * 10_000.0;
                self.limits.quicker_mm_s2 = figure(most) * 10_000.0;
                let usable = self.limits.speed_mm_s > 0.0 && self.limits.acceleration_mm_s2 > 0.0;
                let unfit = Unfit { name: "maxspeed or accel", value: 0.0, needed: "more than 0" };
                Some(if usable { Reply::Prepared(self.limits) } else { Reply::Unfit(unfit) })
            }
        })
    }

    /// `None` when the answer is no position.
    fn pace(&mut self, answer: &Answer<'_>, out: &mut Vec<u8>) -> Option<Option<Reply>> {
        let at = answer.pair()?;
        let left = (0..2).map(|k| self.last.to[k].abs_diff(at[k])).max().unwrap_or(0);
        let ahead = keepout_kernel::curve::nearest_unit(self.scale.approximate(AHEAD_MM));
        if answer.busy && left > ahead.unsigned_abs() {
            self.ask_position(What::Pace, out);
            return Some(None);
        }
        Some(Some(Reply::Accepted))
    }

    /// `None` when the answer is no position on the lattice.
    fn report(&self, answer: &Answer<'_>) -> Option<Reply> {
        if answer.warning == "WM" {
            return Some(Reply::Displaced);
        }
        let at = answer.pair()?;
        let position = match self.zero {
            Some(zero) => {
                let axis = |k: usize| self.scale.units(at[k].checked_sub(zero[k]).unwrap_or(i64::MAX));
                let Vector { dx, dy } = self.setting.offset;
                let back = Vector { dx: -dx, dy: -dy };
                Some(Point::from_units(axis(0), axis(1)).and_then(|at| at.translated(back)).ok()?)
            }
            None => None,
        };
        Some(Reply::Report(Report { mode: answer.mode(), position, queued: None, waiting: None }))
    }
}

impl Dialect for Zaber {
    fn abilities(&self) -> Abilities {
        Abilities {
            interpolation: Interpolation::Linear,
            contours: Interpolation::Linear,
            arcs: false,
            queues: false,
            on_cancel: OnCancel::NotOffered,
            checked: true,
        }
    }

    fn encode(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        match command {
            Command::Query => self.query(out),
            // Not offered, so not asked for: motions run to their certified end.
            Command::Cancel(_) | Command::EndHoming | Command::Abort => {}
            Command::Prepare => {
                self.exchanges.clear();
                self.ask(What::Checksum, format_args!("set comm.checksum 1"), out);
            }
            Command::Home => self.ask(What::Home, format_args!("home"), out),
            Command::Arm => self.ask(What::StreamOff, format_args!("stream 1 setup disable"), out),
            Command::Move(certified) => self.motion(certified.motion(), out)?,
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
        self.exchanges.clear();
        self.lines.clear();
        self.checked = false;
        self.zero = None;
    }
}

/// Taken when the machine profile has no usable steps; it is refused before anything moves.
const FALLBACK: Scale = Scale::ONE;

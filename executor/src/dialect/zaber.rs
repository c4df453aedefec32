//! Zaber ASCII with streams: lines go through a live stream of axes 1 and 2 of device 1, and a checksum
//! protects every message. Implements SR-17, SR-18, SR-19.
//!
//! Sources:
//! - The protocol manual's commands as other hosts use them: `stream 1 setup live 1 2`, `stream 1 line abs`,
//!   `get pos`, `home`, `comm.checksum`, `limit.max`.
//! - General knowledge, not yet tried on a device: the checksum (two's complement of the sum between `/` and
//!   `:`), message numbers, speeds in microsteps/s × 1.6384, accelerations in microsteps/s² × 1.6384 / 10000.
//!   A device never reports `IDLE` while its stream has motions left.
//!
//! A position is a whole number of microsteps, counted from the near end of travel. `limit.max` is the
//! machine's zero, because we assume the table in [−width, 0]. No setting states the microsteps per mm. The
//! machine profile states them, and `limit.max` must match the profile's travel by that figure.
//!
//! The manual does not state how a stream that is stopped midway leaves its line. So the dialect stops no
//! motion: it sends jogs at rest and keeps them short, and holds a contour by not sending the rest of it.

#[cfg(test)]
mod tests;
pub mod wire;

use keepout_guard::{Interpolation, Motion, OnCancel};
use keepout_kernel::{Curve, Height, Place, Point};
use wire::{Answer, alarm, content, framed, refusal};

use super::exchange::Exchanges;
use super::lines::{Line, Lines, as_str};
use super::scale::Scale;
use super::{Dialect, DialectConfig};
use crate::supervisor::{Abilities, Command, EncodeError, Limits, Mode, Reply, Report, Unfit, text};

/// The purpose of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Query,
    /// Turns on checksums in replies.
    Checksum,
    LimitMax,
    MaxSpeed,
    Acceleration,
    Home,
    /// The state while the machine homes.
    Homing,
    StreamOff,
    StreamLive,
    Feed,
    Jog,
    Contour,
    /// The distance from the tool to the contour's last target. The next motion is accepted when it is short.
    Pace,
    /// A query that fills the time before the dialect repeats a motion for which the stream was full.
    Again,
}

/// An unanswered line. The answer carries its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Asked {
    what: What,
    number: u8,
}

/// A motion, in microsteps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Target {
    to: [i64; 3],
    jog: bool,
}

/// The Zaber ASCII dialect of one session.
#[derive(Clone, Debug)]
pub struct Zaber {
    setting: DialectConfig,
    scale: Scale,
    /// The scale of the third axis.
    scale_z: Scale,
    exchanges: Exchanges<Asked>,
    number: u8,
    /// Whether replies must carry a checksum.
    checked: bool,
    /// The machine's zero, microsteps.
    zero: Option<[i64; 3]>,
    limits: Limits,
    feed_mm_min: u32,
    last: Target,
    lines: Lines,
}

/// Distance to the end of the previous contour motion, mm, below which the next one is accepted. The stream
/// then never runs dry, and never holds much.
const AHEAD_MM: f64 = 3.0;
/// Largest difference of the device's travel from the profile's, as a share: people set the stops by hand.
const TRAVEL_OFF: f64 = 0.02;
/// Device speed units per microstep/s, times 10 000.
const SPEED_UNIT: i64 = 16_384;

impl Zaber {
    /// The dialect for a drawing placed on the machine.
    #[must_use]
    pub fn new(setting: DialectConfig) -> Self {
        Self {
            // The start rejects a profile without usable steps per mm before anything moves.
            scale: Scale::per_mm(setting.steps_per_mm).unwrap_or(Scale::ONE),
            scale_z: setting.z.and_then(|z| Scale::per_mm(z.steps_per_mm)).unwrap_or(Scale::ONE),
            setting,
            exchanges: Exchanges::default(),
            number: 0,
            checked: false,
            zero: None,
            limits: Limits::UNLIMITED,
            feed_mm_min: 0,
            last: Target { to: [0; 3], jog: true },
            lines: Lines::default(),
        }
    }

    fn ask(&mut self, what: What, command: std::fmt::Arguments<'_>, out: &mut Vec<u8>) {
        self.number = (self.number + 1) % 100;
        let line = framed(self.number, command);
        self.exchanges.send(Asked { what, number: self.number }, line, out);
    }

    /// Whether the machine has three axes.
    fn three(&self) -> bool {
        self.setting.z.is_some()
    }

    /// Sets up the stream of the machine's axes.
    fn set_up_stream(&mut self, out: &mut Vec<u8>) {
        let axes = if self.three() { "1 2 3" } else { "1 2" };
        self.ask(What::StreamLive, format_args!("stream 1 setup live {axes}"), out);
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
            Motion::Contour { curve: Curve::Line(line), heights: [_, height], feed_mm_min } => {
                (line.to.at_height(*height), *feed_mm_min, false)
            }
            // Unreachable: this dialect offers no arcs.
            Motion::Contour { curve: Curve::Arc(_), .. } => return Err(EncodeError::NoArcs),
        };
        let Place { point, height } = self.setting.on_machine(to)?;
        let zero = self.zero.ok_or(EncodeError::WorkOffsetUnknown)?;
        let plane = [self.scale.counts(point.x.units()), self.scale.counts(point.y.units())];
        let up = self.scale_z.counts(height.units());
        self.last = Target { to: [plane[0] + zero[0], plane[1] + zero[1], up + zero[2]], jog };
        if self.feed_mm_min != feed_mm_min {
            self.feed_mm_min = feed_mm_min;
            let speed = self.speed(feed_mm_min);
            self.ask(What::Feed, format_args!("stream 1 set maxspeed {speed}"), out);
        }
        self.send_last(out);
        Ok(())
    }

    fn send_last(&mut self, out: &mut Vec<u8>) {
        let Target { to: [x, y, z], jog } = self.last;
        let what = if jog { What::Jog } else { What::Contour };
        match self.three() {
            true => self.ask(what, format_args!("stream 1 line abs {x} {y} {z}"), out),
            false => self.ask(what, format_args!("stream 1 line abs {x} {y}"), out),
        }
    }

    /// A feed in device speed units, at least one.
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
        // A late answer to an exchange that was given up.
        if answer.number != asked.number {
            return None;
        }
        if !answer.ok && asked.what == What::Feed {
            // The supervisor learns that the motion is rejected, so it must not follow.
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
                self.set_up_stream(out);
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
            // The stream was not set up, so the dialect sets it up directly.
            What::StreamOff => {
                self.set_up_stream(out);
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
                // The supervisor can repeat only a rejected motion.
                let transient = reason == "STATUSBUSY" && matches!(what, What::Feed | What::Jog);
                Some(Reply::Refused { code, meaning, transient })
            }
        }
    }

    /// The mismatch between the device's travel and the profile's. A wrong number of microsteps in the
    /// profile scales targets and reports alike, so only the travel reveals it.
    fn other_travel(&self, [x, y, z]: [i64; 3]) -> Option<Unfit> {
        let [travel_x, travel_y] = self.setting.travel_mm?;
        let plane = [(self.scale.to_mm(x), travel_x), (self.scale.to_mm(y), travel_y)];
        let up = self.setting.z.and_then(|axis| Some((self.scale_z.to_mm(z), axis.travel_mm?)));
        let mut travels = plane.into_iter().chain(up);
        let (value, _) = travels.find(|(found, travel)| (found / travel - 1.0).abs() > TRAVEL_OFF)?;
        let needed =
            "the profile's travel_mm within 2 %. Correct steps_per_mm or travel_mm in the machine profile";
        Some(Unfit { name: "limit.max, in mm by the profile's steps_per_mm,", value, needed })
    }

    /// `None` unless the answer is two numbers of 32 bits.
    fn setting_read(&mut self, what: What, answer: &Answer<'_>, out: &mut Vec<u8>) -> Option<Option<Reply>> {
        let values = answer.axes(self.three())?;
        let [one, other, third] = values.map(|value| i32::try_from(value).ok());
        third?;
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

    /// `None` when the answer is not a position.
    fn pace(&mut self, answer: &Answer<'_>, out: &mut Vec<u8>) -> Option<Option<Reply>> {
        let at = answer.axes(self.three())?;
        let left = (0..3).map(|k| self.last.to[k].abs_diff(at[k])).max().unwrap_or(0);
        let ahead = keepout_kernel::curve::nearest_unit(self.scale.approximate(AHEAD_MM));
        if answer.busy && left > ahead.unsigned_abs() {
            self.ask_position(What::Pace, out);
            return Some(None);
        }
        Some(Some(Reply::Accepted))
    }

    /// `None` when the answer is not a position on the lattice.
    fn report(&self, answer: &Answer<'_>) -> Option<Reply> {
        if answer.warning == "WM" {
            return Some(Reply::Displaced);
        }
        let at = answer.axes(self.three())?;
        let position = match self.zero {
            Some(zero) => {
                let axis =
                    |k: usize, scale: Scale| scale.units(at[k].checked_sub(zero[k]).unwrap_or(i64::MAX));
                let point = Point::from_units(axis(0, self.scale), axis(1, self.scale)).ok()?;
                let height = if self.three() { axis(2, self.scale_z) } else { 0 };
                let machine = point.at_height(Height::from_units(height).ok()?);
                Some(self.setting.in_drawing(machine).ok()?)
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
            spindle: false,
        }
    }

    fn encode(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        match command {
            Command::Query => self.query(out),
            // Unreachable: this dialect offers no stop. Motions run to their certified end.
            Command::Cancel(_) | Command::EndHoming | Command::Abort => {}
            Command::Spindle { .. } => return Err(EncodeError::NoSpindle),
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

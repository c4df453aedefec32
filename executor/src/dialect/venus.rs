//! Venus-1 of the ITK/Micos Corvus, in host mode: each word ends with a space, and the controller answers in
//! lines. Implements SR-11, SR-12, SR-17, SR-18, SR-19.
//!
//! Sources:
//! - The Corvus adapter of Micro-Manager and the Corvus eco manual: `st` (bit 0: busy), `p`, `move`, `abort`,
//!   `2 setdim`, `cal`, `rm`, `0 0 setpos`, `getvel`, `setvel`, `getaccel`, `1 j`. A second `move` locks the
//!   interpreter until the first one is done.
//! - Two drivers in use: `getdim`, `n getunit` (2 is mm; n = 0 is the unit of velocity), `n getcaldone` (1
//!   after `cal`, 2 after `rm`, 3 after both), and `restore`, which restores the saved settings.
//! - General knowledge, not yet tried on a controller: `ge` (0 is no error); `clear` empties the stack; an
//!   `st` after `move` answers busy; only the first status bit matters here.
//!
//! The controller acknowledges no line. Its interpreter reads in order, so the answer to an `st` behind a
//! motion shows that it has read the motion. A contour motion is accepted when the tool is at rest at its
//! end. So the controller skips no contour motion, no motion locks the interpreter, and the controller always
//! reads `abort`.
//!
//! The controller interpolates both axes. The manuals do not state how `abort` slows down, so a jog may leave
//! its line. The guard certifies it as a box, and permits an `abort` only where the tool may stop anywhere
//! within its stopping distance. A contour is never aborted, and is certified as drawn.
//!
//! Homing ends at the far end of travel, and this becomes zero: the table lies in [−width, 0]. A controller
//! that another program homed may count from elsewhere. The dialect asks whether the controller was homed
//! since power-on, and trusts the operator for the rest.
//!
//! **Reset.** A controller that was reset counts from the tool's present place, in the saved units. It must
//! not execute a motion that was still on its way. The number of dimensions makes it reject such a motion:
//!
//! - The session works in two dimensions, and uses only a controller with three saved dimensions
//!   ([`What::Saved`]). After a reset `move` needs three numbers. Every motion clears the stack and pushes
//!   two, so a motion line, whole or cut anywhere, gives too few.
//! - Only one line sets two dimensions, and it sets the units after them. The controller answers it before
//!   the dialect asks for the units and for homing ([`What::Homed`]), and no motion goes out before.
//! - A controller that was reset and then read that line, or the rest of it, has the units and is not homed.
//!   The start then ends, or homes it.
//! - A controller that is reset later has three dimensions until the session ends. It then reports three
//!   coordinates, and the session ends ([`Reply::Restarted`]).

use keepout_guard::{Interpolation, Motion, OnCancel};
use keepout_kernel::{Curve, Point};
use keepout_planner::Mm2;
use keepout_planner::units::point_from_mm;

use super::exchange::{Exchanges, Sent, sent};
use super::lines::{Line, Lines, Sink, as_str, push_mm, push_number};
use super::{Dialect, DialectConfig};
use crate::supervisor::{Abilities, Command, EncodeError, Limits, Mode, Reply, Report, Text, Unfit, text};

/// The purpose of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    /// Status, then position: a tool that the status shows at rest is still there at the position.
    Query,
    /// The error number, which may come from an earlier session.
    Stale,
    /// The number of dimensions after a reset.
    Saved,
    /// The unit of an axis.
    Unit(u8),
    Velocity,
    Acceleration,
    /// The status after this many homing words.
    Homing(u8),
    /// The ends of an axis that homing found since the reset.
    Homed(u8),
    /// The status after a jog.
    Jog,
    /// Status and position after a contour motion.
    Contour,
    /// The error number.
    Error,
}

/// The Venus-1 dialect of one session.
#[derive(Clone, Debug)]
pub struct Venus {
    setting: DialectConfig,
    /// The exchanges, with the status of a half-answered query.
    exchanges: Exchanges<What, u32>,
    limits: Limits,
    feed_mm_min: u32,
    /// Target of the last motion, machine coordinates.
    target: Point,
    /// Positions are two numbers in mm. Before the set-up they may be anything.
    in_mm: bool,
    lines: Lines,
}

/// Number of `clear` words before the target. A damaged line may leave numbers on the stack, and a damaged
/// motion would take them as coordinates. On an empty stack `move` finds too few numbers, and does nothing.
const CLEARED: u32 = 4;
/// Dimensions in the session.
const DIMENSIONS: u32 = 2;
/// The unit of length: mm.
const MM: u32 = 2;
/// Homing found both ends of an axis.
const BOTH_ENDS: u32 = 3;
/// Bit 0 of the status: an axis moves.
const BUSY: u32 = 1;
/// Largest distance between a motion's target and its end, in steps.
const NEAR_STEPS: f64 = 3.0;

impl Venus {
    /// The dialect for a drawing placed on the machine.
    #[must_use]
    pub fn new(setting: DialectConfig) -> Self {
        Self {
            setting,
            exchanges: Exchanges::default(),
            limits: Limits::of(0.0, 0.0),
            feed_mm_min: 0,
            target: Point::ORIGIN,
            in_mm: false,
            lines: Lines::default(),
        }
    }

    fn ask(&mut self, what: What, line: &[u8], out: &mut Vec<u8>) {
        self.exchanges.send(what, sent(line), out);
    }

    fn motion(&mut self, motion: &Motion, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let (to, feed_mm_min, what) = match motion {
            Motion::Jog { to, feed_mm_min } => (*to, *feed_mm_min, What::Jog),
            Motion::Contour { curve: Curve::Line(line), heights: [_, height], feed_mm_min } => {
                (line.to.at_height(*height), *feed_mm_min, What::Contour)
            }
            // Unreachable: this dialect offers no arcs.
            Motion::Contour { curve: Curve::Arc(_), .. } => return Err(EncodeError::NoArcs),
        };
        let to = self.setting.on_machine(to)?.point;
        self.target = to;
        let mut line = Words::default();
        if self.feed_mm_min != feed_mm_min {
            self.feed_mm_min = feed_mm_min;
            line.thousandths(u64::from(feed_mm_min) * 1000 / 60);
            line.word(b"setvel");
        }
        for _ in 0..CLEARED {
            line.word(b"clear");
        }
        line.length(to.x.units());
        line.length(to.y.units());
        line.word(b"move");
        line.word(b"st");
        if what == What::Contour {
            line.word(b"p");
        }
        self.exchanges.send(what, line.line, out);
        Ok(())
    }

    fn reply(&mut self, line: &str, out: &mut Vec<u8>) -> Option<Reply> {
        let Some(what) = self.exchanges.open() else {
            // A late answer to an exchange that was given up.
            return None;
        };
        self.answer(what, line, out).unwrap_or_else(|| Some(self.garbled(text(line), out)))
    }

    /// Gives up the oldest exchange. Otherwise the rest of a damaged answer could pass for a whole one.
    fn garbled(&mut self, line: Text, out: &mut Vec<u8>) -> Reply {
        self.exchanges.close(out);
        Reply::Garbled(line)
    }

    /// `None` when the line is not an answer to `what`.
    fn answer(&mut self, what: What, line: &str, out: &mut Vec<u8>) -> Option<Option<Reply>> {
        if matches!(what, What::Query | What::Contour) {
            let Some(status) = self.exchanges.part() else {
                self.exchanges.hear(Some(number(line)?));
                return Some(None);
            };
            let (at_mm, count) = place(line)?;
            let reply = if self.in_mm && count != DIMENSIONS {
                self.in_mm = false;
                Some(Reply::Restarted)
            } else if what == What::Query {
                Some(self.report(status, at_mm)?)
            } else {
                self.arrived(status, point_from_mm(at_mm).ok()?, out)
            };
            self.exchanges.close(out);
            return Some(reply);
        }
        if matches!(what, What::Velocity | What::Acceleration) {
            let figure = figure(line)?;
            self.exchanges.close(out);
            return Some(self.figure_read(what, figure, out));
        }
        let number = number(line)?;
        self.exchanges.close(out);
        let busy = number & BUSY != 0;
        Some(match what {
            What::Homing(_) if busy => {
                self.ask(what, b"st ", out);
                None
            }
            What::Homing(done) => self.home(done, out),
            What::Jog => Some(Reply::Accepted),
            What::Stale | What::Saved | What::Unit(_) => self.set_up(what, number, out),
            What::Homed(_) if number != BOTH_ENDS => Some(Reply::NotHomed),
            What::Homed(1) => {
                self.ask(What::Homed(2), b"2 getcaldone ", out);
                None
            }
            What::Homed(_) => {
                self.ask(What::Error, b"ge ", out);
                None
            }
            _ if number != 0 => {
                let code = u16::try_from(number).unwrap_or(u16::MAX);
                Some(Reply::Refused { code, meaning: error_text(number), transient: false })
            }
            _ => Some(Reply::Armed),
        })
    }

    /// Sets up the session: two of the three saved dimensions, mm, joystick off. Reads the units back last.
    fn set_up(&mut self, what: What, number: u32, out: &mut Vec<u8>) -> Option<Reply> {
        let unfit = |name, needed| Some(Reply::Unfit(Unfit { name, value: f64::from(number), needed }));
        match what {
            What::Stale => self.ask(What::Saved, b"restore getdim ", out),
            What::Saved if number <= DIMENSIONS => {
                let needed = "3, so that the controller rejects a motion that arrives after a reset: \
                              send \"3 setdim save \" once";
                return unfit("getdim after restore", needed);
            }
            What::Saved => {
                let words = b"2 setdim 2 0 setunit 2 1 setunit 2 2 setunit 0 j getvel ";
                self.ask(What::Velocity, words, out);
            }
            _ if number != MM => return unfit("getunit", "2 (mm) after the session sets it"),
            What::Unit(1) => self.ask(What::Unit(2), b"2 getunit ", out),
            _ => {
                self.in_mm = true;
                return Some(Reply::Prepared(self.limits));
            }
        }
        None
    }

    /// Homes: to the near end, to the far end, and zero there. Each word goes out when the tool rests after
    /// the previous one.
    fn home(&mut self, done: u8, out: &mut Vec<u8>) -> Option<Reply> {
        let words: [&[u8]; 3] = [b"cal st ", b"rm st ", b"0 0 setpos st "];
        let Some(next) = words.get(usize::from(done)) else { return Some(Reply::Homed) };
        self.ask(What::Homing(done + 1), next, out);
        None
    }

    fn figure_read(&mut self, what: What, figure: f64, out: &mut Vec<u8>) -> Option<Reply> {
        if figure <= 0.0 {
            let name = if what == What::Velocity { "velocity" } else { "acceleration" };
            return Some(Reply::Unfit(Unfit { name, value: figure, needed: "more than 0" }));
        }
        if what == What::Velocity {
            self.limits.speed_mm_s = figure;
            self.ask(What::Acceleration, b"getaccel ", out);
        } else {
            self.limits = Limits::of(self.limits.speed_mm_s, figure);
            self.ask(What::Unit(1), b"1 getunit ", out);
        }
        None
    }

    /// Accepts a contour motion when the tool rests at its end. If the controller did not read the motion,
    /// the next one would begin elsewhere.
    fn arrived(&mut self, status: u32, at: Point, out: &mut Vec<u8>) -> Option<Reply> {
        if status & BUSY != 0 {
            self.ask(What::Contour, b"st p ", out);
            return None;
        }
        let off = at.minus(self.target);
        let near = f64::from(off.dx.abs().max(off.dy.abs())) <= NEAR_STEPS * 1e5 / self.setting.steps_per_mm;
        let meaning = "a motion of the contour was not executed";
        Some(if near { Reply::Accepted } else { Reply::Refused { code: 0, meaning, transient: false } })
    }

    /// `None` when the position is not on the lattice.
    fn report(&self, status: u32, at_mm: Mm2) -> Option<Reply> {
        let in_drawing = || self.setting.in_drawing(point_from_mm(at_mm).ok()?.in_plane()).ok();
        let position = if self.in_mm { Some(in_drawing()?) } else { None };
        let mode = if status & BUSY != 0 { Mode::Moving } else { Mode::Idle };
        Some(Reply::Report(Report { mode, position, queued: None, waiting: None }))
    }
}

impl Dialect for Venus {
    fn abilities(&self) -> Abilities {
        Abilities {
            interpolation: Interpolation::Independent,
            contours: Interpolation::Linear,
            arcs: false,
            queues: false,
            on_cancel: OnCancel::MayStray,
            checked: false,
            spindle: false,
        }
    }

    fn encode(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        match command {
            Command::Query => {
                if self.exchanges.wants_query(|what| *what == What::Query, out) {
                    self.ask(What::Query, b"st p ", out);
                }
            }
            // The controller does not answer `abort`.
            Command::Cancel(_) | Command::EndHoming => out.extend(b"abort "),
            // Unreachable: this dialect offers no hold. Contours run to their certified end.
            Command::Abort => {}
            Command::Spindle { .. } => return Err(EncodeError::NoSpindle),
            Command::Prepare => {
                self.exchanges.clear();
                self.in_mm = false;
                self.ask(What::Stale, b"ge ", out);
            }
            Command::Home => drop(self.home(0, out)),
            Command::Arm => {
                self.feed_mm_min = 0;
                self.ask(What::Homed(1), b"1 getcaldone ", out);
            }
            Command::Move(certified) => self.motion(certified.motion(), out)?,
        }
        Ok(())
    }

    fn decode(&mut self, byte: u8, out: &mut Vec<u8>) -> Option<Reply> {
        match self.lines.take(byte)? {
            Line::Garbled(line) => Some(self.garbled(line, out)),
            Line::Text(line) => self.reply(as_str(&line), out),
        }
    }

    fn reset(&mut self) {
        self.exchanges.clear();
        self.in_mm = false;
        self.lines.clear();
    }
}

/// A line of words, each ended by a space. The longest line has far fewer bytes than [`Sent`] holds.
#[derive(Default)]
struct Words {
    line: Sent,
}

impl Words {
    fn word(&mut self, word: &[u8]) {
        word.iter().for_each(|&byte| self.line.put(byte));
        self.line.put(b' ');
    }

    /// A length in mm, exact.
    fn length(&mut self, units: i32) {
        push_mm(&mut self.line, units);
        self.line.put(b' ');
    }

    /// A number with three decimals.
    fn thousandths(&mut self, thousandths: u64) {
        push_number(&mut self.line, thousandths / 1000);
        self.line.put(b'.');
        for place in [100, 10, 1] {
            push_number(&mut self.line, thousandths / place % 10);
        }
        self.line.put(b' ');
    }
}

/// The first two numbers, and the count of all numbers; `None` when there are fewer than two.
fn place(line: &str) -> Option<(Mm2, u32)> {
    let mut values = line.split_whitespace().map(figure);
    let at_mm = Mm2::new(values.next()??, values.next()??);
    Some((at_mm, values.try_fold(2, |count: u32, value| value.map(|_| count.saturating_add(1)))?))
}

fn number(word: &str) -> Option<u32> {
    word.trim().parse().ok()
}

fn figure(word: &str) -> Option<f64> {
    word.trim().parse().ok().filter(|figure: &f64| figure.is_finite())
}

fn error_text(number: u32) -> &'static str {
    match number {
        1001 | 1002 => "a word of the wrong kind",
        1003 => "beyond the machine's travel",
        1004 => "an unknown word",
        1008 => "too few numbers before a word",
        1009 => "beyond the machine's travel, or a number out of range",
        _ => "",
    }
}

#[cfg(test)]
mod tests;

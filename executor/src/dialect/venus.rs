//! Venus-1 of the ITK/Micos Corvus, in host mode: words before a space, answers in lines.
//!
//! Sources: the Corvus adapter of Micro-Manager and the Corvus eco manual for `st` (bit 0: busy), `p`, `move`, `abort`, `2 setdim`,
//! `cal`, `rm`, `0 0 setpos`, `getvel`, `setvel`, `getaccel`, `1 j`, and that a second `move` locks the interpreter until the first is
//! done; two drivers in use for `getdim`, `n getunit` (2 is mm; n = 0 is the unit of velocity), `n getcaldone` (1 after `cal`, 2 after
//! `rm`, 3 after both) and `restore`, which puts back what was saved; from general knowledge, not yet tried on a controller: `ge` (0 is
//! no error), that `clear` empties the stack, that `st` answered after `move` says busy, and that no status bit but the first matters here.
//!
//! Nothing is acknowledged. The interpreter reads in order, so the answer to an `st` that was sent after a motion says that
//! the motion was read. A motion of a contour is accepted when the tool rests at its end: so none is skipped, none ever locks the
//! interpreter, and `abort` is always heard.
//!
//! Both axes are interpolated. How `abort` slows down is not documented: a jog may leave its line and so is certified
//! as a box; a contour is never aborted, and certified as drawn. The box holds as long as no axis takes longer to stop than
//! it would have to its target: that `abort` brakes no softer than `move` does is taken for granted.
//!
//! Homing ends at the far end of travel, and that becomes zero: the table lies in [−width, 0]. A controller that was homed by
//! somebody else may count from elsewhere: that it was homed since it was switched on is asked, the rest is trusted to the operator.
//!
//! **Reset.** A controller that is reset counts from where the tool stands, in the units that were saved: a motion that was on its way
//! must not be driven. What refuses it is the number of dimensions. The session works in two, and a controller is used only when three
//! were saved ([`What::Saved`]): after a reset `move` needs three numbers, and every motion clears the stack and puts two on it, so
//! that, whole or cut anywhere, it finds too few. One line only sets two dimensions, and the units behind them. It is answered before
//! the controller is asked for its units and whether it is homed ([`What::Homed`]), and no motion goes out before. So one that was
//! reset and then read that line, or what was left of it, has the units and is not homed, which ends the start or makes it home;
//! and one that was reset later has three dimensions to the end of the session. It then gives three numbers for a place, and the
//! session ends ([`Reply::Restarted`]).

use keepout_guard::{Interpolation, Motion, OnCancel};
use keepout_kernel::{Curve, Point, Vector};
use keepout_planner::units::point_from_mm;

use super::exchange::{Exchanges, Sent, sent};
use super::lines::{Line, Lines, Sink, as_str, push_mm, push_number};
use super::{Dialect, DialectConfig};
use crate::supervisor::{Abilities, Command, EncodeError, Limits, Mode, Reply, Report, Text, Unfit, text};

/// What a line asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    /// Status and position, in this order: a tool that was at rest is still there.
    Query,
    /// The error number, which may be an old one.
    Stale,
    /// How many dimensions it has after a reset.
    Saved,
    /// The unit of an axis.
    Unit(u8),
    Velocity,
    Acceleration,
    /// A status after so many words of homing.
    Homing(u8),
    /// Which ends of an axis were found since it was reset.
    Homed(u8),
    /// A status after a jog.
    Jog,
    /// Status and position after a motion of a contour.
    Contour,
    /// The error number.
    Error,
}

/// The Venus-1 dialect of one session.
#[derive(Clone, Debug)]
pub struct Venus {
    setting: DialectConfig,
    /// With the status of a query that is half answered.
    exchanges: Exchanges<What, u32>,
    limits: Limits,
    feed_mm_min: u32,
    /// Where the last motion goes, machine coordinates.
    target: Point,
    /// Positions are of two numbers and in mm: before that they may be anything.
    in_mm: bool,
    lines: Lines,
}

/// So often the stack is cleared before the target is put on it: numbers that a damaged line left there would be taken for a
/// coordinate that is damaged now. With the stack empty `move` finds too little, and does nothing.
const CLEARED: u32 = 4;
/// Dimensions of the session.
const DIMENSIONS: u32 = 2;
/// The unit of length: mm.
const MM: u32 = 2;
/// Both ends of an axis were found.
const BOTH_ENDS: u32 = 3;
/// Bit 0 of the status: something moves.
const BUSY: u32 = 1;
/// A motion ended where it should, to so many steps.
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
            Motion::Contour { curve: Curve::Line(line), feed_mm_min } => {
                (line.to, *feed_mm_min, What::Contour)
            }
            // Never asked for: this dialect says that it knows no arcs.
            Motion::Contour { curve: Curve::Arc(_), .. } => return Err(EncodeError::NoArcs),
        };
        let to = to.translated(self.setting.offset)?;
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
            // Answers that are not waited for any more.
            return None;
        };
        self.answer(what, line, out).unwrap_or_else(|| Some(self.garbled(text(line), out)))
    }

    /// What was asked is not waited for any longer: the rest of a damaged answer must not be taken for all of it.
    fn garbled(&mut self, line: Text, out: &mut Vec<u8>) -> Reply {
        self.exchanges.close(out);
        Reply::Garbled(line)
    }

    /// `None` when the line is no answer to this.
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

    /// Three dimensions are saved; the session has two, mm and no joystick. That the units were taken is asked last.
    fn set_up(&mut self, what: What, number: u32, out: &mut Vec<u8>) -> Option<Reply> {
        let unfit = |name, needed| Some(Reply::Unfit(Unfit { name, value: f64::from(number), needed }));
        match what {
            What::Stale => self.ask(What::Saved, b"restore getdim ", out),
            What::Saved if number <= DIMENSIONS => {
                let needed = "3, so that a motion which arrives after a reset is refused: send \"3 setdim save \" once";
                return unfit("getdim after restore", needed);
            }
            What::Saved => {
                let words = b"2 setdim 2 0 setunit 2 1 setunit 2 2 setunit 0 j getvel ";
                self.ask(What::Velocity, words, out);
            }
            _ if number != MM => return unfit("getunit", "2 (mm) once it is set"),
            What::Unit(1) => self.ask(What::Unit(2), b"2 getunit ", out),
            _ => {
                self.in_mm = true;
                return Some(Reply::Prepared(self.limits));
            }
        }
        None
    }

    /// To the near end, to the far end, and zero there: each begins when the tool rests after the one before.
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

    /// A motion of a contour is accepted when it is done. One that was not read would make the next one begin elsewhere.
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

    /// `None` when the place is not on the lattice.
    fn report(&self, status: u32, at_mm: (f64, f64)) -> Option<Reply> {
        let Vector { dx, dy } = self.setting.offset;
        let back = Vector { dx: -dx, dy: -dy };
        let position =
            if self.in_mm { Some(point_from_mm(at_mm).ok()?.translated(back).ok()?) } else { None };
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
            on_cancel: OnCancel::KeepsPath,
            checked: false,
        }
    }

    fn encode(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        match command {
            Command::Query => {
                if self.exchanges.wants_query(|what| *what == What::Query, out) {
                    self.ask(What::Query, b"st p ", out);
                }
            }
            // It is not answered.
            Command::Cancel(_) | Command::EndHoming => out.extend(b"abort "),
            // Not offered, so not asked for: contours run to their certified end.
            Command::Abort => {}
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

/// Words of a line, each ended by a space. The longest line has six, far shorter than what it holds.
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

/// The first two of the numbers, and how many there are; `None` when there are fewer.
fn place(line: &str) -> Option<((f64, f64), u32)> {
    let mut values = line.split_whitespace().map(figure);
    let at_mm = (values.next()??, values.next()??);
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
        1004 => "a word that it does not know",
        1008 => "too few numbers before a word",
        1009 => "beyond the machine's travel, or a number it does not take",
        _ => "",
    }
}

#[cfg(test)]
mod tests;

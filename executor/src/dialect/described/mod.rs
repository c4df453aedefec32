//! A dialect that a TOML file describes: the controller's lines for state, position, motion and stop, its
//! errors, its echo and its prompt.
//!
//! Implements SR-17, SR-18.
//!
//! One line is under way at a time. It ends with the prompt, or with a line that the description names. A
//! controller may acknowledge no line: then it ends with the answer to the state query behind it. Echoed
//! characters must equal the sent ones. Where motions cannot be queued, a contour motion is accepted when the
//! tool rests at its end.

mod answered;
mod axes;
mod description;
mod file;
mod heard;
mod template;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use arrayvec::ArrayVec;
pub use axes::DescribedZ;
use axes::Values;
pub use description::{Accepted, Description, DescriptionError, Figure};
use heard::{Asked, For, Heard};
use keepout_guard::{Interpolation, Motion};
use keepout_kernel::{Curve, Place, Point, Turn, UNITS_PER_MM};
pub use template::{Slot, Template, TemplateError};

use super::exchange::{Exchanges, SENT_MAX, Sent};
use super::lines::{Line, Lines, Sink, as_str};
use super::{Dialect, DialectConfig};
use crate::supervisor::{Abilities, Command, EncodeError, Mode, Reply, text};

/// Most characters whose echo is expected.
const ECHO_MAX: usize = 4 * SENT_MAX;
/// Largest distance between a motion's target and its end, in steps.
const NEAR_STEPS: f64 = 3.0;

/// A described dialect of one session.
#[derive(Clone, Debug)]
pub struct Described {
    description: Arc<Description>,
    setting: DialectConfig,
    /// The exchanges, with the answer received before the prompt.
    exchanges: Exchanges<Asked, Heard>,
    echo: ArrayVec<u8, ECHO_MAX>,
    mode: Mode,
    /// Target of the last motion, machine coordinates.
    target: Place,
    lines: Lines,
}

impl Described {
    /// The dialect for a drawing placed on the machine.
    #[must_use]
    pub fn new(description: Arc<Description>, setting: DialectConfig) -> Self {
        Self {
            description,
            setting,
            exchanges: Exchanges::default(),
            echo: ArrayVec::new(),
            mode: Mode::Other,
            target: Point::ORIGIN.in_plane(),
            lines: Lines::default(),
        }
    }

    /// Sends lines. Only the last one carries the purpose.
    fn say(&mut self, lines: &[Template], values: &Values, purpose: For, out: &mut Vec<u8>) {
        let description = Arc::clone(&self.description);
        let acknowledged = description.accepted != Accepted::Query;
        let mut sent = Sent::new();
        for (index, line) in lines.iter().enumerate() {
            description.write(line, values, &mut sent);
            if acknowledged {
                let last = index + 1 == lines.len();
                let purpose = if last { purpose } else { For::Nothing };
                self.exchanges.send(Asked::Say(purpose), std::mem::take(&mut sent), out);
            }
        }
        if !acknowledged || lines.is_empty() {
            description.write(&description.status.send, values, &mut sent);
            self.exchanges.send(Asked::Status(purpose), sent, out);
        }
    }

    fn ask_status(&mut self, purpose: For, out: &mut Vec<u8>) {
        let description = Arc::clone(&self.description);
        let mut sent = Sent::new();
        description.write(&description.status.send, &Values::default(), &mut sent);
        self.exchanges.send(Asked::Status(purpose), sent, out);
    }

    /// Queries the position after a state that needs one, ahead of all waiting lines.
    fn ask_position(&mut self, purpose: For, out: &mut Vec<u8>) {
        let needs = purpose == For::Query || purpose == For::Contour && !self.description.queues;
        let description = Arc::clone(&self.description);
        if let Some(position) = description.position.as_ref().filter(|_| needs) {
            let mut sent = Sent::new();
            description.write(&position.send, &Values::default(), &mut sent);
            self.exchanges.send_next(Asked::Position(purpose), sent, out);
        }
    }

    fn motion(&mut self, motion: &Motion, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let (to, feed_mm_min, purpose) = match motion {
            Motion::Jog { to, feed_mm_min } => (*to, *feed_mm_min, For::Jog),
            Motion::Contour { curve, heights: [_, height], feed_mm_min } => {
                (curve.to().at_height(*height), *feed_mm_min, For::Contour)
            }
        };
        let to = self.setting.on_machine(to)?;
        let description = Arc::clone(&self.description);
        let (lines, centre) = match motion {
            Motion::Contour { curve: Curve::Arc(arc), .. } => {
                let mirrored = description.swap ^ description.invert[0] ^ description.invert[1];
                let [left, right] = description.arcs.as_ref().ok_or(EncodeError::NoArcs)?;
                let is_left = (arc.turn() == Turn::CounterClockwise) != mirrored;
                (if is_left { left } else { right }, description.counts(arc.centre().minus(arc.from())))
            }
            _ => (&description.line, [0, 0]),
        };
        let [a, b] = description.counts(to.point.minus(Point::ORIGIN));
        let units_s =
            i32::try_from(i64::from(feed_mm_min) * i64::from(UNITS_PER_MM) / 60).unwrap_or(i32::MAX);
        let values = Values {
            to: [a.saturating_add(description.zero[0]), b.saturating_add(description.zero[1])],
            height: description.height_counts(to.height),
            centre,
            feed: description.speed.scale.counts(units_s).max(1),
        };
        self.target = to;
        self.say(lines, &values, purpose, out);
        Ok(())
    }

    fn stop(&mut self, out: &mut Vec<u8>) {
        let description = Arc::clone(&self.description);
        let Some(stop) = &description.stop else { return };
        let mut sent = Sent::new();
        description.write(stop, &Values::default(), &mut sent);
        match (description.accepted == Accepted::Query, description.stop_at_once) {
            (true, _) => out.extend(&sent),
            (false, true) => self.exchanges.send_now(Asked::Say(For::Stop), &sent, out),
            (false, false) => self.exchanges.send_next(Asked::Say(For::Stop), sent, out),
        }
    }

    /// Adds sent bytes to the expected echo.
    fn expect_echo(&mut self, sent: &[u8]) {
        if self.description.echo {
            // If the buffer is full, the echo will differ from the expected one, and the session stops.
            sent.iter().for_each(|&byte| self.echo.put(byte));
        }
    }

    /// Takes a byte that is not an echo.
    fn hear(&mut self, byte: u8, out: &mut Vec<u8>) -> Option<Reply> {
        let byte = if byte == b'\r' { b'\n' } else { byte };
        match self.lines.take(byte) {
            Some(Line::Garbled(line)) => {
                self.fail(out);
                Some(Reply::Garbled(line))
            }
            Some(Line::Text(line)) => self.line(as_str(&line), out),
            None if !self.description.prompt.is_empty() && self.lines.stands_at(&self.description.prompt) => {
                self.lines.clear();
                self.prompted(out)
            }
            None => None,
        }
    }

    fn line(&mut self, line: &str, out: &mut Vec<u8>) -> Option<Reply> {
        let description = Arc::clone(&self.description);
        if description.ignore.iter().any(|each| each.read(line).is_some()) {
            return None;
        }
        // Data came before the line was echoed completely: the controller did not read the line as sent.
        if self.exchanges.is_single() && !self.echo.is_empty() {
            self.fail(out);
            return Some(Reply::Garbled(text(line)));
        }
        let open = self.exchanges.open();
        let heard = description.heard(open, line);
        match (open, heard) {
            (None, Some(Heard::Error { code, .. })) => {
                Some(Reply::Alarm { code, meaning: "reported without a query" })
            }
            // A late answer to an exchange that was given up.
            (None, _) => None,
            (Some(_), None) => {
                self.fail(out);
                Some(Reply::Garbled(text(line)))
            }
            (Some(_), Some(heard)) if description.prompt.is_empty() => self.over(Some(heard), out),
            (Some(_), Some(heard)) => {
                self.exchanges.hear(Some(heard));
                None
            }
        }
    }

    /// Fails the exchange under way; a prompt may still end it.
    fn fail(&mut self, out: &mut Vec<u8>) {
        self.echo.clear();
        self.exchanges.hear(None);
        if self.description.prompt.is_empty() {
            self.exchanges.close(out);
        }
    }

    fn prompted(&mut self, out: &mut Vec<u8>) -> Option<Reply> {
        self.exchanges.open()?;
        if self.exchanges.is_single() && !self.echo.is_empty() {
            self.echo.clear();
            self.exchanges.close(out);
            return Some(Reply::Garbled(text("a line that was not echoed")));
        }
        let heard = self.exchanges.part();
        self.over(heard, out)
    }

    fn forget(&mut self) {
        self.exchanges.clear();
        self.echo.clear();
    }

    fn command(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let description = Arc::clone(&self.description);
        let none = Values::default();
        match command {
            Command::Query => {
                let is_query =
                    |asked: &Asked| matches!(asked, Asked::Status(For::Query) | Asked::Position(For::Query));
                if self.exchanges.wants_query(is_query, out) {
                    self.ask_status(For::Query, out);
                }
            }
            Command::Cancel(_) | Command::EndHoming => self.stop(out),
            // Unreachable: a described controller never reports a hold.
            Command::Abort => {}
            Command::Spindle { .. } => return Err(EncodeError::NoSpindle),
            Command::Prepare => {
                self.forget();
                let too_coarse = |figure: Figure, steps_per_mm: f64| figure.per_mm() < steps_per_mm * 0.999;
                let coarse = too_coarse(description.coordinate, self.setting.steps_per_mm)
                    || description
                        .z
                        .zip(self.setting.z)
                        .is_some_and(|(z, axis)| too_coarse(z.coordinate, axis.steps_per_mm));
                match coarse {
                    true => self.ask_status(For::Unfit, out),
                    false => self.say(&description.prepare, &none, For::Preparing, out),
                }
            }
            Command::Home => drop(self.home(0, out)),
            Command::Arm => self.say(&description.arm, &none, For::Arming, out),
            Command::Move(certified) => self.motion(certified.motion(), out)?,
        }
        Ok(())
    }
}

impl Dialect for Described {
    fn abilities(&self) -> Abilities {
        let Description { interpolation, contours, queues, .. } = *self.description;
        Abilities {
            interpolation,
            contours,
            arcs: self.description.arcs.is_some() && contours == Interpolation::Linear,
            queues,
            on_cancel: self.description.on_cancel(),
            checked: false,
            spindle: false,
        }
    }

    fn encode(&mut self, command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let first = out.len();
        let outcome = self.command(command, out);
        self.expect_echo(out.get(first..).unwrap_or(&[]));
        outcome
    }

    fn decode(&mut self, byte: u8, out: &mut Vec<u8>) -> Option<Reply> {
        // After the beginning of an answer only the echo of a stop can come, because stops do not wait.
        let may_echo = self.lines.is_blank() || !self.exchanges.is_single();
        if may_echo && self.echo.first() == Some(&byte) {
            self.echo.remove(0);
            // The echo of a line's end also ends the line that it interrupts. Otherwise the digits before and after it
            // would be one number.
            if self.lines.is_blank() || byte != b'\r' {
                return None;
            }
        }
        let first = out.len();
        let reply = self.hear(byte, out);
        self.expect_echo(out.get(first..).unwrap_or(&[]));
        reply
    }

    fn reset(&mut self) {
        self.forget();
        self.lines.clear();
    }
}

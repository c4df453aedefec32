//! The lines of a log: text to entries and back.

use std::fmt::Write as _;

use keepout_guard::{Certified, Guard, Motion, Time};
use keepout_kernel::{Curve, Point};
use keepout_planner::job::ContourJob;
use thiserror::Error;

use super::job;
use crate::session::event_log::LoggedEvent;
use crate::supervisor::{OperatorCommand, OperatorInput};

/// One thing that happened, as it was logged.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// Bytes came from the controller.
    Received(Vec<u8>),
    /// The operator's input.
    OperatorInput(OperatorInput),
    /// Time passed.
    Tick,
    /// A contouring job was worked out.
    Job(Box<Result<ContourJob, String>>),
    /// The port failed.
    PortLost(String),
    /// The port came back.
    PortFound,
    /// The session was to end.
    Halt,
    /// A motion was certified: its target and in-flight set, as text.
    Certificate(String),
    /// Bytes went to the controller.
    Sent(Vec<u8>),
    /// The supervisor went into another state.
    Phase(String),
}

impl Entry {
    /// Whether it went into the engine, and did not come out of it.
    #[must_use]
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Sent(_) | Self::Certificate(_) | Self::Phase(_))
    }
}

/// Why a line says nothing that is understood.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LineError {
    /// It is not formed as its kind is.
    #[error("\"{0}\" is not formed as it should be")]
    Form(String),
    /// Its time is before that of the line before.
    #[error("its time is before that of the line before")]
    Backwards,
}

/// The checksum of a line that follows one with the sum `before`: CRC-32 over both.
pub(super) fn checksum(before: u32, text: &str) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&before.to_le_bytes());
    hasher.update(text.as_bytes());
    hasher.finalize()
}

/// The sum of a line without its end, when it is the one that the line states.
pub(super) fn verified(line: &[u8], before: u32) -> Option<u32> {
    let text = text_of(line)?;
    let stated = &line[text.len() + 1..];
    // Digits are compared as they are written: a capital letter or a sign is a changed line, too.
    let sum = checksum(before, text);
    (format!("{sum:08x}").as_bytes() == stated).then_some(sum)
}

/// The text of a line without its end: what is before the last tab.
pub(super) fn text_of(line: &[u8]) -> Option<&str> {
    let tab = memchr::memrchr(b'\t', line)?;
    std::str::from_utf8(&line[..tab]).ok()
}

/// Without spaces, tabs and line ends.
pub(super) fn quoted(text: &str) -> String {
    text.escape_default().to_string().replace(' ', "\\x20")
}

/// The bytes behind escapes as `escape_ascii` and `escape_default` write them.
pub fn unescaped(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.chars();
    while let Some(letter) = rest.next() {
        if letter != '\\' {
            bytes.extend(letter.encode_utf8(&mut [0; 4]).bytes());
            continue;
        }
        match rest.next()? {
            'n' => bytes.push(b'\n'),
            'r' => bytes.push(b'\r'),
            't' => bytes.push(b'\t'),
            'x' => {
                let digits: String = rest.by_ref().take(2).collect();
                bytes.push(u8::from_str_radix(&digits, 16).ok()?);
            }
            'u' => {
                let digits: String = rest.by_ref().skip(1).take_while(|&c| c != '}').collect();
                let letter = char::from_u32(u32::from_str_radix(&digits, 16).ok()?)?;
                bytes.extend(letter.encode_utf8(&mut [0; 4]).bytes());
            }
            other => bytes.extend(other.encode_utf8(&mut [0; 4]).bytes()),
        }
    }
    Some(bytes)
}

pub(super) fn unquoted(text: &str) -> Option<String> {
    String::from_utf8(unescaped(text)?).ok()
}

/// `w X Y TURNED_X TURNED_Y AUTO ASK`; numbers are written so that they are read as the same.
fn push_wish(text: &mut String, input: &OperatorInput) {
    let ask = match input.ask {
        None => '-',
        Some(OperatorCommand::FeedHold) => 'p',
        Some(OperatorCommand::CycleStart) => 'r',
        Some(OperatorCommand::Recover) => 'f',
        Some(OperatorCommand::Stop) => 'q',
    };
    let ((x, y), (u, v)) = (input.direction, input.turned_mm);
    let _ = write!(text, "w {x:?} {y:?} {u:?} {v:?} {} {ask}", u8::from(input.automatic));
}

/// Whether two inputs are the same to the bit: equal numbers are not, when one of them is −0.
fn is_same(a: &OperatorInput, b: &OperatorInput) -> bool {
    let bits = |input: &OperatorInput| {
        let ((x, y), (u, v)) = (input.direction, input.turned_mm);
        [x, y, u, v].map(f64::to_bits)
    };
    bits(a) == bits(b) && (a.automatic, a.ask) == (b.automatic, b.ask)
}

/// The record without its time. A input that is as the one before says only that.
pub(super) fn push_record(text: &mut String, record: &LoggedEvent<'_>, before: &mut Option<OperatorInput>) {
    // Writing to a string does not fail.
    let _ = match record {
        LoggedEvent::Received(bytes) => write!(text, "r {}", bytes.escape_ascii()),
        LoggedEvent::Sent(bytes) => write!(text, "s {}", bytes.escape_ascii()),
        LoggedEvent::OperatorInput(input) if before.is_some_and(|before| is_same(&before, input)) => {
            write!(text, "w")
        }
        LoggedEvent::OperatorInput(input) => {
            push_wish(text, input);
            *before = Some(*input);
            Ok(())
        }
        LoggedEvent::Tick => write!(text, "t"),
        LoggedEvent::Job(job) => {
            text.push_str("j ");
            job::push(text, job);
            Ok(())
        }
        LoggedEvent::PortLost(reason) => write!(text, "x {}", reason.escape_default()),
        LoggedEvent::PortFound => write!(text, "o"),
        LoggedEvent::Halt => write!(text, "h"),
        LoggedEvent::Certificate(certified, guard) => write!(text, "c {}", certificate(certified, guard)),
        LoggedEvent::Phase(phase, None) => write!(text, "p {phase:?}"),
        LoggedEvent::Phase(phase, Some(fault)) => {
            write!(text, "p {phase:?} {}", fault.to_string().escape_default())
        }
    };
}

/// What allowed a motion: `jog X Y F {SET}` with the in-flight set in lattice units, which holds the target; `line X Y X Y F`
/// or `arc X Y X Y CX CY + F` of a contour.
fn certificate(certified: &Certified, guard: &Guard) -> String {
    let mut text = String::new();
    match certified.motion() {
        Motion::Jog { to, feed_mm_min } => {
            text.push_str("jog ");
            job::push_point(&mut text, *to);
            let _ = write!(text, " {feed_mm_min} {{");
            for (index, point) in guard.in_flight().enumerate() {
                text.push_str(if index > 0 { ", " } else { "" });
                job::push_point(&mut text, point);
            }
            text.push('}');
        }
        Motion::Contour { curve, feed_mm_min } => {
            text.push_str(if matches!(curve, Curve::Line(_)) { "line " } else { "arc " });
            job::push_point(&mut text, curve.from());
            text.push(' ');
            job::push_curve(&mut text, curve);
            let _ = write!(text, " {feed_mm_min}");
        }
    }
    text
}

/// The record as it will be read again.
pub(crate) fn as_entry(record: &LoggedEvent<'_>) -> Option<Entry> {
    Some(match record {
        LoggedEvent::Sent(bytes) => Entry::Sent(bytes.to_vec()),
        LoggedEvent::Certificate(certified, guard) => Entry::Certificate(certificate(certified, guard)),
        LoggedEvent::Phase(phase, None) => Entry::Phase(format!("{phase:?}")),
        LoggedEvent::Phase(phase, Some(fault)) => Entry::Phase(format!("{phase:?} {fault}")),
        _ => return None,
    })
}

/// A certificate as it was logged.
#[derive(Clone, Debug, PartialEq)]
pub enum Certificate {
    /// A jog: its target, and the in-flight set with it.
    Jog(Point, Vec<Point>),
    /// A motion of a contour.
    Contour(Curve),
}

impl Certificate {
    /// Reads the text of [`Entry::Certificate`].
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let mut fields = text.split(' ');
        if fields.next()? == "jog" {
            let target = job::point(&mut fields)?;
            let (_, set) = text.split_once('{')?;
            let points = set.strip_suffix('}')?.split(", ").map(|point| job::point(&mut point.split(' ')));
            return Some(Self::Jog(target, points.collect::<Option<_>>()?));
        }
        let from = job::point(&mut fields)?;
        let rest: Vec<&str> = fields.collect();
        job::curve(from, &rest.join(" ")).map(Self::Contour)
    }
}

/// Reads line after line; a input that is as the one before says only that.
#[derive(Debug, Default)]
pub(super) struct Reader {
    input: OperatorInput,
}

impl Reader {
    pub(super) fn parse(&mut self, text: &str) -> Result<(Time, Entry), LineError> {
        let bad = || LineError::Form(text.chars().take(200).collect());
        let (time, rest) = text.split_once(' ').ok_or_else(bad)?;
        let time = Time::from_micros(time.parse().map_err(|_| bad())?);
        let (kind, payload) = rest.split_once(' ').unwrap_or((rest, ""));
        let bytes = || unescaped(payload).ok_or_else(bad);
        let entry = match kind {
            "r" => Entry::Received(bytes()?),
            "s" => Entry::Sent(bytes()?),
            "w" if payload.is_empty() => Entry::OperatorInput(self.input),
            "w" => {
                self.input = input(payload).ok_or_else(bad)?;
                Entry::OperatorInput(self.input)
            }
            "t" => Entry::Tick,
            "j" => Entry::Job(Box::new(job::parse(payload).ok_or_else(bad)?)),
            "x" => Entry::PortLost(unquoted(payload).ok_or_else(bad)?),
            "o" => Entry::PortFound,
            "h" => Entry::Halt,
            "c" => Entry::Certificate(payload.into()),
            "p" => Entry::Phase(unquoted(payload).ok_or_else(bad)?),
            _ => return Err(bad()),
        };
        Ok((time, entry))
    }
}

fn input(payload: &str) -> Option<OperatorInput> {
    let mut fields = payload.split(' ');
    let mut number = || fields.next()?.parse::<f64>().ok();
    let direction = (number()?, number()?);
    let turned_mm = (number()?, number()?);
    let automatic = fields.next()? == "1";
    let ask = match fields.next()? {
        "-" => None,
        "p" => Some(OperatorCommand::FeedHold),
        "r" => Some(OperatorCommand::CycleStart),
        "f" => Some(OperatorCommand::Recover),
        "q" => Some(OperatorCommand::Stop),
        _ => return None,
    };
    Some(OperatorInput { direction, turned_mm, automatic, ask })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn deflection(random: &mut fastrand::Rng) -> f64 {
        let special = [0.0, -0.0, 1.0, -1.0, f64::MIN_POSITIVE, 5e-324, f64::INFINITY, 0.1 + 0.2];
        match random.usize(0..3) {
            0 => special[random.usize(0..special.len())],
            1 => random.f64() * 2.0 - 1.0,
            _ => Some(f64::from_bits(random.u64(..))).filter(|value| !value.is_nan()).unwrap_or(0.5),
        }
    }

    #[test]
    fn wishes_are_read_to_the_bit() {
        let mut random = fastrand::Rng::with_seed(5);
        let (mut before, mut reader, mut text) = (None, Reader::default(), String::new());
        let mut input = OperatorInput::default();
        for _ in 0..50_000 {
            // Some change nothing, some only a sign of zero.
            match random.u8(0..4) {
                0 => {}
                1 => input.direction.0 = if random.bool() { 0.0 } else { -0.0 },
                _ => {
                    let mut pair = || (deflection(&mut random), deflection(&mut random));
                    (input.direction, input.turned_mm) = (pair(), pair());
                    let asks = [
                        None,
                        Some(OperatorCommand::FeedHold),
                        Some(OperatorCommand::CycleStart),
                        Some(OperatorCommand::Recover),
                        Some(OperatorCommand::Stop),
                    ];
                    (input.automatic, input.ask) = (random.bool(), asks[random.usize(0..5)]);
                }
            }
            text.clear();
            text.push_str("17 ");
            push_record(&mut text, &LoggedEvent::OperatorInput(input), &mut before);
            let (_, entry) = reader.parse(&text).unwrap();
            let Entry::OperatorInput(read) = entry else { panic!("{text}") };
            assert!(is_same(&read, &input), "{text}: {read:?} for {input:?}");
        }
    }

    #[test]
    fn bytes_and_words_are_read_as_they_were_written() {
        let mut random = fastrand::Rng::with_seed(6);
        let mut text = String::new();
        for _ in 0..20_000 {
            let bytes: Vec<u8> = (0..random.usize(0..30)).map(|_| random.u8(..)).collect();
            let words: String = (0..random.usize(0..20)).map(|_| random.char(..)).collect();
            text.clear();
            push_record(&mut text, &LoggedEvent::Received(&bytes), &mut None);
            assert_eq!(unescaped(&text[2..]), Some(bytes));
            text.clear();
            push_record(&mut text, &LoggedEvent::PortLost(&words), &mut None);
            assert_eq!(unquoted(&text[2..]).as_deref(), Some(words.as_str()));
            assert_eq!(unquoted(&quoted(&words)), Some(words));
            assert!(!text.contains(['\t', '\n', '\r']));
        }
    }
}

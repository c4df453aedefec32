//! Recorded traces: every change of an operator's input, with its time.
//!
//! ```text
//! # keepout trace 1: seconds x y turned_x turned_y flags
//! 0.000000 0 0 0 0 -
//! 0.010000 0.35 -0.125 0 0 -
//! 4.120000 0 0 0.01 0 a
//! 9.000000 0 0 0 0 ap
//! 12.500000 end
//! ```
//!
//! Seconds count from the first input after the start of the machine. x and y are the deflection. `turned_x`
//! and `turned_y` are the turns of the handwheels since the previous line, mm. A line in which the third axis
//! moves has two more numbers before the flags: its deflection, upward, and the turns of its handwheel. Flags:
//! `a` cycle armed, then at most one of `p` pause (feed hold), `r` resume (cycle start), `f` recover after a
//! fault, `q` quit (stop), `u` raise, `c3` cross to contour 3, `s` the spindle runs, `t` it stands, or `-`
//! without flags. Numbers are written exactly.

use std::io::{BufRead, BufReader, Read as _};
use std::path::Path;
use std::time::Duration;

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::file::{FileError, FileKind};
use thiserror::Error;

use super::playback::{Playback, Step};

/// Most lines of a trace: five hours of constantly changing inputs.
pub const LINES_MAX: usize = 2_000_000;
/// Longest line with its end, bytes. A written number has up to 330 bytes.
const LINE_MAX: u64 = 2000;
/// The first line of a trace.
pub(super) const HEADER: &str = "# keepout trace 1: seconds x y turned_x turned_y flags";

/// The file of a trace.
pub(super) static TRACE: FileKind = FileKind {
    unwritable: "Choose another --record-trace file; an existing one is not overwritten.",
    ..FileKind::new("trace")
};

/// Why a trace cannot be used.
#[derive(Debug, Error)]
pub enum TraceError {
    /// The file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The trace has no input.
    #[error("the trace holds no input: record one with --record-trace FILE")]
    Empty,
    /// The trace is too long.
    #[error("the trace has more than {LINES_MAX} lines: cut it into pieces")]
    TooLong,
    /// A line is malformed.
    #[error("trace line {number}: {wrong}: \"{line}\"")]
    Line {
        /// Its number, from 1.
        number: usize,
        /// The reason.
        wrong: &'static str,
        /// The line.
        line: String,
    },
}

/// A recorded trace as an operator. After its end it stops the session, but finishes a running contour first.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceOperator {
    playback: Playback,
    end: Duration,
    began: Option<Time>,
}

impl TraceOperator {
    /// Reads a trace from a file.
    ///
    /// # Errors
    /// [`TraceError`] naming the file or the line.
    pub fn load(path: &Path) -> Result<Self, TraceError> {
        Self::read(BufReader::new(TRACE.open(path)?), path)
    }

    /// Reads a trace. `path` appears in the error message.
    ///
    /// # Errors
    /// [`TraceError`] naming the line.
    pub fn read(mut source: impl BufRead, path: &Path) -> Result<Self, TraceError> {
        let mut steps: Vec<Step> = Vec::new();
        let mut end = None;
        let mut bytes = Vec::new();
        for number in 1.. {
            bytes.clear();
            let read = source.by_ref().take(LINE_MAX + 1).read_until(b'\n', &mut bytes);
            if read.map_err(TRACE.read_error(path))? == 0 {
                break;
            }
            let last = end.or(steps.last().map(|step| step.at));
            let parsed = line_of(&bytes).and_then(|line| parse(line, last));
            match parsed.and_then(|parsed| checked(parsed, end.is_some())) {
                Ok(Parsed::Nothing) => {}
                Ok(Parsed::Step(step)) => steps.push(step),
                Ok(Parsed::End(at)) => end = Some(at),
                Err(wrong) => {
                    let line = String::from_utf8_lossy(&bytes).trim().chars().take(80).collect();
                    return Err(TraceError::Line { number, wrong, line });
                }
            }
            if number > LINES_MAX {
                return Err(TraceError::TooLong);
            }
        }
        let last = steps.last().ok_or(TraceError::Empty)?.at;
        Ok(Self { playback: Playback::new(steps), end: end.unwrap_or(last), began: None })
    }
}

impl Operator for TraceOperator {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        if view.phase == Phase::Starting {
            return OperatorInput::default();
        }
        let time = now.since(*self.began.get_or_insert(now));
        let input = self.playback.at(time);
        let due = self.playback.has_command() || input.turns();
        if !self.playback.over() || time <= self.end || due {
            input
        } else if view.phase == Phase::Contouring {
            OperatorInput { armed: true, ..OperatorInput::default() }
        } else {
            self.playback.stop()
        }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.playback.command()
    }
}

enum Parsed {
    Nothing,
    Step(Step),
    End(Duration),
}

/// The line without its end. The bytes beyond the longest line would otherwise become the next line.
fn line_of(bytes: &[u8]) -> Result<&str, &'static str> {
    if bytes.len() as u64 > LINE_MAX {
        return Err("the line has more than 2000 bytes");
    }
    str::from_utf8(bytes).map(str::trim).map_err(|_| "the line is not text in UTF-8")
}

/// Checks that only comments follow the end.
fn checked(parsed: Parsed, ended: bool) -> Result<Parsed, &'static str> {
    if ended && !matches!(parsed, Parsed::Nothing) { Err("a line after the end") } else { Ok(parsed) }
}

fn parse(line: &str, last: Option<Duration>) -> Result<Parsed, &'static str> {
    if line.is_empty() || line.starts_with('#') {
        return Ok(Parsed::Nothing);
    }
    let fields: Vec<&str> = line.split_whitespace().collect();
    let at = seconds(fields[0]).ok_or("the time is not a number of seconds with at most six decimals")?;
    if last.is_some_and(|last| at < last) {
        return Err("the time goes back");
    }
    match fields[1..] {
        ["end"] => Ok(Parsed::End(at)),
        [x, y, turned_x, turned_y, flags] => step(at, [x, y, turned_x, turned_y, "0", "0"], flags),
        [x, y, turned_x, turned_y, up, turned_up, flags] => {
            step(at, [x, y, turned_x, turned_y, up, turned_up], flags)
        }
        _ => Err("not SECONDS X Y TURNED_X TURNED_Y FLAGS (with UP TURNED_UP before FLAGS), or SECONDS end"),
    }
}

fn step(at: Duration, numbers: [&str; 6], flags: &str) -> Result<Parsed, &'static str> {
    let [Some(x), Some(y), Some(turned_x), Some(turned_y), Some(up), Some(turned_up_mm)] =
        numbers.map(number)
    else {
        return Err("a number is missing or not finite");
    };
    let (armed, command) =
        flags_of(flags).ok_or("the flags are not - or a and one of p, r, f, q, u, c and a number, s, t")?;
    let (velocity, turned_mm) = (Mm2::new(x, y), Mm2::new(turned_x, turned_y));
    let input = OperatorInput { velocity, turned_mm, up, turned_up_mm, armed };
    Ok(Parsed::Step(Step { at, input, command }))
}

fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|value| value.is_finite())
}

/// Reads seconds with at most six decimals, exactly.
fn seconds(text: &str) -> Option<Duration> {
    let (whole, decimals) = text.split_once('.').unwrap_or((text, "0"));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(whole) || !digits(decimals) || decimals.len() > 6 || whole.len() > 9 {
        return None;
    }
    let micros: u64 = format!("{decimals:0<6}").parse().ok()?;
    Some(Duration::from_secs(whole.parse().ok()?) + Duration::from_micros(micros))
}

/// The flags of the commands, but for those with a number.
const FLAGS: [(&str, OperatorCommand); 7] = [
    ("p", OperatorCommand::FeedHold),
    ("r", OperatorCommand::CycleStart),
    ("f", OperatorCommand::Recover),
    ("q", OperatorCommand::Stop),
    ("u", OperatorCommand::Raise),
    ("s", OperatorCommand::Spindle { runs: true }),
    ("t", OperatorCommand::Spindle { runs: false }),
];

/// The flag of a command.
pub(super) fn flag_of(command: OperatorCommand) -> String {
    match command {
        OperatorCommand::Cross { contour } => format!("c{contour}"),
        OperatorCommand::Feed { percent } => format!("v{percent}"),
        other => FLAGS.iter().find(|flag| flag.1 == other).map_or("", |flag| flag.0).into(),
    }
}

fn flags_of(flags: &str) -> Option<(bool, Option<OperatorCommand>)> {
    if flags == "-" {
        return Some((false, None));
    }
    let rest = flags.strip_prefix('a');
    let (armed, rest) = (rest.is_some(), rest.unwrap_or(flags));
    if rest.is_empty() {
        return armed.then_some((true, None));
    }
    let command = match (rest.strip_prefix('c'), rest.strip_prefix('v')) {
        (Some(contour), _) => OperatorCommand::Cross { contour: contour.parse().ok()? },
        (_, Some(percent)) => OperatorCommand::Feed { percent: percent.parse().ok()? },
        _ => FLAGS.iter().find(|flag| flag.0 == rest)?.1,
    };
    Some((armed, Some(command)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::tests::view;

    fn read(text: &str) -> Result<TraceOperator, TraceError> {
        TraceOperator::read(text.as_bytes(), Path::new("test"))
    }

    #[test]
    fn wrong_lines_are_named() {
        let wrong = [
            ("0 1 0 0 0", "not SECONDS"),
            ("x 1 0 0 0 -", "the time is not a number"),
            ("-1 1 0 0 0 -", "the time is not a number"),
            ("0.1234567 1 0 0 0 -", "the time is not a number"),
            ("0 nan 0 0 0 -", "not finite"),
            ("0 inf 0 0 0 -", "not finite"),
            ("0 1 0 0 0 pa", "the flags"),
            ("0 1 0 0 0 --", "the flags"),
            ("0 1 0 0 0 apq", "the flags"),
            ("0 1 0 0 0 c", "the flags"),
            ("0 1 0 0 0 c-1", "the flags"),
            ("0 1 0 0 0 1 a", "not SECONDS"),
            ("0 1 0 0 0 1 nan a", "not finite"),
        ];
        for (line, reason) in wrong {
            let error = read(&format!("# a note\n\n0 0 0 0 0 -\n{line}\n")).unwrap_err();
            let text = error.to_string();
            assert!(text.starts_with("trace line 4:") && text.contains(reason), "{text}");
        }
        let back = read("1 0 0 0 0 -\n0.5 0 0 0 0 -").unwrap_err().to_string();
        assert!(back.contains("line 2") && back.contains("goes back"), "{back}");
        assert!(read("1 0 0 0 0 -\n2 end\n3 0 0 0 0 -").is_err());
        assert!(matches!(read("# nothing\n"), Err(TraceError::Empty)));
        assert!(read(&"9".repeat(1 << 20)).is_err(), "a line without an end");
        for long in
            [format!("#{} 5 1 0 0 0 a", " ".repeat(1999)), format!("0 1 0 0 0 a{}q", " ".repeat(1989))]
        {
            let error = read(&format!("0 0 0 0 0 -\n{long}\n")).expect_err("the rest is another line");
            assert!(error.to_string().starts_with("trace line 2: the line has more than"), "{error}");
        }
    }

    #[test]
    fn last_command_is_given_before_the_stop() {
        let mut trace = read("0 0 0 0 0 a\n0.5 0 0 0 0 p\n1 end\n").unwrap();
        trace.input(&view(Phase::Manual), Time::ZERO);
        for command in [Some(OperatorCommand::FeedHold), None] {
            trace.input(&view(Phase::Contouring), Time::from_micros(5_000_000));
            assert_eq!(trace.command(), command);
        }
        trace.input(&view(Phase::Manual), Time::from_micros(5_000_000));
        assert_eq!(trace.command(), Some(OperatorCommand::Stop));
    }

    #[test]
    fn running_contour_is_finished_after_the_end_of_the_trace() {
        let mut trace = read("0 0 0 0 0 a\n1 end\n").unwrap();
        trace.input(&view(Phase::Manual), Time::ZERO);
        let late = Time::from_micros(5_000_000);
        trace.input(&view(Phase::Contouring), late);
        assert_eq!(trace.command(), None);
        trace.input(&view(Phase::Manual), late);
        assert_eq!(trace.command(), Some(OperatorCommand::Stop));
    }

    #[test]
    fn reading_any_text_is_total() {
        let mut random = fastrand::Rng::with_seed(2);
        let parts =
            ["0", "1.5", "-", "end", "a", "q", "\n", " ", "#", "e9", "nan", ".", "é", "\0", "0 0 0 0 0 a\n"];
        for _ in 0..20_000 {
            let text: String =
                (0..random.usize(0..20)).map(|_| parts[random.usize(0..parts.len())]).collect();
            if let Ok(mut trace) = read(&text) {
                trace.input(&view(Phase::Manual), Time::ZERO);
            }
        }
        let error = TraceOperator::read(&b"0 0 0 0 0 -\n0 1 0 \xff\xfe\n"[..], Path::new("test"))
            .expect_err("it is not text");
        assert!(error.to_string().starts_with("trace line 2: the line is not text"), "{error}");
    }
}

//! Scripts: an operator's inputs, line by line.
//!
//! Implements SR-29.
//!
//! ```text
//! # seconds  x     y     (deflection, −1 to 1)
//! 0.0        1.0   0.0
//! 2.5        0.0  -0.5
//! 6.0        0     0.3   auto
//! 20.0       pause
//! 25.0       resume
//! 50.0       turn  0.05  -0.1          # handwheels, mm
//! 52.0       up    -0.5                # third axis, −1 to 1
//! 55.0       raise                     # to the safe height
//! 57.0       spindle  runs             # or stands
//! 58.0       cross  3                  # to contour 3
//! 60.0       quit
//! ```
//!
//! Each line holds until the next. `auto` arms the cycle: a touch then starts the contour. `pause` (feed
//! hold), `resume` (cycle start), `recover` (after a fault) and `turn` deflect no stick and keep `auto`; a
//! turn is given once. When its last line begins, the script stops the session at once. If that line has
//! `auto`, it stops as soon as a contour is finished. A turn or command in the last line is still given.

use std::path::Path;
use std::time::Duration;

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::file::{FileError, FileKind};
use thiserror::Error;

use super::playback::{Playback, Step};

static SCRIPT: FileKind = FileKind::new("script");

/// Why a script cannot be used.
#[derive(Debug, Error)]
pub enum ScriptError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The script has no input.
    #[error("the script is empty: give lines such as \"0 1 0\"")]
    Empty,
    /// A line is malformed.
    #[error(
        "script line {number}: \"{line}\" is not \"SECONDS X Y [auto]\", \"SECONDS turn DX DY\", \"SECONDS up Z\", \
         \"SECONDS cross CONTOUR\", \"SECONDS spindle runs\" (stands) or \"SECONDS pause\" (resume, recover, raise, \
         quit), with times from 0 that do not go back"
    )]
    Line {
        /// Its number, from 1.
        number: usize,
        /// The line.
        line: String,
    },
}

/// A script.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    playback: Playback,
    began: Option<Time>,
}

impl Script {
    /// Reads a script from a file.
    ///
    /// # Errors
    /// [`ScriptError`] naming the file or the line.
    pub fn load(path: &Path) -> Result<Self, ScriptError> {
        Self::parse(&SCRIPT.read_text(path)?)
    }

    /// Reads a script from text.
    ///
    /// # Errors
    /// [`ScriptError::Line`] naming the first malformed line; [`ScriptError::Empty`] without an input.
    pub fn parse(text: &str) -> Result<Self, ScriptError> {
        let mut steps: Vec<Step> = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let content = line.split('#').next().unwrap_or("").trim();
            if content.is_empty() {
                continue;
            }
            let bad = || ScriptError::Line { number: index + 1, line: told(line) };
            let armed = steps.last().is_some_and(|last| last.input.armed);
            let step = step(content, armed).ok_or_else(bad)?;
            if steps.last().is_some_and(|last| last.at > step.at) {
                return Err(bad());
            }
            steps.push(step);
        }
        if steps.is_empty() {
            return Err(ScriptError::Empty);
        }
        Ok(Self { playback: Playback::new(steps), began: None })
    }
}

/// The beginning of a line, for a message.
fn told(line: &str) -> String {
    line.trim().chars().take(80).collect()
}

/// The step of a line. `armed` is the armed state of the previous line.
fn step(content: &str, armed: bool) -> Option<Step> {
    let fields: Vec<&str> = content.split_whitespace().collect();
    let (at, rest) = fields.split_first()?;
    let at = number(at).and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())?;
    let pair = |x: &str, y: &str| Some(Mm2::new(number(x)?, number(y)?));
    let still = OperatorInput { armed, ..OperatorInput::default() };
    let (input, command) = match *rest {
        ["quit"] => (OperatorInput::default(), Some(OperatorCommand::Stop)),
        ["up", up] => (OperatorInput { up: number(up)?, ..still }, None),
        ["cross", contour] => (still, Some(OperatorCommand::Cross { contour: contour.parse().ok()? })),
        ["feed", percent] => (still, Some(OperatorCommand::Feed { percent: percent.parse().ok()? })),
        ["spindle", "runs"] => (still, Some(OperatorCommand::Spindle { runs: true })),
        ["spindle", "stands"] => (still, Some(OperatorCommand::Spindle { runs: false })),
        [word] => (still, Some(command(word)?)),
        ["turn", dx, dy] => (OperatorInput { turned_mm: pair(dx, dy)?, ..still }, None),
        [x, y] => (OperatorInput { velocity: pair(x, y)?, ..OperatorInput::default() }, None),
        [x, y, "auto"] => {
            (OperatorInput { velocity: pair(x, y)?, armed: true, ..OperatorInput::default() }, None)
        }
        _ => return None,
    };
    Some(Step { at, input, command })
}

fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|value| value.is_finite())
}

fn command(word: &str) -> Option<OperatorCommand> {
    match word {
        "pause" => Some(OperatorCommand::FeedHold),
        "resume" => Some(OperatorCommand::CycleStart),
        "recover" => Some(OperatorCommand::Recover),
        "raise" => Some(OperatorCommand::Raise),
        _ => None,
    }
}

impl Operator for Script {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        if view.phase == Phase::Starting {
            return OperatorInput::default();
        }
        let already_over = self.playback.over();
        let input = self.playback.at(now.since(*self.began.get_or_insert(now)));
        let is_due = !already_over && (self.playback.has_command() || input.turned_mm != Mm2::ZERO);
        let finished = !input.armed || view.contoured && view.phase.is_steered();
        if self.playback.over() && finished && !is_due { self.playback.stop() } else { input }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.playback.command()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::tests::view;

    #[test]
    fn lines_are_read_and_errors_name_the_line() {
        let script = Script::parse("# a comment\n0 1 0\n2.5 0 -0.5 auto # touch\n9 quit\n").unwrap();
        let steps = script.playback.steps();
        assert_eq!(steps.len(), 3);
        assert!(steps[1].input.armed && steps[2].command == Some(OperatorCommand::Stop));
        assert!(matches!(Script::parse("# nothing\n\n"), Err(ScriptError::Empty)));
        let wrong = [
            "0 1",
            "x 1 0",
            "5 0 0\n4 0 0",
            "0 nan 0",
            "0 1 0 now",
            "-1 0 0",
            "1e300 0 0",
            "0 turn 1",
            "0 stop",
        ];
        for bad in wrong {
            assert!(matches!(Script::parse(bad), Err(ScriptError::Line { .. })), "{bad}");
        }
    }

    #[test]
    fn commands_and_turns_are_given_in_order() {
        let text = "0 0 0.3 auto\n1 pause\n2 resume\n3 turn 0.05 -0.1\n4 recover\n5 0 0\n6 quit";
        let mut script = Script::parse(text).unwrap();
        let given = |millis: u64, script: &mut Script| {
            let input = script.input(&view(Phase::Manual), Time::from_micros(millis * 1000));
            (input, script.command())
        };
        assert_eq!(given(0, &mut script).0.velocity, Mm2::new(0.0, 0.3));
        let (input, command) = given(1500, &mut script);
        assert!(input.armed && input.velocity == Mm2::ZERO && command == Some(OperatorCommand::FeedHold));
        assert_eq!(given(1510, &mut script).1, None, "once");
        assert_eq!(given(2500, &mut script).1, Some(OperatorCommand::CycleStart));
        assert_eq!(given(3000, &mut script).0.turned_mm, Mm2::new(0.05, -0.1));
        assert_eq!(given(3010, &mut script).0.turned_mm, Mm2::ZERO);
        assert_eq!(given(4000, &mut script).1, Some(OperatorCommand::Recover));
        assert!(!given(5000, &mut script).0.armed);
        assert_eq!(given(6000, &mut script), (OperatorInput::default(), Some(OperatorCommand::Stop)));
    }

    #[test]
    fn last_line_is_given_before_quitting() {
        let mut script = Script::parse("0 turn 1 0").unwrap();
        assert_eq!(script.input(&view(Phase::Manual), Time::ZERO).turned_mm, Mm2::new(1.0, 0.0));
        assert_eq!(script.command(), None);
        script.input(&view(Phase::Manual), Time::from_micros(1));
        assert_eq!(script.command(), Some(OperatorCommand::Stop));
    }
}

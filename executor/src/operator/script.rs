//! Scripts: what a hand does, line by line.
//!
//! ```text
//! # seconds  x     y     (deflection, −1 to 1)
//! 0.0        1.0   0.0
//! 2.5        0.0  -0.5
//! 6.0        0     0.3   auto
//! 60.0       quit
//! ```
//!
//! Each line holds until the next. `auto` lets a touch start the contour; after the last line the script quits as soon
//! as a contour is finished, or at once when it never said `auto`.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::{Operator, Seen};
use crate::supervisor::{Phase, Wish};
use crate::time::Time;

/// Why a script can not be used.
#[derive(Debug, Error)]
pub enum ScriptError {
    /// It can not be read.
    #[error("can not read script {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It has no line that says anything.
    #[error("the script says nothing: give lines such as \"0 1 0\"")]
    Empty,
    /// A line says nothing that is understood.
    #[error(
        "script line {number}: \"{line}\" is not \"SECONDS X Y [auto]\" or \"SECONDS quit\", with times that do not go back"
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
    steps: Vec<(f64, Wish)>,
    began: Option<Time>,
}

impl Script {
    /// Reads a script from a file.
    ///
    /// # Errors
    /// [`ScriptError`] naming the file or the line.
    pub fn load(path: &Path) -> Result<Self, ScriptError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| ScriptError::Read { path: path.to_path_buf(), source })?;
        Self::parse(&text)
    }

    /// Reads a script from text.
    ///
    /// # Errors
    /// [`ScriptError::Line`] naming the first line that is not understood.
    pub fn parse(text: &str) -> Result<Self, ScriptError> {
        let mut steps: Vec<(f64, Wish)> = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let content = line.split('#').next().unwrap_or("").trim();
            if content.is_empty() {
                continue;
            }
            let bad = || ScriptError::Line { number: index + 1, line: line.trim().into() };
            let (at, wish) = step(content).ok_or_else(bad)?;
            if steps.last().is_some_and(|last| last.0 > at) {
                return Err(bad());
            }
            steps.push((at, wish));
        }
        if steps.is_empty() { Err(ScriptError::Empty) } else { Ok(Self { steps, began: None }) }
    }
}

fn step(content: &str) -> Option<(f64, Wish)> {
    let fields: Vec<&str> = content.split_whitespace().collect();
    let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite());
    match fields[..] {
        [at, "quit"] => Some((number(at)?, Wish::QUIT)),
        [at, x, y] => Some((number(at)?, Wish { direction: (number(x)?, number(y)?), ..Wish::default() })),
        [at, x, y, "auto"] => Some((
            number(at)?,
            Wish { direction: (number(x)?, number(y)?), automatic: true, ..Wish::default() },
        )),
        _ => None,
    }
}

impl Operator for Script {
    fn wish(&mut self, seen: &Seen, now: Time) -> Wish {
        if seen.phase == Phase::Starting {
            return Wish::default();
        }
        let t = now.since(*self.began.get_or_insert(now)).as_secs_f64();
        let current = self.steps.iter().rposition(|step| step.0 <= t);
        let last = current.is_none_or(|index| index + 1 == self.steps.len());
        let wish = current.map_or(Wish::default(), |index| self.steps[index].1);
        let finished = last && (!wish.automatic || seen.contoured && seen.phase.is_steered());
        if finished && current.is_some() { Wish::QUIT } else { wish }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_and_faults_named() {
        let script = Script::parse("# a comment\n0 1 0\n2.5 0 -0.5 auto # touch\n9 quit\n").unwrap();
        assert_eq!(script.steps.len(), 3);
        assert!(script.steps[1].1.automatic && script.steps[2].1 == Wish::QUIT);
        assert!(matches!(Script::parse("# nothing\n\n"), Err(ScriptError::Empty)));
        for bad in ["0 1", "x 1 0", "5 0 0\n4 0 0", "0 nan 0", "0 1 0 now"] {
            assert!(matches!(Script::parse(bad), Err(ScriptError::Line { .. })), "{bad}");
        }
    }
}

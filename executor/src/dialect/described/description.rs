//! A controller's ASCII language as a TOML file describes it.

use std::path::{Path, PathBuf};

use keepout_guard::{Interpolation, OnCancel};
use keepout_planner::{plan_file, text_file};
use thiserror::Error;

use super::super::exchange::SENT_MAX;
use super::super::scale::Scale;
use super::file::{AcceptedName, ExchangeTable, File, MotionTable, RuleTable, mode_of, shape_of};
use super::template::{Slot, Template, TemplateError};
use crate::supervisor::Mode;

/// Why a description is refused.
#[derive(Debug, Error)]
pub enum DescriptionError {
    /// The file can not be read.
    #[error("can not read {}: {source}. Check the path.", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is no TOML, or has keys that mean nothing.
    #[error("{reason}")]
    Parse {
        /// Where and what.
        reason: String,
    },
    /// A line is no template.
    #[error("{key}: {error}")]
    Template {
        /// The key.
        key: &'static str,
        /// Why.
        error: TemplateError,
    },
    /// A value can not be what it is.
    #[error("{key}: {needed}")]
    Value {
        /// The key.
        key: &'static str,
        /// What it must be.
        needed: &'static str,
    },
}

/// How a line without data is answered.
#[derive(Clone, Debug, PartialEq)]
pub enum Accepted {
    /// By the prompt.
    Prompt,
    /// By a line like this.
    Answer(Template),
    /// Not at all: the state is asked behind it.
    Query,
}

/// A number as the controller writes it: whole counts, with a decimal point so many digits from the right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    pub(super) scale: Scale,
    pub(super) decimals: u8,
}

impl Figure {
    /// What the last digit stands for, as a share of the number.
    #[must_use]
    pub fn ten(self) -> f64 {
        10.0_f64.powi(self.decimals.into())
    }

    /// Counts per mm.
    #[must_use]
    pub fn per_mm(self) -> f64 {
        self.scale.per_mm_f64()
    }

    /// A number of counts as it is written.
    #[must_use]
    pub fn written(self, counts: f64) -> String {
        format!("{:.*}", usize::from(self.decimals), counts / self.ten())
    }
}

/// A question, and what its answer looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// The question as sent.
    pub send: Template,
    /// The line that answers it.
    pub answer: Template,
}

#[derive(Clone, Debug, PartialEq)]
enum Test {
    Equals(String),
    Contains(String),
    Bits(u32),
}

/// An ASCII language, as described.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// SHA-256 of the text that it was read from.
    pub hash: [u8; 32],
    /// Ends each line that is sent.
    pub end: Vec<u8>,
    /// The controller echoes each character.
    pub echo: bool,
    /// Ends each exchange; empty when nothing does.
    pub prompt: Vec<u8>,
    /// Coordinates.
    pub coordinate: Figure,
    /// Speeds.
    pub speed: Figure,
    /// The machine's zero, counts.
    pub zero: [i64; 2],
    /// The axes are exchanged.
    pub swap: bool,
    /// An axis of the controller points against the drawing's.
    pub invert: [bool; 2],
    /// Asks for the state.
    pub status: Question,
    /// `None` when the state's answer has the position too.
    pub position: Option<Question>,
    rules: Vec<(Test, Mode)>,
    otherwise: Mode,
    /// A straight motion; several lines where the controller needs them.
    pub line: Vec<Template>,
    /// Arcs counter-clockwise and clockwise.
    pub arcs: Option<[Vec<Template>; 2]>,
    /// Stops a jog under way.
    pub stop: Option<Template>,
    /// The stop acts on arrival, without its turn in the queue.
    pub stop_at_once: bool,
    /// A motion that is stopped stays on its line, or in its box.
    pub stop_keeps_path: bool,
    /// How a motion is answered.
    pub accepted: Accepted,
    /// How a jog is driven.
    pub interpolation: Interpolation,
    /// How the motions of a contour are driven.
    pub contours: Interpolation,
    /// Takes motions while it moves.
    pub queues: bool,
    /// Sent first.
    pub prepare: Vec<Template>,
    /// Homes the machine.
    pub home: Vec<Template>,
    /// Sent before the first motion.
    pub arm: Vec<Template>,
    /// Refusals, and whether each is an alarm.
    pub errors: Vec<(Template, bool)>,
    /// Lines without meaning.
    pub ignore: Vec<Template>,
}

/// Longest number that is written: a sign, ten digits, a point.
const NUMBER_MAX: usize = 14;
const DECIMALS_MAX: u8 = 6;
const PROMPT_MAX: usize = 4;

impl Description {
    /// Reads a description from a TOML file.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the key.
    pub fn load(path: &Path) -> Result<Self, DescriptionError> {
        let text = text_file::read(path)
            .map_err(|source| DescriptionError::Read { path: path.to_path_buf(), source })?;
        Self::of(&text)
    }

    /// What its stop does to a jog under way.
    #[must_use]
    pub fn on_cancel(&self) -> OnCancel {
        match (&self.stop, self.stop_keeps_path) {
            (None, _) => OnCancel::NotOffered,
            (Some(_), true) => OnCancel::KeepsPath,
            (Some(_), false) => OnCancel::MayStray,
        }
    }

    /// Reads a description.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the key.
    pub fn of(text: &str) -> Result<Self, DescriptionError> {
        let file: File = toml::from_str(text)
            .map_err(|error| DescriptionError::Parse { reason: text_file::reason(&error) })?;
        let units = &file.units;
        let motion = &file.motion;
        let interpolation = shape_of(motion.interpolation);
        let errors =
            file.errors.iter().map(|each| Ok((template("errors.says", &each.says)?, each.transient)));
        let described = Self {
            hash: plan_file::hash(text.as_bytes()),
            end: file.line.end.clone().into_bytes(),
            echo: file.line.echo,
            prompt: file.line.prompt.clone().into_bytes(),
            coordinate: figure("units.counts_per_mm", units.counts_per_mm, units.decimals)?,
            speed: figure("units.speed_counts_per_mm_s", units.speed_counts_per_mm_s, units.speed_decimals)?,
            zero: units.zero,
            swap: units.swap,
            invert: units.invert,
            status: question("ask.status.send", "ask.status.answer", &file.ask.status)?,
            position: file
                .ask
                .position
                .as_ref()
                .map(|table| question("ask.position.send", "ask.position.answer", table))
                .transpose()?,
            rules: file.status.rules.iter().map(rule).collect::<Result<_, _>>()?,
            otherwise: mode_of(file.status.otherwise),
            line: templates("motion.line", &motion.line)?,
            arcs: arcs_of(motion)?,
            stop: motion.stop.as_ref().map(|stop| template("motion.stop", stop)).transpose()?,
            stop_at_once: motion.stop_at_once,
            stop_keeps_path: motion.stop_keeps_path,
            accepted: accepted_of(motion)?,
            interpolation,
            contours: motion.contours.map_or(interpolation, shape_of),
            queues: motion.queues,
            prepare: templates("start.prepare", &file.start.prepare)?,
            home: templates("start.home", &file.start.home)?,
            arm: templates("start.arm", &file.start.arm)?,
            errors: errors.collect::<Result<_, _>>()?,
            ignore: templates("ignore", &file.ignore)?,
        };
        described.checked()
    }

    /// Checks what belongs together.
    fn checked(self) -> Result<Self, DescriptionError> {
        let has_all = |template: &Template, slots: &[Slot]| slots.iter().all(|&slot| template.has(slot));
        let any_has = |lines: &[Template], slot| lines.iter().any(|line| line.has(slot));
        let place = [Slot::X, Slot::Y];
        let where_from = self.position.as_ref().unwrap_or(&self.status);
        let fits = |lines: &[Template]| {
            let asks = self.status.send.longest(0) + self.end.len();
            let each = |line: &Template| line.longest(NUMBER_MAX) + self.end.len();
            asks + lines.iter().map(each).sum::<usize>() <= SENT_MAX
        };
        let arcs = self.arcs.iter().flatten();
        let rules = [
            (
                self.zero.iter().all(|&zero| i32::try_from(zero).is_ok()) && self.home.len() < 100,
                "units.zero",
                "counts within ±2^31, and fewer than 100 lines of start.home",
            ),
            (has_all(&self.status.answer, &[Slot::Status]), "ask.status.answer", "a line with {status}"),
            (
                has_all(&where_from.answer, &place),
                "ask.position.answer",
                "a line with {x} and {y}; or without ask.position, ask.status.answer must have them",
            ),
            (place.iter().all(|&slot| any_has(&self.line, slot)), "motion.line", "lines with {x} and {y}"),
            (
                arcs.clone().all(|lines| {
                    [Slot::X, Slot::Y, Slot::I, Slot::J].iter().all(|&slot| any_has(lines, slot))
                }),
                "motion.arc_counterclockwise",
                "lines with {x}, {y}, {i} and {j}, as motion.arc_clockwise",
            ),
            (
                [&self.line, &self.prepare, &self.home, &self.arm]
                    .into_iter()
                    .chain(arcs)
                    .all(|lines| fits(lines)),
                "motion.line",
                "shorter, as all lists of lines: together no more than 120 characters",
            ),
        ];
        match self.line_rules().into_iter().chain(rules).find(|(right, ..)| !right) {
            Some((_, key, needed)) => Err(value(key, needed)),
            None => Ok(self),
        }
    }

    /// What lines, echoes and prompts need: whether it is there, the key, and what it should be.
    fn line_rules(&self) -> [(bool, &'static str, &'static str); 5] {
        [
            (!self.end.is_empty() && self.end.len() <= PROMPT_MAX, "line.end", "one to four characters"),
            (
                self.prompt.len() <= PROMPT_MAX && self.prompt.is_ascii(),
                "line.prompt",
                "up to four ASCII characters",
            ),
            (
                self.accepted != Accepted::Prompt || !self.prompt.is_empty(),
                "motion.accepted",
                "\"prompt\" only with a line.prompt",
            ),
            (
                self.accepted == Accepted::Prompt || self.prompt.is_empty(),
                "motion.accepted",
                "\"prompt\" when there is a line.prompt: it answers every line",
            ),
            (
                !self.echo || self.accepted != Accepted::Query || self.stop.is_none(),
                "motion.stop",
                "none where line.echo is true and motion.accepted is \"query\": its echo could stand anywhere in an answer",
            ),
        ]
    }

    /// The mode that a state means; `None` when bits of it are asked for, and it is no number.
    pub(super) fn mode(&self, status: &str) -> Option<Mode> {
        for (test, mode) in &self.rules {
            let holds = match test {
                Test::Equals(word) => status == word,
                Test::Contains(part) => status.contains(part.as_str()),
                Test::Bits(bits) => status.parse::<u32>().ok()? & bits != 0,
            };
            if holds {
                return Some(*mode);
            }
        }
        Some(self.otherwise)
    }

    /// What a controller in this mode says, for a simulated one; `None` when the description has no such state.
    #[must_use]
    pub fn state(&self, wanted: Mode) -> Option<String> {
        let candidates = self.rules.iter().map(|(test, _)| match test {
            Test::Equals(word) | Test::Contains(word) => word.clone(),
            Test::Bits(bits) => bits.to_string(),
        });
        candidates.chain(["0".into(), "-".into()]).find(|state| self.mode(state) == Some(wanted))
    }
}

fn accepted_of(motion: &MotionTable) -> Result<Accepted, DescriptionError> {
    match (motion.accepted, &motion.answer) {
        (AcceptedName::Prompt, None) => Ok(Accepted::Prompt),
        (AcceptedName::Query, None) => Ok(Accepted::Query),
        (AcceptedName::Answer, Some(answer)) => Ok(Accepted::Answer(template("motion.answer", answer)?)),
        _ => Err(value("motion.answer", "given when motion.accepted is \"answer\", and only then")),
    }
}

fn arcs_of(motion: &MotionTable) -> Result<Option<[Vec<Template>; 2]>, DescriptionError> {
    let (first, second) = ("motion.arc_counterclockwise", "motion.arc_clockwise");
    match (&motion.arc_counterclockwise, &motion.arc_clockwise) {
        (Some(left), Some(right)) => Ok(Some([templates(first, left)?, templates(second, right)?])),
        (None, None) => Ok(None),
        _ => Err(value(first, "given together with motion.arc_clockwise, or neither")),
    }
}

fn template(key: &'static str, text: &str) -> Result<Template, DescriptionError> {
    Template::of(text).map_err(|error| DescriptionError::Template { key, error })
}

fn templates(key: &'static str, lines: &[String]) -> Result<Vec<Template>, DescriptionError> {
    lines.iter().map(|line| template(key, line)).collect()
}

fn question(
    send: &'static str,
    answer: &'static str,
    table: &ExchangeTable,
) -> Result<Question, DescriptionError> {
    Ok(Question { send: template(send, &table.send)?, answer: template(answer, &table.answer)? })
}

fn figure(key: &'static str, counts: f64, decimals: u8) -> Result<Figure, DescriptionError> {
    let scale = Scale::per_mm(counts).ok_or(value(key, "more than 0 and no more than 1000000"))?;
    if decimals > DECIMALS_MAX {
        Err(value(key, "with no more than 6 decimals"))
    } else {
        Ok(Figure { scale, decimals })
    }
}

fn rule(table: &RuleTable) -> Result<(Test, Mode), DescriptionError> {
    let test = match (&table.equals, &table.contains, table.bits) {
        (Some(word), None, None) if !word.is_empty() => Test::Equals(word.clone()),
        (None, Some(part), None) if !part.is_empty() => Test::Contains(part.clone()),
        (None, None, Some(bits @ 1..)) => Test::Bits(bits),
        _ => {
            let needed =
                "each with one of equals, contains and bits; a word has letters, and of bits one is set";
            return Err(value("status.rules", needed));
        }
    };
    Ok((test, mode_of(table.mode)))
}

fn value(key: &'static str, needed: &'static str) -> DescriptionError {
    DescriptionError::Value { key, needed }
}

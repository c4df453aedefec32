//! A controller's ASCII dialect, described by a TOML file. Implements SR-18.

use keepout_guard::{Interpolation, OnCancel};
use keepout_planner::{sha256, text_file};
use thiserror::Error;

use super::super::exchange::SENT_MAX;
use super::super::scale::Scale;
use super::axes::DescribedZ;
use super::file::{AcceptedName, ExchangeTable, File, MotionTable, RuleTable, mode_of, shape_of};
use super::template::{Slot, Template, TemplateError};
use crate::supervisor::Mode;

/// Why a description is rejected.
#[derive(Debug, Error)]
pub enum DescriptionError {
    /// The text is not TOML, or has unknown keys.
    #[error("{reason}")]
    Parse {
        /// The place and the reason.
        reason: String,
    },
    /// A line is not a valid template.
    #[error("{key}: {error}")]
    Template {
        /// The key.
        key: &'static str,
        /// The reason.
        error: TemplateError,
    },
    /// A value is not allowed.
    #[error("{key}: {needed}")]
    Value {
        /// The key.
        key: &'static str,
        /// The allowed value.
        needed: &'static str,
    },
}

/// The answer to a line without data.
#[derive(Clone, Debug, PartialEq)]
pub enum Accepted {
    /// The prompt.
    Prompt,
    /// A line of this form.
    Answer(Template),
    /// No answer: a state query follows the line.
    Query,
}

/// A number in the controller's form: whole counts, with a decimal point `decimals` digits from the right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    pub(super) scale: Scale,
    pub(super) decimals: u8,
}

impl Figure {
    /// The number of last-digit units in one: 10^decimals.
    #[must_use]
    pub fn ten(self) -> f64 {
        10.0_f64.powi(self.decimals.into())
    }

    /// Counts per mm.
    #[must_use]
    pub fn per_mm(self) -> f64 {
        self.scale.per_mm_f64()
    }

    /// A number of counts as text, with the figure's decimals.
    #[must_use]
    pub fn written(self, counts: f64) -> String {
        format!("{:.*}", usize::from(self.decimals), counts / self.ten())
    }
}

/// A query and the form of its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// The query, as sent.
    pub send: Template,
    /// The form of the answer.
    pub answer: Template,
}

#[derive(Clone, Debug, PartialEq)]
enum Test {
    Equals(String),
    Contains(String),
    Bits(u32),
}

/// A described ASCII dialect.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// SHA-256 of the description's text.
    pub hash: [u8; 32],
    /// The end of each sent line.
    pub end: Vec<u8>,
    /// Whether the controller echoes each character.
    pub echo: bool,
    /// The prompt that ends each exchange; empty when there is none.
    pub prompt: Vec<u8>,
    /// The form of coordinates.
    pub coordinate: Figure,
    /// The form of speeds.
    pub speed: Figure,
    /// The controller's numbers at the machine's zero, counts.
    pub zero: [i64; 2],
    /// Whether the axes are exchanged.
    pub swap: bool,
    /// Whether each axis of the controller points against the drawing's.
    pub invert: [bool; 2],
    /// The third axis. `None` on a controller of two axes.
    pub z: Option<DescribedZ>,
    /// The state query.
    pub status: Question,
    /// The position query. `None` when the state's answer also holds the position.
    pub position: Option<Question>,
    rules: Vec<(Test, Mode)>,
    otherwise: Mode,
    /// The lines of a straight motion.
    pub line: Vec<Template>,
    /// The lines of counter-clockwise and of clockwise arcs.
    pub arcs: Option<[Vec<Template>; 2]>,
    /// The line that stops a jog under way.
    pub stop: Option<Template>,
    /// Whether the stop acts on arrival, ahead of the queue.
    pub stop_at_once: bool,
    /// Whether a stopped motion stays on its line, or in its box.
    pub stop_keeps_path: bool,
    /// The answer to a motion.
    pub accepted: Accepted,
    /// The interpolation of jogs.
    pub interpolation: Interpolation,
    /// The interpolation of contour motions.
    pub contours: Interpolation,
    /// Whether the controller takes motions while it moves.
    pub queues: bool,
    /// The first lines of a session.
    pub prepare: Vec<Template>,
    /// The homing lines.
    pub home: Vec<Template>,
    /// The lines before the first motion.
    pub arm: Vec<Template>,
    /// Error answers, and whether the same line can be tried again at rest.
    pub errors: Vec<(Template, bool)>,
    /// Lines to ignore.
    pub ignore: Vec<Template>,
}

/// Longest written number, characters: a sign, ten digits, a point.
const NUMBER_MAX: usize = 14;
const DECIMALS_MAX: u8 = 6;
const PROMPT_MAX: usize = 4;

impl Description {
    /// The effect of its stop on a jog under way.
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
            hash: sha256::hash(text.as_bytes()),
            end: file.line.end.clone().into_bytes(),
            echo: file.line.echo,
            prompt: file.line.prompt.clone().into_bytes(),
            coordinate: figure("units.counts_per_mm", units.counts_per_mm, units.decimals)?,
            speed: figure("units.speed_counts_per_mm_s", units.speed_counts_per_mm_s, units.speed_decimals)?,
            zero: units.zero,
            swap: units.swap,
            invert: units.invert,
            z: units.z.as_ref().map(DescribedZ::of).transpose()?,
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

    /// Checks the keys against each other.
    fn checked(self) -> Result<Self, DescriptionError> {
        let has_all = |template: &Template, slots: &[Slot]| slots.iter().all(|&slot| template.has(slot));
        let any_has = |lines: &[Template], slot| lines.iter().any(|line| line.has(slot));
        let place: &[Slot] =
            if self.z.is_some() { &[Slot::X, Slot::Y, Slot::Z] } else { &[Slot::X, Slot::Y] };
        let where_from = self.position.as_ref().unwrap_or(&self.status);
        let fits = |lines: &[Template]| {
            let asks = self.status.send.longest(0) + self.end.len();
            let each = |line: &Template| line.longest(NUMBER_MAX) + self.end.len();
            asks + lines.iter().map(each).sum::<usize>() <= SENT_MAX
        };
        let arcs = self.arcs.iter().flatten();
        let rules = [
            (
                self.zero
                    .iter()
                    .chain(self.z.iter().map(|z| &z.zero))
                    .all(|&zero| i32::try_from(zero).is_ok())
                    && self.home.len() < 100,
                "units.zero",
                "counts within ±2^31, and fewer than 100 lines of start.home",
            ),
            (has_all(&self.status.answer, &[Slot::Status]), "ask.status.answer", "a line with {status}"),
            (
                has_all(&where_from.answer, place),
                "ask.position.answer",
                "a line with {x} and {y}, and {z} with units.z; or without ask.position, ask.status.answer must \
                 have them",
            ),
            (
                place.iter().all(|&slot| any_has(&self.line, slot)),
                "motion.line",
                "lines with {x} and {y}, and {z} with units.z",
            ),
            (
                self.z.is_some() || !any_has(&self.line, Slot::Z) && !where_from.answer.has(Slot::Z),
                "units.z",
                "present where a line has {z}",
            ),
            (
                arcs.clone().all(|lines| {
                    [Slot::X, Slot::Y, Slot::I, Slot::J].iter().all(|&slot| any_has(lines, slot))
                }),
                "motion.arc_counterclockwise",
                "lines with {x}, {y}, {i} and {j}, as in motion.arc_clockwise",
            ),
            (
                [&self.line, &self.prepare, &self.home, &self.arm]
                    .into_iter()
                    .chain(arcs)
                    .all(|lines| fits(lines)),
                "motion.line",
                "at most 120 characters together with the state query, as in each list of lines",
            ),
        ];
        match self.line_rules().into_iter().chain(rules).find(|(right, ..)| !right) {
            Some((_, key, needed)) => Err(value(key, needed)),
            None => Ok(self),
        }
    }

    /// The rules for lines, echoes and prompts: whether each holds, its key, and the allowed value.
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
                "left out where line.echo is true and motion.accepted is \"query\": the stop's echo could \
                 stand anywhere in an answer",
            ),
        ]
    }

    /// The mode that a state means. `None` when a rule tests bits, and the state is not a number.
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

    /// The state that a simulated controller reports in this mode. `None` when the description has no such
    /// state.
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
        _ => Err(value("motion.answer", "present if motion.accepted is \"answer\", and otherwise left out")),
    }
}

fn arcs_of(motion: &MotionTable) -> Result<Option<[Vec<Template>; 2]>, DescriptionError> {
    let (first, second) = ("motion.arc_counterclockwise", "motion.arc_clockwise");
    match (&motion.arc_counterclockwise, &motion.arc_clockwise) {
        (Some(left), Some(right)) => Ok(Some([templates(first, left)?, templates(second, right)?])),
        (None, None) => Ok(None),
        _ => Err(value(first, "present together with motion.arc_clockwise, or both left out")),
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

pub(super) fn figure(key: &'static str, counts: f64, decimals: u8) -> Result<Figure, DescriptionError> {
    let scale = Scale::per_mm(counts).ok_or(value(key, "more than 0 and at most 1000000"))?;
    if decimals > DECIMALS_MAX {
        Err(value(key, "at most 6 decimals"))
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
            let needed = "each with exactly one of equals, contains and bits. The word must not be empty, \
                          and bits must not be 0";
            return Err(value("status.rules", needed));
        }
    };
    Ok((test, mode_of(table.mode)))
}

fn value(key: &'static str, needed: &'static str) -> DescriptionError {
    DescriptionError::Value { key, needed }
}

//! Operators: people at a gamepad, handwheel or keyboard; models of people; scripts and recorded traces.
//!
//! | who | where |
//! |---|---|
//! | a stick with a dead-man button, or a handwheel, by evdev | [`Gamepad`]; its shape is [`Stick`] |
//! | the terminal's keys | [`Keyboard`]; what they mean is [`Keys`](keyboard::Keys) |
//! | a model | [`Model`] |
//! | a file | [`Script`], [`Trace`]; [`Recorder`] makes one |
//!
//! An operator is asked in the session's loop and never waits there: devices are read by threads of their own. Whatever
//! is gone, silent or not understood wishes for nothing. A model draws its own random numbers from a seed and is told the time, so that a run can be repeated. Figures are
//! from human motor control: reaction 0.25 s, crossover 2.5 rad/s, tremor 8–12 Hz, arm as a second-order lag.

mod attended;
pub mod device;
mod gamepad;
mod hand;
pub mod handwheel;
pub mod keyboard;
mod models;
mod panel;
mod playback;
mod recorder;
mod rounds;
mod script;
mod stick;
pub mod terminal;
pub mod trace;

use thiserror::Error;

pub use attended::{Attendant, Attended, Endable};
pub use gamepad::Gamepad;
pub(crate) use models::toward;
pub use models::{Model, ModelKind};
pub use panel::Panel;
pub use recorder::Recorder;
pub use rounds::Rounds;
pub use script::{Script, ScriptError};
pub use stick::{Stick, StickError, StickSettings};
pub use terminal::{Keyboard, TerminalError};
pub use trace::{Trace, TraceError};

use crate::supervisor::{Phase, Wish};
use crate::time::Time;

/// What the operator sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// The tool centre as displayed, drawing coordinates, mm.
    pub position_mm: Option<(f64, f64)>,
    /// The nearest point of the part, drawing coordinates, mm.
    pub wall_mm: Option<(f64, f64)>,
    /// The box around the part, `(min x, min y, max x, max y)`, mm.
    pub part_box_mm: (f64, f64, f64, f64),
    /// Where the tool will be once all that is in flight is executed, drawing coordinates, mm.
    pub end_mm: Option<(f64, f64)>,
    /// Motions sent and not acknowledged.
    pub unacknowledged: u64,
    /// What the supervisor is doing.
    pub phase: Phase,
    /// Whether a contour was finished.
    pub contoured: bool,
}

/// Somebody who steers.
pub trait Operator {
    /// The wish of this moment.
    fn wish(&mut self, seen: &Seen, now: Time) -> Wish;

    /// Time between two wishes.
    fn every(&self) -> std::time::Duration {
        std::time::Duration::from_millis(10)
    }
}

impl<O: Operator + ?Sized> Operator for Box<O> {
    fn wish(&mut self, seen: &Seen, now: Time) -> Wish {
        (**self).wish(seen, now)
    }
}

/// Why there is no operator.
#[derive(Debug, Error)]
pub enum OperatorError {
    /// Neither a model nor a file.
    #[error("no operator \"{name}\": it is none of {} and no script file", ModelKind::NAMES.join(", "))]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// A script that can not be read.
    #[error(transparent)]
    Script(#[from] ScriptError),
    /// A trace that can not be read or recorded.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// No device to steer with.
    #[error(transparent)]
    Device(#[from] device::DeviceError),
    /// A stick that can not be shaped so.
    #[error(transparent)]
    Stick(#[from] StickError),
    /// No terminal to steer or look with.
    #[error(transparent)]
    Terminal(#[from] TerminalError),
}

/// The operator of a session: a model for `manual_s` seconds and then automatic, `trace:FILE`, or a script file.
///
/// # Errors
/// [`OperatorError`] when `name` is neither a model nor a readable trace or script.
pub fn named(name: &str, manual_s: f64, seed: u64) -> Result<Box<dyn Operator + Send>, OperatorError> {
    if let Some(kind) = ModelKind::named(name) {
        return Ok(Box::new(Model::new(kind, manual_s, seed)));
    }
    if let Some(file) = name.strip_prefix("trace:") {
        return Ok(Box::new(Trace::load(std::path::Path::new(file))?));
    }
    let path = std::path::Path::new(name);
    if path.exists() {
        Ok(Box::new(Script::load(path)?))
    } else {
        Err(OperatorError::Unknown { name: name.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What an operator sees in the middle of nowhere.
    pub fn seen(phase: Phase) -> Seen {
        Seen {
            end_mm: None,
            unacknowledged: 0,
            position_mm: Some((-20.0, 10.0)),
            wall_mm: Some((0.0, 10.0)),
            part_box_mm: (0.0, 0.0, 100.0, 60.0),
            phase,
            contoured: false,
        }
    }

    /// An operator who wishes what it was told, one after the other; the start takes none.
    pub struct Told(std::vec::IntoIter<Wish>);

    impl Told {
        pub fn new(wishes: Vec<Wish>) -> Self {
            Self(wishes.into_iter())
        }
    }

    impl Operator for Told {
        fn wish(&mut self, seen: &Seen, _: Time) -> Wish {
            if seen.phase == Phase::Starting { Wish::default() } else { self.0.next().unwrap_or_default() }
        }
    }

    #[test]
    fn operators_are_found_by_name_or_file() {
        for name in ModelKind::NAMES {
            assert!(named(name, 1.0, 1).is_ok(), "{name}");
        }
        assert!(matches!(named("nobody", 1.0, 1), Err(OperatorError::Unknown { .. })));
        assert!(matches!(named("trace:/nowhere", 1.0, 1), Err(OperatorError::Trace(_))));
    }
}

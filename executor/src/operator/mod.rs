//! Operators: models of people at the joystick, and scripts.
//!
//! A model draws its own random numbers from a seed and is told the time, so that a run can be repeated. Figures are
//! from human motor control: reaction 0.25 s, crossover 2.5 rad/s, tremor 8–12 Hz, arm as a second-order lag.

mod models;
mod script;

use thiserror::Error;

pub use models::{Model, ModelKind};
pub use script::{Script, ScriptError};

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
}

/// The operator of a session: a model for `manual_s` seconds and then automatic, or a script file.
///
/// # Errors
/// [`OperatorError`] when `name` is neither a model nor a readable script.
pub fn named(name: &str, manual_s: f64, seed: u64) -> Result<Box<dyn Operator + Send>, OperatorError> {
    if let Some(kind) = ModelKind::named(name) {
        return Ok(Box::new(Model::new(kind, manual_s, seed)));
    }
    let path = std::path::Path::new(name);
    if path.exists() {
        Ok(Box::new(Script::load(path)?))
    } else {
        Err(OperatorError::Unknown { name: name.into() })
    }
}

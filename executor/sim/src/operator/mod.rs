//! Simulated operators: models, scripts and recorded traces.
//!
//! A model draws random numbers from a seed and receives the time as an argument, so a run is reproducible.
//! The figures are from human motor control: reaction time 0.25 s, crossover 2.5 rad/s, tremor 8 to 12 Hz,
//! the arm as a second-order lag.

mod arm;
mod climb;
mod models;
mod playback;
mod recorder;
mod rounds;
mod script;
pub mod trace;

pub use climb::Climb;
use keepout_executor::operator::Operator;
pub use models::{Model, ModelKind};
pub use recorder::Recorder;
pub use rounds::Rounds;
pub use script::{Script, ScriptError};
use thiserror::Error;
pub use trace::{TraceError, TraceOperator};

/// Why a name gives no operator.
#[derive(Debug, Error)]
pub enum OperatorError {
    /// The name is neither a model nor a file.
    #[error(
        "no operator \"{name}\": give one of {}, or the path of a script file",
        ModelKind::NAMES.join(", ")
    )]
    Unknown {
        /// The name.
        name: String,
    },
    /// The script is not readable.
    #[error(transparent)]
    Script(#[from] ScriptError),
    /// The trace is not readable, or cannot be recorded.
    #[error(transparent)]
    Trace(#[from] TraceError),
}

/// The operator of a session: a model that jogs for `jog_s` seconds and then arms the cycle, a trace
/// (`trace:FILE`), or a script file.
///
/// # Errors
/// [`OperatorError`] when `name` is neither a model nor a readable trace or script.
pub fn named(name: &str, jog_s: f64, seed: u64) -> Result<Box<dyn Operator + Send>, OperatorError> {
    if let Some(kind) = ModelKind::named(name) {
        return Ok(Box::new(Model::new(kind, jog_s, seed)));
    }
    if let Some(file) = name.strip_prefix("trace:") {
        return Ok(Box::new(TraceOperator::load(std::path::Path::new(file))?));
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
    use keepout_executor::operator::OperatorView;
    use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
    use keepout_guard::Time;
    use keepout_planner::{Box2, Mm2};

    use super::*;

    /// A view of the tool 20 mm from the wall.
    pub fn view(phase: Phase) -> OperatorView {
        OperatorView {
            end_mm: None,
            unacknowledged: 0,
            spindle_runs: false,
            position_mm: Some(Mm2::new(-20.0, 10.0)),
            height_mm: None,
            wall_mm: Some(Mm2::new(0.0, 10.0)),
            part_box: Box2 { low: Mm2::ZERO, high: Mm2::new(100.0, 60.0) },
            phase,
            contoured: false,
        }
    }

    /// An operator with prescribed inputs and commands, one per call. It gives no input during the start.
    pub struct Prescribed {
        steps: std::vec::IntoIter<(OperatorInput, Option<OperatorCommand>)>,
        command: Option<OperatorCommand>,
    }

    impl Prescribed {
        pub fn new(steps: Vec<(OperatorInput, Option<OperatorCommand>)>) -> Self {
            Self { steps: steps.into_iter(), command: None }
        }
    }

    impl Operator for Prescribed {
        fn input(&mut self, view: &OperatorView, _: Time) -> OperatorInput {
            if view.phase == Phase::Starting {
                return OperatorInput::default();
            }
            let (input, command) = self.steps.next().unwrap_or_default();
            self.command = command;
            input
        }

        fn command(&mut self) -> Option<OperatorCommand> {
            self.command.take()
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

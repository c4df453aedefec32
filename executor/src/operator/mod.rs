//! The operator's side of a session: the view, the jog input and the commands.

mod panel;

use keepout_guard::Time;
use keepout_planner::{Box2, Mm2};
pub use panel::Panel;

use crate::supervisor::{OperatorCommand, OperatorInput, Phase};

/// The state of the session that the operator's display shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatorView {
    /// The tool centre as displayed, drawing coordinates, mm.
    pub position_mm: Option<Mm2>,
    /// The height of the tool's tip, drawing coordinates, mm. `None` for a session with two axes.
    pub height_mm: Option<f64>,
    /// The nearest point of what stands above the tip, drawing coordinates, mm.
    pub wall_mm: Option<Mm2>,
    /// The box around the part.
    pub part_box: Box2,
    /// The tool centre after the last motion in flight, drawing coordinates, mm.
    pub end_mm: Option<Mm2>,
    /// Motions that the controller has not yet acknowledged.
    pub unacknowledged: u64,
    /// Whether the spindle runs, as the operator stated or the controller confirmed.
    pub spindle_runs: bool,
    /// The supervisor's phase.
    pub phase: Phase,
    /// Whether this session finished a contour.
    pub contoured: bool,
}

/// A source of jog inputs and operator commands: a person, a device or a model.
pub trait Operator {
    /// The jog input at time `now`.
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput;

    /// The next command since the last call. After each input the session takes one command, and executes it
    /// before the input.
    fn command(&mut self) -> Option<OperatorCommand> {
        None
    }

    /// Time between two inputs.
    fn every(&self) -> std::time::Duration {
        std::time::Duration::from_millis(10)
    }
}

impl<O: Operator + ?Sized> Operator for Box<O> {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        (**self).input(view, now)
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        (**self).command()
    }

    fn every(&self) -> std::time::Duration {
        (**self).every()
    }
}

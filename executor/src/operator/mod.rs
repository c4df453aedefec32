//! The operator's side of a session: what an operator sees, and what they command for.

mod panel;

use keepout_guard::Time;
pub use panel::Panel;

use crate::supervisor::{OperatorCommand, OperatorInput, Phase};

/// What the operator sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatorView {
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
    /// The jog input of this moment.
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput;

    /// The next command that the operator gave since the last call. The session asks for it after each input,
    /// and acts on the commands before the input.
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
}

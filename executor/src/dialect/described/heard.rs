//! What is asked of a described controller, and what its lines say to it.

use super::description::{Accepted, Description};
use super::template::{Captures, Slot};
use crate::supervisor::Mode;

/// What a line is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum For {
    /// One of several lines.
    Nothing,
    Stop,
    Query,
    Preparing,
    /// The description is too simplified for the plan.
    Unfit,
    /// So many of the lines of homing were sent.
    Homing(u8),
    Arming,
    Jog,
    Contour,
}

/// What a line is, and so what its answer looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asked {
    Say(For),
    Status(For),
    Position(For),
}

/// What was heard of the exchange under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Heard {
    Accepted,
    Status(Mode, Option<(f64, f64)>),
    Position((f64, f64)),
    Error { code: u16, transient: bool },
}

impl Description {
    /// What a line says to what was asked; `None` when it is not of the language there.
    pub(super) fn heard(&self, asked: Option<Asked>, line: &str) -> Option<Heard> {
        let error = self.errors.iter().find_map(|(says, transient)| Some((says.read(line)?, *transient)));
        if let Some((captures, transient)) = error {
            let code = captures.text(Slot::Code).and_then(|code| code.parse().ok()).unwrap_or(0);
            return Some(Heard::Error { code, transient });
        }
        let place = |captures: &Captures<'_>| Some((captures.number(Slot::X)?, captures.number(Slot::Y)?));
        match asked? {
            Asked::Say(_) => match &self.accepted {
                Accepted::Answer(answer) => answer.read(line).map(|_| Heard::Accepted),
                Accepted::Prompt | Accepted::Query => None,
            },
            Asked::Status(_) => {
                let captures = self.status.answer.read(line)?;
                let has_place = self.position.is_none();
                let place = if has_place { Some(place(&captures)?) } else { None };
                Some(Heard::Status(self.mode(captures.text(Slot::Status)?)?, place))
            }
            Asked::Position(_) => place(&self.position.as_ref()?.answer.read(line)?).map(Heard::Position),
        }
    }
}

//! The lines sent to a described controller, and the answers to them.
//!
//! Implements SR-18.

use super::description::{Accepted, Description};
use super::template::{Captures, Slot};
use crate::supervisor::Mode;
use keepout_planner::Mm3;

/// The purpose of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum For {
    /// A line before the last one of several.
    Nothing,
    Stop,
    Query,
    Preparing,
    /// The description is too coarse for the plan.
    Unfit,
    /// This many homing lines were sent.
    Homing(u8),
    Arming,
    Jog,
    Contour,
}

/// The kind of a line, which decides the form of its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asked {
    Say(For),
    Status(For),
    Position(For),
}

/// The received answer to the exchange under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Heard {
    Accepted,
    Status(Mode, Option<Mm3>),
    Position(Mm3),
    Error { code: u16, transient: bool },
}

impl Description {
    /// The answer that a line gives to the open exchange. `None` when the line matches no described form.
    pub(super) fn heard(&self, asked: Option<Asked>, line: &str) -> Option<Heard> {
        let error = self.errors.iter().find_map(|(says, transient)| Some((says.read(line)?, *transient)));
        if let Some((captures, transient)) = error {
            let code = captures.text(Slot::Code).and_then(|code| code.parse().ok()).unwrap_or(0);
            return Some(Heard::Error { code, transient });
        }
        let place = |captures: &Captures<'_>| {
            let z = if self.z.is_some() { captures.number(Slot::Z)? } else { 0.0 };
            Some(Mm3::new(captures.number(Slot::X)?, captures.number(Slot::Y)?, z))
        };
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

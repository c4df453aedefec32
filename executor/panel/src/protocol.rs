//! The messages between the browsers and the panel.

use std::time::Duration;

use keepout_executor::supervisor::OperatorCommand;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::bench::SessionWords;
use crate::gate::{MessageOrder, Steer};
use crate::snapshot::SessionState;

/// Greatest length of a message from a client, bytes.
pub const MESSAGE_MAX: usize = 1024;

/// What a client asks for.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum PanelAction {
    /// A sign of life.
    Alive {},
    /// A jog input.
    Steer {
        /// Its place in the client's order.
        order: MessageOrder,
        /// The input.
        steer: Steer,
    },
    /// A command of the operator.
    Command {
        /// Its place in the client's order.
        order: MessageOrder,
        /// The command.
        command: OperatorCommand,
    },
    /// The client wants the control lease.
    TakeControl {},
    /// The client gives the control lease back.
    GiveControl {},
    /// The holder answers another client's request.
    Answer {
        /// Whether the other client gets the lease.
        consents: bool,
    },
}

/// Why a message cannot be read.
#[derive(Debug, Error)]
pub enum MessageError {
    /// It is too long.
    #[error("a message of {bytes} bytes is longer than {MESSAGE_MAX}")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// It is not in the protocol.
    #[error("a message is not in the panel's protocol: {0}")]
    Foreign(#[from] serde_json::Error),
}

impl PanelAction {
    /// Reads a message.
    ///
    /// # Errors
    /// [`MessageError`] with the reason.
    pub fn parse(text: &str) -> Result<Self, MessageError> {
        if text.len() > MESSAGE_MAX {
            return Err(MessageError::TooLong { bytes: text.len() });
        }
        Ok(serde_json::from_str(text)?)
    }
}

/// Who has control, as one client sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "holder", rename_all = "snake_case")]
pub enum Control {
    /// Nobody.
    Free,
    /// This client.
    Mine {
        /// Whether another client asks for it.
        asked: bool,
    },
    /// Another client.
    Other {
        /// Whether this client has asked for it.
        asking: bool,
    },
}

/// What the panel sends to each client, many times a second.
#[derive(Clone, Debug, Serialize)]
pub struct StateMessage<'a> {
    /// Time stamp, µs. The client repeats it in its messages.
    pub now_us: u64,
    /// The secret of this connection. The client repeats it in its requests.
    pub screen: &'a str,
    /// Who has control.
    pub control: Control,
    /// Number that changes when a step of the job changes: the client then reads it again.
    pub revision: u64,
    /// The session. `None` while none runs.
    pub session: Option<SessionMessage<'a>>,
}

/// The state of the session for a client.
#[derive(Clone, Debug, Serialize)]
pub struct SessionMessage<'a> {
    /// Age of this state, ms. Above 500 the page shows it as dead.
    pub age_ms: u64,
    /// The state.
    #[serde(flatten)]
    pub state: &'a SessionState,
    /// The contours that are cut and those that are left, in words.
    pub tally: &'a str,
    /// The fault, with its remedy.
    pub fault: Option<String>,
    /// The last notices, oldest first.
    pub notices: &'a [String],
}

/// The answer to a message that does not count.
#[derive(Clone, Debug, Serialize)]
pub struct RefusedMessage {
    /// The reason.
    pub refused: String,
}

impl<'a> SessionMessage<'a> {
    /// The message of a state of this age.
    #[must_use]
    pub fn of(state: &'a SessionState, age: Duration, words: &'a SessionWords) -> Self {
        Self {
            age_ms: u64::try_from(age.as_millis()).unwrap_or(u64::MAX),
            state,
            tally: &words.tally,
            fault: state.fault.map(|fault| fault.to_string()),
            notices: &words.notices,
        }
    }
}

#[cfg(test)]
mod tests {
    use keepout_planner::Mm2;

    use super::*;

    #[test]
    fn messages_are_read_and_others_are_refused_by_name() {
        let steer =
            r#"{"type":"steer","order":{"sequence":3,"seen_us":17},"steer":{"held":true,"velocity":[1,0]}}"#;
        let Ok(PanelAction::Steer { order, steer }) = PanelAction::parse(steer) else {
            panic!("it is a jog input")
        };
        assert_eq!((order.sequence, steer.held, steer.velocity), (3, true, Mm2::new(1.0, 0.0)));
        for command in [r#""feed_hold""#, r#"{"cross":{"contour":3}}"#, r#"{"spindle":{"runs":true}}"#] {
            let text =
                format!(r#"{{"type":"command","order":{{"sequence":1,"seen_us":0}},"command":{command}}}"#);
            assert!(matches!(PanelAction::parse(&text), Ok(PanelAction::Command { .. })), "{text}");
        }
        for wrong in ["", "{}", r#"{"type":"fire"}"#, r#"{"type":"alive","more":1}"#, "[1,2", "\u{0}"] {
            assert!(matches!(PanelAction::parse(wrong), Err(MessageError::Foreign(_))), "{wrong}");
        }
        let long = format!(r#"{{"type":"alive"{}}}"#, " ".repeat(MESSAGE_MAX));
        assert!(matches!(PanelAction::parse(&long), Err(MessageError::TooLong { .. })));
    }
}

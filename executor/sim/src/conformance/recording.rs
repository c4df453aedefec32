//! A recording: the bytes on the line and the tool's positions, with times.

use keepout_executor::dialect::Status;
use keepout_executor::session::{SampleKind, characters, micros};
use keepout_guard::Time;
use keepout_planner::Mm2;
use serde::{Deserialize, Serialize};

/// Most events of a recording.
pub const EVENTS_MAX: usize = 4_000_000;

/// The content of an event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum What {
    /// A scenario began.
    Begin {
        /// Its name.
        name: String,
        /// The middle of its box, machine coordinates.
        origin: Mm2,
    },
    /// Sent bytes.
    #[serde(with = "characters")]
    Sent(Vec<u8>),
    /// A received line, without its end.
    #[serde(with = "characters")]
    Received(Vec<u8>),
    /// The controller came to rest.
    Rest,
    /// The tool's true position. Only a simulated machine provides it.
    Tool {
        /// The position, machine coordinates.
        at: Mm2,
        /// The kind of motion.
        kind: SampleKind,
    },
}

/// An event with its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedEvent {
    /// The time.
    #[serde(with = "micros", rename = "at_us")]
    pub at: Time,
    /// The content.
    pub what: What,
}

impl RecordedEvent {
    /// The status report in a received line.
    #[must_use]
    pub fn status(&self) -> Option<Status<'_>> {
        match &self.what {
            What::Received(line) => Status::parse(std::str::from_utf8(line).ok()?, false),
            _ => None,
        }
    }

    /// Whether it is a status query.
    #[must_use]
    pub fn is_query(&self) -> bool {
        matches!(&self.what, What::Sent(bytes) if bytes == b"?")
    }
}

/// The header of a recording: dialect and resolution.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordingHeader {
    /// The dialect.
    pub dialect: String,
    /// Last digit of a reported position, mm.
    pub digit_mm: f64,
    /// A step of the drives, mm.
    pub step_mm: f64,
}

impl RecordingHeader {
    /// The tolerance for equal positions, mm: the report's digit, a step, and 2 µm for rounding.
    #[must_use]
    pub fn tolerance_mm(&self) -> f64 {
        self.digit_mm + self.step_mm + 0.002
    }
}

/// A recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Dialect and resolution.
    pub header: RecordingHeader,
    /// The events, in order.
    pub events: Vec<RecordedEvent>,
}

impl Recording {
    /// The events of each scenario, with its name and the middle of its box.
    pub fn scenarios(&self) -> impl Iterator<Item = (&str, Mm2, &[RecordedEvent])> {
        let mut rest = self.events.as_slice();
        std::iter::from_fn(move || {
            loop {
                let (first, after) = rest.split_first()?;
                let What::Begin { name, origin } = &first.what else {
                    rest = after;
                    continue;
                };
                let begins = |event: &RecordedEvent| matches!(event.what, What::Begin { .. });
                let (events, next) = after.split_at(after.iter().position(begins).unwrap_or(after.len()));
                rest = next;
                return Some((name.as_str(), *origin, events));
            }
        })
    }
}

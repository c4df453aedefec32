//! Model conformance: the comparison of a controller with its simulated model.
//!
//! A [`ScenarioRecorder`] plays [`Scenario`]s over any port with any clock, and stores bytes and positions
//! with their times in a [`Recording`]. [`Findings`] are the figures of a recording. [`compare`] lists the
//! differences between two recordings of the same scenarios. Only the GRBL family has scenarios.
//!
//! ```text
//! scenarios ──> recorder ──> recording ──> observed ──> findings
//!                  |                          └───────> differences
//!               port, clock
//! ```

mod compare;
mod error;
mod file;
mod findings;
mod observe;
mod record;
mod recording;
mod scenario;
mod simulated;
mod start;
#[cfg(test)]
mod tests;

pub use compare::{Aspect, Difference, compare, table};
pub use error::RecordError;
pub use file::{RecordingError, load, read, save, write};
pub use findings::{Findings, Latency};
pub use observe::{Observed, Stop, observe};
pub use record::{Bench, ScenarioRecorder};
pub use recording::{RecordedEvent, Recording, RecordingHeader, What};
pub use scenario::{Care, Frame, Scenario, Step, scenarios};
pub use simulated::{SimulatedBench, simulate, simulate_with};
pub use start::{Setup, Start, StatedIdentity, check_dialect};

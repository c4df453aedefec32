//! A session: supervisor, dialect, port, operator and log, run together against a clock.

mod coverage;
mod log;
mod place;
mod report;
mod run;
mod simulated;
#[cfg(test)]
mod hostile_test;

pub use coverage::{Coverage, coverage};
pub use log::{Log, LogError};
pub use place::{PlaceError, Placement, place_on_table, start_inside};
pub use report::{RunFacts, html, picture_of_run};
pub use simulated::{Link, SimError, SimResult, SimRun, run_simulated};
pub use run::{Clock, Ended, RealClock, Session, VirtualClock};

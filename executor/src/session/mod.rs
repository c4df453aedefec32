//! A session: supervisor, dialect, port, operator and log, run together against a clock.

mod coverage;
#[cfg(test)]
mod hostile_test;
mod log;
mod place;
mod report;
mod run;
mod simulated;

pub use coverage::{Coverage, coverage};
pub use log::{Log, LogError};
pub use place::{PlaceError, Placement, place_on_table, start_inside};
pub use report::{RunFacts, html, picture_of_run};
pub use run::{Clock, Ended, RealClock, Session, VirtualClock};
pub use simulated::{Link, SimError, SimResult, SimRun, run_simulated};

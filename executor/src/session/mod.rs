//! A session with its engine, port, operator, log and clock. Also the replay of the log, and the report.

pub mod characters;
mod clock;
mod coverage;
mod engine;
mod event_log;
pub mod log;
mod log_page;
pub mod micros;
pub mod outcome;
mod place;
pub mod port;
pub mod replay;
mod report;
mod run;
mod sample;
pub mod serial;
mod setup;

pub use clock::{Clock, RealClock, VirtualClock};
pub use coverage::{Coverage, coverage};
pub use engine::Engine;
pub use event_log::{Certificate, EventLog, EventLogError, LoggedEvent, NoEventLog};
pub use log_page::{page_of_log, picture_of_log};
pub use place::{PlaceError, PlacedZ, TablePlacement, place_on_table, start_inside};
pub use report::{RunFacts, html, picture_of_run, section_of_run};
pub use run::{Going, Reopen, Session, free_way_mm, nearest_wall};
pub use sample::{Sample, SampleKind};
pub use setup::SessionSetup;

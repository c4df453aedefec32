//! Reproductions of two papers, and comparisons with Keepout.
//!
//! The papers are Koren & Lo 1992 on feed drives, and Franco & Horikawa 2007 on machining with a joystick.
//!
//! `cargo run --release -p keepout-studies -- --help` lists the commands.
//!
//! ```
//! let scenarios = keepout_studies::franco_horikawa::scenario::Scenarios::built_in().unwrap();
//! assert!(scenarios.delays.query_bytes > 0.0);
//! ```

pub mod command;
pub mod franco_horikawa;
pub mod koren_lo;
pub mod tuned;

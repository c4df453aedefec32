//! The properties that are fuzzed. Each takes any bytes and must neither panic nor believe something false.
//!
//! `cargo +nightly fuzz run dxf_import --features libfuzzer` runs one under libFuzzer; `cargo test -p keepout-fuzz`
//! runs all over the corpus, our drawings and random mutations of them.

use keepout_executor::link::dialect::{Dialect, Grbl, Setting};
use keepout_executor::supervisor::{Command, Reply};
use keepout_kernel::{Point, Vector};
use keepout_planner::plan_file;

mod export;
mod import;
pub mod sketch;
mod witness;

pub use import::dxf_import;
pub use sketch::drawing;

/// Any bytes as a plan file: a typed error, or a plan, which certification believes or refuses.
pub fn plan_file(bytes: &[u8]) {
    if let Ok(plan) = plan_file::decode(bytes) {
        let edges: usize = plan.profile.loops.iter().map(|each| each.edges.len()).sum();
        if edges <= import::CURVES_MAX {
            let _ = plan.certify();
        }
    }
}

/// Any bytes from a controller, at any stage of a session: replies, bounded output, and a line that is understood after a
/// reset whatever came before.
///
/// # Panics
/// When a clean report is not read after a reset, or the dialect talks without end.
pub fn grbl_decode(bytes: &[u8]) {
    let offset = Vector { dx: -12_345_600, dy: 700 };
    let mut dialect = Grbl::new(Setting { offset, steps_per_mm: 400.0, arc_tolerance_mm: 0.0005 });
    let stages = [Command::Query, Command::Prepare, Command::Home, Command::Arm, Command::Abort];
    let (&first, rest) = bytes.split_first().unwrap_or((&0, &[]));
    let mut out = Vec::new();
    let _ = dialect.encode(&stages[usize::from(first) % stages.len()], &mut out);
    let before = out.len();
    for &byte in rest {
        let _ = dialect.decode(byte, &mut out);
    }
    assert!(out.len() <= before + 64 * (rest.len() + 1), "{} bytes to send for {}", out.len(), rest.len());
    dialect.reset();
    let report = b"<Idle|MPos:-123.456,0.007,0.000>\r\n";
    let replies: Vec<Reply> = report.iter().filter_map(|&byte| dialect.decode(byte, &mut out)).collect();
    let [Reply::Report(report)] = replies[..] else { panic!("{replies:?}") };
    assert_eq!(report.position, Some(Point::ORIGIN));
}

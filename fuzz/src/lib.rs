//! The properties that are fuzzed. Each takes any bytes and must neither panic nor believe something false.
//!
//! `cargo +nightly fuzz run dxf_import --features libfuzzer` runs one under libFuzzer; `cargo test -p keepout-fuzz`
//! runs all over the corpus, our drawings and random mutations of them.

use keepout_executor::link::dialect::{Dialect, Grbl, Setting};
use keepout_executor::supervisor::{Command, Reply};
use keepout_kernel::{Point, Vector};
use keepout_planner::machine::MachineProfile;
use keepout_planner::order::Order;
use keepout_planner::plan_file;

/// Drawings with more curves than this are imported and not planned: the fuzzer is after faults, not after work.
const CURVES_MAX: usize = 400;

/// Any bytes as a drawing: a typed error, or a plan that is certified and survives its file.
///
/// # Panics
/// When a plan that was certified is not believed when read back.
pub fn dxf_import(bytes: &[u8]) {
    let order = Order::default();
    let Ok((drawing, chained)) = order.contours(bytes) else { return };
    let edges: usize = chained.profile.loops.iter().map(|each| each.edges.len()).sum();
    if drawing.curves.len().max(edges) > CURVES_MAX {
        return;
    }
    let made = order.plan("fuzz", bytes, &MachineProfile::simulated(), &mut |_| {});
    let Ok(certified) = made else { return };
    let stored = plan_file::encode(&certified.plan).expect("a plan in memory can be written");
    let again = plan_file::decode(&stored).expect("what was written can be read");
    assert_eq!(again, certified.plan, "the plan changed in its file");
    again.certify().expect("what was certified is certified again");
}

/// Any bytes as a plan file: a typed error, or a plan, which certification believes or refuses.
pub fn plan_file(bytes: &[u8]) {
    if let Ok(plan) = plan_file::decode(bytes) {
        let edges: usize = plan.profile.loops.iter().map(|each| each.edges.len()).sum();
        if edges <= CURVES_MAX {
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

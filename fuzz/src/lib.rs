//! The properties that are fuzzed. Each takes any bytes and must neither panic nor believe something false.
//!
//! `cargo +nightly fuzz run dxf_import --features libfuzzer` runs one under libFuzzer; `cargo test -p keepout-fuzz`
//! runs all over the corpus, our drawings and random mutations of them.

use keepout_executor::link::dialect::Grbl;
use keepout_kernel::Vector;
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

/// Any bytes from a controller: replies, in pieces of any size the same as at once.
///
/// # Panics
/// When the pieces are read differently from the whole.
pub fn grbl_decode(bytes: &[u8]) {
    let offset = Vector { dx: -12_345_600, dy: 700 };
    let (mut whole, mut pieces) = (Grbl::new(offset), Grbl::new(offset));
    let at_once = whole.decode(bytes);
    let piecewise: Vec<_> = bytes.chunks(3).flat_map(|chunk| pieces.decode(chunk)).collect();
    // NaN settings are not equal to themselves: compared as they print.
    assert_eq!(format!("{at_once:?}"), format!("{piecewise:?}"));
}

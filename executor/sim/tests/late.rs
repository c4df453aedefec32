//! The true positions of a simulated machine whose computer is late.
#![expect(clippy::unwrap_used, reason = "a test")]

use std::time::Duration;

use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::DialectName;
use keepout_executor::session::Sample;
use keepout_guard::Time;
use keepout_planner::Mm3;
use keepout_planner::machine::MachineProfile;
use keepout_sim::{SimMachine, SimSettings};

/// A plunge, two small circles, a plunge and another circle, each with its time of arrival, ms.
const LINES: [(u64, &str); 8] = [
    (0, "$X\n"),
    (50, "G21G90G94G1X-20Y-20Z-2F6000\n"),
    (100, "G2X-16.04Y-20R1.98\n"),
    (150, "G2X-20Y-20R1.98\n"),
    (200, "G1Z-8\n"),
    (250, "G2X-16.04Y-20R1.98\n"),
    (300, "G2X-20Y-20R1.98\n"),
    (350, "G2X-16.04Y-20R1.98\n"),
];

/// The true positions until the machine's third second. `step` gives the time between two calls, µs.
fn positions(mut step: impl FnMut() -> u64) -> Vec<Sample> {
    let machine = MachineProfile::simulated_three_axes();
    let settings = SimSettings { homed: true, ..SimSettings::of(machine, Mm3::ZERO) };
    let (line, servo) = ((115_200, Duration::from_millis(1)), DriveProfile::simulated().unwrap());
    let mut machine = SimMachine::wandering(settings, &DialectName::Grbl, line, 1, Some(&servo));
    let (mut samples, mut answers, mut us) = (Vec::new(), Vec::new(), 0);
    let mut lines = LINES.iter().peekable();
    while us < 3_000_000 {
        let now = Time::from_micros(us);
        machine.advance(now);
        if let Some((_, text)) = lines.next_if(|(ms, _)| ms * 1000 == us) {
            machine.host_writes(text.as_bytes(), now);
        }
        machine.host_reads(&mut answers, now);
        machine.take_samples(&mut samples);
        us = (us + step()).min(lines.peek().map_or(u64::MAX, |(ms, _)| ms * 1000));
    }
    assert_eq!(String::from_utf8(answers).unwrap().matches("ok").count(), LINES.len());
    samples
}

/// The tool takes the same path at the same time, whenever the machine's program runs.
#[test]
fn positions_do_not_depend_on_when_the_program_runs() {
    let usual = positions(|| 1000);
    let last = usual.last().unwrap();
    assert!((last.position_mm.z + 20.5).abs() < 0.01, "{last:?}");
    let mut random = fastrand::Rng::with_seed(1);
    for case in 0..20 {
        let late =
            positions(
                || if random.u8(0..60) == 0 { random.u64(2000..40_000) } else { random.u64(300..1300) },
            );
        let apart = |(a, b): (&Sample, &Sample)| a.position_mm.distance(b.position_mm);
        let worst = usual.iter().zip(&late).map(apart).fold(0.0, f64::max);
        // Their commands differ by rounding, and that can move either axis by a step.
        assert!(usual.len() == late.len() && worst < 0.0036, "case {case}: {worst} mm");
    }
}

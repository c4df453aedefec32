//! Tests of the simulated GRBL against observations of the real one.

use super::*;

fn idle() -> GrblSim {
    let settings = SimSettings {
        work_offset_mm: Mm3::new(-30.0, -20.0, 0.0),
        ..SimSettings::of(MachineProfile::simulated(), Mm3::new(-100.0, -100.0, 0.0))
    };
    let mut sim = GrblSim::new(settings);
    sim.transmit(&mut Vec::new());
    sim
}

fn transmitted(sim: &mut GrblSim) -> String {
    let mut bytes = Vec::new();
    sim.transmit(&mut bytes);
    String::from_utf8(bytes).unwrap()
}

fn samples(sim: &mut GrblSim) -> Vec<Sample> {
    let mut samples = Vec::new();
    sim.take_samples(&mut samples);
    samples
}

fn say(sim: &mut GrblSim, bytes: &[u8], ms: u64) -> String {
    bytes.iter().for_each(|&byte| sim.receive(byte));
    let until = sim.now.after(Duration::from_millis(ms));
    sim.advance(until);
    transmitted(sim)
}

#[test]
fn jog_is_acknowledged_when_planned_and_ends_idle() {
    let mut sim = idle();
    assert_eq!(say(&mut sim, b"$J=G53G90G21X-90Y-100F6000\n", 1), "ok\r\n");
    assert!(say(&mut sim, b"?", 20).starts_with("<Jog|MPos:-100.000,-100.000"));
    say(&mut sim, b"", 2000);
    assert!(say(&mut sim, b"?", 1).contains("<Idle|MPos:-90.000,-100.000"));
}

#[test]
fn rejections_of_the_real_firmware_are_reproduced() {
    let mut sim = idle();
    assert_eq!(say(&mut sim, b"$J=G90X-90\n", 1), "error:22\r\n");
    assert_eq!(say(&mut sim, b"$J=G1X-90F100\n", 1), "error:16\r\n");
    assert_eq!(say(&mut sim, b"$J=G90X35F100\n", 1), "error:15\r\n");
    assert_eq!(say(&mut sim, &[b'X'; 95], 1), "");
    assert_eq!(say(&mut sim, b"\n", 1), "error:11\r\n");
    assert_eq!(say(&mut sim, b"G2X-60Y-80I3J4F100\n", 1), "error:33\r\n");
    assert!(say(&mut sim, b"G1X35Y0F100\n", 1).starts_with("ALARM:2"));
    assert_eq!(say(&mut sim, b"?", 5), "", "the controller answers no query until reset");
    assert!(say(&mut sim, b"\x18", 5).contains("Grbl 1.1h"));
}

#[test]
fn line_that_waits_through_a_cancel_runs_from_where_the_tool_stopped() {
    let mut sim = idle();
    for k in 0..16 {
        let line = format!("$J=G53G90G21X{}Y-100F6000\n", -99 + k);
        line.bytes().for_each(|byte| sim.receive(byte));
        let now = sim.now.after(Duration::from_millis(1));
        sim.advance(now);
    }
    let acknowledged = transmitted(&mut sim).matches("ok").count();
    assert_eq!(acknowledged, 15, "the sixteenth waits for planner space");
    sim.receive(0x85);
    say(&mut sim, b"", 3000);
    let x = sim.motion.position().x;
    assert!((x - -84.0).abs() < 1e-6, "the tool moves to the waiting line's target: {x}");
}

#[test]
fn reset_while_moving_loses_the_position() {
    let mut sim = idle();
    say(&mut sim, b"$J=G53G90G21X-10Y-100F6000\n", 300);
    let text = say(&mut sim, b"\x18", 5);
    assert!(text.contains("ALARM:3") && text.contains("Grbl 1.1h"), "{text}");
    assert_eq!(say(&mut sim, b"$J=G90X-50F100\n", 5), "error:8\r\n");
}

#[test]
fn arcs_are_chords_inside_the_circle_in_work_coordinates() {
    let mut sim = idle();
    assert_eq!(say(&mut sim, b"G21G90G17G94G55\nG54\n", 1), "ok\r\nok\r\n");
    assert!(say(&mut sim, b"?", 1).contains("WCO:-30.000,-20.000"));
    say(&mut sim, b"G3X-70Y-60I0J10F3000\n", 3000);
    let corners = samples(&mut sim);
    let places = corners.windows(2).flat_map(|pair| {
        let (a, b) = (pair[0].position_mm, pair[1].position_mm);
        (0..=8).map(f64::from).map(move |k| (a.x + (b.x - a.x) * k / 8.0, a.y + (b.y - a.y) * k / 8.0))
    });
    let off: Vec<f64> = places.map(|(x, y)| 10.0 - (x + 100.0).hypot(y + 90.0)).collect();
    let worst = off.iter().copied().fold(0.0_f64, f64::max);
    assert!(off.iter().all(|&off| off > -2e-5) && worst > 0.001 && worst < 4.0 * 0.002, "{worst}");
    assert!((sim.motion.position().y - -80.0).abs() < 1e-5);
}

#[test]
fn arc_of_almost_no_sweep_can_become_a_full_circle() {
    let mut sim = idle();
    say(&mut sim, b"G21G90G17G94\n", 1);
    // 20 nm along a circle of 3 mm: below the resolution of single precision at −100 mm.
    say(&mut sim, b"G3X-69.99999998Y-80I0J3F3000\n", 3000);
    let farthest = samples(&mut sim).iter().map(|s| s.position_mm.y + 100.0).fold(0.0_f64, f64::max);
    assert!(farthest > 5.9, "the guard rejects such arcs for this reason: {farthest}");
}

#[test]
fn first_line_of_a_session_spoils_a_partial_line() {
    for half in ["G91G1X5F600", "G0X-10", "$J=G91X5F600", "$10=", "$H"] {
        let mut sim = idle();
        let answer = say(&mut sim, format!("{half}$\n").as_bytes(), 1000);
        assert!(answer.contains("error:") && !answer.contains("ok"), "{half}: {answer}");
        assert_eq!(sim.motion.position(), Mm3::new(-100.0, -100.0, 0.0), "{half}");
    }
}

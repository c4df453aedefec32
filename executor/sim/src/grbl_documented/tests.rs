//! The second model, statement by statement of the documentation.

use std::time::Duration;

use keepout_guard::Time;
use keepout_planner::Mm3;
use keepout_planner::machine::MachineProfile;

use super::DocumentedGrbl;
use crate::{Disturbance, Quirks, SimSettings, SimulatedController};

/// A controller and its answers.
struct Desk {
    controller: DocumentedGrbl,
    now: Time,
}

impl Desk {
    fn new(change: impl FnOnce(&mut SimSettings)) -> Self {
        let mut settings =
            SimSettings::of(MachineProfile::simulated_three_axes(), Mm3::new(-200.0, -150.0, -20.0));
        change(&mut settings);
        let mut desk = Self { controller: DocumentedGrbl::new(settings), now: Time::ZERO };
        desk.after(10);
        desk
    }

    fn plain() -> Self {
        Self::new(|_| {})
    }

    /// Lets milliseconds pass, and returns what the controller says.
    fn after(&mut self, ms: u64) -> String {
        self.now = self.now.after(Duration::from_millis(ms));
        self.controller.advance(self.now);
        let mut bytes = Vec::new();
        self.controller.transmit(&mut bytes);
        String::from_utf8(bytes).unwrap()
    }

    fn send(&mut self, text: &str) {
        text.bytes().for_each(|byte| self.controller.receive(byte));
    }

    /// Sends a line, and returns what the controller says within 50 ms.
    fn ask(&mut self, line: &str) -> String {
        self.send(line);
        self.send("\n");
        self.after(50)
    }

    fn report(&mut self) -> String {
        self.controller.receive(b'?');
        self.after(5)
    }
}

#[test]
fn receive_buffer_drops_what_does_not_fit() {
    let mut desk = Desk::plain();
    desk.ask("$10=3");
    desk.send("!");
    desk.send(&"G4P1\n".repeat(30));
    assert!(desk.report().contains("|Bf:15,0|"));
    desk.send("~");
    // 128 bytes hold 25 lines and the head of the next.
    assert_eq!(desk.after(40_000).matches("ok").count(), 25);
    assert_eq!(desk.ask("").trim(), "error:2");
}

#[test]
fn settings_and_offsets_survive_a_reset_and_modes_do_not() {
    let mut desk = Desk::plain();
    for line in ["$100=250", "G10L2P1X-5", "$N0=G80", "G20", "G91", "G92X1"] {
        assert_eq!(desk.ask(line).trim(), "ok", "{line}");
    }
    desk.controller.receive(0x18);
    assert!(desk.after(10).contains(">G80:ok"));
    assert!(desk.ask("$$").contains("$100=250.000"));
    let offsets = desk.ask("$#");
    assert!(offsets.contains("[G54:-5.000,") && offsets.contains("[G92:0.000,"), "{offsets}");
    assert!(desk.ask("$G").contains("G21 G90"));
}

#[test]
fn spindle_waits_for_the_motions_before_it() {
    let mut desk = Desk::plain();
    assert!(desk.ask("G1X-150F600").contains("ok"));
    assert_eq!(desk.ask("M3S1000"), "");
    assert!(desk.report().contains("<Run|"));
    assert!(desk.after(10_000).contains("ok"));
    assert!(desk.report().contains("|FS:0,1000"));
}

#[test]
fn programmed_motions_start_when_no_line_waits() {
    let mut desk = Desk::plain();
    desk.ask("$10=3");
    desk.send("G1X-150F600\nG1X-151\nG1X-152\n?");
    // The controller states that it is idle, although a motion is planned.
    let report = desk.after(4);
    assert!(report.contains("<Idle|") && report.contains("|Bf:13,"), "{report}");
    assert!(desk.report().contains("<Run|"));
}

/// Lets a second jog arrive this long after the first has begun. Returns whether it ran as a programmed motion.
fn second_jog_runs(after: Duration) -> bool {
    let mut desk = Desk::plain();
    desk.send("$J=G91X1F600\n");
    desk.now = desk.now.after(after);
    desk.after(0);
    desk.send("$J=G91X1F600\n");
    let states: String = (0..40).map(|_| desk.report()).collect();
    desk.after(1000);
    assert!(desk.report().contains("<Idle|MPos:-198.000,"));
    states.contains("<Run|")
}

#[test]
fn jog_that_is_planned_as_the_motion_ends_runs_as_a_programmed_motion() {
    let times = (1000..1300).map(|tenths| Duration::from_micros(100 * tenths));
    let runs: Vec<bool> = times.map(second_jog_runs).collect();
    assert!(runs.contains(&true) && runs.contains(&false));
    // The line must be parsed as the last step is driven.
    assert!(runs.iter().filter(|&&runs| runs).count() < 30);
}

#[test]
fn power_failure_locks_until_homing_and_loses_the_count() {
    let mut desk = Desk::plain();
    desk.controller.disturb(Disturbance::BrownOut);
    assert!(desk.after(10).contains("[MSG:'$H'|'$X' to unlock]"));
    assert!(desk.report().contains("<Alarm|MPos:0.000,0.000,0.000|"));
    assert_eq!(desk.ask("G1X1F100").trim(), "error:9");
    assert_eq!(desk.ask("$J=G91X1F100").trim(), "error:8");
    assert_eq!(desk.ask("$H"), "");
    assert!(desk.after(2000).contains("ok"));
    assert!(desk.report().contains("<Idle|MPos:-1.000,-1.000,-1.000|"));
}

#[test]
fn homing_in_place_counts_from_the_true_position() {
    let settings = SimSettings::of(MachineProfile::simulated(), Mm3::new(-200.0, -150.0, 0.0));
    let controller = DocumentedGrbl::new(SimSettings { homed: false, ..settings }).homing_in_place();
    let mut desk = Desk { controller, now: Time::ZERO };
    desk.ask("$H");
    desk.after(2000);
    assert!(desk.report().contains("<Idle|MPos:-200.000,-150.000,0.000|"));
}

#[test]
fn second_cancel_in_the_idle_delay_stops_all_lines_until_cycle_start() {
    let delay = Duration::from_millis(25);
    let mut desk = Desk::new(|settings| settings.quirks = Quirks { idle_delay: delay, ..Quirks::default() });
    desk.ask("$J=G91X20F6000");
    desk.controller.receive(0x85);
    while desk.controller.motion.is_running() {
        desk.after(1);
    }
    desk.controller.receive(0x85);
    desk.after(100);
    assert!(desk.report().contains("<Idle|"));
    assert_eq!(desk.ask("$J=G91X1F600"), "");
    desk.controller.receive(b'~');
    assert!(desk.after(50).contains("ok"));
}

#[test]
fn motion_beyond_the_travel_raises_an_alarm_that_only_a_reset_ends() {
    let mut desk = Desk::plain();
    assert!(desk.ask("G1X500F100").contains("ALARM:2"));
    assert_eq!(desk.report(), "");
    desk.controller.receive(0x18);
    assert!(desk.after(5).contains("Grbl 1.1h"));
    assert!(desk.report().contains("<Alarm|MPos:-200.000,"));
    assert!(desk.ask("$X").contains("[MSG:Caution: Unlocked]"));
    assert_eq!(desk.ask("$J=G53X10F100").trim(), "error:15");
}

#[test]
fn reports_carry_offset_and_overrides_now_and_then() {
    let mut desk = Desk::plain();
    let fields: Vec<String> = (0..12).map(|_| desk.report()).collect();
    let numbers =
        |field: &str| -> Vec<usize> { (0..12).filter(|&number| fields[number].contains(field)).collect() };
    assert_eq!(numbers("|WCO:"), [0, 10]);
    assert_eq!(numbers("|Ov:"), [1, 11]);
    desk.ask("$10=0");
    assert!(desk.report().starts_with("<Idle|WPos:-162.750,-128.500,-7.500|"));
}

#[test]
fn lines_are_read_without_spaces_comments_and_case() {
    let mut desk = Desk::plain();
    assert_eq!(desk.ask("g0 x -160 (there) y-130 ; text").trim(), "ok");
    assert_eq!(desk.ask(&"G".repeat(90)).trim(), "error:11");
    assert_eq!(desk.ask("").trim(), "ok");
    for (line, error) in [
        ("1", 1),
        ("GX", 2),
        ("$Q", 2),
        ("F-1", 4),
        ("$0=1", 6),
        ("G999", 20),
        ("G0G90G91", 21),
        ("G1X1", 22),
        ("G1G10L2P1X1F1", 24),
        ("G1X1X2", 25),
        ("G2F1", 26),
        ("G4", 28),
        ("G59.1", 29),
        ("G53G2X1R5F1", 30),
        ("G80X1", 31),
        ("G2Z1R1F1", 32),
        ("G2X-100R1F1", 34),
        ("G2X1F1", 35),
        ("G1X-160P1F1", 36),
        ("G43.1X1", 37),
        ("T300", 38),
        ("$JX", 16),
        ("$J=G91G1X1F1", 16),
        ("$J=X1", 22),
        ("$J=F1", 26),
    ] {
        assert_eq!(desk.ask(line).trim(), format!("error:{error}"), "{line}");
    }
}

/// The tool never moves faster than the axes permit, nor speeds up faster: from positions 1 ms apart.
#[test]
fn motions_keep_the_limits_of_each_axis() {
    let mut desk = Desk::plain();
    let mut random = fastrand::Rng::with_seed(7);
    for _ in 0..40 {
        let [x, y] = [random.f64() * 10.0, random.f64() * 10.0];
        desk.send(&format!("G1X{:.3}Y{:.3}F{}\n", -165.0 + x, -133.0 + y, random.u32(300..12_000)));
        let mut places = Vec::new();
        for _ in 0..random.usize(1..120) {
            desk.after(1);
            places.push(desk.controller.true_mm());
        }
        for three in places.windows(3) {
            let speed = |a: Mm3, b: Mm3| [(b.x - a.x) * 1e3, (b.y - a.y) * 1e3];
            let (before, after) = (speed(three[0], three[1]), speed(three[1], three[2]));
            for axis in 0..2 {
                // A step of 2.5 µm in 1 ms is 2.5 mm/s. A corner changes the speed at once, as `$11` permits.
                assert!(before[axis].abs() < 200.0 + 6.0, "{before:?}");
                assert!((after[axis] - before[axis]).abs() < 1.0 + 6.0 + 8.0, "{before:?} {after:?}");
            }
        }
    }
}

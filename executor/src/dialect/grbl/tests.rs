//! Tests of the GRBL dialect against lines of the firmware.

mod inspection;
mod lines;
mod settings;

use keepout_kernel::Vector;

use super::*;
use crate::supervisor::{Limits, Mode, Unfit};

fn dialect() -> Grbl {
    let offset = Vector { dx: -20_000_000, dy: 500 };
    Grbl::new(DialectConfig {
        offset,
        steps_per_mm: 400.0,
        arc_tolerance_mm: 0.0005,
        travel_mm: Some([400.0, 350.0]),
        z: None,
        spindle_rpm: Some(10_000),
    })
}

fn hear(grbl: &mut Grbl, text: &[u8]) -> (Vec<Reply>, Vec<u8>) {
    let mut out = Vec::new();
    (text.iter().filter_map(|&byte| grbl.decode(byte, &mut out)).collect(), out)
}

fn ready() -> Grbl {
    let mut grbl = dialect();
    grbl.stage = Stage::Ready;
    grbl
}

// Evidence for SR-18, SR-19.
#[test]
fn report_is_read_in_drawing_coordinates() {
    let mut grbl = dialect();
    grbl.stage = Stage::Arming(1);
    hear(&mut grbl, b"[G54:1.000,1.500,0.000]\r\n[G92:0.000,0.500,0.000]\r\nok\r\n");
    let idle = b"<Idle|MPos:0.000,0.000,0.000|Bf:15,128|WCO:1.000,2.000,0.000>\r\n";
    hear(&mut grbl, idle);
    hear(&mut grbl, idle);
    let (replies, _) = hear(&mut grbl, b"<Jog|MPos:-150.000,20.005,0.000|Bf:14,100|FS:600,0>\r\nok\r\n");
    let position = Some(Point::from_units(5_000_000, 2_000_000).unwrap().in_plane());
    let report = Report { mode: Mode::Moving, position, queued: Some(1), waiting: Some(true) };
    assert_eq!(replies, [Reply::Report(report), Reply::Accepted]);
    assert_eq!(grbl.work_offset, Some(Point::from_units(100_000, 200_000).unwrap().in_plane()));
    let (replies, _) = hear(&mut grbl, b"<Idle|MPos:0.000,0.000,0.000|WCO:1.001,2.000,0.000>\r\n");
    assert_eq!(replies, [Reply::Displaced]);
}

// Evidence for SR-19.
#[test]
fn lines_of_the_real_firmware_are_decoded() {
    let mut grbl = ready();
    let text = "error:15\r\nALARM:2\r\n[MSG:Reset to continue]\r\nGrbl 1.1h ['$' for help]\r\n\
                <Hold:1|MPos:0,0,0>\r\n";
    let (replies, _) = hear(&mut grbl, text.as_bytes());
    assert!(
        matches!(
            replies[..],
            [
                Reply::Refused { code: 15, transient: false, .. },
                Reply::Alarm { code: 2, .. },
                Reply::Message(_),
                Reply::Restarted,
                Reply::Report(Report { mode: Mode::Slowing, position: None, .. }),
            ]
        ),
        "{replies:?}"
    );
}

// Evidence for SR-19.
#[test]
fn settings_are_read_checked_and_set() {
    let mut grbl = dialect();
    let mut out = Vec::new();
    grbl.encode(&Command::Prepare, &mut out).unwrap();
    assert_eq!(out, b"$\n");
    assert_eq!(hear(&mut grbl, b"ok\r\n"), (vec![], b"$I\n".to_vec()));
    let identity = b"[VER:1.1h.20190830:]\r\n[OPT:V,15,128]\r\nok\r\n";
    assert_eq!(hear(&mut grbl, identity), (vec![], b"$$\n".to_vec()));
    let listed = b"$10=1\r\n$12=0.002\r\n$13=0\r\n$22=1\r\n$74=name\r\n$100=400.000\r\n$101=400.000 (y)\r\n\
                   $110=6000\r\n$111=3000\r\n$120=100\r\n$121=90\r\n";
    assert_eq!(hear(&mut grbl, listed), (vec![], vec![]));
    assert_eq!(hear(&mut grbl, b"ok\r\n"), (vec![], b"$N\n".to_vec()));
    // GRBL loses bytes that arrive while it stores a setting.
    let (replies, sent) = hear(&mut grbl, b"$N0=G54\r\n$N1=\r\nok\r\n");
    assert_eq!((replies, sent), (vec![], b"$10=3\n".to_vec()));
    assert_eq!(hear(&mut grbl, b"ok\r\n"), (vec![], b"$12=0.00050\n".to_vec()));
    // What was stored is read back.
    assert_eq!(hear(&mut grbl, b"ok\r\n"), (vec![], b"$$\n".to_vec()));
    let listed = b"$10=3\r\n$12=0.001\r\n$13=0\r\n$22=1\r\n$74=name\r\n$100=400.000\r\n$101=400.000 (y)\r\n\
                   $110=6000\r\n$111=3000\r\n$120=100\r\n$121=90\r\nok\r\n";
    assert_eq!(hear(&mut grbl, listed), (vec![], b"$N\n".to_vec()));
    let limits = Limits { speed_mm_s: 50.0, acceleration_mm_s2: 90.0, quicker_mm_s2: 100.0 };
    assert_eq!(hear(&mut grbl, b"$N0=G54\r\n$N1=\r\nok\r\n"), (vec![Reply::Prepared(limits)], vec![]));
    // The margin holds for four times the tolerance, so the tolerance is rounded down.
    for (tolerance, written) in
        [(0.000_106, "0.00010"), (0.000_1, "0.00010"), (0.000_29, "0.00029"), (0.5, "0.50000")]
    {
        let mut grbl = dialect();
        grbl.setting.arc_tolerance_mm = tolerance;
        grbl.encode(&Command::Prepare, &mut Vec::new()).unwrap();
        hear(&mut grbl, b"ok\r\n[OPT:V,15,128]\r\nok\r\n");
        hear(
            &mut grbl,
            b"$10=3\r\n$13=0\r\n$22=1\r\n$100=400.000\r\n$101=400.000\r\n$110=6000\r\n$111=3000\r\nok\r\n",
        );
        let (_, sent) = hear(&mut grbl, b"$N0=G54\r\n$N1=G80\r\nok\r\n");
        assert_eq!(String::from_utf8_lossy(&sent), format!("$12={written}\n"));
    }
    let mut unfit = dialect();
    unfit.stage = Stage::Reading(Settings::default());
    assert!(matches!(hear(&mut unfit, b"ok\r\n").0[..], [Reply::Unfit(_)]));
}

// Evidence for SR-19.
#[test]
fn settings_that_are_not_finite_numbers_are_refused() {
    for name in ["$13", "$22", "$100", "$101", "$481"] {
        for value in ["nan", "-nan", "inf", "-inf", "1e999", "name", ""] {
            let mut grbl = dialect();
            grbl.stage = Stage::Reading(Settings::default());
            let fit = b"$10=3\r\n$12=0.001\r\n$13=0\r\n$22=1\r\n$100=400\r\n$101=400\r\n$481=0\r\n";
            hear(&mut grbl, fit);
            assert_eq!(hear(&mut grbl, format!("{name}={value}\r\n").as_bytes()).0, []);
            let (replies, _) = hear(&mut grbl, b"ok\r\n");
            let refused = matches!(replies[..], [Reply::Unfit(unfit)] if unfit.name == name);
            assert!(refused, "{name}={value}: {replies:?}");
        }
    }
}

#[test]
fn decode_is_total() {
    let mut random = fastrand::Rng::with_seed(7);
    let mut grbl = dialect();
    for round in 0..20_000 {
        if round % 100 == 0 {
            let commands = [Command::Prepare, Command::Arm, Command::Home, Command::Abort];
            let _ = grbl.encode(&commands[random.usize(0..4)], &mut Vec::new());
        }
        let alphabet = b"<>|:,.-+0123456789MPosBfWCOIdleJogokerror\r\n\n$=[]\xff\x00";
        let bytes: Vec<u8> =
            (0..random.usize(0..40)).map(|_| alphabet[random.usize(0..alphabet.len())]).collect();
        hear(&mut grbl, &bytes);
    }
}

// Evidence for SR-17.
/// Found by the fuzzer's round trips: the contour was written as if the work offset were zero.
#[test]
fn no_contour_is_written_before_the_work_offset_is_known() {
    let (mut grbl, mut out) = (ready(), Vec::new());
    let motion = crate::dialect::testing::contour_to(100_000, 200_000, 600);
    assert_eq!(grbl.encode(&motion, &mut out), Err(EncodeError::WorkOffsetUnknown));
    assert!(out.is_empty());
    hear(&mut grbl, b"<Idle|MPos:0.000,0.000,0.000|Bf:15,128|WCO:1.000,2.000,0.000>\r\n");
    grbl.encode(&motion, &mut out).unwrap();
    assert_eq!(out, b"G1G21G54G90G94X-200Y0.005F600\n");
}

// Evidence for SR-18.
/// Found by the fuzzer: bytes between two reports were lost, and the dialect combined the state of one report
/// with the position of the other.
#[test]
fn joined_reports_are_rejected() {
    let mut grbl = ready();
    for glued in [
        "<Idle|MPos:0.000,0.000,0.000|Bf:15,1<Jog|MPos:5.000,0.000,0.000|Bf:14,128>\r\n",
        "<Idle|MPos:0.000,0.000,0.000|FS:60|MPos:5.000,0.000,0.000|Bf:14,128>\r\n",
        "<Idle|MPos:0.000,0.000,0.000|Bf:15,128|FS:60|Bf:14,128>\r\n",
        "<Idle:-20.000,-20.277,0.000|Bf:15,128|FS:0,0>\r\n",
        "<Idle|MPos:0.000,0.000,0.000|FS:0,0|Bf:15,128|FS:0,0>\r\n",
        "<Idle|MPos:0.000,0.000,0.000|WCO:0.000,0.000,0.000|FS:0|WCO:0.000,0.000,0.000>\r\n",
    ] {
        assert!(matches!(hear(&mut grbl, glued.as_bytes()).0[..], [Reply::Garbled(_)]), "{glued}");
    }
    assert_eq!(grbl.work_offset, None, "no field of them is used");
}

// Evidence for SR-18, SR-19.
#[test]
fn position_is_used_only_with_the_confirmed_work_offset() {
    let mut grbl = dialect();
    grbl.stage = Stage::Arming(1);
    hear(&mut grbl, b"[G54:1.000,1.500,0.000]\r\n[G92:0.000,0.500,0.000]\r\nok\r\n");
    let report = |grbl: &mut Grbl, offset: &str| {
        let line = format!("<Idle|MPos:0.000,0.000,0.000|Bf:15,128|WCO:{offset}>\r\n");
        match hear(grbl, line.as_bytes()).0[..] {
            [Reply::Report(report)] => report.position.is_some(),
            ref other => panic!("{other:?}"),
        }
    };
    report(&mut grbl, "1.000,2.000,0.000");
    assert!(report(&mut grbl, "1.000,2.000,0.000"), "G54 and G92 add up to it");
    let mut other = grbl.clone();
    (other.work_offset, other.stage) = (None, Stage::Ready);
    assert!(!report(&mut other, "7.000,2.000,0.000"), "another offset than the controller listed");
}

// Evidence for SR-19.
#[test]
fn controller_that_can_turn_work_coordinates_is_refused() {
    for (angle, fits) in [("", true), (":0.00", false), (":-30.00", false), (":", false)] {
        let mut grbl = dialect();
        grbl.stage = Stage::Arming(1);
        let list = format!("[G54:1.000,1.500,0.000{angle}]\r\n[G92:0.000,0.500,0.000]\r\nok\r\n");
        let (replies, _) = hear(&mut grbl, list.as_bytes());
        match replies[..] {
            [Reply::Armed] => assert!(fits, "{angle}"),
            [Reply::Unfit(Unfit { name: "G54 rotation", .. })] => assert!(!fits, "{angle}"),
            _ => panic!("{angle}: {replies:?}"),
        }
    }
}

// Evidence for SR-17.
#[test]
fn arming_sets_every_mode_that_changes_a_motion() {
    let (mut grbl, mut out) = (dialect(), Vec::new());
    grbl.encode(&Command::Arm, &mut out).unwrap();
    let line = String::from_utf8(out.split_off(1)).unwrap();
    assert_eq!(out, [0x90], "the feed override of another host goes back to 100 %");
    // mm, absolute, feed per minute, plane XY, no cutter radius, no tool length, no canned cycle.
    for mode in ["G21", "G90", "G94", "G17", "G40", "G49", "G80"] {
        assert!(line.contains(mode), "{line} leaves {mode} out");
    }
}

// Evidence for SR-19.
#[test]
fn feed_override_above_100_per_cent_ends_the_session() {
    let report = |stage: Stage, percent: &str| {
        let mut grbl = Grbl { stage, ..ready() };
        hear(&mut grbl, format!("<Run|MPos:1.000,2.000,3.000|FS:500,0|Ov:{percent},100,100>\r\n").as_bytes())
            .0
    };
    for (percent, fits) in [("10", true), ("100", true), ("101", false), ("200", false), ("65535", false)] {
        match report(Stage::Ready, percent)[..] {
            [Reply::Report(_)] => assert!(fits, "{percent}"),
            [Reply::Unfit(Unfit { name: "feed override", value, .. })] => {
                assert!(!fits && percent.parse() == Ok(value), "{percent}");
            }
            _ => panic!("{percent}"),
        }
        // An earlier host can have left it. Arming sets it back.
        assert!(matches!(report(Stage::Prepared, percent)[..], [Reply::Report(_)]), "{percent}");
        assert!(matches!(report(Stage::Arming(1), percent)[..], [Reply::Report(_)]), "{percent}");
    }
    for percent in ["", "-1", "x", "99999", "1.5"] {
        assert!(matches!(report(Stage::Ready, percent)[..], [Reply::Garbled(_)]), "{percent}");
    }
}

// Evidence for SR-19.
#[test]
fn settings_of_a_third_axis_are_checked() {
    let mut settings = Settings::default();
    for (number, value) in [(13, 0.0), (22, 1.0), (100, 400.0), (101, 400.0)] {
        settings.take(number, &value.to_string());
    }
    assert!(settings.check(400.0, None).is_ok());
    assert!(settings.check(400.0, Some(800.0)).is_err(), "the controller did not state $102");
    for (steps, fits) in [(800.0, true), (640.0, false), (f64::NAN, false)] {
        settings.take(102, &steps.to_string());
        assert_eq!(settings.check(400.0, Some(800.0)).is_ok(), fits, "{steps}");
    }
}

// Evidence for SR-19.
#[test]
fn arc_tolerance_holds_only_beyond_the_reported_digits() {
    let mut settings = Settings::default();
    for (reported, holds) in [(0.002, false), (0.0016, false), (0.0015, true), (0.001, true), (0.0005, false)]
    {
        settings.take(12, &reported.to_string());
        assert_eq!(settings.follows_arcs(0.002), holds, "{reported}");
    }
}

// Evidence for SR-19.
#[test]
fn every_word_of_a_startup_line_is_looked_at() {
    for (line, fits) in
        [("G80", true), ("G54G80", true), ("G20G80", false), ("G91 G80", false), ("G80G1X5", false)]
    {
        let mut lines = StartupBlocks::default();
        lines.take("N0", line);
        lines.take("N1", "");
        assert_eq!(lines.needed().is_ok(), fits, "{line}");
    }
}

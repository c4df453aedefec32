//! Lines to the controller and from it, one by one.

use keepout_guard::ContourMotion;
use keepout_kernel::{Arc, Curve, Height, Point, Segment, Turn, Vector};

use super::super::meaning::{alarm_text, error_text, mode};
use super::super::*;
use super::{dialect, hear, ready};
use crate::dialect::DialectZ;
use crate::dialect::testing::{contour_of, encoded, jog_to, place};
use crate::supervisor::Mode;

fn height(units: i64) -> Height {
    place(0, 0, units).height
}

/// A machine with three axes, with its work coordinates turned to those of the drawing by offsets.
fn three_axes() -> Grbl {
    let mut grbl = ready();
    let z = DialectZ { zero: height(-1_000_000), steps_per_mm: 400.0, travel_mm: None };
    grbl.setting = DialectConfig { z: Some(z), offset: Vector { dx: 0, dy: 0 }, ..grbl.setting };
    grbl.work_offset = Some(place(100_000, 200_000, -3_000_000));
    grbl
}

/// A motion of a contour from the origin, which rises by `rise` units.
fn contour(curve: Curve, rise: i64, feed_mm_min: u32) -> Command {
    contour_of(ContourMotion { curve, heights: [Height::ZERO, height(rise)], feed_mm_min })
}

fn line_to(x: i64, y: i64) -> Curve {
    Curve::Line(Segment { from: Point::ORIGIN, to: place(x, y, 0).point })
}

/// A quarter turn from the origin.
fn quarter(turn: Turn) -> Curve {
    let side = if turn == Turn::CounterClockwise { 1 } else { -1 };
    let (to, centre) = (place(1_234_567, side * 1_234_567, 0).point, place(0, side * 1_234_567, 0).point);
    Curve::Arc(Arc::new(Point::ORIGIN, to, centre, turn).unwrap())
}

#[test]
fn contours_state_direction_and_height() {
    let mut grbl = three_axes();
    for (curve, rise, line) in [
        (line_to(500_000, 0), 0, "G1G21G54G90G94X4Y-2Z20F600\n"),
        (line_to(500_000, 0), 50_000, "G1G21G54G90G94X4Y-2Z20.5F600\n"),
        (quarter(Turn::CounterClockwise), 0, "G3G17G21G54G90G94X11.34567Y10.34567R12.34567F600\n"),
        (quarter(Turn::Clockwise), 0, "G2G17G21G54G90G94X11.34567Y-14.34567R12.34567F600\n"),
        (quarter(Turn::Clockwise), -50_000, "G2G17G21G54G90G94X11.34567Y-14.34567Z19.5R12.34567F600\n"),
    ] {
        let command = contour(curve, rise, 600);
        assert_eq!(encoded(&mut grbl, &command), line);
        let Command::Move(certified) = &command else { unreachable!() };
        assert_eq!(grbl.motion_text(certified.motion()).unwrap(), line.as_bytes(), "as it stands in a log");
    }
    assert_eq!(encoded(&mut grbl, &jog_to(500_000, 0, 600)), "$J=G53G90G21X5Y0Z-10F600\n");
}

#[test]
fn lines_may_have_63_bytes() {
    let mut grbl = three_axes();
    for digits in 1..=9 {
        let command = contour(quarter(Turn::CounterClockwise), 12_345, 10_u32.pow(digits - 1));
        let bytes = 55 + usize::try_from(digits).unwrap();
        // What waits in the buffer before the line does not count.
        let mut out = vec![b'?'; 40];
        let expected = if bytes <= 63 { Ok(()) } else { Err(EncodeError::LineTooLong { bytes }) };
        grbl.work_offset = Some(place(100_000, -1_200_000, -3_000_000));
        assert_eq!(grbl.encode(&command, &mut out), expected, "{}", String::from_utf8_lossy(&out));
        assert_eq!(out.len(), 40 + if bytes <= 63 { bytes } else { 0 });
    }
}

#[test]
fn heights_are_turned_with_the_place() {
    let mut grbl = three_axes();
    grbl.stage = Stage::Prepared;
    let (replies, _) = hear(&mut grbl, b"<Idle|MPos:1.000,2.000,-7.000|Bf:15,128>\r\n");
    let [Reply::Report(report)] = replies[..] else { panic!("{replies:?}") };
    assert_eq!(report.position, Some(place(100_000, 200_000, 300_000)));
}

#[test]
fn spindle_is_switched_where_the_machine_has_a_speed() {
    let mut grbl = ready();
    assert_eq!(encoded(&mut grbl, &Command::Spindle { runs: true }), "M3S10000\n");
    assert_eq!(hear(&mut grbl, b"ok\r\nok\r\n").0, [Reply::SpindleSwitched, Reply::Accepted]);
    assert_eq!(encoded(&mut grbl, &Command::Spindle { runs: false }), "M5\n");
    let mut out = Vec::new();
    grbl.setting.spindle_rpm = None;
    assert_eq!(grbl.encode(&Command::Spindle { runs: true }, &mut out), Err(EncodeError::NoSpindle));
    assert!(out.is_empty());
}

#[test]
fn arming_ends_with_its_third_answer_and_grblhal_cancels_scaling() {
    let mut grbl = dialect();
    assert!(!encoded(&mut grbl, &Command::Arm).contains("G50"));
    assert_eq!(hear(&mut grbl, b"ok\r\nok\r\n").0, []);
    assert_eq!(hear(&mut grbl, b"ok\r\nok\r\n").0, [Reply::Armed, Reply::Accepted]);
    assert!(encoded(&mut Grbl::hal(grbl.setting), &Command::Arm).contains("G50"));
}

#[test]
fn greeting_counts_as_a_restart_once_a_line_was_sent() {
    let greeting = b"Grbl 1.1h ['$' for help]\r\n";
    let mut grbl = dialect();
    assert_eq!(hear(&mut grbl, greeting).0, [], "nothing was sent");
    grbl.stage = Stage::Aborting;
    assert_eq!(hear(&mut grbl, b"error:9\r\n").0, [], "an answer to what a reset discarded");
    assert_eq!(hear(&mut grbl, greeting).0, [], "the session has reset it");
    assert_eq!(grbl.stage, Stage::Silent);
    assert_eq!(hear(&mut grbl, b"error:9\r\n").0, []);
    grbl.stage = Stage::Ready;
    assert_eq!(hear(&mut grbl, b"GrblHAL 1.1f ['$' or '$HELP' for help]\r\n").0, [Reply::Restarted]);
}

#[test]
fn waking_ends_with_any_answer() {
    let mut grbl = dialect();
    for answer in [&b"error:3\r\n"[..], b"[HLP:$$ $# $G $I]\r\nok\r\n"] {
        grbl.encode(&Command::Prepare, &mut Vec::new()).unwrap();
        assert_eq!(hear(&mut grbl, answer), (vec![], b"$I\n".to_vec()));
    }
}

#[test]
fn lines_are_told_apart_by_both_ends() {
    let mut grbl = ready();
    for (line, is_message) in [
        (">x>", true),
        (">G54:ok", true),
        ("[MSG:Pgm End]", true),
        ("[HLP:$$ $# $G $I]", true),
        ("$N0=G80", true),
        ("[MSG:Pgm En", false),
        ("MSG:Pgm End]", false),
        ("$X=1", false),
        ("$100=abc", false),
        ("<Idle|MPos:0.000,0.000,0.000", false),
    ] {
        let (replies, _) = hear(&mut grbl, format!("{line}\r\n").as_bytes());
        let told = match replies[..] {
            [Reply::Message(_)] => true,
            [Reply::Garbled(_)] => false,
            _ => panic!("{line}: {replies:?}"),
        };
        assert_eq!(told, is_message, "{line}");
    }
    assert_eq!(hear(&mut grbl, b"$100=400\r\n").0, [], "a setting that nobody reads");
}

#[test]
fn reset_drops_what_was_under_way() {
    let mut grbl = ready();
    grbl.encode(&Command::Spindle { runs: true }, &mut Vec::new()).unwrap();
    hear(&mut grbl, b"err");
    grbl.reset();
    assert_eq!(hear(&mut grbl, b"ok\r\n").0, [], "nothing is unanswered");
    grbl.stage = Stage::Ready;
    assert_eq!(hear(&mut grbl, b"ok\r\n").0, [Reply::Accepted]);
}

#[test]
fn words_and_numbers_have_their_meaning() {
    for (state, expected) in [
        ("Idle", Some(Mode::Idle)),
        ("Jog", Some(Mode::Moving)),
        ("Run", Some(Mode::Moving)),
        ("Hold:1", Some(Mode::Slowing)),
        ("Hold:0", Some(Mode::Held)),
        ("Hold", Some(Mode::Held)),
        ("Home", Some(Mode::Homing)),
        ("Alarm", Some(Mode::Alarm)),
        ("Door:1", Some(Mode::Other)),
        ("Check", Some(Mode::Other)),
        ("Sleep", Some(Mode::Other)),
        ("Tool", Some(Mode::Other)),
        ("Idl", None),
        ("Hold:x", None),
    ] {
        assert_eq!(mode(state), expected, "{state}");
    }
    for (code, meaning) in [
        (2, "a damaged line"),
        (8, "not idle"),
        (9, "locked by an alarm"),
        (11, "a line too long"),
        (14, "a line too long"),
        (15, "beyond the machine's travel"),
        (22, "not valid G-code"),
        (34, "not valid G-code"),
        (7, ""),
    ] {
        assert_eq!(error_text(code), meaning, "error:{code}");
    }
    for (code, meaning) in [
        (1, "limit switch"),
        (2, "beyond the machine's travel"),
        (3, "reset while moving, position lost"),
        (6, "homing failed"),
        (9, "homing failed"),
        (5, ""),
    ] {
        assert_eq!(alarm_text(code), meaning, "ALARM:{code}");
    }
    for line in ["<Run|FS:600,9000>", "<Run|F:600>"] {
        assert_eq!(Status::parse(line, false).unwrap().feed_mm_min, Some(600.0), "{line}");
    }
}

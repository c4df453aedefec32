//! Motions on the controller's axes, and what follows from the answers.

use keepout_kernel::Height;

use super::super::*;
use super::{NSK, OK_STYLE, TANGO, THREE_AXES, dialect, hear};
use crate::dialect::DialectZ;
use crate::dialect::testing::{contour_to, encoded, jog_to, place};
use crate::supervisor::Report;

fn three_axes() -> Described {
    let mut described = dialect(THREE_AXES);
    let zero = Height::from_units(-1_000_000).unwrap();
    described.setting.z = Some(DialectZ { zero, steps_per_mm: 400.0, travel_mm: None });
    described
}

fn position(replies: &[Reply]) -> Option<Place> {
    match replies {
        [Reply::Report(Report { position, .. })] => *position,
        other => panic!("{other:?}"),
    }
}

#[test]
fn third_axis_counts_downward_from_its_zero() {
    let mut described = three_axes();
    assert_eq!(encoded(&mut described, &jog_to(5_000_000, 2_000_000, 600)), "V10000\r\n");
    // 10 mm below the machine's zero: 12 000 + 10 · 2000 counts.
    assert_eq!(hear(&mut described, "OK\r\n").1, "GO -150000 -180000 32000\r\n");
    hear(&mut described, "OK\r\n");
    encoded(&mut described, &Command::Query);
    let (replies, _) = hear(&mut described, "S0 X-150000 Y-180000 Z31000\r\n");
    assert_eq!(position(&replies), Some(place(5_000_000, 2_000_000, 50_000)));
}

#[test]
fn contour_of_three_axes_ends_within_three_steps_of_its_height() {
    // Three of 400 steps per mm are 7.5 µm: 15 of 2000 counts per mm.
    for (height, accepted) in [(32_015, true), (31_985, true), (32_016, false), (31_984, false)] {
        let mut described = three_axes();
        encoded(&mut described, &contour_to(5_000_000, 2_000_000, 600));
        hear(&mut described, "OK\r\nOK\r\n");
        let (replies, _) = hear(&mut described, &format!("S0 X-150000 Y-180000 Z{height}\r\n"));
        assert_eq!(replies == [Reply::Accepted], accepted, "{height}: {replies:?}");
    }
}

// Evidence for SR-12, SR-18.
#[test]
fn contour_ends_within_three_steps_and_an_alarm_is_told() {
    for (x, accepted) in [(250_007, true), (250_008, false)] {
        let mut nsk = dialect(NSK);
        encoded(&mut nsk, &contour_to(5_000_000, 2_000_000, 600));
        hear(&mut nsk, "MV10000\r\n:MA250000,170000\r\n:");
        hear(&mut nsk, "TS\r\n 0\r\n:");
        let (replies, _) = hear(&mut nsk, &format!("TP\r\n {x},170000\r\n:"));
        assert_eq!(replies == [Reply::Accepted], accepted, "{x}: {replies:?}");
    }
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &contour_to(5_000_000, 2_000_000, 600));
    hear(&mut nsk, "MV10000\r\n:MA250000,170000\r\n:TS\r\n 4\r\n:");
    let (replies, _) = hear(&mut nsk, "TP\r\n 250000,170000\r\n:");
    assert!(matches!(replies[..], [Reply::Alarm { .. }]), "{replies:?}");
}

#[test]
fn axes_that_count_backward_turn_targets_and_places() {
    let text = TANGO.replacen("[units]", "[units]\ninvert = [true, false]\nzero = [10000, 0]", 1);
    let mut tango = dialect(&text);
    let sent = encoded(&mut tango, &jog_to(5_000_000, 20_000_000, 600));
    assert!(sent.contains("!moa 151.0000 0.0000\r"), "{sent}");
    hear(&mut tango, "@@-.-\r");
    encoded(&mut tango, &Command::Query);
    hear(&mut tango, "@@-.-\r");
    let (replies, _) = hear(&mut tango, "151.0000 0.0000 0\r");
    assert_eq!(position(&replies), Some(place(5_000_000, 20_000_000, 0)));
}

// Evidence for SR-18.
#[test]
fn axes_that_are_exchanged_are_so_in_targets_and_places() {
    let jog = jog_to(5_000_000, 21_000_000, 600);
    let plain = encoded(&mut dialect(TANGO), &jog);
    let numbers = plain.split_once("!moa ").and_then(|(_, rest)| rest.split_once('\r')).unwrap().0;
    let (first, second) = numbers.split_once(' ').unwrap();
    assert_ne!(first, second);
    let mut tango = dialect(&TANGO.replacen("[units]", "[units]\nswap = true", 1));
    let sent = encoded(&mut tango, &jog);
    assert!(sent.contains(&format!("!moa {second} {first}\r")), "{plain} {sent}");
    hear(&mut tango, "@@-.-\r");
    encoded(&mut tango, &Command::Query);
    hear(&mut tango, "@@-.-\r");
    let (replies, _) = hear(&mut tango, &format!("{second} {first} 0\r"));
    assert_eq!(position(&replies), Some(place(5_000_000, 21_000_000, 0)));
}

#[test]
fn controller_with_a_queue_accepts_contours_at_once() {
    let mut queues = dialect(OK_STYLE);
    encoded(&mut queues, &contour_to(5_000_000, 2_000_000, 600));
    assert_eq!(hear(&mut queues, "ok\n"), (vec![Reply::Accepted], String::new()));
    // A controller that acknowledges nothing shows it by its state.
    let text = TANGO.replacen("queues = false", "queues = true", 1);
    for (text, accepted) in [(text.as_str(), true), (TANGO, false)] {
        let mut tango = dialect(text);
        encoded(&mut tango, &contour_to(5_000_000, 2_000_000, 600));
        assert_eq!(hear(&mut tango, "M@-.-\r").0 == [Reply::Accepted], accepted);
    }
}

#[test]
fn homing_asks_for_the_state_and_tells_an_alarm() {
    let mut tango = dialect(TANGO);
    encoded(&mut tango, &Command::Home);
    assert!(matches!(hear(&mut tango, "S@-.-\r").0[..], [Reply::Alarm { .. }]));
    // A controller without homing lines must still be at rest.
    let mut bare = dialect(&TANGO.replacen("home = [\"!cal\", \"!rm\"]", "home = []", 1));
    assert_eq!(encoded(&mut bare, &Command::Home), "?statusaxis\r");
    assert_eq!(hear(&mut bare, "MM-.-\r"), (vec![], "?statusaxis\r".into()));
    assert_eq!(hear(&mut bare, "@@-.-\r").0, [Reply::Homed]);
}

#[test]
fn failed_exchange_is_closed_with_its_echo() {
    let mut tango = dialect(TANGO);
    encoded(&mut tango, &Command::Query);
    assert!(matches!(hear(&mut tango, "\u{1}\r").0[..], [Reply::Garbled(_)]));
    assert_eq!(encoded(&mut tango, &Command::Query), "?statusaxis\r", "nothing is unanswered");
    // What is left of an echo does not count for the next line.
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &Command::Query);
    assert!(matches!(hear(&mut nsk, "X\r\n:").0[..], [Reply::Garbled(_), ..]));
    let mut forgets = dialect(NSK);
    encoded(&mut forgets, &Command::Query);
    hear(&mut forgets, "T");
    let mut again = forgets.clone();
    forgets.reset();
    assert!(forgets.echo.is_empty(), "the rest of the old echo is forgotten");
    encoded(&mut again, &Command::Prepare);
    assert_eq!(again.echo.as_slice(), b"TS\r", "only the new line's echo is expected");
}

#[test]
fn reset_forgets_lines_and_exchanges() {
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &Command::Query);
    hear(&mut nsk, "TS\r\n 1");
    nsk.reset();
    assert_eq!(encoded(&mut nsk, &Command::Query), "TS\r");
    assert_eq!(hear(&mut nsk, "TS\r\n 0\r\n:"), (vec![], "TP\r".into()));
}

#[test]
fn echoes_of_a_line_and_of_many_stops_are_expected() {
    let line = "x".repeat(110);
    let mut nsk = dialect(&NSK.replacen("prepare = []", &format!("prepare = [\"{line}\"]"), 1));
    assert_eq!(encoded(&mut nsk, &Command::Prepare), format!("{line}\r"));
    for _ in 0..7 {
        assert_eq!(encoded(&mut nsk, &Command::EndHoming), "MS\r");
    }
    assert!(matches!(hear(&mut nsk, &format!("{line}\r\n:")).0[..], [Reply::Prepared(_)]));
    for _ in 0..7 {
        assert_eq!(hear(&mut nsk, "MS\r\n:").0, []);
    }
    assert_eq!(encoded(&mut nsk, &Command::Query), "TS\r");
}

#[test]
fn echo_of_a_stop_within_an_answer_is_taken_out() {
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &Command::Query);
    hear(&mut nsk, "TS\r\n 1");
    assert_eq!(encoded(&mut nsk, &Command::EndHoming), "MS\r");
    assert_eq!(hear(&mut nsk, "MS\r\r\n:"), (vec![], String::new()), "the state is still read");
    assert_eq!(hear(&mut nsk, ":").1, "TP\r", "after the answer to the stop");
}

use keepout_kernel::Vector;

use super::*;
use crate::dialect::testing::{contour_to, encoded, jog_to};

fn dialect() -> Venus {
    let offset = Vector { dx: -20_000_000, dy: 500 };
    let mut venus = Venus::new(DialectConfig {
        offset,
        steps_per_mm: 400.0,
        arc_tolerance_mm: 0.0005,
        travel_mm: Some([400.0, 350.0]),
        z: None,
        spindle_rpm: None,
    });
    venus.in_mm = true;
    venus
}

fn hear(venus: &mut Venus, text: &str) -> (Vec<Reply>, String) {
    let mut out = Vec::new();
    let replies = text.bytes().filter_map(|byte| venus.decode(byte, &mut out)).collect();
    (replies, String::from_utf8(out).unwrap())
}

// Evidence for SR-11.
/// Nobody has measured how `abort` brakes.
#[test]
fn abort_may_leave_the_path() {
    assert_eq!(dialect().abilities().on_cancel, OnCancel::MayStray);
}

#[test]
fn report_is_status_and_then_position() {
    let mut venus = dialect();
    assert_eq!(encoded(&mut venus, &Command::Query), "st p ");
    assert_eq!(hear(&mut venus, "3\r\n").0, []);
    let position = Some(Point::from_units(5_000_000, 2_000_000).unwrap().in_plane());
    let report = Report { mode: Mode::Moving, position, queued: None, waiting: None };
    assert_eq!(hear(&mut venus, "-150.000000 20.005000\r\n").0, [Reply::Report(report)]);
    encoded(&mut venus, &Command::Query);
    assert!(matches!(hear(&mut venus, "-150.0 20.0\r\n").0[..], [Reply::Garbled(_)]), "no status came");
    encoded(&mut venus, &Command::Query);
    assert!(matches!(hear(&mut venus, "0\r\n17\r\n").0[..], [Reply::Garbled(_)]), "no position came");
    encoded(&mut venus, &Command::Query);
    let broken = hear(&mut venus, "1\r\n-20.0 -12.4\u{1}\n00 -12.9\r\n").0;
    assert!(matches!(broken[..], [Reply::Garbled(_)]), "{broken:?}: half a position is rejected");
}

#[test]
fn half_an_answer_is_dropped_with_its_query() {
    let mut venus = dialect();
    encoded(&mut venus, &Command::Query);
    hear(&mut venus, "0\r\n");
    encoded(&mut venus, &jog_to(500_123, 0, 600));
    assert_eq!(encoded(&mut venus, &Command::Query), "");
    assert!(encoded(&mut venus, &Command::Query).ends_with("move st "), "given up: the jog is sent");
    assert_eq!(hear(&mut venus, "1\r\n"), (vec![Reply::Accepted], "st p ".into()));
    let late = hear(&mut venus, "-20.0 -15.82\r\n").0;
    assert!(matches!(late[..], [Reply::Garbled(_)]), "{late:?}: the status is from before the jog");
}

// Evidence for SR-12.
#[test]
fn jogs_are_accepted_when_read_and_contours_when_done() {
    let mut venus = dialect();
    assert_eq!(
        encoded(&mut venus, &jog_to(500_123, 0, 600)),
        "10.000 setvel clear clear clear clear -194.99877 0.005 move st "
    );
    assert_eq!(encoded(&mut venus, &Command::Query), "", "the query waits");
    assert_eq!(encoded(&mut venus, &Command::EndHoming), "abort ", "the stop does not wait");
    assert_eq!(hear(&mut venus, "1\r\n"), (vec![Reply::Accepted], "st p ".into()));
    assert_eq!(hear(&mut venus, "1\r\n0 0\r\n").0.len(), 1);
    assert_eq!(encoded(&mut venus, &contour_to(0, -500, 600)), "clear clear clear clear -200 0 move st p ");
    assert_eq!(hear(&mut venus, "1\r\n-198 0\r\n"), (vec![], "st p ".into()));
    let mut skipped = venus.clone();
    assert_eq!(hear(&mut venus, "0\r\n-200.002 0\r\n"), (vec![Reply::Accepted], String::new()));
    assert!(matches!(hear(&mut skipped, "0\r\n-198 0\r\n").0[..], [Reply::Refused { .. }]));
}

// Evidence for SR-19.
#[test]
fn start_sets_units_and_reads_speed_and_acceleration() {
    let mut venus = dialect();
    assert_eq!(encoded(&mut venus, &Command::Prepare), "ge ");
    assert_eq!(hear(&mut venus, "1009\r\n"), (vec![], "restore getdim ".into()), "an old error");
    let mut two_saved = venus.clone();
    let set = "2 setdim 2 0 setunit 2 1 setunit 2 2 setunit 0 j getvel ";
    assert_eq!(hear(&mut venus, "3\r\n"), (vec![], set.into()));
    let mut still = venus.clone();
    assert_eq!(hear(&mut venus, "100.000\r\n"), (vec![], "getaccel ".into()));
    assert_eq!(hear(&mut venus, "500.0\r\n"), (vec![], "1 getunit ".into()));
    assert_eq!(hear(&mut venus, "2\r\n"), (vec![], "2 getunit ".into()));
    let mut micrometres = venus.clone();
    let limits = Limits::of(100.0, 500.0);
    assert_eq!(hear(&mut venus, "2\r\n").0, [Reply::Prepared(limits)]);
    for (unfit, answer) in [(&mut two_saved, "2\r\n"), (&mut micrometres, "1\r\n"), (&mut still, "0.0\r\n")] {
        assert!(matches!(hear(unfit, answer).0[..], [Reply::Unfit(_)]));
    }
}

// Evidence for SR-19.
#[test]
fn arm_asks_whether_homing_found_both_ends() {
    let mut venus = dialect();
    assert_eq!(encoded(&mut venus, &Command::Home), "cal st ");
    assert_eq!(hear(&mut venus, "1\r\n").1, "st ");
    assert_eq!(hear(&mut venus, "0\r\n").1, "rm st ");
    assert_eq!(hear(&mut venus, "0\r\n").1, "0 0 setpos st ");
    assert_eq!(hear(&mut venus, "0\r\n").0, [Reply::Homed]);
    assert_eq!(encoded(&mut venus, &Command::Arm), "1 getcaldone ");
    let mut half = venus.clone();
    assert_eq!(hear(&mut half, "1\r\n").0, [Reply::NotHomed]);
    assert_eq!(hear(&mut venus, "3\r\n").1, "2 getcaldone ");
    assert_eq!(hear(&mut venus, "3\r\n").1, "ge ");
    let mut refused = venus.clone();
    assert_eq!(hear(&mut venus, "0\r\n").0, [Reply::Armed]);
    assert!(matches!(hear(&mut refused, "1004\r\n").0[..], [Reply::Refused { code: 1004, .. }]));
}

// Evidence for SR-19.
#[test]
fn position_of_three_numbers_shows_a_reset() {
    let mut venus = dialect();
    for (line, asked) in [(Command::Query, "st p "), (contour_to(0, 0, 600), "move st p ")] {
        venus.in_mm = true;
        assert!(encoded(&mut venus, &line).ends_with(asked));
        assert_eq!(hear(&mut venus, "0\r\n0 0 0\r\n").0, [Reply::Restarted]);
    }
    encoded(&mut venus, &Command::Query);
    let report = Report { mode: Mode::Idle, position: None, queued: None, waiting: None };
    assert_eq!(
        hear(&mut venus, "0\r\n0 0 0\r\n").0,
        [Reply::Report(report)],
        "the dialect reads it as before the set-up"
    );
}

#[test]
fn decode_is_total() {
    crate::dialect::testing::decode_is_total(|| Box::new(dialect()), b"0123 456.789-0 \r\n\n\xff\x00e");
}

#[test]
fn every_error_has_its_meaning() {
    for (number, is_known) in
        [(1001, true), (1002, true), (1003, true), (1004, true), (1008, true), (1009, true), (1005, false)]
    {
        assert_eq!(!error_text(number).is_empty(), is_known, "{number}");
    }
    assert!(error_text(1004).contains("unknown") && error_text(1003).contains("travel"));
}

#[test]
fn speed_has_three_decimals() {
    let mut venus = dialect();
    // 754 mm/min: 12.566… mm/s, rounded down.
    for (feed, speed) in [(754, "12.566 setvel"), (7, "0.116 setvel"), (3_000, "50.000 setvel")] {
        let line = encoded(&mut venus, &jog_to(0, 0, feed));
        assert!(line.starts_with(speed), "{line}");
        hear(&mut venus, "1\r\n");
    }
}

#[test]
fn refused_figure_is_named() {
    let mut venus = dialect();
    encoded(&mut venus, &Command::Prepare);
    hear(&mut venus, "0\r\n3\r\n");
    let mut slow = venus.clone();
    let unfit = |replies: Vec<Reply>| match replies[..] {
        [Reply::Unfit(unfit)] => unfit.name,
        ref other => panic!("{other:?}"),
    };
    assert_eq!(unfit(hear(&mut slow, "0.0\r\n").0), "velocity");
    assert_eq!(unfit(hear(&mut venus, "100.0\r\n0.0\r\n").0), "acceleration");
}

#[test]
fn contour_ends_within_three_steps() {
    // Three of 400 steps per mm are 7.5 µm.
    for (place, accepted) in [("-199.9926 0.005", true), ("-200 0.0124", true), ("-199.9924 0.005", false)] {
        let mut venus = dialect();
        encoded(&mut venus, &contour_to(0, 0, 600));
        let (replies, _) = hear(&mut venus, &format!("0\r\n{place}\r\n"));
        assert_eq!(replies == [Reply::Accepted], accepted, "{place}: {replies:?}");
    }
}

#[test]
fn reset_forgets_unit_and_exchanges() {
    let mut venus = dialect();
    encoded(&mut venus, &contour_to(0, 0, 600));
    hear(&mut venus, "0\r\n-2");
    venus.reset();
    assert_eq!(encoded(&mut venus, &Command::Query), "st p ", "nothing is unanswered");
    let report = Report { mode: Mode::Idle, position: None, queued: None, waiting: None };
    assert_eq!(hear(&mut venus, "0\r\n-200 0\r\n").0, [Reply::Report(report)], "the unit is not known");
}

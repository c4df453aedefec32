use keepout_kernel::Vector;

use super::wire::checksum;
use super::*;
use crate::dialect::testing::{contour_to, encoded, jog_to};

fn dialect() -> Zaber {
    let offset = Vector { dx: -20_000_000, dy: 500 };
    Zaber::new(DialectConfig {
        offset,
        steps_per_mm: 400.0,
        arc_tolerance_mm: 0.0005,
        travel_mm: Some([400.0, 350.0]),
        z: None,
        spindle_rpm: None,
    })
}

fn ready() -> Zaber {
    let mut zaber = dialect();
    zaber.zero = Some([160_000, 140_000, 0]);
    zaber.checked = true;
    zaber
}

fn hear(zaber: &mut Zaber, message: &str) -> (Vec<Reply>, String) {
    let line = format!("{message}:{:02X}\r\n", checksum(&message.as_bytes()[1..]));
    let mut out = Vec::new();
    let replies = line.bytes().filter_map(|byte| zaber.decode(byte, &mut out)).collect();
    (replies, String::from_utf8(out).unwrap())
}

// Evidence for SR-18.
#[test]
fn report_is_in_drawing_coordinates_and_only_from_its_own_answer() {
    let mut zaber = ready();
    assert_eq!(encoded(&mut zaber, &Command::Query), "/1 0 01 get pos:2C\n");
    assert_eq!(hear(&mut zaber, "@01 0 77 OK IDLE -- 1 2").0, [], "an answer to something else");
    let (replies, _) = hear(&mut zaber, "@01 0 01 OK BUSY -- 100000 148002");
    let position = Some(Point::from_units(5_000_000, 2_000_000).unwrap().in_plane());
    let report = Report { mode: Mode::Moving, position, queued: None, waiting: None };
    assert_eq!(replies, [Reply::Report(report)]);
    let mut out = Vec::new();
    let damaged = b"@01 0 01 OK BUSY -- 100000 148002:00\r\n@01 0 01 OK BUSY -- 100000 148002\r\n";
    let replies: Vec<_> = damaged.iter().filter_map(|&byte| zaber.decode(byte, &mut out)).collect();
    assert!(matches!(replies[..], [Reply::Garbled(_), Reply::Garbled(_)]), "{replies:?}");
}

#[test]
fn start_reads_travel_limits_and_homes() {
    let mut zaber = dialect();
    assert!(encoded(&mut zaber, &Command::Prepare).contains("set comm.checksum 1"));
    assert!(hear(&mut zaber, "@01 0 01 OK IDLE -- 0").1.contains("get limit.max"));
    assert!(hear(&mut zaber, "@01 0 02 OK IDLE -- 160000 140000").1.contains("get maxspeed"));
    assert!(hear(&mut zaber, "@01 0 03 OK IDLE -- 131072 65536").1.contains("get accel"));
    let limits = Limits::of(100.0, 1000.0);
    let (replies, _) = hear(&mut zaber, "@01 0 04 OK IDLE -- 98 66");
    let [Reply::Prepared(read)] = replies[..] else { panic!("{replies:?}") };
    assert!(
        (read.speed_mm_s - limits.speed_mm_s).abs() < 0.1
            && read.acceleration_mm_s2 > 1000.0
            && read.quicker_mm_s2 > 1400.0,
        "{read:?}"
    );
    assert!(encoded(&mut zaber, &Command::Home).contains(" home:"));
    assert!(hear(&mut zaber, "@01 0 05 OK BUSY WR 0").1.contains("get pos"));
    assert!(hear(&mut zaber, "@01 0 06 OK BUSY WR 0 0").1.contains("get pos"));
    assert_eq!(hear(&mut zaber, "@01 0 07 OK IDLE -- 0 0").0, [Reply::Homed]);
    assert!(encoded(&mut zaber, &Command::Arm).contains("stream 1 setup disable"));
    assert!(hear(&mut zaber, "@01 0 08 RJ IDLE -- BADCOMMAND").1.contains("stream 1 setup live 1 2"));
    assert_eq!(hear(&mut zaber, "@01 0 09 OK IDLE -- 0").0, [Reply::Armed]);
}

// Evidence for SR-19.
/// With wrong microsteps in the profile, targets and reports agree, and the part comes out smaller. So does
/// the travel in mm.
#[test]
fn device_with_another_travel_is_rejected() {
    for (limit, fits) in [
        ("160000 140000", true),
        ("162000 139000", true),
        ("806299 705512", false),
        ("32000 28000", false),
        ("160000 137000", false),
        ("0 0", false),
        ("-160000 -140000", false),
    ] {
        let mut zaber = dialect();
        encoded(&mut zaber, &Command::Prepare);
        hear(&mut zaber, "@01 0 01 OK IDLE -- 0");
        let (replies, sent) = hear(&mut zaber, &format!("@01 0 02 OK IDLE -- {limit}"));
        assert_eq!(sent.contains("get maxspeed"), fits, "{limit}");
        assert_eq!(matches!(replies[..], [Reply::Unfit(_)]), !fits, "{limit}: {replies:?}");
        assert_eq!(zaber.zero.is_some(), fits, "{limit}");
    }
    // An older log does not state its machine's travel.
    let mut zaber = dialect();
    zaber.setting.travel_mm = None;
    encoded(&mut zaber, &Command::Prepare);
    hear(&mut zaber, "@01 0 01 OK IDLE -- 0");
    assert!(hear(&mut zaber, "@01 0 02 OK IDLE -- 32000 28000").1.contains("get maxspeed"));
}

#[test]
fn motions_are_rounded_to_steps_and_accepted_near_their_end() {
    let mut zaber = ready();
    // 5.00123 − 200 mm is −77 999.51 steps.
    let jog = encoded(&mut zaber, &jog_to(500_123, 0, 600));
    assert!(jog.contains("stream 1 set maxspeed 6553:"), "{jog}");
    let (_, line) = hear(&mut zaber, "@01 0 01 OK IDLE -- 0");
    assert!(line.contains("stream 1 line abs 82000 140002:"), "{line}");
    assert_eq!(hear(&mut zaber, "@01 0 02 OK BUSY -- 0").0, [Reply::Accepted]);
    let full = encoded(&mut zaber, &contour_to(500_123, 500_000, 600));
    assert!(full.contains("stream 1 line abs 82000 142002:"), "{full}");
    let (replies, wait) = hear(&mut zaber, "@01 0 03 RJ BUSY -- AGAIN");
    assert!(replies.is_empty() && wait.contains("get pos"));
    let (_, again) = hear(&mut zaber, "@01 0 04 OK BUSY -- 80000 140000");
    assert!(again.contains("stream 1 line abs 82000 142002:"), "{again}");
    assert!(hear(&mut zaber, "@01 0 05 OK BUSY -- 0").0.is_empty());
    assert!(hear(&mut zaber, "@01 0 06 OK BUSY -- 82000 140002").0.is_empty(), "5 mm are left");
    assert_eq!(hear(&mut zaber, "@01 0 07 OK BUSY -- 82000 141002").0, [Reply::Accepted]);
}

#[test]
fn warnings_set_the_mode_and_rejections_carry_a_code() {
    for (warning, mode) in [("WR", Mode::Alarm), ("FS", Mode::Alarm), ("NC", Mode::Other), ("NI", Mode::Idle)]
    {
        let mut zaber = ready();
        encoded(&mut zaber, &Command::Query);
        let (replies, _) = hear(&mut zaber, &format!("@01 0 01 OK IDLE {warning} 0 0"));
        assert!(
            matches!(replies[..], [Reply::Report(Report { mode: seen, .. })] if seen == mode),
            "{replies:?}"
        );
    }
    let mut zaber = ready();
    zaber.feed_mm_min = 600;
    encoded(&mut zaber, &jog_to(0, 0, 600));
    let (replies, _) = hear(&mut zaber, "@01 0 01 RJ IDLE -- BADDATA");
    assert!(matches!(replies[..], [Reply::Refused { code: 4, transient: false, .. }]), "{replies:?}");
    assert!(matches!(hear(&mut zaber, "!01 1 IDLE FS").0[..], [Reply::Alarm { code: 1, .. }]));
    assert!(matches!(hear(&mut zaber, "#01 0 hello").0[..], [Reply::Message(_)]));
}

#[test]
fn motion_does_not_follow_a_rejected_feed() {
    let mut zaber = ready();
    assert!(encoded(&mut zaber, &jog_to(0, 0, 600)).contains("maxspeed"));
    let (replies, sent) = hear(&mut zaber, "@01 0 01 RJ BUSY -- STATUSBUSY");
    assert!(matches!(replies[..], [Reply::Refused { transient: true, .. }]) && sent.is_empty(), "{sent}");
    assert!(
        encoded(&mut zaber, &jog_to(0, 0, 600)).contains("maxspeed"),
        "the next motion sets the feed again"
    );
}

#[test]
fn decode_is_total() {
    let alphabet = b"@!#/01 OKRJIDLEBUSY-- 123456789:ABCDEF\r\n\n\xff\x00";
    crate::dialect::testing::decode_is_total(|| Box::new(ready()), alphabet);
}

/// A travel beyond all devices once overflowed the sum of zero and target.
#[test]
fn travel_beyond_32_bits_is_rejected() {
    let mut zaber = dialect();
    encoded(&mut zaber, &Command::Prepare);
    hear(&mut zaber, "@01 0 01 OK IDLE -- 0");
    let (replies, _) = hear(&mut zaber, "@01 0 02 OK IDLE -- 160000 9223372036854775807");
    assert!(matches!(replies[..], [Reply::Garbled(_)]), "{replies:?}");
    assert_eq!(zaber.zero, None);
}

#[test]
fn nothing_moves_after_a_reset_until_the_zero_is_read_again() {
    let mut zaber = ready();
    zaber.reset();
    let mut out = Vec::new();
    assert_eq!(zaber.encode(&jog_to(0, 0, 600), &mut out), Err(EncodeError::WorkOffsetUnknown));
    assert!(out.is_empty());
    encoded(&mut zaber, &Command::Query);
    let (replies, _) = hear(&mut zaber, "@01 0 01 OK IDLE -- 100000 148002");
    let report = Report { mode: Mode::Idle, position: None, queued: None, waiting: None };
    assert_eq!(replies, [Reply::Report(report)]);
}

#[test]
fn every_flag_and_reason_has_its_meaning() {
    for (warning, code) in [
        ("FS", 1),
        ("FE", 2),
        ("FQ", 3),
        ("FD", 4),
        ("FB", 5),
        ("FO", 6),
        ("FP", 6),
        ("WR", 7),
        ("WH", 7),
        ("WL", 8),
        ("FX", 0),
        ("F", 0),
    ] {
        let Reply::Alarm { code: found, meaning } = alarm(warning) else { panic!("{warning}") };
        assert_eq!((found, meaning.is_empty()), (code, code == 0), "{warning}");
    }
    for (reason, code) in [
        ("AGAIN", 1),
        ("BADAXIS", 2),
        ("BADCOMMAND", 3),
        ("BADDATA", 4),
        ("STATUSBUSY", 5),
        ("FULL", 6),
        ("NOACCESS", 7),
        ("PARKED", 8),
        ("ODD", 0),
    ] {
        let (found, meaning) = refusal(reason);
        assert_eq!((found, meaning.is_empty()), (code, code == 0), "{reason}");
    }
}

#[test]
fn answers_of_another_form_are_garbled() {
    for (answer, fits) in [
        ("@01 0 01 OK IDLE -- 100000 148002", true),
        ("@01 0 01 OX IDLE -- 100000 148002", false),
        ("@01 0 01 OK IDEL -- 100000 148002", false),
        ("@02 0 01 OK IDLE -- 100000 148002", false),
        ("@01 0 0x OK IDLE -- 100000 148002", false),
    ] {
        let mut zaber = ready();
        encoded(&mut zaber, &Command::Query);
        let (replies, _) = hear(&mut zaber, answer);
        let told = matches!(replies[..], [Reply::Report(_)]);
        assert!(told == fits && told != matches!(replies[..], [Reply::Garbled(_)]), "{answer}: {replies:?}");
    }
}

#[test]
fn alerts_count_where_they_warn_of_a_fault() {
    let mut zaber = ready();
    assert_eq!(hear(&mut zaber, "!01 1 IDLE --").0, []);
    assert!(matches!(hear(&mut zaber, "!01 1 IDLE FE").0[..], [Reply::Alarm { code: 2, .. }]));
}

#[test]
fn third_axis_has_a_zero_and_a_stream_of_its_own() {
    let z = super::super::DialectZ {
        zero: Height::from_units(-1_000_000).unwrap(),
        steps_per_mm: 1000.0,
        travel_mm: Some(100.0),
    };
    let mut zaber = Zaber::new(DialectConfig { z: Some(z), ..dialect().setting });
    encoded(&mut zaber, &Command::Prepare);
    hear(&mut zaber, "@01 0 01 OK IDLE -- 0 0 0");
    assert!(hear(&mut zaber, "@01 0 02 OK IDLE -- 160000 140000 100000").1.contains("get maxspeed"));
    hear(&mut zaber, "@01 0 03 OK IDLE -- 131072 65536 65536");
    assert!(matches!(hear(&mut zaber, "@01 0 04 OK IDLE -- 98 66 66").0[..], [Reply::Prepared(_)]));
    encoded(&mut zaber, &Command::Arm);
    assert!(hear(&mut zaber, "@01 0 05 OK IDLE -- 0").1.contains("stream 1 setup live 1 2 3:"));
    hear(&mut zaber, "@01 0 06 OK IDLE -- 0");
    encoded(&mut zaber, &jog_to(0, 0, 600));
    // 10 mm below the machine's zero: 100 000 − 10 000 steps.
    let (_, line) = hear(&mut zaber, "@01 0 07 OK IDLE -- 0");
    assert!(line.contains("stream 1 line abs 80000 140002 90000:"), "{line}");
}

#[test]
fn limits_are_those_of_the_slower_axis_and_above_zero() {
    let set_up = |speeds: &str, accelerations: &str| {
        let mut zaber = dialect();
        encoded(&mut zaber, &Command::Prepare);
        hear(&mut zaber, "@01 0 01 OK IDLE -- 0");
        hear(&mut zaber, "@01 0 02 OK IDLE -- 160000 140000");
        hear(&mut zaber, &format!("@01 0 03 OK IDLE -- {speeds}"));
        hear(&mut zaber, &format!("@01 0 04 OK IDLE -- {accelerations}")).0
    };
    // Speeds in microsteps/s × 1.6384, accelerations in microsteps/s² × 1.6384 / 10 000; 400 microsteps per mm.
    let [Reply::Prepared(limits)] = set_up("131072 65536", "98 66")[..] else { panic!() };
    let off = |value: f64, expected: f64| (value / expected - 1.0).abs();
    assert!(off(limits.speed_mm_s, 65_536.0 / 1.6384 / 400.0) < 1e-9, "{limits:?}");
    assert!(off(limits.acceleration_mm_s2, 66.0 * 10_000.0 / 1.6384 / 400.0) < 1e-9, "{limits:?}");
    assert!(off(limits.quicker_mm_s2, 98.0 * 10_000.0 / 1.6384 / 400.0) < 1e-9, "{limits:?}");
    for (speeds, accelerations) in [("0 65536", "98 66"), ("131072 65536", "98 0"), ("0 0", "0 0")] {
        assert!(matches!(set_up(speeds, accelerations)[..], [Reply::Unfit(_)]), "{speeds}, {accelerations}");
    }
}

#[test]
fn contour_is_accepted_three_millimetres_before_its_end() {
    for (left, accepted) in [(1201, false), (1200, true)] {
        let mut zaber = ready();
        zaber.feed_mm_min = 600;
        encoded(&mut zaber, &contour_to(0, 0, 600));
        assert!(hear(&mut zaber, "@01 0 01 OK BUSY -- 0").1.contains("get pos"));
        let (replies, sent) = hear(&mut zaber, &format!("@01 0 02 OK BUSY -- {} {}", 80_000 - left, 140_002));
        assert_eq!(replies == [Reply::Accepted], accepted, "{left}");
        assert_eq!(sent.contains("get pos"), !accepted, "{left}");
    }
}

#[test]
fn refused_set_up_and_failed_homing_are_told() {
    let mut zaber = dialect();
    encoded(&mut zaber, &Command::Prepare);
    let (replies, _) = hear(&mut zaber, "@01 0 01 RJ IDLE -- BADCOMMAND");
    assert!(matches!(replies[..], [Reply::Unfit(Unfit { name: "comm.checksum", .. })]), "{replies:?}");
    let mut zaber = ready();
    encoded(&mut zaber, &Command::Home);
    assert!(hear(&mut zaber, "@01 0 01 OK BUSY -- 0").1.contains("get pos"));
    let (replies, _) = hear(&mut zaber, "@01 0 02 OK IDLE WR 0 0");
    assert!(matches!(replies[..], [Reply::Alarm { code: 7, .. }]), "{replies:?}");
}

#[test]
fn query_in_vain_is_given_up() {
    let mut zaber = ready();
    assert!(encoded(&mut zaber, &Command::Query).contains("get pos"));
    assert_eq!(encoded(&mut zaber, &Command::Query), "", "it is unanswered");
    assert!(encoded(&mut zaber, &Command::Query).contains("get pos"), "it counts as lost");
    // Another line that is unanswered is no query.
    let mut zaber = ready();
    encoded(&mut zaber, &Command::Home);
    assert_eq!(encoded(&mut zaber, &Command::Query), "", "it waits");
    assert_eq!(encoded(&mut zaber, &Command::Query), "", "a second one does not wait behind it");
    assert_eq!(zaber.exchanges.open().map(|asked| asked.what), Some(What::Home));
}

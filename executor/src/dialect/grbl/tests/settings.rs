//! Single settings, startup lines and offsets.

use keepout_kernel::Height;

use super::super::settings::{Settings, StartupBlocks, Stated, limits};
use super::{Command, Dialect, Reply, Stage, Unfit, dialect, hear};

fn settings(changes: &[(u16, f64)]) -> Settings {
    let mut settings = Settings::default();
    for (number, value) in [(13, 0.0), (22, 1.0), (100, 1000.0), (101, 1000.0)].iter().chain(changes) {
        settings.take(*number, &value.to_string());
    }
    settings
}

#[test]
fn each_setting_that_a_session_rests_on_is_refused_by_its_name() {
    for (number, value, refused) in [
        (481, 100.0, Some("$481")),
        (481, 0.0, None),
        (22, 0.0, Some("$22")),
        (22, 5.0, None),
        (13, 1.0, Some("$13")),
        (100, 200.0, Some("$100")),
        (101, 200.0, Some("$101")),
        // A thousandth less is a rounded figure.
        (100, 999.0, None),
        (101, 998.9, Some("$101")),
    ] {
        let checked = settings(&[(number, value)]).check(1000.0, None);
        assert_eq!(checked.err().map(|unfit| unfit.name), refused, "${number}={value}");
    }
    assert_eq!(settings(&[(102, 200.0)]).check(1000.0, Some(400.0)).unwrap_err().name, "$102");
}

#[test]
fn report_mask_keeps_what_grblhal_has_set() {
    for (mask, hal, needed) in [
        (3.0, false, None),
        (1.0, false, Some(3)),
        (5.0, false, Some(3)),
        (99.0, true, None),
        (35.0, true, Some(99)),
        (5.0, true, Some(103)),
        (0.0, true, Some(99)),
    ] {
        assert_eq!(settings(&[(10, mask)]).report_mask_needed(hal), needed, "{mask} {hal}");
    }
}

#[test]
fn rates_of_nothing_are_not_known() {
    let known = limits([Some(0.0), Some(600.0)], [Some(50.0), Some(0.0)]);
    assert!((known.speed_mm_s - 10.0).abs() < 1e-9 && (known.acceleration_mm_s2 - 50.0).abs() < 1e-9);
    assert!(limits([None, Some(0.0)], [None; 2]).speed_mm_s.is_infinite());
    // The lesser rate is that of x, the lesser acceleration that of y.
    let known = settings(&[(110, 600.0), (111, 1200.0), (120, 90.0), (121, 50.0)]).limits();
    assert!((known.speed_mm_s - 10.0).abs() < 1e-9 && (known.acceleration_mm_s2 - 50.0).abs() < 1e-9);
    assert!((known.quicker_mm_s2 - 90.0).abs() < 1e-9);
}

#[test]
fn work_offset_is_the_sum_in_each_axis() {
    let mut stated = Stated::default();
    stated.take("G54:1.000,2.000,3.000", true);
    assert_eq!(stated.sum(), None, "G92 was not stated");
    stated.take("G92:0.500,-0.250,0.125", true);
    let sum = stated.sum().unwrap();
    assert_eq!((sum.point.x.units(), sum.point.y.units()), (150_000, 175_000));
    assert_eq!(sum.height, Height::from_units(312_500).unwrap());
}

#[test]
fn startup_lines_are_stored_where_one_is_empty() {
    let needed = |lines: &[(&str, &str)]| {
        let mut blocks = StartupBlocks::default();
        lines.iter().for_each(|(name, value)| blocks.take(name, value));
        blocks.needed().map_err(|unfit| unfit.name)
    };
    let store = |line: &'static [u8]| Ok(Some(line));
    assert_eq!(needed(&[("N0", ""), ("N1", "")]), store(b"$N1=G80\n"));
    assert_eq!(needed(&[("N0", ""), ("N1", "G54")]), store(b"$N0=G80\n"));
    assert_eq!(needed(&[("N0", "G80"), ("N1", "G54")]), Ok(None));
    assert_eq!(needed(&[("N0", "G54"), ("N1", "G54")]), Err("$N1"));
    assert_eq!(needed(&[("N0", "G80"), ("N1", "G20")]), Err("$N1"), "a harmful second line");
    assert_eq!(needed(&[("N0", "G20"), ("N1", "G80")]), Err("$N0"), "a harmful first line");
    assert_eq!(needed(&[("N0", "G80")]), Err("$N"), "one line is not stated");
    assert_eq!(needed(&[("N0", "G80"), ("N1", ""), ("N2", "")]), Ok(None));
    assert_eq!(needed(&[("N0", "G80"), ("N1", ""), ("N2", "G20")]), Err("$N2"));
}

// Evidence for SR-19.
/// The controller answers `ok` to a line of which a digit changed on the way.
#[test]
fn setting_that_is_not_listed_as_it_was_stored_is_refused() {
    let listing = |changes: &[(&str, &str)]| {
        let listed = "$10=3\r\n$11=0.010\r\n$12=0.001\r\n$13=0\r\n$22=1\r\n$100=400\r\n$101=400\r\nok\r\n";
        changes.iter().fold(listed.to_owned(), |text, (from, to)| text.replace(from, to))
    };
    let second = |changes: &[(&str, &str)]| {
        let mut grbl = dialect();
        grbl.stage = Stage::Reading(Settings::default());
        hear(&mut grbl, listing(&[("$12=0.001", "$12=0.002")]).as_bytes());
        assert_eq!(hear(&mut grbl, b"$N0=\r\n$N1=G80\r\nok\r\n"), (vec![], b"$12=0.00050\n".to_vec()));
        assert_eq!(hear(&mut grbl, b"ok\r\n"), (vec![], b"$$\n".to_vec()));
        hear(&mut grbl, listing(changes).as_bytes());
        match hear(&mut grbl, b"$N0=\r\n$N1=G80\r\nok\r\n").0[..] {
            [Reply::Prepared(_)] => None,
            [Reply::Unfit(Unfit { name, value, .. })] => {
                Some((name, Some(value).filter(|value| !value.is_nan())))
            }
            ref other => panic!("{changes:?}: {other:?}"),
        }
    };
    assert_eq!(second(&[]), None);
    assert_eq!(second(&[("$10=3", "$10=2")]), Some(("$10", Some(2.0))));
    assert_eq!(second(&[("$12=0.001", "$12=0.005")]), Some(("$12", Some(0.005))));
    assert_eq!(second(&[("$12=0.001", "$12=0.000")]), Some(("$12", Some(0.0))), "arcs without a tolerance");
    assert_eq!(
        second(&[("$11=0.010", "$11=3.000")]),
        Some(("$$", None)),
        "the number of the setting was altered"
    );
}

// Evidence for SR-19.
/// At a controller that has everything, the first answer can be altered.
#[test]
fn settings_are_read_twice_where_nothing_is_stored() {
    let answers = |second: &str| {
        let mut grbl = dialect();
        grbl.setting.arc_tolerance_mm = 0.003;
        grbl.stage = Stage::Reading(Settings::default());
        let listing = |tolerance: &str| {
            format!(
                "$10=3\r\n$12={tolerance}\r\n$13=0\r\n$22=1\r\n$100=400\r\n$101=400\r\nok\r\n$N0=\r\n$N1=G80\r\nok\r\n"
            )
        };
        assert_eq!(hear(&mut grbl, listing("0.001").as_bytes()), (vec![], b"$N\n$$\n".to_vec()));
        hear(&mut grbl, listing(second).as_bytes()).0
    };
    assert!(matches!(answers("0.001")[..], [Reply::Prepared(_)]));
    assert!(matches!(answers("0.009")[..], [Reply::Unfit(Unfit { name: "$12", .. })]));
}

// Evidence for SR-19.
/// The real firmware lists 0.00050 as 0.001, and 0.00049 as 0.000. GRBL lists 0.01350 as 0.013.
#[test]
fn arc_tolerance_is_read_back_to_the_listed_digits() {
    for (allowed_mm, listed, held) in [
        (0.0005, 0.001, true),
        (0.0005, 0.0005, true),
        (0.0005, 0.0, false),
        (0.0005, 0.002, false),
        (0.0135, 0.013, true),
        (0.0135, 0.014, true),
        (0.0135, 0.015, false),
        (0.0135, 0.012, false),
    ] {
        let found = settings(&[(12, listed)]).reads_back_arcs(allowed_mm);
        assert_eq!(found, held, "{allowed_mm} listed as {listed}");
    }
    assert!(!settings(&[(12, f64::NAN)]).reads_back_arcs(0.0005) && !settings(&[]).reads_back_arcs(0.0005));
}

// Evidence for SR-19.
/// GRBL answers `error:8` to a startup line while it is locked, so the session stores it after homing.
#[test]
fn startup_line_is_stored_before_arming_and_read_back() {
    let armed_with = |listed: &str| {
        let (mut grbl, mut out) = (dialect(), Vec::new());
        grbl.startup = Some(b"$N1=G80\n");
        grbl.encode(&Command::Arm, &mut out).unwrap();
        assert_eq!(out, b"$N1=G80\n");
        assert_eq!(hear(&mut grbl, b"ok\r\n"), (vec![], b"$N\n".to_vec()));
        assert!(matches!(hear(&mut grbl, b"$x=1\r\n").0[..], [Reply::Garbled(_)]), "no startup line");
        hear(&mut grbl, format!("$N0=\r\n$N1={listed}\r\nok\r\n").as_bytes())
    };
    let (replies, sent) = armed_with("G80");
    assert!(replies.is_empty() && sent.starts_with(b"\x90G21G90"), "{replies:?}");
    for listed in ["", "G30"] {
        let (replies, sent) = armed_with(listed);
        assert!(matches!(replies[..], [Reply::Unfit(_)]) && sent.is_empty(), "{listed}: {replies:?}");
    }
}

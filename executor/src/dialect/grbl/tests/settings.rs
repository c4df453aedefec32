//! Single settings, startup lines and offsets.

use keepout_kernel::Height;

use super::super::settings::{Settings, StartupBlocks, Stated, limits};

fn settings(changes: &[(u16, f64)]) -> Settings {
    let mut settings = Settings::default();
    for (number, value) in [(13, 0.0), (22, 1.0), (100, 1000.0), (101, 1000.0)].iter().chain(changes) {
        settings.take(*number, *value);
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
        (35.0, true, None),
        (5.0, true, Some(39)),
        (0.0, true, Some(35)),
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

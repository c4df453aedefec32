//! Tests of what all dialects share: names, places, lines and counts.

use keepout_kernel::{Height, Vector};

use super::lines::Lines;
use super::scale::Scale;
use super::testing::place;
use super::{DialectConfig, DialectName, DialectNameError, DialectZ};

// Evidence for SR-17.
#[test]
fn dialects_have_names_hashes_and_axes() {
    for (name, third_axis, spindle) in
        [("grbl", true, true), ("grblhal", true, true), ("zaber", true, false), ("venus", false, false)]
    {
        let dialect = DialectName::named(name).unwrap();
        assert_eq!((dialect.name(), dialect.hash().as_str()), (name, ""));
        assert_eq!((dialect.has_third_axis(), dialect.switches_spindle()), (third_axis, spindle), "{name}");
        assert!(!dialect.needs_third_axis(), "{name}");
    }
    let described =
        ["sim/tests/described/three-axes.toml", "sim/tests/described/ok-style.toml"].map(|file| {
            let file = format!("{}/{file}", env!("CARGO_MANIFEST_DIR"));
            let dialect = DialectName::named(&file).unwrap();
            assert_eq!((dialect.name(), dialect.hash().len()), (file.as_str(), 64));
            assert!(!dialect.switches_spindle());
            (dialect.has_third_axis(), dialect.needs_third_axis())
        });
    assert_eq!(described, [(true, true), (false, false)]);
    let unknown = DialectName::named("no such dialect");
    assert!(matches!(unknown, Err(DialectNameError::Unknown { name }) if name == "no such dialect"));
}

#[test]
fn places_turn_between_drawing_and_machine() {
    let z = DialectZ { zero: Height::from_units(-70).unwrap(), steps_per_mm: 400.0, travel_mm: None };
    let offset = Vector { dx: -100, dy: 50 };
    let setting = DialectConfig {
        offset,
        steps_per_mm: 400.0,
        arc_tolerance_mm: 0.001,
        travel_mm: None,
        z: Some(z),
        spindle_rpm: None,
    };
    assert_eq!(setting.on_machine(place(1, 2, 3)), Ok(place(-99, 52, -67)));
    assert_eq!(setting.in_drawing(place(-99, 52, -67)), Ok(place(1, 2, 3)));
    let flat = DialectConfig { z: None, ..setting };
    assert_eq!(flat.on_machine(place(1, 2, 3)), Ok(place(-99, 52, 0)));
    assert_eq!(flat.in_drawing(place(-99, 52, -67)), Ok(place(1, 2, 0)));
}

#[test]
fn blank_lines_have_spaces_only() {
    let mut lines = Lines::default();
    assert!(lines.is_blank());
    lines.take(b' ');
    assert!(lines.is_blank());
    lines.take(b'x');
    assert!(!lines.is_blank());
    lines.clear();
    lines.take(0xff);
    assert!(!lines.is_blank(), "a byte that is not printable");
}

#[test]
fn counts_per_mm_are_a_ratio_above_zero() {
    assert_eq!(Scale::per_mm(36.5), Scale::ratio(36_500_000, 1_000_000));
    assert!(Scale::per_mm(1_000_000.0).is_some() && Scale::per_mm(1_000_000.000_000_3).is_none());
    for (counts, mm, fits) in [
        (1, 1, true),
        (1_000_000_000_000, 1_000_000_000_000, true),
        (0, 1, false),
        (1, 0, false),
        (1_000_000_000_001, 1, false),
        (1, -1, false),
    ] {
        assert_eq!(Scale::ratio(counts, mm).is_some(), fits, "{counts}/{mm}");
    }
}

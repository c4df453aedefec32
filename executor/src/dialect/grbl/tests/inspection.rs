//! What an inspection finds in the answers.

use super::super::inspect::GrblInspector;
use super::dialect;
use crate::dialect::{Dialect, Fit, Inspected, Inspector, StatedAxis};

fn inspected(lines: &[&str]) -> Inspected {
    let mut inspector = GrblInspector::default();
    for line in lines {
        inspector.hear(line);
    }
    inspector.inspected(400.0, 0.002)
}

/// Whether the setting of this line is good, minor or wrong: 0, 1, 2.
fn fit_of(line: &str) -> u8 {
    let name = line.split('=').next().unwrap();
    let found = inspected(&[line]);
    let finding = found.findings.iter().find(|finding| finding.name.split(' ').next() == Some(name)).unwrap();
    match finding.fit {
        Fit::Good => 0,
        Fit::Minor(_) => 1,
        Fit::Wrong(_) => 2,
    }
}

#[test]
fn queries_are_a_spoiler_and_three_lists() {
    let expected: [&[u8]; 4] = [b"$\n", b"$I\n", b"$G\n", b"$$\n"];
    assert_eq!(dialect().inspector().unwrap().questions(), expected);
}

#[test]
fn each_setting_has_its_verdict() {
    for (line, fit) in [
        ("$10=3", 0),
        ("$10=7", 0),
        ("$10=1", 1),
        ("$12=0.001", 0),
        ("$12=0.0014", 0),
        ("$12=0.002", 1),
        ("$12=0.0005", 1),
        ("$13=0", 0),
        ("$13=1", 2),
        ("$20=1", 0),
        ("$20=0", 1),
        ("$21=1", 0),
        ("$21=0", 1),
        ("$22=1", 0),
        ("$22=0", 2),
        ("$100=400", 0),
        ("$101=399", 2),
    ] {
        assert_eq!(fit_of(line), fit, "{line}");
    }
    // What the controller does not report: a session can do without some of it.
    for (name, fit) in [("$20", 1), ("$132", 1), ("$13", 2), ("$22", 2), ("$100", 2)] {
        assert_eq!(fit_of(name), fit, "{name}");
    }
}

#[test]
fn figures_above_zero_count_as_stated() {
    let found = inspected(&["$100=0", "$101=250", "$130=400", "$131=300"]);
    assert_eq!((found.steps_per_mm, found.travel_mm), (Some(250.0), Some([400.0, 300.0])));
    for lines in [["$130=0", "$131=300"], ["$130=400", "$131=0"], ["$130=-400", "$131=300"], ["$130=400", ""]]
    {
        assert_eq!(inspected(&lines).travel_mm, None, "{lines:?}");
    }
    let stated = StatedAxis {
        travel_mm: Some(80.0),
        max_rate_mm_s: Some(10.5),
        acceleration_mm_s2: Some(50.0),
        steps_per_mm: Some(640.0),
    };
    assert_eq!(inspected(&["$132=80", "$112=630", "$122=50", "$102=640"]).z, stated);
    assert_eq!(inspected(&["$132=0", "$112=0", "$122=0", "$102=-1"]).z, StatedAxis::default());
}

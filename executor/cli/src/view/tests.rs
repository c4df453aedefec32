use super::*;

fn facts() -> ViewFacts {
    let part = [(0.0, 0.0), (120.0, 0.0), (120.0, 80.0), (0.0, 80.0), (0.0, 0.0)].map(Mm2::from);
    let hole = [(40.0, 30.0), (80.0, 30.0), (80.0, 50.0), (40.0, 50.0), (40.0, 30.0)].map(Mm2::from);
    ViewFacts {
        headline: Headline::AtTheWall,
        position_mm: Some(Mm2::new(-3.2204, 41.5)),
        height_mm: None,
        wall_mm: Some(0.0124),
        unit: ShownUnit::Mm,
        speed_mm_s: Some(12.34),
        tool_radius_mm: 3.0,
        outline: Arc::new(ScreenOutline::new(&[part.to_vec(), hole.to_vec()])),
        trail: (0..40).map(|i| Mm2::new(-3.3, f64::from(i))).collect(),
        status: "speed 20 %".into(),
        notices: vec!["first".into(), "second".into(), "third".into()],
        tally: "1 of 2 contours cut. Left: 2 slot 20 × 40 (not begun)".into(),
        help: &[],
        keys: "arrows jog · space STOP · q quit".into(),
        seconds: 3723.9,
    }
}

fn check(facts: &ViewFacts, width: usize, height: usize) {
    let lines = draw(facts, width, height);
    assert_eq!(lines.len(), height);
    for line in &lines {
        assert!(line.chars().count() <= width, "{width}×{height}: {line:?}");
        assert!(!line.chars().any(char::is_control));
    }
}

#[test]
fn large_view_matches_its_snapshot() {
    let view = draw(&facts(), 80, 24).join("\n");
    let expected = include_str!("large.txt");
    assert_eq!(view.trim_end(), expected.trim_end(), "\n{view}");
}

#[test]
fn small_view_matches_its_snapshot() {
    let view = draw(&facts(), 40, 12).join("\n");
    let expected = include_str!("small.txt");
    assert_eq!(view.trim_end(), expected.trim_end(), "\n{view}");
}

#[test]
fn inches_are_shown_and_named() {
    let facts = ViewFacts { unit: ShownUnit::Inch, ..facts() };
    let small = draw(&facts, 40, 12).join("\n");
    assert!(small.contains("X   -0.1268") && small.contains("Y    1.6339"), "{small}");
    assert!(small.contains("wall   0.0005 in") && small.contains("moving 29.1 in/min"), "{small}");
    assert!(draw(&facts, 80, 24).join("\n").contains("lengths in inches"));
    check(&facts, 80, 24);
}

#[test]
fn view_shows_a_fault_with_its_remedy() {
    let fault = "no answer from the controller for 5.0 s. Check cable, power, port and baud rate.";
    let facts = ViewFacts { headline: Headline::stopped(fault), ..facts() };
    assert_eq!(facts.headline.tone(), Tone::Alarm);
    for (width, height) in [(80, 24), (40, 12)] {
        let view = draw(&facts, width, height).join(" ");
        assert!(view.contains("no answer from the controller"), "{view}");
        assert!(view.contains("Check cable, power"), "{view}");
        check(&facts, width, height);
    }
}

#[test]
fn every_headline_fits_80_columns_large() {
    let all = [
        Headline::Starting,
        Headline::Manual,
        Headline::Armed,
        Headline::AtTheWall,
        Headline::EndOfTravel,
        Headline::Contouring { percent: Some(100) },
        Headline::Contouring { percent: None },
        Headline::Retracting,
        Headline::Touching,
        Headline::Pausing,
        Headline::Paused,
        Headline::Stopping,
        Headline::Done,
        Headline::stopped("x"),
    ];
    for headline in all {
        assert!(letters::large(&headline.words(), 80).is_some(), "{headline:?}");
    }
}

#[test]
fn view_fits_every_size_with_any_facts() {
    let odd = ViewFacts {
        headline: Headline::stopped(&"a long reason \u{1b}[2J 漢字 ".repeat(40)),
        height_mm: Some(f64::NAN),
        position_mm: Some(Mm2::new(f64::NAN, f64::INFINITY)),
        wall_mm: Some(-1.0),
        unit: ShownUnit::Inch,
        speed_mm_s: Some(f64::NAN),
        tool_radius_mm: f64::INFINITY,
        outline: Arc::new(ScreenOutline::default()),
        trail: vec![Mm2::new(f64::NAN, 0.0), Mm2::new(f64::MAX, f64::MIN)],
        status: "\u{7}".into(),
        notices: vec!["\u{1b}]0;title\u{7}".into(), "\u{202e}gnirts".into()],
        tally: "\u{7}".repeat(300),
        help: &[],
        keys: "k".repeat(500),
        seconds: f64::NAN,
    };
    let far =
        ViewFacts { position_mm: Some(Mm2::new(-123_456.789, 99_998.999)), wall_mm: Some(1e9), ..facts() };
    let helped = ViewFacts { help: &crate::operator_setup::HELP, ..facts() };
    let high = ViewFacts { height_mm: Some(-2.5), ..facts() };
    for (columns, lines) in [(40, 12), (100, 40)] {
        let text = draw(&high, columns, lines).join("\n");
        assert!(text.contains("Z") && text.contains("-2.500"), "{text}");
    }
    let none = ViewFacts { position_mm: None, wall_mm: None, speed_mm_s: None, ..facts() };
    for facts in [facts(), odd, far, none, helped] {
        for width in (0..=100).chain([200, 1000]) {
            for height in (0..=30).chain([100]) {
                check(&facts, width, height);
            }
        }
    }
}

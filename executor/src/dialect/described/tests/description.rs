//! What a description may hold, to the last character and the last count.

use super::super::template::Template;
use super::super::*;
use super::{NSK, OK_STYLE, TANGO, THREE_AXES, dialect, hear};
use crate::dialect::testing::encoded;

/// The key that a description is rejected for.
fn rejected(text: &str) -> Option<String> {
    Some(Description::of(text).err()?.to_string().split(':').next().unwrap().into())
}

fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn lines_may_have_120_characters_with_the_state_query() {
    // "TS" and its end are three characters; each line has an end of one.
    for (list, characters, fits) in [("prepare = []", 116, true), ("prepare = []", 117, false)] {
        let line = format!("prepare = [\"{}\"]", "x".repeat(characters));
        let key = rejected(&changed(NSK, list, &line));
        assert_eq!(key, (!fits).then(|| "motion.line".into()), "{characters}");
    }
    // A number may have 14 characters: 3 + 3 · (2 · 14 + 3 + 1) = 99, and 20 more are 119.
    let values = "\"MA{x},{y}\", \"MB{x},{y}\", \"MC{x},{y}\"";
    for (rest, fits) in [(20, true), (22, false)] {
        let lines = format!("line = [{values}, \"{}\"]", "x".repeat(rest));
        let key = rejected(&changed(NSK, "line = [\"MV{feed}\", \"MA{x},{y}\"]", &lines));
        assert_eq!(key, (!fits).then(|| "motion.line".into()), "{rest}");
    }
}

#[test]
fn homing_may_have_99_lines() {
    for (count, key) in [(99, None), (100, Some("units.zero".into()))] {
        let home = format!("home = [{}]", vec!["\"\""; count].join(", "));
        assert_eq!(rejected(&changed(NSK, "home = [\"HS\"]", &home)), key, "{count}");
    }
}

#[test]
fn line_ends_and_prompts_have_up_to_four_characters() {
    for (end, key) in [("\\r\\n\\r\\n", None), ("", Some("line.end")), ("\\r\\n\\r\\n\\r", Some("line.end"))]
    {
        let text = changed(OK_STYLE, "end = \"\\n\"", &format!("end = \"{end}\""));
        assert_eq!(rejected(&text).as_deref(), key, "{end}");
    }
    for (prompt, key) in [("::::", None), (":::::", Some("line.prompt")), ("»", Some("line.prompt"))] {
        let text = changed(NSK, "prompt = \":\"", &format!("prompt = \"{prompt}\""));
        assert_eq!(rejected(&text).as_deref(), key, "{prompt}");
    }
}

#[test]
fn height_in_a_line_needs_a_third_axis() {
    let answer = changed(OK_STYLE, "X{x} Y{y}\"", "X{x} Y{y} Z{z}\"");
    assert_eq!(rejected(&answer).as_deref(), Some("units.z"), "in the answer");
    let line = changed(OK_STYLE, "G1 X{x} Y{y}", "G1 X{x} Y{y} Z{z}");
    assert_eq!(rejected(&line).as_deref(), Some("units.z"), "in the motion");
    assert_eq!(rejected(THREE_AXES), None);
}

#[test]
fn figures_have_up_to_six_decimals() {
    for (decimals, key) in [(6, None), (7, Some("units.counts_per_mm")), (8, Some("units.counts_per_mm"))] {
        let text = changed(TANGO, "decimals = 4", &format!("decimals = {decimals}"));
        assert_eq!(rejected(&text).as_deref(), key, "{decimals}");
    }
    let figure = Description::of(TANGO).unwrap().coordinate;
    assert!((figure.ten() - 10_000.0).abs() < 1e-9);
    assert_eq!(figure.written(-12_345.0), "-1.2345");
}

#[test]
fn states_of_a_simulated_controller_are_read_back() {
    for (text, states) in [
        (NSK, [("1", Mode::Moving), ("4", Mode::Alarm), ("0", Mode::Idle), ("-", Mode::Other)]),
        (OK_STYLE, [("Run", Mode::Moving), ("Alarm", Mode::Alarm), ("Idle", Mode::Idle), ("0", Mode::Other)]),
    ] {
        let description = Description::of(text).unwrap();
        for (state, mode) in states {
            let found = description.state(mode);
            // A rule of bits needs a number, so this controller has no state for another mode.
            assert_eq!(found.as_deref(), (state != "-").then_some(state), "{mode:?}");
        }
        assert_eq!(description.state(Mode::Held), None);
    }
}

#[test]
fn word_before_a_space_at_the_end_may_have_spaces() {
    let captures = Template::of("S {status} ").unwrap();
    assert_eq!(captures.read("S I J ").unwrap().text(Slot::Status), Some("I J"));
    assert_eq!(Template::of("{x} ab {y}").unwrap().longest(14), 32);
}

#[test]
fn arcs_need_their_lines_and_linear_contours() {
    let arcs = |text: &str| dialect(text).abilities().arcs;
    assert!(arcs(OK_STYLE) && !arcs(NSK) && !arcs(THREE_AXES));
    assert!(!arcs(&changed(OK_STYLE, "interpolation = \"linear\"", "interpolation = \"independent\"")));
}

#[test]
fn counts_may_be_a_thousandth_coarser_than_steps() {
    for (counts, fits) in [("399.6", true), ("399.5", false), ("400", true)] {
        let text =
            changed(OK_STYLE, "counts_per_mm = 100000\ndecimals = 5", &format!("counts_per_mm = {counts}"));
        let mut described = dialect(&text);
        let sent = encoded(&mut described, &Command::Prepare);
        assert_eq!(sent.starts_with("G21"), fits, "{counts}: {sent}");
        let (replies, _) = hear(&mut described, if fits { "ok\nok\n" } else { "<Idle>\n" });
        assert_eq!(matches!(replies[..], [Reply::Prepared(_)]), fits, "{counts}: {replies:?}");
        assert_eq!(matches!(replies[..], [Reply::Unfit(_)]), !fits, "{counts}: {replies:?}");
    }
}

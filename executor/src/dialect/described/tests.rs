mod answers;
mod description;

use keepout_kernel::Vector;

use super::*;
use crate::dialect::testing::{contour_of, contour_to, encoded, jog_to};
use crate::supervisor::Report;

const NSK: &str = include_str!("../../../dialects/nsk-style.toml");
const TANGO: &str = include_str!("../../../dialects/tango.toml");
const OK_STYLE: &str = include_str!("../../../sim/tests/described/ok-style.toml");
const THREE_AXES: &str = include_str!("../../../sim/tests/described/three-axes.toml");

fn dialect(text: &str) -> Described {
    let offset = Vector { dx: -20_000_000, dy: -20_000_000 };
    let description = Arc::new(Description::of(text).unwrap());
    Described::new(
        description,
        DialectConfig {
            offset,
            steps_per_mm: 400.0,
            arc_tolerance_mm: 0.0005,
            travel_mm: Some([400.0, 350.0]),
            z: None,
            spindle_rpm: None,
        },
    )
}

fn hear(dialect: &mut Described, text: &str) -> (Vec<Reply>, String) {
    let mut out = Vec::new();
    let replies = text.bytes().filter_map(|byte| dialect.decode(byte, &mut out)).collect();
    (replies, String::from_utf8(out).unwrap())
}

#[test]
fn query_reads_the_state_and_then_the_position() {
    let mut nsk = dialect(NSK);
    assert_eq!(encoded(&mut nsk, &Command::Query), "TS\r");
    assert_eq!(hear(&mut nsk, "TS\r\n 1\r\n:"), (vec![], "TP\r".into()));
    let position = Some(Point::from_units(5_000_000, 2_000_000).unwrap().in_plane());
    let report = Report { mode: Mode::Moving, position, queued: None, waiting: None };
    assert_eq!(hear(&mut nsk, "TP\r\n 250000,170000\r\n:").0, [Reply::Report(report)]);
}

/// Found by fuzzing: the end of a stop's echo joined the digits before and after it to one number.
#[test]
fn echo_of_a_line_end_in_an_answer_does_not_join_its_digits() {
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &Command::Query);
    hear(&mut nsk, "TS\r\n 1\r\n:");
    // The end of the query's own echo is lost, and a stop goes out before the answer is complete.
    hear(&mut nsk, "TP 250000,1700");
    assert_eq!(encoded(&mut nsk, &Command::EndHoming), "MS\r");
    let far = Point::from_units(5_000_000, 155_000_000).unwrap();
    for reply in hear(&mut nsk, "00\r0\r\n:").0 {
        let Reply::Report(report) = reply else { continue };
        assert!(report.position.is_none_or(|at| at.point.y < far.y), "{report:?}");
    }
}

/// A state from before a motion and a position from after it make no valid report.
#[test]
fn no_line_goes_out_between_a_state_and_its_position() {
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &Command::Query);
    assert_eq!(encoded(&mut nsk, &jog_to(5_000_049, 2_000_051, 600)), "");
    assert_eq!(hear(&mut nsk, "TS\r\n 0\r\n:"), (vec![], "TP\r".into()));
    let (replies, sent) = hear(&mut nsk, "TP\r\n 250000,170000\r\n:");
    assert!(matches!(replies[..], [Reply::Report(Report { mode: Mode::Idle, .. })]), "{replies:?}");
    assert_eq!(sent, "MV10000\r");
}

#[test]
fn jog_is_two_lines_and_stop_does_not_wait() {
    let mut nsk = dialect(NSK);
    assert_eq!(encoded(&mut nsk, &jog_to(5_000_049, 2_000_051, 600)), "MV10000\r");
    assert_eq!(encoded(&mut nsk, &Command::Query), "");
    assert_eq!(hear(&mut nsk, "MV10000\r\n:"), (vec![], "MA250000,170001\r".into()));
    assert_eq!(encoded(&mut nsk, &Command::EndHoming), "MS\r");
    assert_eq!(hear(&mut nsk, "MA250000,170001\r\n:").0, [Reply::Accepted]);
    assert_eq!(hear(&mut nsk, "MS\r\n:"), (vec![], "TS\r".into()));
}

#[test]
fn contour_is_accepted_at_its_end_only() {
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &contour_to(5_000_000, 2_000_000, 600));
    hear(&mut nsk, "MV10000\r\n:");
    assert_eq!(hear(&mut nsk, "MA250000,170000\r\n:"), (vec![], "TS\r".into()));
    assert_eq!(hear(&mut nsk, "TS\r\n 1\r\n:").1, "TP\r");
    assert_eq!(hear(&mut nsk, "TP\r\n 249000,170000\r\n:").1, "TS\r");
    assert_eq!(hear(&mut nsk, "TS\r\n 0\r\n:").1, "TP\r");
    let mut elsewhere = nsk.clone();
    assert_eq!(hear(&mut nsk, "TP\r\n 250001,170000\r\n:").0, [Reply::Accepted]);
    assert!(matches!(hear(&mut elsewhere, "TP\r\n 249000,170000\r\n:").0[..], [Reply::Refused { .. }]));
}

#[test]
fn damaged_lines_and_rejections_are_reported() {
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &Command::Query);
    assert!(matches!(hear(&mut nsk, "T5\r\n").0[..], [Reply::Garbled(_)]), "another echo");
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &Command::Query);
    assert!(matches!(hear(&mut nsk, "T:").0[..], [Reply::Garbled(_)] | []), "a lost echo");
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &Command::Query);
    assert!(matches!(hear(&mut nsk, "TS\r\n:").0[..], [Reply::Garbled(_)]), "no data");
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &Command::Query);
    let torn = hear(&mut nsk, "T\rS 0\r1\r\n:").0;
    assert!(matches!(torn[..], [Reply::Garbled(_), ..]), "{torn:?}: the end of an answer is not an echo");
    let mut nsk = dialect(NSK);
    encoded(&mut nsk, &jog_to(0, 0, 600));
    let (replies, sent) = hear(&mut nsk, "MV10000\r\n E7 BUSY\r\n:");
    assert!(matches!(replies[..], [Reply::Refused { code: 7, transient: true, .. }]), "{replies:?}");
    assert_eq!(sent, "", "the motion does not follow its rejected feed");
    encoded(&mut nsk, &Command::Query);
    let (replies, _) = hear(&mut nsk, "TS\r\n E7 BUSY\r\n:");
    assert!(
        matches!(replies[..], [Reply::Refused { transient: false, .. }]),
        "the rejected line is not a motion"
    );
}

#[test]
fn start_without_acknowledgements() {
    let mut tango = dialect(TANGO);
    assert_eq!(encoded(&mut tango, &Command::Prepare), "!dim 2 2\r?statusaxis\r");
    assert!(matches!(hear(&mut tango, "@@-.-\r").0[..], [Reply::Prepared(..)]));
    assert_eq!(encoded(&mut tango, &Command::Home), "!cal\r?statusaxis\r");
    assert_eq!(hear(&mut tango, "MM-.-\r").1, "?statusaxis\r");
    assert_eq!(hear(&mut tango, "@@-.-\r").1, "!rm\r?statusaxis\r");
    assert_eq!(hear(&mut tango, "@@-.-\r").0, [Reply::Homed]);
    assert_eq!(encoded(&mut tango, &Command::Arm), "?statusaxis\r");
    assert_eq!(hear(&mut tango, "@@-.-\r").0, [Reply::Armed]);
    let jog = encoded(&mut tango, &jog_to(5_000_123, 0, 600));
    assert_eq!(jog, "!dim 2 2\r!vel 10.000 10.000\r!moa -149.9988 -200.0000\r?statusaxis\r");
    assert_eq!(hear(&mut tango, "M@-.-\r").0, [Reply::Accepted]);
}

#[test]
fn coarse_counts_are_rejected() {
    let mut coarse = dialect(&NSK.replace("counts_per_mm = 1000", "counts_per_mm = 100"));
    encoded(&mut coarse, &Command::Prepare);
    assert!(matches!(hear(&mut coarse, "TS\r\n 0\r\n:").0[..], [Reply::Unfit(_)]));
}

#[test]
fn rejected_description_names_its_key() {
    for (from, to, says) in [
        ("end = \"\\r\"", "ende = \"\\r\"", "ende"),
        ("answer = \"{status}\"", "answer = \"{state}\"", "ask.status.answer: {state}"),
        ("answer = \"{x},{y}\"", "answer = \"{x}\"", "ask.position.answer: a line with {x} and {y}"),
        ("prompt = \":\"", "prompt = \"\"", "motion.accepted"),
        ("accepted = \"prompt\"", "accepted = \"query\"", "motion.accepted"),
        ("\nzero = [400000, 350000]", "\nzero = [4000000000, 0]", "units.zero"),
        (
            "\nzero = [400000, 350000]",
            "\nzero = [400000, 350000, 0]",
            "invalid length 3, expected an array of two",
        ),
        ("counts_per_mm = 1000", "counts_per_mm = 0", "units.counts_per_mm: more than 0"),
        ("{ bits = 1, mode", "{ mode", "status.rules"),
        ("{ bits = 1, mode", "{ bits = 0, mode", "status.rules"),
        ("{ bits = 1, mode", "{ contains = \"\", mode", "status.rules"),
        ("{ bits = 1, mode", "{ equals = \"\", mode", "status.rules"),
        ("[\"MV{feed}\", \"MA{x},{y}\"]", "[\"MA{x}\"]", "motion.line"),
        ("interpolation = \"independent\"", "interpolation = \"round\"", "unknown variant `round`"),
    ] {
        assert!(NSK.contains(from), "{from}");
        let error = Description::of(&NSK.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn stop_with_an_ambiguous_echo_is_rejected() {
    let asking = NSK.replace("prompt = \":\"", "prompt = \"\"").replace("\"prompt\"", "\"query\"");
    let error = Description::of(&asking).unwrap_err().to_string();
    assert!(error.contains("motion.stop: left out where line.echo"), "{error}");
    assert!(Description::of(&asking.replace("stop = \"MS\"", "")).is_ok());
}

/// A rule of bits needs a state that is a number.
#[test]
fn state_that_is_not_a_number_is_not_taken_as_idle() {
    let bits = TANGO
        .replace("answer = \"{status}\"", "answer = \"S{status}\"")
        .replace("contains = \"M\"", "bits = 1");
    let mut tango = dialect(&bits.replace("otherwise = \"other\"", "otherwise = \"idle\""));
    for (state, believed) in [("S4", true), ("Sx", false), ("S-1", false), ("S5000000001", false)] {
        tango.reset();
        encoded(&mut tango, &Command::Query);
        let (replies, next) = hear(&mut tango, &format!("{state}\r"));
        assert_eq!((replies.is_empty(), next.contains("?pos")), (believed, believed), "{state}: {replies:?}");
    }
}

#[test]
fn decode_is_total() {
    let alphabet = b":TSPMAV 0123456789,.-E\r\n\n@MSCA\xff\x00";
    for text in [NSK, TANGO] {
        crate::dialect::testing::decode_is_total(|| Box::new(dialect(text)), alphabet);
    }
}

/// A quarter circle, counter-clockwise about the origin.
fn quarter() -> Command {
    let [from, to] = [(1_000_000, 0), (0, 1_000_000)].map(|(x, y)| Point::from_units(x, y).unwrap());
    let arc = keepout_kernel::Arc::new(from, to, Point::ORIGIN, Turn::CounterClockwise).unwrap();
    contour_of(keepout_guard::ContourMotion::in_plane(Curve::Arc(arc), 600))
}

// Evidence for SR-17.
#[test]
fn mirrored_axes_turn_arcs_the_other_way() {
    let mirrored =
        ["swap = true", "invert = [true, false]", "invert = [false, true]"].map(|units| (units, "G2"));
    let turned =
        ["", "invert = [true, true]", "swap = true\ninvert = [true, false]"].map(|units| (units, "G3"));
    for (units, line) in mirrored.into_iter().chain(turned) {
        let text = OK_STYLE.replacen("[units]", &format!("[units]\n{units}"), 1);
        let sent = encoded(&mut dialect(&text), &quarter());
        assert!(sent.starts_with(line), "{units}: {sent}");
    }
}

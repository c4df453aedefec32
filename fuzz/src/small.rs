//! The small files: profiles, alignments, scripts, traces, descriptions. The program uses exactly the
//! content of the file.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use arbitrary::{Arbitrary, Unstructured};
use keepout_drives::gains::Design;
use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::{Described, Description, Dialect};
use keepout_executor::operator::{Operator, Panel};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::align::file::AlignmentFile;
use keepout_planner::machine::MachineProfile;
use keepout_planner::margin::Budget;
use keepout_sim::operator::{Recorder, Script, TraceOperator};
use serde::Serialize;
use toml::Value;

use crate::dialects::{COMMANDS, dialect_config};
use crate::import::check_message;
use crate::oracle;
use crate::panel::view;
use crate::sketch::number;

/// Largest number of inputs taken from an operator's file.
const LOOKS: usize = 200;

/// Reads any bytes as a machine profile or, after a zero byte, as the figures of one. The result is a typed
/// error, or figures that a machine can have. They are the file's, survive writing and reading, and give a
/// margin that is their sum.
///
/// # Panics
/// When one of these does not hold.
pub fn machine_profile(bytes: &[u8]) {
    if let Some((0, figures)) = bytes.split_first() {
        return profile_of(&with_figures(&mut Unstructured::new(figures)).unwrap_or_default());
    }
    if let Ok(text) = std::str::from_utf8(bytes) {
        profile_of(text);
    }
}

/// A profile with all its keys and any numbers.
fn with_figures(u: &mut Unstructured<'_>) -> arbitrary::Result<String> {
    const KEYS: [&str; 7] = [
        "max_rate_mm_s",
        "acceleration_mm_s2",
        "steps_per_mm",
        "report_digit_mm",
        "arc_tolerance_mm",
        "repeatability_mm",
        "contour_error_mm",
    ];
    let two = [number(u)?, number(u)?];
    let mut text = "name = \"any\"\n".to_string();
    let usual = MachineProfile::simulated().to_toml();
    for key in KEYS {
        // Most figures are usual ones, so that the parser also reaches the others.
        let line = usual.lines().find(|line| line.starts_with(key)).unwrap_or_default();
        let any = if bool::arbitrary(u)? { Some(number(u)?) } else { None };
        text.push_str(&any.map_or_else(|| line.to_string(), |any| format!("{key} = {any:?}")));
        text.push('\n');
    }
    // Older inputs end here, and so have any travel.
    let travel = match u.int_in_range(0..=3_u8)? {
        0 => two.to_vec(),
        1 => vec![400.0, 350.0],
        2 => vec![400.0, 350.0, two[0]],
        _ => vec![400.0],
    };
    text.push_str(&format!("travel_mm = {travel:?}\ncontour_error_source = \"stated: fuzz\"\n"));
    Ok(text)
}

fn profile_of(text: &str) {
    let profile = match MachineProfile::parse(Path::new("fuzz"), text) {
        Ok(profile) => profile,
        Err(error) => return check_message(&error.to_string()),
    };
    let again = MachineProfile::parse(Path::new("fuzz"), &profile.to_toml()).expect("it was written as TOML");
    assert_eq!(again, profile);
    is_used(text, &profile);
    match Budget::of(&profile, None, false) {
        Ok(budget) => adds_up(&profile, &budget, None),
        Err(error) => check_message(&error.to_string()),
    }
}

/// Checks that the terms cover the machine's errors or the requested margin, and that their sum is the
/// margin.
pub(crate) fn adds_up(profile: &MachineProfile, budget: &Budget, ordered_mm: Option<f64>) {
    let sum: f64 = budget.terms.iter().map(|term| term.mm).sum();
    let least = ordered_mm.unwrap_or_else(|| oracle::least_margin_mm(profile)) - 1e-9;
    let figures = [
        profile.repeatability_mm,
        profile.contour_error_mm,
        profile.arc_tolerance_mm,
        profile.report_digit_mm,
    ];
    assert!(figures.iter().all(|figure| (0.0..=10.0).contains(figure)), "{profile:?}");
    assert!(budget.terms.iter().all(|term| term.mm >= 0.0) && sum >= least, "{profile:?}: {budget:?}");
    if let Ok(total) = budget.total() {
        // Each term is rounded up to a unit of the lattice.
        let most = 1e-5 * f64::from(u8::try_from(budget.terms.len()).unwrap_or(u8::MAX)) + 1e-9;
        let off = f64::from(total.units()) / 1e5 - sum;
        assert!((-1e-9..=most).contains(&off), "{off} mm between the terms and the margin of {profile:?}");
    }
}

/// Reads any bytes as one of the small files: a controller's description, an alignment, a script, a trace,
/// drives. The first byte chooses. The result is a typed error, or all of the file's content. Comments and
/// blanks change nothing. The inputs of a script or a trace come back from a recording. A dialect from a
/// description takes the rest of the bytes.
///
/// # Panics
/// When one of these does not hold.
pub fn small_files(bytes: &[u8]) {
    let Some((which, rest)) = bytes.split_first() else { return };
    let path = Path::new("fuzz");
    let Ok(text) = std::str::from_utf8(rest) else {
        // Only traces may be other than text.
        return check_message(&TraceOperator::read(rest, path).expect_err("it is no text").to_string());
    };
    match which % 5 {
        0 => match Description::of(text) {
            Ok(description) => decodes(description, rest),
            Err(error) => check_message(&error.to_string()),
        },
        1 => match AlignmentFile::parse(path, text) {
            Ok(setup) => {
                assert!(setup.placed().is_none_or(|(degrees, _)| degrees.is_finite()));
                is_used(text, &setup);
            }
            Err(error) => check_message(&error.to_string()),
        },
        2 => match Script::parse(text) {
            Ok(script) => {
                let bare = bare(text.lines().map(|line| line.split('#').next().unwrap_or_default()));
                assert_eq!(Script::parse(&bare).expect("it was read before"), script, "{bare}");
                is_recorded(script, rest);
            }
            Err(error) => check_message(&error.to_string()),
        },
        3 => match TraceOperator::read(rest, path) {
            Ok(trace) => {
                let bare = bare(text.split('\n').filter(|line| !line.trim().starts_with('#')));
                let again = TraceOperator::read(bare.as_bytes(), path).expect("it was read before");
                assert_eq!(again, trace, "{bare}");
                is_recorded(trace, rest);
            }
            Err(error) => check_message(&error.to_string()),
        },
        _ => match DriveProfile::parse("fuzz", text) {
            Ok(drives) => is_used(text, &drives),
            Err(error) => check_message(&error.to_string()),
        },
    }
}

/// The lines without comments and blanks.
fn bare<'a>(lines: impl Iterator<Item = &'a str>) -> String {
    let words = lines.map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
    words.filter(|line| !line.is_empty()).map(|line| line + "\n").collect()
}

/// Checks that all of the file's content was read.
fn is_used(text: &str, read: &impl Serialize) {
    let stated = Value::Table(toml::from_str(text).expect("it was read before"));
    let used = Value::try_from(read).expect("it has a form in TOML");
    assert!(is_in(&stated, &used), "{stated} was read as {used}");
}

/// The value of a field that a file leaves out where it is the usual one.
fn omitted(field: &str) -> Option<Value> {
    match field {
        "design" => Value::try_from(Design::default()).ok(),
        "stribeck_mm_s" => Some(Value::Float(1.0)),
        _ => None,
    }
}

#[expect(clippy::cast_precision_loss, reason = "as it is when an integer is read where a number is expected")]
fn is_in(said: &Value, used: &Value) -> bool {
    match (said, used) {
        (Value::Table(said), Value::Table(used)) => {
            let other = |key: &str| used.get(key).cloned().or_else(|| omitted(key));
            said.iter().all(|(key, value)| other(key).is_some_and(|other| is_in(value, &other)))
        }
        (Value::Array(said), Value::Array(used)) => {
            said.len() == used.len() && said.iter().zip(used).all(|(value, other)| is_in(value, other))
        }
        (Value::Integer(said), Value::Float(used)) => *said as f64 == *used,
        _ => said == used,
    }
}

/// Checks that the recording of an operator's inputs gives the same inputs at the same times.
fn is_recorded(operator: impl Operator, looks: &[u8]) {
    let seen = view(Phase::Manual);
    let mut now = Time::from_micros(77_777);
    let mut later = |look: u64| {
        now = now.after(Duration::from_micros(1 + 300 * look * look));
        now
    };
    let times: Vec<Time> = looks.iter().take(LOOKS).map(|&look| later(look.into())).collect();
    let mut file = Vec::new();
    let mut recorder = Recorder::new(operator, &mut file, Panel::default());
    let steps: Vec<(OperatorInput, Option<OperatorCommand>)> =
        times.iter().map(|&time| (recorder.input(&seen, time), recorder.command())).collect();
    drop(recorder);
    let mut again = TraceOperator::read(&file[..], Path::new("recorded")).expect("a recording can be read");
    // Turns add up. Infinite values count as zero.
    let finite = |value: Mm2| if value.is_finite() { value } else { Mm2::ZERO };
    for (time, (input, command)) in times.into_iter().zip(steps) {
        let input =
            OperatorInput { velocity: finite(input.velocity), turned_mm: finite(input.turned_mm), ..input };
        assert_eq!((again.input(&seen, time), again.command()), (input, command), "at {time:?}");
    }
}

fn decodes(description: Description, bytes: &[u8]) {
    let mut dialect = Described::new(Arc::new(description), dialect_config());
    let mut out = Vec::new();
    for command in COMMANDS {
        let _ = dialect.encode(&command, &mut out);
        for &byte in bytes.iter().take(500) {
            let before = out.len();
            let _ = dialect.decode(byte, &mut out);
            assert!(out.len() - before < 3000, "unbounded output");
        }
    }
}

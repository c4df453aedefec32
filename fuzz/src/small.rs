//! The small files: profiles, setups, scripts, traces, descriptions. What they say is what is used, and nothing else.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use arbitrary::{Arbitrary, Unstructured};
use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::{Described, Description, Dialect};
use keepout_executor::operator::{Operator, OperatorView, Panel};
use keepout_executor::supervisor::{OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::align::file::AlignmentFile;
use keepout_planner::machine::MachineProfile;
use keepout_planner::margin::Budget;
use keepout_sim::operator::{Recorder, Script, Trace};
use serde::Serialize;
use toml::Value;

use crate::dialects::{COMMANDS, setting};
use crate::import::told;
use crate::oracle;
use crate::sketch::number;

/// Looks at what an operator from a file inputs.
const LOOKS: usize = 200;

/// Any bytes as a machine profile, or, behind a zero, as its figures: a typed error, or figures that a machine can have, which are
/// those of the file, come back from another, and make a margin of their sum.
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

/// A profile that has all its keys, and any numbers.
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
        // Most figures are usual ones, so that it comes to the others.
        let line = usual.lines().find(|line| line.starts_with(key)).unwrap_or_default();
        let any = if bool::arbitrary(u)? { Some(number(u)?) } else { None };
        text.push_str(&any.map_or_else(|| line.to_string(), |any| format!("{key} = {any:?}")));
        text.push('\n');
    }
    // Inputs that end before have any strokes.
    let strokes = match u.int_in_range(0..=3_u8)? {
        0 => two.to_vec(),
        1 => vec![400.0, 350.0],
        2 => vec![400.0, 350.0, two[0]],
        _ => vec![400.0],
    };
    text.push_str(&format!("travel_mm = {strokes:?}\n"));
    Ok(text)
}

fn profile_of(text: &str) {
    let profile = match MachineProfile::parse(Path::new("fuzz"), text) {
        Ok(profile) => profile,
        Err(error) => return told(&error.to_string()),
    };
    let again = MachineProfile::parse(Path::new("fuzz"), &profile.to_toml()).expect("it was written as TOML");
    assert_eq!(again, profile);
    is_used(text, &profile);
    match Budget::of(&profile, None, false) {
        Ok(budget) => adds_up(&profile, &budget, None),
        Err(error) => told(&error.to_string()),
    }
}

/// The terms cover what the machine needs, or are what was ordered; and their sum is the margin.
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

/// Any bytes as one of the small files, which the first chooses: a controller's description, a setup, a script, a trace, drives.
/// A typed error, or what the file says: all of it is in what was read of it, notes and blanks change nothing, what a script or a
/// trace inputs can be recorded and comes back, and a description that is read makes a dialect that hears the rest.
///
/// # Panics
/// When one of these does not hold.
pub fn small_files(bytes: &[u8]) {
    let Some((which, rest)) = bytes.split_first() else { return };
    let path = Path::new("fuzz");
    let Ok(text) = std::str::from_utf8(rest) else {
        // Only traces are read as bytes.
        return told(&Trace::read(rest, path).expect_err("it is no text").to_string());
    };
    match which % 5 {
        0 => match Description::of(text) {
            Ok(description) => hears(description, rest),
            Err(error) => told(&error.to_string()),
        },
        1 => match AlignmentFile::parse(path, text) {
            Ok(setup) => {
                assert!(setup.placed().is_none_or(|(degrees, _)| degrees.is_finite()));
                is_used(text, &setup);
            }
            Err(error) => told(&error.to_string()),
        },
        2 => match Script::parse(text) {
            Ok(script) => {
                let bare = bare(text.lines().map(|line| line.split('#').next().unwrap_or_default()));
                assert_eq!(Script::parse(&bare).expect("it was read before"), script, "{bare}");
                is_recorded(script, rest);
            }
            Err(error) => told(&error.to_string()),
        },
        3 => match Trace::read(rest, path) {
            Ok(trace) => {
                let bare = bare(text.split('\n').filter(|line| !line.trim().starts_with('#')));
                let again = Trace::read(bare.as_bytes(), path).expect("it was read before");
                assert_eq!(again, trace, "{bare}");
                is_recorded(trace, rest);
            }
            Err(error) => told(&error.to_string()),
        },
        _ => match DriveProfile::parse("fuzz", text) {
            Ok(drives) => is_used(text, &drives),
            Err(error) => told(&error.to_string()),
        },
    }
}

/// Lines without what says nothing.
fn bare<'a>(lines: impl Iterator<Item = &'a str>) -> String {
    let words = lines.map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
    words.filter(|line| !line.is_empty()).map(|line| line + "\n").collect()
}

/// All that a file says is in what was read of it.
fn is_used(text: &str, read: &impl Serialize) {
    let said = Value::Table(toml::from_str(text).expect("it was read before"));
    let used = Value::try_from(read).expect("it has a form in TOML");
    assert!(is_in(&said, &used), "{said} was read as {used}");
}

#[expect(clippy::cast_precision_loss, reason = "as it is when an integer is read where a number is expected")]
fn is_in(said: &Value, used: &Value) -> bool {
    match (said, used) {
        (Value::Table(said), Value::Table(used)) => {
            said.iter().all(|(key, value)| used.get(key).is_some_and(|other| is_in(value, other)))
        }
        (Value::Array(said), Value::Array(used)) => {
            said.len() == used.len() && said.iter().zip(used).all(|(value, other)| is_in(value, other))
        }
        (Value::Integer(said), Value::Float(used)) => *said as f64 == *used,
        _ => said == used,
    }
}

/// What an operator inputs is recorded, and input again at the same times by who plays the recording.
fn is_recorded(operator: impl Operator, looks: &[u8]) {
    let seen = OperatorView {
        position_mm: None,
        wall_mm: None,
        part_box_mm: (0.0, 0.0, 100.0, 60.0),
        end_mm: None,
        unacknowledged: 0,
        phase: Phase::Manual,
        contoured: false,
    };
    let mut now = Time::from_micros(77_777);
    let mut later = |look: u64| {
        now = now.after(Duration::from_micros(1 + 300 * look * look));
        now
    };
    let times: Vec<Time> = looks.iter().take(LOOKS).map(|&look| later(look.into())).collect();
    let mut file = Vec::new();
    let mut recorder = Recorder::new(operator, &mut file, Panel::default());
    let inputs: Vec<OperatorInput> = times.iter().map(|&time| recorder.input(&seen, time)).collect();
    drop(recorder);
    let mut again = Trace::read(&file[..], Path::new("recorded")).expect("a recording can be read");
    // Turns add up; what is beyond all numbers is none.
    let finite = |(x, y): (f64, f64)| if x.is_finite() && y.is_finite() { (x, y) } else { (0.0, 0.0) };
    for (time, input) in times.into_iter().zip(inputs) {
        let input =
            OperatorInput { velocity: finite(input.velocity), turned_mm: finite(input.turned_mm), ..input };
        assert_eq!(again.input(&seen, time), input, "at {time:?}");
    }
}

fn hears(description: Description, bytes: &[u8]) {
    let mut dialect = Described::new(Arc::new(description), setting());
    let mut out = Vec::new();
    for command in COMMANDS {
        let _ = dialect.encode(&command, &mut out);
        for &byte in bytes.iter().take(500) {
            let before = out.len();
            let _ = dialect.decode(byte, &mut out);
            assert!(out.len() - before < 3000, "it talks without end");
        }
    }
}

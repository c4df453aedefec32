//! Files that a workshop keeps: plans, logs, profiles and the small ones.

use std::path::Path;
use std::sync::Arc;

use arbitrary::{Arbitrary, Unstructured};
use keepout_executor::link::dialect::{Described, Description, Dialect, Setting};
use keepout_executor::operator::{Script, Trace};
use keepout_executor::servo::profile::DriveProfile;
use keepout_executor::session::log::{Certificate, Entry, Log, LogReadError};
use keepout_executor::session::replay::replay;
use keepout_executor::session::{page_of_log, picture_of_log};
use keepout_kernel::curve::xy;
use keepout_planner::machine::MachineProfile;
use keepout_planner::margin::Budget;
use keepout_planner::plan_file;
use keepout_planner::setup::Setup;

use crate::dialects::setting;
use crate::import::{CURVES_MAX, edges, told};
use crate::sketch::number;
use crate::{job, witness};

/// Any bytes as a plan file, or as what one holds behind its hash: a typed error, or a plan, which certification refuses or
/// believes; what it believes keeps the tool out of the part, by another's eyes.
///
/// # Panics
/// When it believes what does not, or when a plan changes on its way to a file and back.
pub fn plan_file(bytes: &[u8]) {
    let whole = if bytes.starts_with(b"KEEPOUT PLAN") { bytes.to_vec() } else { sealed(bytes) };
    let plan = match plan_file::decode(&whole) {
        Ok(plan) => plan,
        Err(error) => return told(&error.to_string()),
    };
    let stored = plan_file::encode(&plan).expect("a plan in memory can be written");
    let again = plan_file::decode(&stored).expect("what was written can be read");
    assert_eq!(plan_file::encode(&again).expect("as before"), stored, "the plan changed in its file");
    let curves: usize =
        plan.passes.iter().flat_map(|pass| &pass.path.loops).map(|each| each.curves.len()).sum();
    if edges(&plan.profile).max(edges(&plan.zones)).max(curves) > CURVES_MAX {
        return;
    }
    match plan.certify() {
        Ok(certified) => witness::watch(&certified, None),
        Err(error) => told(&error.to_string()),
    }
}

/// The bytes behind the head and the hash of a plan file.
fn sealed(payload: &[u8]) -> Vec<u8> {
    let mut bytes = b"KEEPOUT PLAN".to_vec();
    bytes.extend(plan_file::VERSION.to_le_bytes());
    bytes.extend(plan_file::hash(payload));
    bytes.extend(payload);
    bytes
}

/// Any bytes as a log, and as a log's lines without their checksums, which are added: a typed error with the line, or a session
/// that is played again. What it says was sent is certified, by another's eyes, and no bit of it can be changed unnoticed.
///
/// # Panics
/// When one of these does not hold.
pub fn session_log(bytes: &[u8]) {
    if let Err(error) = Log::parse(bytes) {
        told(&error.to_string());
    }
    let summed = summed(bytes);
    let log = match Log::parse(&summed) {
        Ok(log) => log,
        Err(error) => return told(&error.to_string()),
    };
    is_not_changed_unnoticed(&summed, bytes.len());
    match replay(&log, job::work()) {
        Ok(played) => {
            watch(&log);
            told(&played.end().to_string());
            assert!(picture_of_log(&log.header, &played).starts_with("<svg"));
            assert!(page_of_log(&log.header, &played, "fuzz.log", 0).contains("<html"));
        }
        Err(error) => told(&error.to_string()),
    }
}

/// Lines of a log, each with the checksum over itself and the line before, and `plan=@` made the hash of the plan that
/// [`job::work`] has.
fn summed(lines: &[u8]) -> Vec<u8> {
    let mut sum = 0_u32;
    let mut out = Vec::with_capacity(2 * lines.len());
    for line in lines.split_inclusive(|&byte| byte == b'\n') {
        let Some((_, line)) = line.split_last().filter(|(last, _)| **last == b'\n') else {
            out.extend(line);
            break;
        };
        let line = named(line);
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&sum.to_le_bytes());
        hasher.update(&line);
        sum = hasher.finalize();
        out.extend(&line);
        out.extend(format!("\t{sum:08x}\n").bytes());
    }
    out
}

fn named(line: &[u8]) -> Vec<u8> {
    const PLACE: &[u8] = b" plan=@ ";
    match line.windows(PLACE.len()).position(|window| window == PLACE) {
        Some(at) if line.starts_with(b"keepout-log") => {
            [&line[..at], b" plan=", job::hash().as_bytes(), b" ", &line[at + PLACE.len()..]].concat()
        }
        _ => line.to_vec(),
    }
}

fn is_not_changed_unnoticed(log: &[u8], which: usize) {
    let Some(end) = log.iter().rposition(|&byte| byte == b'\n') else { return };
    let (at, bit) = (which * 7 % end, which % 8);
    let mut changed = log.to_vec();
    changed[at] ^= 1 << bit;
    let error = Log::parse(&changed).expect_err("a bit was changed");
    assert!(!matches!(error, LogReadError::Read { .. }), "{error}");
}

/// Jogs that were certified end clear of the part; those that lead out of it come nearer to nothing, which is looked at elsewhere.
fn watch(log: &Log) {
    let plan = &job::work().plan;
    let mut escapes = false;
    for (_, entry) in &log.entries {
        match entry {
            Entry::Phase(phase) => escapes |= phase.starts_with("Escaping"),
            Entry::Certificate(text) => {
                let Some(Certificate::Jog(to, _)) = Certificate::parse(text) else { continue };
                let left = witness::distance(xy(to), witness::walls(plan));
                let kept = if escapes { plan.plan.tool_radius } else { plan.roughing };
                assert!(left > f64::from(kept.units()) - 3.0, "a jog to {to:?}, {left} from the part");
            }
            _ => {}
        }
    }
}

/// Any bytes as a machine profile, or, behind a zero, as its figures: a typed error, or figures that a machine can have, which come
/// back from a file, and make a margin of their sum.
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
    let mut text = format!("name = \"any\"\nstroke_mm = [{:?}, {:?}]\n", number(u)?, number(u)?);
    let usual = MachineProfile::simulated().to_toml();
    for key in KEYS {
        // Most figures are usual ones, so that it comes to the others.
        let line = usual.lines().find(|line| line.starts_with(key)).unwrap_or_default();
        let any = if bool::arbitrary(u)? { Some(number(u)?) } else { None };
        text.push_str(&any.map_or_else(|| line.to_string(), |any| format!("{key} = {any:?}")));
        text.push('\n');
    }
    Ok(text)
}

fn profile_of(text: &str) {
    let profile = match MachineProfile::parse(Path::new("fuzz"), text) {
        Ok(profile) => profile,
        Err(error) => return told(&error.to_string()),
    };
    let again = MachineProfile::parse(Path::new("fuzz"), &profile.to_toml()).expect("it was written as TOML");
    assert_eq!(again, profile);
    match Budget::of(&profile, None, false) {
        Ok(budget) => adds_up(&profile, &budget, None),
        Err(error) => told(&error.to_string()),
    }
}

/// The terms cover what the machine needs, or are what was ordered; and their sum is the margin.
pub(crate) fn adds_up(profile: &MachineProfile, budget: &Budget, ordered_mm: Option<f64>) {
    let sum: f64 = budget.terms.iter().map(|term| term.mm).sum();
    let least = ordered_mm.unwrap_or_else(|| witness::least_margin_mm(profile)) - 1e-9;
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
/// A typed error, or what is read; a description that is read makes a dialect that hears the rest.
///
/// # Panics
/// When the dialect talks without end.
pub fn small_files(bytes: &[u8]) {
    let Some((which, rest)) = bytes.split_first() else { return };
    let path = Path::new("fuzz");
    if which % 5 == 3 {
        if let Err(error) = Trace::read(rest, path) {
            told(&error.to_string());
        }
        return;
    }
    let Ok(text) = std::str::from_utf8(rest) else { return };
    match which % 5 {
        0 => match Description::of(text) {
            Ok(description) => hears(description, rest),
            Err(error) => told(&error.to_string()),
        },
        1 => match Setup::parse(path, text) {
            Ok(setup) => assert!(setup.placed().is_none_or(|(degrees, _)| degrees.is_finite())),
            Err(error) => told(&error.to_string()),
        },
        2 => {
            if let Err(error) = Script::parse(text) {
                told(&error.to_string());
            }
        }
        _ => {
            if let Err(error) = DriveProfile::parse("fuzz", text) {
                told(&error.to_string());
            }
        }
    }
}

fn hears(description: Description, bytes: &[u8]) {
    let setting: Setting = setting();
    let mut dialect = Described::new(Arc::new(description), setting);
    let mut out = Vec::new();
    for command in crate::dialects::COMMANDS {
        let _ = dialect.encode(&command, &mut out);
        for &byte in bytes.iter().take(500) {
            let before = out.len();
            let _ = dialect.decode(byte, &mut out);
            assert!(out.len() - before < 3000, "it talks without end");
        }
    }
}

//! Plan files and session logs.

use keepout_executor::session::log::{Log, LogReadError};
use keepout_executor::session::replay::replay;
use keepout_executor::session::{Certificate, LoggedEvent, page_of_log, picture_of_log};
use keepout_executor::supervisor::Phase;
use keepout_kernel::Curve;
use keepout_planner::{plan_file, sha256};
use keepout_proofs::properties::Xy;
use keepout_proofs::square::plain;

use crate::import::{CURVES_MAX, check_message, edges};
use crate::session::watch::{ROUNDING, comes_near, ends_of_edges, keep_away, triangles};
use crate::{job, oracle};

/// Reads any bytes as a plan file, or as its content after the hash. The result is a typed error or a plan.
/// Certification refuses the plan or accepts it. An accepted plan keeps the tool out of the part by an
/// independent check, and its texts can be printed.
///
/// # Panics
/// When certification accepts a plan that is wrong, or when a plan changes on its way to a file and back.
pub fn plan_file(bytes: &[u8]) {
    let _ = is_certified_plan(bytes);
}

/// Runs [`plan_file()`]. Returns whether the plan was read and certified.
///
/// # Panics
/// As [`plan_file()`].
#[must_use]
pub fn is_certified_plan(bytes: &[u8]) -> bool {
    let no_plan = |message: &str| {
        check_message(message);
        false
    };
    let whole = if bytes.starts_with(b"KEEPOUT PLAN") { bytes.to_vec() } else { sealed(bytes) };
    let plan = match plan_file::decode(&whole) {
        Ok(plan) => plan,
        Err(error) => return no_plan(&error.to_string()),
    };
    let stored = plan_file::encode(&plan).expect("a plan in memory can be written");
    let again = plan_file::decode(&stored).expect("what was written can be read");
    assert_eq!(plan_file::encode(&again).expect("as before"), stored, "the plan changed in its file");
    let curves: usize =
        plan.passes.iter().flat_map(|pass| &pass.path.loops).map(|each| each.curves.len()).sum();
    if edges(&plan.profile).max(edges(&plan.zones)).max(curves) > CURVES_MAX {
        return false;
    }
    let certified = match plan.certify() {
        Ok(certified) => certified,
        Err(error) => return no_plan(&error.to_string()),
    };
    let plan = &certified.plan;
    let terms = plan.budget.terms.iter().map(|term| &term.source);
    let texts = terms.chain([&plan.provenance.name, &plan.provenance.unit, &plan.machine.name]);
    let lines: Vec<&String> = texts.filter(|text| text.contains(char::is_control)).collect();
    assert!(lines.is_empty(), "pages print these texts, and they hold control characters: {lines:?}");
    oracle::watch(&certified, None);
    true
}

/// A plan file with these bytes after the head and the hash.
fn sealed(payload: &[u8]) -> Vec<u8> {
    let mut bytes = b"KEEPOUT PLAN".to_vec();
    bytes.extend(plan_file::VERSION.to_le_bytes());
    bytes.extend(sha256::hash(payload));
    bytes.extend(payload);
    bytes
}

/// Reads any bytes as a log, and as a log's lines without their checksums, which the target adds. The
/// result is a typed error with the line, or a session that replays. An independent check confirms every
/// logged certificate, and no bit of the log can change unnoticed.
///
/// # Panics
/// When one of these does not hold.
pub fn session_log(bytes: &[u8]) {
    let _ = certificates_of_log(bytes);
}

/// The check of [`session_log`]. Returns the number of certificates of a log that replays.
///
/// # Panics
/// As [`session_log`].
#[must_use]
pub fn certificates_of_log(bytes: &[u8]) -> usize {
    if let Err(error) = Log::parse(bytes) {
        check_message(&error.to_string());
    }
    let summed = summed(bytes);
    let log = match Log::parse(&summed) {
        Ok(log) => log,
        Err(error) => {
            check_message(&error.to_string());
            return 0;
        }
    };
    is_not_changed_unnoticed(&summed, bytes.len());
    match replay(&log, job::work()) {
        Ok(played) => {
            check_message(&played.outcome().to_string());
            assert!(picture_of_log(&log.header, &played).starts_with("<svg"));
            assert!(page_of_log(&log.header, &played, &[], "fuzz.log", 0).contains("<html"));
            watch(&log)
        }
        Err(error) => {
            check_message(&error.to_string());
            0
        }
    }
}

/// Lines of a log without their checksums. Each gets the checksum over itself and the line before, and the
/// plan `@` becomes the hash of the plan of [`job::work`].
fn summed(lines: &[u8]) -> Vec<u8> {
    let mut sum = 0_u32;
    let mut out = Vec::with_capacity(2 * lines.len());
    for line in lines.split_inclusive(|&byte| byte == b'\n') {
        let whole = line.strip_suffix(b"\n").and_then(|line| line.strip_prefix(b"{"));
        let Some(rest) = whole else {
            out.extend(line);
            break;
        };
        let rest = named(rest);
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&sum.to_le_bytes());
        hasher.update(&rest);
        sum = hasher.finalize();
        out.extend(format!("{{\"crc\":\"{sum:08x}\",").bytes());
        out.extend(&rest);
        out.push(b'\n');
    }
    out
}

fn named(line: &[u8]) -> Vec<u8> {
    const PLACE: &[u8] = b"\"plan\":\"@\"";
    match line.windows(PLACE.len()).position(|window| window == PLACE) {
        Some(at) if line.starts_with(b"\"keepout_log\"") => {
            let plan = format!("\"plan\":\"{}\"", job::hash());
            [&line[..at], plan.as_bytes(), &line[at + PLACE.len()..]].concat()
        }
        _ => line.to_vec(),
    }
}

/// Changes a bit of the log, and then one of the last digit of a line's checksum.
fn is_not_changed_unnoticed(log: &[u8], which: usize) {
    const LAST_DIGIT: usize = "{\"crc\":\"".len() + 7;
    let Some(end) = log.iter().rposition(|&byte| byte == b'\n') else { return };
    let at = which * 7 % end;
    let line = log[..at].iter().rposition(|&byte| byte == b'\n').map_or(0, |newline| newline + 1);
    for (at, bit) in [(at, which % 8), (line + LAST_DIGIT, 0)] {
        let mut changed = log.to_vec();
        changed[at] ^= 1 << bit;
        let error = Log::parse(&changed).expect_err("a bit was changed");
        assert!(!matches!(error, LogReadError::File(_)), "{error}");
    }
}

/// Checks that every certified motion is clear of the part: the whole in-flight set with a jog, and each
/// motion of a contour. Retract moves stay out of the part. Another target checks that they come nearer to
/// no edge. Returns the number of certificates.
fn watch(log: &Log) -> usize {
    let plan = &job::work().plan;
    let walls = ends_of_edges(&plan.part);
    let curves: Vec<Curve> = oracle::walls(plan).copied().collect();
    let retracts_now = |event: &LoggedEvent<'_>| match event {
        LoggedEvent::Phase { phase, .. } => Some(*phase == Phase::Retracting),
        _ => None,
    };
    // A motion belongs to the last logged phase, or to the next.
    let (mut last, mut count) = (false, 0);
    for (at, entry) in log.entries.iter().enumerate() {
        let mut next = log.entries[at..].iter().filter_map(|entry| retracts_now(&entry.event));
        let retracts = last || next.next() == Some(true);
        last = retracts_now(&entry.event).unwrap_or(last);
        let LoggedEvent::Certificate(certificate) = &entry.event else { continue };
        count += 1;
        match certificate {
            Certificate::Jog { to, set, .. } => {
                let kept = if retracts { plan.plan.tool_radius } else { plan.roughing };
                let kept = i64::from(kept.units()) - 3;
                let set: Vec<Xy> = set.iter().chain([to]).map(|&point| plain(point)).collect();
                let set = if retracts { &set[set.len() - 1..] } else { &set };
                let near = triangles(set)
                    .find(|corners| walls.iter().any(|&(d, e)| comes_near(*corners, d, e, kept)));
                assert!(near.is_none(), "a jog to {to:?}: {near:?} comes nearer than {kept}");
            }
            Certificate::Contour { curve, .. } => {
                let kept = f64::from(plan.finishing.units()) - ROUNDING;
                keep_away(curve, &oracle::places(curve), kept, &curves);
            }
        }
    }
    count
}
